"""Runs of a balancing job: which masses were on the rotor, and what was read."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field, PlainValidator, model_validator

from autobalancer.errors import QuestionError, UnitError
from autobalancer.files.text import faults_of, read_toml
from autobalancer.machine.keys import document
from autobalancer.machine.part import Angle, Label, Name, Quantity, Question, Ratio, Speed, key
from autobalancer.tables import rpm_and_si
from autobalancer.units import argument

AMPLITUDES = ("m", "m/s", "m/s^2", "N", "V")
MASSES = ("kg", "kg*m")
OF_ALL = ("name", "phase", "angles", "deviation")  # what a file says of all runs
Phase = Literal["lead", "lag"]
Angles = Literal["with rotation", "against rotation"]
TURNS = 4.0 * math.pi  # a phase beyond it is hardly one in rad


class Sized(float):
    """A number in SI that knows its unit."""

    unit: str

    def __new__(cls, value: float, unit: str) -> Sized:
        self = super().__new__(cls, value)
        self.unit = unit
        return self

    def __getnewargs__(self) -> tuple[float, str]:  # type: ignore[override]
        return float(self), self.unit


def _sized(units: tuple[str, ...], amplitude: bool = False) -> PlainValidator:
    """Reads a quantity that may have one of several dimensions."""

    def read(argument: Any) -> Sized:
        try:
            return argument if isinstance(argument, Sized) else Sized(*one_of("it", argument, units, amplitude))
        except UnitError as reason:
            raise ValueError(str(reason).removeprefix("it: ")) from None

    return PlainValidator(read, json_schema_input_type=float | str)


Called = Annotated[Name, BeforeValidator(lambda given: str(given) if type(given) is int else given, str | int)]
Size = Annotated[float, _sized(MASSES)]
Amplitude = Annotated[float, _sized(AMPLITUDES, amplitude=True)]


class TrialMass(Question):
    """A mass on the rotor in a run."""

    plane: Called = key("name of the balancing plane")
    mass: Size = key("or an unbalance; what is taken away is negative", value="kg, or kg m")
    angle: Angle = key("on the rotor, from the zero mark", 0.0)

    @property
    def unit(self) -> str:
        """Of the mass: kg, or kg m of an unbalance."""
        return str(getattr(self.mass, "unit", MASSES[0]))


class Reading(Question):
    """What one sensor shows at one speed: the same kind of value in all runs.

    With ``pp`` or ``rms`` behind the unit, ``"7 mil pp"``, an amplitude becomes the peak of the sinusoid.
    """

    amplitude: Amplitude = key(
        "displacement, velocity, acceleration, force or voltage", value="m, m/s, m/s², N or V, ≥ 0"
    )
    phase: Angle | None = key("of the vibration against the mark; without it for `four_run` only", None)
    sensor: Called = key("its name", "1")
    speed: Speed | None = key("of the rotor, where there are several", None)
    amplitude_deviation: Amplitude | None = key(
        "one standard deviation", None, value="in the unit of the amplitude, > 0"
    )
    phase_deviation: Annotated[float, Quantity("rad", positive=True)] | None = key("one standard deviation", None)

    @model_validator(mode="after")
    def _is_possible(self) -> Reading:
        if not self.amplitude >= 0.0:
            raise QuestionError(f"given {self.amplitude:g}; must not be below zero", ("amplitude",))
        if self.phase is not None and abs(self.phase) > TURNS:
            said = f"given {self.phase:g} rad, more than two turns; a phase in degrees needs its unit: '{self.phase:g} deg'"
            raise QuestionError(said, ("phase",))
        spread = self.amplitude_deviation
        if spread is not None and not spread > 0.0:
            raise QuestionError(f"given {spread:g}; must be above zero", ("amplitude_deviation",))
        if spread is not None and AMPLITUDES[0] != getattr(spread, "unit", self.unit) != self.unit:
            raise QuestionError(
                f"given in {getattr(spread, 'unit', '')}; must be in {self.unit}", ("amplitude_deviation",)
            )
        return self

    @property
    def unit(self) -> str:
        """Of the amplitude."""
        return str(getattr(self.amplitude, "unit", AMPLITUDES[0]))


class BalanceRun(Question):
    """One run: all masses on the rotor besides its own unbalance, and the readings."""

    name: Called = key("used in messages; that of its place unless given", "")
    readings: tuple[Reading, ...] = key("of the sensors")
    masses: tuple[TrialMass, ...] = key("on the rotor", ())
    trim: bool = key("whether the run only checks the correction", False)


class BalanceJob(Question):
    """The runs of a balancing job, and what holds for all of them."""

    name: Label = key("of the job", "")
    description: str = key("what it is about", "")
    phase: Phase | None = key("whether phases are those by which the vibration leads or lags", None)
    angles: Angles | None = key("in which sense angles on the rotor are counted", None)
    deviation: Ratio | None = key("standard deviation of readings as a share of the amplitude", None)
    runs: Annotated[tuple[BalanceRun, ...], Field(min_length=1)] = key("without and with trial masses")


document(BalanceJob)


def one_of(name: str, value: float | str, units: Sequence[str], amplitude: bool = False) -> tuple[float, str]:
    """A quantity that may have one of several dimensions, in SI, and its unit; a number has the first.

    The suffix of an ``amplitude`` is understood.

    Raises
    ------
    UnitError
        If it has none of them.
    """
    if not isinstance(value, str):
        return argument(name, value, units[0]), units[0]
    reason = ""
    for unit in units:
        try:
            return argument(name, value, unit, amplitude), unit
        except UnitError as error:
            reason = reason or str(error)
    other = " is wanted here" in reason  # it is a quantity, but none of these
    raise UnitError(
        f"{name}: given {value!r}; give a number with a unit, one of {', '.join(units)}" if other else reason
    )


# Files of balancing runs: TOML, every quantity with its unit or in SI.


def load_balance_runs(path: str | Path) -> tuple[BalanceRun, ...]:
    """Read the runs of a balancing job.

    Parameters
    ----------
    path
        A TOML file with a list ``runs``; the keys of its entries are those of :class:`~autobalancer.measure.BalanceRun`, of its
        lists ``readings`` and ``masses`` those of :class:`~autobalancer.measure.Reading` and
        :class:`~autobalancer.measure.TrialMass`. ``phase``, ``angles`` and ``deviation`` may stand above them, and mean what
        they mean in :func:`~autobalancer.measure.balance`.

    Raises
    ------
    QuestionError
        If the file or an entry cannot be read; it names the run.
    """
    return given_runs(path)[0]


def given_runs(runs: Sequence[BalanceRun] | str | Path) -> tuple[tuple[BalanceRun, ...], dict[str, Any]]:
    """Runs, and what else a file says of all of them."""
    if not isinstance(runs, (str, Path)):
        return tuple(runs), {}
    path = Path(runs)
    with faults_of(str(path)):
        job = BalanceJob(**read_toml(path))
    named = (run if run.name else run.model_copy(update={"name": str(n)}) for n, run in enumerate(job.runs, 1))
    return tuple(named), {key: getattr(job, key) for key in OF_ALL if key in job.model_fields_set}


# Runs as arrays: complex readings, complex masses, and how sure the readings are.


Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
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
            reading = _reading(run, sensor, speed)
            assert reading is not None
            size_of = float(reading.amplitude)
            readings[r, c] = size_of * np.exp(1j * turn * _number(reading.phase)) if phases else size_of
            share = np.nan if deviation is None else deviation * size_of
            along[r, c] = (
                share if math.isnan(_number(reading.amplitude_deviation)) else _number(reading.amplitude_deviation)
            )
            turned = size_of * _number(reading.phase_deviation)
            across[r, c] = along[r, c] if math.isnan(turned) else turned
        for mass in run.masses:
            masses[r, planes.index(mass.plane)] += float(mass.mass) * np.exp(1j * count * float(mass.angle))
    return Job(
        tuple(names), tuple(run.trim for run in runs), tuple(c[0] for c in channels), np.array([c[1] for c in channels]),
        tuple(c[2] for c in channels), planes, kinds[0] if kinds else "kg", readings, masses, along, across,
    )  # fmt: skip


def _number(value: object) -> float:
    return math.nan if value is None else float(value)  # type: ignore[arg-type]  # numbers once a reading is made


def _channels(run: BalanceRun, owner: str) -> list[tuple[str, float, str]]:
    channels = [(reading.sensor, _number(reading.speed), reading.unit) for reading in run.readings]
    if not channels:
        raise QuestionError(f"{owner}: run {run.name!r} has no readings")
    return channels


def _reading(run: BalanceRun, sensor: str, speed: float) -> Reading | None:
    return next(
        (reading for reading in run.readings if reading.sensor == sensor and _same(_number(reading.speed), speed)), None
    )


def _same(one: float, other: float) -> bool:
    return (math.isnan(one) and math.isnan(other)) or abs(one - other) <= SAME * abs(other)


def _check_channels(run: BalanceRun, channels: list[tuple[str, float, str]], phases: bool, owner: str) -> None:
    where = f"{owner}: run {run.name!r}"
    for sensor, speed, unit in channels:
        reading = _reading(run, sensor, speed)
        at = "" if math.isnan(speed) else f" at {rpm_and_si(speed)}"
        if reading is None:
            raise QuestionError(
                f"{where} has no reading of sensor {sensor!r}{at}, as the first run has; all runs need the same"
            )
        if reading.unit != unit:
            raise QuestionError(
                f"{where}: sensor {sensor!r}{at} is in {reading.unit}, in the first run in {unit}; keep to one"
            )
        if phases and math.isnan(_number(reading.phase)):
            raise QuestionError(f"{where}: sensor {sensor!r}{at} has no phase; without phases use the four-run method")
    if len(run.readings) != len(channels):
        raise QuestionError(
            f"{where} has {len(run.readings)} readings, the first run {len(channels)}; all runs need the same"
        )
