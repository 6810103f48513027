"""Critical speeds of the body of a machine with chambers."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.linalg import eigh

from autobalancer.assembly.chamber import assemble_chamber
from autobalancer.machine.chamber import ChamberMachine

Array = Any


def chamber_critical_speeds(machine: ChamberMachine) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Speeds at which the undamped machine meets its unbalance (rad/s), ascending, and the damping ratios there.

    The balls count as masses in the middles of their chambers. With a motion exp(i w t) at the speed w of the rotor the
    gyroscopic moment goes with the square of w as the inertia does, so that K u = w² (M - i G) u with Hermitian M - i G.
    """
    total = sum(group.count for chamber in machine.chambers for group in chamber.balls)
    numbers = assemble_chamber(machine, np.zeros((total, 3)), 1e-6)
    free = numbers.active[:-1]
    if not len(free):
        return (), ()
    inertia = numbers.inertia.astype(complex)
    for chamber in machine.chambers:
        mass = sum(group.count * group.ball_mass for group in chamber.balls)
        arm = np.zeros((3, 6))
        arm[:, :3] = np.eye(3)
        arm[1, 5], arm[2, 4] = chamber.position, -chamber.position
        inertia += mass * arm.T @ arm
    gyroscopic = np.zeros((6, 6))
    gyroscopic[4, 5], gyroscopic[5, 4] = machine.rotor.polar_inertia, -machine.rotor.polar_inertia
    chosen = np.ix_(free, free)
    m, g, k, c = inertia[chosen].real, gyroscopic[chosen], numbers.stiffness[chosen], numbers.damping[chosen]
    # K is definite or nearly so and M - i G need not be: 1/w² are the eigenvalues of the pencil turned around
    softest = 1e-12 * np.trace(k) * np.eye(len(free))
    inverse = eigh(m - 1j * g, k + softest, eigvals_only=True)
    speeds = sorted(float(value) ** -0.5 for value in inverse if 0.0 < value < 1e10)
    return tuple(speeds), tuple(_ratio(m, c + speed * g, k, speed) for speed in speeds)


def _ratio(m: Array, c: Array, k: Array, speed: float) -> float:
    size = len(m)
    state = np.block([[np.zeros((size, size)), np.eye(size)], [-np.linalg.solve(m, k), -np.linalg.solve(m, c)]])
    root = min(np.linalg.eigvals(state), key=lambda value: abs(value - 1j * speed))
    return float(-root.real / abs(root))
