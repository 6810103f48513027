"""How a run got to its end: its greatest deflection and the balls that settle, also between jumps of the unbalance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.results.jumps import jump_times, parts_between_jumps
from autobalancer.results.measures import peak_deflection, settling_time


@dataclass(frozen=True)
class Peak:
    """Greatest deflection of a run at the reference station (m) and the speed there (rad/s)."""

    place: str
    deflection: float
    speed: float


@dataclass(frozen=True)
class Settling:
    """The ball that settles last: how long it takes, from when, and when that is in the run, s; ``moving`` never settle."""

    ball: int
    duration: float
    counted_from: str
    settled_at: float
    moving: tuple[int, ...]


@dataclass(frozen=True)
class RunPart:
    """A part of a run between jumps of its unbalance, from ``begin`` to ``end`` (s)."""

    begin: float
    end: float
    peak: Peak | None
    settling: Settling | None


def parts_of(run: xr.Dataset) -> tuple[RunPart, ...]:
    """The parts between jumps of the unbalance; none if it does not jump."""
    if not jump_times(run):
        return ()
    return tuple(RunPart(begin, end, peak_of(part), settling_of(part)) for begin, end, part in parts_between_jumps(run))


def peak_of(run: xr.Dataset) -> Peak | None:
    """The greatest deflection; None of a run that kept no data for it."""
    try:
        found = peak_deflection(run)
    except QuestionError:
        return None
    return Peak(str(run.attrs["reference_station"]), float(found["deflection"]), float(found["speed"]))


def settling_of(run: xr.Dataset) -> Settling | None:
    """The ball that settles last; None without balls, or without data."""
    if not run.sizes.get("ball", 0):
        return None
    try:
        found = settling_time(run)
    except QuestionError:
        return None
    at = found["settled_at"].values
    moving = tuple(int(ball) for ball in found["ball"].values[np.isnan(at)])
    if len(moving) == at.size:
        return Settling(0, np.nan, "", np.nan, moving)
    last = int(np.nanargmax(at))
    return Settling(last + 1, float(found[last]), str(found["counted_from"].values[last]), float(at[last]), moving)
