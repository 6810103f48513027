"""Whether a run is balanced, by the rule of results/verdict.py."""

from __future__ import annotations

import math

from numba import boolean, float64, int64

from autobalancer.kernels.flags import EXACT, njit
from autobalancer.kernels.measures.limits import (
    LIMITS,
    NO_VERDICT,
    SAME_VIBRATION,
    SPEED_CHANGES,
    STEADY,
    UNEVEN,
    VIBRATION_CHANGES,
)
from autobalancer.kernels.system import Floats, vector_type

FIRST = LIMITS[0]
REVOLUTIONS = 10.0  # so that each of the last twentieths has half of one, in which a vibration shows its extremes


@njit(float64(vector_type, vector_type, vector_type, float64, float64, int64), **EXACT)
def twentieth(time: Floats, low: Floats, high: Floats, end: float, begin: float, centered: int) -> float:
    """Vibration at the reference station in the twentieth of a run from a share of it on, m; nan without an envelope there."""
    least, greatest, any_of = math.inf, -math.inf, False
    for b in range(time.size):
        if begin * end < time[b] <= (begin + 0.05) * end:
            least, greatest, any_of = min(least, low[b]), max(greatest, high[b]), True
    if not any_of:
        return math.nan
    return greatest if centered != 0 else 0.5 * (greatest - least)


@njit(int64(boolean, boolean, boolean, float64, float64, float64, float64, float64), **EXACT)
def changing(
    speed: bool,
    uneven: bool,
    creeps: bool,
    before: float,
    after: float,
    to_come: float,
    vibration: float,
    without: float,
) -> int:
    """Why a run has no verdict: its speed changes, or its vibration, ``before`` and ``after`` in the last two twentieths (m).

    ``uneven``: a ball goes round in the rotor; ``creeps``: one that has not settled drifts. ``to_come`` is the change of the
    vibration that is still to come, over what it is; nan if that is not known. ``vibration`` and ``without`` are the greatest of
    all places, that without balls (m): below a tenth of it a vibration may change.
    """
    if speed:
        return SPEED_CHANGES
    if creeps and not uneven and vibration > FIRST * without:
        return VIBRATION_CHANGES
    greater, smaller = max(before, after), min(before, after)
    if greater > FIRST * without:
        if greater > (UNEVEN if uneven else SAME_VIBRATION) * smaller:
            return VIBRATION_CHANGES
        if not uneven and (1.0 + to_come > SAME_VIBRATION or (1.0 + to_come) * SAME_VIBRATION < 1.0):
            return VIBRATION_CHANGES
    return STEADY


@njit(boolean(float64, float64), **EXACT)
def too_short(end: float, speed: float) -> bool:
    """Whether a run of ``end`` seconds has too few revolutions at its last ``speed`` (rad/s) to tell where it goes."""
    return end * abs(speed) < REVOLUTIONS * 2.0 * math.pi


@njit(int64(float64), **EXACT)
def class_of(ratio: float) -> int:
    """The verdict on a vibration with balls over that without."""
    if math.isnan(ratio):
        return NO_VERDICT
    for k in range(len(LIMITS)):
        if ratio <= LIMITS[k]:
            return k
    return len(LIMITS)
