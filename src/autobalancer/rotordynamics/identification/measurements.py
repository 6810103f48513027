"""What was measured, each with its standard deviation, and what a machine predicts for it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, Literal, Protocol, get_args

import numpy as np
import xarray as xr

from autobalancer.assembly.quantities import parameter_of
from autobalancer.assembly.rotors import LateralModel, lateral_model, rows_at, with_ball_mass
from autobalancer.assembly.rotors.lateral_model import Floats
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.machine.path import unit_at
from autobalancer.rotordynamics.campbell import critical_speeds
from autobalancer.rotordynamics.eigenproblem import (
    FreeMotions,
    Whirl,
    ellipses_of,
    free_motions,
    greatest_mean,
    mean_of_greatest,
    mode_names,
    whirl,
    whole_direction,
)
from autobalancer.rotordynamics.question import Places, along_axis, checked_speeds, chosen_places
from autobalancer.rotordynamics.response import amplitudes, load_of

ModeQuantity = Literal["frequency", "decay_rate", "damping_ratio"]
ResponseMeasure = Literal["mean_of_greatest", "greatest_mean", "semi_major", "forward", "x", "y"]
WhirlWord = Literal["forward", "backward", "mixed", "straight"]
Motion = Literal["displacement", "velocity", "acceleration"]
ONE_PLACE = ("semi_major", "forward", "x", "y")


@dataclass(frozen=True)
class Rows:
    """The measured values of one measurement: what people read, and in which unit."""

    label: str
    kind: str
    unit: str
    measured: Floats
    error: Floats
    speed: Floats  # nan where it has none
    parts: tuple[str, ...] = ()  # of what each value is, where they differ


class Measurement(Protocol):
    """Something measured on a machine."""

    def rows(self) -> Rows:
        """Measured values and standard deviations."""

    def predict(self, trial: Trial) -> Floats:
        """What the machine gives in their place; nan where it has no such thing."""

    def residual(self, predicted: Floats) -> Floats:
        """Deviations of the prediction in standard deviations."""


@dataclass(frozen=True)
class _Single:
    """A measurement of one number."""

    value: float
    error: float

    def residual(self, predicted: Floats) -> Floats:
        """See :class:`Measurement`."""
        return np.asarray((predicted - self.value) / self.error)

    def _rows(self, label: str, kind: str, unit: str, speed: float = math.nan) -> Rows:
        check_error(label, self.value, self.error)
        return Rows(label, kind, unit, np.array([self.value]), np.array([self.error]), np.array([speed]))


@dataclass(frozen=True)
class MeasuredMode(_Single):
    """Frequency (damped, rad/s), decay rate (1/s) or damping ratio of a mode at a rotor speed, rad/s.

    The mode is the ``order``-th by frequency of those with this ``whirl`` direction (forward, backward, mixed, straight)
    and with the words of ``mode`` in their names, such as ``"cylindrical y"``. On an isotropic rotor give the direction:
    at rest each frequency occurs twice.
    """

    quantity: ModeQuantity = "frequency"
    speed: float = 0.0
    order: int = 1
    whirl: str | None = None
    mode: str | None = None
    balls: bool = False

    def rows(self) -> Rows:
        """See :class:`Measurement`."""
        if self.quantity not in get_args(ModeQuantity):
            allowed = ", ".join(get_args(ModeQuantity))
            raise QuestionError(f"identify: mode: quantity: given {self.quantity!r}; must be one of {allowed}")
        label = f"{self.quantity.replace('_', ' ')} of {_which('mode', self)}"
        units = {"frequency": "rad/s", "decay_rate": "1/s", "damping_ratio": ""}
        return self._rows(label, self.quantity, units[self.quantity], self.speed)

    def predict(self, trial: Trial) -> Floats:
        """See :class:`Measurement`."""
        checked_speeds(self.speed, trial.bare, "identify")
        motions = trial.motions(self.speed, self.balls)
        words = [("", "")] * motions.count
        if self.whirl is not None or self.mode is not None:
            words = trial.words(self.speed, self.balls)
        number = chosen(words, self.order, self.whirl, self.mode)
        if number is None:
            return np.array([math.nan])
        root = motions.eigenvalue[number]
        answer = {"frequency": root.imag, "decay_rate": -root.real, "damping_ratio": -root.real / abs(root)}
        return np.array([answer[self.quantity]])


@dataclass(frozen=True)
class MeasuredCriticalSpeed(_Single):
    """A critical speed, rad/s: the ``order``-th with this whirl direction and the words of ``mode`` in its name.

    Without damping, as given by :func:`~autobalancer.rotordynamics.campbell.critical_speeds`; with ``highest`` (rad/s) the
    damped ones up to that speed.
    """

    order: int = 1
    whirl: str | None = None
    mode: str | None = None
    balls: bool = False
    highest: float | None = None

    def rows(self) -> Rows:
        """See :class:`Measurement`."""
        return self._rows(_which("critical speed", self), "critical_speed", "rad/s", self.value)

    def predict(self, trial: Trial) -> Floats:
        """See :class:`Measurement`."""
        speeds, words = trial.critical(self.balls, self.highest)
        number = chosen(words, self.order, self.whirl, self.mode)
        return np.array([math.nan if number is None else speeds[number]])


@dataclass(frozen=True)
class MeasuredStiffness(_Single):
    """Static stiffness at a place across the rotor, N/m: force over deflection along ``x`` or ``y``."""

    station: str | float | None = None
    direction: Literal["x", "y"] = "x"

    def rows(self) -> Rows:
        """See :class:`Measurement`."""
        if self.direction not in ("x", "y"):
            raise QuestionError(f"identify: stiffness: direction: given {self.direction!r}; must be x or y")
        return self._rows(f"static stiffness at {self.station or 'rotor'} along {self.direction}", "stiffness", "N/m")

    def predict(self, trial: Trial) -> Floats:
        """See :class:`Measurement`."""
        rows = rows_at(trial.machine, trial.bare, self.station, "stations").deflection[None]
        axis = "xy".index(self.direction)
        return np.array([1.0 / trial.bare.receptance(0.0, 0.0, rows)[axis, axis].real])


@dataclass(frozen=True)
class KnownValue(_Single):
    """A parameter known with an error: the path of an entry of the machine, or the name of a free parameter."""

    path: str = ""

    def rows(self) -> Rows:
        """See :class:`Measurement`."""
        return self._rows(f"known {self.path}", "known", unit_at(self.path))

    def predict(self, trial: Trial) -> Floats:
        """See :class:`Measurement`."""
        known = trial.values
        return np.array([known[self.path] if self.path in known else parameter_of(trial.machine, self.path)])


@dataclass(frozen=True)
class MeasuredResponse:
    """Amplitudes of the synchronous unbalance response over the speed, without balls.

    Parameters
    ----------
    speeds, amplitudes
        rad/s and m (m/s, m/s^2 for the other quantities); one of each.
    error
        Standard deviations, one or as many; with ``logarithmic`` relative to the amplitudes, else in their unit.
    stations
        Names or positions; by default all stations.
    measure
        ``mean_of_greatest`` (Rodrigues et al. 2011, (3)) or ``greatest_mean`` of all stations; of one station
        ``semi_major``, ``forward``, ``x`` or ``y``.
    logarithmic
        Whether the logarithms are compared, so that small and large amplitudes have the same weight.
    quantity
        ``displacement``, ``velocity`` or ``acceleration``.
    """

    speeds: Sequence[float] | Floats
    amplitudes: Sequence[float] | Floats
    error: float | Sequence[float] | Floats
    stations: Sequence[str | float] | str | float | None = None
    measure: ResponseMeasure = "mean_of_greatest"
    logarithmic: bool = True
    quantity: Motion = "displacement"
    label: str = "response"

    def rows(self) -> Rows:
        """See :class:`Measurement`."""
        speeds, values = np.asarray(self.speeds, np.float64), np.asarray(self.amplitudes, np.float64)
        errors = np.broadcast_to(np.asarray(self.error, np.float64), values.shape)
        if speeds.ndim != 1 or speeds.shape != values.shape or speeds.size == 0:
            raise QuestionError(
                f"identify: {self.label}: given {speeds.size} speeds and {values.size} amplitudes; give as many of both"
            )
        if not (
            np.isfinite(values).all() and (values > 0.0).all() and np.isfinite(errors).all() and (errors > 0.0).all()
        ):
            raise QuestionError(f"identify: {self.label}: amplitudes and errors must be finite and greater than zero")
        for name, given, allowed in (
            ("measure", self.measure, get_args(ResponseMeasure)),
            ("quantity", self.quantity, get_args(Motion)),
        ):
            if given not in allowed:
                raise QuestionError(
                    f"identify: {self.label}: {name}: given {given!r}; must be one of {', '.join(allowed)}"
                )
        unit = ("m", "m/s", "m/s^2")[get_args(Motion).index(self.quantity)]
        return Rows(self.label, "response", unit, values, errors * (values if self.logarithmic else 1.0), speeds)

    def predict(self, trial: Trial) -> Floats:
        """See :class:`Measurement`."""
        speeds = checked_speeds(np.asarray(self.speeds, np.float64), trial.bare, "identify")
        places = chosen_places(trial.machine, trial.bare, self.stations, "identify")
        if self.measure in ONE_PLACE and len(places.names) != 1:
            raise QuestionError(
                f"identify: {self.label}: measure {self.measure!r} is that of one station; given {', '.join(places.names)}"
            )
        load = load_of(trial.machine, trial.bare, None, None, "identify")
        rate = speeds[:, None] ** get_args(Motion).index(self.quantity)
        x, y = (rate * part for part in amplitudes(trial.bare, speeds, load, places))
        ellipses = whirl(x, y)
        if self.measure == "mean_of_greatest":
            return mean_of_greatest(ellipses)
        if self.measure == "greatest_mean":
            return greatest_mean(ellipses)
        single = {
            "semi_major": ellipses.semi_major,
            "forward": np.abs(ellipses.forward),
            "x": np.abs(x),
            "y": np.abs(y),
        }
        return np.asarray(single[self.measure][:, 0])

    def residual(self, predicted: Floats) -> Floats:
        """See :class:`Measurement`."""
        values, errors = np.asarray(self.amplitudes, np.float64), np.asarray(self.error, np.float64)
        if self.logarithmic:
            return np.asarray(np.log(predicted / values) / errors)
        return np.asarray((predicted - values) / errors)


def check_error(label: str, value: float, error: float) -> None:
    """A measured value is finite and its standard deviation greater than zero."""
    if not math.isfinite(value):
        raise QuestionError(f"identify: {label}: given {value!r}; must be a finite number")
    if not (math.isfinite(error) and error > 0.0):
        raise QuestionError(f"identify: {label}: error: given {error!r}; give a standard deviation greater than zero")


def _which(thing: str, wanted: MeasuredMode | MeasuredCriticalSpeed) -> str:
    if isinstance(wanted.order, bool) or not isinstance(wanted.order, int) or wanted.order < 1:
        raise QuestionError(f"identify: {thing}: order: given {wanted.order!r}; must be a whole number from 1")
    words = [thing if wanted.mode is None else f"{thing} {wanted.mode!r}", str(wanted.order)]
    if wanted.whirl is not None:
        if wanted.whirl not in get_args(WhirlWord):
            raise QuestionError(
                f"identify: {thing}: whirl: given {wanted.whirl!r}; must be forward, backward, mixed or straight"
            )
        words.append(wanted.whirl)
    return " ".join(words)


# One trial of a fit: a machine with its parameters, and what is computed of it only once.


class Trial:
    """A machine under trial; ``values`` are those of the free parameters by name."""

    def __init__(self, machine: Machine, values: dict[str, float]) -> None:
        self.machine = machine
        self.values = values
        self.runs: dict[Any, xr.Dataset] = {}  # that measurements of one run-up share
        self.motions = cache(self._motions)
        self.words = cache(self._words)
        self.critical = cache(self._critical)

    @cached_property
    def bare(self) -> LateralModel:
        """The rotor without balls."""
        return lateral_model(self.machine)

    @cached_property
    def loaded(self) -> LateralModel:
        """The rotor with the masses of the balls."""
        return with_ball_mass(self.machine, self.bare)

    @cached_property
    def axis(self) -> Places:
        """Places from end to end."""
        return along_axis(self.machine, self.bare)

    def model(self, balls: bool) -> LateralModel:
        """The rotor with the masses of the balls or without balls."""
        return self.loaded if balls else self.bare

    def _motions(self, speed: float, balls: bool) -> FreeMotions:
        return free_motions(self.model(balls), speed)

    def _words(self, speed: float, balls: bool) -> list[tuple[str, str]]:
        """Name and whirl direction of every mode."""
        motions, model = self.motions(speed, balls), self.model(balls)
        ellipses = ellipses_of(model, motions.vector, self.axis)
        names = mode_names(model, motions.vector, self.axis)
        ways = [whole_direction(Whirl(f, b)) for f, b in zip(ellipses.forward, ellipses.backward, strict=True)]
        return list(zip(names, ways, strict=True))

    def _critical(self, balls: bool, highest: float | None) -> tuple[np.ndarray, list[tuple[str, str]]]:
        """Critical speeds, undamped or (with a highest speed) damped, with name and whirl direction."""
        speeds = critical_speeds(self.machine, balls=balls, highest=highest, damped=highest is not None)
        words = list(zip(speeds["name"].values.tolist(), speeds["whirl"].values.tolist(), strict=True))
        return np.asarray(speeds["critical_speed"].values), words


def chosen(words: list[tuple[str, str]], order: int, whirl: str | None, mode: str | None) -> int | None:
    """The number of the ``order``-th entry with this whirl direction and all words of ``mode`` in its name."""
    wanted = set((mode or "").split())
    result = [i for i, (name, way) in enumerate(words) if whirl in (None, way) and wanted <= set(name.split())]
    return result[order - 1] if order <= len(result) else None
