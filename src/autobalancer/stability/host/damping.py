"""The damping of the whirl at a critical speed."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from autobalancer.assembly.rotors import LateralModel


def damping_ratio(model: LateralModel, speed: float) -> float:
    """Of the free whirl that turns with the rotor at a critical speed."""
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
    values = np.linalg.eigvals(first)
    own = values[np.argmin(np.abs(values - 1j * speed))]
    return float(-own.real / abs(own))
