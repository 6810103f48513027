"""What every rotor model is for lateral motion: one linear system with places along an axis.

    M q'' + (C(w) + w G) q' + (K(w) + w' G/2) q = forces,    w = rotor speed

The coordinates are ordered: ``pairs`` of them along x, as many along y, then others (axial, torsional) that no force
across the axis reaches on a symmetric machine. Tilts are counted as slopes of the axis, dx/dz and dy/dz, so that the
y part repeats the x part. G is antisymmetric. G/2 is K_dot: with tilts as components of one rotation vector the
kinetic energy of the spin is w q'^T (G/2) q, so that energy is conserved with a free rotor angle too.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, singledispatch
from typing import Protocol

import numpy as np

from autobalancer.arrays import Complexes, Floats, Matrix
from autobalancer.errors import MachineError
from autobalancer.machine import Support
from autobalancer.machine.rotors import Rotor

SAME = 1e-12  # relative difference of two motions that counts as none


@dataclass(frozen=True)
class Rows:
    """A place on the axis: its deflection x = ``deflection`` . q_x and slope dx/dz = ``slope`` . q_x; y alike."""

    deflection: Floats  # (pairs,)
    slope: Floats  # (pairs,)


class Axis(Protocol):
    """Knows the places on a rotor."""

    def rows(self, position: float | None, body: str | None) -> Rows:
        """The rows of a place; ``None`` is the middle of what turns, where that is clear.

        Raises
        ------
        ValueError
            If there is no such place; the message says what there is.
        """

    def line(self) -> list[tuple[float, Rows]]:
        """Places from end to end, enough of them to draw the shape of the axis."""


@dataclass(frozen=True)
class LateralModel:
    """M, C, G, K of a rotor without balls over N coordinates, SI."""

    mass: Matrix  # (N, N) symmetric, positive definite
    gyroscopic: Matrix  # (N, N) antisymmetric, of speed one
    speeds: Floats  # (k,) ascending from 0; one entry if nothing depends on the speed
    damping: Matrix  # (k, N, N) at these speeds, linear in between
    stiffness: Matrix  # (k, N, N)
    pairs: int
    coordinates: tuple[str, ...]  # (N,) for people
    axis: Axis
    polar_inertia: float | None  # of all that turns
    total_mass: float  # of all that moves sideways
    moved: Matrix | None = (
        None  # (N, 2) coordinates of the whole moved by one along x and y, where names do not say them
    )

    def __post_init__(self) -> None:
        n = self.mass.shape[0]
        if self.gyroscopic.shape != (n, n) or self.stiffness.shape != (self.speeds.size, n, n):
            raise MachineError("rotor: the sizes of its matrices do not match")
        if (
            not _certainly_definite(self.mass)
            and not np.linalg.eigvalsh(self.mass)[0] > 1e-20 * np.abs(self.mass).max()
        ):
            where = self.coordinates[int(np.argmax(np.abs(np.linalg.eigh(self.mass)[1][:, 0])))]
            raise MachineError(f"rotor: its mass matrix is singular; nothing has mass or inertia along {where!r}")

    @property
    def size(self) -> int:
        """Number of coordinates N."""
        return int(self.mass.shape[0])

    @property
    def top_speed(self) -> float:
        """Up to where the tables reach, rad/s; infinite without tables."""
        return float(self.speeds[-1]) if self.speeds.size > 1 else np.inf

    @property
    def translation(self) -> Matrix:
        """q of the whole machine moved by one along x, and along y, (N, 2): coordinates are deflections unless named a slope."""
        if self.moved is not None:
            return self.moved
        moved, n = np.zeros((self.size, 2)), self.pairs
        for column in range(2):
            names = self.coordinates[column * n : (column + 1) * n]
            moved[column * n : (column + 1) * n, column] = ["slope" not in name for name in names]
        return moved

    def damping_at(self, speed: float) -> Matrix:
        """C at a speed, (N, N)."""
        return self._at(self.damping, speed)

    def stiffness_at(self, speed: float) -> Matrix:
        """K at a speed, (N, N)."""
        return self._at(self.stiffness, speed)

    def _at(self, table: Matrix, speed: float) -> Matrix:
        if self.speeds.size == 1:
            return np.asarray(table[0])
        speed = abs(speed)
        if speed > self.speeds[-1] * (1.0 + 1e-12):
            raise MachineError(
                f"rotor: its tables end at {self.speeds[-1]:.6g} rad/s and do not cover {speed:.6g} rad/s; extend them"
            )
        i = min(max(int(np.searchsorted(self.speeds, speed)) - 1, 0), self.speeds.size - 2)
        share = (speed - self.speeds[i]) / (self.speeds[i + 1] - self.speeds[i])
        return np.asarray((1.0 - share) * table[i] + share * table[i + 1])

    @cached_property
    def isotropic(self) -> bool:
        """Whether x and y are alike, so that all commutes with turning the machine about its axis."""
        n = self.pairs
        for stack in (self.mass[None], self.gyroscopic[None], self.damping, self.stiffness):
            size = np.abs(stack).max(initial=0.0)
            xx, xy, yx, yy = (
                stack[:, :n, :n],
                stack[:, :n, n : 2 * n],
                stack[:, n : 2 * n, :n],
                stack[:, n : 2 * n, n : 2 * n],
            )
            other = max(
                np.abs(stack[:, : 2 * n, 2 * n :]).max(initial=0.0), np.abs(stack[:, 2 * n :, : 2 * n]).max(initial=0.0)
            )
            if max(np.abs(xx - yy).max(initial=0.0), np.abs(xy + yx).max(initial=0.0), other) > 1e-9 * size:
                return False
        return True

    def complex_matrices(self, speed: float) -> tuple[Complexes, Complexes, Complexes]:
        """M, C - i w G and K for z = q_x + i q_y, each (pairs, pairs); only where the machine is isotropic."""
        n = self.pairs

        def joined(matrix: Matrix) -> Complexes:
            return np.asarray(matrix[:n, :n] + 1j * matrix[n : 2 * n, :n], np.complex128)

        turning = self.damping_at(speed) + speed * self.gyroscopic
        return joined(self.mass), joined(turning), joined(self.stiffness_at(speed))

    def receptance(self, sigma: complex, speed: float, rows: Matrix) -> Complexes:
        """Deflections for forces e^(sigma t) at places, both real (P, pairs) rows: (2 P, 2 P), all x before all y."""
        b = self.both(rows)
        turning = self.damping_at(speed) + speed * self.gyroscopic
        dynamic = sigma**2 * self.mass + sigma * turning + self.stiffness_at(speed)
        return np.asarray(b @ np.linalg.solve(dynamic, b.T), np.complex128)

    def both(self, rows: Matrix) -> Matrix:
        """Rows of places along x, (P, pairs), as rows over all coordinates: (2 P, N), all x before all y."""
        places, n = rows.shape
        full = np.zeros((2 * places, self.size))
        full[:places, :n] = rows
        full[places:, n : 2 * n] = rows
        return full


def _certainly_definite(mass: Matrix) -> bool:
    """Whether a symmetric matrix is positive definite beyond doubt, in a fifth of the time of its eigenvalues."""
    try:
        return bool(np.linalg.cholesky(mass).diagonal().min() ** 2 > 1e-12 * mass.diagonal().max())
    except np.linalg.LinAlgError:
        return False


def turns_alike(rows: Matrix, pairs: int) -> bool:
    """Whether two motions, rows (2, N), turn with the machine when that is turned about its axis."""
    x, y, rest = rows[:, :pairs], rows[:, pairs : 2 * pairs], rows[:, 2 * pairs :]
    apart = max(np.abs(x[0] - y[1]).max(), np.abs(x[1] + y[0]).max(), np.abs(rest).max(initial=0.0))
    return bool(apart <= SAME * np.abs(rows).max())


@singledispatch
def matrices(rotor: Rotor, gravity: float) -> LateralModel:
    """The linear system of a rotor; each kind registers its own in its file, see ``rigid.py``.

    ``gravity`` along the axis, m/s^2, is 0 if that is horizontal.

    Raises
    ------
    MachineError
        If the rotor is not possible as described.
    """
    raise NotImplementedError(f"rotor of kind {rotor.kind!r}: no file in assembly/rotors registers its matrices")


# Supports of a rotor as matrices.


def table_speeds(tables: Iterable[Sequence[float]]) -> Floats:
    """The common speeds of all tables, each given by its own, as far as all of them reach; [0] if there is none.

    Below its first speed a table keeps its first value.
    """
    given = [[float(w) for w in speeds] for speeds in tables]
    end = min((speeds[-1] for speeds in given), default=0.0)
    return np.array(sorted({0.0, *(w for speeds in given for w in speeds if w <= end)}))


def add_support(support: Support, place: Rows, speeds: Floats, damping: Matrix, stiffness: Matrix) -> None:
    """Add a support at a place of the rotor to C and K, both (k, N, N)."""
    n = place.deflection.size
    values = [support.values(float(w)) for w in speeds]
    k, c = np.array(values).transpose(1, 0, 2)
    across = np.outer(place.deflection, place.deflection)
    tilting = np.outer(place.slope, place.slope)
    for direction in range(2):
        block = slice(direction * n, (direction + 1) * n)
        stiffness[:, block, block] += k[:, direction, None, None] * across + float(support.tilt_stiffness) * tilting
        damping[:, block, block] += c[:, direction, None, None] * across + float(support.tilt_damping) * tilting
    if support.cross_stiffness is not None:
        stiffness[:, :n, n : 2 * n] += float(support.cross_stiffness[0]) * across
        stiffness[:, n : 2 * n, :n] += float(support.cross_stiffness[1]) * across
