"""Laws of a contact: normal force, adherence. Depths in m, velocities in m/s, forces in N. Friction laws are leaves."""

from __future__ import annotations

import math

from autobalancer.kernels.flags import INLINE, njit


@njit(**INLINE)
def normal_force(depth: float, rate: float, stiffness: float, damping: float, hertz: int) -> float:
    """Force of a contact ``depth`` deep, which grows at ``rate``; it never pulls.

    Linear (Spannan 2021, 5.3), or Hertz with the damping of Tsuji et al. (1992), whose restitution depends on no speed.
    """
    if depth <= 0.0:
        return 0.0
    if hertz == 0:
        return max(stiffness * depth + damping * rate, 0.0)
    root = math.sqrt(depth)
    return max(stiffness * depth * root + damping * math.sqrt(root) * rate, 0.0)


@njit(**INLINE)
def resting(slip: float, speed: float, rest_speed: float) -> float:
    """1 for a ball at rest in its race, 0 for one that slips or moves at ``rest_speed``, smooth between half of it and it."""
    fast = max(abs(slip), abs(speed)) / rest_speed
    if fast <= 0.5:
        return 1.0
    if fast >= 1.0:
        return 0.0
    part = 2.0 * (1.0 - fast)
    return part * part * (3.0 - 2.0 * part)


@njit(**INLINE)
def adherence(
    hold: float, slip: float, speed: float, limit: float, stiffness: float, damping: float, rest_speed: float
) -> tuple[float, float]:
    """Force against the motion along the race, and the rate of the spring's deflection ``hold`` (Spannan 2021, 5.15).

    The three conditions of the source are smooth: slip and speed below ``rest_speed`` let the spring hold, at most with
    ``limit``, where it yields, and let go as it relaxes. The force takes from the ball what goes into the spring, or more.
    """
    share = resting(slip, speed, rest_speed)
    whole = stiffness * hold + damping * speed
    kept = 1.0
    if abs(whole) > limit:
        kept = limit / abs(whole)
    return share * kept * whole, share * kept * speed - (1.0 - share) * hold * stiffness / damping
