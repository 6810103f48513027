"""What measured equilibrium angles say: drag coefficients over the Reynolds number, and the coefficient of friction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.measurement.angle.curve import angle_machine, attributes
from autobalancer.measurement.angle.file import AngleSeries
from autobalancer.measurement.angle.statics import Floats, TurnedRace, drag_coefficients, equilibrium_angles
from autobalancer.random_numbers import generator
from autobalancer.results.answers.labeled import Labeled
from autobalancer.results.provenance import provenance

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
        Measured speeds and angles, :func:`~autobalancer.measurement.angle.file.load_angle_series`.
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
    parts = [(one.race(given.race), one.speeds, one.angles) for one in series]
    source = "given" if rolling is not None else "fitted" if overlaps(parts) else "machine"
    speeds, angles = (np.concatenate([part[i] for part in parts]) for i in (1, 2))
    reynolds = np.concatenate([race.reynolds(w) for race, w, _ in parts])
    found, stands, coefficients, deviations = [], [], [], []
    for pressure in (0.0, given.pressure):
        turned = [(replace(race, pressure=pressure), w, s) for race, w, s in parts]
        value = given.rolling if rolling is None else rolling
        deviation = float("nan")
        if source == "fitted":
            value = fit_rolling_resistance(turned)
            deviation = rolling_resistance_deviation(turned, resamples=resamples, seed=seed)
        coefficients.append(value)
        deviations.append(deviation)
        found.append(np.concatenate([drag_coefficients(race, w, s, value) for race, w, s in turned]))
        stands.append(np.concatenate([equilibrium_angles(race, given.law, w, value) for race, w, _ in turned]))
    each = ("pressure_force", "point")
    data = {
        "measured_angle": ("point", angles),
        "reynolds": ("point", reynolds),
        "law_coefficient": ("point", given.law.coefficient(reynolds)),
        "drag_coefficient": (each, np.array(found)),
        "angle": (each, np.array(stands)),
        "rolling_resistance": ("pressure_force", coefficients),
        "rolling_resistance_deviation": ("pressure_force", deviations),
    }
    names = np.repeat([one.name for one in series], [np.size(one.speeds) for one in series])
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
    from scipy.optimize import minimize_scalar

    overlap = _Overlap(series)
    if not overlap.pairs:
        raise QuestionError("no two series have overlapping Reynolds numbers; measure fluids of more similar viscosity")
    weights = [np.ones(POINTS)] * len(overlap.pairs)
    trial = np.linspace(0.0, LARGEST, 61)
    best = int(np.argmin([overlap.mismatch(mu, weights) for mu in trial]))
    found, reach = float(trial[best]), float(trial[1])
    for _ in range(PASSES):
        span = max(found - reach, 0.0), min(found + reach, LARGEST)
        answer = minimize_scalar(
            overlap.mismatch, bounds=span, args=(weights,), method="bounded", options={"xatol": 1e-8}
        )
        found = float(answer.x)
        weights = overlap.weights(found)
    return found


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
    found = []
    for _ in range(resamples):
        drawn = []
        for race, speeds, angles in series:
            count = np.size(np.asarray(speeds))
            picked = np.unique(random.integers(0, count, count))
            drawn.append((race, np.asarray(speeds)[picked], np.asarray(angles)[picked]))
        if _Overlap(drawn).pairs:
            found.append(fit_rolling_resistance(drawn))
    return float(np.std(found, ddof=1)) if len(found) > 1 else float("nan")


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
