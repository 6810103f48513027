"""Contacts that can begin, and those that did."""

from __future__ import annotations

import numpy as np

from autobalancer.kernels.fields import Field, Record

NEXT, BEHIND, AHEAD, WALL, INNER, SIDES, BALL = range(
    7
)  # of a guided ball the first three, of a resolved one the others

TOUCH = Record(
    Field(
        "kind", "", "NEXT: with the next ball, BEHIND, AHEAD, SIDES: with a partition, WALL, INNER, BALL", kind=np.int64
    ),
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
