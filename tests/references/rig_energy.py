"""A rig on softening rubber with resolved balls: what it stores and what it loses, straight from its state.

Written for axes at rest, a vertical axis, walls by Hertz, Coulomb's smooth friction and linear drag. The contact laws of the
balls are written once more here; mass, damping, stiffness and gyroscopic matrix of the bodies are the assembled ones.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from tests.references.rates import rates_at

from autobalancer.assembly.reduced_rotor import spatial_parts
from autobalancer.assembly.system import assemble
from autobalancer.kernels import records as at
from autobalancer.kernels.system import BALLS, SPEED, THETA, VX, VY, X, Y
from autobalancer.machine import Machine
from autobalancer.simulation.steppers import equations


class RigEnergy:
    """The stored energy of a state, and the power that is lost in it."""

    def __init__(self, machine: Machine) -> None:
        self.assembly = assemble(machine, rotating=False)
        self.balls = self.assembly.balls
        parts = spatial_parts(machine, self.balls)
        self.mass, self.places = parts.mass, parts.places[0]
        self.damping, self.stiffness = (
            parts.small(stack[0]) for stack in (parts.sliding.damping, parts.sliding.stiffness)
        )
        self.gyroscopic = parts.small(parts.model.gyroscopic)
        self.unbalance = parts.shapes.sum(0)
        self.inertia = float(machine.rotor.inertia or 0.0)
        self.rubber = [
            (mount.rows @ parts.reduction.basis, np.array(mount.rubber.friction.stiffness, float),
             np.array(mount.rubber.friction.breakaway_amplitude, float))
            for mount in parts.mounts
        ]  # fmt: skip
        self.first = 2 + 2 * parts.size + 2 * len(self.balls)
        self.elements = self.first + at.BALL_STATES * len(self.balls)
        self.size = parts.size

    def moving(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates of the bodies and their rates."""
        rest = BALLS + 2 * len(self.balls)
        more = self.size - 2
        return np.append(y[[X, Y]], y[rest : rest + more]), np.append(y[[VX, VY]], y[rest + more : rest + 2 * more])

    def ball(self, y: np.ndarray, b: int) -> np.ndarray:
        """States of one ball."""
        own = self.first + at.BALL_STATES * b
        return y[own : own + at.BALL_STATES]

    def stored(self, y: np.ndarray) -> float:
        """Kinetic energy, springs of bodies, rubber, walls and adherence."""
        q, v = self.moving(y)
        w, turn = y[SPEED], np.exp(1j * y[THETA])
        total = 0.5 * v @ self.mass @ v + 0.5 * self.inertia * w**2 + 0.5 * w * v @ self.gyroscopic @ q
        total += w * v @ (1j * self.unbalance * turn).real + 0.5 * q @ self.stiffness @ q
        where = self.elements
        for _, stiffness, _ in self.rubber:
            forces = y[where : where + 2 * stiffness.size].reshape(-1, 2)
            total += ((forces**2).sum(1) / (2.0 * stiffness)).sum()
            where += 2 * stiffness.size
        station = complex(*(self.places @ v))
        for b, ball in enumerate(self.balls):
            row, own = self.assembly.system.free_balls[b], self.ball(y, b)
            place, u = complex(own[at.BALL_X], own[at.BALL_Y]), complex(own[at.BALL_VX], own[at.BALL_VY])
            velocity = station + turn * (u + 1j * w * place)
            total += 0.5 * row.mass * abs(velocity) ** 2 + 0.5 * row.extra * abs(u) ** 2
            spins = (own[at.BALL_SPIN] + w) ** 2 + own[at.TUMBLE_X] ** 2 + own[at.TUMBLE_Y] ** 2
            total += 0.5 * ball.own_inertia * spins
            outer, inner = abs(place) - row.orbit, row.orbit - row.gap - abs(place)
            total += 0.4 * (row.wall_stiffness * max(outer, 0.0) ** 2.5 + row.inner_stiffness * max(inner, 0.0) ** 2.5)
            total += 0.5 * row.hold_stiffness * own[at.HOLD] ** 2
        return float(total)

    def lost(self, y: np.ndarray) -> float:
        """Power lost in dampers, rubber, contacts, rolling and drag, W."""
        _, v = self.moving(y)
        total, where = v @ self.damping @ v, self.elements
        for rows, stiffness, amplitude in self.rubber:
            forces = y[where : where + 2 * stiffness.size].reshape(-1, 2)
            give = np.maximum(forces @ (rows @ v), 0.0) / (stiffness * amplitude**2)
            total += (give * (forces**2).sum(1) / stiffness).sum()
            where += 2 * stiffness.size
        return float(total + sum(self.lost_by(b, y) for b in range(len(self.balls))))

    def lost_by(self, b: int, y: np.ndarray) -> float:
        """Power lost by one ball."""
        row, own = self.assembly.system.free_balls[b], self.ball(y, b)
        x, z, vx, vz, spin = (float(own[i]) for i in range(5))
        away = float(np.hypot(x, z))
        out, along = (vx * x + vz * z) / away, (vz * x - vx * z) / away
        total = row.viscous * (vx * vx + vz * vz)
        outer, inner = away - row.orbit, row.orbit - row.gap - away
        tx, ty = float(own[at.TUMBLE_X]), float(own[at.TUMBLE_Y])
        pressed, climb = 0.0, row.floor_arm * (tx * z - ty * x) / away
        for deep, rate, turned in ((outer, out, 1.0), (inner, -out, -1.0)):
            if deep <= 0.0:
                continue
            stiffness, damping = row.wall_stiffness, row.wall_damping
            if turned < 0.0:
                stiffness, damping = row.inner_stiffness, row.inner_damping
            spring = stiffness * deep**1.5
            push = max(spring + damping * deep**0.25 * rate, 0.0)
            slip = float(np.hypot(along + turned * row.radius * spin, climb))
            total += (push - spring) * rate + push * row.sliding * np.tanh(slip / row.slip_speed) * slip
            pressed += push
        total += row.rolling_arm * pressed * np.tanh(row.radius * spin / row.rest_speed) * spin
        left = row.weight - row.sliding * pressed
        if row.floor > 0.0 and left > 0.0:
            fast = float(np.hypot(vx - row.floor_arm * ty, vz + row.floor_arm * tx))
            total += left * row.floor * np.tanh(fast / row.slip_speed) * fast
            turning = float(np.hypot(tx, ty))
            total += row.rolling_arm * left * np.tanh(row.radius * turning / row.rest_speed) * turning
        return float(total)

    def run(self, times: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
        """Stored energy and all that was lost since the start, J, at these times: the compiled equations, another integrator."""
        assembly = self.assembly
        compiled, size = equations(assembly).rates, assembly.state.size
        scale = np.append(assembly.scale, self.stored(assembly.state))

        def rates(time: float, state: np.ndarray) -> np.ndarray:
            y = np.ascontiguousarray(state[:size])
            return np.append(rates_at(compiled, time, y, assembly.system), self.lost(y))

        answer: Any = solve_ivp(
            rates,
            (0.0, times[-1]),
            np.append(assembly.state, 0.0),
            "DOP853",
            times,
            rtol=tolerance,
            atol=tolerance * scale,
        )
        assert answer.success
        return np.array([self.stored(y) for y in answer.y[:size].T]), answer.y[size]
