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

    ``ball_speed`` is (time, ball), in space. With the ratio r = (ball speed - critical speed) / (rotor speed - critical
    speed) a ball is stalled at r < 1/4 and released where r then passes 1/2 for the last time.
    """
    margin = rotor_speed - critical_speed
    above = margin > STALL_MARGIN * critical_speed
    result = np.full(ball_speed.shape[1], np.nan)
    if not above.any():
        return result
    for i in range(ball_speed.shape[1]):
        ratio = np.where(above, (ball_speed[:, i] - critical_speed) / np.where(above, margin, 1.0), 1.0)
        stalled = np.flatnonzero(ratio < 0.25)
        if stalled.size < 2:
            continue
        low = np.flatnonzero(ratio[stalled[0] :] < 0.5)[-1] + stalled[0]
        if low + 1 < rotor_speed.size and ratio[-1] >= 0.5:
            result[i] = 0.5 * (rotor_speed[low] + rotor_speed[low + 1])
    return result


def wrapped(angle: Floats) -> Floats:
    """The same angle within (-pi, pi]."""
    return np.asarray(np.pi - np.mod(np.pi - angle, 2.0 * np.pi), np.float64)
