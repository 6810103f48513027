"""A ball that is free in the plane of its race, and its part of the state vector.

Behind the state of kernels/system.py each ball has

    x, y        position of its center from the center of the race     m        in the rotor
    vx, vy      velocity as seen from the rotor                        m/s      in the rotor
    spin        as seen from the rotor                                 rad/s
    hold        deflection of the spring of adherence                  m
    tumble      horizontal part of the spin, about x and y, in space   rad/s    in the rotor

and then come the relaxation modes of the fluids. The ball angles and speeds among the first states follow from x and y;
they are carried along for whoever reads these.
"""

from __future__ import annotations

import numpy as np

from autobalancer.kernels.fields import Field, Record
from autobalancer.kernels.records.fluid import IN_FLUID

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
    Field(
        "rebound",
        "",
        "where the table of the damping ratio of the walls begins, for both dampings; NONE: none",
        kind=np.int64,
    ),
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
