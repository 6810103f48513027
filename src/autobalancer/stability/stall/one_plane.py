"""The release speed of equal balls in one plane, whatever the receptance of the rotor."""

from __future__ import annotations

import math
from collections.abc import Sequence

from autobalancer.laws.stall import Receptance, StalledBall, StallRange, parting_speeds
from autobalancer.stability.border import Border
from autobalancer.stability.stall.notes import EXACTLY, HOW, PASS, RELEASE, WORTH


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
