"""Quantities whose passage through a level is an event."""

from __future__ import annotations

import math

from numba import njit

from autobalancer.kernels.flags import INLINE
from autobalancer.kernels.system import BALLS, SPEED, Floats, X, Y

DEFLECTION, ROTOR_SPEED, BALL_SPEED_IN_ROTOR, BALL_SPEED_IN_SPACE, FASTEST_BALL = range(5)


@njit(**INLINE)
def event_value(kind: int, ball: int, level: float, y: Floats) -> float:
    """The quantity less the level; zero at the event."""
    count = (y.size - BALLS) // 2
    if kind == DEFLECTION:
        return math.hypot(y[X], y[Y]) - level
    if kind == ROTOR_SPEED:
        return y[SPEED] - level
    if kind == BALL_SPEED_IN_ROTOR:
        return y[BALLS + count + ball] - level
    if kind == BALL_SPEED_IN_SPACE:
        return y[SPEED] + y[BALLS + count + ball] - level
    fastest = 0.0
    for i in range(count):
        fastest = max(fastest, abs(y[BALLS + count + i]))
    return fastest - level
