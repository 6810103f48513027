"""The implicit step of the spectral flow solver: its inverse row by row, and wall vorticity by an influence matrix.

With s the leading weight of the derivative, W the reference speed of the rotor, K and K' the slopes along z in shares and F
what is known, a step is

    (s - nu L) g = F_g + 2 W K psi,   (s - nu L) q = F_q + 2 W K' g + c x + d y,   q = -L psi,

x, y being nu times the vorticity on the walls. K and K' act along z only, so each share along r is a small system of its own,

    M_i psi_i = F_q + 2 W K' F_g/(s - nu L) + c_i x + d y_i,   M_i = (s - nu L)(-L) - 4 W^2 K' (s - nu L)^-1 K.

At the walls psi vanishes and so do its slopes, sum_i p_i psi_i = 0 and sum_j s_j psi_ij = 0. This is a linear system for x and y,
the influence matrix (Ehrenstein and Peyret 1989). It is singular once for each corner, where a pattern of wall values acts on
no inner point; these patterns are filled up.
"""

from __future__ import annotations

from numba import types

from autobalancer.kernels.flags import COMPILED, njit
from autobalancer.kernels.flow.dense import factorize, invert
from autobalancer.kernels.flow.spectral_arrays import Plan, State, plan_type, state_type
from autobalancer.kernels.system import Matrix, matrix_type


@njit(types.void(plan_type, state_type, types.float64, types.float64), **COMPILED)
def _rows(p: Plan, s: State, shift: float, reference: float) -> None:
    """Inverses of M_i; of a reference of zero only the diagonals are set, because there is nothing else."""
    m, n = p.odd_rates.shape
    squared = 4.0 * reference * reference
    for i in range(m):
        if reference == 0.0:
            for j in range(n):
                for k in range(n):
                    s.green[i, j, k] = 0.0
                s.green[i, j, j] = 1.0 / ((p.viscosity * p.odd_rates[i, j] - shift) * p.odd_rates[i, j])
            continue
        for j in range(n):
            own = 1.0 / ((p.viscosity * p.odd_rates[i, j] - shift) * p.odd_rates[i, j])
            for k in range(n):
                s.block[j, k] = 0.0
            for k in range(n):
                x = p.to_odd[k, j] * s.scale[i, k] * squared * own
                for other in range(n):
                    s.block[j, other] -= x * p.to_even[other, k]
            s.block[j, j] += 1.0
        invert(s.block, s.pivots)
        for j in range(n):
            for k in range(n):
                s.green[i, k, j] = s.block[j, k] / ((p.viscosity * p.odd_rates[i, k] - shift) * p.odd_rates[i, k])


@njit(types.void(plan_type, state_type), **COMPILED)
def _influence(p: Plan, s: State) -> None:
    """Slopes at the walls over the wall vorticity."""
    m, n = p.odd_rates.shape
    lids = p.d.shape[0]
    a = s.influence
    for i in range(a.shape[0]):
        for j in range(a.shape[0]):
            a[i, j] = 0.0
    for i in range(m):
        for j in range(n):
            for u in range(2):
                for v in range(2):
                    x = p.p[u, i] * p.c[v, i]
                    for k in range(n):
                        a[u * n + j, v * n + k] += x * s.green[i, k, j]
            for k in range(n):
                green = s.green[i, k, j]
                for w in range(lids):
                    at = 2 * n + w * m + i
                    for u in range(2):
                        a[u * n + j, at] += p.p[u, i] * green * p.d[w, k]
                        a[at, u * n + k] += p.s[w, j] * green * p.c[u, i]
                    for v in range(lids):
                        a[at, 2 * n + v * m + i] += p.s[w, j] * green * p.d[v, k]


@njit(types.void(matrix_type, state_type), **COMPILED)
def _balance(a: Matrix, s: State) -> None:
    """Rows and columns scaled to a greatest entry of one; the scales are kept."""
    size = a.shape[0]
    for i in range(size):
        most = 0.0
        for j in range(size):
            most = max(most, abs(a[i, j]))
        s.rows[i] = 1.0 / most
    for j in range(size):
        s.columns[j] = 0.0
    for i in range(size):
        for j in range(size):
            s.columns[j] = max(s.columns[j], abs(a[i, j]) * s.rows[i])
    for j in range(size):
        s.columns[j] = 1.0 / s.columns[j]
    for i in range(size):
        for j in range(size):
            a[i, j] *= s.rows[i] * s.columns[j]


@njit(types.void(plan_type, state_type, types.float64, types.float64), **COMPILED)
def prepare(p: Plan, s: State, shift: float, reference: float) -> None:
    """Everything that depends on the leading weight of a step and on the reference speed."""
    m, n = p.odd_rates.shape
    for i in range(m):
        for j in range(n):
            s.scale[i, j] = 1.0 / (shift - p.viscosity * p.even_rates[i, j])
    _rows(p, s, shift, reference)
    _influence(p, s)
    _balance(s.influence, s)
    size = s.influence.shape[0]
    for corner in range(p.right.shape[0]):
        left, right = 0.0, 0.0
        for i in range(size):
            left += (p.left[corner, i] / s.rows[i]) ** 2
            right += (p.right[corner, i] / s.columns[i]) ** 2
        norm = 1.0 / (left * right) ** 0.5
        for i in range(size):
            x = p.left[corner, i] / s.rows[i] * norm
            for j in range(size):
                s.influence[i, j] += x * p.right[corner, j] / s.columns[j]
    factorize(s.influence, s.pivots)
