"""Orthogonal collocation on a mesh over one period (de Boor and Swartz 1973; Doedel et al. 1991).

On each of N intervals the orbit is a polynomial of degree m that satisfies the equations at the m Gauss points. The linear
systems are condensed: inside an interval all is expressed by its first node, so that a small system for the first node of the
orbit is left, and the product of the interval matrices is the monodromy matrix.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from autobalancer.stability.host.planar import Floats, Matrix

DEGREE = 4


@cache
def basis() -> tuple[Matrix, Matrix, Floats, Matrix]:
    """Values and derivatives of the Lagrange basis at the Gauss points, Gauss weights, highest derivative; unit interval."""
    nodes = np.linspace(0.0, 1.0, DEGREE + 1)
    gauss, weights = np.polynomial.legendre.leggauss(DEGREE)
    gauss, weights = 0.5 * (gauss + 1.0), 0.5 * weights
    powers = np.vander(nodes, increasing=True)
    coefficients = np.linalg.inv(powers)  # row k: factor of x^k for each node
    values = np.vander(gauss, DEGREE + 1, increasing=True) @ coefficients
    order = np.arange(DEGREE + 1)
    slopes = np.where(order > 0, order * gauss[:, None] ** np.maximum(order - 1, 0), 0.0) @ coefficients
    return np.asarray(values), np.asarray(slopes), np.asarray(weights, np.float64), np.asarray(coefficients, np.float64)


@dataclass(frozen=True)
class Mesh:
    """Edges of the intervals over the unit period, (N + 1,)."""

    edges: Floats

    @property
    def count(self) -> int:
        """Number of intervals."""
        return self.edges.size - 1

    @property
    def nodes(self) -> Floats:
        """Times of all nodes, (N m + 1,)."""
        steps = np.diff(self.edges)[:, None] * np.arange(DEGREE) / DEGREE
        return np.append((self.edges[:-1, None] + steps).ravel(), 1.0)

    def pieces(self, states: Matrix) -> Any:
        """Nodes by interval, (N, m + 1, d), from (N m + 1, d)."""
        index = np.arange(self.count)[:, None] * DEGREE + np.arange(DEGREE + 1)
        return states[index]

    def at_gauss(self, states: Matrix) -> Any:
        """States at the Gauss points, (N, m, d)."""
        return basis()[0] @ self.pieces(states)

    def slopes_at_gauss(self, states: Matrix) -> Any:
        """Derivatives over the unit period at the Gauss points, (N, m, d)."""
        return basis()[1] @ self.pieces(states) / np.diff(self.edges)[:, None, None]

    def weights(self) -> Matrix:
        """Gauss weights of the whole period, (N, m)."""
        return np.asarray(np.diff(self.edges)[:, None] * basis()[2])

    def interpolated(self, states: Matrix, times: Floats) -> Matrix:
        """The orbit at any times of the unit period."""
        place = np.clip(np.searchsorted(self.edges, times, side="right") - 1, 0, self.count - 1)
        x = (times - self.edges[place]) / np.diff(self.edges)[place]
        rows = np.vander(x, DEGREE + 1, increasing=True) @ basis()[3]
        return np.asarray(np.einsum("tj,tjd->td", rows, self.pieces(states)[place]))

    def adapted(self, states: Matrix) -> Mesh:
        """A mesh on which the estimated error is even: de Boor's rule with the derivative of order m + 1."""
        widths = np.diff(self.edges)
        highest = np.einsum("j,njd->nd", basis()[3][-1], self.pieces(states)) / widths[:, None] ** DEGREE
        apart = 0.5 * (widths + np.roll(widths, -1))
        jumps = np.linalg.norm(np.roll(highest, -1, axis=0) - highest, axis=1) / apart
        density = (0.5 * (jumps + np.roll(jumps, 1))) ** (1.0 / (DEGREE + 1))
        density = density + 0.1 * density.mean() + 1e-300
        total = np.concatenate([[0.0], np.cumsum(density * widths)])
        edges = np.interp(np.linspace(0.0, total[-1], self.count + 1), total, self.edges)
        edges[0], edges[-1] = 0.0, 1.0
        return Mesh(edges)


@dataclass(frozen=True)
class Condensed:
    """All nodes as ``nodes @ (first node, extra unknowns, 1)``, (N m + 1, d, d + e + 1)."""

    nodes: Any

    @property
    def monodromy(self) -> Matrix:
        """The last node by the first one."""
        d = self.nodes.shape[1]
        return np.asarray(self.nodes[-1, :, :d])


def condensed(mesh: Mesh, jacobians: Any, extra: Any, right: Any) -> Condensed:
    """Solve sum_j slopes x_j / h - A sum_j values x_j + extra . y = right inside all intervals.

    ``jacobians`` (N, m, d, d), ``extra`` (N, m, d, e), ``right`` (N, m, d).
    """
    values, slopes, _, _ = basis()
    n, m, d, _ = jacobians.shape
    e = extra.shape[-1]
    widths = np.diff(mesh.edges)
    blocks = np.einsum("kj,ab,n->nkajb", slopes, np.eye(d), 1.0 / widths) - np.einsum(
        "kj,nkab->nkajb", values, jacobians
    )
    inner = blocks[:, :, :, 1:, :].reshape(n, m * d, m * d)
    side = np.concatenate([-blocks[:, :, :, 0, :], -extra, right[..., None]], -1).reshape(n, m * d, d + e + 1)
    local = np.linalg.solve(inner, side).reshape(n, m, d, d + e + 1)
    nodes = np.zeros((n * m + 1, d, d + e + 1))
    nodes[0, :, :d] = np.eye(d)
    for i in range(n):
        first = nodes[i * m]
        piece = local[i, :, :, :d] @ first
        piece[:, :, d:] += local[i, :, :, d:]
        nodes[i * m + 1 : (i + 1) * m + 1] = piece
    return Condensed(nodes)
