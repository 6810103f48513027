"""Undamped critical speeds of any rotor, also where tables give its stiffness over the speed."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import scipy.linalg
from scipy.optimize import brentq

from autobalancer.assembly.rotors import LateralModel
from autobalancer.assembly.rotors.critical import undamped_critical_speeds


def critical_speeds(model: LateralModel) -> tuple[float, ...]:
    """Speeds at which an undamped whirl turns with the rotor, rad/s, ascending; within the reach of the tables.

    On isotropic supports those of forward whirl, which alone an unbalance excites. A tilt whose polar inertia is
    greater than its transverse one has none, so that there may be fewer than pairs of coordinates.
    """
    if model.speeds.size == 1:
        return tuple(undamped_critical_speeds(model).tolist())
    count = min(undamped_critical_speeds(model, float(speed)).size for speed in model.speeds)
    found = []
    for index in range(count):

        def miss(speed: float, index: int = index) -> float:
            return speed - float(undamped_critical_speeds(model, speed)[index])

        for low, high in pairwise([float(speed) for speed in model.speeds]):
            if miss(low) < 0.0 <= miss(high) or miss(high) < 0.0 <= miss(low):
                found.append(float(brentq(miss, low, high, xtol=1e-12 * high)))
    return tuple(sorted(found))


def lowest_frequency(model: LateralModel) -> float:
    """Of the rotor at rest with balls, undamped, rad/s: what its speeds are measured by."""
    stiffness = model.stiffness_at(0.0)
    squares = scipy.linalg.eigvalsh(0.5 * (stiffness + stiffness.T), model.mass)
    positive = squares[squares > 1e-12 * np.abs(squares).max()]
    return float(np.sqrt(positive[0]))
