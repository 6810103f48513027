"""The flow in an annulus by second-order differences: predictor and corrector on a stretched grid.

Scheme of Spannan 2021, section 3, in g = r^2 (W - w), q = r eta and psi; arrays are (radius, height) with the walls at their
ends, symbols are listed in ``autobalancer.flow``. A step is limited by convection and waves, as (3.18) with the magnitudes
that (3.19) lost, and by diffusion. Nothing is allocated; rows run along the axis.
"""

from __future__ import annotations

from typing import NamedTuple

from numba import types
from numba.core.types import NamedTuple as NamedTupleType
from numba.core.types import NamedUniTuple

from autobalancer.kernels.flags import COMPILED, njit
from autobalancer.kernels.flow.dense import product
from autobalancer.kernels.flow.speed import wall_speed
from autobalancer.kernels.system import Floats, Matrix, matrix_type, vector_type


class Cross(NamedTuple):
    """Grid, weights of three neighbors, direct solver and work space of a cross-section."""

    radius: Floats
    space_r: Floats  # mean of both neighbors, m
    space_z: Floats
    first_r: Matrix  # (radius, 3): d/dr
    second_r: Matrix  # d2/dr2 - (1/r) d/dr
    first_z: Matrix
    second_z: Matrix
    wall: Matrix  # (inner, outer, bottom, top; 2): second normal derivative from the two points next to a wall
    forward: Matrix  # height to eigenvectors of d2/dz2, transposed, and back
    backward: Matrix
    pivot: Matrix  # elimination in r for each of them
    upper: Matrix
    orbit_r: Floats  # weights of interpolation at the orbit
    orbit_z: Floats
    viscosity: float
    diffusive: float  # longest step that diffusion allows, s
    reach: float  # step times (2 w + convection)


class Fields(NamedTuple):
    """g, q, psi now and at the predictor, and room for transforms."""

    g: Matrix
    q: Matrix
    psi: Matrix
    g_half: Matrix
    q_half: Matrix
    work: Matrix
    turned: Matrix


cross_type = NamedTupleType([vector_type] * 3 + [matrix_type] * 9 + [vector_type] * 2 + [types.float64] * 3, Cross)
fields_type = NamedUniTuple(matrix_type, 7, Fields)


@njit(types.void(cross_type, matrix_type, fields_type), **COMPILED)
def poisson(p: Cross, q: Matrix, f: Fields) -> None:
    """psi from D2 psi = -q: eigenvectors along the axis, elimination along the radius."""
    m, n = p.pivot.shape
    for i in range(m):
        for j in range(n):
            f.work[i, j] = -q[i + 1, j + 1]
    product(f.work, p.forward, f.turned)
    for j in range(n):
        f.turned[0, j] *= p.pivot[0, j]
    for i in range(1, m):
        lower = p.second_r[i + 1, 0]
        for j in range(n):
            f.turned[i, j] = (f.turned[i, j] - lower * f.turned[i - 1, j]) * p.pivot[i, j]
    for i in range(m - 2, -1, -1):
        for j in range(n):
            f.turned[i, j] -= p.upper[i, j] * f.turned[i + 1, j]
    product(f.turned, p.backward, f.work)
    for i in range(m):
        for j in range(n):
            f.psi[i + 1, j + 1] = f.work[i, j]


@njit(types.void(cross_type, matrix_type, matrix_type), **COMPILED)
def wall_vorticity(p: Cross, psi: Matrix, q: Matrix) -> None:
    """q = -psi_nn at the walls from the two points next to them, second order (Spannan 2021, 3.16, 3.17)."""
    m, n = q.shape[0] - 1, q.shape[1] - 1
    for j in range(1, n):
        q[0, j] = -(p.wall[0, 0] * psi[1, j] + p.wall[0, 1] * psi[2, j])
        q[m, j] = -(p.wall[1, 0] * psi[m - 1, j] + p.wall[1, 1] * psi[m - 2, j])
    for i in range(1, m):
        q[i, 0] = -(p.wall[2, 0] * psi[i, 1] + p.wall[2, 1] * psi[i, 2])
        q[i, n] = -(p.wall[3, 0] * psi[i, n - 1] + p.wall[3, 1] * psi[i, n - 2])


@njit(types.float64(cross_type, matrix_type), **COMPILED)
def convection(p: Cross, psi: Matrix) -> float:
    """Greatest |u_r|/dr + |u_z|/dz, 1/s."""
    most = 0.0
    for i in range(1, psi.shape[0] - 1):
        for j in range(1, psi.shape[1] - 1):
            along_r = p.first_r[i, 0] * psi[i - 1, j] + p.first_r[i, 1] * psi[i, j] + p.first_r[i, 2] * psi[i + 1, j]
            along_z = p.first_z[j, 0] * psi[i, j - 1] + p.first_z[j, 1] * psi[i, j] + p.first_z[j, 2] * psi[i, j + 1]
            rate = (abs(along_z) / p.space_r[i] + abs(along_r) / p.space_z[j]) / p.radius[i]
            if rate > most:
                most = rate
    return most


@njit(
    types.void(
        cross_type, matrix_type, matrix_type, matrix_type, matrix_type, matrix_type,
        types.float64, types.float64, types.float64, matrix_type, matrix_type,
    ),
    **COMPILED,
)  # fmt: skip
def advance(
    p: Cross,
    g: Matrix,
    q: Matrix,
    psi: Matrix,
    g0: Matrix,
    q0: Matrix,
    step: float,
    speed: float,
    rate: float,
    g_new: Matrix,
    q_new: Matrix,
) -> None:
    """g_new = g0 + step g_t(g, q, psi), and q likewise, at the inner points."""
    nu = p.viscosity
    for i in range(1, g.shape[0] - 1):
        r = p.radius[i]
        a0, a1, a2 = p.first_r[i, 0], p.first_r[i, 1], p.first_r[i, 2]
        b0, b1, b2 = p.second_r[i, 0], p.second_r[i, 1], p.second_r[i, 2]
        for j in range(1, g.shape[1] - 1):
            c0, c1, c2 = p.first_z[j, 0], p.first_z[j, 1], p.first_z[j, 2]
            d0, d1, d2 = p.second_z[j, 0], p.second_z[j, 1], p.second_z[j, 2]
            psi_z = c0 * psi[i, j - 1] + c1 * psi[i, j] + c2 * psi[i, j + 1]
            u = -psi_z / r
            v = (a0 * psi[i - 1, j] + a1 * psi[i, j] + a2 * psi[i + 1, j]) / r
            g_z = c0 * g[i, j - 1] + c1 * g[i, j] + c2 * g[i, j + 1]
            g_r = a0 * g[i - 1, j] + a1 * g[i, j] + a2 * g[i + 1, j]
            g_d = (
                b0 * g[i - 1, j] + b1 * g[i, j] + b2 * g[i + 1, j] + d0 * g[i, j - 1] + d1 * g[i, j] + d2 * g[i, j + 1]
            )
            q_z = c0 * q[i, j - 1] + c1 * q[i, j] + c2 * q[i, j + 1]
            q_r = a0 * q[i - 1, j] + a1 * q[i, j] + a2 * q[i + 1, j]
            q_d = (
                b0 * q[i - 1, j] + b1 * q[i, j] + b2 * q[i + 1, j] + d0 * q[i, j - 1] + d1 * q[i, j] + d2 * q[i, j + 1]
            )
            g_t = nu * g_d - u * g_r - v * g_z + 2.0 * speed * psi_z - r * r * rate
            q_t = nu * q_d - u * q_r - v * q_z + 2.0 * (u * q[i, j] / r + g[i, j] * g_z / (r * r) + speed * g_z)
            g_new[i, j] = g0[i, j] + step * g_t
            q_new[i, j] = q0[i, j] + step * q_t


@njit(
    types.int64(
        cross_type, fields_type, vector_type, types.float64, types.float64, vector_type, types.float64,
        types.float64, matrix_type,
    ),
    **COMPILED,
)  # fmt: skip
def march(
    p: Cross,
    f: Fields,
    clock: Floats,
    start: float,
    kind: float,
    numbers: Floats,
    end: float,
    fixed: float,
    record: Matrix,
) -> int:
    """Steps from ``clock[0]`` to ``end`` within one piece of the speed, at most as many as ``record`` has rows.

    A row of the record is time, rotor speed, speed of the fluid at the orbit relative to it. ``fixed`` is the step to
    take, or 0 for the longest stable one. Returns the number of steps; it is negative if the flow blew up.
    """
    for count in range(record.shape[0]):
        time = clock[0]
        if time >= end:
            return count
        speed, rate = wall_speed(time, start, kind, numbers)
        rates = convection(p, f.psi) + 2.0 * abs(speed)
        if not rates < 1e15:
            return -1 - count
        step = fixed if fixed > 0.0 else min(p.diffusive, p.reach / max(rates, 1e-300))
        left = end - time
        last = left <= step * 1.000001
        if last:
            step = left
        advance(p, f.g, f.q, f.psi, f.g, f.q, 0.5 * step, speed, rate, f.g_half, f.q_half)
        poisson(p, f.q_half, f)
        wall_vorticity(p, f.psi, f.q_half)
        speed, rate = wall_speed(time + 0.5 * step, start, kind, numbers)
        advance(p, f.g_half, f.q_half, f.psi, f.g, f.q, step, speed, rate, f.g, f.q)
        poisson(p, f.q, f)
        wall_vorticity(p, f.psi, f.q)
        clock[0] = end if last else time + step
        total = 0.0
        for i in range(p.orbit_r.shape[0]):
            if p.orbit_r[i] != 0.0:
                for j in range(p.orbit_z.shape[0]):
                    total += p.orbit_r[i] * p.orbit_z[j] * f.g[i, j]
        record[count, 0] = clock[0]
        record[count, 1] = wall_speed(clock[0], start, kind, numbers)[0]
        record[count, 2] = total
    return record.shape[0]
