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

MEETING = Record(
    Field("mass", "kg", "reduced mass"),
    Field("restitution", "1", "what an impact leaves of the speed, of slow ones where that falls with the speed"),
    Field("yield_speed", "m/s", "above which it falls as a power; infinite: it does not"),
    Field("exponent", "1", "of that power"),
    Field("first", "", "number of the first of the measured points", kind=np.int64),
    Field("points", "", "how many there are; 0: it was not measured", kind=np.int64),
    Field("slowest", "m/s", "no slower impact rebounds, because of the fluid; 0 without one"),
    Field("least", "1", "what counts for less; 0 of rigid contacts"),
    Field("falls", "", "whether it depends on the speed at all", kind=np.int64),
)
"""What an impact means in a contact."""
