"""The damping of the whirl at a critical speed, and of the slowest motion of the rotor."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from autobalancer.assembly.rotors import LateralModel
from autobalancer.stability.host.stations import Stations


def damping_ratio(model: LateralModel, speed: float) -> float:
    """Of the free whirl that turns with the rotor at a critical speed."""
    values = _free(model, speed)
    own = values[np.argmin(np.abs(values - 1j * speed))]
    return float(-own.real / abs(own))


def slowest_decay(st: Stations, speed: float) -> float:
    """Decay rate of the free motion of the rotor that dies away last, 1/s; with the mass of the balls on it."""
    return float((-_free(st.model, speed).real).min())


def _free(model: LateralModel, speed: float) -> NDArray[np.complex128]:
    """Eigenvalues of the rotor at a speed, 1/s."""
    mass: NDArray[Any]
    stiffness: NDArray[Any]
    turning: NDArray[Any]
    if model.isotropic:
        mass, turning, stiffness = model.complex_matrices(speed)
    else:
        mass, stiffness = model.mass, model.stiffness_at(speed)
        turning = model.damping_at(speed) + speed * model.gyroscopic
    n = mass.shape[0]
    first = np.block(
        [
            [np.zeros((n, n)), np.eye(n)],
            [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, turning)],
        ]
    )
    return np.asarray(np.linalg.eigvals(first), np.complex128)
