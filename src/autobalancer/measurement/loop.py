"""Balls on a rotor of which only the receptance is known."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from pathlib import Path

import numpy as np
import xarray as xr

from autobalancer.arrays import Complexes, Floats
from autobalancer.assembly.terms import Theory, unknown
from autobalancer.catalog.resolve import fluid_numbers, resolve
from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import balls_in_races
from autobalancer.machine import Machine
from autobalancer.progress import shows_progress
from autobalancer.random_numbers import generator
from autobalancer.results.answers.answer import Labeled, provenance
from autobalancer.results.display_units import moment_text
from autobalancer.results.labels import labeled
from autobalancer.roots import root
from autobalancer.rotordynamics.rational_fit import Fitting
from autobalancer.rotordynamics.receptances import PoleModel, hertz, pole_model
from autobalancer.stability.states.ball_positions import directions
from autobalancer.units import argument, ends_argument, list_argument, optional_argument

# Stability of the balanced state from a fitted receptance and the balls: growth rates, margins, exact borders.
#
# Exact for balls in one race on the axis of a rotor with isotropic supports at constant speed. A receptance measured
# at standstill holds where gyroscopic effects are small; nothing is known of modes outside the measured band.


DRAGS = np.geomspace(1e-5, 1e5, 101)  # factors on the drag that are tried
GAINS = np.geomspace(1.0, 1e4, 81)
PHASES = np.linspace(0.0, math.pi, 91)


def receptance_stability(
    fit: xr.Dataset,
    balls: RaceBalls,
    speeds: Sequence[float | str],
    *,
    balls_on_rotor: bool,
    unbalance: float | str | None = None,
    angles: Floats | None = None,
) -> xr.Dataset:
    """Growth rate and margins of the balanced state at given speeds.

    Parameters
    ----------
    fit
        From :func:`~autobalancer.rotordynamics.rational_fit.receptance`.
    balls
        From :func:`balls_of` or :func:`equal_balls`.
    speeds
        Rotor speeds, rad/s.
    balls_on_rotor
        Whether the receptance was measured with the balls (their mass) on the rotor.
    unbalance
        kg m, of the rotor without balls, for one or two balls.
    angles
        Instead: ball angles in the balanced state, rad. Without both, the worst of several arrangements from evenly spread
        to all in line is taken, separately at each speed.

    Returns
    -------
    xarray.Dataset
        Over ``speed``: ``growth_rate`` (1/s) and ``whirl_frequency`` (rad/s, seen in the rotor) of the leading
        eigenvalue; ``drag_factor``, the least factor on all drags from which on the state is stable (inf: none);
        ``gain_margin`` (factor) and ``phase_margin`` (rad) by which the receptance may be wrong, nan where the state is
        unstable; ``frequency_low``, ``frequency_high``: the frequencies of the receptance on which this rests, and
        ``covered``, whether they were measured. ``attrs["warnings"]`` says so in words.

    Raises
    ------
    QuestionError
        If the balls cannot have these angles, or a speed is not above zero.
    """
    speeds = list_argument("speeds", speeds, "rad/s")
    unbalance = optional_argument("unbalance", unbalance, "kg*m")
    # the fitted receptance, with the balls' mass if they were not on the rotor, and the arrangements of the balls
    model = pole_model(fit, 0.0 if balls_on_rotor else float(balls.mass.sum()))
    states = positions(balls, unbalance, angles)
    band = (fit.attrs["band_low"], fit.attrs["band_high"])
    rows = [_row(model, balls, states, _valid(speed), band) for speed in speeds]
    meanings = {
        "growth_rate": ("growth rate", "1/s"),
        "whirl_frequency": ("frequency of the leading mode, in the rotor", "rad/s"),
        "drag_factor": ("least factor on the drag for stability", ""),
        "gain_margin": ("gain margin", ""),
        "phase_margin": ("phase margin", "rad"),
        "spread": ("arrangement of the balls:  0 evenly spread, 1 in line", ""),
        "frequency_low": ("lowest frequency needed", "rad/s"),
        "frequency_high": ("highest frequency needed", "rad/s"),
    }
    # growth and margins at each speed
    columns = zip(meanings.items(), zip(*rows, strict=True), strict=True)
    data = {name: ("speed", list(column), *about) for (name, about), column in columns}
    dataset = labeled(data, {"speed": ("speed", list(speeds), "rotor speed", "rad/s")})
    # does the answer rest on what was measured?
    within = (dataset["frequency_low"] >= band[0]) & (dataset["frequency_high"] <= band[1])
    dataset["covered"] = within.assign_attrs(long_name="whether these were measured")
    doubts = [text for text in fit.attrs["warnings"].split("\n") if text]
    if not bool(within.all()):
        low, high = float(dataset["frequency_low"].min()), float(dataset["frequency_high"].max())
        doubts.append(
            f"the stability rests on the receptance from {hertz(low)} to {hertz(high)} Hz, the band of the fit is "
            f"{hertz(band[0])} to {hertz(band[1])} Hz: what lies outside is extrapolated"
        )
    dataset.attrs = {**provenance(), "title": "Stability from a receptance", "theory": "exact: full equations"}
    dataset.attrs |= {
        "balls": balls.count,
        "ignores": balls.ignores,
        "warnings": "\n".join(doubts),
        "fit_error": fit.attrs["fit_error"],
    }
    if len(states) == 1:
        dataset.attrs["ball_angles_deg"] = degrees(states[0])
    return Labeled.of(dataset)


def worst_growth(model: PoleModel, balls: RaceBalls, states: list[Floats], speed: float) -> float:
    """Greatest growth rate over several ball positions, 1/s."""
    return max(float(loop_eigenvalues(model, balls, angles, speed)[0].real) for angles in states)


def needed_frequencies(
    model: PoleModel, balls: RaceBalls, angles: Floats, speed: float, s: complex
) -> tuple[float, float]:
    """Least and greatest frequency at which the receptance decides over an eigenvalue, and the speed itself, rad/s.

    An eigenvalue s rests on H at s + iW and s - iW; one of them is left out if it weighs less than a twentieth.
    """
    t = loop_matrix(model, balls, angles, speed, np.array([s]))[0]
    cross = t[0, 1] * t[1, 0]
    weights = abs(t[0, 0] * (1.0 - t[1, 1]) + cross), abs(t[1, 1] * (1.0 - t[0, 0]) + cross)
    needed = [speed]
    needed += [abs(s.imag + side * speed) for side, w in zip((1, -1), weights, strict=True) if w > 0.05 * max(weights)]
    return min(needed), max(needed)


def _row(
    model: PoleModel, balls: RaceBalls, states: list[Floats], speed: float, band: tuple[float, float]
) -> tuple[float, ...]:
    leading = [complex(loop_eigenvalues(model, balls, angles, speed)[0]) for angles in states]
    worst = int(np.argmax([s.real for s in leading]))
    s, angles = leading[worst], states[worst]
    gain, phase = math.nan, math.nan
    if s.real < 0.0:
        rates = [partial(_rate, model, balls, angles, speed) for angles in states]
        gain = min(_margin(rate, GAINS) for rate in rates)
        phase = min(_margin(partial(rate, 1.0), sign * PHASES) for rate in rates for sign in (1.0, -1.0))
    drag = least_drag_factor(model, balls, states, speed)
    needed = needed_frequencies(model, balls, angles, speed, s)
    return s.real, abs(s.imag), drag, gain, phase, spread(balls, angles), *needed


def _rate(model: PoleModel, balls: RaceBalls, angles: Floats, speed: float, gain: float, phase: float = 0.0) -> float:
    return float(loop_eigenvalues(model, balls, angles, speed, gain=gain, phase=phase)[0].real)


def _margin(rate: Callable[[float], float], values: Floats) -> float:
    """Amount of the first value at which the growth rate, negative at the beginning, passes zero; inf if none."""
    for near, far in pairwise(values.tolist()):
        if rate(far) >= 0.0:
            return abs(root(rate, near, far, rtol=1e-10))
    return math.inf


def least_drag_factor(model: PoleModel, balls: RaceBalls, states: list[Floats], speed: float) -> float:
    """Least factor on all drags from which on, up to 1e5, the balanced state is stable; inf if it is not at 1e5."""

    def rate(logarithm: float) -> float:
        return worst_growth(model, balls.with_drag(math.exp(logarithm)), states, speed)

    values = np.log(DRAGS)
    for above, below in pairwise(values[::-1].tolist()):
        if rate(above) >= 0.0:
            return math.inf
        if rate(below) >= 0.0:
            return math.exp(root(rate, below, above, xtol=1e-10))
    return 0.0


def viscosity_of(machine: Machine | str | Path) -> float | None:
    """Kinematic viscosity (m^2/s) of the fluid in the race, if the drag follows from it, in proportion."""
    machine = balls_in_races(machine)
    race = machine.balancers[0].races[0]
    if race.fluid is None or not race.drag.needs_fluid:
        return None
    return fluid_numbers(race.fluid)[1]


def _valid(speed: float) -> float:
    if not (math.isfinite(speed) and speed > 0.0):
        raise QuestionError(f"speed: given {speed!r}; must be greater than zero, in rad/s")
    return float(speed)


# Balls coupled to a rotor of which only the receptance at the race is known, linearized about the balanced state.
#
# With H(sigma) = sum r/(sigma - p), the receptance for forward rotating quantities, sum r = 0, and the acceleration A
# of the race, in the frame that turns with the rotor at speed W (one complex q for each pole):
#
#     q' = (p - iW) q + r f,   A = sum p^2 q + (sum r p) f,   f = -m A - i sum s e^(i phi) (phi'' + 2iW phi' - W^2 phi)
#     I phi'' + beta phi' + s Im[e^(-i phi) A] = 0,   s = m_b eps
#
# m is the mass of the balls if H was measured without them, else 0. The eigenvalues are the roots of det(1 - T(s)) =
# 0,
#
#     T = 1/2 [a_0 G+, a_2 G-; a_-2 G+, a_0 G-],   G+ = (s + iW)^4 H(s + iW),   G- = conj(G+(conj s)),
#     a_n = sum s_j^2 e^(i n phi_j) / P_j(s),   P = I s^2 + beta s,   1/H with balls = 1/H + m sigma^2.
#
# Derived for this project; for equal balls it is (P - cN G+/2)(P - cN G-/2) = c^2 |S2|^2 G+ G-/4. For the planar
# rotor it is :mod:`autobalancer.stability.states.linearized`.


def loop_eigenvalues(
    model: PoleModel, balls: RaceBalls, angles: Floats, speed: float, *, gain: float = 1.0, phase: float = 0.0
) -> Complexes:
    """Eigenvalues of the closed loop, 1/s, the fastest growing first, without the zeros of freely movable balls.

    ``gain`` and ``phase`` (rad) change G+ to gain e^(i phase) G+: how wrong the receptance may be.
    """
    p, r, n, balls_n = model.poles, model.residues, model.poles.size, balls.count
    direct = complex((r * p).sum())
    ahead = balls.moment * np.exp(1j * angles)
    seen = gain * np.exp(1j * phase) * balls.moment * np.exp(-1j * angles)
    # columns: Re q, Im q, phi, phi'; rows of the equations for f (two) and phi''
    size = 2 * n + 2 * balls_n
    free = np.zeros(size, np.complex128)
    free[:n], free[n : 2 * n] = p**2, 1j * p**2
    load = -model.added_mass * free
    load[2 * n : 2 * n + balls_n] += 1j * speed**2 * ahead
    load[2 * n + balls_n :] += 2.0 * speed * ahead
    left = np.zeros((2 + balls_n, 2 + balls_n))
    right = np.zeros((2 + balls_n, size))
    factor = 1.0 + model.added_mass * direct
    left[:2, :2] = [[factor.real, -factor.imag], [factor.imag, factor.real]]
    left[0, 2:], left[1, 2:] = (1j * ahead).real, (1j * ahead).imag
    left[2:, 0], left[2:, 1] = (seen * direct).imag, (1j * seen * direct).imag
    left[2:, 2:] = np.diag(balls.inertia)
    right[0], right[1] = load.real, load.imag
    right[2:] = -(seen[:, None] * free).imag
    right[2:, 2 * n + balls_n :] -= np.diag(balls.drag)
    answer = np.linalg.solve(left, right)
    matrix = np.zeros((size, size))
    turned = p - 1j * speed
    matrix[:n, :n] = matrix[n : 2 * n, n : 2 * n] = np.diag(turned.real)
    matrix[:n, n : 2 * n], matrix[n : 2 * n, :n] = np.diag(-turned.imag), np.diag(turned.imag)
    matrix[:n] += np.outer(r.real, answer[0]) - np.outer(r.imag, answer[1])
    matrix[n : 2 * n] += np.outer(r.imag, answer[0]) + np.outer(r.real, answer[1])
    matrix[2 * n : 2 * n + balls_n, 2 * n + balls_n :] = np.eye(balls_n)
    matrix[2 * n + balls_n :] = answer[2:]
    values = np.linalg.eigvals(matrix)
    values = np.delete(values, np.argsort(np.abs(values))[: neutral_count(angles)])
    return np.asarray(values[np.argsort(-values.real, kind="stable")], np.complex128)


def neutral_count(angles: Floats) -> int:
    """Zeros among the eigenvalues: n - 2, or n - 1 for balls in line."""
    if angles.size < 2:
        return 0
    reach = np.linalg.svd(np.vstack([np.cos(angles), np.sin(angles)]), compute_uv=False)
    return int(angles.size - 2 + (reach[1] < 1e-7 * reach[0]))


def loop_matrix(model: PoleModel, balls: RaceBalls, angles: Floats, speed: float, s: Complexes) -> Complexes:
    """T(s), shape (..., 2, 2), at complex frequencies seen in the rotor."""
    ball = balls.inertia * s[..., None] ** 2 + balls.drag * s[..., None]
    a_0, a_2, a_back = ((balls.moment**2 * np.exp(1j * k * angles) / ball).sum(axis=-1) for k in (0, 2, -2))
    forward = _fourth(model, s + 1j * speed)
    backward = np.conj(_fourth(model, np.conj(s) + 1j * speed))
    rows = [[a_0 * forward, a_2 * backward], [a_back * forward, a_0 * backward]]
    return np.asarray(0.5 * np.moveaxis(np.array(rows), (0, 1), (-2, -1)), np.complex128)


def _fourth(model: PoleModel, sigma: Complexes) -> Complexes:
    return np.asarray(sigma**4 * model.receptance(sigma), np.complex128)


# Exact border speeds from a fitted receptance, with the uncertainty that comes from the noise of the measurement.


POINTS = 240
SHARES = (1e-3, 1e-2, 0.03, 0.1, 0.3)  # of a border within which that of a fit with new noise is looked for


@shows_progress
def receptance_border(
    fit: xr.Dataset,
    balls: RaceBalls,
    *,
    balls_on_rotor: bool,
    unbalance: float | str | None = None,
    angles: Floats | None = None,
    searched: tuple[float | str, float | str] | str | None = None,
    resamples: int = 0,
    seed: int = 0,
    progress: Callable[[float, float], None] | bool | None = None,
) -> xr.Dataset:
    """Speed ranges in which the balanced state is stable, and the exact border.

    Parameters
    ----------
    fit, balls, balls_on_rotor, unbalance, angles
        As for :func:`receptance_stability`.
    searched
        Speeds, rad/s; by default from the lowest mode in the measured band to the end of the band.
    resamples
        How many times the fit is repeated with its own noise added, for the uncertainty of the border.
    seed
        For that noise.
    progress
        By default a bar where a person is looking and it takes more than a second; False: none; or a function of
        (done, all).

    Returns
    -------
    xarray.Dataset
        Along ``range``: ``stable_from`` and ``stable_to``, rad/s. ``attrs``: ``exact_border``, the lowest speed from
        which on the state is stable up to the end of the search (inf if it is not stable there);
        ``exact_border_deviation``, its standard deviation (nan without resamples); ``searched``; ``warnings``.
    """
    unbalance = optional_argument("unbalance", unbalance, "kg*m")
    # ranges of speed in which the worst arrangement is stable; the border begins the last one
    added = 0.0 if balls_on_rotor else float(balls.mass.sum())
    model, states = pole_model(fit, added), positions(balls, unbalance, angles)
    low, high = _search_range(fit, model) if searched is None else ends_argument("searched", searched, "rad/s")
    if not 0.0 < low < high:
        raise QuestionError(f"speeds searched: given {low:g} to {high:g} rad/s; must be above zero and ascend")
    ranges = _stable_ranges(model, balls, states, low, high)
    border = ranges[-1][0] if ranges and ranges[-1][1] == high else math.inf
    begins, ends = [r[0] for r in ranges], [r[1] for r in ranges]
    dataset = labeled(
        {
            "stable_from": ("range", begins, "stable from", "rad/s"),
            "stable_to": ("range", ends, "stable up to", "rad/s"),
        }
    )
    # how far noise in the receptance moves it: fits of resampled residuals
    deviation = math.nan
    if resamples and math.isfinite(border):
        borders = []
        for number, again in enumerate(_resampled(fit, resamples, seed, added), 1):
            borders.append(_border_near(partial(worst_growth, again, balls, states), border, high))
            if callable(progress):
                progress(number, resamples)
        known = [speed for speed in borders if math.isfinite(speed)]
        deviation = float(np.std(known, ddof=1)) if len(known) > 1 else math.nan
    at_border = {"balls_on_rotor": balls_on_rotor, "unbalance": unbalance, "angles": angles}
    there = receptance_stability(fit, balls, [border if math.isfinite(border) else high], **at_border)  # type: ignore[arg-type]
    dataset.attrs = {
        **provenance(),
        "title": "Exact border from a receptance",
        "theory": "exact: full equations",
        "state": "worst case over the positions of the balls" if len(states) > 1 else "one position of the balls",
        "exact_border": border,
        "exact_border_deviation": deviation,
        "searched": [low, high],
        "ignores": balls.ignores,
        "warnings": there.attrs["warnings"],
    }
    return Labeled.of(dataset)


def _resampled(fit: xr.Dataset, count: int, seed: int, added_mass: float = 0.0) -> Iterator[PoleModel]:
    """Fits of the fitted receptance with new noise of the same size; the number of modes stays."""
    random = generator(seed)
    part = fit.isel(frequency=np.flatnonzero(fit["used"].values))
    frequency = np.asarray(part["frequency"].values, np.float64)
    fitted = np.asarray(part["fitted_real"].values + 1j * part["fitted_imag"].values, np.complex128)
    deviation = np.asarray(part["noise_deviation"].values, np.float64)
    unit, size = math.sqrt(frequency[0] * frequency[-1]), float(np.abs(fitted).max())
    start = pole_model(fit).poles[: fit.attrs["modes"]] / unit
    for _ in range(count):
        noise = random.normal(size=(2, fitted.size)) * deviation / math.sqrt(2.0)
        values = fitted + noise[0] + 1j * noise[1]
        weights = size / (deviation * math.sqrt(fitted.size))
        poles, residues = Fitting(frequency / unit, values / size, weights).search([start]).poles_and_residues()
        yield PoleModel(unit * poles, unit * size * residues, added_mass)


def _search_range(fit: xr.Dataset, model: PoleModel) -> tuple[float, float]:
    high = float(fit.attrs["band_high"])
    modes = np.abs(model.poles[np.abs(model.poles.imag) > 0.3 * np.abs(model.poles.real)])
    inside = modes[(modes > fit.attrs["band_low"]) & (modes < high)]
    return (0.9 * float(inside.min()) if inside.size else float(fit.attrs["band_low"])), high


def _stable_ranges(
    model: PoleModel, balls: RaceBalls, states: list[Floats], low: float, high: float
) -> list[tuple[float, float]]:
    def rate(speed: float) -> float:
        return worst_growth(model, balls, states, speed)

    speeds = np.linspace(low, high, POINTS)
    stable = np.array([rate(speed) for speed in speeds]) < 0.0
    ranges: list[tuple[float, float]] = []
    start = low if stable[0] else math.nan
    for i in np.flatnonzero(stable[1:] != stable[:-1]):
        edge = root(rate, speeds[i], speeds[i + 1], xtol=1e-9 * high)
        if stable[i + 1]:
            start = edge
        else:
            ranges.append((start, edge))
    return [*ranges, (start, high)] if stable[-1] else ranges


def _border_near(rate: Callable[[float], float], border: float, high: float) -> float:
    """The speed near ``border`` at which the growth rate falls through zero; nan if there is none within a third."""
    for share in SHARES:
        low, top = border * (1.0 - share), min(border * (1.0 + share), high)
        if rate(low) > 0.0 > rate(top):
            return root(rate, low, top, xtol=1e-9 * high)
    return math.nan


# The loop through rotor and balls as a curve: what passes the point +1 on the wrong side is unstable.


def receptance_loop(fit: xr.Dataset, balls: RaceBalls, speed: float | str, *, balls_on_rotor: bool) -> xr.Dataset:
    """The loop L = (a_0/2) w^4 H(iw) over the frequency w in space, for balls evenly spread over directions.

    There the equation of :mod:`autobalancer.measurement.loop` splits into 1 = L and its conjugate (equal balls:
    L = (c N/2) w^4 H(iw)/P(i(w - W))), so measured values can be drawn as they are. If stable, the curve,
    followed with rising frequency, has +1 on its left. At w = W it comes from infinity.

    Parameters
    ----------
    fit, balls, balls_on_rotor
        As for :func:`receptance_stability`.
    speed
        Rotor speed, rad/s.

    Returns
    -------
    xarray.Dataset
        ``loop_real`` and ``loop_imag`` over ``loop_frequency`` (rad/s) from the fit; ``measured_loop_real`` and
        ``measured_loop_imag`` over ``frequency`` from the measured values. ``attrs``: speed, growth rate, gain and
        phase margin of balls so spread.
    """
    speed = argument("speed", speed, "rad/s")
    model = pole_model(fit, 0.0 if balls_on_rotor else float(balls.mass.sum()))
    weight = balls.moment**2
    level = max(0.0, 2.0 * float(weight.max()) - float(weight.sum()))
    doubled = directions(weight, complex(level))
    assert doubled is not None
    row = receptance_stability(fit, balls, [speed], balls_on_rotor=balls_on_rotor, angles=0.5 * doubled)
    frequency = _frequencies(fit, model, speed)
    measured_at = fit["frequency"].values
    bare = fit["receptance_real"].values + 1j * fit["receptance_imag"].values
    measured = bare / (1.0 - model.added_mass * measured_at**2 * bare)
    curves = {
        "loop": ("loop_frequency", _loop(balls, speed, frequency, model.at(frequency))),
        "measured_loop": ("frequency", _loop(balls, speed, measured_at, measured)),
    }
    dataset = labeled(
        {f"{name}_real": (dim, values.real, "loop, real part", "") for name, (dim, values) in curves.items()}
        | {f"{name}_imag": (dim, values.imag, "loop, imaginary part", "") for name, (dim, values) in curves.items()},
        {
            dim: (dim, values, "frequency in space", "rad/s")
            for dim, values in (("loop_frequency", frequency), ("frequency", measured_at))
        },
    )
    dataset.attrs = {
        **provenance(),
        "title": "Loop of evenly spread balls",
        "speed": float(speed),
        "ignores": balls.ignores,
    }
    dataset.attrs |= {name: float(row[name][0]) for name in ("growth_rate", "gain_margin", "phase_margin")}
    return Labeled.of(dataset)


def _loop(balls: RaceBalls, speed: float, frequency: Floats, receptance: Complexes) -> Complexes:
    turning = 1j * (frequency[:, None] - speed)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = (balls.moment**2 / (balls.inertia * turning**2 + balls.drag * turning)).sum(axis=1)
        return np.asarray(0.5 * share * frequency**4 * receptance, np.complex128)


def _frequencies(fit: xr.Dataset, model: PoleModel, speed: float) -> Floats:
    """Even over the logarithm, and dense about every mode and about the speed, where the curve runs fast."""
    low, high = 0.3 * min(speed, fit.attrs["band_low"]), 1.5 * max(speed, fit.attrs["band_high"])
    shares = np.sinh(np.linspace(-9.0, 9.0, 400))
    points = [np.geomspace(low, high, 800), speed * (1.0 + 1e-4 * shares)]
    for pole in model.poles[model.poles.imag > 0.0]:
        points.append(abs(pole) + 0.02 * abs(pole.real) * shares)
    every = np.unique(np.concatenate(points))
    return np.asarray(every[(every > low) & (every < high) & (every != speed)], np.float64)


# Balls in one race on the rotor's axis, and where they stand: all that stability from a receptance needs of them.


LEVELS = 9  # so many ways of standing are gone through for the worst case


@dataclass(frozen=True)
class RaceBalls:
    """Balls in one race, each array of shape (n,), SI."""

    mass: Floats  # effective: what moves with the rotor
    moment: Floats  # effective mass x orbit radius
    inertia: Floats  # of the ball angle
    drag: Floats  # beta, N m s
    ignores: str = ""  # what this theory does not know of their machine

    def __post_init__(self) -> None:
        positive = {"mass": self.mass, "moment": self.moment, "inertia": self.inertia, "drag": self.drag}
        for name, values in positive.items():
            if values.size == 0 or not (np.isfinite(values) & (values > 0.0)).all():
                raise QuestionError(f"balls: {name} = {values.tolist()}; give one ball or more, all values above zero")

    @property
    def count(self) -> int:
        """Number of balls."""
        return int(self.moment.size)

    def with_drag(self, factor: float) -> RaceBalls:
        """The same balls with so many times the drag."""
        return replace(self, drag=factor * self.drag)


def equal_balls(
    count: int, mass: float | str, orbit_radius: float | str, drag: float | str, *, spin_ratio: float
) -> RaceBalls:
    """``count`` equal balls without buoyancy: ``mass`` (kg), ``orbit_radius`` (m), ``drag`` beta of each (N m s).

    ``spin_ratio`` is 2/5 for rolling balls, 0 for points.
    """
    mass = argument("mass", mass, "kg")
    orbit_radius = argument("orbit_radius", orbit_radius, "m")
    drag = argument("drag", drag, "N*m*s")
    ones = np.ones(count)
    inertia = (1.0 + spin_ratio) * mass * orbit_radius**2
    return RaceBalls(mass * ones, mass * orbit_radius * ones, inertia * ones, drag * ones)


def balls_of(machine: Machine | str | Path) -> RaceBalls:
    """The balls of a machine with one race on its axis; the rotor of the machine is ignored.

    Raises
    ------
    QuestionError
        If there are no balls, several races, or the race is off the axis.
    """
    machine = balls_in_races(machine)
    balls = resolve(machine)
    if len({(ball.balancer, ball.race) for ball in balls}) != 1:
        raise QuestionError("stability from a receptance: the machine must have one race with balls")
    if any(ball.eccentricity for ball in balls):
        raise QuestionError("stability from a receptance: the race is off the axis; this method is for one on the axis")
    mass, moment = np.array([b.effective_mass for b in balls]), np.array([b.moment for b in balls])
    inertia, drag = np.array([b.inertia for b in balls]), np.array([b.drag for b in balls])
    return RaceBalls(mass, moment, inertia, drag, ", ".join(unknown(machine, Theory.LOOP)))


def positions(balls: RaceBalls, unbalance: float | None, angles: Floats | None) -> list[Floats]:
    """Ball angles in the balanced state; several, from evenly spread to all in line, if nothing is given.

    Raises
    ------
    QuestionError
        If the balls cannot balance the unbalance, or there are more than two and no angles.
    """
    if angles is not None:
        given = np.asarray(angles, np.float64)
        if given.shape != balls.moment.shape:
            raise QuestionError(f"ball angles: given {given.size} for {balls.count} balls")
        return [given]
    if unbalance is None:
        weight = balls.moment**2
        least = max(0.0, 2.0 * float(weight.max()) - float(weight.sum()))
        doubled = [directions(weight, complex(level)) for level in np.linspace(least, weight.sum(), LEVELS)]
        return [0.5 * positions for positions in doubled if positions is not None]
    if balls.count > 2:
        raise QuestionError(
            f"unbalance: {balls.count} balls can balance it in many ways; give their angles, or nothing: the worst case"
        )
    positions = directions(balls.moment, complex(-abs(unbalance)))
    if positions is None:
        raise QuestionError(
            f"unbalance: the balls cannot balance {moment_text(abs(unbalance), 4)}; "
            f"they can balance up to {moment_text(balls.moment.sum(), 4)}"
        )
    return [positions]


def spread(balls: RaceBalls, angles: Floats) -> float:
    """|sum c e^(2 i phi)| / sum c with c = (m eps)^2: 0 for balls evenly spread over directions, 1 in line."""
    weight = balls.moment**2
    return float(abs((weight * np.exp(2j * angles)).sum()) / weight.sum())


def degrees(angles: Floats) -> list[float]:
    """Angles in degrees within ±180, for messages."""
    return [round(math.degrees(math.remainder(angle, 2.0 * math.pi)), 1) for angle in angles.tolist()]
