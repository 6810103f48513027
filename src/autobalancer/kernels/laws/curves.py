"""Curves over a uniform grid, cubic between the points."""

from __future__ import annotations

import math
from typing import Any

from autobalancer.kernels.flags import INLINE, njit
from autobalancer.kernels.records.fluid import NONE
from autobalancer.kernels.system import Fluid


@njit(**INLINE)
def between(value: float, slope: float, other: float, its_slope: float, s: float) -> float:
    """The cubic through two points with their slopes, a fraction s of the way from one to the other."""
    d = other - value
    m, n = slope - d, d - its_slope
    return value + s * (d + (1.0 - s) * (m * (1.0 - s) + n * s))


@njit(**INLINE)
def hermite(points: Any, first: int, count: int, x: float) -> float:
    """Value at x (in steps) of so many points from the ``first`` on; constant outside."""
    last = count - 1.0
    x = min(max(x, 0.0), last)
    i = min(int(x), count - 2)
    left, right = points[first + i], points[first + i + 1]
    return between(left.value, left.slope, right.value, right.slope, x - i)


@njit(**INLINE)
def drag_force(fluid: Fluid, curve: int, viscous: float, velocity: float) -> float:
    """Drag on a ball, N, against its velocity relative to the fluid: linear below the first point of the curve.

    Beyond the last point the drag coefficient keeps its value.
    """
    size = abs(velocity)
    if curve == NONE:
        return viscous * velocity
    table = fluid.tables[curve]
    if size <= math.exp(table.start):
        return viscous * velocity
    place = (math.log(size) - table.start) / table.step
    force = math.exp(hermite(fluid.points, table.first, table.count, place))
    beyond = place - (table.count - 1.0)
    if beyond > 0.0:
        force *= math.exp(2.0 * beyond * table.step)
    return math.copysign(force, velocity)


@njit(**INLINE)
def table_value(fluid: Fluid, number: int, time: float) -> float:
    """A quantity tabled over time."""
    table = fluid.tables[number]
    return hermite(fluid.points, table.first, table.count, (time - table.start) / table.step)
