"""Robust least squares within bounds, from one or several starts."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, Literal, NamedTuple, Protocol, get_args

import numpy as np
import xarray as xr
from scipy.optimize import least_squares
from scipy.stats import qmc

from autobalancer.arrays import Floats
from autobalancer.assembly.quantities import parameter_of, with_value_at
from autobalancer.assembly.rotors import lateral_model, rows_at, with_ball_mass
from autobalancer.assembly.rotors.lateral_model import LateralModel
from autobalancer.errors import QuestionError, UnitError, one_of
from autobalancer.machine import Machine
from autobalancer.machine.path import unit_at
from autobalancer.random_numbers import generator
from autobalancer.rotordynamics.campbell import critical_speeds
from autobalancer.rotordynamics.natural_modes import (
    FreeMotions,
    Places,
    Whirl,
    along_axis,
    checked_speeds,
    chosen_places,
    ellipses_of,
    free_motions,
    greatest_mean,
    mean_of_greatest,
    mode_names,
    whirl,
    whole_direction,
)
from autobalancer.rotordynamics.response import amplitudes, load_of
from autobalancer.units import shortened
from autobalancer.units.quantity import argument

# Free parameters: entries of a machine that a fit may change, alone or tied together.


Tie = Literal["value", "factor", "offset"]
Bounds = tuple[float, float]
DECADE = 10.0  # bounds of one sign further apart than this are searched by equal ratios


@dataclass(frozen=True)
class FreeParameter:
    """One unknown of a fit.

    Parameters
    ----------
    paths
        Path of an entry, as for :func:`~autobalancer.assembly.quantities.with_value_at`, or several tied paths.
    lower, upper
        Bounds in SI, or texts with a unit.
    tie
        What is free: the ``value`` of all entries, a ``factor`` on their values in the machine, or an ``offset`` added
        to them.
    name
        Name in results; by default the first path.
    start
        Start value of the fit; by default that of the machine (the first path), 1 for a factor, 0 for an offset.
    """

    paths: str | Sequence[str]
    lower: float | str = -math.inf
    upper: float | str = math.inf
    tie: Tie = "value"
    name: str = ""
    start: float | str | None = None

    @property
    def first(self) -> str:
        """The first path."""
        return self.paths if isinstance(self.paths, str) else next(iter(self.paths), "")


@dataclass(frozen=True)
class Unknown:
    """A free parameter read against its machine: everything a number, in SI."""

    name: str
    paths: tuple[str, ...]
    tie: Tie
    origins: tuple[float, ...]  # of the entries
    lower: float
    upper: float
    start: float
    scale: float  # of one step of the search variable; 0 where it is a logarithm
    unit: str

    def inner(self, value: float) -> float:
        """The search variable of a value."""
        return math.log(abs(value)) if self.scale == 0.0 else value / self.scale

    def outer(self, variable: float) -> float:
        """The value of a search variable."""
        value = math.copysign(math.exp(variable), self.start) if self.scale == 0.0 else variable * self.scale
        return min(max(value, self.lower), self.upper)

    @property
    def inner_bounds(self) -> tuple[float, float]:
        """Bounds of the search variable, ascending."""
        low, high = sorted((self.inner(self.lower), self.inner(self.upper)))
        return low, high

    def slope(self, value: float) -> float:
        """d value / d variable."""
        return value if self.scale == 0.0 else self.scale

    def applied(self, machine: Machine, value: float) -> Machine:
        """The machine with this value."""
        for path, origin in zip(self.paths, self.origins, strict=True):
            entry = {"value": value, "factor": origin * value, "offset": origin + value}[self.tie]
            machine = with_value_at(machine, path, entry)
        return machine


def unknowns(machine: Machine, free: Any) -> list[Unknown]:
    """Read free parameters: :class:`FreeParameter` entries, or a mapping from paths to (lower, upper).

    Raises
    ------
    QuestionError
        If there is none, a path does not lead to a number, bounds do not ascend or leave out the start, or an entry is
        free twice.
    """
    if isinstance(free, Mapping):
        free = [FreeParameter(path, *bounds) for path, bounds in free.items()]
    unknowns = [_read(machine, entry) for entry in free]
    if not unknowns:
        raise QuestionError("identify: free: given none; name at least one parameter")
    for kind, given in (("name", [u.name for u in unknowns]), ("path", [p for u in unknowns for p in u.paths])):
        twice = sorted({entry for entry in given if given.count(entry) > 1})
        if twice:
            raise QuestionError(f"identify: free: {kind} {twice[0]!r} is given twice; an entry has one unknown only")
    return unknowns


def _read(machine: Machine, free: FreeParameter) -> Unknown:
    single = isinstance(free.paths, str) or not isinstance(free.paths, Iterable)
    paths: tuple[Any, ...] = (free.paths,) if single else tuple(free.paths)
    if not paths:
        raise QuestionError("identify: free: a parameter has no path; give at least one")
    if not all(isinstance(path, str) for path in paths):
        raise QuestionError(
            f"identify: free: paths: given {shortened(list(paths))}; must be texts such as 'rotor.damping'"
        )
    name = free.name or paths[0]
    one_of(f"identify: {name}: tie", free.tie, *get_args(Tie))
    origins = tuple(parameter_of(machine, path) for path in paths)
    unit = "" if free.tie == "factor" else unit_at(paths[0])
    lower, upper = (_number(value, unit, name) for value in (free.lower, free.upper))
    default = {"value": origins[0], "factor": 1.0, "offset": 0.0}[free.tie]
    start = default if free.start is None else _number(free.start, unit, name)
    if not lower < upper:
        raise QuestionError(f"identify: {name}: bounds: given {lower:g} to {upper:g} {unit}; must ascend")
    if not lower <= start <= upper:
        raise QuestionError(
            f"identify: {name}: the start {start:g} {unit} is outside the bounds {lower:g} to {upper:g}; "
            "widen them, or give another 'start'"
        )
    # the size of a step; a logarithm where bounds of one sign are far apart
    near, far = sorted((abs(lower), abs(upper)))
    width, scale = upper - lower, 0.0
    if not (lower * upper > 0.0 and math.isfinite(far) and far > DECADE * near):
        scale = min(abs(start) or (0.5 * width if math.isfinite(width) else abs(origins[0])), width)
        if scale == 0.0:
            raise QuestionError(f"identify: {name}: it starts at zero and has no bounds; give bounds, or a 'start'")
    return Unknown(name, paths, free.tie, origins, lower, upper, start, scale, unit)


def _number(value: float | str, unit: str, name: str) -> float:
    try:
        number = argument(f"identify: {name}", value, unit)
    except UnitError as reason:
        raise QuestionError(str(reason)) from None
    if math.isnan(number):
        raise QuestionError(f"identify: {name}: given nan; give a number")
    return number


# What was measured, each with its standard deviation, and what a machine predicts for it.


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
        if not math.isfinite(self.value):
            raise QuestionError(f"identify: {label}: given {self.value!r}; must be a finite number")
        if not (math.isfinite(self.error) and self.error > 0.0):
            raise QuestionError(
                f"identify: {label}: error: given {self.error!r}; give a standard deviation greater than zero"
            )
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
        one_of("identify: mode: quantity", self.quantity, *get_args(ModeQuantity))
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
        one_of("identify: stiffness: direction", self.direction, "x", "y")
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
        one_of(f"identify: {self.label}: measure", self.measure, *get_args(ResponseMeasure))
        one_of(f"identify: {self.label}: quantity", self.quantity, *get_args(Motion))
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


def _which(thing: str, wanted: MeasuredMode | MeasuredCriticalSpeed) -> str:
    if isinstance(wanted.order, bool) or not isinstance(wanted.order, int) or wanted.order < 1:
        raise QuestionError(f"identify: {thing}: order: given {wanted.order!r}; must be a whole number from 1")
    words = [thing if wanted.mode is None else f"{thing} {wanted.mode!r}", str(wanted.order)]
    if wanted.whirl is not None:
        one_of(f"identify: {thing}: whirl", wanted.whirl, *get_args(WhirlWord))
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


Loss = Literal["linear", "soft_l1", "huber", "cauchy"]
SAME = 1e-6  # costs closer than this, relative, count as one optimum
Residuals = Callable[[Floats], Floats]


class Search(NamedTuple):
    """How a search takes differences, and when it ends.

    ``step`` is that of a search variable: the error of ``central`` differences is about its square. The last differences are
    central; what of them is below the share ``error`` is not real. The search ends where steps and gains are below ``accuracy``.
    """

    step: float = 1e-5
    accuracy: float = 1e-14
    central: bool = True
    error: float = 1e-7


EXACT = Search()


@dataclass(frozen=True)
class Fit:
    """The best search of all starts."""

    variables: Floats
    cost: float
    jacobian: Floats  # of the residuals, without the weights of the loss
    outcome: str
    evaluations: int
    agreeing: int  # starts that ended at the same cost
    starts: int


def best_fit(
    residuals: Residuals,
    start: Floats,
    low: Floats,
    high: Floats,
    loss: Loss,
    loss_scale: float,
    starts: int,
    seed: int,
    how: Search = EXACT,
) -> Fit:
    """Search from ``start`` and from ``starts - 1`` points spread within the bounds.

    Raises
    ------
    QuestionError
        If no start gives finite residuals, or several starts are wanted without bounds.
    """
    points = [start]
    if starts > 1:
        if not (np.isfinite(low).all() and np.isfinite(high).all()):
            raise QuestionError("identify: several starts need bounds on both sides of every free parameter; give them")
        spread = qmc.LatinHypercube(start.size, rng=generator(seed)).random(starts - 1)
        points += list(low + spread * (high - low))
    best_fit: list[Fit] = []
    for point in points:
        inside = np.clip(point, low, high)
        if not np.isfinite(residuals(inside)).all():
            continue
        best_fit.append(_search(residuals, inside, low, high, loss, loss_scale, how))
    if not best_fit:
        raise QuestionError(
            "identify: at the start the machine lacks something that was measured (a mode, a critical speed); "
            "start closer, select by order instead of name, or give more starts"
        )
    best = min(best_fit, key=lambda fit: fit.cost)
    slack = SAME * best.cost + 1e-12
    agreeing = sum(fit.cost <= best.cost + slack for fit in best_fit)
    return Fit(
        best.variables, best.cost, best.jacobian, best.outcome, sum(f.evaluations for f in best_fit), agreeing, starts
    )


def _search(
    residuals: Residuals, start: Floats, low: Floats, high: Floats, loss: Loss, loss_scale: float, how: Search
) -> Fit:
    last: dict[bytes, Floats] = {}  # the search asks again at the first point

    def jacobian(point: Floats) -> Floats:
        key = point.tobytes()
        if key not in last:
            result = differences(residuals, point, low, high, how)
            last.clear()
            last[key] = result
        return last[key]

    # slopes that are usable at the start scale the parameters
    first = jacobian(start)
    regular = np.isfinite(first).all() and np.abs(first).sum(axis=0).all()
    result = least_squares(
        residuals,
        start,
        jac=jacobian,
        bounds=(low, high),
        method="trf",
        loss=loss,
        f_scale=loss_scale,
        x_scale="jac" if regular else 1.0,
        ftol=how.accuracy,
        xtol=how.accuracy,
        gtol=how.accuracy,
        max_nfev=300,
    )
    # the answer, exactly on its bounds where it is as good as there
    point = np.asarray(result.x)
    for edge in (low, high):  # the search stays a hair inside its bounds
        point = np.where(np.abs(point - edge) <= 1e-9 * (1.0 + np.abs(point)), edge, point)
    if not np.isfinite(residuals(point)).all():
        point = np.asarray(result.x)
    outcome = "converged" if result.status > 0 else "stopped after 300 steps; give more starts or tighter bounds"
    last_one = differences(residuals, point, low, high, how._replace(central=True))
    return Fit(point, float(result.cost), last_one, outcome, int(result.nfev), 1, 1)


def differences(residuals: Residuals, point: Floats, low: Floats, high: Floats, how: Search = EXACT) -> Floats:
    """Jacobian by central differences; one-sided at a bound, where one side has no answer, or if asked."""
    here = residuals(point)
    columns = []
    for i in range(point.size):
        sides = []
        for sign in (1.0, -1.0):
            moved = point.copy()
            moved[i] += sign * how.step
            inside = low[i] <= moved[i] <= high[i]
            value = residuals(moved) if inside else here
            sides.append((moved[i] - point[i], value) if inside and np.isfinite(value).all() else (0.0, here))
            if sides[0][0] and not how.central:
                sides.append((0.0, here))
                break
        (ahead, above), (behind, below) = sides
        columns.append((above - below) / (ahead - behind) if ahead != behind else np.zeros_like(here))
    return np.asarray(np.array(columns).T)


def weights(residuals: Floats, loss: Loss, loss_scale: float) -> Floats:
    """How much a residual counts: the slope of the loss, 1 without outliers."""
    square = (residuals / loss_scale) ** 2
    if loss == "soft_l1":
        return np.asarray((1.0 + square) ** -0.5)
    if loss == "huber":
        return np.asarray(np.where(square <= 1.0, 1.0, 1.0 / np.sqrt(np.maximum(square, 1.0))))
    if loss == "cauchy":
        return np.asarray(1.0 / (1.0 + square))
    return np.ones_like(residuals)
