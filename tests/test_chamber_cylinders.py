"""Cylinders in a chamber, parallel to the rotor: closed forms, the energy of contacts, balances."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from tests.references.chamber_machines import cylinder_machine

from autobalancer.assembly.chamber_assembly import assemble_chamber, contact_time
from autobalancer.kernels.chamber.time_steps import start
from autobalancer.laws.impacts import end_stiffness, line_stiffness
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.simulation.chamber import simulate_chamber
from autobalancer.simulation.chamber.bounds import tilt_between_walls
from autobalancer.simulation.chamber.chamber_run import begin

ORBIT, R, LENGTH, G = 0.09, 0.01, 0.03, 9.81
MASS = 7800.0 * math.pi * R**2 * LENGTH
MODULUS = 1e8 / (2.0 * (1.0 - 0.3**2))
STILL = [0.0, 0.0, 0.0]


def coasting(speed: float = 0.0) -> dict[str, Any]:
    """A motor without torque, and the speed at the start."""
    motor = {"rated_torque": 0.0, "overload": 2.0, "synchronous_speed": 100.0, "breakdown_slip": 0.2}
    return {"drive": {"kind": "asynchronous", **motor}, "start": {"speed": speed}}


@pytest.mark.parametrize("speed", [0.0, 20.0])
def test_a_cylinder_rolls_in_a_drum_as_a_pendulum_with_half_its_mass_more(speed: float) -> None:
    # (m + J/r^2) eps^2 phi'' = -m g eps phi, J = m r^2 / 2, whatever the steady speed of the drum
    place = [0.0, ORBIT * math.sin(0.05), -ORBIT * math.cos(0.05)]
    spin = [speed * 0.1 / R, 0.0, 0.0]  # rolls on a wall of 100 mm, with its middle at rest
    balls = {"positions": [place], "velocities": [STILL], "spins": [spin]}
    contact = {"friction": 0.5, "slip_speed": 1e-5}
    machine = cylinder_machine(balls=balls, contact=contact, gravity=[0.0, 0.0, -G], speed=speed)
    run = simulate_chamber(machine, duration=1.6, sample=2e-3)
    across, time = run.ball_position.values[:, 0, 1], run.time.values
    before = np.flatnonzero(np.diff(np.sign(across)))
    zeros = time[before] - across[before] * np.diff(time)[before] / np.diff(across)[before]
    period = 2.0 * np.diff(zeros).mean()
    assert period == pytest.approx(2.0 * math.pi * math.sqrt(1.5 * ORBIT / G) * (1.0 + 0.05**2 / 16.0), rel=1e-3)


def test_a_cylinder_that_is_thrown_along_the_wall_rolls_with_two_thirds_of_its_speed() -> None:
    balls = {"positions": [[0.0, 0.0, -ORBIT]], "velocities": [[0.0, 2.0, 0.0]]}
    run = simulate_chamber(cylinder_machine(balls=balls, contact={"friction": 0.3}), duration=0.3, sample=1e-2)
    speed, spin = np.linalg.norm(run.ball_velocity.values[-1, 0]), run.ball_spin.values[-1, 0, 0]
    # while it slides it is pressed in a little deeper, which is worth some parts in a thousand of the orbit
    assert speed == pytest.approx(2.0 * 2.0 / 3.0, rel=4e-3)
    assert R * spin == pytest.approx(-speed, rel=4e-3)
    assert pytest.approx(float(run.loss_friction[-1]), rel=1e-2) == 0.5 * MASS * 4.0 / 3.0


HITS = {
    "side on the race": ([[0.0, 0.0, 0.0]], [[0.0, 0.0, -3.0]]),
    "side on the inner wall": ([[0.0, 0.0, -0.06]], [[0.0, 0.0, 3.0]]),
    "end on a flat wall": ([[0.0, 0.0, 0.0]], [[3.0, 0.0, 0.0]]),
    "side on side": ([[0.0, -0.011, 0.0], [0.01, 0.011, 0.0]], [[0.0, 1.5, 0.0], [0.0, -1.5, 0.0]]),
    "end on end": ([[-0.016, 0.0, 0.0], [0.016, 0.004, 0.0]], [[1.5, 0.0, 0.0], [-1.5, 0.0, 0.0]]),
}


@pytest.mark.parametrize("case", list(HITS))
def test_a_cylinder_rebounds_with_the_restitution(case: str) -> None:
    places, velocities = HITS[case]
    axis = int(np.argmax(np.abs(velocities[0])))
    # stiff, as the force across the direction of the impact goes with the depth
    balls = {"count": len(places), "positions": places, "velocities": velocities}
    inner = {"inner_radius": 0.03} if "inner" in case else {}
    machine = cylinder_machine(balls=balls, contact={"youngs_modulus": 1e10}, chamber=inner)
    run = simulate_chamber(machine, duration={1: 0.01 if inner else 0.04, 2: 0.006}[len(places)], sample=1e-3)
    first, last = run.ball_velocity.values[0], run.ball_velocity.values[-1]
    before, after = (v[0, axis] - (v[1, axis] if len(places) > 1 else 0.0) for v in (first, last))
    assert after == pytest.approx(-0.6 * before, rel=0.01)
    if len(places) > 1:
        assert np.abs(last.sum(axis=0)).max() < 1e-12
    assert np.abs(np.delete(last, axis, axis=1)).max() < 5e-3  # along the other axes nearly nothing
    assert abs(float(run.energy_error[-1])) < 2e-3 * MASS * 9.0


def test_an_oblique_impact_on_the_race_follows_coulomb_impulses() -> None:
    # sliding throughout: mu (1 + R) times the normal velocity, along the race and the axis together, and twice that of spin
    mu, across, along = 0.1, 1.2, 0.9
    given = {"positions": [[0.0, 0.0, -0.089999]], "velocities": [[along, across, -2.0]]}
    machine = cylinder_machine(balls=given, contact={"friction": mu, "youngs_modulus": 1e13})
    run = simulate_chamber(machine, duration=3e-4, sample=1e-4)  # stiff, as the race is curved
    lost = mu * 1.6 * 2.0
    velocity, spin = run.ball_velocity.values[-1, 0], run.ball_spin.values[-1, 0, 0]
    # at first 4 parts of 5 across; less in the end, as sliding across fades three times as fast
    assert 0.6 * lost < across - velocity[1] < 0.8 * lost
    assert R * spin == pytest.approx(-2.0 * (across - velocity[1]), rel=2e-3)
    assert math.hypot(across - velocity[1], along - velocity[0]) == pytest.approx(lost, rel=0.02)


def test_a_contact_takes_the_time_of_its_linear_spring() -> None:
    stiffness = line_stiffness(MODULUS, LENGTH)
    assert stiffness == pytest.approx(0.25 * math.pi * MODULUS * LENGTH, rel=1e-12)
    assert end_stiffness(MODULUS, R) < stiffness
    machine = cylinder_machine(balls={"count": 2, "positions": [[0.0, -0.02, 0.0], [0.0, 0.02, 0.0]]})
    assert contact_time(machine) == pytest.approx(math.pi * math.sqrt(0.5 * MASS / stiffness), rel=1e-12)


def pressed(machine: ChamberMachine, places: np.ndarray, place: np.ndarray) -> Any:
    """Everything at these places, at rest."""
    chamber = assemble_chamber(machine, places, 1e-6)
    chamber.body.place = place
    start(chamber)
    return chamber


CORNERS = {
    "side on side": [[0.0, 0.0, 0.0], [0.012, 0.0121, 0.0158]],
    "end on end": [[0.0, 0.0, 0.0], [0.0297, 0.003, -0.008]],
    "corner on corner": [[0.0, 0.0, 0.0], [-0.0298, 0.0119, 0.0159]],
    "thin on thick": [[0.0, 0.0, 0.0], [0.0299, 0.02, 0.01]],
    "race and wall": [[0.0, 0.0, 0.0], [0.0852, 0.0541, 0.0722]],
}


@pytest.mark.parametrize("case", list(CORNERS))
def test_forces_on_cylinders_and_on_the_tilted_rotor_are_slopes_of_one_energy(case: str) -> None:
    group = {"body": "cylinder", "count": 1, "density": 7800.0, "diameter": 0.02, "length": 0.03}
    other = group | ({"diameter": 0.04, "length": 0.02} if case == "thin on thick" else {})
    machine = cylinder_machine(
        body={"freedom": "free", "mass": 20.0, "inertia": [0.5, 0.5, 0.5]},
        chamber={"balls": [group, other]},
        contact={"restitution": 1.0},
    )
    if case == "thin on thick":
        CORNERS[case][1][0] = 0.0249
    places, place = np.array(CORNERS[case]), np.zeros(7)
    place[4:6] = 2e-5, -3e-5  # tilted

    def energy(moved: np.ndarray) -> float:
        at = place.copy()
        at[4:6] += moved[6:]
        return float(pressed(machine, places + moved[:6].reshape(2, 3), at).power.stored)

    chamber = pressed(machine, places, place)
    force = np.r_[chamber.balls.force.ravel(), chamber.body.contact_moment[1:]]
    slopes = np.zeros(8)
    for i in range(8):
        step = np.zeros(8)
        step[i] = 1e-8 if i < 6 else 1e-7
        slopes[i] = (energy(step) - energy(-step)) / (2.0 * step[i])
    size = np.abs(slopes[:6]).max()
    assert size > 0.5
    assert force[:6] == pytest.approx(-slopes[:6], abs=1e-5 * size)
    # small rotations: to first order
    assert force[6:] == pytest.approx(-slopes[6:], abs=2e-4 * 0.1 * size)


def test_without_friction_and_loss_the_energy_of_cylinders_in_contact_stays() -> None:
    # two swing on the race, half their length apart, and touch each other softly again and again
    angle = math.asin(R * 1.0000001 / ORBIT)
    places = [[x, ORBIT * math.sin(a + 0.3), -ORBIT * math.cos(a + 0.3)] for x, a in ((0.0, angle), (0.015, -angle))]
    balls = {"count": 2, "positions": places}
    machine = cylinder_machine(balls=balls, contact={"restitution": 1.0, "youngs_modulus": 1e6}, gravity=[0.0, 0.0, -G])
    run = simulate_chamber(machine, duration=0.3, step=5e-6, sample=1e-2, method="runge_kutta")
    assert float(run.energy_kinetic.max()) > 5e-3
    assert float(np.abs(run.energy_error).max()) < 1e-9 * float(run.energy_kinetic.max())


def test_without_friction_and_loss_collisions_keep_the_energy_the_better_the_shorter_the_step() -> None:
    random = np.random.default_rng(3)
    places = [[x, y, z] for x in (-0.05, 0.0, 0.05) for y, z in ((-0.03, 0.01), (0.03, -0.01))]
    given = {"count": 6, "positions": places, "velocities": random.uniform(-2.0, 2.0, (6, 3)).tolist()}
    machine = cylinder_machine(
        balls=given, contact={"restitution": 1.0, "youngs_modulus": 1e6}, chamber={"radius": 0.06, "depth": 0.16}
    )
    errors = []
    for step in (2e-5, 2e-6):
        run = simulate_chamber(machine, duration=0.1, step=step, sample=1e-2, method="runge_kutta")
        errors.append(float(np.abs(run.energy_error).max() / run.energy_kinetic[0]))
    assert int(run.contacts_ball.sum()) > 5
    assert int(run.contacts_wall.sum()) > 10
    # the slope of a force along a line jumps where the contact begins, within a step
    assert errors[0] < 1e-5
    assert errors[1] < 0.1 * errors[0]


def flying(count: int = 6) -> dict[str, Any]:
    """Cylinders that fly about in a small chamber."""
    random = np.random.default_rng(1)
    places = [[x, 0.03 * math.cos(a), 0.03 * math.sin(a)] for x in (-0.02, 0.02) for a in (0.5, 2.6, 4.7)][:count]
    spins = np.c_[random.uniform(-200.0, 200.0, count), np.zeros((count, 2))]
    return {
        "count": count, "positions": places, "velocities": random.uniform(-4.0, 4.0, (count, 3)).tolist(),
        "spins": spins.tolist(),
    }  # fmt: skip


def test_momentum_and_angular_momentum_of_a_released_machine_stay() -> None:
    body = {"freedom": "free", "mass": 20.0, "inertia": [0.5, 0.5, 0.5]}
    machine = cylinder_machine(
        balls=flying(), body=body, chamber={"radius": 0.06, "depth": 0.1}, contact={"friction": 0.4}, **coasting(60.0)
    )
    tilted = 6.0 * MASS * (R**2 / 4.0 + LENGTH**2 / 12.0)

    def momenta(chamber: Any) -> tuple[np.ndarray, np.ndarray]:
        q, v, balls = chamber.body.place, chamber.body.rate, chamber.balls
        axis = np.array([1.0, q[5], -q[4]])
        linear = 23.0 * v[:3] + (balls.mass[:, None] * balls.velocity).sum(axis=0)
        angular = 23.0 * np.cross(q[:3], v[:3]) + 0.5 * v[3:6] + (0.32 + tilted) * np.array([0.0, v[4], v[5]])
        angular += (0.5 * v[6] + (balls.inertia * balls.spin[:, 0]).sum()) * axis
        return linear, angular + (balls.mass[:, None] * np.cross(balls.position, balls.velocity)).sum(axis=0)

    step = contact_time(machine) / 40.0
    march = begin(machine, step, 10, "verlet", 0, False)
    first = momenta(march.chamber)
    part = march.take(round(0.04 / step / 10))
    last = momenta(march.chamber)
    assert int(part.contacts_wall.sum()) > 5
    assert int(part.contacts_ball.sum()) > 3
    tilt = np.abs(march.chamber.body.place[4:6]).max()
    assert 5e-5 < tilt < 1e-2
    assert np.abs(last[0] - first[0]).max() < 1e-12
    # to first order in the tilt: along the axis its product with the lateral part is left out
    assert np.abs(last[1] - first[1])[1:].max() < 5e-9
    assert np.abs(last[1] - first[1])[0] < tilt * np.linalg.norm(first[1][1:]) < 1e-5 * first[1][0]


def test_the_account_of_the_energy_closes_with_the_square_of_the_step() -> None:
    body = {"freedom": "free", "mass": 20.0, "inertia": [0.5, 0.5, 0.5]}
    contact = {"friction": 0.4, "rolling_arm": 1e-4}
    machine = cylinder_machine(
        balls=flying(), body=body, chamber={"radius": 0.06, "depth": 0.1}, contact=contact, **coasting(60.0)
    )
    errors = []
    for count in (25, 100):
        run = simulate_chamber(machine, duration=0.3, step=contact_time(machine) / count, sample=1e-2)
        errors.append(float(np.abs(run.energy_error).max()))
    assert float(run.loss_friction[-1]) > 1.0
    assert float(run.loss_contact[-1]) > 1.0
    assert float(run.loss_rolling[-1]) > 0.1
    assert errors[0] < 1e-3 * float(run.loss_friction[-1])
    assert errors[1] < errors[0] / 8.0


def test_cylinders_stacked_end_on_end_bear_what_stands_on_them() -> None:
    # the drum stands: three on each other, each contact pressed in by the weight above over 2 E* r
    places = [[-0.1 + LENGTH * (0.5 + k), 0.0, 0.0] for k in range(3)]
    balls = {"count": 3, "positions": places}
    machine = cylinder_machine(
        balls=balls, gravity=[-G, 0.0, 0.0], contact={"restitution": 0.9, "friction": 0.3, "youngs_modulus": 1e7}
    )
    run = simulate_chamber(machine, duration=0.5, sample=1e-2)
    middles = run.ball_position.values[-1, :, 0] + 0.1
    depths = LENGTH * (0.5 + np.arange(3)) - middles
    # at rest the force is midway between that of approach and that of separation
    one = MASS * G / (0.5 * (1.0 + 0.9**2) * end_stiffness(0.1 * MODULUS, R))
    assert np.diff(np.r_[0.0, depths]) == pytest.approx(one * np.array([3.0, 2.0, 1.0]), rel=3e-3)
    assert np.abs(run.ball_velocity.values[-1]).max() < 1e-4


def test_a_cylinder_that_spins_on_the_floor_is_braked_as_a_disc() -> None:
    # J w' = -2/3 mu m g r
    friction, speed = 0.2, 100.0
    balls = {"positions": [[-0.085, 0.02, 0.0]], "velocities": [STILL], "spins": [[speed, 0.0, 0.0]]}
    machine = cylinder_machine(balls=balls, gravity=[-G, 0.0, 0.0], contact={"friction": friction, "restitution": 0.3})
    run = simulate_chamber(machine, duration=0.2, sample=1e-2)
    lost = speed - run.ball_spin.values[:, 0, 0]
    assert lost == pytest.approx(4.0 / 3.0 * friction * G / R * run.time.values, abs=0.01 * lost[-1])
    assert float(run.loss_friction[-1]) == pytest.approx(
        0.25 * MASS * R**2 * (speed**2 - (speed - lost[-1]) ** 2), rel=2e-2
    )


@pytest.mark.parametrize("friction", [0.3, 1.2])
def test_a_cylinder_that_slides_on_the_floor_would_tip_by_friction_times_length_over_diameter(friction: float) -> None:
    balls = {"positions": [[-0.085, -0.05, 0.0]], "velocities": [[0.0, 1.0, 0.0]]}
    machine = cylinder_machine(balls=balls, gravity=[-G, 0.0, 0.0], contact={"friction": friction, "restitution": 0.3})
    run = simulate_chamber(machine, duration=0.06, sample=2e-2)
    assert run.tilting.values[1:] == pytest.approx(np.full(3, friction * LENGTH / (2.0 * R)), rel=1e-3)


@pytest.mark.parametrize(("gap", "tilt"), [(0.03, 0.0), (0.0304, None), (0.0361, 0.5 * math.pi)])
def test_flat_walls_let_a_cylinder_tilt_until_its_corners_meet_them(gap: float, tilt: float | None) -> None:
    found = tilt_between_walls(LENGTH, 2.0 * R, gap)
    if tilt is not None:
        assert found == pytest.approx(tilt, abs=1e-12)
    else:
        assert LENGTH * math.cos(found) + 2.0 * R * math.sin(found) == pytest.approx(gap, rel=1e-12)
        assert 0.0 < found < 0.03


def test_contacts_are_found_by_cells_as_by_looking_at_every_pair() -> None:
    balls = {"count": 130, "diameter": 0.012, "length": 0.03}
    machine = cylinder_machine(balls=balls, gravity=[0.0, 0.0, -G], chamber={"radius": 0.1, "depth": 0.13})
    march = begin(machine, contact_time(machine) / 25.0, 1, "verlet", 2, False)
    pairs, places = march.chamber.pairs, march.chamber.balls.position
    count, margin = int(march.chamber.progress.pairs), float(march.chamber.run.margin)
    listed = sorted(zip(pairs.first[:count].tolist(), pairs.second[:count].tolist(), strict=True))
    near = [
        (i, j)
        for i in range(130)
        for j in range(i + 1, 130)
        if abs(places[i, 0] - places[j, 0]) < 0.03 + margin
        and math.hypot(*(places[i, 1:] - places[j, 1:])) < 0.012 + margin
    ]
    assert listed == near
    assert count > 200
