"""Angles that go round and round, as lines on an axis from -180 to 180 degrees."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def wrapped(time: Floats, angle: Floats) -> tuple[Floats, Floats]:
    """A continuous angle (rad) as degrees within ±180, broken where it passes the edge.

    Each passage becomes three points: the edge left, a gap (nan), the edge entered; so no line runs across the axis.

    Parameters
    ----------
    time
        Ascending, s.
    angle
        Not wrapped, rad, of the same length.

    Returns
    -------
    time, degrees
        Arrays for one line.
    """
    turn = np.floor((angle + np.pi) / (2.0 * np.pi))
    inside = np.rad2deg(angle - 2.0 * np.pi * turn)
    passes = np.flatnonzero(np.diff(turn))
    at, when, value = [], [], []
    for i in passes:
        up = turn[i + 1] > turn[i]
        edges = np.pi * (2.0 * np.arange(turn[i], turn[i + 1]) + 1.0)
        if not up:
            edges = np.pi * (2.0 * np.arange(turn[i], turn[i + 1], -1.0) - 1.0)
        for edge in edges:
            part = (edge - angle[i]) / (angle[i + 1] - angle[i])
            moment = time[i] + part * (time[i + 1] - time[i])
            side = 180.0 if up else -180.0
            at += [i + 1] * 3
            when += [moment] * 3
            value += [side, np.nan, -side]
    return np.insert(time, at, when), np.insert(inside, at, value)


def slipping(time: Floats, angle: Floats, span: float) -> NDArray[np.bool_]:
    """Where an angle goes round over 2.5 times in 1/100 of ``span`` (s), so that its line would be a solid block."""
    if time.size < 2:
        return np.zeros(time.shape, np.bool_)
    window = 0.01 * span
    ahead = np.interp(time + 0.5 * window, time, angle)
    behind = np.interp(time - 0.5 * window, time, angle)
    fast: NDArray[np.bool_] = np.abs(ahead - behind) > 5.0 * np.pi
    return fast
