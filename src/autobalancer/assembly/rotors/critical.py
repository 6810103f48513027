"""Natural frequencies and synchronous critical speeds of matrices, undamped."""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh

from autobalancer.assembly.rotors.model import Floats, LateralModel

NOT_A_SPEED = 1e-9  # share of the greatest 1/w^2 below which it counts as zero


def undamped_critical_speeds(model: LateralModel, speed: float = 0.0) -> Floats:
    """Speeds at which an undamped whirl has the speed of the rotor, rad/s, ascending; K taken at ``speed``.

    On isotropic supports forward whirl only, since unbalance excites no other; else all synchronous vibrations.
    K x = w^2 (M - i G) x is a Hermitian problem, whatever the sign of M - i G: where the polar inertia outweighs the
    transverse one, a critical speed is missing.
    """
    stiffness = model.stiffness_at(speed)
    stiffness = 0.5 * (stiffness + stiffness.T)
    n = model.pairs
    if model.isotropic:
        m, _, _ = model.complex_matrices(speed)
        # G over x and y is [[0, g], [-g, 0]], and a forward whirl has z' = i w z: g acts against M
        mass = m.real - model.gyroscopic[:n, n : 2 * n]
        held = stiffness[:n, :n]
    else:
        mass, held = model.mass - 1j * model.gyroscopic, stiffness
    if np.linalg.eigvalsh(held)[0] <= 1e-12 * np.abs(held).max():
        held = held + 1e-12 * np.abs(held).max() * np.eye(held.shape[0])
    inverse = eigh(mass, held, eigvals_only=True)
    return np.sort(1.0 / np.sqrt(inverse[inverse > NOT_A_SPEED * np.abs(inverse).max()]))
