"""Runs of a balancing job: which masses were on the rotor, and what was read."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from math import comb
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field, PlainValidator

from autobalancer.arrays import Complexes, Floats
from autobalancer.errors import Problem, QuestionError, UnitError, all_of, one_of
from autobalancer.files.samples import beside
from autobalancer.files.text_files import built_of, read_toml
from autobalancer.machine.keys import document
from autobalancer.machine.part import Angle, Label, Name, Quantity, Question, Ratio, Speed, Time, key
from autobalancer.measurement.load_signals import load_signals
from autobalancer.measurement.noise_density import independent
from autobalancer.measurement.tracking import orders
from autobalancer.tables import rpm_and_si
from autobalancer.units import argument, list_argument
from autobalancer.units.quantity import NUMBER

AMPLITUDES = ("m", "m/s", "m/s^2", "N", "V")
MASSES = ("kg", "kg*m")
OF_ALL = ("name", "phase", "angles", "deviation", "runout", "influence")  # what a file says of all runs
Phase = Literal["lead", "lag"]
Angles = Literal["with rotation", "against rotation"]
TURNS = 4.0 * math.pi  # a phase beyond it is hardly one in rad


class Sized(float):
    """A number in SI that knows its unit, and that in which it was written."""

    unit: str
    written: str

    def __new__(cls, value: float, unit: str, written: str = "") -> Sized:
        self = super().__new__(cls, value)
        self.unit, self.written = unit, written
        return self

    def __getnewargs__(self) -> tuple[float, str, str]:  # type: ignore[override]
        return float(self), self.unit, self.written


def _sized(units: tuple[str, ...], amplitude: bool = False) -> PlainValidator:
    """Reads a quantity that may have one of several dimensions."""

    def read(argument: Any) -> Sized:
        try:
            if isinstance(argument, Sized):
                return argument
            written = NUMBER.match(argument) if isinstance(argument, str) else None
            return Sized(*quantity_of_units("it", argument, units, amplitude), written[2].strip() if written else "")
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

    def contradictions(self) -> Iterator[Problem]:
        """What no instrument shows."""
        if not self.amplitude >= 0.0:
            yield ("amplitude",), f"given {self.amplitude:g}; must not be below zero"
        if self.phase is not None and abs(self.phase) > TURNS:
            said = f"given {self.phase:g} rad, more than two turns; a phase in degrees needs its unit: '{self.phase:g} deg'"
            yield ("phase",), said
        spread = self.amplitude_deviation
        if spread is not None and not spread > 0.0:
            yield ("amplitude_deviation",), f"given {spread:g}; must be above zero"
        if spread is not None and AMPLITUDES[0] != getattr(spread, "unit", self.unit) != self.unit:
            yield ("amplitude_deviation",), f"given in {getattr(spread, 'unit', '')}; must be in {self.unit}"

    @property
    def unit(self) -> str:
        """Of the amplitude."""
        return str(getattr(self.amplitude, "unit", AMPLITUDES[0]))


class BalanceRun(Question):
    """One run: all masses on the rotor besides its own unbalance, and the readings, or the recording of a logger."""

    name: Called = key("used in messages; that of its place unless given", "")
    readings: tuple[Reading, ...] = key("of the sensors", ())
    masses: tuple[TrialMass, ...] = key("on the rotor", ())
    trim: bool = key("whether the run only checks the correction", False)
    recording: str = key("file of a logger with a tacho, in place of readings: first order of each vibration", "")
    start: Time | None = key("of the part of the recording at constant speed", None)
    end: Time | None = key("of this part", None)

    def contradictions(self) -> Iterator[Problem]:
        """Readings besides a recording, or neither."""
        if bool(self.readings) == bool(self.recording):
            yield ("readings",), f"given {'besides' if self.readings else 'without'} a recording; must be one of both"


class InfluenceCoefficient(Reading):
    """What a mass in a plane, at the zero mark, does to one sensor, from an earlier job or a report."""

    plane: Called = key("name of the balancing plane")
    mass: Size = key("that makes this vibration; or an unbalance", value="kg, or kg m")

    @property
    def mass_unit(self) -> str:
        """Of the mass: kg, or kg m of an unbalance."""
        return str(getattr(self.mass, "unit", MASSES[0]))


class BalanceJob(Question):
    """The runs of a balancing job, and what holds for all of them."""

    name: Label = key("of the job", "")
    description: str = key("what it is about", "")
    phase: Phase | None = key("whether phases are those by which the vibration leads or lags", None)
    angles: Angles | None = key("in which sense angles on the rotor are counted", None)
    deviation: Ratio | None = key("standard deviation of readings as a share of the amplitude", None)
    runs: Annotated[tuple[BalanceRun, ...], Field(min_length=1)] = key("without and with trial masses")
    runout: tuple[Reading, ...] = key(
        "what sensors show of the shaft surface at slow roll, subtracted from their readings; of all speeds without one",
        (),
    )
    influence: tuple[InfluenceCoefficient, ...] = key(
        "coefficients that are known, in place of runs with trial masses", ()
    )


document(BalanceJob)


def quantity_of_units(
    name: str, value: float | str, units: Sequence[str], amplitude: bool = False
) -> tuple[float, str]:
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
    return balance_runs(path)[0]


def balance_runs(runs: Sequence[BalanceRun] | str | Path) -> tuple[tuple[BalanceRun, ...], dict[str, Any]]:
    """Runs, and what else a file says of all of them."""
    if not isinstance(runs, (str, Path)):
        return tuple(_recorded(run, Path()) for run in runs), {}
    path = Path(runs)
    job = built_of(lambda data: BalanceJob(**data), read_toml(path), str(path))
    named = (run if run.name else run.model_copy(update={"name": str(n)}) for n, run in enumerate(job.runs, 1))
    read = tuple(_recorded(run, path.parent) for run in named)
    return read, {key: getattr(job, key) for key in OF_ALL if key in job.model_fields_set}


def _recorded(run: BalanceRun, folder: Path) -> BalanceRun:
    """The run with readings of its recording: the mean first order of each vibration, of all windows at a constant speed."""
    if not run.recording:
        return run
    file = beside(folder, run.recording)
    found = orders(load_signals(file, start=run.start, end=run.end), progress=False).isel(order=0)
    first, last = (float(half.mean()) for half in np.array_split(found["speed"].values, 2))
    if not _same(first, last):
        raise QuestionError(
            f"{file}: the speed goes from {rpm_and_si(first)} to {rpm_and_si(last)}; give start and end of a part in "
            "which it is constant"
        )
    vectors = (found["amplitude"] * np.exp(1j * found["phase"])).mean("time").values
    count = math.sqrt(independent(found).sizes["time"])  # windows overlap
    sure = (found[["amplitude_deviation", "phase_deviation"]] ** 2).mean("time") ** 0.5 / count
    readings = tuple(
        Reading(
            amplitude=Sized(abs(vectors[k]), unit),
            phase=float(np.angle(vectors[k])),
            sensor=str(found["channel"].values[k]),
            speed=0.5 * (first + last),
            amplitude_deviation=Sized(float(sure["amplitude_deviation"][k]), unit),
            phase_deviation=float(sure["phase_deviation"][k]),
        )
        for k, unit in enumerate(found["units"].values.tolist())
    )
    return run.model_copy(update={"readings": readings})


# Runs as arrays: complex readings, complex masses, and how sure the readings are.


SAME = 5e-3  # relative difference of speeds that count as one


@dataclass(frozen=True)
class Job:
    """R runs, C channels (a sensor at a speed), P planes.

    ``readings`` (R, C) are complex with the lead of the vibration as phase, or amplitudes alone; ``masses`` (R, P) are complex
    with angles in the sense of rotation. ``along`` and ``across`` (R, C) are standard deviations of a reading along its own
    direction and across it, nan where they are not known. ``states`` (R, B) say which vectors each reading contains beside what
    the masses do: first the vibration of the rotor as it is now, then the run-out, then those of earlier jobs. What is known
    from elsewhere, the run-out and coefficients, stands before the runs, as readings of these alone. ``written`` are the
    units (C,) in which the first run has its readings, empty for numbers.
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
    states: Floats
    written: tuple[str, ...] = ()

    def channel(self, c: int) -> str:
        """A channel for messages."""
        return f"sensor {self.sensors[c]!r}{_at(float(self.speeds[c]))}"

    @property
    def now(self) -> NDArray[np.bool_]:
        """Runs of the rotor as it is now, (R,)."""
        return self.states[:, 0] > 0.0


def job_of(
    runs: Sequence[BalanceRun],
    phase: Phase,
    angles: Angles,
    deviation: float | None,
    *,
    phases: bool,
    owner: str,
    runout: Sequence[Reading] = (),
    coefficients: Sequence[InfluenceCoefficient] = (),
    least: int = 2,
) -> Job:
    """The arrays of a job.

    ``deviation`` is a share of the amplitude, for readings that have none of their own. Without ``phases`` only amplitudes are
    used.

    Raises
    ------
    QuestionError
        If there are fewer than the ``least`` runs, a run lacks a reading, or units differ; it names the run.
    """
    runs = tuple(runs)
    one_of("phase", phase, *get_args(Phase))
    one_of("angles", angles, *get_args(Angles))
    if deviation is not None and not 0.0 < deviation < 1.0:
        raise QuestionError(f"deviation: given {deviation:g}; must be a share of the amplitude, such as 0.02 or '2 %'")
    if len(runs) < least:
        raise QuestionError(
            f"{owner}: given {len(runs)} runs; at least one without and one with a trial mass are needed"
        )
    # what is known beforehand comes first: run-out, and the readings behind stored coefficients
    known_runs = _known_runs(runs[0], runout, coefficients, owner)
    rows = [*known_runs, *runs]
    names = [run.name for run in rows]
    for name in names:
        if names.count(name) > 1:
            raise QuestionError(f"{owner}: two runs are called {name!r}; give each its own name")
    channels = _channels(runs[0], owner)
    all_of(*(partial(_check_channels, run, channels, phases, owner) for run in runs))
    # all trial masses are of one dimension, kg or kg m
    kinds = sorted({mass.unit for run in rows for mass in run.masses})
    if len(kinds) > 1:
        raise QuestionError(f"{owner}: some trial masses are masses, others unbalances; give all as one of both")
    planes = tuple(dict.fromkeys(mass.plane for run in rows for mass in run.masses))
    # readings as complex amplitudes, phases as leads, with their deviations along and across
    size = (len(rows), len(channels))
    readings, along, across = np.zeros(size, complex), np.full(size, np.nan), np.full(size, np.nan)
    masses = np.zeros((len(rows), len(planes)), complex)
    turn, count = (1.0 if phase == "lead" else -1.0), (1.0 if angles == "with rotation" else -1.0)
    for r, run in enumerate(rows):
        for c, (sensor, speed, _) in enumerate(channels):
            reading = _reading(run, sensor, speed)
            if reading is None:  # a sensor without run-out
                along[r, c] = across[r, c] = 0.0
                continue
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
    # which unknown state each row is of: the rotor as it runs, or its slow roll
    states = np.zeros((len(rows), 2 if runout else 1))
    states[len(known_runs) :] = 1.0
    if runout:
        states[0, 1] = 1.0
    return Job(
        tuple(names), tuple(run.trim for run in rows), tuple(c[0] for c in channels), np.array([c[1] for c in channels]),
        tuple(c[2] for c in channels), planes, kinds[0] if kinds else "kg", readings, masses, along, across, states,
        tuple(str(getattr(reading.amplitude, "written", "")) for reading in runs[0].readings),
    )  # fmt: skip


def _known_runs(
    first: BalanceRun, runout: Sequence[Reading], coefficients: Sequence[InfluenceCoefficient], owner: str
) -> list[BalanceRun]:
    """The run-out and the coefficients of each plane as runs, over the channels of the first run."""
    channels, known = _channels(first, owner), []
    if runout:
        known.append(BalanceRun(name="run-out", readings=_at_channels(runout, channels, f"{owner}: runout")))
    for plane in dict.fromkeys(one.plane for one in coefficients):
        where = f"{owner}: influence of plane {plane!r}"
        own = [one for one in coefficients if one.plane == plane]
        unit = TrialMass(plane=plane, mass=own[0].mass)
        for one in own:
            if not float(one.mass) > 0.0 or one.mass_unit != unit.unit:
                raise QuestionError(f"{where}: given a mass of {float(one.mass):g} {one.mass_unit}; must be above zero, and "
                                    f"of the same kind for all sensors")  # fmt: skip
        scaled = [
            one.model_copy(
                update={
                    name: Sized(float(value) * float(unit.mass) / float(one.mass), one.unit)
                    for name in ("amplitude", "amplitude_deviation")
                    if (value := getattr(one, name)) is not None
                }
            )
            for one in own
        ]
        run = BalanceRun(name=f"influence of {plane}", readings=_at_channels(scaled, channels, where), masses=(unit,))
        _check_channels(run, channels, True, owner)
        known.append(run)
    return known


def _at_channels(vectors: Sequence[Reading], channels: list[tuple[str, float, str]], where: str) -> tuple[Reading, ...]:
    """Vectors of sensors as readings of the channels; one without speed is that of all speeds of its sensor."""
    readings: list[Reading] = []
    for one in vectors:
        own = [c for c in channels if c[0] == one.sensor and (one.speed is None or _same(c[1], float(one.speed)))]
        at = "" if one.speed is None else _at(float(one.speed))
        if not own:
            there = ", ".join(repr(name) + _at(speed) for name, speed, _ in channels)
            raise QuestionError(
                f"{where}: no reading of sensor {one.sensor!r}{at}; there are {there}"
                + "; leave the speed out for a vector of all speeds" * bool(at)
            )
        if one.phase is None:
            raise QuestionError(f"{where}: sensor {one.sensor!r}{at} has no phase; a vector has amplitude and phase")
        for name, speed, unit in own:
            if one.unit != unit:
                raise QuestionError(
                    f"{where}: sensor {name!r}{at} is in {one.unit}, its readings in {unit}; keep to one"
                )
            if any(other.sensor == name and _same(_number(other.speed), speed) for other in readings):
                raise QuestionError(f"{where}: sensor {name!r}{_at(speed)} is given twice; keep one")
            readings.append(one.model_copy(update={"speed": None if math.isnan(speed) else speed}))
    return tuple(readings)


def joined(earlier: Job, job: Job, where: str) -> Job:
    """The job with the runs of an earlier one in front, whose unbalance was another one.

    Raises
    ------
    QuestionError
        If a sensor or speed was not read then, or units differ.
    """
    columns: list[int] = []
    for c, (sensor, speed, unit) in enumerate(zip(job.sensors, job.speeds, job.units, strict=True)):
        own = [k for k, name in enumerate(earlier.sensors) if name == sensor and _same(float(earlier.speeds[k]), speed)]
        if not own:
            there = ", ".join(earlier.channel(k) for k in range(len(earlier.sensors)))
            raise QuestionError(f"{where}: no coefficients of {job.channel(c)}; there are those of {there}")
        if earlier.units[own[0]] != unit:
            raise QuestionError(f"{where}: {job.channel(c)} was in {earlier.units[own[0]]}, now in {unit}; keep to one")
        columns.append(own[0])
    if job.planes and job.mass_unit != earlier.mass_unit:
        raise QuestionError(f"{where}: masses were in {earlier.mass_unit}, now in {job.mass_unit}; keep to one")
    planes = tuple(dict.fromkeys((*earlier.planes, *job.planes)))
    kept = ~np.array(earlier.trim)
    taken = {name for name, keep in zip(earlier.runs, kept, strict=True) if keep}
    masses = np.zeros((kept.sum() + len(job.runs), len(planes)), complex)
    masses[: kept.sum(), [planes.index(p) for p in earlier.planes]] = earlier.masses[kept]
    masses[kept.sum() :, [planes.index(p) for p in job.planes]] = job.masses
    states = np.zeros((masses.shape[0], job.states.shape[1] + earlier.states.shape[1]))
    states[: kept.sum(), job.states.shape[1] :] = earlier.states[kept]
    states[kept.sum() :, : job.states.shape[1]] = job.states
    both = [
        np.concatenate([getattr(earlier, name)[kept][:, columns], getattr(job, name)])
        for name in ("readings", "along", "across")
    ]
    names = (*(name for name, keep in zip(earlier.runs, kept, strict=True) if keep),
             *(f"{name} now" if name in taken else name for name in job.runs))  # fmt: skip
    return replace(
        job, runs=names, trim=(False,) * int(kept.sum()) + job.trim, planes=planes, mass_unit=earlier.mass_unit,
        readings=both[0], along=both[1], across=both[2], masses=masses, states=states[:, states.any(axis=0)],
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


def _at(speed: float) -> str:
    return "" if math.isnan(speed) else f" at {rpm_and_si(speed)}"


def _same(one: float, other: float) -> bool:
    return (math.isnan(one) and math.isnan(other)) or abs(one - other) <= SAME * abs(other)


def _check_channels(run: BalanceRun, channels: list[tuple[str, float, str]], phases: bool, owner: str) -> None:
    where = f"{owner}: run {run.name!r}"
    for sensor, speed, unit in channels:
        reading = _reading(run, sensor, speed)
        at = _at(speed)
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


# A correction split over holes: masses at given angles whose sum comes nearest to the wanted one.


MOST = 20_000_000  # combinations that are tried
AT_ONCE = 500_000
EQUAL = 1e-6  # share of the wanted mass by which two answers are equally near


@dataclass(frozen=True)
class Split:
    """``masses`` (kg or kg m) at ``angles`` (rad), and what they leave: ``residual`` and ``residual_angle``."""

    angles: tuple[float, ...]
    masses: tuple[float, ...]
    residual: float
    residual_angle: float
    unit: str


def split_mass(
    mass: float | str,
    angle: float | str,
    *,
    holes: int | Sequence[float | str],
    first: float | str = 0.0,
    masses: Sequence[float | str] | None = None,
    largest: float | str | None = None,
    most: int = 3,
) -> Split:
    """Split a mass at an angle over holes.

    Parameters
    ----------
    mass
        Wanted, kg, or a text; an unbalance as ``"25 g*mm"``.
    angle
        Of it, rad.
    holes
        Their number, evenly spaced from ``first`` (rad) on, or the angle of each, rad.
    masses
        That there are, each as often as needed and one in a hole: of all choices of up to ``most`` holes the nearest is
        found, of equally near ones that with fewest and lightest masses. Without any, masses may have any size: the least sum
        of masses that makes the wanted one exactly.
    largest
        Greatest mass in a hole, where any size is possible.
    most
        Holes that may be used with given masses.

    Returns
    -------
    Split
        Only holes with a mass.

    Raises
    ------
    QuestionError
        If holes and masses cannot make the wanted mass, or there are too many choices.
    """
    wanted_size, unit = quantity_of_units("mass", mass, MASSES)
    where = argument("angle", angle, "rad")
    if not wanted_size >= 0.0:
        raise QuestionError(f"split_mass: mass: given {mass!r}; must not be below zero")
    places = _places(holes, argument("first", first, "rad"))
    wanted = complex(wanted_size * np.exp(1j * where))
    if masses is None:
        limit = np.inf if largest is None else _of_kind("largest", largest, unit)
        result = _least_masses(wanted, places, limit)
    else:
        if largest is not None:
            raise QuestionError("split_mass: largest: given with masses; leave those out that are too large")
        sizes = np.array(sorted({_of_kind("masses", mass, unit) for mass in masses}))
        if not sizes.size or not most >= 1:
            raise QuestionError("split_mass: give at least one of 'masses', and 'most' from 1 on")
        result = _of_stock(wanted, places, sizes, min(int(most), places.size))
    rounding = 1e-9 * max(wanted_size, 1e-300)
    used = np.flatnonzero(result > rounding)
    left = wanted - complex((result * np.exp(1j * places)).sum())
    left *= abs(left) > rounding
    return Split(
        tuple(places[used].tolist()),
        tuple(result[used].tolist()),
        abs(left),
        float(np.angle(left)),
        unit.replace("*", " "),
    )


def _of_kind(name: str, value: float | str, unit: str) -> float:
    number, own = quantity_of_units(name, value, MASSES)
    if isinstance(value, str) and own != unit:
        raise QuestionError(f"split_mass: {name}: given {value!r}, but the wanted mass is in {unit}")
    if not number > 0.0:
        raise QuestionError(f"split_mass: {name}: given {value!r}; must be above zero")
    return number


def _places(holes: int | Sequence[float | str], first: float) -> Floats:
    if isinstance(holes, int):
        if holes < 2:
            raise QuestionError(f"split_mass: holes: given {holes}; at least two are needed")
        return np.asarray(first + 2.0 * np.pi * np.arange(holes) / holes)
    return np.array(list_argument("holes", holes, "rad"))


def _least_masses(wanted: complex, places: Floats, limit: float) -> Floats:
    """The least sum of masses; two neighbors by the law of sines, unless a limit asks for more holes."""
    from scipy.optimize import linprog

    scale = abs(wanted) or 1.0
    result = linprog(
        np.ones(places.size),
        A_eq=np.stack([np.cos(places), np.sin(places)]),
        b_eq=np.array([wanted.real, wanted.imag]) / scale,
        bounds=(0.0, limit / scale if np.isfinite(limit) else None),
    )
    if not result.success:
        raise QuestionError(
            f"split_mass: {places.size} holes cannot hold this mass; there must be holes within 180 deg around its angle, and "
            "'largest' must not be too small"
        )
    return np.asarray(result.x * scale)


def _of_stock(wanted: complex, places: Floats, sizes: Floats, most: int) -> Floats:
    """All choices of up to ``most`` holes, and of a mass in each."""
    count = sum(comb(places.size, n) * sizes.size**n for n in range(1, most + 1))
    if count > MOST:
        raise QuestionError(
            f"split_mass: {count:.2g} choices of up to {most} of {places.size} holes and {sizes.size} masses are too many; "
            "take fewer masses, or a smaller 'most'"
        )
    best, answer = abs(wanted), np.zeros(places.size)
    slack = EQUAL * max(abs(wanted), float(sizes[0]))
    for n in range(1, most + 1):
        grids: Floats = np.stack(np.meshgrid(*[sizes] * n, indexing="ij"), -1).reshape(-1, n)
        chosen = np.array(list(combinations(range(places.size), n)))
        for part in np.array_split(chosen, -(-chosen.shape[0] * grids.shape[0] // AT_ONCE)):
            if not part.size:
                continue
            ways: Complexes = np.exp(1j * places[part])
            far = np.abs(ways @ grids.T - wanted)
            nearest = far.min()
            if nearest >= best - slack:
                continue
            near = np.argwhere(far <= nearest + slack)
            lightest = near[int(np.argmin(grids[near[:, 1]].sum(axis=1)))]
            best = float(far[tuple(lightest)])
            answer = np.zeros(places.size)
            answer[part[lightest[0]]] = grids[lightest[1]]
    return answer
