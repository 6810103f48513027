"""What a run keeps. Ask for one of these or for several; memory grows with them only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from autobalancer.errors import QuestionError

MOST = 10_000_000  # of each kind


@dataclass(frozen=True)
class Samples:
    """The state at ``count`` equally spaced times, begin and end included."""

    count: int = 2001

    def __post_init__(self) -> None:
        if not 2 <= self.count <= MOST:
            raise QuestionError(f"Samples(count={self.count}): give 2, for begin and end, to {MOST}")


@dataclass(frozen=True)
class SampleTimes:
    """The state at these times (s, ascending)."""

    times: Sequence[float]


@dataclass(frozen=True)
class Envelope:
    """Least and greatest deflection in each of ``bins`` equal parts of the run, found on the dense output."""

    bins: int = 1000

    def __post_init__(self) -> None:
        if not 1 <= self.bins <= MOST:
            raise QuestionError(f"Envelope(bins={self.bins}): give 1 to {MOST}")


@dataclass(frozen=True)
class LastRevolutions:
    """The state at equal steps of the rotor angle over the last ``count`` revolutions."""

    count: int = 10
    per_revolution: int = 72

    def __post_init__(self) -> None:
        if self.count < 1 or self.per_revolution < 4:
            raise QuestionError(f"{self}: give at least 1 revolution and 4 samples in each")
        if self.count * self.per_revolution > MOST:
            raise QuestionError(f"{self}: give at most {MOST} samples in all")


Sampling = Samples | SampleTimes | Envelope | LastRevolutions
