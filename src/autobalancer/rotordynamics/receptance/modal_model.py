"""A receptance as a sum of modes, stable and of relative degree two by construction, fitted by least squares.

H(sigma) = sum (a_k + b_k sigma)/(sigma^2 + d_k sigma + e_k), d_k, e_k > 0, sum b_k = 0. The a, b follow linearly from
the d, e, so only these are searched for (variable projection, Golub and Pereyra 1973).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lstsq, qr
from scipy.optimize import least_squares

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]


@dataclass(frozen=True)
class Modes:
    """K modes in scaled units, and how far they are from the data."""

    shapes: Floats  # (2 K,) ln d, ln e
    numerators: Floats  # (K, 2) a, b
    misfit: float  # weighted sum of squares

    @property
    def count(self) -> int:
        """K."""
        return int(self.shapes.size // 2)

    def without(self, number: int) -> Modes:
        """All but one; the others as they are."""
        k = self.count
        return Modes(np.delete(self.shapes, [number, k + number]), np.delete(self.numerators, number, axis=0), math.nan)

    def poles_and_residues(self) -> tuple[Complexes, Complexes]:
        """All 2 K poles and residues, a conjugate or real pair for each mode."""
        d, e = np.exp(self.shapes[: self.count]), np.exp(self.shapes[self.count :])
        root = np.sqrt((0.25 * d**2 - e).astype(np.complex128))
        root = np.where(np.abs(root) < 1e-9 * np.sqrt(e), 1e-9 * np.sqrt(e), root)  # no double poles
        up, down = -0.5 * d + root, -0.5 * d - root
        a, b = self.numerators.T
        residue_up, residue_down = (a + b * up) / (up - down), (a + b * down) / (down - up)
        return np.concatenate([up, down]), np.concatenate([residue_up, residue_down])

    def at(self, frequency: Floats) -> Complexes:
        """The receptance at i frequency."""
        return np.asarray(self.parts(frequency).sum(axis=1), np.complex128)

    def parts(self, frequency: Floats) -> Complexes:
        """The part of each mode in it, shape (n, K)."""
        d, e = np.exp(self.shapes[: self.count]), np.exp(self.shapes[self.count :])
        sigma = 1j * frequency[:, None]
        a, b = self.numerators.T
        return np.asarray((a + b * sigma) / (sigma**2 + d * sigma + e), np.complex128)

    def slopes(self, frequency: Floats) -> Complexes:
        """The derivatives of the receptance over ln d, ln e, a and all b but the last, shape (n, 4 K - 1)."""
        d, e = np.exp(self.shapes[: self.count]), np.exp(self.shapes[self.count :])
        sigma = 1j * frequency[:, None]
        a, b = self.numerators.T
        share = 1.0 / (sigma**2 + d * sigma + e)
        change = -(a + b * sigma) * share**2
        moved = sigma * share
        return np.hstack([change * d * sigma, change * e, share, moved[:, :-1] - moved[:, -1:]])

    def taken(self, frequency: Floats, variance: Floats) -> Floats:
        """The share of each value that these parameters take up, the leverage of its line, from 0 to 1."""
        slopes = _stack(self.slopes(frequency) / np.sqrt(variance)[:, None])
        q = qr(slopes / np.linalg.norm(slopes, axis=0), mode="economic", check_finite=False)[0]
        return np.asarray(0.5 * (q**2).sum(axis=1).reshape(2, -1).sum(axis=0))


class Fitting:
    """Data to be fitted: complex values at sigma = i frequency, weighted."""

    def __init__(self, frequency: Floats, values: Complexes, weights: Floats) -> None:
        self.sigma, self.weights = 1j * frequency, weights
        self.target = _stack(weights * values)
        self.known: tuple[Floats, tuple[Floats, Floats, Floats]] | None = None  # residuals and slopes are asked in turn

    def numerators(self, shapes: Floats) -> tuple[Floats, Floats, Floats]:
        """Best a, b for given d, e; the residuals; and their slopes over ln d, ln e (Kaufman 1975)."""
        if self.known is not None and np.array_equal(self.known[0], shapes):
            return self.known[1]
        k = shapes.size // 2
        d, e = np.exp(shapes[:k]), np.exp(shapes[k:])
        sigma = self.sigma[:, None]
        share = 1.0 / (sigma**2 + d * sigma + e)
        base = self.weights[:, None] * share
        slope = base * sigma
        matrix = _stack(np.hstack([base, slope[:, :-1] - slope[:, -1:]]))
        size = np.linalg.norm(matrix, axis=0)
        # from scipy, like the search around it: two libraries with threads of their own wait for each other
        q, r = qr(matrix / size, mode="economic", check_finite=False)
        solution = lstsq(r, q.T @ self.target, cond=1e-13)[0] / size
        b = np.append(solution[k:], -solution[k:].sum())
        change = -(solution[:k] * base + b * slope) * share
        slopes = _stack(np.hstack([change * d * sigma, change * e]))
        answer = np.column_stack([solution[:k], b]), matrix @ solution - self.target, slopes - q @ (q.T @ slopes)
        self.known = shapes.copy(), answer
        return answer

    def search(self, starts: list[Complexes]) -> Modes:
        """The modes nearest to the data; from each start (poles, one of each pair) a few steps, from the best all."""
        tried = [self._refine(_shapes(poles), 12, 1e-6) for poles in starts]
        return self._refine(min(tried, key=lambda modes: modes.misfit).shapes, 60, 1e-13)

    def refined(self, modes: Modes) -> Modes:
        """The modes nearest to the data, from modes that are near."""
        return self._refine(modes.shapes, 60, 1e-13)

    def _bounds(self, count: int) -> tuple[Floats, Floats]:
        """Of ln d, ln e: frequencies within a hundred times the band, and what damping cannot be told from none."""
        low, high = math.log(np.abs(self.sigma).min()), math.log(np.abs(self.sigma).max())
        far, ones = math.log(100.0), np.ones(count)
        return (
            np.concatenate([(low - 25.0) * ones, 2.0 * (low - far) * ones]),
            np.concatenate([(high + 2.0 * far) * ones, 2.0 * (high + far) * ones]),
        )

    def _refine(self, start: Floats, steps: int, tolerance: float) -> Modes:
        low, high = self._bounds(start.size // 2)
        found = least_squares(
            lambda x: self.numerators(x)[1],
            np.clip(start, low + 1e-6, high - 1e-6),
            jac=lambda x: self.numerators(x)[2],
            bounds=(low, high),
            xtol=tolerance,
            ftol=tolerance,
            gtol=1e-15,
            max_nfev=steps,
        )
        numerators, miss, _ = self.numerators(found.x)
        return Modes(found.x, numerators, float(miss @ miss))


def _stack(values: Complexes) -> Floats:
    return np.concatenate([values.real, values.imag])


def _shapes(poles: Complexes) -> Floats:
    return np.concatenate([np.log(np.maximum(-2.0 * poles.real, 1e-12)), np.log(np.maximum(np.abs(poles), 1e-12) ** 2)])
