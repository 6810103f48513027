"""Chebyshev collocation on one coordinate, and D2 diagonalized in both directions."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autobalancer.flow.annulus import Annulus, Floats, Matrix


@dataclass(frozen=True)
class Line:
    """Points and derivative of one coordinate, ascending, and the operator of that direction between its walls.

    ``operator`` acts on the inner points; ``walls`` are its columns of the two walls. ``rates``, ``forward`` and
    ``backward`` diagonalize it: operator = backward diag(rates) forward.
    """

    points: Floats
    derivative: Matrix
    weights: Floats
    rates: Floats
    forward: Matrix
    backward: Matrix
    walls: Matrix

    def values_at(self, place: float) -> Floats:
        """Row that interpolates at ``place``, by the barycentric formula of the Chebyshev points."""
        count = self.points.size
        side = np.where(np.arange(count) % 2 == 0, 1.0, -1.0)
        side[[0, -1]] *= 0.5
        away = place - self.points
        if not away.all():
            return np.asarray(away == 0.0, np.float64)
        share = side / away
        return np.asarray(share / share.sum(), np.float64)


def line(begin: float, end: float, count: int, *, radial: bool) -> Line:
    """``count`` intervals; the operator is d2/dr2 - (1/r) d/dr if ``radial``, else d2/dz2."""
    points, first, weights = _chebyshev(count)
    half = 0.5 * (end - begin)
    points, first = begin + half * (1.0 + points), first / half
    second = first @ first
    if radial:
        second -= first / points[:, None]
    inside = second[1:-1, 1:-1]
    rates, vectors = np.linalg.eig(inside)
    order = np.argsort(-rates.real)
    rates, vectors = rates.real[order], np.ascontiguousarray(vectors.real[:, order])
    forward = np.linalg.inv(vectors)
    return Line(points, first, weights * half, rates, forward, vectors, np.ascontiguousarray(second[1:-1][:, [0, -1]]))


@dataclass(frozen=True)
class Grid:
    """Points, derivatives and the eigenvalues of D2 in a cross-section."""

    r: Line
    z: Line
    laplacian: Matrix

    def forward(self, field: Matrix) -> Matrix:
        """Values at the inner points to the eigenbasis of D2."""
        return np.asarray(self.r.forward @ field @ self.z.forward.T, np.float64)

    def backward(self, shares: Matrix) -> Matrix:
        """The way back."""
        return np.asarray(self.r.backward @ shares @ self.z.backward.T, np.float64)


def chebyshev_grid(annulus: Annulus, radial: int, axial: int) -> Grid:
    """``radial`` by ``axial`` intervals."""
    r = line(annulus.inner, annulus.outer, radial, radial=True)
    z = line(0.0, annulus.height, axial, radial=False)
    return Grid(r, z, r.rates[:, None] + z.rates[None, :])


def _chebyshev(count: int) -> tuple[Floats, Matrix, Floats]:
    """Ascending points on [-1, 1], first derivative (rows sum to zero exactly), weights of Clenshaw and Curtis."""
    k = np.arange(count + 1)
    points = np.sin(math.pi * (2.0 * k - count) / (2.0 * count))
    share = np.where(k % 2 == 0, 1.0, -1.0)
    share[[0, -1]] *= 2.0
    # differences of the points by the product of sines, which keeps their digits
    angle = math.pi * k / (2.0 * count)
    apart = 2.0 * np.sin(angle[:, None] + angle[None, :]) * np.sin(angle[:, None] - angle[None, :])
    np.fill_diagonal(apart, 1.0)
    matrix = np.outer(share, 1.0 / share) / apart
    np.fill_diagonal(matrix, 0.0)
    np.fill_diagonal(matrix, -matrix.sum(axis=1))
    even = np.arange(0, count + 1, 2)
    moments = np.zeros(count + 1)
    moments[even] = 2.0 / (1.0 - even.astype(np.float64) ** 2)
    cosines = np.cos(math.pi * np.outer(k, k) / count)
    halves = np.ones(count + 1)
    halves[[0, -1]] = 0.5
    weights = 2.0 / count * halves * (cosines @ (halves * moments))
    return points, matrix, weights
