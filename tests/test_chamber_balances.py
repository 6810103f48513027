"""Balances of released machines with balls, and the order of the steps."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from tests.references.chamber_machines import free_machine

from autobalancer.assembly.chamber_assembly import assemble_chamber, contact_time
from autobalancer.kernels.chamber.chamber_records import Chamber
from autobalancer.kernels.chamber.time_steps import start
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.simulation.chamber import simulate_chamber
from autobalancer.simulation.chamber.chamber_run import March, begin, total_energy

UNBALANCE = [{"moment": 0.02, "position": 0.05, "angle": 0.3}]
RADIUS = (0.75 * 0.1 / (math.pi * 7800.0)) ** (1.0 / 3.0)
LOSSES = ("loss_contact", "loss_friction", "loss_rolling", "loss_supports", "loss_bearings", "loss_drag")


def coasting(speed: float, **motor: float) -> dict[str, Any]:
    """A motor, by default without torque, and the speed at the start."""
    kind = {"rated_torque": 0.0, "overload": 2.0, "synchronous_speed": 100.0, "breakdown_slip": 0.2} | motor
    return {"drive": {"kind": "asynchronous", **kind}, "start": {"speed": speed}}


def thrown(count: int = 6, seed: int = 1) -> list[dict[str, Any]]:
    """A chamber with balls that fly about."""
    random = np.random.default_rng(seed)
    places = [[x, 0.03 * math.cos(a), 0.03 * math.sin(a)] for x in (-0.02, 0.02) for a in (0.5, 2.6, 4.7)][:count]
    velocities = random.uniform(-4.0, 4.0, (count, 3)).tolist()
    balls = {"count": count, "density": 7800.0, "mass": 0.1, "positions": places, "velocities": velocities}
    return [{"radius": 0.06, "depth": 0.1, "balls": [balls]}]


def angular_momentum(chamber: Chamber, transverse: float) -> np.ndarray:
    """About the origin, of balls, body and rotor, for small rotations and a body whose center is the rotor's middle."""
    q, v, balls = chamber.body.place, chamber.body.rate, chamber.balls
    axis = np.array([1.0, q[5], -q[4]])
    total = 23.0 * np.cross(q[:3], v[:3]) + np.array([0.5, 0.5, 0.5]) * v[3:6]
    total += transverse * np.array([0.0, v[4], v[5]]) + 0.5 * v[6] * axis
    total += (balls.mass[:, None] * np.cross(balls.position, balls.velocity)).sum(axis=0)
    return np.asarray(total + (balls.inertia[:, None] * balls.spin).sum(axis=0))


def test_the_angular_momentum_of_a_released_machine_stays() -> None:
    machine = free_machine(
        chambers=thrown(), **coasting(60.0, rated_torque=5.0), contact={"restitution": 0.5, "friction": 0.3}
    )
    step = contact_time(machine) / 40.0
    march = begin(machine, step, 10, "verlet", 0, False)
    first = angular_momentum(march.chamber, 0.32)
    part = march.take(round(0.04 / step / 10))
    last = angular_momentum(march.chamber, 0.32)
    tilt = np.abs(march.chamber.body.place[4:6]).max()
    assert int(part.contacts_wall.sum()) > 10
    assert 5e-5 < tilt < 1e-3
    # to first order in the tilt: along the axis its product with the lateral part is left out
    assert np.abs(last - first)[1:].max() < 1e-9
    assert np.abs(last - first)[0] < tilt * np.linalg.norm(first[1:]) < 1e-7 * first[0]


def momentum(chamber: Chamber, center: np.ndarray) -> np.ndarray:
    """Of balls, body with its center at ``center``, rotor and unbalance."""
    q, v, balls = chamber.body.place, chamber.body.rate, chamber.balls
    c, s = math.cos(q[6] + 0.3), math.sin(q[6] + 0.3)
    size, tilt, turn = 0.02, np.array([0.0, q[4], q[5]]), np.array([0.0, v[4], v[5]])
    heavy, moved = size * np.array([0.0, c, s]), size * v[6] * np.array([0.0, -s, c])
    total = 23.0 * v[:3] + 20.0 * np.cross(v[3:6], center)
    total += moved + np.array([1.0, 0.0, 0.0]) * (np.cross(turn, heavy) + np.cross(tilt, moved))
    return np.asarray(total + (balls.mass[:, None] * balls.velocity).sum(axis=0))


def test_the_momentum_of_a_released_machine_with_unbalance_stays() -> None:
    center = np.array([0.03, -0.02, 0.05])
    body = {"freedom": "free", "mass": 20.0, "inertia": [0.5, 0.7, 0.6], "center": center.tolist()}
    machine = free_machine(body=body, chambers=thrown(), unbalances=UNBALANCE, **coasting(60.0, rated_torque=5.0))
    step = contact_time(machine) / 400.0
    march = begin(machine, step, 10, "verlet", 0, False)
    first = momentum(march.chamber, center)
    velocities = march.chamber.balls.velocity.copy()
    march.take(round(0.03 / step / 10))
    assert np.abs(march.chamber.balls.velocity - velocities).max() > 1.0
    assert np.abs(march.chamber.body.place[3:6]).min() > 1e-4
    assert np.abs(momentum(march.chamber, center) - first).max() < 1e-8 * np.linalg.norm(first)


def test_the_work_of_fluid_drag_is_an_entry_of_its_own_and_the_account_closes() -> None:
    chambers = [thrown()[0] | {"drag": 0.2, "square_drag": 0.1}]
    legs = [
        {"position": [x, y, 0.1], "stiffness": [2e3] * 3, "damping": [20.0] * 3}
        for x in (0.2, -0.2)
        for y in (0.2, -0.2)
    ]
    errors = []
    for count in (25, 100):
        machine = free_machine(
            chambers=chambers, gravity=(1.0, 0.0, -9.8), unbalances=UNBALANCE, supports=legs, **coasting(20.0, rated_torque=5.0)
        )  # fmt: skip
        run = simulate_chamber(machine, duration=0.3, step=contact_time(machine) / count)
        lost = {name: float(run[name][-1]) for name in LOSSES}
        assert lost["loss_drag"] > 0.1 * sum(lost.values())
        assert (np.diff(run.loss_drag.values) >= 0.0).all()
        exchanged = float(run.work_motor[-1]) + sum(lost.values())
        errors.append(float(np.abs(run.energy_error).max()) / exchanged)
    assert errors[0] < 1e-3
    assert errors[1] < 0.3 * errors[0]


def test_drag_takes_a_ball_along_as_its_equation_says() -> None:
    # a ball at rest in the middle of a chamber that turns around it: nothing; thrown along the axis: exponential
    ball = {"count": 1, "density": 7800.0, "mass": 0.1, "positions": [[0, 0, 0]], "velocities": [[0.5, 0, 0]]}
    fixed = free_machine(
        body={"freedom": "fixed"}, chambers=[{"radius": 0.06, "depth": 0.2, "drag": 1.5, "balls": [ball]}]
    )
    run = simulate_chamber(fixed, duration=0.1)
    wanted = 0.5 * np.exp(-1.5 / 0.1 * run.time.values)
    assert run.ball_velocity.values[:, 0, 0] == pytest.approx(wanted, rel=1e-6)
    assert run.loss_drag.values[-1] == pytest.approx(0.05 * (0.5**2 - wanted[-1] ** 2), rel=1e-6)


def pressed(machine: ChamberMachine, step: float, method: str) -> March:
    """Balls pressed into the race from the start, so that nothing of the motion has a corner."""
    chamber = assemble_chamber(machine, np.array([[x, 0.0, -(0.06 - RADIUS) - 2e-5] for x in (-0.03, 0.03)]), step)
    chamber.balls.velocity[:, 1] = 0.05
    start(chamber)
    return March(machine, chamber, 1, method, total_energy(chamber))


@pytest.mark.parametrize(("method", "order"), [("verlet", 2), ("runge_kutta", 4)])
def test_smooth_motion_converges_with_the_full_order_of_the_method(method: str, order: int) -> None:
    legs = [
        {"position": [x, y, 0.1], "stiffness": [2e5] * 3, "damping": [200.0] * 3}
        for x in (0.2, -0.2)
        for y in (0.2, -0.2)
    ]
    smooth = free_machine(
        gravity=(0.0, 0.0, -9.8), unbalances=UNBALANCE, supports=legs, **coasting(100.0, rated_torque=20.0),
        chambers=[{"radius": 0.06, "depth": 0.1, "drag": 0.5, "balls": [{"count": 2, "density": 7800.0, "mass": 0.1}]}],
        contact={"restitution": 1.0, "friction": 0.2, "rolling_arm": 0.0, "stiffness": 1e7, "slip_speed": 1e3},
    )  # fmt: skip

    def end(steps: int) -> np.ndarray:
        march = pressed(smooth, 4e-3 / steps, method)
        part = march.take(steps)
        assert int(part.contacts_wall[1:].sum()) == 0  # never left
        body, balls = march.chamber.body, march.chamber.balls
        return np.concatenate([a.ravel() for a in (body.place, body.rate, balls.position, balls.velocity, balls.spin)])

    counts = (64, 128, 256)
    coarse, middle, fine = (end(count) for count in counts)
    slope = np.log2(np.linalg.norm(coarse - middle) / np.linalg.norm(middle - fine))
    assert slope == pytest.approx(order, abs=0.02)
