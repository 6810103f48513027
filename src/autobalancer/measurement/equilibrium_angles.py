"""The equilibrium angle of one ball in a slowly turned race."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from autobalancer.arrays import Floats
from autobalancer.assembly.quantities import with_value_at
from autobalancer.catalog.product_tables import ROOM, fluid
from autobalancer.catalog.resolve import Ball, resolve
from autobalancer.errors import CatalogError, QuestionError, ResultError
from autobalancer.files.machine_file import balls_in_races
from autobalancer.files.text_files import Table, read_table
from autobalancer.laws.drag_coefficient import DragCurve, DragLaw, ShearedDragCurve, linear_drag_law
from autobalancer.machine import Machine
from autobalancer.random_numbers import generator
from autobalancer.results.answers.answer import Labeled, provenance
from autobalancer.roots import least
from autobalancer.safe_file import as_path
from autobalancer.simulation.record import SampleTimes
from autobalancer.simulation.run import simulate_races
from autobalancer.units import argument, field_arguments, texts_argument

# One ball in a slowly turned horizontal race: the angle at which it stands still in space, and what that says of its
# drag.
#
# The fluid and the race carry the ball up by the angle s from the lowest point (Spannan 2021, section 6.1.4):
#
#     m_eff g sin s = F_drag(W eps) + mu F_N,    F_N = m_eff g cos s - P,    P = rho V W^2 eps (1 + c)
#
# P is the inward force of the pressure of the rotating fluid on a ball at rest, c its virtual mass; (6.6) leaves it
# out, which matters at drag coefficients below one: P over m_eff g is (8/3) (r_b/eps) (1 + c)/c_d at 90 degrees.


GRAVITY = 9.80665


@dataclass(frozen=True)
class TurnedRace:
    """A ball in its race: ``diameter`` and ``orbit_radius`` in m, ``mass`` in kg, density (kg/m^3) and kinematic viscosity
    (m^2/s) of the fluid. ``pressure`` is 1 + c of the inward force above; 0 leaves it out, as (6.6) does.
    """

    diameter: float
    mass: float
    orbit_radius: float
    fluid_density: float
    viscosity: float
    pressure: float = 0.0
    gravity: float = GRAVITY

    def __post_init__(self) -> None:
        field_arguments(
            self, diameter="m", mass="kg", orbit_radius="m", fluid_density="kg/m^3", viscosity="m^2/s", gravity="m/s^2"
        )
        if self.weight <= 0.0:
            raise QuestionError(
                f"the ball floats: its mass of {self.mass:g} kg is not more than that of the fluid it displaces"
            )

    @property
    def volume(self) -> float:
        """Of the ball, m^3."""
        return math.pi / 6.0 * self.diameter**3

    @property
    def weight(self) -> float:
        """Less buoyancy, N."""
        return (self.mass - self.fluid_density * self.volume) * self.gravity

    def inward(self, speed: ArrayLike) -> Floats:
        """P, N, at rotor speeds in rad/s."""
        return np.asarray(self.fluid_density * self.volume * self.orbit_radius * self.pressure * np.square(speed))

    def reynolds(self, speed: ArrayLike) -> Floats:
        """W eps d_b / nu."""
        return np.asarray(np.abs(np.asarray(speed, dtype=float)) * self.orbit_radius * self.diameter / self.viscosity)

    def drag_scale(self, speed: ArrayLike) -> Floats:
        """Drag coefficient for a drag as great as the weight less buoyancy."""
        dynamic = 0.5 * self.fluid_density * np.square(np.asarray(speed, dtype=float) * self.orbit_radius)
        return np.asarray(self.weight / (dynamic * math.pi / 4.0 * self.diameter**2))


def equilibrium_angles(race: TurnedRace, law: DragLaw, speeds: ArrayLike, rolling: float = 0.0) -> Floats:
    """Angles from the lowest point, rad, of the shape of ``speeds`` (rad/s, positive), of a ball in ``race``.

    Its drag follows ``law``, its rolling resistance is ``rolling`` (arm over ball radius).

    nan where none up to 90 degrees holds the ball: from there on it is carried around, or leaves the wall.
    """
    speeds = texts_argument("speeds", speeds, "rad/s")
    w = np.asarray(speeds, dtype=float)
    curve = DragCurve(law, race.fluid_density, race.viscosity, race.diameter)
    force = curve.force(w * race.orbit_radius) - rolling * race.inward(w)
    # sin s - mu cos s = f has the solution s = arcsin(f / sqrt(1 + mu^2)) + arctan mu while the wall presses
    share = force / (race.weight * math.hypot(1.0, rolling))
    with np.errstate(invalid="ignore"):
        angle = np.arcsin(share) + math.atan(rolling)
        pressed = race.weight * np.cos(angle) > race.inward(w)
        free = np.arcsin(curve.force(w * race.orbit_radius) / race.weight)
    angle = np.where(pressed, angle, free)
    return np.asarray(np.where(angle <= 0.5 * math.pi, angle, np.nan))


def drag_coefficients(
    race: TurnedRace,
    speeds: ArrayLike,
    angles: ArrayLike,
    rolling: float = 0.0,
) -> Floats:
    """c_d from measured ``angles`` (rad, up to pi/2) at ``speeds`` (rad/s) of the same shape, (6.6).

    ``rolling`` is the rolling resistance (arm over ball radius); with the force P if ``race.pressure`` is not zero.
    """
    speeds = texts_argument("speeds", speeds, "rad/s")
    angles = texts_argument("angles", angles, "rad")
    w, s = np.asarray(speeds, dtype=float), np.asarray(angles, dtype=float)
    if np.any(s > 0.5 * math.pi) or np.any(w <= 0.0):
        raise QuestionError(
            f"given angles up to {math.degrees(np.max(s)):.4g} deg and speeds from {np.min(w):.4g} rad/s; angles must be at most "
            "90 deg, speeds greater than zero; leave out what is beyond"
        )
    normal = np.maximum(np.cos(s) - race.inward(w) / race.weight, 0.0)
    return np.asarray(race.drag_scale(w) * (np.sin(s) - rolling * normal))


# What measured equilibrium angles say: drag coefficients over the Reynolds number, and the coefficient of friction.


WAYS = ("left out", "included")
MEANINGS = {
    "series": ("series", ""),
    "pressure_force": ("pressure force of the turning fluid", ""),
    "speed": ("rotor speed", "rad/s"),
    "measured_angle": ("angle from the lowest point, measured", "rad"),
    "angle": ("angle from the lowest point, by the drag law of the machine", "rad"),
    "reynolds": ("Reynolds number", "1"),
    "drag_coefficient": ("drag coefficient", "1"),
    "law_coefficient": ("drag coefficient of the law of the machine", "1"),
    "rolling_resistance": ("coefficient of rolling resistance", "1"),
    "rolling_resistance_deviation": ("its standard deviation", "1"),
}


def evaluate_angles(
    machine: Machine | str | Path,
    series: Sequence[AngleSeries],
    *,
    rolling: float | None = None,
    resamples: int = 100,
    seed: int = 0,
) -> xr.Dataset:
    """Drag coefficients by (6.6) of Spannan (2021), with and without the force P that it neglects.

    Parameters
    ----------
    machine
        With the ball and the race of the experiment: one ball on a horizontal axis.
    series
        Measured speeds and angles, :func:`~autobalancer.measurement.equilibrium_angles.load_angle_series`.
    rolling
        Coefficient of rolling resistance; by default the one for which overlapping series agree, else that of the machine.
    resamples
        Number of resamples of the points of each series, for the standard deviation of a fitted coefficient.
    seed
        Of the resamples.

    Returns
    -------
    xarray.Dataset
        Over ``point``: ``series``, ``speed``, ``measured_angle``, ``reynolds``, ``law_coefficient``; over ``pressure_force``
        (left out, included), too: ``drag_coefficient`` and the ``angle`` by the law of the machine. Over ``pressure_force``:
        ``rolling_resistance`` and ``rolling_resistance_deviation``, nan where nothing was fitted. The attribute
        ``rolling_resistance_from`` says where the coefficient comes from: fitted, given or machine.

    Raises
    ------
    QuestionError
        If the machine does not fit, there is no series, or an angle is above 90 degrees.
    """
    given = angle_machine(machine)
    if not series:
        raise QuestionError("equilibrium angle: no series to evaluate")
    if rolling is not None and not 0.0 <= rolling < 1.0:
        raise QuestionError(f"rolling: given {rolling:g}; a coefficient of rolling resistance is from 0 to below 1")
    # all series together; where their Reynolds numbers overlap, rolling resistance can be told from drag
    parts = [(angle_series.race(given.race), angle_series.speeds, angle_series.angles) for angle_series in series]
    source = "given" if rolling is not None else "fitted" if overlaps(parts) else "machine"
    speeds, angles = (np.concatenate([part[i] for part in parts]) for i in (1, 2))
    reynolds = np.concatenate([race.reynolds(w) for race, w, _ in parts])
    items, stands, coefficients, deviations = [], [], [], []
    # without and with the force by the pressure in the fluid
    for pressure in (0.0, given.pressure):
        turned = [(replace(race, pressure=pressure), w, s) for race, w, s in parts]
        value = given.rolling if rolling is None else rolling
        deviation = float("nan")
        if source == "fitted":
            value = fit_rolling_resistance(turned)
            deviation = rolling_resistance_deviation(turned, resamples=resamples, seed=seed)
        coefficients.append(value)
        deviations.append(deviation)
        items.append(np.concatenate([drag_coefficients(race, w, s, value) for race, w, s in turned]))
        stands.append(np.concatenate([equilibrium_angles(race, given.law, w, value) for race, w, _ in turned]))
    each = ("pressure_force", "point")
    data = {
        "measured_angle": ("point", angles),
        "reynolds": ("point", reynolds),
        "law_coefficient": ("point", given.law.coefficient(reynolds)),
        "drag_coefficient": (each, np.array(items)),
        "angle": (each, np.array(stands)),
        "rolling_resistance": ("pressure_force", coefficients),
        "rolling_resistance_deviation": ("pressure_force", deviations),
    }
    names = np.repeat(
        [angle_series.name for angle_series in series], [np.size(angle_series.speeds) for angle_series in series]
    )
    coordinates = {"series": ("point", names), "speed": ("point", speeds), "pressure_force": list(WAYS)}
    answer = xr.Dataset(data, coordinates)
    for name in answer.variables:
        answer[name].attrs = dict(zip(("long_name", "units"), MEANINGS[str(name)], strict=True))
    title = f"Drag from equilibrium angles: {given.machine.name}"
    answer.attrs = {"title": title, **provenance(), **attributes(given), "rolling_resistance_from": source}
    return Labeled.of(answer)


# The coefficient of rolling resistance with which measured series of equilibrium angles agree.
#
# Drag coefficients of two fluids at one Reynolds number must be equal. At the left end of a series angles are small
# and ruled by friction, at the right end of the next thicker fluid they are large and ruled by drag (Spannan 2021,
# section 6.1.4).


Series = Sequence[tuple[TurnedRace, ArrayLike, ArrayLike]]
LARGEST = 0.3  # coefficient in a fit
POINTS = 9  # Reynolds numbers at which two series are compared
FARTHEST = 3.0  # greatest logarithm of a ratio that counts, so that no single point rules
PASSES = 3  # one with equal weights, the others with those of the coefficient found


def overlaps(series: Series) -> bool:
    """Whether any two series share Reynolds numbers."""
    return bool(_Overlap(series).pairs)


def fit_rolling_resistance(series: Series) -> float:
    """The coefficient for which series in different fluids agree where their Reynolds numbers overlap.

    Least squares of the logarithms of their ratios, weighted for an equal error of all angles: where the drag is a small
    difference of weight and friction, its logarithm is uncertain.

    Parameters
    ----------
    series
        Race, speeds (rad/s) and angles (rad) of each.

    Raises
    ------
    QuestionError
        If no two series overlap, an angle is above 90 degrees, or a speed not above zero.
    """
    overlap = _Overlap(series)
    if not overlap.pairs:
        raise QuestionError("no two series have overlapping Reynolds numbers; measure fluids of more similar viscosity")
    weights = [np.ones(POINTS)] * len(overlap.pairs)
    trial = np.linspace(0.0, LARGEST, 61)
    best = int(np.argmin([overlap.mismatch(mu, weights) for mu in trial]))
    rolling_resistance, reach = float(trial[best]), float(trial[1])
    for _ in range(PASSES):
        span = max(rolling_resistance - reach, 0.0), min(rolling_resistance + reach, LARGEST)
        rolling_resistance, _ = least(partial(overlap.mismatch, weights=weights), *span, xtol=1e-8)
        weights = overlap.weights(rolling_resistance)
    return rolling_resistance


def rolling_resistance_deviation(series: Series, *, resamples: int = 100, seed: int = 0) -> float:
    """Standard deviation of the fitted coefficient from the scatter of the points: a bootstrap over the points of each series.

    ``seed`` is that of the ``resamples``.

    Raises
    ------
    QuestionError
        As :func:`fit_rolling_resistance`; or if there are fewer than two ``resamples``.
    """
    if resamples < 2:
        raise QuestionError(f"resamples: given {resamples}; give at least 2, such as 100")
    fit_rolling_resistance(series)
    random = generator(seed)
    deviation = []
    for _ in range(resamples):
        drawn = []
        for race, speeds, angles in series:
            count = np.size(np.asarray(speeds))
            picked = np.unique(random.integers(0, count, count))
            drawn.append((race, np.asarray(speeds)[picked], np.asarray(angles)[picked]))
        if _Overlap(drawn).pairs:
            deviation.append(fit_rolling_resistance(drawn))
    return float(np.std(deviation, ddof=1)) if len(deviation) > 1 else float("nan")


class _Overlap:
    """Series as logarithms, in the order of their Reynolds numbers, and where which of them overlap."""

    def __init__(self, series: Series) -> None:
        self.x: list[Floats] = []
        self.free: list[Floats] = []  # c_d without friction
        self.rubbed: list[Floats] = []  # what a coefficient of one takes from it
        self.slope: list[tuple[Floats, Floats]] = []  # of both over the angle
        for race, speeds, angles in series:
            re, s = race.reynolds(speeds), np.asarray(angles, dtype=float)
            order = np.argsort(re)
            free = drag_coefficients(race, speeds, angles)
            rubbed = free - drag_coefficients(race, speeds, angles, 1.0)
            scale = race.drag_scale(speeds)
            self.x.append(np.log(re)[order])
            self.free.append(free[order])
            self.rubbed.append(rubbed[order])
            pressed = rubbed > 0.0
            self.slope.append(((scale * np.cos(s))[order], np.where(pressed, scale * np.sin(s), 0.0)[order]))
        self.pairs = []
        for i, j in combinations(range(len(self.x)), 2):
            low, high = max(self.x[i][0], self.x[j][0]), min(self.x[i][-1], self.x[j][-1])
            if low < high:
                self.pairs.append((i, j, np.linspace(low, high, POINTS)))

    def mismatch(self, rolling: float, weights: list[Floats]) -> float:
        """Weighted mean square of the logarithms of the ratios."""
        logs = [np.log(np.maximum(a - rolling * b, 1e-12)) for a, b in zip(self.free, self.rubbed, strict=True)]
        total = 0.0
        for (i, j, at), weight in zip(self.pairs, weights, strict=True):
            gap = np.interp(at, self.x[i], logs[i]) - np.interp(at, self.x[j], logs[j])
            total += float(weight @ np.clip(gap, -FARTHEST, FARTHEST) ** 2)
        return total

    def weights(self, rolling: float) -> list[Floats]:
        """One over the variance that equal errors of the angles would cause in each ratio."""
        spread = []
        for a, b, (da, db) in zip(self.free, self.rubbed, self.slope, strict=True):
            left = np.maximum(a - rolling * b, 1e-3 * np.maximum(a, 1e-12))
            spread.append(((da + rolling * db) / left) ** 2)
        return [
            1.0 / (np.interp(at, self.x[i], spread[i]) + np.interp(at, self.x[j], spread[j])) for i, j, at in self.pairs
        ]


# The angle at which the ball of a slowly turned machine stands, against the speed: by statics and by simulation.


STEEPEST = math.radians(85.0)  # end of the speeds that are taken where none are given
COUNT, SLOWEST = 60, 0.02  # how many, and the first as a share of the last
DURATION = 300.0  # s, of the run-up in the source
CURVE_MEANINGS = {
    "angle": ("angle from the lowest point, statics", "rad"),
    "angle_with_pressure": ("angle from the lowest point, statics with the pressure of the turning fluid", "rad"),
    "simulated_angle": ("angle from the lowest point, simulated", "rad"),
    "reynolds": ("Reynolds number", "1"),
    "drag_coefficient": ("drag coefficient of the law", "1"),
    "speed": ("rotor speed", "rad/s"),
}


@dataclass(frozen=True)
class AngleMachine:
    """What the experiment needs of a machine; ``pressure`` is 1 + c of the force that (6.6) leaves out."""

    machine: Machine
    race: TurnedRace
    law: DragLaw
    rolling: float
    pressure: float
    path: str  # of the balls

    @property
    def pressed(self) -> TurnedRace:
        """The race with the pressure of the turning fluid."""
        return replace(self.race, pressure=self.pressure)


def angle_machine(machine: Machine | str | Path) -> AngleMachine:
    """Ball, race, fluid, drag law and rolling resistance of a machine with one ball on a horizontal axis.

    Raises
    ------
    QuestionError
        If the axis is vertical, there is not exactly one ball, no fluid or no drag, or the race is not round.
    """
    machine = balls_in_races(machine)
    balls = resolve(machine)
    if machine.axis != "horizontal":
        raise QuestionError(
            f"equilibrium angle: the axis is {machine.axis}; the experiment needs a horizontal one: axis = 'horizontal'"
        )
    if len(balls) != 1:
        raise QuestionError(f"equilibrium angle: the machine has {len(balls)} balls; the experiment needs exactly one")
    ball = balls[0]
    race = machine.balancers[ball.balancer].races[ball.race]
    where = f"balancers[{ball.balancer + 1}].races[{ball.race + 1}]"
    if ball.body != "ball":
        raise QuestionError(f"equilibrium angle: {where} has a {ball.body}; the experiment is one with a ball")
    if ball.fluid_viscosity <= 0.0 or ball.diameter <= 0.0:
        raise QuestionError(f"equilibrium angle: {where} needs a fluid, and its ball a size")
    if isinstance(ball.drag_curve, ShearedDragCurve):
        raise QuestionError(
            f"equilibrium angle: {where}.fluid.shear: a drag coefficient over the Reynolds number needs a constant viscosity; "
            "leave 'shear' out"
        )
    if ball.drag <= 0.0:
        raise QuestionError(f"equilibrium angle: {where}.drag: the ball has no drag; give a drag law")
    if ball.eccentricity or race.harmonics or race.roundness is not None:
        raise QuestionError(
            f"equilibrium angle: {where} is not circular and centered on the axis, which the balance of forces requires"
        )
    turned = TurnedRace(
        ball.diameter,
        ball.mass,
        ball.orbit_radius,
        ball.fluid_density,
        ball.fluid_viscosity,
        0.0,
        float(machine.gravity),
    )
    rolling = float(race.friction.rolling_resistance) if race.friction is not None else 0.0
    return AngleMachine(machine, turned, _law(ball), rolling, 1.0 + ball.virtual_mass, f"{where}.balls[1]")


def _law(ball: Ball) -> DragLaw:
    if ball.drag_curve is not None:
        return ball.drag_curve.law
    viscous = math.pi / 8.0 * ball.fluid_density * ball.fluid_viscosity * ball.diameter
    return linear_drag_law(ball.drag / (viscous * ball.orbit_radius**2), "linear range of the drag law of the machine")


def equilibrium_angle(
    machine: Machine | str | Path,
    speeds: ArrayLike | None = None,
    *,
    simulation: bool = False,
    duration: float | str = DURATION,
) -> xr.Dataset:
    """The angle of the ball from the lowest point over the speed, with Reynolds number and drag coefficient.

    Parameters
    ----------
    machine
        With one ball on a horizontal axis; its drive is ignored.
    speeds
        rad/s, ascending from above zero; by default up to the speed at which the ball rests at 85 degrees.
    simulation
        Whether to simulate as well: the rotor is brought from the first to the last speed in ``duration`` (s), so slowly that
        the ball nearly stands at any time, and follows late only where the angle grows steeply near 90 degrees.

    Returns
    -------
    xarray.Dataset
        ``angle`` and ``angle_with_pressure`` by statics, rad, nan where none up to 90 degrees holds the ball;
        ``simulated_angle`` if asked for; ``reynolds`` and ``drag_coefficient`` over ``speed``.

    Raises
    ------
    QuestionError
        If the machine does not fit (:func:`angle_machine`), or the speeds or the duration are not as said.
    """
    speeds = texts_argument("speeds", speeds, "rad/s")
    duration = argument("duration", duration, "s")
    given = angle_machine(machine)
    w = _speeds(given) if speeds is None else np.atleast_1d(np.asarray(speeds, dtype=float))
    if w.size == 0 or not (w[0] > 0.0 and (np.diff(w) > 0.0).all()):
        raise QuestionError("equilibrium angle: speeds must ascend from above zero")
    data = {
        "angle": equilibrium_angles(given.race, given.law, w, given.rolling),
        "angle_with_pressure": equilibrium_angles(given.pressed, given.law, w, given.rolling),
        "reynolds": given.race.reynolds(w),
        "drag_coefficient": given.law.coefficient(given.race.reynolds(w)),
    }
    if simulation:
        data["simulated_angle"] = _simulated(given, w, duration, float(data["angle"][0]))
    dataset = xr.Dataset({name: ("speed", values) for name, values in data.items()}, {"speed": w})
    for name in dataset.variables:
        dataset[name].attrs = dict(zip(("long_name", "units"), CURVE_MEANINGS[str(name)], strict=True))
    dataset.attrs = {"title": f"Equilibrium angle: {given.machine.name}", **provenance(), **attributes(given)}
    return Labeled.of(dataset)


def attributes(argument: AngleMachine) -> dict[str, str | float]:
    """What a result says of its machine, SI."""
    return {
        "machine_name": argument.machine.name,
        "drag_law": argument.law.name,
        "drag_source": argument.law.source,
        "rolling_resistance": argument.rolling,
        "pressure": argument.pressure,
        "fluid_density": argument.race.fluid_density,
        "viscosity": argument.race.viscosity,
    }


def _speeds(argument: AngleMachine) -> Floats:
    grid = np.geomspace(1e-4, 1e4, 8001)
    held = equilibrium_angles(argument.race, argument.law, grid, argument.rolling) < STEEPEST
    if not held[0] or held[-1]:
        raise QuestionError("equilibrium angle: no speed from 1e-4 to 1e4 rad/s holds the ball at 85 deg; give speeds")
    top = float(grid[np.argmin(held)])
    return np.linspace(SLOWEST * top, top, COUNT)


def _simulated(argument: AngleMachine, w: Floats, duration: float, first: float) -> Floats:
    if w.size < 2 or not duration > 0.0:
        raise QuestionError("equilibrium angle: a simulation needs two speeds or more, and a duration above zero")
    if not math.isfinite(first):
        raise QuestionError(
            f"equilibrium angle: at {w[0]:.4g} rad/s the ball has no equilibrium; start the simulation at a lower speed"
        )
    machine = argument.machine
    for path, value in (
        ("start.speed", 0.0),
        ("drive", {"kind": "speed", "profile": {"kind": "ramp", "start": w[0], "end": w[-1], "duration": duration}}),
        (f"{argument.path}.start_angles", [first - 0.5 * math.pi]),
        (f"{argument.path}.start_speeds", [-w[0]]),
    ):
        machine = with_value_at(machine, path, value)
    times = (w - w[0]) / (w[-1] - w[0]) * duration
    run = simulate_races(machine, duration=duration, save=SampleTimes(times.tolist()))
    angle = (run["rotor_angle"] + run["ball_angle_in_rotor"][:, 0]).values + 0.5 * math.pi
    return np.where(angle <= 0.5 * math.pi, angle, np.nan)


# Measured equilibrium angles from a table, several fluids in one.


EXAMPLE = "fluid, density [kg/m^3], viscosity [mm^2/s], speed [rpm], angle [deg]"


@dataclass(frozen=True)
class AngleSeries:
    """Speeds (rad/s) and angles from the lowest point (rad) in one fluid, kg/m^3 and m^2/s; no fluid is that of the machine."""

    name: str
    speeds: Floats
    angles: Floats
    fluid_density: float = 0.0
    viscosity: float = 0.0

    def race(self, race: TurnedRace) -> TurnedRace:
        """The ball and its race in this fluid."""
        return replace(race, fluid_density=self.fluid_density, viscosity=self.viscosity) if self.viscosity else race


def load_angle_series(path: str | Path) -> list[AngleSeries]:
    """Read a table of measured equilibrium angles.

    Parameters
    ----------
    path
        A table with the columns ``speed`` and ``angle``. Rows in the same fluid are one series. It is described by the
        columns ``density`` and ``viscosity``, and perhaps named by ``fluid``; else it is that of the catalog with this name,
        at the ``temperature`` of the row or 25 degC. Without any of these columns it is the fluid of the machine.

    Returns
    -------
    list
        Series in the order in which they begin.

    Raises
    ------
    ResultError
        If the file, a column, a unit or a number is missing or cannot be read, or a fluid is unknown or ambiguous.
    """
    table = read_table(as_path(path), EXAMPLE)
    speeds, angles = table.numbers("speed", "rad/s"), table.numbers("angle", "rad")
    described = [name for name in ("density", "viscosity") if name in table.heads]
    if len(described) == 1:
        raise ResultError(
            f"{table.place}: column {described[0]!r} alone describes no fluid; give density and viscosity"
        )
    if "fluid" not in table.heads and not described:
        return [AngleSeries("fluid of the machine", speeds, angles)]
    densities, viscosities = _fluids(table) if not described else (
        table.numbers("density", "kg/m^3"), table.numbers("viscosity", "m^2/s")
    )  # fmt: skip
    for column, what in ((densities, "density"), (viscosities, "viscosity")):
        if not (column > 0.0).all():
            raise ResultError(f"{table.place}: column {what!r} holds {column.min():g}; it must be above zero")
    names = table.texts("fluid") if "fluid" in table.heads else ["fluid"] * speeds.size
    keys = list(zip(names, densities.tolist(), viscosities.tolist(), strict=True))
    angle_series = []
    for key in dict.fromkeys(keys):
        rows = np.flatnonzero([other == key for other in keys])
        alone = sum(key[0] == name for name, *_ in dict.fromkeys(keys)) == 1
        name = key[0] if alone else f"{key[0]}, {1e6 * key[2]:.4g} mm^2/s"
        angle_series.append(AngleSeries(name, speeds[rows], angles[rows], key[1], key[2]))
    return angle_series


def _fluids(table: Table) -> tuple[Floats, Floats]:
    names = table.texts("fluid")
    warm = table.numbers("temperature", "K") if "temperature" in table.heads else np.full(len(names), ROOM)
    try:
        states = [fluid(name, float(kelvin)) for name, kelvin in zip(names, warm, strict=True)]
    except CatalogError as error:
        raise ResultError(
            f"{table.place}: column 'fluid': {error}; or describe the fluid by the columns density [kg/m^3] and "
            "viscosity [mm^2/s]"
        ) from None
    return np.array([state.density for state in states]), np.array([state.viscosity for state in states])
