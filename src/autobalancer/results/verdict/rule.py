"""When a machine counts as balanced: one rule for balls in races, deep chambers, runs and studies.

The vibration with balls, at the place where it is greatest, is compared with the vibration of the same machine with its
balls spread evenly and held, where that is greatest. Up to a tenth of it is *balanced*, up to nine tenths *partly
balanced*, up to eleven tenths *not balanced*; more is *worse than without balls*. There is *no verdict* on a run that was
stopped, or whose speed changes by more than a hundredth in its last twentieth. *Not settled yet* is one of fewer than ten
revolutions, or whose vibration in the last two twentieths differs by more than a fifth, or would still change by more than
that: its means in the thirds of the last fifth are continued as an exponential approach; or whose balls drift and have not
settled. Where a ball goes round in the rotor only the twentieths count, which may differ by a factor of two. Below a tenth of
that without balls a vibration may change.
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
NO_VERDICT, NOT_SETTLED = "no verdict", "not settled yet"
WORDS = (BALANCED, PARTLY, NOT, WORSE, NO_VERDICT, NOT_SETTLED)  # in the order of kernels/measures/limits.py
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
    since: float = 0.0  # from when the run was left alone, s
    creeps: bool = False  # whether a ball that has not settled drifts at the end


def unsteady(course: Course, vibration: float, without_balls: float) -> tuple[str, str]:
    """The word and the reason where a run has not come to its end: its speed or its vibration still changes; else empty texts.

    ``vibration`` is the greatest of all places, ``without_balls`` that without balls (m): below a tenth of it a vibration may
    change.
    """
    from autobalancer.kernels.measures.verdict import REVOLUTIONS, changing, too_short, twentieth

    envelope = plain(course.envelope_time), plain(course.low), plain(course.high)
    before, after = (twentieth(*envelope, course.end, begin, course.centered) for begin in (0.9, 0.95))
    to_come = compiled().vibration_to_come(*envelope, course.since, course.end, course.centered)
    moves = speed_changes(course.time, course.speed, course.end)
    reason = changing(moves, course.uneven, course.creeps, before, after, to_come, vibration, without_balls)
    if reason == SPEED_CHANGES:
        return NO_VERDICT, (
            "the speed still changes in the last twentieth of the run, so the numbers are those of its last revolutions and "
            "not of a steady state; run longer"
        )
    if course.speed.size and too_short(course.end, float(course.speed[-1])):
        turns = course.end * abs(float(course.speed[-1])) / (2.0 * np.pi)
        return NOT_SETTLED, f"too short to tell: {turns:.2g} revolutions; take {REVOLUTIONS:g} or more"
    return (
        (NOT_SETTLED, "the vibration still changes at the end of the run") if reason == VIBRATION_CHANGES else ("", "")
    )


def speed_changes(time: Floats, speed: Floats, end: float) -> bool:
    """Whether the speed still changes in the last twentieth of a run of ``end`` seconds, so that it has no steady state."""
    return bool(compiled().speed_changes(plain(time), plain(speed), end))


def goes_round(time: Floats, angle: Floats, end: float) -> bool:
    """Whether a ball makes a turn in the rotor in the last twentieth of a run; ``angle`` is (T, n) in the rotor, rad."""
    return bool(compiled().goes_round(plain(time), plain(angle), end))
