"""Quantities whose passage through a level is an event, as components of the state."""

from __future__ import annotations

import math
from typing import Any

from autobalancer.kernels.flags import PART, njit
from autobalancer.kernels.integrators.dense import component
from autobalancer.kernels.pointers import behind

SUM, LENGTH, GREATEST = range(3)  # kinds of quantity


@njit(**PART)
def quantity(kind: int, first: int, second: int, x: float, pair: Any) -> float:
    """A quantity at the fraction x of the step.

    SUM of component ``first`` and, unless it is negative, ``second``; LENGTH of the vector of both; GREATEST amount of
    the components from ``first`` to before ``second``.
    """
    _, m = behind(pair)
    if kind == LENGTH:
        return math.hypot(component(first, x, m), component(second, x, m))
    if kind == SUM:
        return component(first, x, m) + (component(second, x, m) if second >= 0 else 0.0)
    greatest = 0.0
    for i in range(first, second):
        greatest = max(greatest, abs(component(i, x, m)))
    return greatest
