"""One implicit step of the spectral flow solver, and the explicit terms of the fields that it gives."""

from __future__ import annotations

from numba import types

from autobalancer.kernels.flags import COMPILED, njit
from autobalancer.kernels.flow.dense import product, substitute
from autobalancer.kernels.flow.spectral_arrays import (
    AGO,
    CONVECTION,
    HEAD,
    LEVELS,
    REFERENCE,
    Plan,
    State,
    plan_type,
    state_type,
)
from autobalancer.kernels.system import Floats, vector_type


@njit(types.void(state_type, vector_type, types.int64, types.int64), **COMPILED)
def weigh(s: State, clock: Floats, order: int, known: int) -> None:
    """Weights of a step of length ``clock[AGO]``; the lengths before it follow, so that equal steps have equal weights."""
    for row in range(3):
        count = known if row == 2 else order
        total, lead = 0.0, 0.0
        for j in range(count):
            total += clock[AGO + j]
            x, other = 1.0, 0.0
            for k in range(count):
                other += clock[AGO + k]
                if k != j:
                    x *= other / (other - total)
            if row == 0:
                s.weights[0, j + 1] = -x / total
                lead += x / total
            else:
                s.weights[row, j] = x
        if row == 0:
            s.weights[0, 0] = lead


@njit(types.void(plan_type, state_type, types.boolean), **COMPILED)
def _green(p: Plan, s: State, diagonal: bool) -> None:
    """psi of the right-hand side ``s.b``."""
    m, n = p.odd_rates.shape
    for i in range(m):
        if diagonal:
            for j in range(n):
                s.psi_share[i, j] = s.green[i, j, j] * s.b[i, j]
        else:
            for j in range(n):
                s.psi_share[i, j] = 0.0
            for k in range(n):
                x = s.b[i, k]
                for j in range(n):
                    s.psi_share[i, j] += x * s.green[i, k, j]


@njit(types.void(plan_type, state_type, vector_type, types.int64, types.float64), **COMPILED)
def implicit(p: Plan, s: State, clock: Floats, order: int, rate: float) -> None:
    """The step that the weights and :func:`prepare` are for; it fills the level after the present one."""
    m, n = p.odd_rates.shape
    lids = p.d.shape[0]
    head, reference = int(clock[HEAD]), clock[REFERENCE]
    new = (head + 1) % LEVELS
    for i in range(m):
        for j in range(n):
            s.a[i, j], s.b[i, j] = p.lift[i, j] - rate * p.source[i, j], 0.0
        for k in range(order):
            level = (head - k) % LEVELS
            past, ahead = s.weights[0, k + 1], s.weights[1, k]
            wave = 2.0 * ahead * (s.speeds[level] - reference)
            for j in range(n):
                s.a[i, j] += (
                    ahead * s.g_rate[level, i, j] + wave * s.g_wave[level, i, j] - past * s.g_share[level, i, j]
                )
                s.b[i, j] += (
                    ahead * s.q_rate[level, i, j] + wave * s.q_wave[level, i, j] - past * s.q_share[level, i, j]
                )
        for j in range(n):
            s.a[i, j] *= s.scale[i, j]
    x = s.unknown
    for k in range(x.shape[0]):
        x[k] = 0.0
    if reference != 0.0:
        product(s.a, p.to_odd, s.q)
        for i in range(m):
            for j in range(n):
                s.b[i, j] += 2.0 * reference * (s.q[i, j] + p.wall_wave[i, j])
    _green(p, s, reference == 0.0)
    for i in range(m):
        for j in range(n):
            psi = s.psi_share[i, j]
            for w in range(2):
                x[w * n + j] -= p.p[w, i] * psi
            for w in range(lids):
                x[2 * n + w * m + i] -= p.s[w, j] * psi
    for k in range(x.shape[0]):
        x[k] *= s.rows[k]
    substitute(s.influence, s.pivots, x)
    for k in range(x.shape[0]):
        x[k] *= s.columns[k]
    for i in range(m):
        for j in range(n):
            s.b[i, j] += p.c[0, i] * x[j] + p.c[1, i] * x[n + j]
        for w in range(lids):
            for j in range(n):
                s.b[i, j] += p.d[w, j] * x[2 * n + w * m + i]
    _green(p, s, reference == 0.0)
    for i in range(m):
        for j in range(n):
            s.q_share[new, i, j] = -p.odd_rates[i, j] * s.psi_share[i, j]
    product(s.psi_share, p.to_even, s.g_wave[new])
    for i in range(m):
        for j in range(n):
            s.g_share[new, i, j] = s.a[i, j] + 2.0 * reference * s.g_wave[new, i, j] * s.scale[i, j]
    product(s.g_share[new], p.even_backward, s.a)
    product(p.r_backward, s.a, s.g[new])


@njit(types.void(plan_type, state_type, vector_type, types.float64), **COMPILED)
def remember(p: Plan, s: State, clock: Floats, speed: float) -> None:
    """Explicit terms of the present level, after :func:`implicit`, which leaves g in ``a``: shares along r, values along z."""
    m, n = p.odd_rates.shape
    now = int(clock[HEAD])
    s.speeds[now] = speed
    lids, nu = p.d.shape[0], p.viscosity
    product(p.r_slope, s.a, s.g_r)
    product(s.g[now], p.even_slope, s.g_z)
    product(s.g_share[now], p.to_odd, s.q_wave[now])
    product(s.q_share[now], p.odd_backward, s.a)
    product(p.r_backward, s.a, s.q)
    product(p.r_slope, s.a, s.q_r)
    product(s.q, p.odd_slope, s.q_z)
    product(s.psi_share, p.odd_backward, s.a)
    product(p.r_slope, s.a, s.psi_r)
    product(s.g_wave[now], p.even_backward, s.a)
    product(p.r_backward, s.a, s.psi_z)
    for w in range(2):
        for j in range(n):
            total = 0.0
            for k in range(n):
                total += s.unknown[w * n + k] * p.odd_backward[k, j]
            s.q_side[w, j] = total / nu
    for w in range(lids):
        for i in range(m):
            total = 0.0
            for k in range(m):
                total += s.unknown[2 * n + w * m + k] * p.r_backward[i, k]
            s.q_lid[w, i] = total / nu
    most = 0.0
    for i in range(m):
        over, dr, near, far = p.over_r[i], p.over_dr[i], p.near_r[0, i], p.near_r[1, i]
        for w in range(lids):
            lid = s.q_lid[w, i]
            for j in range(n):
                s.q_z[i, j] += lid * p.near_z[w, j]
        fastest = 0.0
        for j in range(n):
            u, v = -s.psi_z[i, j] * over, s.psi_r[i, j] * over
            g, g_z, q = s.g[now, i, j], s.g_z[i, j] + p.wall_z[i, j], s.q[i, j]
            q_r = s.q_r[i, j] + near * s.q_side[0, j] + far * s.q_side[1, j]
            s.a[i, j] = -u * (s.g_r[i, j] + p.wall_r[i, j]) - v * g_z
            s.b[i, j] = 2.0 * (u * q + g * g_z * over) * over - u * q_r - v * s.q_z[i, j]
            s.q_wave[now, i, j] += p.wall_wave[i, j]
            fastest = max(fastest, abs(u) * dr + abs(v) * p.over_dz[j])
        most = max(most, fastest)
    clock[CONVECTION] = most
    product(p.r_forward, s.a, s.g_r)
    product(s.g_r, p.even_forward, s.g_rate[now])
    product(p.r_forward, s.b, s.g_r)
    product(s.g_r, p.odd_forward, s.q_rate[now])


@njit(types.float64(plan_type, state_type, vector_type, types.int64), **COMPILED)
def missed(p: Plan, s: State, clock: Floats, known: int) -> float:
    """Root mean square of the new angular velocity less the one extrapolated from ``known`` instants, rad/s."""
    m, n = p.odd_rates.shape
    head = int(clock[HEAD])
    new = (head + 1) % LEVELS
    total = 0.0
    for i in range(m):
        for j in range(n):
            s.b[i, j] = s.g[new, i, j]
        for k in range(known):
            x, level = s.weights[2, k], (head - k) % LEVELS
            for j in range(n):
                s.b[i, j] -= x * s.g[level, i, j]
        part = 0.0
        for j in range(n):
            part += s.b[i, j] * s.b[i, j]
        total += part * p.over_r[i] ** 4
    return (total / (m * n)) ** 0.5
