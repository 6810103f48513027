"""The numbers of compiled equations by name: one record for a ball, a contact, a wave, ..., each with units and meanings."""

from __future__ import annotations

import numpy as np

from autobalancer.kernels.fields import Field, Record

# What the fluid around a ball does: drag curves, lag, slipstream; and tables over time.


NONE = -1  # in place of the number of a table or a line: there is none

TABLE = Record(
    Field("start", "of its axis", "where the grid begins"),
    Field("step", "of its axis", "between two points of the grid"),
    Field("count", "", "how many points", kind=np.int64),
    Field("first", "", "number of its first point", kind=np.int64),
)
"""A curve over a uniform grid, cubic between its points. A drag curve is log force over log velocity."""

POINT = Record(
    Field("value", "of the table", "the value there"),
    Field("slope", "of the table", "its change per step of the grid"),
)
"""A point of a table."""

RELAXATION = Record(
    Field("state", "", "its place in the state vector", kind=np.int64),
    Field("rate", "1/s", "how fast it dies out"),
    Field("gain", "1", "what the rotor's acceleration adds to it"),
)
"""A relaxation mode of the fluid in a race: c' = gain w' - rate c, and the fluid lags by the sum of all c."""

LINE = Record(
    Field("ball", "", "its number", kind=np.int64),
    Field("first", "", "place of the first number of the others", kind=np.int64),
    Field("others", "", "how many others there are", kind=np.int64),
    Field("per_speed", "s/m", "Reynolds number over speed"),
    Field("greatest", "1", "the greatest Reynolds number of the fit"),
    Field("per_angle", "1/rad", "distance in diameters over angle"),
    Field("reach", "1", "the greatest distance of the fit, in diameters"),
)
"""A ball and the others of its race, of which the one ahead lessens its drag."""

IN_FLUID = (
    Field("drag_curve", "", "number of the table of its drag; NONE: linear", kind=np.int64),
    Field("slipstream", "", "number of its line; NONE: no slipstream", kind=np.int64),
    Field("lag_table", "", "number of the table of the fluid's lag; NONE: none", kind=np.int64),
    Field("modes", "", "how many relaxation modes its fluid has", kind=np.int64),
    Field("first_mode", "", "number of the first of them", kind=np.int64),
)
"""What any ball knows of its fluid: where its tables, its line and its modes are."""


# Forces on balls that are leaves: where a ball is, as such a force sees it, and which force acts on which ball.


PLACE = Record(
    Field("x", "m", "ball center from the center of its race, in axes that turn with the rotor"),
    Field("y", "m", "the same"),
    Field("vx", "m/s", "its velocity as seen from the rotor, in the same axes"),
    Field("vy", "m/s", "the same"),
    Field("ahead", "rad", "angle by which it is ahead of the other ball of a pair, around the race; below 0: behind"),
    Field("speed", "rad/s", "of the rotor"),
    Field("mass", "kg", "effective mass, less the fluid it displaces"),
    Field("radius", "m", "of the ball; 0 if not given"),
    Field("orbit", "m", "orbit radius"),
    Field("gravity", "m/s^2", "acceleration of gravity along the axis; 0 on a horizontal one"),
)
"""Where a ball is. No time and no angle of the rotor, so that steady states exist in the axes of the rotor."""

FORCE = Record(
    Field("address", "", "of its compiled function", kind=np.int64),
    Field("energy", "", "address of its compiled energy; 0: it has none", kind=np.int64),
    Field("first", "", "place of the first of its own numbers", kind=np.int64),
    Field("ball", "", "number of the ball", kind=np.int64),
    Field("other", "", "number of the other ball of a pair; NONE: it acts on one ball", kind=np.int64),
    Field("wrap", "rad", "what to add to the angle of the other ball, so that it is ahead"),
    Field("wrong", "", "whether it ever was not a number where the place was one", kind=np.int64),
    Field("wrong_x", "m", "the last place of the ball where that was so"),
    Field("wrong_y", "m", "the same"),
    Field("wrong_vx", "m/s", "the velocity there"),
    Field("wrong_vy", "m/s", "the same"),
    Field("wrong_speed", "rad/s", "the speed of the rotor there"),
)
"""One force on one ball, or between two; ``wrong`` and what follows are written by the equations."""


# Slip of a ball on a wall, as a friction law sees it.


SLIP = Record(
    Field(
        "slip", "m/s", "velocity with which the ball slides on the wall, of either sign; of a guided one along its race"
    ),
    Field("pressed", "N", "force of the wall; of a guided ball not a number"),
    Field("sliding", "1", "coefficient of friction, the key `sliding_friction`; of a guided ball `rolling_resistance`"),
    Field("slip_speed", "m/s", "the key `slip_speed`; of a guided ball far below any slip"),
    Field("radius", "m", "of the ball"),
    Field("wrong", "", "whether the law ever was not a number where the slip was one", kind=np.int64),
    Field("wrong_slip", "m/s", "the last slip where that was so"),
    Field("wrong_pressed", "N", "the force of the wall there"),
)
"""What a friction law knows of a contact: no time and no place; ``wrong`` and what follows are written by the equations."""


# A ball that is guided on the path of its race.


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
    Field("friction", "", "address of the law of its rolling resistance; 0: it has none", kind=np.int64),
    Field("first_number", "", "place of the first of the own numbers of this law", kind=np.int64),
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
    Field("rebound", "", "where the table of the damping ratio begins, a factor of soft; NONE: none", kind=np.int64),
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
    Field("joined", "", "1: it moves with the next ball, which it touches, 2: in the last gap", kind=np.int64),
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


# A ball that is free in the plane of its race, and its part of the state vector.
#
# Behind the state of kernels/system.py each ball has
#
#     x, y        position of its center from the center of the race     m        in the rotor
#     vx, vy      velocity as seen from the rotor                        m/s      in the rotor
#     spin        as seen from the rotor                                 rad/s
#     hold        deflection of the spring of adherence                  m
#     tumble      horizontal part of the spin, about x and y, in space   rad/s    in the rotor
#
# and then come the relaxation modes of the fluids. The ball angles and speeds among the first states follow from x and
# y; they are carried along for whoever reads these.


BALL_X, BALL_Y, BALL_VX, BALL_VY, BALL_SPIN, HOLD, TUMBLE_X, TUMBLE_Y, BALL_STATES = range(9)

FREE_BALL = Record(
    Field("station", "", "number of its balancer", kind=np.int64),
    Field("race", "", "number of its race; -1 where balls pass through each other", kind=np.int64),
    Field("hertz", "", "whether contacts are those of Hertz, else linear", kind=np.int64),
    Field("mass", "kg", "effective mass, less the fluid it displaces"),
    Field("extra", "kg", "by which its inertia in motion relative to the chamber exceeds the effective mass"),
    Field("spin_inertia", "kg m^2", "inertia of its spin"),
    Field("radius", "m", "its radius"),
    Field("orbit", "m", "orbit radius on the outer wall"),
    Field("center_x", "m", "center of its race in the rotor"),
    Field("center_y", "m", "center of its race in the rotor"),
    Field("gap", "m", "from inner to outer wall for the ball center; infinite without inner wall"),
    Field("wall_stiffness", "N/m or N/m^1.5", "of the outer wall"),
    Field("wall_damping", "N s/m or N s/m^1.25", "of the outer wall"),
    Field("inner_stiffness", "N/m or N/m^1.5", "of the inner wall"),
    Field("inner_damping", "N s/m or N s/m^1.25", "of the inner wall"),
    Field("rebound", "", "where the table of the damping ratio of both walls begins; NONE: none", kind=np.int64),
    Field("ball_stiffness", "N/m or N/m^2", "between balls; with Hertz for a pair whose radii reduce to 1 m"),
    Field("ball_damping", "1 or 1/m^0.25", "between balls, per square root of stiffness times mass"),
    Field("friction", "", "address of the friction law of the walls", kind=np.int64),
    Field("first_number", "", "place of the first of the own numbers of this law", kind=np.int64),
    Field("sliding", "1", "friction of the walls"),
    Field("slip_speed", "m/s", "slip at which friction sets in"),
    Field("rolling_arm", "m", "arm of the wall force in rolling"),
    Field("rest_speed", "m/s", "below which a ball counts as at rest"),
    Field("adherence", "1", "greatest force that holds it at rest, over the normal force"),
    Field("hold_stiffness", "N/m", "of the spring of adherence"),
    Field("hold_damping", "N s/m", "of the spring of adherence"),
    Field("floor", "1", "friction of the floor"),
    Field("floor_arm", "m", "its radius where it rolls on the floor, 0 where it slides"),
    Field("weight", "N", "on the floor"),
    Field("ball_sliding", "1", "friction between balls"),
    Field("viscous", "N s/m", "drag force over velocity, where drag is linear"),
    Field("waves", "", "how many harmonics its orbit has", kind=np.int64),
    Field("first_wave", "", "number of the first of them", kind=np.int64),
    Field("partition", "", "number of its partitions; NONE: none", kind=np.int64),
    *IN_FLUID,
)
"""What a resolved ball and its walls are."""

PARTITION = Record(
    Field("middle", "rad", "angle between them"),
    Field("behind_x", "1", "normal of the one behind"),
    Field("behind_y", "1", "normal of the one behind"),
    Field("ahead_x", "1", "normal of the one ahead"),
    Field("ahead_y", "1", "normal of the one ahead"),
    Field("stiffness", "N/m or N/m^1.5", "of both"),
    Field("damping", "N s/m or N s/m^1.25", "of both"),
    Field("rebound", "", "where the table of the damping ratio begins; NONE: there is none", kind=np.int64),
)
"""The partitions between which a resolved ball runs; normals point towards the ball."""

FREE = Record(
    Field("force_x", "N", "all forces but its weight"),
    Field("force_y", "N", "all forces but its weight"),
    Field("torque", "N m", "on its spin"),
    Field("hold_rate", "m/s", "of the spring of adherence"),
    Field("tumble_x", "N m", "on the horizontal part of its spin"),
    Field("tumble_y", "N m", "on the horizontal part of its spin"),
)
"""What acts on a resolved ball, as found by the last evaluation; in the rotor."""


# Contacts that can begin, and those that did.


# of a guided ball the first three, of a resolved one the others
NEXT, BEHIND, AHEAD, WALL, INNER, SIDES, OTHER_BALL = range(7)

TOUCH = Record(
    Field("kind", "", "NEXT: with the next ball, BEHIND, AHEAD, SIDES: a partition, WALL, INNER, BALL", kind=np.int64),
    Field("one", "", "number of the ball", kind=np.int64),
    Field("other", "", "number of the other ball, -1 without one", kind=np.int64),
    Field("known", "", "1 while they touch, 0 while they do not, -1 before the first look", kind=np.int64),
    Field("approach", "m/s", "speed at which they approached at the last look without contact"),
)
"""A ball and what it can hit."""

IMPACT = Record(
    Field("time", "s", "when it began"),
    Field("speed", "m/s", "at which the bodies approached"),
    Field("touch", "", "number of the contact", kind=np.int64),
)
"""A contact that began."""

MEETING = Record(
    Field("mass", "kg", "reduced mass"),
    Field("restitution", "1", "what an impact leaves of the speed, where that depends on nothing"),
    Field("law", "", "where its law begins, see laws/contact_law.py; NONE: it is constant", kind=np.int64),
    Field("least", "1", "what counts for less; 0 of rigid contacts"),
)
"""What an impact means in a contact."""


# What drives the rotor and what shakes it, over time.


PRESCRIBED, TORQUE = 0, 1  # kinds of drive
LINEAR, HILL = 0, 1  # kinds of a segment
HARMONIC, RECORDED = 0, 1  # kinds of an excitation

SEGMENT = Record(
    Field("start", "s", "its begin"),
    Field("kind", "", "LINEAR or HILL", kind=np.int64),
    Field("value", "rad/s or N m", "LINEAR: speed, or torque of the drive, at its begin"),
    Field("rate", "rad/s^2 or N m/s", "LINEAR: what it gains per time"),
    Field("end", "rad/s or N m", "HILL: where the S-shaped rise ends"),
    Field("half_time", "s", "HILL: time of half the rise"),
    Field("exponent", "1", "HILL: how steep the rise is"),
    Field("begin", "rad/s or N m", "HILL: where the rise begins"),
    Field("unbalance_x", "kg m", "resultant unbalance in the rotor, at its begin"),
    Field("unbalance_y", "kg m", "resultant unbalance in the rotor, at its begin"),
    Field("unbalance_rate_x", "kg m/s", "what it gains per time"),
    Field("unbalance_rate_y", "kg m/s", "what it gains per time"),
    Field("changing", "", "whether the loads of any unbalance change in it", kind=np.int64),
)
"""A stretch of time over which drive and unbalance keep their course."""

SHAKE = Record(
    Field("kind", "", "HARMONIC or RECORDED", kind=np.int64),
    Field("felt", "", "whether balls feel it: motion of the base", kind=np.int64),
    Field("x_real", "m/s^2 or N", "HARMONIC: amplitude along x, real part of e^(i w t)"),
    Field("x_imaginary", "m/s^2 or N", "HARMONIC: imaginary part"),
    Field("y_real", "m/s^2 or N", "HARMONIC: amplitude along y, real part"),
    Field("y_imaginary", "m/s^2 or N", "HARMONIC: imaginary part"),
    Field("frequency", "rad/s or 1", "HARMONIC: frequency, or how often per turn"),
    Field("by_angle", "", "whether the frequency counts in turns of the rotor", kind=np.int64),
    Field("table_x", "", "RECORDED: number of the table along x", kind=np.int64),
    Field("table_y", "", "RECORDED: number of the table along y", kind=np.int64),
)
"""One excitation from outside; its two rows of ``vectors`` are accelerations of the coordinates per unit along x and y."""

COUPLING, MOUNT = 0, 1  # kinds of a link

LINK = Record(
    Field(
        "kind", "", "COUPLING, from the rotor to the motor, or MOUNT of the motor's stator, the last one", kind=np.int64
    ),
    Field("state", "", "place of its twist in the state; its speed comes next", kind=np.int64),
    Field("inertia", "kg m^2", "of what turns on the motor's side, or of the stator; 0: its speed is prescribed"),
    Field("stiffness", "N m/rad", "torque over twist"),
    Field("damping", "N m s/rad", "torque over speed of the twist"),
    Field("error", "rad", "amplitude of the twist without a torque"),
    Field("order", "1", "cycles of it per turn of the rotor's side"),
    Field("phase", "rad", "of it"),
)
"""An elastic piece of the drive train. The twist of a coupling is the angle of its motor's side less that of its rotor's side."""

RIPPLE = Record(
    Field("torque", "N m", "amplitude"),
    Field("order", "1", "cycles per turn of the motor against its stator"),
    Field("phase", "rad", "at angle zero"),
)
"""A torque of the motor that changes as it turns."""


# Bearings that become stiffer as they deflect.


HARDENING = Record(
    Field("cubic", "N/m^3", "force over the third power of the distance"),
    Field("contact", "N/m", "stiffness of the stop"),
    Field("clearance", "m", "distance at which it begins"),
    Field("center_x", "m", "middle of the bearing from where the rotor rests"),
    Field("center_y", "m", "the same"),
    Field("first", "", "where the pieces of its table begin", kind=np.int64),
    Field("pieces", "", "how many there are; 0: it has none", kind=np.int64),
    Field("rest_x", "N", "force of the bearing there, which is part of the rest"),
    Field("rest_y", "N", "the same"),
)
"""A central force between a place of the rotor and the ground."""


# Rubber whose elements slide and relax.


ELASTOPLASTIC, ENDOCHRONIC, MAXWELL = range(3)

RUBBER_MOUNT = Record(
    Field("first", "", "number of its first element", kind=np.int64),
    Field("elements", "", "how many there are", kind=np.int64),
)
"""A piece of rubber that two rows of coordinates stretch."""

ELEMENT = Record(
    Field("law", "", "how it gives way: ELASTOPLASTIC, ENDOCHRONIC or MAXWELL", kind=np.int64),
    Field("state", "", "place of the first of its two forces in the state vector", kind=np.int64),
    Field("stiffness", "N/m", "of its spring"),
    Field("give", "1/(J/s), 1/m, 1/s", "how fast its force falls: stiffness over F^2, stiffness over F, 1 over tau"),
)
"""A spring that slides at a force F, or relaxes in a time tau: f' = stiffness z' - give (<f.z'>, |z'| or 1) f."""
