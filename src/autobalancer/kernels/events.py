"""Quantities whose passage through a level is an event."""

from __future__ import annotations

import math

from numba import njit

from autobalancer.kernels.flags import COMPILED
from autobalancer.kernels.integrators.dense import component
from autobalancer.kernels.pointers import behind
from autobalancer.kernels.system import BALLS, SPEED, X, Y

DEFLECTION, ROTOR_SPEED, BALL_SPEED_IN_ROTOR, BALL_SPEED_IN_SPACE, FASTEST_BALL = range(5)


@njit(**COMPILED)
def event_value(kind, ball, count, level, x, pair):  # type: ignore[no-untyped-def]
    """The quantity at the fraction x of the step, less the level; zero at the event. ``count`` balls in all."""
    _, m = behind(pair)
    if kind == DEFLECTION:
        return math.hypot(component(X, x, m), component(Y, x, m)) - level
    if kind == ROTOR_SPEED:
        return component(SPEED, x, m) - level
    if kind == BALL_SPEED_IN_ROTOR:
        return component(BALLS + count + ball, x, m) - level
    if kind == BALL_SPEED_IN_SPACE:
        return component(SPEED, x, m) + component(BALLS + count + ball, x, m) - level
    fastest = 0.0
    for i in range(count):
        fastest = max(fastest, abs(component(BALLS + count + i, x, m)))
    return fastest - level
