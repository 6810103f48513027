"""The averaged equations as they are printed, apart from the matrices of the package."""

from __future__ import annotations

import numpy as np

from autobalancer.stability.averaged import stiffness_xy
from autobalancer.stability.host.stations import Floats, Plane


def averaged_residuals(
    p: Plane, speed: float, angles: Floats, a_x: complex, a_y: complex
) -> tuple[complex, complex, Floats]:
    """Right-hand sides of the steady averaged equations; all zero in a steady state.

    Returns
    -------
    rate_x, rate_y, torque
        A_x' + i B_x' and A_y' + i B_y' of (4.25)-(4.28), m/s, and the torque on each ball, (4.29) times m eps, N m.
    """
    load = speed**2 * (p.fixed_load + complex((p.moment * np.exp(1j * angles)).sum()))
    factor = -0.5j / (p.mass * speed)
    x, y = stiffness_xy(p, speed)
    torque = p.moment * speed**2 * np.imag(np.exp(-1j * angles) * (0.5 * (a_x + a_y) + p.offset))
    return factor * (load - x * a_x), factor * (load - y * a_y), torque


def unbalance_whirl(p: Plane, speed: float) -> tuple[complex, complex]:
    """Forward and backward part (a, b) of the unbalance response z = a e^(iWt) + b e^(-iWt), m, balls left out.

    Without damping this is (4.72) of Spannan (2021) with the lost factor 1/M restored.
    """
    x, y = stiffness_xy(p, speed)
    load = p.unbalance * speed**2
    return 0.5 * load * (1.0 / x + 1.0 / y), complex(np.conj(0.5 * load * (1.0 / x - 1.0 / y)))
