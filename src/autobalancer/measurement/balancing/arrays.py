"""Runs as arrays: complex readings, complex masses, and how sure the readings are."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.measurement.balancing.runs import BalanceRun, Reading
from autobalancer.shown import rpm_and_si

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Phase = Literal["lead", "lag"]
Angles = Literal["with rotation", "against rotation"]
SAME = 5e-3  # relative difference of speeds that count as one


@dataclass(frozen=True)
class Job:
    """R runs, C channels (a sensor at a speed), P planes.

    ``readings`` (R, C) are complex with the lead of the vibration as phase, or amplitudes alone; ``masses`` (R, P) are complex
    with angles in the sense of rotation. ``along`` and ``across`` (R, C) are standard deviations of a reading along its own
    direction and across it, nan where they are not known.
    """

    runs: tuple[str, ...]
    trim: tuple[bool, ...]
    sensors: tuple[str, ...]
    speeds: Floats
    units: tuple[str, ...]
    planes: tuple[str, ...]
    mass_unit: str
    readings: Complexes
    masses: Complexes
    along: Floats
    across: Floats

    def channel(self, c: int) -> str:
        """A channel for messages."""
        at = "" if math.isnan(self.speeds[c]) else f" at {rpm_and_si(float(self.speeds[c]))}"
        return f"sensor {self.sensors[c]!r}{at}"


def job_of(
    runs: Sequence[BalanceRun], phase: Phase, angles: Angles, deviation: float | None, *, phases: bool, owner: str
) -> Job:
    """The arrays of a job.

    ``deviation`` is a share of the amplitude, for readings that have none of their own. Without ``phases`` only amplitudes are
    used.

    Raises
    ------
    QuestionError
        If there are too few runs, a run lacks a reading, or units differ; it names the run.
    """
    runs = tuple(runs)
    for name, value, known in (("phase", phase, get_args(Phase)), ("angles", angles, get_args(Angles))):
        if value not in known:
            raise QuestionError(f"{name}: given {value!r}; must be {' or '.join(map(repr, known))}")
    if deviation is not None and not 0.0 < deviation < 1.0:
        raise QuestionError(f"deviation: given {deviation:g}; must be a share of the amplitude, such as 0.02 or '2 %'")
    if len(runs) < 2:
        raise QuestionError(
            f"{owner}: given {len(runs)} runs; at least one without and one with a trial mass are needed"
        )
    names = [run.name for run in runs]
    for name in names:
        if names.count(name) > 1:
            raise QuestionError(f"{owner}: two runs are called {name!r}; give each its own name")
    channels = _channels(runs[0], owner)
    for run in runs:
        _check_channels(run, channels, phases, owner)
    kinds = sorted({mass.unit for run in runs for mass in run.masses})
    if len(kinds) > 1:
        raise QuestionError(f"{owner}: some trial masses are masses, others unbalances; give all as one of both")
    planes = tuple(dict.fromkeys(mass.plane for run in runs for mass in run.masses))
    size = (len(runs), len(channels))
    readings, along, across = np.zeros(size, complex), np.full(size, np.nan), np.full(size, np.nan)
    masses = np.zeros((len(runs), len(planes)), complex)
    turn, count = (1.0 if phase == "lead" else -1.0), (1.0 if angles == "with rotation" else -1.0)
    for r, run in enumerate(runs):
        for c, (sensor, speed, _) in enumerate(channels):
            one = _reading(run, sensor, speed)
            assert one is not None
            size_of = float(one.amplitude)
            readings[r, c] = size_of * np.exp(1j * turn * _number(one.phase)) if phases else size_of
            share = np.nan if deviation is None else deviation * size_of
            along[r, c] = share if math.isnan(_number(one.amplitude_deviation)) else _number(one.amplitude_deviation)
            turned = size_of * _number(one.phase_deviation)
            across[r, c] = along[r, c] if math.isnan(turned) else turned
        for mass in run.masses:
            masses[r, planes.index(mass.plane)] += float(mass.mass) * np.exp(1j * count * float(mass.angle))
    return Job(
        tuple(names), tuple(run.trim for run in runs), tuple(c[0] for c in channels), np.array([c[1] for c in channels]),
        tuple(c[2] for c in channels), planes, kinds[0] if kinds else "kg", readings, masses, along, across,
    )  # fmt: skip


def _number(value: object) -> float:
    return float(value)  # type: ignore[arg-type]  # all are numbers once a reading is made


def _channels(run: BalanceRun, owner: str) -> list[tuple[str, float, str]]:
    found = [(one.sensor, _number(one.speed), one.unit) for one in run.readings]
    if not found:
        raise QuestionError(f"{owner}: run {run.name!r} has no readings")
    return found


def _reading(run: BalanceRun, sensor: str, speed: float) -> Reading | None:
    return next((one for one in run.readings if one.sensor == sensor and _same(_number(one.speed), speed)), None)


def _same(one: float, other: float) -> bool:
    return (math.isnan(one) and math.isnan(other)) or abs(one - other) <= SAME * abs(other)


def _check_channels(run: BalanceRun, channels: list[tuple[str, float, str]], phases: bool, owner: str) -> None:
    where = f"{owner}: run {run.name!r}"
    for sensor, speed, unit in channels:
        one = _reading(run, sensor, speed)
        at = "" if math.isnan(speed) else f" at {rpm_and_si(speed)}"
        if one is None:
            raise QuestionError(
                f"{where} has no reading of sensor {sensor!r}{at}, as the first run has; all runs need the same"
            )
        if one.unit != unit:
            raise QuestionError(
                f"{where}: sensor {sensor!r}{at} is in {one.unit}, in the first run in {unit}; keep to one"
            )
        if phases and math.isnan(_number(one.phase)):
            raise QuestionError(f"{where}: sensor {sensor!r}{at} has no phase; without phases use the four-run method")
    if len(run.readings) != len(channels):
        raise QuestionError(
            f"{where} has {len(run.readings)} readings, the first run {len(channels)}; all runs need the same"
        )
