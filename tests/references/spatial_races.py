"""Balls on races of any shape that tilt with a rigid rotor: places in space, expanded and differentiated by computer algebra.

As tests/references/spatial.py, but the ball runs on eps(phi) instead of a circle, and may move off its path along the outward
normal of it in the plane of the race. This coordinate n is held at 0; the force that holds it is minus the normal force N, and
rolling resistance takes mu L N from the ball. Coordinates: X, a, Y, b of the mass center, theta, phi_1 ... phi_n.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import pairwise
from typing import Any

import numpy as np
import sympy as sp
from tests.references.races import Races, races
from tests.references.spatial import derived, position, supports, unbalances

from autobalancer.catalog.resolve import resolve
from autobalancer.machine import ConstantTorque, Machine


@cache
def derived_places() -> Any:
    """(q, v, numbers, radii) -> of the place of a ball, by orders in the lateral coordinates: itself (3, 3), its derivatives
    (3, 3, 7) and its acceleration without q'' (3, 3); the path per angle and its rate. Coordinates X, a, Y, b, theta, phi, n.
    """
    q, v = sp.symbols("X a Y b theta phi n"), sp.symbols("Xt at Yt bt w phit nt")
    numbers = r_x, r_y, z = sp.symbols("Ex Ey z")
    radii = radius, slope, _, _ = sp.symbols(
        "R0 R1 R2 R3"
    )  # and its derivatives; the last one does not matter where n = 0
    x, a, y, b, theta, phi, n = q

    def change(expression: Any, s: Any) -> Any:
        changed = sp.diff(expression, s)
        if s == phi:
            for one, its in pairwise(radii):
                changed += sp.diff(expression, one) * its
        return changed

    path = sp.Matrix([radius * sp.cos(phi), radius * sp.sin(phi)])
    along = change(path, phi)
    length = sp.sqrt(radius**2 + slope**2)
    off = n * sp.Matrix([along[1], -along[0]]) / length
    spin = sp.Matrix([[sp.cos(theta), -sp.sin(theta)], [sp.sin(theta), sp.cos(theta)]])
    flat = spin * (sp.Matrix([r_x, r_y]) + path + off)
    rho, tilt = sp.Matrix([*flat, 0]), sp.Matrix([-b, a, 0])
    places = rho, sp.Matrix([x + z * a, y + z * b, 0]) + tilt.cross(rho), tilt.cross(tilt.cross(rho)) / 2

    def rate(expression: Any) -> Any:
        return sum((change(expression, s) * u for s, u in zip(q[:6], v[:6], strict=True)), sp.zeros(*expression.shape))

    on_race = [place.subs(n, 0) for place in places]
    slopes = [[[change(part, s).subs(n, 0) for s in q] for part in place] for place in places]
    found = [[list(place) for place in on_race], slopes, [list(rate(rate(place))) for place in on_race]]
    return sp.lambdify(
        [q, v, numbers, radii[:3]], [*found, length, change(length, phi) * v[5]], modules="math", cse=True
    )


def ball(q: Any, v: Any, numbers: Any, radii: Any) -> tuple[np.ndarray, np.ndarray, float, float, float]:
    """Mass matrix (7, 7), forces (7,), T, V, path per angle; coordinates X, a, Y, b, theta, phi, n.

    Lagrange's equations of (place . place) / 2 are its derivatives times its acceleration, of each pair of orders.
    """
    mass, fluid, own, r, *at, gx, gy, gz = numbers
    *found, length, stretched = derived_places()(q, v, at, radii)
    places, slopes, rates = (np.array(one, float) for one in found)
    rolled = np.zeros((2, 7))  # along the race, and the turn of the ball
    rolled[0, 5], rolled[1, 4:6] = length, (1.0, -length / r)
    turned = np.array([stretched * v[5], -stretched * v[5] / r])
    matrix = rolled.T @ np.diag([fluid, own]) @ rolled
    force = mass * np.array([gx, gy, gz]) @ slopes.sum(axis=0) - rolled.T @ ([fluid, own] * turned)
    for i, j in ((0, 0), (0, 1), (1, 0), (1, 1), (0, 2), (2, 0)):  # up to the second order
        matrix += mass * slopes[i].T @ slopes[j]
        force -= mass * slopes[i].T @ rates[j]
    potential = -mass * np.array([gx, gy, gz]) @ places.sum(axis=0)
    return matrix, force, float(0.5 * np.array(v) @ matrix @ v), float(potential), float(length)


@dataclass(frozen=True)
class SpatialRaces:
    """A machine with a rigid rotor and races that tilt."""

    machine: Machine

    @cached_property
    def flat(self) -> Races:
        """Numbers of balls and paths."""
        return races(self.machine)

    def terms(self, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, float, list[Any]]:
        """Mass matrix and forces without constraints, energy, and what each ball says of itself."""
        machine, rotor = self.machine, self.machine.rotor
        static, couple = unbalances(machine, 0.0)
        pull = -float(machine.gravity) if machine.axis == "horizontal" else 0.0
        axial = -float(machine.gravity) if machine.axis == "vertical" else 0.0
        size = q.size
        matrix, force = np.zeros((size, size)), np.zeros(size)
        numbers = [rotor.mass, rotor.transverse_inertia, rotor.polar_inertia]
        numbers += [static.real, static.imag, couple.real, couple.imag, 0.0, pull]
        body = derived("rotor")([*q[:5].tolist(), 0.0], [*v[:5].tolist(), 0.0], list(map(float, numbers)))
        matrix[:5, :5], force[:5] = np.reshape(body[:36], (6, 6))[:5, :5], body[36:41]
        stiffness, damping = supports(machine, v[4])
        force[:4] -= stiffness @ q[:4] + damping @ v[:4]
        energy = body[42] + body[43] + 0.5 * q[:4] @ stiffness @ q[:4]
        drive = machine.drive
        if isinstance(drive, ConstantTorque):
            force[4] += float(drive.torque) - float(drive.damping) * v[4]
        found = []
        for i, (one, flat) in enumerate(zip(resolve(machine), self.flat.numbers, strict=True)):
            rows = [0, 1, 2, 3, 4, 5 + i]
            z = position(machine, machine.balancers[one.balancer].station)
            places, speeds = [*q[:5].tolist(), q[5 + i], 0.0], [*v[:5].tolist(), v[5 + i], 0.0]
            own, push, kinetic, potential, length = ball(
                places, speeds, [*flat[:6], z, 0.0, pull, axial], self.flat.radii(i, q[5 + i])
            )
            matrix[np.ix_(rows, rows)] += own[:6, :6]
            force[rows] += push[:6]
            force[5 + i] -= self.flat.drag[i] * length**2 * v[5 + i]
            energy += kinetic + potential
            found.append((rows, own[6, :6], push[6], length))
        return matrix, force, float(energy), found

    def accelerations(
        self, q: np.ndarray, v: np.ndarray, turning: float | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """q'' and the normal force on each ball; ``turning`` is the rotor's acceleration where the speed is prescribed."""
        matrix, force, _, found = self.terms(q, v)
        k, size = len(found), q.size
        whole, right = np.zeros((size + k, size + k)), np.zeros(size + k)
        whole[:size, :size], right[:size] = matrix, force
        for i, (rows, hold, push, length) in enumerate(found):
            whole[size + i, rows], whole[size + i, size + i], right[size + i] = (
                hold,
                1.0,
                push,
            )  # hold . q'' - push = -N
            whole[5 + i, size + i] = math.copysign(self.flat.rolling[i] * length, v[5 + i])
        if turning is not None:
            whole[4], right[4] = 0.0, turning
            whole[4, 4] = 1.0
        solved = np.linalg.solve(whole, right)
        return solved[:size], solved[size:]

    def energy(self, q: np.ndarray, v: np.ndarray) -> float:
        """T + V, springs included."""
        return self.terms(q, v)[2]

    def power_rubbed(self, q: np.ndarray, v: np.ndarray) -> float:
        """What rolling resistance takes, W."""
        lengths = [length for *_, length in self.terms(q, v)[3]]
        return float(np.abs(self.flat.rolling * lengths * v[5:]) @ self.accelerations(q, v)[1])
