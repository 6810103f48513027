"""Forces on balls that are leaves: where a ball is, as such a force sees it, and which force acts on which ball."""

from __future__ import annotations

import numpy as np

from autobalancer.kernels.fields import Field, Record

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
