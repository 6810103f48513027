"""Release and capture speed of equal balls in one plane, whatever the receptance of the rotor."""

from __future__ import annotations

import math
from collections.abc import Sequence

from autobalancer.laws.stall import Receptance, StalledBall, StallRange, parting_speeds
from autobalancer.stability.border import Border
from autobalancer.stability.stall.capture import STEADY
from autobalancer.stability.stall.notes import CAPTURE, EXACTLY, HOW, PASS, RELEASE, WORTH, capture_border


def parted(
    ball: StalledBall,
    receptance: Receptance,
    resonances: Sequence[float],
    folds: tuple[StallRange, ...],
    count: int,
    how: str = HOW,
) -> Border:
    """In a fold, or where several balls part before it; ``how`` is what it says of itself."""
    ends = [(fold.release, fold.release_whirl) for fold in folds]
    if count > 1:
        apart = parting_speeds(ball, receptance, resonances)
        ends = [end for end in ends if not any(whirl <= end[1] and whirl > 0.8 * end[1] for _, whirl in apart)]
        ends += apart
    if not ends:
        return Border(RELEASE, math.nan, PASS)
    speed, _ = max(ends)
    notes = [how]
    if folds and folds[-1].release > (1.0 + WORTH) * speed:
        notes.append(EXACTLY.format(folds[-1].release))
    return Border(RELEASE, speed, "; ".join(notes))


def caught(folds: tuple[StallRange, ...], released: Border) -> Border:
    """In the fold at the highest whirl: balls that turn nearly with the rotor are beyond all resonances, and fall there.

    Where two resonances are close the fold between them may be at a higher speed of the rotor. It is not on their way.
    """
    ends = [(fold.capture_whirl, fold.capture) for fold in folds if not math.isnan(fold.capture)]
    if not ends:
        return Border(CAPTURE, math.nan, PASS if math.isnan(released.speed) else STEADY)
    return capture_border(max(ends)[1], "")
