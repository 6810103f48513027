"""A ball that is guided on the path of its race."""

from __future__ import annotations

import numpy as np

from autobalancer.kernels.fields import Field, Record
from autobalancer.kernels.records.fluid import IN_FLUID

BALL = Record(
    Field("station", "", "number of its balancer", kind=np.int64),
    Field("mass", "kg", "effective mass, less the fluid it displaces"),
    Field("moment", "kg m", "effective mass times orbit radius"),
    Field("inertia", "kg m^2", "inertia of its angle: mass, virtual mass, own rotation"),
    Field("stretch", "kg", "inertia of its angle over the square of the path per angle"),
    Field("spin", "kg m^2", "coupling with the rotor angle on a circle around the axis: m eps^2 - j m a eps"),
    Field("roll", "kg m", "j m a with its own mass; a: radius on which it rolls, of a pendulum -eps"),
    Field("own_spin", "kg m^2", "j m a^2, inertia about its own center"),
    Field("drag", "N m s", "drag torque over its speed in the rotor"),
    Field("viscous", "N s/m", "drag force over velocity, where drag is linear"),
    Field("orbit", "m", "orbit radius"),
    Field("center_x", "m", "center of its race in the rotor"),
    Field("center_y", "m", "center of its race in the rotor"),
    Field("rolling", "1", "rolling resistance"),
    Field("adherence", "1", "greatest force that holds it at rest, over the normal force"),
    Field("pulls", "1", "1: what guides it also pulls, as the bearing of a pendulum; 0: it only presses"),
    Field("waves", "", "how many harmonics its path has", kind=np.int64),
    Field("first_wave", "", "number of the first of them", kind=np.int64),
    *IN_FLUID,
)
"""What a guided ball is. The path is a circle, or has waves."""

WAVE = Record(
    Field("cosine", "m", "times the cosine of so many times the angle"),
    Field("sine", "m", "times the sine"),
)
"""One harmonic of the radius of a path: cosine and sine amplitude."""

CONTACT = Record(
    Field("next", "", "number of the next ball of its race", kind=np.int64),
    Field("wrap", "rad", "what to add to the angle of the next ball, so that it is ahead"),
    Field("touch", "rad", "angle between them when they touch"),
    Field("hard", "N m/rad", "stiffness of their contact; 0: they never touch"),
    Field("soft", "N m s/rad", "its damping"),
    Field("wall_low", "rad", "angle at the partition behind"),
    Field("wall_high", "rad", "angle at the partition ahead"),
    Field("wall_hard", "N m/rad", "stiffness of partitions; 0: there are none"),
    Field("wall_soft", "N m s/rad", "their damping"),
    Field(
        "rebound",
        "",
        "where the table of the damping ratio begins, by which soft is multiplied; NONE: soft is all",
        kind=np.int64,
    ),
    Field("wall_rebound", "", "the same of partitions", kind=np.int64),
    Field("pace", "m", "speed at which the balls approach over the rate of the angle between them"),
    Field("wall_pace", "m", "the same of a partition"),
    Field("quick", "rad/s", "frequency of the contact of the balls"),
    Field("wall_quick", "rad/s", "that of the contact with a partition"),
    Field("rub", "1", "friction between the balls"),
    Field("grip", "s/rad", "sharpness of its onset"),
    Field("arm", "1", "arm of friction, over that of the contact"),
    Field("arm_next", "1", "that of the next ball"),
    Field("out", "1/m", "what the contact presses this ball on the wall"),
    Field("out_next", "1/m", "what it presses the next one on the wall"),
    Field("before", "", "number of the ball before it in its race", kind=np.int64),
    Field("rigid", "", "1: the contact with the next ball is rigid, 2: and the balls fill their race", kind=np.int64),
    Field("wall_rigid", "", "1: partitions are rigid", kind=np.int64),
    Field("left", "1", "restitution of a rigid contact; with a table ``rebound`` has it over the speed"),
    Field("wall_left", "1", "that of a rigid partition"),
)
"""A ball with the next of its race and with the partitions beside it; friction after laws/impacts.py."""

GUIDED = Record(
    Field("mode", "1", "+1 or -1: rolling that way; 0: at rest on the race"),
    Field("contact", "N m", "torque of what it touches"),
    Field("outward", "N", "what this presses it on the wall"),
    Field("push", "rad/s^2", "of its row"),
    Field("twist", "1", "of its row"),
    Field("lean_x", "1/m", "of its row"),
    Field("lean_y", "1/m", "of its row"),
    Field("lean_u", "1", "of its row"),
    Field("lean_v", "1", "of its row"),
    Field("held_push", "N m", "of the torque that would hold it at rest"),
    Field("held_twist", "kg m^2", "of the same"),
    Field("held_lean_x", "kg m", "of the same"),
    Field("held_lean_y", "kg m", "of the same"),
    Field("held_lean_u", "kg m^2", "of the same"),
    Field("held_lean_v", "kg m^2", "of the same"),
    Field("normal_push", "N", "of the normal force"),
    Field("normal_twist", "kg m", "of the same"),
    Field("normal_x", "kg", "of the same"),
    Field("normal_y", "kg", "of the same"),
    Field("normal_u", "kg m", "of the same"),
    Field("normal_v", "kg m", "of the same"),
    Field("need", "N m", "torque that holds it at rest"),
    Field("normal", "N", "normal force of the race"),
    Field("bound", "", "1: rigid contacts hold it, so its row belongs to a cluster", kind=np.int64),
    Field("given", "N m", "torque from outside, in the search for what an impact does"),
    Field("given_out", "N", "force onto the wall from outside, in the same"),
)
"""What a guided ball does, as found by the last evaluation; ``mode``, ``bound`` and what is given last. Its row is
phi'' = push - lean.A - twist w', with A the acceleration of its station (u, v: of its slope)."""

TIE = Record(
    Field(
        "joined", "", "1: it touches the next ball and moves with it, 2: in the last gap of a full race", kind=np.int64
    ),
    Field("low", "", "1: it touches the partition behind", kind=np.int64),
    Field("high", "", "1: it touches the partition ahead", kind=np.int64),
    Field("follows", "", "1: the ball before is joined with it", kind=np.int64),
    Field("push", "N m", "of its row with friction: I phi'' = push - spin w' - (x, y, u, v).A"),
    Field("spin", "kg m^2", "of the same"),
    Field("x", "kg m", "of the same"),
    Field("y", "kg m", "of the same"),
    Field("u", "kg m^2", "of the same"),
    Field("v", "kg m^2", "of the same"),
    Field("inertia", "kg m^2", "I of the same"),
    Field("arm", "m", "of rolling resistance"),
    Field("back", "1", "torque against this ball over that of the contact with the next one"),
    Field("ahead", "1", "torque on the next ball over the same"),
    Field("rest", "N m", "what the contacts must add to this ball, negative"),
    Field("press", "N m", "torque of the contact with the next ball; never negative"),
    Field("press_low", "N m", "torque of the partition behind"),
    Field("press_high", "N m", "torque of the partition ahead"),
    Field("least", "N m", "at rest: least torque that this ball may pass on to the next one"),
    Field("most", "N m", "at rest: greatest torque that it may pass on"),
)
"""What rigid contacts do at a guided ball; the first four last."""
