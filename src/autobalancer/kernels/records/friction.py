"""Slip of a ball on a wall, as a friction law sees it."""

from __future__ import annotations

import numpy as np

from autobalancer.kernels.fields import Field, Record

SLIP = Record(
    Field("slip", "m/s", "velocity with which the ball slides on the wall, of either sign"),
    Field("pressed", "N", "force of the wall"),
    Field("sliding", "1", "coefficient of friction, the key `sliding_friction`"),
    Field("slip_speed", "m/s", "the key `slip_speed`"),
    Field("radius", "m", "of the ball"),
    Field("wrong", "", "whether the law ever was not a number where the slip was one", kind=np.int64),
    Field("wrong_slip", "m/s", "the last slip where that was so"),
    Field("wrong_pressed", "N", "the force of the wall there"),
)
"""What a friction law knows of a contact: no time and no place; ``wrong`` and what follows are written by the equations."""
