"""A smooth angle through the pulses of a tacho: a spline of degree five with little jerk, and how sure it is."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.interpolate import BSpline
from scipy.linalg import cho_solve_banded, cholesky_banded
from scipy.optimize import minimize_scalar

Floats = NDArray[np.float64]
DEGREE, JERK = 5, 3
ROUGHEST, SMOOTHEST = -12.0, 9.0  # powers of ten of the weight of the jerk, time in mean intervals of the pulses
TRIED = 150  # pulses of which the leverage is computed, evenly chosen


class SmoothAngle(NamedTuple):
    """The angle as a function of the time.

    Attributes
    ----------
    spline
        rad over s.
    jitter
        Standard deviation of the instants of the pulses, s.
    times, share
        Instants (s), and of the variance of one pulse the share that the spline has there.
    """

    spline: BSpline
    jitter: float
    times: Floats
    share: Floats

    def deviation(self, t: Floats) -> Floats:
        """Standard deviation of the angle, rad."""
        speed = self.spline.derivative()(t)
        return np.asarray(self.jitter * speed * np.sqrt(np.interp(t, self.times, self.share)), np.float64)


def smooth_angle(times: Floats, angles: Floats) -> SmoothAngle:
    """Fit it: the squares of the jitter of the pulses in time, and of the jerk, with the weight of the least cross-validation.

    The spline has a knot at every pulse; generalized cross-validation (Craven and Wahba 1979) says how much it is smoothed.

    Parameters
    ----------
    times
        Instants of the pulses, s, ascending; at least four.
    angles
        Of the rotor there, rad.
    """
    unit = float(times[-1] - times[0]) / (times.size - 1)
    clock = (times - times[0]) / unit
    slope = np.gradient(angles, clock)
    fit = _Fit(clock, angles, 1.0 / slope)
    if times.size <= DEGREE:
        power = ROUGHEST
    else:
        grid = np.linspace(ROUGHEST, SMOOTHEST, 15)
        scores = [fit.score(power) for power in grid]
        best = int(np.argmin(scores))
        ends = (grid[max(0, best - 1)], grid[min(grid.size - 1, best + 1)])
        power = float(minimize_scalar(fit.score, bounds=ends, method="bounded", options={"xatol": 0.05}).x)
    coefficients, leverage, rest = fit.solved(power)
    free = max(1.0, times.size * (1.0 - float(leverage.mean())))
    jitter = unit * math.sqrt(float((rest**2).sum()) / free)
    spline = BSpline(times[0] + unit * fit.knots, coefficients, DEGREE)
    return SmoothAngle(spline, jitter, times[fit.tried], leverage)


class _Fit:
    """The matrices, made once for all weights of the jerk."""

    def __init__(self, clock: Floats, angles: Floats, weights: Floats) -> None:
        self.knots = np.concatenate([[clock[0]] * DEGREE, clock, [clock[-1]] * DEGREE])
        design = BSpline.design_matrix(clock, self.knots, DEGREE).tocsr()
        self.design = sparse.diags_array(weights) @ design
        self.target = weights * angles
        self.right = self.design.T @ self.target
        self.gram = (self.design.T @ self.design).tocsr()
        jerk = _derivative(self.knots, DEGREE, JERK)
        left = DEGREE - JERK + 1
        inner = self.knots[JERK:-JERK]
        spans = (inner[left:] - inner[:-left]) / left
        self.rough = (jerk.T @ sparse.diags_array(spans) @ jerk).tocsr()
        self.tried = np.unique(np.linspace(0, clock.size - 1, min(TRIED, clock.size)).astype(int))

    def solved(self, power: float) -> tuple[Floats, Floats, Floats]:
        """Coefficients, leverage of the pulses that are tried, residuals of all pulses in units of the clock."""
        band = _lower_band((self.gram + 10.0**power * self.rough).tocsr(), DEGREE)
        factor = cholesky_banded(band, lower=True)
        found = cho_solve_banded((factor, True), self.right)
        rows = self.design[self.tried].toarray()
        leverage = (rows * cho_solve_banded((factor, True), rows.T).T).sum(axis=1)
        return found, np.asarray(leverage, np.float64), np.asarray(self.design @ found - self.target, np.float64)

    def score(self, power: float) -> float:
        """Generalized cross-validation."""
        try:
            _, leverage, rest = self.solved(power)
        except np.linalg.LinAlgError:
            return math.inf
        free = 1.0 - float(leverage.mean())
        return float((rest**2).mean()) / free**2 if free > 1e-3 else math.inf


def _derivative(knots: Floats, degree: int, times: int) -> sparse.csr_array:
    """Coefficients of a derivative of a spline from those of the spline."""
    count = knots.size - degree - 1
    total = sparse.eye_array(count, format="csr")
    for _ in range(times):
        spans = knots[degree + 1 : count + degree] - knots[1:count]
        steps = degree / spans
        one = sparse.diags_array([-steps, steps], offsets=[0, 1], shape=(count - 1, count))
        total = one @ total
        knots, degree, count = knots[1:-1], degree - 1, count - 1
    return total.tocsr()


def _lower_band(matrix: sparse.csr_array, width: int) -> Floats:
    band = np.zeros((width + 1, matrix.shape[0]))
    for k in range(width + 1):
        diagonal = matrix.diagonal(-k)
        band[k, : diagonal.size] = diagonal
    return band
