"""Critical speeds of the body of a machine with chambers."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.linalg import eigh

from autobalancer.assembly.chamber import assemble_chamber
from autobalancer.machine.chamber import ChamberMachine

Array = Any
# force and moment of an unbalance and of a couple that turn from y to z, in the order x, y, z, then about them
UNBALANCES = np.array([[0, 1, -1j, 0, 0, 0], [0, 0, 0, 0, 1j, 1]]).T


def chamber_critical_speeds(machine: ChamberMachine) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Speeds at which the undamped machine meets its unbalance (rad/s), ascending, and the damping ratios there.

    The balls count as masses in the middles of their chambers. With a motion exp(i w t) at the speed w of the rotor the
    gyroscopic moment goes with the square of w as the inertia does, so that K u = w² (M - i G) u with Hermitian M - i G.
    Motions on which no unbalance or couple does work are left out: those along the axis, and backward whirl in a circle.
    """
    free, m, g, k, c = linear_body(machine)
    if not len(free) or not k.any():
        return (), ()  # nothing moves, or nothing holds it
    # K is definite or nearly so and M - i G need not be: 1/w² are the eigenvalues of the pencil turned around
    softest = 1e-12 * np.trace(k) * np.eye(len(free))
    inverse, shapes = eigh(m - 1j * g, k + softest)
    work = np.abs(shapes.T.conj() @ UNBALANCES[free]) / np.linalg.norm(shapes, axis=0)[:, None]
    met = sorted(
        float(value) ** -0.5 for value, own in zip(inverse, work, strict=True) if own.max() > 1e-6 and 0 < value < 1e10
    )
    speeds = [speed for speed, before in zip(met, [0.0, *met], strict=False) if speed > before * (1.0 + 1e-9)]
    return tuple(speeds), tuple(_ratio(m, c + speed * g, k, speed) for speed in speeds)


def linear_body(machine: ChamberMachine) -> tuple[Array, Array, Array, Array, Array]:
    """Free coordinates of the body, and M, G of speed one, K and C over them, balls in the middles of their chambers."""
    total = sum(group.count for chamber in machine.chambers for group in chamber.balls)
    numbers = assemble_chamber(machine, np.zeros((total, 3)), 1e-6).machine
    free = numbers.free[numbers.free >= 0]
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
    return free, inertia[chosen].real, gyroscopic[chosen], numbers.stiffness[chosen], numbers.damping[chosen]


def body_without_balancing(machine: ChamberMachine, speed: float) -> float:
    """Greatest vibration (m) of the middle of the rotor at a steady speed, with the balls in the middles of the chambers.

    nan at a critical speed of an undamped body.
    """
    return float(vibrations_without_balancing(machine, [speed])[0])


def vibrations_without_balancing(machine: ChamberMachine, speeds: Array) -> Array:
    """The same at many speeds, (speeds,) m."""
    free, m, g, k, c = linear_body(machine)
    static = sum(part.vector for part in machine.unbalances)
    couple = sum(part.vector * part.position for part in machine.unbalances)
    load = (UNBALANCES @ np.array([static, couple], complex))[free]
    found = np.full(len(speeds), np.nan)
    for i, speed in enumerate(speeds):
        moved = np.zeros(6, complex)
        try:
            moved[free] = np.linalg.solve(k + 1j * speed * (c + speed * g) - speed**2 * m, speed**2 * load)
        except np.linalg.LinAlgError:
            continue
        found[i] = 0.5 * float(abs(moved[1] + 1j * moved[2]) + abs(moved[1] - 1j * moved[2]))
    return found


def _ratio(m: Array, c: Array, k: Array, speed: float) -> float:
    size = len(m)
    state = np.block([[np.zeros((size, size)), np.eye(size)], [-np.linalg.solve(m, k), -np.linalg.solve(m, c)]])
    root = min(np.linalg.eigvals(state), key=lambda value: abs(value - 1j * speed))
    return float(-root.real / abs(root))
