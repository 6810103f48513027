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

from autobalancer.kernels.measures.limits import LIMITS as bounds
from autobalancer.kernels.measures.limits import SPEED_CHANGES, VIBRATION_CHANGES
from autobalancer.results.series import compiled, plain

Floats = NDArray[np.float64]

BALANCED, PARTLY, NOT, WORSE = "balanced", "partly balanced", "not balanced", "worse than without balls"
NO_VERDICT = "no verdict"
WORDS = (BALANCED, PARTLY, NOT, WORSE, NO_VERDICT)  # in the order of kernels/measures/limits.py
LIMITS = tuple(zip(bounds, WORDS[:3], strict=True))


def verdict_word(ratio: float) -> str:
    """The word for the vibration with balls over that without; ``"no verdict"`` for nan."""
    from autobalancer.kernels.measures.verdict import class_of

    return WORDS[class_of(ratio)]


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
    from autobalancer.kernels.measures.verdict import changing, twentieth

    envelope = plain(course.envelope_time), plain(course.low), plain(course.high)
    before, after = (twentieth(*envelope, course.end, begin, course.centered) for begin in (0.9, 0.95))
    moves = speed_changes(course.time, course.speed, course.end)
    reason = changing(moves, course.uneven, before, after, without_balls)
    if reason == SPEED_CHANGES:
        return (
            "the speed still changes in the last twentieth of the run, so the numbers are those of its last revolutions and "
            "not of a steady state; run longer"
        )
    if reason == VIBRATION_CHANGES:
        return "the vibration still changes in the last tenth of the run; run longer"
    return ""


def speed_changes(time: Floats, speed: Floats, end: float) -> bool:
    """Whether the speed still changes in the last twentieth of a run of ``end`` seconds, so that it has no steady state."""
    return bool(compiled().speed_changes(plain(time), plain(speed), end))


def goes_round(time: Floats, angle: Floats, end: float) -> bool:
    """Whether a ball makes a turn in the rotor in the last twentieth of a run; ``angle`` is (T, n) in the rotor, rad."""
    return bool(compiled().goes_round(plain(time), plain(angle), end))
