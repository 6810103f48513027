"""Correction masses for which the vibration that remains is least: in the mean square, or the greatest one."""

from __future__ import annotations

from typing import Literal

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.measurement.balancing.arrays import Complexes, Floats

Goal = Literal["mean", "greatest"]
TIGHT = 1e-13  # tolerance of the search


def least_residual(
    original: Complexes, coefficients: Complexes, weights: Floats, goal: Goal, limits: Floats
) -> Complexes:
    """Masses (P,) for which weighted ``original + coefficients @ masses`` is least, each at most its limit (inf for none).

    Both problems are convex, so what is found is the least of all.

    Source: Goodman (1964) for the least squares; Foiles, Allaire and Gunter (2000) for the least greatest residual.
    """
    a, b = weights[:, None] * coefficients, weights * original
    plain = np.asarray(-np.linalg.lstsq(a, b, rcond=None)[0], np.complex128)
    if goal == "mean" and (np.abs(plain) <= limits).all():
        return plain
    if goal == "greatest" and b.size <= plain.size and (np.abs(plain) <= limits).all():
        return plain  # nothing remains
    return _searched(a, b, plain, goal, limits)


def _searched(a: Complexes, b: Complexes, plain: Complexes, goal: Goal, limits: Floats) -> Complexes:
    from scipy.optimize import minimize

    count = plain.size
    size = np.where(np.abs(plain) > 0.0, np.abs(plain), 1.0)
    rows = a * size
    scale = float(np.abs(b).max()) or 1.0
    rows, rest = rows / scale, b / scale
    start = plain * np.minimum(1.0, limits / np.maximum(np.abs(plain), 1e-300)) / size
    bound = np.flatnonzero(np.isfinite(limits))

    def masses(v: Floats) -> Complexes:
        return np.asarray(v[:count] + 1j * v[count : 2 * count])

    def residual(v: Floats) -> Complexes:
        return np.asarray(rest + rows @ masses(v))

    def gradient(weighted: Complexes) -> Floats:
        """Of the half square of each residual, weighted, (..., 2 P)."""
        return np.concatenate([weighted.real, weighted.imag], axis=-1)

    held = {
        "type": "ineq",
        "fun": lambda v: (limits[bound] / size[bound]) ** 2 - np.abs(masses(v)[bound]) ** 2,
        "jac": lambda v: _limit_rows(masses(v), bound, v.size),
    }
    v = np.concatenate([start.real, start.imag])
    if goal == "mean":
        found = minimize(
            lambda v: 0.5 * float((np.abs(residual(v)) ** 2).sum()), v, method="SLSQP", constraints=[held],
            jac=lambda v: gradient(rows.conj().T @ residual(v)), options={"ftol": TIGHT, "maxiter": 500},
        )  # fmt: skip
    else:
        top = float(np.abs(residual(v)).max())
        below = {
            "type": "ineq",
            "fun": lambda v: v[-1] ** 2 - np.abs(residual(v)) ** 2,
            "jac": lambda v: np.column_stack(
                [-2.0 * gradient(rows.conj() * residual(v)[:, None]), np.full(rest.size, 2.0 * v[-1])]
            ),
        }
        found = minimize(
            lambda v: v[-1], np.append(v, top), method="SLSQP", constraints=[below, held],
            jac=lambda v: np.eye(v.size)[-1], options={"ftol": TIGHT, "maxiter": 500},
        )  # fmt: skip
    if not found.success and found.status not in (8, 9):
        raise QuestionError(f"balance: no correction was found: {found.message}")
    return masses(found.x) * size


def _limit_rows(masses: Complexes, bound: np.ndarray, size: int) -> Floats:
    rows = np.zeros((bound.size, size))
    for i, p in enumerate(bound):
        rows[i, p], rows[i, masses.size + p] = -2.0 * masses[p].real, -2.0 * masses[p].imag
    return rows
