"""Wall vorticity by an influence matrix.

At the walls the stream function and its normal derivative vanish; the vorticity there is whatever this takes. An implicit
step solves (s - nu D2) q = f, D2 psi = -q, psi = 0 on the walls. In the eigenbasis of D2, with G = 1/((s - nu L)(-L)),

    psi_ij = G_ij (f_ij + nu (c0_i x0_j + c1_i x1_j + d0_j y0_i + d1_j y1_i)),

where c and d are the columns of D2 that belong to the walls and x, y the vorticities on them. Vanishing slopes,
sum_i p_i psi_ij = 0 and sum_j s_j psi_ij = 0, are a linear system for x and y (Ehrenstein and Peyret 1989). Its matrix is
singular four times, once for each corner: a pattern of wall values that acts on no inner point. These patterns do not
depend on the step, and are filled up.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from autobalancer.flow.annulus import Floats, Matrix
from autobalancer.flow.chebyshev import Grid


@dataclass(frozen=True)
class Traces:
    """Walls in the eigenbasis: columns of D2 (c, d), slopes at the walls (p, s), null patterns."""

    c: Matrix  # (inner r, wall)
    d: Matrix  # (inner z, wall)
    p: Matrix  # (wall, inner r)
    s: Matrix  # (wall, inner z)
    right: Matrix  # (unknown, corner)
    left: Matrix


def traces(grid: Grid) -> Traces:
    """Everything about the walls that does not depend on the step."""
    c, d = grid.r.forward @ grid.r.walls, grid.z.forward @ grid.z.walls
    p = grid.r.derivative[[0, -1], 1:-1] @ grid.r.backward
    s = grid.z.derivative[[0, -1], 1:-1] @ grid.z.backward
    m, n = c.shape[0], d.shape[0]
    right, left = np.zeros((2 * (m + n), 4)), np.zeros((2 * (m + n), 4))
    for corner, (i, j) in enumerate(((0, 0), (0, 1), (1, 0), (1, 1))):
        right[i * n : (i + 1) * n, corner] = d[:, j]
        right[2 * n + j * m : 2 * n + (j + 1) * m, corner] = -c[:, i]
        left[i * n : (i + 1) * n, corner] = s[j]
        left[2 * n + j * m : 2 * n + (j + 1) * m, corner] = -p[i]
    return Traces(c, d, p, s, right / np.linalg.norm(right, axis=0), left / np.linalg.norm(left, axis=0))


class Influence:
    """The implicit step (s - nu D2) q = f with no slip at the walls, for one s (1/s)."""

    def __init__(self, grid: Grid, walls: Traces, shift: float, viscosity: float) -> None:
        self.walls, self.viscosity = walls, viscosity
        self.scale = 1.0 / (shift - viscosity * grid.laplacian)
        self.poisson = -1.0 / grid.laplacian
        self.green = g = self.scale * self.poisson
        c, d, p, s = walls.c, walls.d, walls.p, walls.s
        m, n = g.shape
        matrix = np.zeros((2 * (m + n), 2 * (m + n)))
        for i in range(2):
            rows = slice(i * n, (i + 1) * n)
            other = slice(2 * n + i * m, 2 * n + (i + 1) * m)
            for j in range(2):
                radial, axial = slice(j * n, (j + 1) * n), slice(2 * n + j * m, 2 * n + (j + 1) * m)
                matrix[rows, radial] = np.diag((p[i] * c[:, j]) @ g)
                matrix[rows, axial] = ((p[i][:, None] * g) * d[:, j]).T
                matrix[other, radial] = (s[i] * g) * c[:, j][:, None]
                matrix[other, axial] = np.diag(g @ (s[i] * d[:, j]))
        self.rows = 1.0 / np.abs(matrix).max(axis=1)
        matrix *= self.rows[:, None]
        self.columns = 1.0 / np.abs(matrix).max(axis=0)
        matrix *= self.columns
        left, right = walls.left / self.rows[:, None], walls.right / self.columns[:, None]
        left /= np.linalg.norm(left, axis=0)
        right /= np.linalg.norm(right, axis=0)
        self.factors = lu_factor(matrix + left @ right.T, overwrite_a=True, check_finite=False)

    def solve(self, f: Matrix) -> tuple[Matrix, Matrix, tuple[Matrix, Matrix]]:
        """q and psi in the eigenbasis, and q on the walls: (wall, inner z) and (wall, inner r), in it too."""
        walls, (m, n) = self.walls, f.shape
        slopes = self.green * f
        given = np.concatenate([(walls.p @ slopes).ravel(), (slopes @ walls.s.T).T.ravel()])
        found: Floats = lu_solve(self.factors, -self.rows * given, check_finite=False) * self.columns
        x, y = found[: 2 * n].reshape(2, n), found[2 * n :].reshape(2, m)
        q = self.scale * (f + walls.c @ x + y.T @ walls.d.T)
        return q, q * self.poisson, (x / self.viscosity, y / self.viscosity)
