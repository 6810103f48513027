"""Balls free in three dimensions: collisions, rolling, balances, reactions, time stepping."""

from __future__ import annotations

import math

import numpy as np
import pytest

from autobalancer.assembly.chamber_assembly import contact_time
from autobalancer.errors import MachineError, QuestionError
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.simulation.chamber import simulate_chamber

RADIUS = (0.75 * 0.02 / (math.pi * 7800.0)) ** (1.0 / 3.0)
FREE = {
    "freedom": "free", "mass": 20.0, "inertia": (1.0, 1.2, 0.9), "center": (0.01, 0.0, -0.1),
}  # fmt: skip


def machine(**changes):
    balls = {"count": 2, "density": 7800.0, "mass": 0.02}
    balls |= changes.pop("balls", {})
    contact = {"law": "restitution", "restitution": 0.54, "friction": 0.0, "stiffness": 1e9} | changes.pop(
        "contact", {}
    )
    rotor = {"mass": 3.0, "polar_inertia": 0.02, "transverse_inertia": 0.02, "bearings": (0.1, -0.1)}
    chamber = {"radius": 0.1, "depth": 0.2, "balls": [balls]} | changes.pop("chamber", {})
    description = {
        "name": "test", "gravity": (0.0, 0.0, 0.0), "body": {"freedom": "fixed"},
        "rotor": rotor | changes.pop("rotor", {}), "chambers": [chamber], "contact": contact,
        "drive": {"kind": "speed", "profile": {"kind": "constant", "speed": changes.pop("speed", 0.0)}},
    }  # fmt: skip
    return ChamberMachine(**(description | changes))


def idle(speed):
    """A motor without torque."""
    motor = {
        "kind": "asynchronous",
        "rated_torque": 0.0,
        "overload": 2.0,
        "synchronous_speed": 100.0,
        "breakdown_slip": 0.2,
    }
    return {"drive": motor, "start": {"speed": speed}}


def meeting(velocities, offset=0.0, spins=None, **contact):
    places = ((0.0, -0.0095, 0.0), (0.0, 0.0095, offset))
    given = {"positions": places, "velocities": velocities}
    return machine(balls=given | ({"spins": spins} if spins else {}), contact=contact)


@pytest.mark.parametrize("stiffness", [1e8, 1e9, 1e10])
@pytest.mark.parametrize("speed", [0.5, 4.0])
def test_balls_that_meet_head_on_part_with_the_restitution(stiffness, speed):
    run = simulate_chamber(
        meeting(((0.0, speed / 2, 0.0), (0.0, -speed / 2, 0.0)), stiffness=stiffness),
        duration=0.0075 / speed,
        sample=0.0075 / speed,
    )
    velocity = run.ball_velocity.values[-1]
    assert velocity[1, 1] - velocity[0, 1] == pytest.approx(0.54 * speed, rel=0.005)
    assert np.abs(velocity.sum(axis=0)).max() < 1e-12


def test_a_ball_rebounds_from_race_and_flat_wall_with_the_restitution():
    for velocity in ((0.0, 0.0, -3.0), (3.0, 0.0, 0.0)):
        given = {"count": 1, "positions": ((0.0, 0.0, 0.0),), "velocities": (velocity,)}
        run = simulate_chamber(machine(balls=given), duration=0.04, sample=1e-2)
        axis = int(np.argmax(np.abs(velocity)))
        assert run.ball_velocity.values[-1, 0, axis] == pytest.approx(-0.54 * velocity[axis], rel=0.005)


def test_an_oblique_collision_follows_coulomb_impulses():
    # sliding throughout: tangential impulse mu times the normal one, which also spins both balls
    speed, mu, across = 2.0, 0.1, 1.0
    run = simulate_chamber(
        meeting(((0.0, speed / 2, across), (0.0, -speed / 2, -across)), friction=mu, stiffness=1e12),
        duration=0.004,
        sample=0.004,
    )
    before, after = run.ball_velocity.values[0], run.ball_velocity.values[-1]
    impulse = 0.02 * (after[0] - before[0])
    # where they touch the line of centers is tilted by the way gone across
    at = (0.0095 - RADIUS) / (speed / 2)
    for _ in range(30):
        at = (0.0095 - math.sqrt(RADIUS**2 - (across * at) ** 2)) / (speed / 2)
    normal = np.array([0.0, math.sqrt(RADIUS**2 - (across * at) ** 2), -across * at]) / RADIUS
    pressed = -impulse @ normal
    sideways = impulse + pressed * normal
    assert pressed == pytest.approx(0.5 * 0.02 * 1.54 * ((before[0] - before[1]) @ normal), rel=0.01)
    assert np.linalg.norm(sideways) == pytest.approx(mu * pressed, rel=0.01)
    inertia = 0.4 * 0.02 * RADIUS**2
    spin = RADIUS * np.cross(normal, sideways) / inertia
    assert run.ball_spin.values[-1] == pytest.approx(np.array([spin, spin]), rel=0.02, abs=0.1)


def test_a_ball_rests_in_a_turning_drum_where_rolling_resistance_holds_it():
    arm = 5e-4
    start = {"count": 1, "positions": ((0.0, 0.0, -(0.1 - RADIUS)),)}
    spin = 5.0 * 0.1 / RADIUS
    given = machine(
        gravity=(0.0, 0.0, -9.81), speed=5.0, balls=start | {"velocities": ((0.0, 0.0, 0.0),), "spins": ((spin, 0.0, 0.0),)},
        contact={"friction": 0.6, "rolling_arm": arm, "stiffness": 1e8}, chamber={"drag": 0.1},
    )  # fmt: skip
    run = simulate_chamber(given, duration=4.0, sample=1e-2)
    y, z = run.ball_position.values[-30:, 0, 1].mean(), run.ball_position.values[-30:, 0, 2].mean()
    angle = math.atan2(y, -z)
    # moments about the contact point: weight r sin(angle) = rolling moment f N + drag r u, with N = m g cos(angle)
    u = 5.0 * (0.1 - RADIUS)
    weight = 0.02 * 9.81
    wanted = weight * RADIUS * math.sin(angle) - arm * weight * math.cos(angle)
    assert wanted == pytest.approx(0.1 * u * RADIUS, rel=0.02)
    assert run.ball_spin.values[-1, 0, 0] == pytest.approx(spin, rel=0.01)


def test_a_collision_keeps_the_angular_momentum_of_spinning_balls():
    spins = ((30.0, -80.0, 10.0), (0.0, 50.0, 200.0))
    given = meeting(((0.1, 1.0, 0.3), (-0.2, -1.0, 0.0)), offset=0.004, spins=spins, friction=0.4)
    run = simulate_chamber(given, duration=0.006, sample=0.001)
    place, velocity, spin = (run[name].values for name in ("ball_position", "ball_velocity", "ball_spin"))
    total = 0.02 * np.cross(place, velocity).sum(axis=1) + 0.4 * 0.02 * RADIUS**2 * spin.sum(axis=1)
    assert run.contacts_ball.values.sum() == 1
    assert np.abs(spin[-1] - spin[0]).max() > 10.0
    assert np.abs(total - total[0]).max() < 1e-9 * np.abs(total[0]).max()


def tumbling(**changes):
    return machine(
        balls={"count": 12}, contact={"friction": 0.4, "rolling_arm": 1e-4, "stiffness": 1e8}, body=FREE,
        unbalances=[{"moment": 0.01, "position": 0.05}], chamber={"radius": 0.04, "depth": 0.08},
        rotor={"mass": 3.0, "polar_inertia": 0.02, "transverse_inertia": 0.02},
        **(idle(40.0) | changes),
    )  # fmt: skip


def test_the_momentum_of_a_free_machine_stays():
    free = tumbling()
    run = simulate_chamber(free, duration=0.2, sample=0.01, settle=False)
    balls = 0.02 * run.ball_velocity.values.sum(axis=1)
    # body without supports: momentum of body and rotor from their velocities, by differences of positions
    fine = simulate_chamber(free, duration=0.2, sample=1e-4, settle=False)
    reference = fine.body_position.values
    rotation = fine.body_rotation.values
    theta = fine.rotor_angle.values
    u = 0.01 * np.column_stack([np.zeros_like(theta), np.cos(theta), np.sin(theta)])
    tilt = np.cross(np.column_stack([0 * theta, rotation[:, 1], rotation[:, 2]]), u)
    places = 23.0 * reference + 20.0 * np.cross(rotation, FREE["center"]) + u + tilt
    swing = 0.02 * (fine.ball_velocity.values.sum(axis=1))
    moved = places + np.vstack([np.zeros(3), np.cumsum(0.5e-4 * (swing[1:] + swing[:-1]), axis=0)])
    drift = moved - moved[0] - np.outer(fine.time, 0.01 * 40.0 * np.array([0.0, 0.0, 1.0]))
    assert np.abs(balls).max() > 0.005
    assert np.abs(drift).max() < 2e-3 * np.abs(places).max()


def test_energy_is_accounted_for_and_the_error_falls_with_the_step():
    free = tumbling(gravity=(0.0, 0.0, -9.81))
    shortest = contact_time(free)
    errors = []
    for step in (shortest / 25, shortest / 100):
        run = simulate_chamber(free, duration=0.3, step=step, settle=False)
        lost = float(sum(run[name][-1] for name in ("loss_contact", "loss_friction", "loss_rolling")))
        errors.append(float(np.abs(run.energy_error).max()) / lost)
        assert lost > 0.05
    assert errors[0] < 1e-3
    assert errors[1] < 0.5 * errors[0]


def test_bearing_forces_are_newtons_on_the_rotor():
    turning = machine(
        speed=50.0, unbalances=[{"moment": 0.01, "position": 0.04}],
        balls={"count": 1, "positions": ((0.0, 0.0, 0.0),)}, gravity=(0.0, 0.0, -9.81),
    )  # fmt: skip
    run = simulate_chamber(turning, duration=1e-3, sample=1e-3)
    angle = run.rotor_angle.values[0]
    pull = 0.01 * 50.0**2 * np.array([0.0, math.cos(angle), math.sin(angle)])
    forces = run.bearing_force.values[0]
    assert forces.sum(axis=0) == pytest.approx(-pull + [0.0, 0.0, 3.0 * 9.81], abs=1e-9)
    # moments about x = 0.04: the unbalance has none
    assert (0.1 - 0.04) * forces[0, 1] + (-0.1 - 0.04) * forces[1, 1] == pytest.approx(0.0, abs=1e-9)


def test_the_motor_gives_its_breakdown_torque_at_breakdown_speed():
    motor = {
        "kind": "asynchronous",
        "rated_torque": 14.6,
        "overload": 2.2,
        "synchronous_speed": 157.08,
        "breakdown_slip": 0.2,
    }
    for speed, torque in ((0.8 * 157.08, 14.6 * 2.2), (157.08, 0.0), (0.0, 2 * 14.6 * 2.2 / (0.2 + 5.0))):
        run = simulate_chamber(
            machine(drive=motor, start={"speed": speed}, balls={"count": 1}), duration=0.0, settle=False
        )
        assert run.motor_torque.values[0] == pytest.approx(torque, abs=1e-9)


def test_bearing_friction_slows_the_rotor():
    heavy = {"mass": 3.0, "neck_diameter": 0.03, "bearing_friction": 0.01}
    slowed = machine(
        rotor=heavy, gravity=(0.0, 0.0, -9.81), balls={"count": 1, "positions": ((0, 0, 0),)}, **idle(50.0)
    )
    run = simulate_chamber(slowed, duration=0.05, sample=0.05)
    torque = 0.01 * 0.015 * 3.0 * 9.81
    assert run.speed.values[-1] == pytest.approx(50.0 - torque / 0.02 * 0.05, rel=1e-6)
    assert run.loss_bearings.values[-1] == pytest.approx(torque * 50.0 * 0.05, rel=1e-3)


@pytest.mark.parametrize(("method", "order"), [("verlet", 2), ("runge_kutta", 4)])
def test_steps_converge_with_the_order_of_the_method(method, order):
    elastic = meeting(((0.0, 1.0, 0.2), (0.0, -1.0, -0.2)), restitution=1.0, stiffness=1e7)
    shortest = contact_time(elastic)

    def end(count):
        run = simulate_chamber(elastic, duration=1.4e-3, sample=1.4e-3, step=shortest / count, method=method)
        return run.ball_velocity.values[-1]

    exact = end(4000)
    # in the middle of contact; the start of the contact within a step limits the order to 5/2
    coarse, fine = (float(np.abs(end(count) - exact).max()) for count in (50, 200))
    assert math.log(coarse / fine, 4) > min(order, 2.5) - 0.6


def test_a_run_is_the_same_every_time_and_after_a_resume():
    mixed = tumbling(gravity=(0.0, 0.0, -9.81))
    held = []
    whole = simulate_chamber(
        mixed, duration=0.1, seed=3, settle=False, chunk=40, on_chunk=lambda part, state: held.append(state)
    )
    again = simulate_chamber(mixed, duration=0.1, seed=3, settle=False)
    later = simulate_chamber(mixed, duration=0.1, resume=held[0])
    for name in whole.data_vars:
        assert np.array_equal(whole[name].values, again[name].values), name
        assert np.array_equal(whole[name].values[41:], later[name].values), name


def test_a_ball_with_memory_rolls_without_slip_where_a_sliding_one_slips():
    # on a flat wall as floor; the rolling moment lets it creep, the contact point must rest
    level = {"count": 1, "positions": ((-(0.1 - RADIUS), 0.0, 0.0),)}
    slip = {}
    for law in ("history", "restitution"):
        pulled = machine(
            gravity=(-9.81, 0.0, -2.0), balls=level,
            contact={"law": law, "friction": 0.5, "rolling_arm": 0.02, "stiffness": 1e8},
        )  # fmt: skip
        run = simulate_chamber(pulled, duration=0.2, sample=1e-2)
        slip[law] = abs(float(run.ball_velocity[-1, 0, 2] + RADIUS * run.ball_spin[-1, 0, 1]))
    assert slip["history"] < 1e-9
    assert 1e-4 < slip["restitution"] < 1e-3


def test_a_ball_with_memory_rebounds_with_the_restitution():
    for restitution in (0.9, 0.7, 0.4, 0.1):
        fast = meeting(((0.0, 1.0, 0.0), (0.0, -1.0, 0.0)), law="history", restitution=restitution)
        # the law is exact; the default step leaves up to 0.6 %
        velocity = simulate_chamber(fast, duration=0.004, sample=0.004, step=2e-7).ball_velocity.values[-1]
        assert velocity[1, 1] - velocity[0, 1] == pytest.approx(restitution * 2.0, rel=5e-4)


def test_the_constraint_force_is_what_a_fixed_machine_presses_on_its_foundation():
    # balls at rest in a chamber at rest weigh what they weigh
    resting = machine(balls={"count": 6}, gravity=(0.0, 0.0, -9.81), contact={"stiffness": 1e8, "friction": 0.3})
    run = simulate_chamber(resting, duration=0.1, sample=0.1)
    assert run.constraint_force.values[-1, 2] == pytest.approx(6 * 0.02 * 9.81, rel=0.02)


def test_what_cannot_be_is_refused_with_its_place():
    with pytest.raises(MachineError, match=r"at most \d+ do"):
        simulate_chamber(machine(balls={"count": 5000}), duration=0.1)
    with pytest.raises(MachineError, match="balls 1 and 2 overlap"):
        simulate_chamber(machine(balls={"positions": ((0, 0, 0), (0, 0, 0.01))}), duration=0.1)
    with pytest.raises(QuestionError, match="shortest contact lasts"):
        simulate_chamber(machine(), duration=0.1, step=1e-3)
    with pytest.raises(MachineError, match=r"restitution: given 1\.2"):
        machine(contact={"restitution": 1.2})
    with pytest.raises(MachineError, match="friction: given -1"):
        machine(contact={"friction": -1.0})
    with pytest.raises(MachineError, match="mm wide"):
        machine(chamber={"radius": 0.005})
