"""A ball behind another one in its race feels less drag: laws/slipstream.py of the package, in a run."""

from __future__ import annotations

import math
from typing import Any

from autobalancer.kernels.flags import INLINE, njit
from autobalancer.kernels.system import BALLS, Fluid

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
