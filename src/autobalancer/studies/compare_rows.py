"""What a comparison of machines keeps of one run, of balls in races or in deep chambers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.results.chamber.measures import chamber_measures
from autobalancer.results.measure_table import numbers
from autobalancer.results.recorded_of import recorded_of
from autobalancer.results.verdict.judged import Verdict, verdict
from autobalancer.results.verdict.rule import NO_VERDICT
from autobalancer.simulation.chamber.verdict import chamber_verdict, middle_deflection
from autobalancer.stability.maps.speeds import borders

NEAR = 0.01  # of a speed: the rotor counts as running at it
LATE = 0.5  # of the time at a speed: the balls have had the rest of it to settle
BORDER = "exact border"
MEASURES = ("peak_deflection", "peak_speed", "vibration", "vibration_without_balls", "settling_time", "release_speed")


def race_row(machine: Machine, run: xr.Dataset, speeds: Sequence[float]) -> dict[str, Any]:
    """Of a ``run`` with its envelope and last revolutions; the greatest deflection also at these ``speeds``, rad/s."""
    recorded = recorded_of(run)
    row: dict[str, Any] = dict.fromkeys(MEASURES, math.nan)
    row |= {name: value for name, value in numbers(recorded).items() if name in MEASURES}
    bins = recorded.bins
    row["course"] = (bins.time, bins.high, bins.speed)
    row["deflection_at"] = [_at(bins.speed, bins.high, speed) for speed in speeds]
    judged: Verdict | None = None
    with suppress(QuestionError):
        judged = verdict(run)
    row["verdict"], row["support_force"] = _word(judged), _support_force(judged)
    row["beyond"] = [run.attrs[key] for key in ("drag_warning", "slipstream_warning") if run.attrs.get(key)]
    row["exact_border"], row["border_note"] = _border(machine)
    return row


def chamber_row(run: xr.Dataset, speeds: Sequence[float], bins: int) -> dict[str, Any]:
    """The same of a deep chamber, its deflection over time in ``bins`` parts."""
    judged = chamber_verdict(run)
    row: dict[str, Any] = dict.fromkeys(MEASURES, math.nan)
    row["settling_time"] = float(chamber_measures(run)["settling_time"])
    if judged.peak is not None:
        row["peak_deflection"], row["peak_speed"] = judged.peak.deflection, judged.peak.speed
    for place in judged.places:
        row["vibration"], row["vibration_without_balls"] = place.vibration, place.without_balls
    away, time, speed = np.abs(middle_deflection(run)), run["time"].values, run["speed"].values
    starts = np.linspace(0, time.size, min(bins, time.size), endpoint=False).astype(int)
    ends = np.append(starts[1:], time.size) - 1
    high = np.maximum.reduceat(away, starts)
    row["course"] = (0.5 * (time[starts] + time[ends]), high, speed[ends])
    row["deflection_at"] = [_at(speed[ends], high, wanted) for wanted in speeds]
    row["verdict"], row["support_force"] = _word(judged), _support_force(judged)
    row["beyond"], row["exact_border"], row["border_note"] = [], math.nan, ""
    return row


def _word(judged: Verdict | None) -> str:
    return NO_VERDICT if judged is None else judged.word


def _support_force(judged: Verdict | None) -> float:
    """How far the force of the hardest loaded support gets from its mean, N."""
    return max((one.vibrating for one in judged.supports), default=math.nan) if judged is not None else math.nan


def _at(speed: np.ndarray, high: np.ndarray, wanted: float) -> float:
    """Greatest deflection in the later part of the first stay at this speed; nan if the rotor never has it."""
    near = np.flatnonzero(np.abs(speed - wanted) <= NEAR * abs(wanted))
    if not near.size:
        return math.nan
    stay = near[: np.argmax(np.diff(near, append=speed.size + 1) > 1) + 1]
    return float(high[stay[int(LATE * stay.size) :]].max())


def _border(machine: Machine) -> tuple[float, str]:
    """Speed and note of the exact border."""
    try:
        found = borders(machine, only=(BORDER,))
    except QuestionError as refused:
        return math.nan, f"border not known, {refused}"
    return (found[0].speed, found[0].note) if found else (math.nan, "")
