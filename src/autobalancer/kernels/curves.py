"""Curves over a uniform grid, cubic between the points."""

from __future__ import annotations

import math

from numba import njit

from autobalancer.kernels.flags import INLINE
from autobalancer.kernels.race_layout import (
    CURVE_COUNT,
    CURVE_FIRST,
    CURVE_STEP,
    CURVE_VALUES,
    TABLE_COUNT,
    TABLE_START,
    TABLE_STEP,
    TABLE_VALUES,
)


@njit(**INLINE)
def hermite(r, at: int, x: float, count: int) -> float:  # type: ignore[no-untyped-def]
    """Value at x (in steps) of (value, slope) pairs from place ``at`` on; constant outside."""
    last = count - 1.0
    x = min(max(x, 0.0), last)
    i = min(int(x), count - 2)
    s = x - i
    a = at + 2 * i
    d = r[a + 2] - r[a]
    m, n = r[a + 1] - d, d - r[a + 3]
    return r[a] + s * (d + (1.0 - s) * (m * (1.0 - s) + n * s))


@njit(**INLINE)
def drag_force(r, at: int, viscous: float, velocity: float) -> float:  # type: ignore[no-untyped-def]
    """Drag on a ball, N, against its velocity relative to the fluid: linear below the first point of the curve.

    Beyond the last point the drag coefficient keeps its value.
    """
    size = abs(velocity)
    if at == 0:
        return viscous * velocity
    count = int(r[at + CURVE_COUNT])
    if size <= math.exp(r[at + CURVE_FIRST]):
        return viscous * velocity
    place = (math.log(size) - r[at + CURVE_FIRST]) / r[at + CURVE_STEP]
    force = math.exp(hermite(r, at + CURVE_VALUES, place, count))
    beyond = place - (count - 1.0)
    if beyond > 0.0:
        force *= math.exp(2.0 * beyond * r[at + CURVE_STEP])
    return math.copysign(force, velocity)


@njit(**INLINE)
def table_value(r, at: int, time: float) -> float:  # type: ignore[no-untyped-def]
    """A quantity tabled over time."""
    return hermite(r, at + TABLE_VALUES, (time - r[at + TABLE_START]) / r[at + TABLE_STEP], int(r[at + TABLE_COUNT]))
