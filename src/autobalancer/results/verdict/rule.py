"""When a machine counts as balanced: one rule for balls in races, deep chambers, runs and studies.

The vibration with balls, at the place where it is greatest, is compared with the vibration of the same machine with its
balls spread evenly and held, where that is greatest. Up to a tenth of it is *balanced*, up to nine tenths *partly
balanced*, up to eleven tenths *not balanced*; more is *worse than without balls*. There is no verdict on a run that has
not come to its end, whose speed changes by more than a hundredth in its last twentieth, or whose vibration in the last two
twentieths differs by more than a fifth, or by a factor of two where a ball goes round in the rotor. Below a tenth of that
without balls it may change.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

BALANCED, PARTLY, NOT, WORSE = "balanced", "partly balanced", "not balanced", "worse than without balls"
NO_VERDICT = "no verdict"
LIMITS = ((0.1, BALANCED), (0.9, PARTLY), (1.1, NOT))
SAME_SPEED = 0.01  # relative change over the last twentieth of a run
SAME_VIBRATION = 1.2  # factor between the last two twentieths
UNEVEN = 2.0  # the same where a ball goes round in the rotor, which is never even


def verdict_word(ratio: float) -> str:
    """The word for the vibration with balls over that without; ``"no verdict"`` for nan."""
    if np.isnan(ratio):
        return NO_VERDICT
    return next((word for limit, word in LIMITS if ratio <= limit), WORSE)


class Course(NamedTuple):
    """What tells whether a run has come to its end: samples, and the envelope of the reference station."""

    end: float  # time, s
    centered: bool  # nothing can deflect the rotor for good
    time: Floats  # (T,) s
    speed: Floats  # (T,) rad/s
    uneven: bool  # whether a ball goes round in the rotor at the end
    envelope_time: Floats  # (B,) s; empty without an envelope
    low: Floats  # (B,) m
    high: Floats  # (B,) m


def changing_because(course: Course, without_balls: float) -> str:
    """Why a run has no verdict: its speed or vibration still changes; else an empty text.

    ``without_balls`` is the greatest vibration without balls (m): below a tenth of it a vibration may change.
    """
    if speed_changes(course.time, course.speed, course.end):
        return (
            "the speed still changes in the last twentieth of the run, so the numbers are those of its last revolutions and "
            "not of a steady state; run longer"
        )
    before, after = (_vibration(course, begin) for begin in (0.9, 0.95))
    greater, smaller = max(before, after), min(before, after)
    if greater > LIMITS[0][0] * without_balls and greater > (UNEVEN if course.uneven else SAME_VIBRATION) * smaller:
        return "the vibration still changes in the last tenth of the run; run longer"
    return ""


def speed_changes(time: Floats, speed: Floats, end: float) -> bool:
    """Whether the speed still changes in the last twentieth of a run of ``end`` seconds, so that it has no steady state."""
    late = speed[time >= 0.95 * end]
    return bool(late.size and np.ptp(late) > SAME_SPEED * np.abs(late).max())


def goes_round(time: Floats, angle: Floats, end: float) -> bool:
    """Whether a ball makes a turn in the rotor in the last twentieth of a run; ``angle`` is (T, n) in the rotor, rad."""
    late = angle[time >= 0.95 * end]
    return bool(late.size and (np.abs(late[-1] - late[0]) > 2.0 * np.pi).any())


def _vibration(course: Course, begin: float) -> float:
    """Vibration at the reference station in the twentieth of the run from a share of it on, m; nan without envelope."""
    time = course.envelope_time
    inside = (time > begin * course.end) & (time <= (begin + 0.05) * course.end)
    if not inside.any():
        return np.nan
    high, low = float(course.high[inside].max()), float(course.low[inside].min())
    return high if course.centered else 0.5 * (high - low)
