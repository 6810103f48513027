"""Curves over a uniform grid, cubic between the points."""

from __future__ import annotations

import math
from typing import Any

from autobalancer.kernels.compiler.flags import INLINE, njit
from autobalancer.kernels.records import NONE
from autobalancer.kernels.system import BALLS, Fluid


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


# How far the fluid around a ball lags behind its race.


@njit(**INLINE)
def fluid_lag(time: float, y: Any, fluid: Fluid, ball: Any) -> float:
    """Speed of the rotor less that of the fluid at the ball, rad/s: the sum of relaxation modes, or a table over time."""
    lag = 0.0
    for i in range(ball.first_mode, ball.first_mode + ball.modes):
        lag += y[fluid.modes[i].state]
    if ball.lag_table != NONE:
        lag += table_value(fluid, ball.lag_table, time)
    return lag


@njit(**INLINE)
def relax(y: Any, dy: Any, fluid: Fluid, acceleration: float) -> None:
    """The derivatives of all relaxation modes."""
    for i in range(fluid.modes.shape[0]):
        mode = fluid.modes[i]
        dy[mode.state] = mode.gain * acceleration - mode.rate * y[mode.state]


# A ball behind another one in its race feels less drag, as laws/drag_coefficient.py has it.


TURN = 2.0 * math.pi


@njit(**INLINE)
def _factor(fit: Any, reach: float, reynolds: float, distance: float) -> float:
    """The fit, clamped; it fades over the last diameter of its reach."""
    fade = min(max(reach - distance, 0.0), 1.0)
    apart = min(max(distance, 1.0), reach)
    total = 0.0
    for i in range(fit.shape[0] - 1, -1, -1):
        part = 0.0
        for j in range(fit.shape[1] - 1, -1, -1):
            part = part * apart + fit[i, j]
        total = total * reynolds + part
    return 1.0 - fade * max(1.0 - total, 0.0)


@njit(**INLINE)
def slipstream(y: Any, fluid: Fluid, number: int, along: float, speed: float) -> float:
    """Drag of a ball over that of a single one; ``number`` is that of its line, ``speed`` that through the fluid (m/s).

    ``along`` is the velocity along the race relative to the fluid, of which the sign counts: what is ahead.
    """
    line = fluid.lines[number]
    angle, sense = y[BALLS + line.ball], math.copysign(1.0, along)
    half = 0.5 / line.per_angle
    near, passing = TURN, 0.0
    for i in range(line.others):
        ahead = sense * (y[BALLS + fluid.others[line.first + i]] - angle)
        ahead -= TURN * math.floor(ahead / TURN)
        if ahead < half:
            passing = max(passing, ahead)
        else:
            near = min(near, ahead)
    reynolds = min(speed * line.per_speed, line.greatest)
    share = _factor(fluid.fit, line.reach, reynolds, near * line.per_angle)
    if passing > 0.0:
        part = passing / half
        share += part * part * (3.0 - 2.0 * part) * (_factor(fluid.fit, line.reach, reynolds, 1.0) - share)
    return share
