"""Chebyshev collocation on one coordinate, whole or folded at its middle, with D2 of that direction diagonalized."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from autobalancer.flow.annulus import Annulus, Floats, Matrix

Parity = Literal[-1, 0, 1]  # of a field about the middle: odd, of no parity, even
KEPT, POWER, STRENGTH = 0.6, 2, 36.0  # share of the wave numbers that the filter leaves alone, and its shape beyond


@dataclass(frozen=True)
class Family:
    """Fields of one parity between the walls: n unknowns (those of one half if there is a parity), k walls.

    Attributes
    ----------
    rates, forward, backward
        The second derivative (or D2) between walls at zero is backward diag(rates) forward.
    walls
        Its columns of the values at the walls, (n, k).
    slope, near
        First derivative at the unknowns from the unknowns (n, n) and from the walls (n, k).
    ends
        First derivative at the walls from the unknowns where the walls are at zero, (k, n).
    filtered
        ``forward`` after the removal of what products of fields put into the highest wave numbers.
    """

    rates: Floats
    forward: Matrix
    backward: Matrix
    walls: Matrix
    slope: Matrix
    near: Matrix
    ends: Matrix
    filtered: Matrix


@dataclass(frozen=True)
class Line:
    """Points of one coordinate, ascending; ``second`` is d2/dz2, or d2/dr2 - (1/r) d/dr."""

    points: Floats
    derivative: Matrix
    second: Matrix
    weights: Floats

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

    def fold(self, row: Floats, parity: Parity) -> Floats:
        """Columns of all points to those of the points up to the middle; the last axis."""
        if parity == 0:
            return row
        count = row.shape[-1]
        half = (count + 1) // 2
        folded = row[..., :half] + parity * row[..., ::-1][..., :half]
        if count % 2:
            folded[..., -1] *= 0.5
        return np.asarray(folded, np.float64)

    def unfold(self, values: Floats, parity: Parity) -> Floats:
        """Values at the points up to the middle to those at all points; the last axis."""
        if parity == 0:
            return values
        mirrored = parity * values[..., ::-1][..., self.points.size % 2 :]
        return np.concatenate([values, mirrored], axis=-1)

    def family(self, parity: Parity = 0, *, smooth: bool = False) -> Family:
        """Fields of one parity, filtered if ``smooth``; a point in the middle is an unknown of odd ones too, of value zero."""
        count = self.points.size
        rows = slice(1, -1) if parity == 0 else slice(1, (count + 1) // 2)
        ends = [0, -1] if parity == 0 else [0]
        second, first = self.fold(self.second, parity)[rows], self.fold(self.derivative, parity)
        columns = slice(1, -1) if parity == 0 else slice(1, None)
        inside, slope = second[:, columns].copy(), first[rows][:, columns].copy()
        sieve = self.fold(_filter(count - 1, STRENGTH * smooth), parity)[: inside.shape[0]]
        middle = parity != 0 and count % 2 == 1
        if middle and parity == 1:
            slope[-1] = 0.0
        if middle and parity == -1:
            sieve[-1], sieve[:, -1] = 0.0, 0.0
            rates, forward, backward = _eigenvectors(inside[:-1, :-1])
            rates = np.append(rates, rates.min())
            forward, backward = (_padded(matrix) for matrix in (forward, backward))
        else:
            rates, forward, backward = _eigenvectors(inside)
        return Family(
            rates,
            forward,
            backward,
            second[:, ends],
            slope,
            first[rows][:, ends],
            first[ends][:, columns] @ backward,
            forward @ sieve,
        )


@dataclass(frozen=True)
class Grid:
    """Points and derivatives in a cross-section."""

    r: Line
    z: Line


def chebyshev_grid(annulus: Annulus, radial: int, axial: int) -> Grid:
    """``radial`` by ``axial`` intervals."""
    return Grid(line(annulus.inner, annulus.outer, radial, radial=True), line(0.0, annulus.height, axial, radial=False))


def line(begin: float, end: float, count: int, *, radial: bool) -> Line:
    """``count`` intervals; the operator is d2/dr2 - (1/r) d/dr if ``radial``, else d2/dz2."""
    points, first, weights = _chebyshev(count)
    half = 0.5 * (end - begin)
    points, first = begin + half * (1.0 + points), first / half
    second = first @ first
    if radial:
        second -= first / points[:, None]
    return Line(points, first, second, weights * half)


def _eigenvectors(matrix: Matrix) -> tuple[Floats, Matrix, Matrix]:
    rates, vectors = np.linalg.eig(matrix)
    order = np.argsort(-rates.real)
    rates, vectors = rates.real[order], np.ascontiguousarray(vectors.real[:, order])
    return rates, np.linalg.inv(vectors), vectors


def _padded(matrix: Matrix) -> Matrix:
    size = matrix.shape[0] + 1
    out = np.eye(size)
    out[:-1, :-1] = matrix
    return out


def _filter(count: int, strength: float) -> Matrix:
    """Low wave numbers pass, high ones fade, on the inner points of ``count`` intervals.

    The inner points are those of Gauss for the polynomials U_k, so the way to their shares and back is exact.
    """
    angle = math.pi * (count - np.arange(1, count)) / count
    k = np.arange(1, count)
    shapes = np.sin(np.outer(angle, k)) / np.sin(angle)[:, None]
    back = 2.0 / count * shapes * (np.sin(angle) ** 2)[:, None]
    over = np.maximum(0.0, (k / count - KEPT) / (1.0 - KEPT))
    return np.asarray((shapes * np.exp(-strength * over**POWER)) @ back.T, np.float64)


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
