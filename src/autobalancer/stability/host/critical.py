"""What the speeds of a rotor are measured by."""

from __future__ import annotations

import numpy as np
import scipy.linalg

from autobalancer.assembly.rotors import LateralModel


def lowest_frequency(model: LateralModel) -> float:
    """Of the rotor at rest with balls, undamped, rad/s: what its speeds are measured by."""
    stiffness = model.stiffness_at(0.0)
    squares = scipy.linalg.eigvalsh(0.5 * (stiffness + stiffness.T), model.mass)
    positive = squares[squares > 1e-12 * np.abs(squares).max()]
    return float(np.sqrt(positive[0]))
