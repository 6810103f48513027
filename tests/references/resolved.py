"""Runs of contact-resolved balls on a planar rotor, and their energy and momentum straight from positions and velocities."""

from __future__ import annotations

import cmath
import math
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from autobalancer.assembly.resolved import ball_states
from autobalancer.assembly.system import Assembly, assemble
from autobalancer.kernels import records as at
from autobalancer.kernels.integrators.runge_kutta import FINISHED, advance
from autobalancer.kernels.integrators.tableau import dormand_prince_8
from autobalancer.kernels.system import SPEED, THETA, VX, VY, X, Y
from autobalancer.machine import Machine, Race
from autobalancer.simulation.record import SampleTimes, record_for
from autobalancer.simulation.steppers import equations, memory_for

TURN = 2.0 * math.pi
BALL = {"count": 1, "mass": 5e-3, "diameter": 0.01, "start_angles": [0.0]}


def contact(**changes: Any) -> dict[str, Any]:
    """Elastic and without friction unless changed."""
    found = {"stiffness": 1e6, "restitution": 1.0, "sliding_friction": 0.0, "slip_speed": 1e-3, **changes}
    if "reduced_modulus" in found:
        del found["stiffness"]
    return found


def chamber(
    *,
    speed: float = 0.0,
    axis: str = "vertical",
    balls: dict[str, Any] | None = None,
    race: dict[str, Any] | None = None,
    rotor: dict[str, Any] | None = None,
    **resolved: Any,
) -> Machine:
    """A race of 0.1 m orbit radius in a rotor that hardly moves and keeps its speed."""
    return Machine(
        name="chamber",
        axis=axis,
        rotor={"mass": 1e6, "stiffness": 1e12, "damping": 0.0, **(rotor or {})},
        balancers=[
            {
                "races": [
                    {
                        "orbit_radius": 0.1,
                        "drag": {"law": "viscous", "damping": 0.0},
                        "resolved": contact(**resolved),
                        "balls": [BALL | (balls or {})],
                        **(race or {}),
                    }
                ]
            }
        ],
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": speed}},
    )


def free(*, axis: str = "vertical", race: dict[str, Any] | None = None, **resolved: Any) -> Machine:
    """A light rotor that spins freely, out of balance, with two unequal balls in an eccentric race."""
    anisotropic = axis == "horizontal"
    return Machine(
        name="free",
        axis=axis,
        rotor={"mass": 0.5, "stiffness": [4e3, 6e3] if anisotropic else 4e3, "damping": 0.0, "inertia": 2e-3},
        unbalances=[{"moment": 3e-4, "angle": 0.4}],
        balancers=[
            {
                "races": [
                    {
                        "race_radius": 0.1,
                        "eccentricity": 2e-3,
                        "eccentricity_angle": 1.0,
                        "width": 0.03,
                        "drag": {"law": "viscous", "damping": 0.0},
                        "contact": {"restitution": 1.0},
                        "resolved": contact(stiffness=2e4, **resolved),
                        "balls": [
                            {"count": 1, "mass": 0.02, "diameter": 0.02, "start_angles": [0.3], "start_speeds": [9.0]},
                            {
                                "count": 1,
                                "mass": 0.01,
                                "diameter": 0.014,
                                "start_angles": [2.0],
                                "start_speeds": [-7.0],
                            },
                        ],
                        **(race or {}),
                    }
                ]
            }
        ],
        drive={"kind": "torque", "torque": 0.0},
        start={"speed": 12.0, "deflection": [1e-3, 0.0], "velocity": [0.0, 0.1]},
    )


def run(
    machine: Machine,
    times: Any,
    change: dict[tuple[int, int], float] | None = None,
    *,
    tolerance: float = 1e-10,
    **options: Any,
) -> tuple[Any, Any, Assembly]:
    """States at the times, those of the balls (times, n, BALL_STATES), and the machine; ``change`` sets start states."""
    assembly = assemble(machine, **options)
    own = ball_states(assembly.state[None], assembly.system, assembly.places.shape[2])[0]
    for (ball, state), value in (change or {}).items():
        own[ball, state] = value
    states = states_at(assembly, times, tolerance)
    return states, ball_states(states, assembly.system, assembly.places.shape[2]), assembly


def states_at(assembly: Assembly, times: Any, tolerance: float = 1e-10) -> Any:
    """States of any assembled machine at the times."""
    record = record_for([SampleTimes(list(times))], (), assembly, float(times[-1]))
    memory = memory_for(assembly, float(times[-1]), tolerance, dormand_prince_8())
    status = advance(*equations(assembly), assembly.system, dormand_prince_8(), record, memory, 10**8)
    assert status == FINISHED
    return record.samples


def beyond(race: Race, mean: float, places: Any) -> Any:
    """Distance of complex places outside the orbit of this mean radius: minimized, not solved for."""

    def orbit(angle: float) -> complex:
        waves = sum(float(h.amplitude) * math.cos(h.order * (angle - float(h.angle))) for h in race.harmonics)
        return (mean + waves) * cmath.exp(1j * angle)

    found = np.abs(places) - np.abs([orbit(a) for a in np.angle(places)])
    for i in np.flatnonzero(found if race.harmonics else 0.0):
        angle = cmath.phase(places[i])
        near = minimize_scalar(
            lambda a, z=places[i]: abs(z - orbit(a)),
            bounds=(angle - 0.2, angle + 0.2),
            method="bounded",
            options={"xatol": 1e-12},
        )
        found[i] = math.copysign(near.fun, found[i])
    return found


class Bodies:
    """All that moves, in space: complex positions and velocities, of rotor and balls."""

    def __init__(self, machine: Machine, states: Any, own: Any, assembly: Assembly) -> None:
        self.machine, self.assembly, self.own = machine, assembly, own
        turn = np.exp(1j * states[:, THETA])
        frame = turn if assembly.system.rotating else 1.0
        self.speed, self.turn = states[:, SPEED], turn
        self.z, self.v = (states[:, X] + 1j * states[:, Y]) * frame, (states[:, VX] + 1j * states[:, VY]) * frame
        self.place = own[..., at.BALL_X] + 1j * own[..., at.BALL_Y]
        self.relative = own[..., at.BALL_VX] + 1j * own[..., at.BALL_VY]
        self.spin = own[..., at.BALL_SPIN] + self.speed[:, None]
        balls = assembly.balls
        self.mass = np.array([b.effective_mass for b in balls])
        self.extra = np.array([b.mass + b.virtual_mass * b.displaced for b in balls]) - self.mass
        self.polar = np.array([0.4 * b.mass * b.radius**2 for b in balls])
        arm = np.array([b.eccentricity for b in balls]) + self.place
        self.ball = self.z[:, None] + turn[:, None] * arm
        self.ball_velocity = self.v[:, None] + turn[:, None] * (self.relative + 1j * self.speed[:, None] * arm)
        u = sum(u.size * np.exp(1j * u.angle) for u in machine.unbalances)
        self.unbalance = u * turn
        self.rotor = float(machine.rotor.mass), float(machine.rotor.inertia or 0.0)  # type: ignore[union-attr]

    def energy(self) -> Any:
        """Kinetic energy, springs of supports and contacts, weight."""
        mass, inertia = self.rotor
        kinetic = 0.5 * mass * np.abs(self.v) ** 2 + 0.5 * inertia * self.speed**2
        kinetic = kinetic + self.speed * (self.v.conj() * 1j * self.unbalance).real
        kinetic = kinetic + (0.5 * self.mass * np.abs(self.ball_velocity) ** 2).sum(1)
        kinetic = kinetic + (0.5 * self.extra * np.abs(self.relative) ** 2 + 0.5 * self.polar * self.spin**2).sum(1)
        kx, ky = self.machine.rotor.stiffness_xy  # type: ignore[union-attr]
        stored = 0.5 * kx * self.z.real**2 + 0.5 * ky * self.z.imag**2 + self._contacts()
        if self.machine.axis == "horizontal":
            heavy = self.unbalance.imag + (self.mass * self.ball.imag).sum(1)
            stored = stored + float(self.machine.gravity) * heavy
        return kinetic + stored

    def _contacts(self) -> Any:
        race = self.machine.balancers[0].races[0]
        k = float(race.resolved.stiffness)  # type: ignore[union-attr, arg-type]
        total = 0.0
        for i, ball in enumerate(self.assembly.balls):
            place = self.place[:, i]
            total = total + 0.5 * k * np.maximum(beyond(race, ball.orbit_radius, place), 0.0) ** 2
            if race.width is not None:
                low = ball.orbit_radius + ball.diameter - float(race.width)
                total = total + 0.5 * k * np.maximum(-beyond(race, low, place), 0.0) ** 2
            if race.partitions is not None:
                walls = TURN * np.arange(race.partitions.count) / race.partitions.count + float(race.partitions.angle)
                seen = place[:, None] * np.exp(-1j * walls)
                deep = np.where(seen.real > 0.0, ball.radius - np.abs(seen.imag), 0.0)
                total = total + 0.5 * k * (np.maximum(deep, 0.0) ** 2).sum(1)
            for j in range(i):
                apart = np.abs(self.place[:, i] - self.place[:, j])
                reach = ball.radius + self.assembly.balls[j].radius
                total = total + 0.5 * k * np.maximum(reach - apart, 0.0) ** 2
        if race.friction is not None:
            hold = float(race.resolved.adherence_stiffness)  # type: ignore[union-attr]
            total = total + 0.5 * hold * (self.own[..., at.HOLD] ** 2).sum(1)
        return total

    def angular_momentum(self) -> Any:
        """About the axis at rest; without a fluid."""
        mass, inertia = self.rotor
        cross = mass * (self.z.conj() * self.v).imag + inertia * self.speed
        cross = cross + (self.z.conj() * 1j * self.speed * self.unbalance + self.unbalance.conj() * self.v).imag
        return cross + (self.mass * (self.ball.conj() * self.ball_velocity).imag + self.polar * self.spin).sum(1)

    def momentum(self) -> Any:
        """Of rotor and balls together, complex; without a fluid."""
        return self.rotor[0] * self.v + 1j * self.speed * self.unbalance + (self.mass * self.ball_velocity).sum(1)
