"""Balls on races of any shape once more: energies in space, differentiated by computer algebra, nothing eliminated.

A ball sits at z + e^(i theta) (E + eps(phi) e^(i phi) + n N(phi)) with N the outward normal of the race. The coordinate n is
held at 0; the force that holds it is minus the normal force. Coordinates x, y, theta, phi_1 ... phi_k of a planar rotor.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import sympy as sp

from autobalancer.assembly.guided_balls import race_harmonics
from autobalancer.catalog.resolve import resolve
from autobalancer.machine import ConstantTorque, Machine, PrescribedSpeed


@cache
def ball() -> Any:
    """(q, v, numbers, radii) -> mass matrix (5, 5), forces (5,), T, V, path per angle; coordinates x, y, theta, phi, n.

    ``radii`` are the radius of the path and its first two derivatives with respect to phi.
    """
    q, v = sp.symbols("x y theta phi n"), sp.symbols("u v w rate slide")
    numbers = m, fluid, own, r, ex, ey, gx, gy = sp.symbols("m fluid J r Ex Ey gx gy")
    radii = sp.symbols("R0 R1 R2")
    x, y, theta, phi, n = q
    radius = sp.Function("R")(phi)
    place = sp.Matrix([ex + radius * sp.cos(phi), ey + radius * sp.sin(phi)])
    path = sp.diff(place, phi)
    length = sp.sqrt(radius**2 + sp.diff(radius, phi) ** 2)
    outward = sp.Matrix([path[1], -path[0]]) / length
    turn = sp.Matrix([[sp.cos(theta), -sp.sin(theta)], [sp.sin(theta), sp.cos(theta)]])
    where = sp.Matrix([x, y]) + turn * (place + n * outward)
    moving = where.jacobian(q) * sp.Matrix(v)
    along = length * v[3]
    kinetic = m * moving.dot(moving) / 2 + fluid * along**2 / 2 + own * (v[2] - along / r) ** 2 / 2
    potential = -m * (gx * where[0] + gy * where[1])
    momenta = [sp.diff(kinetic, s) for s in v]
    matrix = [[sp.diff(p, s) for s in v] for p in momenta]
    forces = [
        sp.diff(kinetic - potential, s) - sum(sp.diff(p, q[j]) * v[j] for j in range(5))
        for s, p in zip(q, momenta, strict=True)
    ]

    def held(expression: Any) -> Any:
        on_race = expression.subs({n: 0, v[4]: 0}).doit()
        for order in (2, 1):
            on_race = on_race.subs(sp.Derivative(radius, (phi, order)), radii[order])
        return on_race.subs(radius, radii[0])

    found = [[[held(e) for e in row] for row in matrix], [held(e) for e in forces], held(kinetic), held(potential)]
    return sp.lambdify([q, v, numbers, radii], [*found, held(length)], cse=True)


@dataclass(frozen=True)
class Races:
    """A planar machine with one entry in ``numbers`` per ball."""

    machine: Machine
    numbers: list[list[float]]
    orbits: list[tuple[float, np.ndarray]]  # mean radius, amplitudes of its waves (H, 2)
    drag: np.ndarray  # N s/m along the path
    rolling: np.ndarray

    def terms(self, q: np.ndarray, v: np.ndarray, time: float) -> tuple[np.ndarray, np.ndarray, float, list[Any]]:
        """Mass matrix and forces without constraints, energy, and what each ball says of itself."""
        k, rotor = len(self.numbers), self.machine.rotor
        size = 3 + k
        matrix, force = np.zeros((size, size)), np.zeros(size)
        (kx, ky), (bx, by) = rotor.stiffness_xy, rotor.damping_xy
        mass, inertia = float(rotor.mass), float(rotor.inertia or 0.0)
        unbalance = sum(u.size * np.exp(1j * float(u.angle)) for u in self.machine.unbalances) * np.exp(1j * q[2])
        gravity = -float(self.machine.gravity) if self.machine.axis == "horizontal" else 0.0
        lever = 1j * unbalance
        matrix[:3, :3] = [[mass, 0, lever.real], [0, mass, lever.imag], [lever.real, lever.imag, inertia]]
        force[:2] = -kx * q[0] - bx * v[0], -ky * q[1] - by * v[1]
        force[:2] += np.array([unbalance.real, unbalance.imag]) * v[2] ** 2
        force[2] = unbalance.real * gravity
        drive = self.machine.drive
        if isinstance(drive, ConstantTorque):
            force[2] += float(drive.torque) - float(drive.damping) * v[2]
        energy = 0.5 * v[:3] @ matrix[:3, :3] @ v[:3] + 0.5 * (kx * q[0] ** 2 + ky * q[1] ** 2)
        energy -= gravity * unbalance.imag
        found = []
        for i, numbers in enumerate(self.numbers):
            rows = [0, 1, 2, 3 + i]
            places, speeds = [*q[:3], q[3 + i], 0.0], [*v[:3], v[3 + i], 0.0]
            own, push, kinetic, potential, length = ball()(places, speeds, numbers, self.radii(i, q[3 + i]))
            own, push = np.array(own, float), np.array(push, float)
            matrix[np.ix_(rows, rows)] += own[:4, :4]
            force[rows] += push[:4]
            force[3 + i] -= self.drag[i] * length**2 * v[3 + i]
            energy += kinetic + potential
            found.append((rows, own[4, :4], push[4], length))
        return matrix, force, float(energy), found

    def radii(self, i: int, phi: float) -> tuple[float, float, float]:
        """Radius of the path of a ball and its derivatives."""
        mean, waves = self.orbits[i]
        k = np.arange(1, len(waves) + 1)
        wave = (waves[:, 0] - 1j * waves[:, 1]) * np.exp(1j * k * phi)
        return mean + wave.sum().real, (1j * k * wave).sum().real, (-(k**2) * wave).sum().real

    def accelerations(
        self, q: np.ndarray, v: np.ndarray, time: float = 0.0, turning: float = 0.0
    ) -> tuple[np.ndarray, np.ndarray]:
        """q'' and the normal force on each ball; ``turning`` is the rotor's acceleration where the speed is prescribed."""
        matrix, force, _, found = self.terms(q, v, time)
        k, size = len(found), len(q)
        whole, right = np.zeros((size + k, size + k)), np.zeros(size + k)
        whole[:size, :size], right[:size] = matrix, force
        for i, (rows, hold, push, length) in enumerate(found):
            # hold . q'' - push = -N
            whole[size + i, rows], whole[size + i, size + i], right[size + i] = hold, 1.0, push
            whole[3 + i, size + i] = math.copysign(self.rolling[i] * length, v[3 + i])
        if isinstance(self.machine.drive, PrescribedSpeed):
            whole[2], right[2] = 0.0, turning
            whole[2, 2] = 1.0
        solved = np.linalg.solve(whole, right)
        return solved[:size], solved[size:]

    def energy(self, q: np.ndarray, v: np.ndarray) -> float:
        return self.terms(q, v, 0.0)[2]

    def power_lost(self, q: np.ndarray, v: np.ndarray) -> tuple[float, float]:
        """In supports, fluid and drive; and by rolling resistance, W."""
        damping = self.machine.rotor.damping_xy
        lost = damping[0] * v[0] ** 2 + damping[1] * v[1] ** 2
        rubbed = 0.0
        found = self.terms(q, v, 0.0)[3]
        normal = self.accelerations(q, v)[1] if isinstance(self.machine.drive, ConstantTorque) else np.zeros(len(found))
        for i, (_, _, _, length) in enumerate(found):
            lost += self.drag[i] * (length * v[3 + i]) ** 2
            rubbed += self.rolling[i] * length * abs(v[3 + i]) * normal[i]
        drive = self.machine.drive
        if isinstance(drive, ConstantTorque):
            lost -= (float(drive.torque) - float(drive.damping) * v[2]) * v[2]
        return float(lost), float(rubbed)

    def split(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """q and q' of a state of the package, in axes at rest."""
        k = len(self.numbers)
        q = np.concatenate([state[:2], state[4:5], state[6 : 6 + k]])
        return q, np.concatenate([state[2:4], state[5:6], state[6 + k : 6 + 2 * k]])

    def rates(self, state: np.ndarray, time: float = 0.0, turning: float = 0.0) -> np.ndarray:
        q, v = self.split(state)
        a = self.accelerations(q, v, time, turning)[0]
        return np.concatenate([v[:2], a[:2], [v[2], a[2]], v[3:], a[3:]])


def races(machine: Machine) -> Races:
    """The reference of a machine of the package."""
    gravity = -float(machine.gravity) if machine.axis == "horizontal" else 0.0
    numbers, orbits, drag, rolling = [], [], [], []
    for one in resolve(machine):
        race = machine.balancers[one.balancer].races[one.race]
        fluid = one.mass - one.effective_mass + one.virtual_mass * one.displaced
        own = one.spin_ratio * one.mass * one.radius**2
        center = one.eccentricity
        numbers.append(
            [one.effective_mass, fluid, own, max(one.radius, 1e-300), center.real, center.imag, 0.0, gravity]
        )
        orbits.append((one.orbit_radius, race_harmonics(race)))
        drag.append(one.drag / one.orbit_radius**2)
        rolling.append(race.friction.rolling_resistance if race.friction is not None else 0.0)
    return Races(machine, numbers, orbits, np.array(drag), np.array(rolling))
