"""A resolved ball on the floor of its annulus, vertical axis: rolling and sliding, and how the wall takes it over."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.references.resolved import chamber, run

import autobalancer as ab
from autobalancer.files.examples import rig
from autobalancer.kernels import records as at
from autobalancer.machine import Machine

GRAVITY, ORBIT, RADIUS, MASS = 9.80665, 0.1, 0.005, 5e-3
GRIP: dict[str, Any] = {"restitution": 0.3, "sliding_friction": 0.5, "floor_friction": 0.5, "slip_speed": 1e-4}


def driven(machine: Machine, **profile: Any) -> Machine:
    """The machine with another speed."""
    kept = {key: getattr(machine, key) for key in machine.model_fields_set}
    return Machine(**{**kept, "drive": {"kind": "speed", "profile": profile}})


def place(own: Any) -> Any:
    return own[:, 0, at.BALL_X] + 1j * own[:, 0, at.BALL_Y]


def test_a_ball_that_rolls_on_a_turntable_goes_round_in_circles_at_two_sevenths_of_its_speed() -> None:
    """In space v' = (2/7) w e x v, whatever the friction that keeps it rolling."""
    w, v = 7.0, 0.1
    machine = chamber(speed=w, start_gap=0.05, **GRIP)
    # at rest in space on the turntable it would slip; it rolls with u - r t x e = 0
    start = {(0, at.BALL_X): 0.05, (0, at.BALL_Y): 0.0, (0, at.BALL_VX): 0.0, (0, at.BALL_VY): v - w * 0.05}
    start |= {(0, at.TUMBLE_X): -start[0, at.BALL_VY] / RADIUS, (0, at.TUMBLE_Y): 0.0}
    times = np.linspace(0.0, 1.0, 41)
    _, own, _ = run(machine, times, start, tolerance=1e-9)
    in_space = place(own) * np.exp(1j * w * times)
    turn = 2.0 / 7.0 * w
    circle = 0.05 + v / turn * (np.exp(1j * turn * times) - 1.0)
    np.testing.assert_allclose(in_space, circle, atol=1e-4 * v / turn + 2e-5)


def test_a_ball_that_slides_on_the_floor_rolls_on_with_five_sevenths_of_its_speed() -> None:
    v = 0.2
    machine = chamber(start_gap=0.09, **GRIP)
    start = {(0, at.BALL_X): 0.0, (0, at.BALL_Y): 0.0, (0, at.BALL_VX): v}
    _, own, _ = run(machine, [0.0, 0.2], start, tolerance=1e-9)
    assert own[-1, 0, at.BALL_VX] == pytest.approx(5.0 / 7.0 * v, rel=1e-3)
    assert own[-1, 0, at.TUMBLE_Y] == pytest.approx(5.0 / 7.0 * v / RADIUS, rel=1e-3)


def test_rolling_resistance_of_the_floor_slows_a_rolling_ball_by_a_over_r_in_1_4() -> None:
    arm, v = 0.02, 0.2
    machine = chamber(start_gap=0.09, race={"friction": {"rolling_resistance": arm}}, rest_speed=1e-4, **GRIP)
    start = {(0, at.BALL_X): 0.0, (0, at.BALL_Y): 0.0, (0, at.BALL_VX): v, (0, at.TUMBLE_Y): v / RADIUS}
    _, own, _ = run(machine, [0.0, 0.3], start, tolerance=1e-9)
    assert own[-1, 0, at.BALL_VX] == pytest.approx(v - arm * GRAVITY / 1.4 * 0.3, rel=1e-3)


def test_in_the_corner_a_ball_rolls_on_floor_and_wall_with_nine_fifths_of_its_mass() -> None:
    """Both contacts rest in the rotor: m (eps a + v') = (2/5) m (a - v'/r) - 2/5 m v' leaves v' = -a (eps - 2 r/5)/1.8."""
    growth, end = 2.0, 1.0
    slow = {"kind": "ramp", "start": 4.0, "end": 4.0 + growth * end, "duration": end}
    found = {}
    for floor in (0.5, 0.0):
        machine = driven(chamber(**GRIP | {"sliding_friction": 0.3, "floor_friction": floor}), **slow)
        _, own, _ = run(machine, [0.0, end], tolerance=1e-9)
        along = own[-1, 0, [at.BALL_VX, at.BALL_VY]] @ np.array([-place(own)[-1].imag, place(own)[-1].real]) / ORBIT
        found[floor] = -along / (growth * end * (ORBIT - 0.4 * RADIUS))
    assert found[0.5] == pytest.approx(1.0 / 1.8, rel=2e-3)
    assert found[0.0] == pytest.approx(1.0 / 1.4, rel=2e-3)


@pytest.mark.parametrize(("motion", "stays"), [("sliding", 0.0), ("rolling", 5.0 / 7.0)])
def test_on_a_floor_that_starts_to_turn_a_sliding_ball_goes_along_and_a_rolling_one_stays_behind_by_five_sevenths(
    motion: str, stays: float
) -> None:
    """In space a rolling ball has two sevenths of the velocity of the floor under it, so it is not thrown outward either."""
    machine = chamber(**GRIP, start_gap=0.02, floor_motion=motion)
    slow = driven(machine, kind="ramp", start=0.0, end=5.0, duration=1.0)
    _, own, _ = run(slow, [0.0, 0.5, 1.0], tolerance=1e-8)
    np.testing.assert_allclose(np.abs(place(own)), ORBIT - 0.02, rtol=2e-3)
    turned = np.unwrap(np.angle(place(own)))
    np.testing.assert_allclose(turned, -stays * np.array([0.0, 0.625, 2.5]), atol=5e-3)


def test_oil_throws_a_ball_outward_that_rolls_on_the_floor() -> None:
    oil = {"fluid": {"density": 900.0, "viscosity": 2e-5}, "drag": {"law": "sphere_on_plane"}}
    machine = chamber(**GRIP, start_gap=0.02, race=oil)
    slow = driven(machine, kind="ramp", start=0.0, end=5.0, duration=1.0)
    _, own, _ = run(slow, [0.0, 4.0], tolerance=1e-8)
    assert abs(place(own)[-1]) > ORBIT


def test_friction_of_floor_and_wall_only_takes_energy_from_a_ball_that_tumbles() -> None:
    """The rotor is at rest; kinetic energy, all three spins, and the spring of the wall."""
    friction = {"rolling_resistance": 0.01}
    grip = GRIP | {"slip_speed": 5e-3, "sliding_friction": 0.2, "floor_friction": 0.3}
    machine = chamber(start_gap=0.01, race={"friction": friction}, rest_speed=1e-2, **grip)
    start = {
        (0, at.BALL_VX): 0.4,
        (0, at.BALL_VY): 0.6,
        (0, at.TUMBLE_X): 80.0,
        (0, at.TUMBLE_Y): -120.0,
        (0, at.BALL_SPIN): 60.0,
    }
    _, own, _ = run(machine, np.linspace(0.0, 1.0, 2001), start, tolerance=1e-10)
    moving = (own[:, 0, [at.BALL_VX, at.BALL_VY]] ** 2).sum(1)
    turning = (own[:, 0, [at.BALL_SPIN, at.TUMBLE_X, at.TUMBLE_Y]] ** 2).sum(1)
    spring = np.maximum(np.abs(place(own)) - ORBIT, 0.0) ** 2
    energy = 0.5 * MASS * (moving + 0.4 * RADIUS**2 * turning) + 0.5 * 1e6 * spring
    assert np.diff(energy).max() < 1e-9 * energy[0]
    assert energy[-1] < 0.7 * energy[0]
    assert (np.abs(place(own)) > ORBIT).any()


def test_a_run_says_until_when_its_balls_are_on_the_floor() -> None:
    """From w^2 eps = g/mu on, w being the speed of the ball, which stays behind in the corner; slowly, so that it rolls there."""
    mu, begin = 0.5, 8.0  # rad/s, at which the wall is pressed enough for rolling
    behind = (1.0 - 0.4 * RADIUS / ORBIT) / 1.8
    leaves = (math.sqrt(GRAVITY / mu / ORBIT) - behind * begin) / (1.0 - behind)
    up = driven(chamber(**GRIP | {"sliding_friction": mu}), kind="ramp", start=begin, end=1.2 * leaves, duration=4.0)
    risen = ab.simulate(up, duration=4.0, save=ab.Samples(2001), tolerance=1e-6)
    found = ab.run_measures(risen)
    assert found["lift_off_speed"].values == pytest.approx([leaves], rel=1e-2)
    assert found["lift_off_time"].values == pytest.approx([4.0 * (leaves - begin) / (1.2 * leaves - begin)], rel=1.5e-2)
    at_lift = f"{float(found['lift_off_time'][0]):.3g} s ({float(found['lift_off_speed'][0]):.3g} rad/s)"
    assert f"on the floor of the annulus: ball 1 until {at_lift}" in risen.attrs["remarks"]
    assert risen.attrs["remarks"][-1] in ab.verdict(risen).notes
    still = ab.simulate(driven(chamber(**GRIP), kind="constant", speed=5.0), duration=0.1, save=ab.Samples(11))
    assert still["ball_floor_force"].values[-1] == pytest.approx(MASS * GRAVITY - mu * MASS * ORBIT * 25.0, rel=1e-3)
    assert np.isnan(ab.run_measures(still)["lift_off_speed"].values).all()
    assert "ball 1 up to the end; friction of its wall carries it from 14 rad/s on" in " ".join(still.attrs["remarks"])


def test_a_ball_rests_on_its_wall_where_stiff_bearings_have_critical_speeds_that_no_ball_goes_round_at() -> None:
    """Accuracy is asked for from what the speed of the rotor presses, not from 12 700 rad/s: before, the ball hopped for ever."""
    machine = rig("discoidal_rig_rubber")
    race = machine.balancers[0].races[0].model_dump(exclude_unset=True)
    race |= {
        "resolved": {key: GRIP[key] for key in ("restitution", "sliding_friction")}
        | {"stiffness": 3e4, "slip_speed": 0.02, "rest_speed": 1e-3}
    }
    turning = driven(ab.with_parameter(machine, "balancers[1].races[1]", race), kind="constant", speed=15.0)
    found = ab.simulate(turning, duration=1.0, save=ab.Samples(2001), tolerance=1e-6)
    force = found["ball_normal_force"].values[600:]
    assert max(found.attrs["critical_speeds"]) > 1e4
    needed = found["ball_moment"].values * found["ball_speed_in_space"].values[600:] ** 2
    np.testing.assert_allclose(force, needed, rtol=0.02)


def test_a_tumbling_ball_on_floor_and_wall_moves_as_in_space_with_all_three_spins() -> None:
    """Independent: position and spin as vectors at rest, slips by cross products with turning floor and wall, SciPy's solver."""
    speed, k, mu, mu_floor, v1 = 6.0, 2e3, 0.2, 0.4, 0.02
    machine = chamber(
        speed=speed,
        stiffness=k,
        restitution=1.0,
        sliding_friction=mu,
        floor_friction=mu_floor,
        slip_speed=v1,
        start_gap=0.01,
    )
    start = {
        (0, at.BALL_VX): 0.3,
        (0, at.BALL_VY): -0.2,
        (0, at.BALL_SPIN): 20.0,
        (0, at.TUMBLE_X): 40.0,
        (0, at.TUMBLE_Y): -70.0,
    }
    times = np.linspace(0.0, 0.5, 251)
    _, own, _ = run(machine, times, start, tolerance=1e-10)
    turning, up = np.array([0.0, 0.0, speed]), np.array([0.0, 0.0, 1.0])

    def rub(pressed: float, coefficient: float, velocity: Any, spin: Any, arm: Any, place: Any) -> tuple[Any, Any]:
        slip = velocity + np.cross(spin, arm) - np.cross(turning, place + arm)
        slip = slip - (slip @ arm) * arm / RADIUS**2
        fast = math.sqrt(slip @ slip) + 1e-15
        force = -pressed * coefficient * math.tanh(fast / v1) / fast * slip
        return force, np.cross(arm, force)

    def rate(_: float, y: Any) -> Any:
        place, velocity, spin = y[:3], y[3:6], y[6:]
        away = math.sqrt(place @ place)
        pressed, normal = k * max(away - ORBIT, 0.0), place / away
        carried = max(MASS * GRAVITY - mu * pressed, 0.0)
        floor, turn = rub(carried, mu_floor, velocity, spin, -RADIUS * up, place)
        wall, twist = rub(pressed, mu, velocity, spin, RADIUS * normal, place)
        force = floor + wall - pressed * normal
        force[2] = 0.0  # what carries it is balanced
        return np.concatenate([velocity, force / MASS, (turn + twist) / (0.4 * MASS * RADIUS**2)])

    begin = np.array([ORBIT - 0.01, 0.0, 0.0])
    y0 = np.concatenate([begin, np.array([0.3, -0.2, 0.0]) + np.cross(turning, begin), [40.0, -70.0, 20.0 + speed]])
    found = solve_ivp(rate, (0.0, 0.5), y0, t_eval=times, rtol=1e-10, atol=1e-12, method="LSODA", max_step=5e-4).y
    in_space = place(own) * np.exp(1j * speed * times)
    assert (np.abs(in_space) > ORBIT).any()
    np.testing.assert_allclose(in_space, found[0] + 1j * found[1], atol=1e-6)
    tumble = (own[:, 0, at.TUMBLE_X] + 1j * own[:, 0, at.TUMBLE_Y]) * np.exp(1j * speed * times)
    np.testing.assert_allclose(tumble, found[6] + 1j * found[7], atol=1e-3)
    np.testing.assert_allclose(own[:, 0, at.BALL_SPIN] + speed, found[8], atol=1e-3)
