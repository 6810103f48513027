"""Robust least squares within bounds, from one or several starts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import qmc

from autobalancer.assembly.rotors.lateral_model import Floats
from autobalancer.errors import QuestionError
from autobalancer.random_numbers import generator

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
