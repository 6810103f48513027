"""Free motions q = Re(Q e^(lambda t)) of a rotor at one speed.

An isotropic rotor is solved for z = q_x + i q_y, where each motion is a forward or a backward circle even where both
have one frequency, as at standstill. The states are scaled by the undamped frequencies at rest, so that stiff shafts
lose no digits.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import eig, eigh

from autobalancer.assembly.rotors.model import Complexes, Floats, LateralModel

CREEPING = 0.1  # of |lambda|: with less frequency, damping ratios above 0.995, a motion creeps back and does not swing


@dataclass(frozen=True)
class FreeMotions:
    """Oscillating motions by ascending frequency; ``real`` are the real parts of those that do not oscillate."""

    eigenvalue: Complexes  # (modes,), imaginary part > 0
    vector: Complexes  # (modes, N), of unit kinetic norm Q^H M Q
    real: Floats

    @property
    def count(self) -> int:
        """Number of oscillating motions."""
        return int(self.eigenvalue.size)

    def lowest(self, count: int) -> FreeMotions:
        """The first ``count`` of them."""
        return FreeMotions(self.eigenvalue[:count], self.vector[:count], self.real)


def free_motions(model: LateralModel, speed: float, *, damped: bool = True) -> FreeMotions:
    """All free motions at a rotor speed, rad/s; ``damped=False`` leaves out C."""
    n = model.pairs
    if model.isotropic:
        mass, turning, stiffness = model.complex_matrices(speed)
        if not damped:
            turning = turning - _joined(model.damping_at(speed), n)
        values, shapes = _solved(mass, turning, stiffness)
        full = np.zeros((values.size, model.size), np.complex128)
        backward = values.imag < 0.0
        values = np.where(backward, values.conj(), values)
        shapes = np.where(backward[:, None], shapes.conj(), shapes)
        full[:, :n], full[:, n : 2 * n] = shapes, np.where(backward, 1j, -1j)[:, None] * shapes
        rest = slice(2 * n, None)
        others = _real_part(model, speed, rest, damped)
        later = np.concatenate([~backward, np.zeros(others[0].size, np.bool_)])  # of two circles of one frequency
        values, full = np.concatenate([values, others[0]]), np.concatenate([full, others[1]])
    else:
        values, full = _real_part(model, speed, slice(None), damped)
        later = np.zeros(values.size, np.bool_)
    return _sorted(values, full, model.mass, later)


def correlation(one: Complexes, other: Complexes, mass: Floats) -> Floats:
    """Modal assurance criterion weighted with M, (modes, modes), of vectors of unit kinetic norm."""
    return np.asarray(np.abs(one.conj() @ mass @ other.T) ** 2)


def _joined(matrix: Floats, n: int) -> Complexes:
    return np.asarray(matrix[:n, :n] + 1j * matrix[n : 2 * n, :n], np.complex128)


def _real_part(model: LateralModel, speed: float, block: slice, damped: bool) -> tuple[Complexes, Complexes]:
    """Eigenvalues with imaginary part >= 0 of a block of coordinates that no other touches."""
    mass, stiffness = model.mass[block, block], model.stiffness_at(speed)[block, block]
    turning = speed * model.gyroscopic[block, block] + damped * model.damping_at(speed)[block, block]
    if mass.size == 0:
        return np.empty(0, np.complex128), np.empty((0, model.size), np.complex128)
    values, shapes = _solved(mass, turning, stiffness)
    keep = values.imag >= 0.0
    full = np.zeros((int(keep.sum()), model.size), np.complex128)
    full[:, block] = shapes[keep]
    return values[keep], full


def _solved(mass: Any, turning: Any, stiffness: Any) -> tuple[Complexes, Complexes]:
    """(lambda^2 M + lambda D + K) q = 0: all 2 n eigenvalues and vectors as rows."""
    hermitian = 0.5 * (stiffness + stiffness.conj().T)
    squares, basis = eigh(hermitian, mass)
    scale = np.sqrt(np.maximum(squares, 1e-16 * np.abs(squares).max(initial=0.0)))
    scale = np.where(scale > 0.0, scale, 1.0)
    n = scale.size
    adjoint = basis.conj().T
    spring = adjoint @ (stiffness - hermitian) @ basis + np.diag(squares)
    matrix = np.zeros((2 * n, 2 * n), np.result_type(turning, spring))
    matrix[:n, n:] = np.diag(scale)
    matrix[n:, :n] = -spring / scale
    matrix[n:, n:] = -adjoint @ turning @ basis
    values, vectors = eig(matrix)
    return values.astype(np.complex128), np.asarray((basis @ (vectors[:n] / scale[:, None])).T, np.complex128)


def _sorted(values: Complexes, vectors: Complexes, mass: Floats, later: np.ndarray) -> FreeMotions:
    swings = np.abs(values.imag) > CREEPING * np.abs(values)
    order = np.flatnonzero(swings)
    order = order[np.argsort((values.imag * (1.0 + 1e-9 * later))[order], kind="stable")]
    chosen = vectors[order]
    norm = np.sqrt(np.einsum("ij,jk,ik->i", chosen.conj(), mass, chosen).real)
    chosen = chosen / np.where(norm > 0.0, norm, 1.0)[:, None]
    largest = np.take_along_axis(chosen, np.argmax(np.abs(chosen), axis=1)[:, None], 1)
    turned = chosen * np.exp(-1j * np.angle(largest))
    return FreeMotions(values[order], turned, np.sort(values.real[~swings])[::-1])


def decay_rates(values: Complexes) -> Floats:
    """Decay of motions with these eigenvalues, 1/s; zero where it is rounding, some 1e-16 of the greatest eigenvalue."""
    greatest = np.abs(values).max(initial=0.0, where=np.isfinite(values))
    return np.where(np.abs(values.real) > 1e-13 * greatest, -values.real, 0.0)
