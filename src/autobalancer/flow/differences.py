"""The full equations by finite differences on a stretched grid: what the spectral solver is measured against."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.flow.annulus import Annulus, Floats, Matrix, Walls
from autobalancer.flow.choice import CELL, LOOKS
from autobalancer.flow.speed import WallSpeed
from autobalancer.flow.track import Progress, Track
from autobalancer.kernels.flow.differences import Cross, Fields, advance, poisson, wall_vorticity
from autobalancer.kernels.flow.differences import march as march_steps

REACH = 0.6  # step times (2 w + convection rate)
DIFFUSIVE = 0.9  # of the limit of the predictor-corrector scheme on the real axis, step times rate = 2
POWERS = 60  # multiplications that find the fastest decaying pattern
STRETCHING = 0.1  # Spannan 2021, figure 3.4; the mapping is monotonic below 1/(2 pi)
CHUNK = 2000  # steps between two looks at the progress bar


class DifferenceFlow:
    """State and steps on ``radial`` by ``axial`` cells."""

    def __init__(
        self,
        annulus: Annulus,
        radial: int,
        axial: int,
        *,
        walls: Walls | None = None,
        stretching: float = STRETCHING,
    ) -> None:
        if not 0.0 <= stretching < 0.5 / math.pi:
            raise QuestionError(
                f"stretching: given {stretching:g}; must be at least 0 and below 1/(2 pi) = 0.159, where points would "
                "coincide"
            )
        self.annulus = annulus
        self.radius = annulus.inner + annulus.width * _stretched(radial, stretching)
        self.height = annulus.height * _stretched(axial, stretching)
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

    def seconds(self, speed: WallSpeed, end: float) -> float:
        """About how long :meth:`march` takes, s."""
        cells, axial = (self.radius.size - 1) * (self.height.size - 1), self.height.size - 1
        return self.steps(speed, end) * cells * (CELL[0] + CELL[1] * axial)

    def steps(self, speed: WallSpeed, end: float) -> float:
        """About how many steps :meth:`march` takes where convection does not shorten them."""
        times = np.linspace(0.0, end, LOOKS)
        rates = np.maximum(1.0 / self._cross.diffusive, 2.0 * np.abs(speed.over(times)) / REACH)
        return float(np.trapezoid(rates, times))

    def march(
        self,
        speed: WallSpeed,
        end: float,
        *,
        stops: Sequence[float] = (),
        at_stop: Callable[[float], None] = lambda time: None,
        progress: Progress | None = None,
        fixed: float = 0.0,
    ) -> Track:
        """Run from time zero to ``end``; as :func:`autobalancer.flow.march.march`, the step is the longest stable one.

        Raises
        ------
        QuestionError
            If the flow is not resolved and blows up.
        """
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
                done = march_steps(self._cross, f, clock, piece.start, float(piece.kind), numbers, mark, fixed, record)
                if done < 0:
                    raise QuestionError(
                        f"the finite-difference flow solver diverged at {clock[0]:.4g} s: the flow is not resolved; take more "
                        "'points'"
                    )
                for time, w, lag in record[:done].tolist():
                    track.note(time, w, lag)
                track.steps += done
                if progress is not None:
                    progress(float(clock[0]), end)
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
