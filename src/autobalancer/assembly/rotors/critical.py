"""Undamped whirl with the speed of the rotor, or a multiple of it: the one place where critical speeds are found.

q = Re(Q e^(i h w t)) is free where D(w) Q = 0 with the Hermitian D(w) = K(w) - w^2 (h^2 M - i h G). For one K this is an
eigenproblem for 1/w^2, whatever the sign of the inertia: where the polar inertia outweighs the transverse one, a critical speed
is missing. For tables the roots of the ordered eigenvalues of D(w), which are continuous, are found one by one. In axes of an
isotropic rotor forward and backward whirl (h > 0, h < 0) stand alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from autobalancer.arrays import Complexes, Floats
from autobalancer.assembly.rotors.lateral_model import LateralModel
from autobalancer.cache import remembered
from autobalancer.roots import root

NOT_A_SPEED = 1e-10  # share of the greatest 1/w^2 below which it counts as zero
INTERVALS = 64  # of the reach of a table, in which critical speeds are sought
BOTH = (1.0, -1.0)


class Critical(NamedTuple):
    """A free whirl at a critical speed."""

    speed: float  # rad/s
    harmonic: float
    shape: Complexes  # (N,)


def critical_speeds(model: LateralModel) -> tuple[float, ...]:
    """Speeds at which an undamped whirl has the rotor speed, rad/s, ascending; within the range of the tables.

    Tables are taken at the frequency of the whirl, which is the speed itself. On isotropic supports forward whirl only, since
    unbalance excites no other. There may be fewer than pairs of coordinates, or none.
    """
    return forward_whirls(model)[0]


@remembered(8)
def forward_whirls(model: LateralModel) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """The same, and of each the gyroscopic share g in the inertia of its mode, which tells its whirl at other speeds.

    With the shape Q of the mode g = Q* (i G) Q / (Q* M Q), zero where nothing tilts. At the rotor speed w a whirl of that shape
    has the frequency f with f^2 - g w f = (1 - g) w_c^2.
    """
    whirls = []
    for whirl in critical_whirls(model, directions=(1.0,)):
        left = whirl.shape.conj()
        share = (left @ (1j * model.gyroscopic) @ whirl.shape).real / (left @ model.mass @ whirl.shape).real
        whirls.append((whirl.speed, float(share)))
    speeds, shares = zip(*sorted(whirls), strict=True) if whirls else ((), ())
    return speeds, shares


@remembered(8)
def natural_frequencies(model: LateralModel) -> Floats:
    """Of the rotor at rest, undamped, rad/s, ascending; without those of a rotor that is free to move."""
    from scipy.linalg import eigvalsh

    stiffness = model.stiffness_at(0.0)
    squares = eigvalsh(0.5 * (stiffness + stiffness.T), model.mass)
    return np.asarray(np.sqrt(squares[squares > 1e-12 * np.abs(squares).max()]))


def critical_whirls(
    model: LateralModel,
    harmonic: float = 1.0,
    limit: float = np.inf,
    *,
    intervals: int = INTERVALS,
    directions: Sequence[float] = BOTH,
) -> list[Critical]:
    """Every free whirl with ``harmonic`` times the speed of the rotor up to ``limit``, in no order.

    ``directions``: on isotropic supports forward (1) and backward (-1) whirl; elsewhere there is no such difference.
    """
    n, limit = model.pairs, min(limit, model.top_speed)
    if not model.isotropic:
        dynamic = _Dynamic(model.stiffness_at, _inertia(model.mass, model.gyroscopic, harmonic))
        return [Critical(w, harmonic, vector) for w, vector in dynamic.roots(model, limit, intervals)]
    mass, circling = _joined(model.mass, n), _joined(model.gyroscopic, n)
    critical_whirls = []
    for sign in directions:
        dynamic = _Dynamic(lambda w: _joined(model.stiffness_at(w), n), _inertia(mass, circling, sign * harmonic))
        for w, vector in dynamic.roots(model, limit, intervals):
            part = vector if sign > 0.0 else vector.conj()
            whole = np.concatenate([part, -1j * sign * part, np.zeros(model.size - 2 * n)])
            critical_whirls.append(Critical(w, harmonic, whole))
    return critical_whirls


class _Dynamic(NamedTuple):
    """D(w) = K(w) - w^2 inertia; of K the symmetric part."""

    stiffness: Callable[[float], Any]
    inertia: Complexes

    def held(self, speed: float) -> Any:
        matrix = self.stiffness(speed)
        return 0.5 * (matrix + matrix.conj().T)

    def roots(self, model: LateralModel, limit: float, intervals: int) -> list[tuple[float, Complexes]]:
        roots = self._direct() if model.speeds.size == 1 else self._over_tables(model.speeds, limit, intervals)
        return [(w, vector) for w, vector in roots if w <= limit]

    def _direct(self) -> list[tuple[float, Complexes]]:
        """Eigenvalues 1/w^2 of the inertia over the stiffness; a tiny spring holds a rotor that is free to move."""
        from scipy.linalg import eigh

        held = self.held(0.0)
        size = float(np.abs(held).max())
        if np.linalg.eigvalsh(held)[0] <= 1e-13 * size:
            held = held + 1e-13 * size * np.eye(held.shape[0])
        inverse, vectors = eigh(self.inertia, held)
        chosen = np.flatnonzero(inverse > NOT_A_SPEED * np.abs(inverse).max())
        return [(float(inverse[i] ** -0.5), vectors[:, i]) for i in chosen]

    def _over_tables(self, speeds: Floats, limit: float, intervals: int) -> list[tuple[float, Complexes]]:
        """Roots of the ordered eigenvalues of D(w), sought between the speeds of the tables and finer."""
        grid = np.union1d(np.linspace(0.0, limit, intervals + 1), speeds[speeds < limit])

        def dynamic(speed: float) -> Complexes:
            return np.asarray(self.held(speed) - speed**2 * self.inertia)

        levels = np.array([np.linalg.eigvalsh(dynamic(float(w))) for w in grid])
        roots = []
        for i, k in zip(*np.nonzero(levels[:-1] * levels[1:] < 0.0), strict=True):

            def level(w: float, k: int = k) -> float:
                return float(np.linalg.eigvalsh(dynamic(w))[k])

            speed = root(level, grid[i], grid[i + 1], rtol=1e-13)
            roots.append((speed, np.linalg.eigh(dynamic(speed))[1][:, k]))
        return roots


def _joined(matrix: Floats, n: int) -> Complexes:
    return np.asarray(matrix[:n, :n] + 1j * matrix[n : 2 * n, :n], np.complex128)


def _inertia(mass: Any, gyroscopic: Any, harmonic: float) -> Complexes:
    return np.asarray(harmonic**2 * mass - 1j * harmonic * gyroscopic, np.complex128)
