"""The coefficient of rolling resistance with which measured series of equilibrium angles agree.

Drag coefficients of two fluids at one Reynolds number must be equal. At the left end of a series angles are small and ruled by
friction, at the right end of the next thicker fluid they are large and ruled by drag (Spannan 2021, section 6.1.4).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from autobalancer.errors import QuestionError
from autobalancer.measurement.angle.statics import Floats, TurnedRace, drag_coefficients
from autobalancer.random_numbers import generator

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
