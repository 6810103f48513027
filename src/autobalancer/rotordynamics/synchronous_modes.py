"""Undamped modes of a rotor as a place on it sees them, in space at rest or turning with the rotor.

With A = M (``natural``) or A = M - i G (``critical``: whirl at the speed of the rotor) the motion obeys
(K - w^2 A) q = f e^(i w t). Modes phi with A phi = K phi / w_i^2 and phi^H K phi = 1 give the receptance at a place
sum_i |r phi_i|^2 / (1 - w^2/w_i^2): the share of a mode in the static deflection, and its growth with the speed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.linalg import eig, eigh

from autobalancer.assembly.rotors.model import Complexes, Floats, LateralModel
from autobalancer.errors import QuestionError

Kind = Literal["critical", "natural"]


@dataclass(frozen=True)
class Pencil:
    """K, A, C for q = Re(Q e^(i w t)) and the row of a place along one direction."""

    stiffness: Complexes
    inertia: Complexes
    damping: Complexes
    row: Floats

    def receptance(self, speed: float, *, damped: bool = True) -> complex:
        """Deflection over force at the place for w = ``speed``, m/N."""
        dynamic = self.stiffness - speed**2 * self.inertia + 1j * speed * damped * self.damping
        return complex(self.row @ np.linalg.solve(dynamic, self.row))


@dataclass(frozen=True)
class PlaceMode:
    """One mode as a place sees it."""

    speed: float  # w_i
    vector: Complexes  # phi, of unit elastic energy
    deflection: complex  # r phi


def pencil(model: LateralModel, row: Floats, direction: int, speed: float, kind: Kind) -> Pencil:
    """The matrices at a rotor speed; an isotropic rotor in complex coordinates, so that only forward whirl counts."""
    n, turns = model.pairs, float(kind == "critical")
    inertia = np.asarray(model.mass - 1j * turns * model.gyroscopic, np.complex128)
    stiffness, damping = model.stiffness_at(speed), model.damping_at(speed)
    if model.isotropic:
        k, a, c = (np.asarray(e[:n, :n] + 1j * e[n : 2 * n, :n], np.complex128) for e in (stiffness, inertia, damping))
        return Pencil(k, a, c, row)
    full = np.zeros(model.size)
    full[direction * n : (direction + 1) * n] = row
    return Pencil(np.asarray(stiffness, np.complex128), inertia, np.asarray(damping, np.complex128), full)


def place_modes(matrices: Pencil) -> list[PlaceMode]:
    """Modes with a real speed, by their share in the static deflection of the place, greatest first.

    Raises
    ------
    QuestionError
        If the rotor is not held, so that a static force moves it without end.
    """
    hermitian = 0.5 * (matrices.stiffness + matrices.stiffness.conj().T)
    levels = np.linalg.eigvalsh(hermitian)
    if levels[0] <= 1e-12 * levels[-1]:
        raise QuestionError("equivalent_planar: the rotor is not held, and has no static stiffness; give it supports")
    inverse, vectors = eigh(matrices.inertia, hermitian)
    found = []
    for value, vector in zip(inverse, vectors.T, strict=True):
        if value > 1e-10 * np.abs(inverse).max():
            found.append((float(value**-0.5), vector, complex(matrices.row @ vector)))
    return sorted((PlaceMode(*entry) for entry in found), key=lambda mode: -(abs(mode.deflection) ** 2))


def damping_ratio(matrices: Pencil, mode: PlaceMode) -> float:
    """Damping ratio of the damped motion most alike, from (lambda^2 A + lambda C + K) Q = 0.

    Raises
    ------
    QuestionError
        If nothing oscillates.
    """
    n = mode.vector.size
    left, right = np.zeros((2, 2 * n, 2 * n), np.complex128)
    left[:n, n:] = mode.speed * np.eye(n)
    left[n:, :n], left[n:, n:] = -matrices.stiffness / mode.speed, -matrices.damping
    right[:n, :n], right[n:, n:] = np.eye(n), matrices.inertia
    values, motions = eig(left, right)
    finite = np.isfinite(values)
    values, shapes = values[finite], motions[:n, finite]
    energy = np.einsum("ij,ik,kj->j", shapes.conj(), matrices.stiffness, shapes).real
    likeness = np.abs((matrices.stiffness @ mode.vector).conj() @ shapes) ** 2 / np.maximum(energy, 1e-300)
    oscillating = values.imag > 1e-9 * np.abs(values)
    if not oscillating.any():
        raise QuestionError("equivalent_planar: no motion of the rotor oscillates; its damping is above critical")
    best = int(np.argmax(np.where(oscillating, likeness, -1.0)))
    return float(-values[best].real / abs(values[best]))
