"""What the speeds of a rotor are measured by: its lowest frequency, and the damping of the whirl at a critical speed."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from autobalancer.assembly.rotors import LateralModel


def lowest_frequency(model: LateralModel) -> float:
    """Of the rotor at rest with balls, undamped, rad/s: what its speeds are measured by."""
    stiffness = model.stiffness_at(0.0)
    squares = scipy.linalg.eigvalsh(0.5 * (stiffness + stiffness.T), model.mass)
    positive = squares[squares > 1e-12 * np.abs(squares).max()]
    return float(np.sqrt(positive[0]))


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
