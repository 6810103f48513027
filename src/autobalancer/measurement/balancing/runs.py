"""Runs of a balancing job: which masses were on the rotor, and what was read."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from autobalancer.errors import AutobalancerError, QuestionError, UnitError
from autobalancer.files.text import read_toml
from autobalancer.machine.part import unknown_key
from autobalancer.tables import rpm_and_si
from autobalancer.units import argument

AMPLITUDES = ("m", "m/s", "m/s^2", "N", "V")
MASSES = ("kg", "kg*m")
TURNS = 4.0 * math.pi  # a phase beyond it is hardly one in rad


@dataclass(frozen=True)
class TrialMass:
    """A mass on the rotor in a run.

    Parameters
    ----------
    plane
        Name of the balancing plane.
    mass
        kg, or a text such as ``"2.5 g"``; an unbalance as a text such as ``"25 g*mm"``. What is taken away is negative.
    angle
        On the rotor, rad, counted from the zero mark.
    """

    plane: str
    mass: float | str
    angle: float | str = 0.0
    unit: str = field(init=False, default="kg")

    def __post_init__(self) -> None:
        value, unit = one_of("mass", self.mass, MASSES)
        _set(self, plane=str(self.plane), mass=value, unit=unit, angle=argument("angle", self.angle, "rad"))


@dataclass(frozen=True)
class Reading:
    """What one sensor shows at one speed.

    Parameters
    ----------
    amplitude
        A number in SI or a text such as ``"7.2 mm/s"``: displacement, velocity, acceleration, force or voltage; the same kind of
        value in all runs. With ``pp`` or ``rms`` behind the unit, ``"7 mil pp"``, it becomes the peak of the sinusoid.
    phase
        Of the vibration against the mark, rad; without it only :func:`~autobalancer.measure.four_run` can use the reading.
    sensor
        Its name.
    speed
        Of the rotor, rad/s, where there are several.
    amplitude_deviation, phase_deviation
        One standard deviation, in the units of both.
    """

    amplitude: float | str
    phase: float | str | None = None
    sensor: str = "1"
    speed: float | str | None = None
    amplitude_deviation: float | str | None = None
    phase_deviation: float | str | None = None
    unit: str = field(init=False, default="m")

    def __post_init__(self) -> None:
        value, unit = one_of("amplitude", self.amplitude, AMPLITUDES, amplitude=True)
        if not value >= 0.0:
            raise QuestionError(f"amplitude: given {self.amplitude!r}; must not be below zero")
        found: dict[str, Any] = {"amplitude": value, "unit": unit, "sensor": str(self.sensor)}
        for name, si in (
            ("phase", "rad"),
            ("speed", "rad/s"),
            ("amplitude_deviation", unit),
            ("phase_deviation", "rad"),
        ):
            given = getattr(self, name)
            found[name] = (
                math.nan if given is None else argument(name, given, si, amplitude=name == "amplitude_deviation")
            )
        for name in ("amplitude_deviation", "phase_deviation"):
            if found[name] <= 0.0:
                raise QuestionError(f"{name}: given {getattr(self, name)!r}; must be above zero")
        if abs(found["phase"]) > TURNS:
            raise QuestionError(
                f"phase: given {found['phase']:g} rad, more than two turns; a phase in degrees needs its unit: "
                f"'{found['phase']:g} deg'"
            )
        _set(self, **found)


@dataclass(frozen=True)
class BalanceRun:
    """One run: all masses on the rotor besides its own unbalance, and the readings.

    ``name`` is used in messages; ``trim`` marks a run that only checks the correction.
    """

    name: str
    readings: Sequence[Reading]
    masses: Sequence[TrialMass] = ()
    trim: bool = False

    def __post_init__(self) -> None:
        _set(self, readings=tuple(self.readings), masses=tuple(self.masses))


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


def _set(record: Any, **values: Any) -> None:
    for name, value in values.items():
        object.__setattr__(record, name, value)


# Files of balancing runs: TOML, every quantity with its unit or in SI.


TOP = ("name", "description", "phase", "angles", "deviation", "runs")
RUN = ("name", "readings", "masses", "trim")
READING = ("amplitude", "phase", "sensor", "speed", "amplitude_deviation", "phase_deviation")
MASS = ("plane", "mass", "angle")


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
    data = read_toml(path)
    _check(data, TOP, f"{path}")
    entries = _tables(data, "runs", f"{path}")
    if not entries:
        raise QuestionError(f"{path}: no runs; write each one under its own line [[runs]]")
    found = []
    for number, entry in enumerate(entries, 1):
        where = f"{path}: run {str(entry.get('name', number))!r}"
        _check(entry, RUN, where)
        found.append(
            BalanceRun(
                str(entry.get("name", number)),
                [
                    _made(Reading, one, READING, ("amplitude",), f"{where}: readings[{n}]")
                    for n, one in _each(entry, "readings", where)
                ],
                [
                    _made(TrialMass, one, MASS, ("plane", "mass"), f"{where}: masses[{n}]")
                    for n, one in _each(entry, "masses", where)
                ],
                bool(entry.get("trim", False)),
            )
        )
    return tuple(found), {key: data[key] for key in ("name", "phase", "angles", "deviation") if key in data}


def _each(entry: dict[str, Any], key: str, where: str) -> list[tuple[int, dict[str, Any]]]:
    return list(enumerate(_tables(entry, key, where), 1))


def _tables(entry: dict[str, Any], key: str, where: str) -> list[dict[str, Any]]:
    found = entry.get(key, [])
    if not isinstance(found, list) or not all(isinstance(one, dict) for one in found):
        raise QuestionError(f"{where}: {key}: must be a list of tables, such as {key} = [{{ ... }}]")
    return found


def _check(entry: dict[str, Any], allowed: tuple[str, ...], where: str) -> None:
    for key in entry:
        if key not in allowed:
            raise QuestionError(f"{where}: {key}: {unknown_key(key, allowed)}")


def _made(kind: Any, entry: dict[str, Any], allowed: tuple[str, ...], needed: tuple[str, ...], where: str) -> Any:
    _check(entry, allowed, where)
    for key in needed:
        if key not in entry:
            raise QuestionError(f"{where}: {key}: missing; it has no default")
    try:
        return kind(**entry)
    except AutobalancerError as error:
        raise type(error)(f"{where}: {error}") from None


# Runs as arrays: complex readings, complex masses, and how sure the readings are.


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
