"""Where a time or a speed is in a table."""

from __future__ import annotations

from typing import Any

from numba import float64, int64, types

from autobalancer.kernels.flags import EXACT_PART, INLINE, njit
from autobalancer.kernels.system import System, system_type


@njit(int64(float64, system_type), **EXACT_PART)
def segment_at(time: float, p: System) -> int:
    """The stretch of drive and unbalance in force at a time, just after a jump."""
    segments, k = p.drive.segments, 0
    while k + 1 < segments.shape[0] and segments[k + 1].start <= time:
        k += 1
    return k


@njit(**INLINE)
def since(time: float, k: int, p: System) -> float:
    """Time since the begin of stretch k, s; 0 where no unbalance changes in it, so that time may be infinite."""
    return time - p.drive.segments[k].start if p.drive.segments[k].changing != 0 else 0.0


@njit(types.UniTuple(float64, 2)(float64, system_type), **EXACT_PART)
def unbalance_at(time: float, p: System) -> tuple[float, float]:
    """Resultant unbalance in the rotor at a time, just after a jump, kg m."""
    k = segment_at(time, p)
    own, now = p.drive.segments[k], since(time, k, p)
    return own.unbalance_x + now * own.unbalance_rate_x, own.unbalance_y + now * own.unbalance_rate_y


@njit(**INLINE)
def share_of(k: int, speeds: Any, speed: float) -> float:
    """Weight of speed k of a table at a speed: linear in between, constant outside."""
    last, at = speeds.size - 1, abs(speed)
    if last == 0:
        return 1.0
    if at <= speeds[k]:
        if k == 0 or at == speeds[k]:
            return 1.0
        return max(0.0, (at - speeds[k - 1]) / (speeds[k] - speeds[k - 1]))
    return 1.0 if k == last else max(0.0, (speeds[k + 1] - at) / (speeds[k + 1] - speeds[k]))
