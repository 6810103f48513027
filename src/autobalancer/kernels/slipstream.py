"""A ball behind another one in its race feels less drag: laws/slipstream.py, in a run."""

from __future__ import annotations

import math

from numba import njit

from autobalancer.kernels.flags import INLINE
from autobalancer.kernels.race_layout import (
    LINE_DISTANCE_POWERS,
    LINE_FIRST,
    LINE_FIT,
    LINE_OTHERS,
    LINE_OWN,
    LINE_PER_ANGLE,
    LINE_PER_SPEED,
    LINE_REACH,
    LINE_REYNOLDS,
    LINE_SPEED_POWERS,
)
from autobalancer.kernels.system import BALLS

TURN = 2.0 * math.pi


@njit(**INLINE)
def _factor(r, at: int, reynolds: float, distance: float) -> float:  # type: ignore[no-untyped-def]
    """The fit, clamped; it fades over the last diameter of its reach."""
    fade = min(max(r[at + LINE_REACH] - distance, 0.0), 1.0)
    apart = min(max(distance, 1.0), r[at + LINE_REACH])
    total = 0.0
    for i in range(LINE_SPEED_POWERS - 1, -1, -1):
        part = 0.0
        for j in range(LINE_DISTANCE_POWERS - 1, -1, -1):
            part = part * apart + r[at + LINE_FIT + i * LINE_DISTANCE_POWERS + j]
        total = total * reynolds + part
    return 1.0 - fade * max(1.0 - total, 0.0)


@njit(**INLINE)
def slipstream(y, r, at: int, along: float, speed: float) -> float:  # type: ignore[no-untyped-def]
    """Drag of a ball over that of a single one; ``at`` is the place of its numbers, ``speed`` that through the fluid (m/s).

    ``along`` is the velocity along the race relative to the fluid, of which the sign counts: what is ahead.
    """
    angle, sense = y[BALLS + int(r[at + LINE_OWN])], math.copysign(1.0, along)
    half = 0.5 / r[at + LINE_PER_ANGLE]
    near, passing = TURN, 0.0
    for i in range(int(r[at + LINE_OTHERS])):
        ahead = sense * (y[BALLS + int(r[at + LINE_FIRST + i])] - angle)
        ahead -= TURN * math.floor(ahead / TURN)
        if ahead < half:
            passing = max(passing, ahead)
        else:
            near = min(near, ahead)
    reynolds = min(speed * r[at + LINE_PER_SPEED], r[at + LINE_REYNOLDS])
    share = _factor(r, at, reynolds, near * r[at + LINE_PER_ANGLE])
    if passing > 0.0:
        part = passing / half
        share += part * part * (3.0 - 2.0 * part) * (_factor(r, at, reynolds, 1.0) - share)
    return share
