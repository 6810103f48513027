"""Single balls against closed forms: oblique impacts that slide or stick, rolling in a turning drum."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from tests.references.chamber_machines import free_machine

from autobalancer.assembly.chamber_assembly import contact_time
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.simulation.chamber import simulate_chamber

MASS = 0.02
RADIUS = (0.75 * MASS / (math.pi * 7800.0)) ** (1.0 / 3.0)


def drum(
    contact: dict[str, Any], speed: float = 0.0, gravity: Any = (0.0, 0.0, 0.0), drag: float = 0.0, **ball: Any
) -> ChamberMachine:
    balls = {"count": 1, "density": 7800.0, "mass": MASS} | ball
    return free_machine(
        body={"freedom": "fixed"}, gravity=gravity, contact=contact,
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": speed}},
        chambers=[{"radius": 0.1, "depth": 0.2, "drag": drag, "balls": [balls]}],
    )  # fmt: skip


@pytest.mark.parametrize("incidence", [20.0, 45.0, 75.0])
@pytest.mark.parametrize("spin", [0.0, 150.0])
def test_an_oblique_impact_on_a_wall_slides_or_sticks_as_rigid_body_theory_says(incidence: float, spin: float) -> None:
    # onto the flat wall at +x, moving along y; slip s = v_y - r spin_z of the contact point; e, mu: Walton's two regimes
    mu, restitution, speed = 0.25, 0.6, 3.0
    normal, along = speed * math.cos(math.radians(incidence)), speed * math.sin(math.radians(incidence))
    near = 0.1 - RADIUS - 1e-4
    machine = drum(
        {"friction": mu, "rolling_arm": 0.0, "restitution": restitution, "stiffness": 1e9, "slip_speed": 1e-4},
        positions=[[near, 0.0, 0.0]], velocities=[[normal, along, 0.0]], spins=[[0.0, 0.0, spin]],
    )  # fmt: skip
    run = simulate_chamber(machine, duration=1e-3, sample=1e-3, step=contact_time(machine) / 200.0)
    assert int(run.contacts_wall.sum()) == 1
    velocity, turning = run.ball_velocity.values[-1, 0], run.ball_spin.values[-1, 0]
    slip = along + RADIUS * spin  # the contact point is at +r along x: velocity of it along y
    change = min(mu * (1.0 + restitution) * normal, 2.0 / 7.0 * abs(slip))
    assert velocity[0] == pytest.approx(-restitution * normal, rel=0.002)
    assert velocity[1] == pytest.approx(along - math.copysign(change, slip), abs=0.003 * speed)
    assert turning[2] == pytest.approx(spin - 2.5 * math.copysign(change, slip) / RADIUS, abs=0.01 * speed / RADIUS)
    stuck = 2.0 / 7.0 * abs(slip) < mu * (1.0 + restitution) * normal
    assert stuck == (abs(velocity[1] + RADIUS * turning[2]) < 0.005 * speed)


@pytest.mark.parametrize("speed", [5.0, -5.0])
def test_a_ball_rolls_in_a_turning_drum_where_drag_and_rolling_moment_hold_it(speed: float) -> None:
    # moments about the point of contact: weight r sin(angle) = arm N + drag r u, with N = weight cos(angle), u = w (R - r)
    arm, drag, weight = 3e-4, 0.12, MASS * 9.81
    spin = speed * 0.1 / RADIUS
    machine = drum(
        {"law": "history", "friction": 0.6, "rolling_arm": arm, "stiffness": 1e8, "slip_speed": 1e-4},
        speed, (0.0, 0.0, -9.81), drag,
        positions=[[0.0, 0.0, -(0.1 - RADIUS)]], velocities=[[0.0, 0.0, 0.0]], spins=[[spin, 0.0, 0.0]],
    )  # fmt: skip
    run = simulate_chamber(machine, duration=6.0, sample=1e-2)
    late = run.isel(time=slice(-100, None))
    angle = np.arctan2(late.ball_position.values[:, 0, 1], -late.ball_position.values[:, 0, 2])
    pull = drag * RADIUS * abs(speed) * (0.1 - RADIUS)
    size = math.hypot(weight * RADIUS, weight * arm)
    wanted = math.asin(pull / size) + math.atan2(arm, RADIUS)
    assert angle.max() - angle.min() < 1e-3
    assert angle.mean() == pytest.approx(math.copysign(wanted, speed), rel=2e-3)
    assert late.ball_spin.values[:, 0, 0] == pytest.approx(spin, rel=1e-3)
    assert np.abs(late.ball_velocity.values).max() < 1e-3


@pytest.mark.parametrize(("law", "within"), [("restitution", 0.01), ("history", 0.15)])
def test_balls_rub_on_each_other_with_their_own_friction_and_on_the_wall_with_that_of_the_wall(
    law: str, within: float
) -> None:
    # a spinning ball meets one at rest head on, a third one slides along the flat wall: both slide throughout; the tangential
    # damper of "history" leaves a stretched spring, which takes away a tenth of the impulse at the end
    walls, balls, restitution, speed, spin = 0.3, 0.1, 0.6, 2.0, 600.0
    near, gap = 0.1 - RADIUS - 1e-4, 1e-4
    machine = drum(
        {"law": law, "friction": walls, "ball_friction": balls, "restitution": restitution, "stiffness": 1e9, "slip_speed": 1e-4},
        count=3, positions=[[-RADIUS - gap, 0.0, 0.0], [RADIUS, 0.0, 0.0], [near, 0.05, 0.0]],
        velocities=[[speed, 0.0, 0.0], [0.0, 0.0, 0.0], [speed, 0.0, 8.0]], spins=[[0.0, 0.0, spin], [0.0] * 3, [0.0] * 3],
    )  # fmt: skip
    run = simulate_chamber(machine, duration=1e-3, sample=1e-3, step=contact_time(machine) / 200.0)
    assert (int(run.contacts_wall.sum()), int(run.contacts_ball.sum())) == (1, 1)
    velocity = run.ball_velocity.values[-1]
    impulse = (1.0 + restitution) * speed  # over the mass; half of it between two balls
    assert velocity[2, 2] - 8.0 == pytest.approx(-walls * impulse, rel=within)
    assert velocity[1, 1] == pytest.approx(balls * 0.5 * impulse, rel=within)
    assert velocity[0, 1] == pytest.approx(-velocity[1, 1], rel=1e-6)
