"""Growth rate of two balls in balance, from the Lagrangian of the machine and differences."""

from __future__ import annotations

import cmath
import math
from dataclasses import replace

import numpy as np
from tests.references import lagrange

from autobalancer.machine import Machine

STEPS = np.array([1e-6, 1e-6, 1e-4, 1e-4, 1e-4, 1e-4, 1e-2, 1e-2])  # m, m/s, rad, rad/s


def growth(machine: Machine, speed: float) -> float:
    """Greatest real part of an eigenvalue (1/s) at a steady rotor speed, on an isotropic planar rotor without weight."""
    turned = replace(lagrange.planar(machine), speed=lambda time: (speed, 0.0))
    unbalance = turned.unbalance(0.0)
    apart = math.acos(abs(unbalance) / (2.0 * float(turned.effective_mass[0]) * float(turned.orbit[0])))
    opposite = cmath.phase(unbalance) + math.pi
    state = np.array([0.0, 0.0, 0.0, 0.0, opposite - apart, opposite + apart, 0.0, 0.0])

    def rates(own: np.ndarray) -> np.ndarray:
        """In axes that turn with the rotor and now lie on those at rest."""
        x, y, vx, vy, *balls = own
        found = turned.rates(0.0, np.array([x, y, vx, vy, 0.0, speed, *balls]))
        turning = speed * np.array([y, -x, vy, -vx])
        return np.concatenate([found[:4] + turning, found[6:]])

    assert np.abs(rates(state)).max() < 1e-9
    columns = [
        (rates(state + h) - rates(state - h)) / (2.0 * step) for h, step in zip(np.diag(STEPS), STEPS, strict=True)
    ]
    return float(np.linalg.eigvals(np.array(columns).T).real.max())
