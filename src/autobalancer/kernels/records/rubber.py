"""Rubber whose elements slide and relax."""

from __future__ import annotations

import numpy as np

from autobalancer.kernels.fields import Field, Record

ELASTOPLASTIC, ENDOCHRONIC, MAXWELL = range(3)

MOUNT = Record(
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
