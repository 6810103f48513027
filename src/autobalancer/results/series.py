"""The numbers behind the measures: functions on plain arrays, so that a sweep can use them a thousand times."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

STALL_MARGIN = 0.02  # a ball can be called stalled only this far (relative) above the critical speed
REST = 1e-3  # balls slower than this share of the rotor speed are at rest at the end of a run


def settled_from(time: Floats, angle: Floats, speed: Floats, rotor_speed: Floats, tolerance: float) -> Floats:
    """Time from which each ball stays within ``tolerance`` (rad) of its last angle; nan if it still moves.

    ``angle`` and ``speed`` are (time, ball), in the rotor.
    """
    result = np.full(angle.shape[1], np.nan)
    for i in range(angle.shape[1]):
        if abs(speed[-1, i]) > REST * max(abs(rotor_speed[-1]), 1e-300):
            continue
        away = np.flatnonzero(np.abs(angle[:, i] - angle[-1, i]) > tolerance)
        if away.size == 0:
            result[i] = time[0]
        elif away[-1] + 1 < time.size - 1:
            result[i] = time[away[-1] + 1]
    return result


def released_at(rotor_speed: Floats, ball_speed: Floats, critical_speed: float) -> Floats:
    """Rotor speed at which each stalled ball breaks away; nan if it never stalled or never broke away.

    ``ball_speed`` is (time, ball), in space. A ball is stalled while it is three times nearer to the critical speed than to
    the rotor speed, at least 2 % above the critical speed. A stalled ball hangs just below the critical speed; it is
    released where it passes it for the last time, if it then comes nearer to the rotor speed.
    """
    margin = rotor_speed - critical_speed
    above = margin > STALL_MARGIN * critical_speed
    result = np.full(ball_speed.shape[1], np.nan)
    for i in range(ball_speed.shape[1]):
        excess = ball_speed[:, i] - critical_speed
        stalled = np.flatnonzero(above & (excess < 0.25 * margin))
        if stalled.size < 2 or excess[-1] < 0.5 * margin[-1]:
            continue
        below = np.flatnonzero(above & (excess < 0.0))
        if below.size == 0:  # it hung above the critical speed: take the end of the stall
            below = stalled
        last = min(int(below[-1]), rotor_speed.size - 2)
        rise = excess[last + 1] - excess[last]
        part = min(max(-excess[last] / rise, 0.0), 1.0) if rise > 0.0 else 0.5
        result[i] = rotor_speed[last] + part * (rotor_speed[last + 1] - rotor_speed[last])
    return result


def wrapped(angle: Floats) -> Floats:
    """The same angle within (-pi, pi]."""
    return np.asarray(np.pi - np.mod(np.pi - angle, 2.0 * np.pi), np.float64)
