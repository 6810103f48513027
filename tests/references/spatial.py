"""The rigid rotor with balls once more: energies in space, expanded and differentiated by computer algebra.

The rotor is turned by exp(Theta x) after its spin, with Theta = (-b, a, 0) for the slopes a = dx/dz and b = dy/dz. A
ball sits at rho + Theta x rho + Theta x (Theta x rho)/2 from the center of its station (``full``), or at rho
(``deflection``). The Lagrangian is kept to the second order in deflections, slopes and unbalances; its Euler-Lagrange
equations have the full mass matrix, nothing is eliminated. Supports are generalized forces.

Coordinates: X, a, Y, b of the mass center, theta, phi_1 ... phi_n.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np
import sympy as sp
from scipy.integrate import solve_ivp
from tests.references.lagrange import own_turning, profile_value

from autobalancer.assembly.system import assemble
from autobalancer.catalog.resolve import Ball, resolve
from autobalancer.machine import ConstantTorque, Machine, PrescribedSpeed, RigidRotor, TargetTorque

NUMBERS = {"rotor": "M J_t J_p Ux Uy Cx Cy gx gy", "ball": "m eps Ex Ey z J turn gx gy gz"}


@cache
def derived(part: str, full: bool = False) -> Callable[..., Any]:
    """(coordinates, velocities, numbers) -> mass matrix by rows, forces, T, V of the rotor or of one ball, 44 numbers."""
    x, a, y, b, theta, phi = q = sp.symbols("X a Y b theta phi")
    v = sp.symbols("Xt at Yt bt w phit")
    order = sp.Symbol("order")
    numbers = sp.symbols(NUMBERS[part])
    lateral = [*q[:4], *v[:4]]

    def rate(expression: Any) -> Any:
        return sum((sp.diff(expression, q[i]) * v[i] for i in range(6)), sp.zeros(*expression.shape))

    tilt = sp.Matrix([-b, a, 0])
    cosine, sine = sp.cos(theta), sp.sin(theta)
    spin = sp.Matrix([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]])
    if part == "rotor":
        mass, transverse, polar, ux, uy, cx, cy, gx, gy = numbers
        lateral += [ux, uy, cx, cy]
        # angular velocity of exp(Theta x) in its own axes to the second order, then along the spinning ones
        turning = spin.T * (rate(tilt) - tilt.cross(rate(tilt)) / 2) + sp.Matrix([0, 0, v[4]])
        inertia = sp.Matrix([[transverse, 0, -cx], [0, transverse, -cy], [-cx, -cy, polar]])
        moment = spin[:2, :2] * sp.Matrix([ux, uy])
        lever = rate(moment)
        kinetic = mass * (v[0] ** 2 + v[2] ** 2) / 2 + v[0] * lever[0] + v[2] * lever[1]
        kinetic += (turning.T * inertia * turning)[0] / 2
        potential = -(gx * moment[0] + gy * moment[1])
    else:
        mass, orbit, ex, ey, z, own, turn, gx, gy, gz = numbers
        rho = spin * sp.Matrix([ex + orbit * sp.cos(phi), ey + orbit * sp.sin(phi), 0])
        place = sp.Matrix([x + z * a, y + z * b, 0]) + rho
        if full:
            place += tilt.cross(rho) + tilt.cross(tilt.cross(rho)) / 2
        moving = rate(place)
        kinetic = mass * (moving.T * moving)[0] / 2 + own * (v[4] + turn * v[5]) ** 2 / 2
        potential = -mass * (gx * place[0] + gy * place[1] + gz * place[2])

    def cut(expression: Any) -> Any:
        scaled = expression.subs({s: order * s for s in lateral}, simultaneous=True)
        return sum(sp.diff(scaled, order, i).subs(order, 0) / (1, 1, 2)[i] for i in range(3))

    kinetic, potential = cut(kinetic), cut(potential)
    lagrangian = kinetic - potential
    momenta = [sp.diff(lagrangian, s) for s in v]
    matrix = [sp.diff(p, s) for p in momenta for s in v]
    forces = [
        sp.diff(lagrangian, s) - sum(sp.diff(p, q[j]) * v[j] for j in range(6)) for s, p in zip(q, momenta, strict=True)
    ]
    return sp.lambdify([q, v, numbers], [*matrix, *forces, kinetic, potential], modules="math", cse=True)  # type: ignore[no-any-return]


@dataclass(frozen=True)
class Spatial:
    """A machine with a rigid rotor as numbers."""

    machine: Machine

    @cached_property
    def balls(self) -> tuple[Ball, ...]:
        return resolve(self.machine)

    @cached_property
    def own(self) -> list[tuple[float, float]]:
        return own_turning(self.machine)

    @cached_property
    def held(self) -> Callable[[float], tuple[np.ndarray, np.ndarray]]:
        """K and C at a speed; they are added up once where no table changes them."""
        constant = supports(self.machine, 0.0)
        tables = any(support.table is not None for support in self.machine.rotor.supports)
        return (lambda speed: supports(self.machine, speed)) if tables else (lambda _: constant)

    def parts(self, time: float, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, float, float]:
        """Mass matrix, forces of inertia, weight and drag, T and V without supports."""
        machine, balls = self.machine, self.balls
        rotor = machine.rotor
        assert isinstance(rotor, RigidRotor)
        static, couple = unbalances(machine, time)
        pull = -machine.gravity if machine.axis == "horizontal" else 0.0
        axial = -machine.gravity if machine.axis == "vertical" else 0.0
        n = len(balls)
        matrix, force = np.zeros((5 + n, 5 + n)), np.zeros(5 + n)
        numbers = [rotor.mass, rotor.transverse_inertia, rotor.polar_inertia]
        numbers += [static.real, static.imag, couple.real, couple.imag, 0.0, pull]
        numbers = [float(number) for number in numbers]
        body = derived("rotor")([*q[:5].tolist(), 0.0], [*v[:5].tolist(), 0.0], numbers)
        matrix[:5, :5] = np.reshape(body[:36], (6, 6))[:5, :5]
        force[:5] = body[36:41]
        kinetic, potential = body[42:]
        for i, ball in enumerate(balls):
            at = np.array([0, 1, 2, 3, 4, 5 + i])
            z, e = position(machine, machine.balancers[ball.balancer].station), ball.eccentricity
            numbers = [ball.mass, ball.orbit_radius, e.real, e.imag, z, *self.own[i], 0.0, pull, axial]
            body = derived("ball", machine.tilting_races == "full")(q[at].tolist(), v[at].tolist(), numbers)
            matrix[at[:, None], at] += np.reshape(body[:36], (6, 6))
            force[at] += body[36:42]
            force[5 + i] -= ball.drag * v[5 + i]
            kinetic, potential = kinetic + body[42], potential + body[43]
        return matrix, force, kinetic, potential

    def accelerations(self, time: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """q''."""
        matrix, force, _, _ = self.parts(time, q, v)
        stiffness, damping = self.held(v[4])
        force[:4] -= stiffness @ q[:4] + damping @ v[:4]
        drive = self.machine.drive
        if not isinstance(drive, PrescribedSpeed):
            force[4] += torque(drive, time, v[4])
            return np.asarray(np.linalg.solve(matrix, force))
        result = np.zeros(q.size)
        result[4] = profile_value(drive.profile, time)[1]
        free = np.arange(q.size) != 4
        result[free] = np.linalg.solve(matrix[np.ix_(free, free)], force[free] - matrix[free, 4] * result[4])
        return result

    def energy(self, time: float, q: np.ndarray, v: np.ndarray) -> float:
        """T + V, springs included."""
        _, _, kinetic, potential = self.parts(time, q, v)
        return float(kinetic + potential + 0.5 * q[:4] @ self.held(v[4])[0] @ q[:4])

    def angular_momentum(self, time: float, q: np.ndarray, v: np.ndarray) -> float:
        """About the axis at rest: the momentum of turning all lateral coordinates and the rotor as one."""
        turn = np.zeros(q.size)
        turn[:5] = -q[2], -q[3], q[0], q[1], 1.0
        return float(turn @ self.parts(time, q, v)[0] @ v)

    def run(self, times: Sequence[float] | np.ndarray, corners: Sequence[float] = ()) -> np.ndarray:
        """q and q' from the start of the machine, (times, 2, 5 + n); no step crosses a corner."""
        q, v = start(self.machine)
        n = q.size
        lateral, others = np.array([1e-4, 1e-3] * 2), np.ones(n - 4)
        scale = np.concatenate([lateral, others, 100.0 * lateral, 100.0 * others])

        def rates(time: float, state: np.ndarray) -> np.ndarray:
            place, speed = state[:n], state[n:].copy()
            if isinstance(self.machine.drive, PrescribedSpeed):
                speed[4] = profile_value(self.machine.drive.profile, time)[0]
            return np.concatenate([speed, self.accelerations(time, place, speed)])

        now, state, found = 0.0, np.concatenate([q, v]), {0.0: np.concatenate([q, v])}
        for end in sorted({times[-1], *corners}):
            # a speed with a corner jumps in its rate: both sides of a piece see the rate inside it
            inside = [time for time in times if now < time < end] + [end]
            answer = solve_ivp(
                lambda t, s, low=now, high=end: rates(min(max(t, low + 1e-12), high - 1e-12), s),
                (now, end), state, "DOP853", t_eval=inside, rtol=1e-11, atol=1e-11 * scale,
            )  # fmt: skip
            assert answer.success
            now, state = end, answer.y[:, -1]
            found |= dict(zip(inside, answer.y.T, strict=True))
        states = np.array([found[time] for time in times])
        if isinstance(self.machine.drive, PrescribedSpeed):
            states[:, n + 4] = [profile_value(self.machine.drive.profile, time)[0] for time in times]
        return states.reshape(len(times), 2, n)


def unbalances(machine: Machine, time: float) -> tuple[complex, complex]:
    """Moment and couple about the mass center, in the rotor."""
    rotor = machine.rotor
    assert isinstance(rotor, RigidRotor)
    static = couple = 0j
    for unbalance in machine.unbalances:
        turn = factor(unbalance, time) * np.exp(1j * unbalance.angle)
        if unbalance.misalignment is not None:
            couple += unbalance.misalignment * (rotor.transverse_inertia - rotor.polar_inertia) * turn
        elif unbalance.couple is not None:
            couple += unbalance.couple * turn
        else:
            static += unbalance.size * turn
            couple += unbalance.size * position(machine, unbalance.station) * turn
    return static, couple


def supports(machine: Machine, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """K and C over X, a, Y, b, written down once more."""
    rotor = machine.rotor
    assert isinstance(rotor, RigidRotor)
    matrices = np.zeros((2, 4, 4))
    for support in rotor.supports:
        line = np.array([1.0, support.position])
        of = support if support.table is None else support.table
        for i, values in enumerate((of.stiffness, of.damping)):
            if support.table is not None:
                rows = np.array([np.broadcast_to(value, 2) for value in values])
                x, y = (np.interp(abs(speed), support.table.speed, rows[:, k]) for k in range(2))
            else:
                x, y = np.broadcast_to(0.0 if values is None else values, 2)
            matrices[i, :2, :2] += x * np.outer(line, line)
            matrices[i, 2:, 2:] += y * np.outer(line, line)
        for i, value in enumerate((support.tilt_stiffness, support.tilt_damping)):
            matrices[i, 1, 1] += value
            matrices[i, 3, 3] += value
    matrices[1] += rotor.stiffness_proportional_damping * matrices[0]
    return matrices[0], matrices[1]


def factor(unbalance: Any, time: float) -> float:
    """Of a schedule, after a jump."""
    if unbalance.schedule is None:
        return 1.0
    times, factors = np.array(unbalance.schedule.time), np.array(unbalance.schedule.factor)
    i = int(np.searchsorted(times, time, side="right"))
    if i in (0, times.size):
        return float(factors[min(i, times.size - 1)])
    share = (time - times[i - 1]) / (times[i] - times[i - 1])
    return float((1.0 - share) * factors[i - 1] + share * factors[i])


def position(machine: Machine, place: float | str | None) -> float:
    """Along the axis from the mass center, m."""
    if isinstance(place, str):
        return next(float(station.position) for station in machine.stations if station.name == place)
    return float(place or 0.0)


def torque(drive: Any, time: float, speed: float) -> float:
    """All of it, N m."""
    if isinstance(drive, ConstantTorque):
        return float(drive.torque - drive.damping * speed)
    if isinstance(drive, TargetTorque):
        return float(drive.gain * profile_value(drive.profile, time)[0] - drive.damping * speed)
    return float(np.interp(speed, drive.speed, drive.torque) - drive.damping * speed)


def start(machine: Machine) -> tuple[np.ndarray, np.ndarray]:
    """q and q' at time 0: pulled by a static force at the first balancer, struck by an impulse there."""
    balls, rotor = resolve(machine), machine.rotor
    assert isinstance(rotor, RigidRotor)
    front = np.zeros((2, 4))
    front[0, :2] = front[1, 2:] = 1.0, position(machine, machine.balancers[0].station)
    q, v = np.zeros(5 + len(balls)), np.zeros(5 + len(balls))
    pulled = np.linalg.solve(supports(machine, 0.0)[0], front.T)
    struck = front.T / np.array([rotor.mass, rotor.transverse_inertia] * 2)[:, None]
    q[:4] = pulled @ np.linalg.solve(front @ pulled, machine.start.deflection)
    v[:4] = struck @ np.linalg.solve(front @ struck, machine.start.velocity)
    q[4], v[4] = machine.start.rotor_angle, machine.start.speed
    if isinstance(machine.drive, PrescribedSpeed):
        v[4] = profile_value(machine.drive.profile, 0.0)[0]
    q[5:], v[5:] = [ball.start_angle for ball in balls], [ball.start_speed for ball in balls]
    return q, v


def split(machine: Machine, states: np.ndarray) -> np.ndarray:
    """States of the package in axes at rest, (times, 2 + 2 R + 2 n), as (times, 2, 5 + n)."""
    n = len(resolve(machine))
    basis = assemble(machine).reduction.basis  # type: ignore[union-attr]
    size = basis.shape[1]
    rest = 6 + 2 * n
    place = np.column_stack([states[:, :2], states[:, rest : rest + size - 2]]) @ basis.T
    speed = np.column_stack([states[:, 2:4], states[:, rest + size - 2 :]]) @ basis.T
    q = np.column_stack([place, states[:, 4], states[:, 6 : 6 + n]])
    v = np.column_stack([speed, states[:, 5], states[:, 6 + n : rest]])
    return np.stack([q, v], axis=1)


def joined(machine: Machine, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """One state of the package in axes at rest."""
    basis = assemble(machine).reduction.basis  # type: ignore[union-attr]
    place, speed = np.linalg.solve(basis, q[:4]), np.linalg.solve(basis, v[:4])
    return np.concatenate([place[:2], speed[:2], [q[4], v[4]], q[5:], v[5:], place[2:], speed[2:]])
