"""The full equations by finite differences on a stretched grid: what the spectral solver is measured against.

Scheme of Spannan 2021, section 3, after Lopez (1998), in g = r^2 (W - w), q = r eta and psi: second order, predictor and
corrector; arrays are (radius, height) with the walls at their ends, symbols are listed in ``autobalancer.flow``. Two limits
of the step are added that the source does not give: diffusion, and magnitudes in (3.19). The fastest decaying pattern is
found by multiplication, because the wall vorticity makes it up to several times faster than D^2 alone. The stretching must
be below 1/(2 pi), not 1.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numba import types
from numba.core.types import NamedTuple as NamedTupleType
from numba.core.types import NamedUniTuple

from autobalancer.flow.annulus import Annulus, Walls
from autobalancer.flow.relaxation import Track, WallSpeed
from autobalancer.kernels.annulus_flow import product, wall_speed
from autobalancer.kernels.compiler.flags import COMPILED, njit
from autobalancer.kernels.system import Floats, Matrix, matrix_type, vector_type

REACH = 0.6  # step times (2 w + convection rate)
DIFFUSIVE = 0.9  # of the limit of the predictor-corrector scheme on the real axis, step times rate = 2
POWERS = 60  # multiplications that find the fastest decaying pattern
STRETCHING = 0.1  # Spannan 2021, figure 3.4; the mapping is monotonic below 1/(2 pi)
CHUNK = 2000  # steps of one record


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


class DifferenceFlow:
    """State and steps on ``radial`` by ``axial`` cells."""

    def __init__(
        self,
        annulus: Annulus,
        radial: int,
        axial: int,
        *,
        walls: Walls | None = None,
    ) -> None:
        self.annulus = annulus
        self.radius = annulus.inner + annulus.width * _stretched(radial, STRETCHING)
        self.height = annulus.height * _stretched(axial, STRETCHING)
        self.walls = (walls or Walls()).momentum(annulus, self.radius, self.height)
        self._cross = _cross(annulus, self.radius, self.height)
        shape, inner = (radial + 1, axial + 1), (radial - 1, axial - 1)
        self._fields = Fields(*(np.zeros(shape) for _ in range(5)), *(np.zeros(inner) for _ in range(2)))

    @property
    def swirl(self) -> Matrix:
        """g = r^2 (W - w), m^2/s."""
        return self._fields.g

    @property
    def vorticity(self) -> Matrix:
        """q = r eta."""
        return self._fields.q

    @property
    def stream(self) -> Matrix:
        """psi, m^3/s."""
        return self._fields.psi

    def orbit_speed(self) -> float:
        """Angular velocity of the fluid at the orbit relative to the rotor, rad/s."""
        return float(self._cross.orbit_r @ self.swirl @ self._cross.orbit_z)

    def momentum(self, speed: float) -> float:
        """Angular momentum of the fluid at the rotor speed ``speed``, kg m^2/s."""
        total = (self.swirl + self.radius[:, None] ** 2 * speed) * self.radius[:, None]
        return float(
            2.0 * np.pi * self.annulus.density * np.trapezoid(np.trapezoid(total, self.height, axis=1), self.radius)
        )

    def torque(self) -> float:
        """Torque of the walls on the fluid, N m; second order."""
        g, r, z = self.swirl, self.radius, self.height
        around = [np.trapezoid(r[i] * _slope(r, g, i) - 2.0 * g[i], z) for i in (0, -1)]
        lids = [np.trapezoid(r * _slope(z, g.T, j), r) for j in (0, -1)]
        turning = around[1] - around[0] + lids[1] - lids[0]
        return float(2.0 * np.pi * self.annulus.density * self.annulus.viscosity * turning)

    def march(
        self,
        speed: WallSpeed,
        end: float,
        *,
        stops: Sequence[float] = (),
        at_stop: Callable[[float], None] = lambda time: None,
        fixed: float = 0.0,
    ) -> Track:
        """Run from time zero to ``end``; the step is the longest stable one."""
        f, first = self._fields, speed.at(0.0)[0]
        f.g[:] = self.walls
        f.g[1:-1, 1:-1] = self.radius[1:-1, None] ** 2 * (speed.before - first)
        f.q[:], f.psi[:] = 0.0, 0.0
        f.g_half[:], f.q_half[:] = f.g, 0.0
        track = Track()
        track.note(0.0, first, speed.before - first)
        if 0.0 in stops:
            at_stop(0.0)
        clock, record = np.zeros(1), np.empty((CHUNK, 3))
        for mark in sorted({*(t for t in stops if 0.0 < t < end), *speed.corners(end), end}):
            piece = speed.piece(float(clock[0]))
            numbers = np.array(piece.numbers, np.float64)
            while clock[0] < mark:
                done = march(self._cross, f, clock, piece.start, float(piece.kind), numbers, mark, fixed, record)
                assert done >= 0, f"diverged at {clock[0]:.4g} s: the flow is not resolved; take more points"
                for time, w, lag in record[:done].tolist():
                    track.note(time, w, lag)
                track.steps += done
            if mark in stops:
                at_stop(mark)
        return track


def _stretched(count: int, stretching: float) -> Floats:
    """From 0 to 1, finer at both ends (Spannan 2021, 3.21, 3.22)."""
    share = np.arange(count + 1) / count
    return np.asarray(share - stretching * np.sin(2.0 * np.pi * share), np.float64)


def _weights(points: Floats) -> tuple[Matrix, Matrix]:
    """Three-point weights of first and second derivative at the inner points (Spannan 2021, table 3.1)."""
    low, high = np.diff(points)[:-1], np.diff(points)[1:]
    first, second = np.zeros((points.size, 3)), np.zeros((points.size, 3))
    scale = 1.0 / (low * high * (low + high))
    first[1:-1] = (scale * np.stack([-(high**2), high**2 - low**2, low**2])).T
    second[1:-1] = (scale * np.stack([2.0 * high, -2.0 * (low + high), 2.0 * low])).T
    return first, second


def _wall_weights(points: Floats) -> tuple[float, float]:
    """Second derivative at a wall where value and slope vanish, from the two points next to it: a cubic."""
    h1, h2 = abs(points[1] - points[0]), abs(points[2] - points[0])
    scale = 2.0 / (h1**2 * h2**3 - h2**2 * h1**3)
    return float(scale * h2**3), float(-scale * h1**3)


def _at(points: Floats, place: float) -> Floats:
    """Weights of cubic interpolation at ``place``."""
    left = int(np.clip(np.searchsorted(points, place) - 2, 0, points.size - 4))
    weights = np.zeros(points.size)
    for j in range(left, left + 4):
        others = np.delete(points[left : left + 4], j - left)
        weights[j] = np.prod((place - others) / (points[j] - others))
    return weights


def _cross(annulus: Annulus, r: Floats, z: Floats) -> Cross:
    first_r, second_r = _weights(r)
    second_r -= first_r / r[:, None]
    first_z, second_z = _weights(z)
    rates, forward, backward = _eigenvectors(second_z)
    m, n = r.size - 2, z.size - 2
    pivot, upper = np.empty((m, n)), np.zeros((m, n))
    for i in range(m):
        row = second_r[i + 1]
        pivot[i] = 1.0 / (row[1] + rates - (row[0] * upper[i - 1] if i else 0.0))
        upper[i] = row[2] * pivot[i]
    fastest = float(np.abs(_eigenvectors(second_r)[0]).max() + np.abs(rates).max())
    cross = Cross(
        radius=r,
        space_r=np.gradient(r),
        space_z=np.gradient(z),
        first_r=first_r,
        second_r=second_r,
        first_z=first_z,
        second_z=second_z,
        wall=np.array([_wall_weights(p) for p in (r, r[::-1], z, z[::-1])]),
        forward=np.ascontiguousarray(forward.T),
        backward=np.ascontiguousarray(backward.T),
        pivot=pivot,
        upper=upper,
        orbit_r=_at(r, annulus.orbit_radius) / annulus.orbit_radius**2,
        orbit_z=_at(z, 0.5 * annulus.height),
        viscosity=annulus.viscosity,
        diffusive=DIFFUSIVE * 2.0 / (annulus.viscosity * fastest),
        reach=REACH,
    )
    return cross._replace(diffusive=min(cross.diffusive, DIFFUSIVE * 2.0 / _fastest(cross)))


def _fastest(cross: Cross) -> float:
    """Fastest decay rate of vorticity that diffuses and feels the walls, 1/s; the walls make it faster than D2 alone."""
    shape = cross.radius.size, cross.space_z.size
    rng = np.random.default_rng(0)
    none, unused, q, new = (np.zeros(shape) for _ in range(4))
    f = Fields(*(np.zeros(shape) for _ in range(5)), *(np.zeros_like(cross.pivot) for _ in range(2)))
    q[1:-1, 1:-1] = rng.standard_normal(cross.pivot.shape)
    rate = 0.0
    for _ in range(POWERS):
        poisson(cross, q, f)
        wall_vorticity(cross, f.psi, q)
        advance(cross, none, q, none, none, none, 1.0, 0.0, 0.0, unused, new)
        rate = float(np.linalg.norm(new) / np.linalg.norm(q[1:-1, 1:-1]))
        q[1:-1, 1:-1] = new[1:-1, 1:-1] / np.linalg.norm(new)
    return rate


def _eigenvectors(second: Matrix) -> tuple[Floats, Matrix, Matrix]:
    """Of the tridiagonal operator between the walls: rates, way there and way back; it is similar to a symmetric one."""
    middle, below, above = second[1:-1, 1], second[2:-1, 0], second[1:-2, 2]
    scale = np.concatenate([[1.0], np.cumprod(np.sqrt(above / below))])  # S A S^-1 is symmetric
    off = np.sqrt(above * below)
    rates, vectors = np.linalg.eigh(np.diag(middle) + np.diag(off, 1) + np.diag(off, -1))
    return rates, vectors.T * scale, vectors / scale[:, None]


def _slope(points: Floats, field: Matrix, end: int) -> Floats:
    """First derivative at a wall (``end`` 0 or -1) along axis 0 from three points, second order."""
    i, j, k = (0, 1, 2) if end == 0 else (-1, -2, -3)
    h1, h2 = points[j] - points[i], points[k] - points[i]
    return np.asarray(
        ((field[j] - field[i]) * h2**2 - (field[k] - field[i]) * h1**2) / (h1 * h2 * (h2 - h1)), np.float64
    )
