"""The planar machine once more, straight from its Lagrangian, with nothing eliminated and nothing compiled.

Coordinates q = (x, y, theta, phi_1 ... phi_n). With z_i = z + E e^(i(theta + gamma)) + eps e^(i(theta + phi_i)),

    T = 1/2 m |z'|^2 + 1/2 J theta'^2 + theta' z' . (i U e^(i theta))
        + sum 1/2 m_eff |z_i'|^2 + 1/2 (m - m_eff + c_vm m_displaced) (eps phi_i')^2 + 1/2 J_i (theta' + turn phi_i')^2
    V = 1/2 k_x x^2 + 1/2 k_y y^2 - g . (U e^(i theta) + sum m_eff z_i)

where turn is -eps/r of what rolls and 1 of a pendulum, whose arm turns by phi. It is (4.10) of Spannan 2021 where there are
balls only and no fluid; the mass of the rotor includes that of the unbalance, and the
deflection is counted from where the rotor without balls hangs. The Jacobians dz_i/dq give the full mass matrix.
"""

from __future__ import annotations

import cmath
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from autobalancer.catalog.resolve import resolve
from autobalancer.machine import (
    Constant,
    ConstantTorque,
    Dwell,
    Hill,
    Machine,
    PrescribedSpeed,
    Ramp,
    Table,
    TargetTorque,
)


@dataclass(frozen=True)
class Planar:
    """A planar machine as numbers; arrays have one entry per ball."""

    mass: float
    stiffness: tuple[float, float]
    damping: tuple[float, float]
    inertia: float
    gravity: tuple[float, float]
    ball_mass: np.ndarray
    effective_mass: np.ndarray
    fluid_mass: np.ndarray  # m - m_eff + c_vm m_displaced, moves with eps phi'
    own: np.ndarray  # J_i
    turn: np.ndarray  # angle that a body turns in the rotor, over phi
    orbit: np.ndarray
    center: np.ndarray  # complex, E e^(i gamma)
    drag: np.ndarray
    unbalance: Callable[[float], complex]
    speed: Callable[[float], tuple[float, float]] | None  # speed and acceleration if they are prescribed
    torque: Callable[[float, float], float]  # of time and speed, all of it

    @property
    def balls(self) -> int:
        return self.orbit.size

    # energy ---------------------------------------------------------------------------------------------------------

    def kinetic(self, time: float, q: np.ndarray, v: np.ndarray) -> float:
        """T, from velocities only: no mass matrix."""
        theta, w, phi, rate = q[2], v[2], q[3:], v[3:]
        host = v[0] + 1j * v[1]
        lever = 1j * self.unbalance(time) * cmath.exp(1j * theta)
        ball = host + 1j * np.exp(1j * theta) * (w * self.center + (w + rate) * self.orbit * np.exp(1j * phi))
        return float(
            0.5 * self.mass * abs(host) ** 2
            + 0.5 * self.inertia * w**2
            + w * (host * lever.conjugate()).real
            + 0.5 * np.sum(self.effective_mass * np.abs(ball) ** 2)
            + 0.5 * np.sum(self.fluid_mass * (self.orbit * rate) ** 2)
            + 0.5 * np.sum(self.own * (w + self.turn * rate) ** 2)
        )

    def potential(self, time: float, q: np.ndarray) -> float:
        """V."""
        turn = cmath.exp(1j * q[2])
        places = q[0] + 1j * q[1] + turn * (self.center + self.orbit * np.exp(1j * q[3:]))
        moment = self.unbalance(time) * turn + np.sum(self.effective_mass * places)
        springs = 0.5 * (self.stiffness[0] * q[0] ** 2 + self.stiffness[1] * q[1] ** 2)
        return float(springs - self.gravity[0] * moment.real - self.gravity[1] * moment.imag)

    def energy(self, time: float, q: np.ndarray, v: np.ndarray) -> float:
        """T + V."""
        return self.kinetic(time, q, v) + self.potential(time, q)

    def dissipation(self, v: np.ndarray) -> float:
        """Power lost in supports and fluid, W."""
        return float(self.damping[0] * v[0] ** 2 + self.damping[1] * v[1] ** 2 + np.sum(self.drag * v[3:] ** 2))

    def angular_momentum(self, time: float, q: np.ndarray, v: np.ndarray) -> float:
        """About the rest position of the shaft; kept if all is isotropic and nothing drives or brakes."""
        turn = np.zeros_like(v)
        turn[0], turn[1], turn[2] = -q[1], q[0], 1.0  # all turns as one body
        return float(turn @ self.mass_matrix(time, q) @ v)

    # equations ------------------------------------------------------------------------------------------------------

    def mass_matrix(self, time: float, q: np.ndarray) -> np.ndarray:
        """Of all n + 3 coordinates."""
        n = self.balls
        matrix = np.zeros((n + 3, n + 3))
        matrix[0, 0] = matrix[1, 1] = self.mass
        matrix[2, 2] = self.inertia
        lever = 1j * self.unbalance(time) * cmath.exp(1j * q[2])
        matrix[0, 2] = matrix[2, 0] = lever.real
        matrix[1, 2] = matrix[2, 1] = lever.imag
        for i in range(n):
            jacobian = self._jacobian(i, q)
            matrix += self.effective_mass[i] * jacobian.T @ jacobian
            turning = np.zeros(n + 3)
            turning[2], turning[3 + i] = 1.0, self.turn[i]
            matrix += self.own[i] * np.outer(turning, turning)
            matrix[3 + i, 3 + i] += self.fluid_mass[i] * self.orbit[i] ** 2
        return matrix

    def forces(self, time: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Right-hand side of mass matrix times acceleration."""
        force = np.zeros(self.balls + 3)
        w, turn, pull = v[2], cmath.exp(1j * q[2]), complex(*self.gravity)
        arm = self.unbalance(time) * turn
        force[0] = -self.stiffness[0] * q[0] - self.damping[0] * v[0] + (arm * w**2).real
        force[1] = -self.stiffness[1] * q[1] - self.damping[1] * v[1] + (arm * w**2).imag
        force[2] = self.torque(time, w) + (arm.conjugate() * pull).imag
        force[3:] = -self.drag * v[3:]
        for i in range(self.balls):
            # acceleration at q'' = 0, and weight
            center = turn * self.center[i]
            radial = turn * self.orbit[i] * cmath.exp(1j * q[3 + i])
            given = pull + w**2 * center + (w + v[3 + i]) ** 2 * radial
            force += self.effective_mass[i] * self._jacobian(i, q).T @ [given.real, given.imag]
        return force

    def accelerations(self, time: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """q''."""
        matrix, force = self.mass_matrix(time, q), self.forces(time, q, v)
        if self.speed is None:
            return np.linalg.solve(matrix, force)
        free = [i for i in range(self.balls + 3) if i != 2]
        result = np.zeros(self.balls + 3)
        result[2] = self.speed(time)[1]
        result[free] = np.linalg.solve(matrix[np.ix_(free, free)], force[free] - matrix[free, 2] * result[2])
        return result

    def rates(self, time: float, state: np.ndarray) -> np.ndarray:
        """Derivative of the package's state (x, y, x', y', theta, theta', phi, phi') in axes at rest."""
        q, v = self.split(state)
        if self.speed is not None:
            v[2] = self.speed(time)[0]
        a = self.accelerations(time, q, v)
        return np.concatenate([v[:2], a[:2], [v[2], a[2]], v[3:], a[3:]])

    def split(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """q and q' of a state of the package, in axes at rest."""
        n = self.balls
        return (
            np.concatenate([state[:2], state[4:5], state[6 : 6 + n]]),
            np.concatenate([state[2:4], state[5:6], state[6 + n :]]),
        )

    def _jacobian(self, i: int, q: np.ndarray) -> np.ndarray:
        """d(x_i, y_i)/dq, (2, n + 3)."""
        arm = 1j * cmath.exp(1j * q[2]) * self.orbit[i] * cmath.exp(1j * q[3 + i])
        whole = arm + 1j * cmath.exp(1j * q[2]) * self.center[i]
        jacobian = np.zeros((2, self.balls + 3))
        jacobian[0, 0] = jacobian[1, 1] = 1.0
        jacobian[:, 2] = whole.real, whole.imag
        jacobian[:, 3 + i] = arm.real, arm.imag
        return jacobian


def planar(machine: Machine) -> Planar:
    """The reference of a machine of the package."""
    balls = resolve(machine)
    (kx, ky), (bx, by) = machine.rotor.stiffness_xy, machine.rotor.damping_xy

    def column(name: str, kind: Any = float) -> np.ndarray:
        return np.array([getattr(ball, name) for ball in balls], kind)

    def unbalance(time: float) -> complex:
        return sum((u.size * _factor(u, time) * cmath.exp(1j * u.angle) for u in machine.unbalances), 0j)

    def speed(time: float) -> tuple[float, float]:
        assert isinstance(machine.drive, PrescribedSpeed)
        return profile_value(machine.drive.profile, time)

    def torque(time: float, w: float) -> float:
        drive = machine.drive
        if isinstance(drive, PrescribedSpeed):
            return 0.0
        if isinstance(drive, ConstantTorque):
            return drive.torque - drive.damping * w
        if isinstance(drive, TargetTorque):
            return drive.gain * profile_value(drive.profile, time)[0] - drive.damping * w
        return float(np.interp(w, drive.speed, drive.torque)) - drive.damping * w

    displaced = column("displaced")
    return Planar(
        mass=float(machine.rotor.mass),
        stiffness=(kx, ky),
        damping=(bx, by),
        inertia=float(machine.rotor.inertia or 0.0),
        gravity=(0.0, -float(machine.gravity) if machine.axis == "horizontal" else 0.0),
        ball_mass=column("mass"),
        effective_mass=column("mass") - displaced,
        fluid_mass=displaced + column("virtual_mass") * displaced,
        own=np.array([own for own, _ in own_turning(machine)]),
        turn=np.array([turn for _, turn in own_turning(machine)]),
        orbit=column("orbit_radius"),
        center=column("eccentricity", complex),
        drag=column("drag"),
        unbalance=unbalance,
        speed=speed if isinstance(machine.drive, PrescribedSpeed) else None,
        torque=torque,
    )


def own_turning(machine: Machine) -> list[tuple[float, float]]:
    """Inertia of each body about its own center, and its angle in the rotor over phi, written down once more."""
    races = [race for balancer in machine.balancers for race in balancer.races]
    groups = [group for race in races for group in race.balls for _ in range(group.count)]
    found = []
    for group, ball in zip(groups, resolve(machine), strict=True):
        if group.body == "pendulum":
            found.append((float(group.inertia), 1.0))
        elif group.body == "ball" and group.motion == "point":
            found.append((0.0, 0.0))
        else:
            r, inside = ball.radius, 0.5 * float(group.inner_diameter or 0.0)
            own = 0.5 * ball.mass * (r**2 + inside**2) if group.body == "roller" else 0.4 * ball.mass * r**2
            found.append((own, -ball.orbit_radius / r))
    return found


def profile_value(profile: Any, time: float) -> tuple[float, float]:
    """Value and rate of a profile between its corners, written down once more."""
    if isinstance(profile, Constant):
        return float(profile.speed), 0.0
    if isinstance(profile, Hill):
        n, half, rise = profile.exponent, profile.half_time, profile.end - profile.start
        share = time**n / (half**n + time**n)
        return profile.start + rise * share, rise * n * time ** (n - 1) * half**n / (half**n + time**n) ** 2
    if isinstance(profile, Ramp):
        times = [profile.delay, profile.delay + profile.duration]
        values = [profile.start, profile.end]
    elif isinstance(profile, Table):
        times, values = list(profile.time), list(profile.speed)
    elif isinstance(profile, Dwell):
        times, values = [0.0, profile.hold], [profile.speeds[0]] * 2
        for speed in profile.speeds[1:]:
            arrival = times[-1] + abs(speed - values[-1]) / profile.acceleration
            times += [arrival, arrival + profile.hold]
            values += [speed, speed]
    else:
        raise NotImplementedError(profile)
    slopes = [0.0, *(np.diff(values) / np.diff(times)), 0.0]
    return float(np.interp(time, times, values)), float(slopes[int(np.searchsorted(times, time, side="right"))])


def _factor(unbalance: Any, time: float) -> float:
    if unbalance.schedule is None:
        return 1.0
    return float(np.interp(time, unbalance.schedule.time, unbalance.schedule.factor))


def to_rotor(state: np.ndarray) -> np.ndarray:
    """A state in axes at rest, seen along the axes of the rotor."""
    return _turned(state, -1.0)


def to_space(state: np.ndarray) -> np.ndarray:
    """A state along the axes of the rotor, seen in axes at rest."""
    return _turned(state, 1.0)


def _turned(state: np.ndarray, sign: float) -> np.ndarray:
    state = np.array(state, float)
    turn = np.exp(sign * 1j * state[..., 4])
    for a, b in ((0, 1), (2, 3)):
        z = (state[..., a] + 1j * state[..., b]) * turn
        state[..., a], state[..., b] = z.real, z.imag
    return state
