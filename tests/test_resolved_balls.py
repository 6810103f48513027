"""Balls resolved in contact: where they fall onto the guided ball, and what a guided ball cannot do."""

from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.references.resolved import BALL, chamber, contact, run, states_at
from tests.references.resolved_run_ups import GRIP, ORBIT, PLANAR, RIG, RIGID, SHAFT, apart, run_up

import autobalancer as ab
from autobalancer.assembly.guided_balls import Lag
from autobalancer.assembly.system import assemble
from autobalancer.errors import MachineError
from autobalancer.kernels import records as at
from autobalancer.kernels.system import BALLS, X, Y
from autobalancer.machine import Machine
from autobalancer.simulation.saved import wall_contacts

GRAVITY = 9.80665
MACHINES = Path(__file__).resolve().parent.parent / "examples" / "machines"
OIL = {"density": 900.0, "viscosity": 2e-5}


@pytest.mark.parametrize(
    "rotor",
    [PLANAR, RIGID, pytest.param(SHAFT, marks=pytest.mark.slow), RIG],
    ids=["planar", "rigid", "shaft", "rig"],
)
@pytest.mark.parametrize("torque", [False, True], ids=["speed", "torque"])
def test_stiff_balls_that_do_not_slip_run_up_like_guided_ones(rotor: dict[str, Any], torque: bool) -> None:
    """The difference is that of the orbit, which the compliance of the wall makes larger: it falls with 1/k."""
    guided = run_up(rotor=rotor, torque=torque)
    soft, stiff = (
        apart(guided, run_up(contact(stiffness=k, slip_speed=0.01, **GRIP), rotor=rotor, torque=torque))
        for k in (1e6, 1e7)
    )
    assert stiff == pytest.approx(0.1 * soft, rel=0.02)
    assert stiff < 2e-3


def test_stiff_balls_in_two_races_in_each_of_two_planes_move_like_guided_ones() -> None:
    machine = ab.load_machine(MACHINES / "two_plane_rotor.toml")
    times = np.linspace(0.0, 0.1, 101)
    for b in (1, 2):
        race = machine.balancers[b - 1].races[0]
        races = [race, race.model_copy(update={"orbit_radius": 0.035})]
        machine = ab.with_parameter(machine, f"balancers[{b}].races", races)
    resolved, law = machine, contact(stiffness=1e8, slip_speed=0.03, **GRIP)
    for b, r in itertools.product((1, 2), (1, 2)):
        resolved = ab.with_parameter(resolved, f"balancers[{b}].races[{r}].resolved", law)
    a, b = (states_at(assemble(one), times, 1e-9) for one in (machine, resolved))
    n = len(assemble(machine).balls)
    assert np.ptp(a[:, BALLS : BALLS + n], axis=0).min() > 0.01
    np.testing.assert_allclose(b[:, BALLS : BALLS + n], a[:, BALLS : BALLS + n], atol=1e-3)
    np.testing.assert_allclose(b[:, [X, Y]], a[:, [X, Y]], atol=1e-3 * np.abs(a[:, [X, Y]]).max())


@pytest.mark.slow
def test_virtual_mass_nonlinear_drag_and_lag_act_as_on_guided_balls() -> None:
    race: dict[str, Any] = {"fluid": OIL, "drag": {"law": "sphere_on_plane", "range": "whole"}}
    lags = {(0, 0): Lag(rates=np.array([3.0]), gains=np.array([0.6]))}
    found = [
        # a third of the slip speed, a third of what does not fall with the stiffness: 5e-6
        apart(run_up(**race), run_up(contact(stiffness=k, slip_speed=0.003, **GRIP), **race), lags=lags)
        for k in (1e6, 1e7)
    ]
    assert found[1] == pytest.approx(0.1 * found[0], rel=0.03)
    assert found[1] < 5e-4


def test_rolling_resistance_acts_as_on_guided_balls() -> None:
    race: dict[str, Any] = {"friction": {"rolling_resistance": 2e-3}}
    found = apart(run_up(**race), run_up(contact(stiffness=1e7, slip_speed=0.01, rest_speed=1e-3, **GRIP), **race))
    assert found < 3e-3
    without = apart(run_up(**race), run_up(contact(stiffness=1e7, slip_speed=0.01, **GRIP)))
    assert without > 10.0 * found


def test_both_frames_give_the_same_motion() -> None:
    machine = run_up(contact(stiffness=1e5, slip_speed=0.1, **GRIP), torque=True)
    runs = [ab.simulate(machine, duration=0.3, frame=f, tolerance=1e-9) for f in ("rotor", "space")]
    for name in ("x", "y", "ball_angle_in_rotor", "ball_x", "ball_y", "ball_spin", "speed"):
        size = np.abs(runs[0][name]).max()
        np.testing.assert_allclose(runs[0][name], runs[1][name], rtol=0.0, atol=1e-5 * float(size))


def test_a_result_knows_where_the_ball_is_how_it_spins_and_how_it_is_pressed() -> None:
    machine = run_up(contact(stiffness=1e6, slip_speed=0.01, **GRIP))
    result = ab.simulate(machine, duration=0.6, save=[ab.Samples(201), ab.Envelope(20), ab.LastRevolutions(2)])
    place = (result.ball_x + 1j * result.ball_y) - (result.x + 1j * result.y)
    np.testing.assert_allclose(np.abs(place), ORBIT - result.ball_gap, rtol=1e-12)
    angle = result.ball_angle_in_rotor + result.rotor_angle
    np.testing.assert_allclose(np.angle(place * np.exp(-1j * angle)), 0.0, atol=1e-9)
    late = result.isel(time=slice(100, None))
    rolls = late.speed - (ORBIT - late.ball_gap) / 4e-3 * late.ball_speed_in_rotor
    np.testing.assert_allclose(late.ball_spin, rolls, atol=1e-3 * float(late.speed.max()))
    np.testing.assert_allclose(late.ball_normal_force / -late.ball_gap, 1e6, rtol=5e-2)
    assert np.isfinite(result.envelope_ball_angle_in_rotor).all()
    assert np.isfinite(result.turn_ball_angle_in_rotor).all()


def test_a_ball_that_loops_leaves_the_wall_where_its_weight_wins() -> None:
    """At rest, no friction, v at the lowest point: cos = (2 g eps - v^2)/(3 g eps), counted from the lowest point."""
    for factor in (3.0, 4.5):
        v = math.sqrt(factor * GRAVITY * ORBIT)
        machine = chamber(axis="horizontal", balls={"start_angles": [-0.5 * math.pi]}, stiffness=1e6, restitution=0.2)
        load = 5e-3 * (GRAVITY + v**2 / ORBIT)
        start = {(0, at.BALL_VX): v, (0, at.BALL_Y): -(ORBIT + load / 1e6)}
        _, own, assembly = run(machine, np.linspace(0.0, 0.3, 30001), start)
        pressed = wall_contacts(own, assembly.system)[1][:, 0] > 0.0
        leaves = int(np.argmin(pressed))
        place = own[leaves, 0, at.BALL_X] + 1j * own[leaves, 0, at.BALL_Y]
        assert pressed[:leaves].all()
        assert -place.imag / abs(place) == pytest.approx((2.0 - factor) / 3.0, abs=2e-3)


def test_a_ball_with_enough_speed_loops_without_leaving_the_wall() -> None:
    v = math.sqrt(5.1 * GRAVITY * ORBIT)
    machine = chamber(axis="horizontal", balls={"start_angles": [-0.5 * math.pi]}, restitution=0.2)
    load = 5e-3 * (GRAVITY + v**2 / ORBIT)
    start = {(0, at.BALL_VX): v, (0, at.BALL_Y): -(ORBIT + load / 1e6)}
    _, own, assembly = run(machine, np.linspace(0.0, 1.0, 5001), start)
    force = wall_contacts(own, assembly.system)[1][:, 0]
    assert force.min() == pytest.approx(5e-3 * GRAVITY * 0.1, rel=2e-2)


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_on_a_horizontal_axis_a_carried_ball_rides_round_above_the_square_root_of_g_over_eps(share: float) -> None:
    w = share * math.sqrt(GRAVITY / ORBIT)
    machine = chamber(
        axis="horizontal", speed=w, race={"drag": {"law": "viscous", "damping": 0.02}},
        restitution=0.2, sliding_friction=0.3, slip_speed=0.01, balls={"start_angles": [-0.5 * math.pi]},
    )  # fmt: skip
    load = 5e-3 * (GRAVITY + w**2 * ORBIT)
    _, own, assembly = run(
        machine, np.linspace(0.0, 1.4, 2001), {(0, at.BALL_Y): -(ORBIT + load / 1e6)}, tolerance=1e-8
    )
    force = wall_contacts(own, assembly.system)[1][:, 0]
    if share > 1.0:
        assert force.min() == pytest.approx(5e-3 * GRAVITY * (share**2 - 1.0), rel=0.06)
    else:
        assert force.min() == 0.0
        assert (ORBIT - np.hypot(own[:, 0, at.BALL_X], own[:, 0, at.BALL_Y])).max() > 3e-4


def test_on_a_tilting_rotor_balls_fall_off_the_small_races_at_both_ends_and_not_off_the_large_ones() -> None:
    """On a horizontal axis at a speed between both square roots of g/eps; the rotor sags and tilts."""
    orbits = [0.1, 0.07]
    w, (low, left) = math.sqrt(GRAVITY / 0.085), (-0.5 * math.pi, math.pi)
    races = [
        {
            "orbit_radius": orbit, "drag": {"law": "viscous", "damping": 0.02},
            "resolved": contact(restitution=0.2, sliding_friction=0.3, slip_speed=0.01),
            "balls": [BALL | {"start_angles": [angle]}],
        }
        for orbit, angle in zip(orbits, (low, left), strict=True)
    ]  # fmt: skip
    machine = Machine(
        name="horizontal",
        axis="horizontal",
        rotor=RIGID,
        unbalances=[{"moment": 1e-4, "station": 0.2}],
        balancers=[{"station": -0.12, "races": races}, {"station": 0.2, "races": races}],
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": w}},
    )
    result = ab.simulate(machine, duration=1.4, save=ab.Samples(1401), tolerance=1e-7)
    force, gap = result.ball_normal_force.sel(time=slice(0.05, None)), result.ball_gap.max("time")
    assert result.balancer.values.tolist() == [1, 1, 2, 2]
    rate = result.ball_speed_in_rotor.sel(time=slice(0.05, None)).values
    for ball in (0, 2):  # at the top, with the speed that is left there
        top = int(force.values[:, ball].argmin())
        needed = 5e-3 * ((w + rate[top, ball]) ** 2 * 0.1 - GRAVITY)
        assert float(force[top, ball]) == pytest.approx(needed, rel=0.01)
    assert (force[:, [1, 3]].min("time") == 0.0).all()
    assert (gap[[1, 3]] > 1e-4).all()
    assert (gap[[0, 2]] < 0.0).all()


def test_on_a_vertical_axis_a_ball_lies_on_the_floor_until_the_race_takes_over() -> None:
    """The floor carries it round up to w^2 R = mu g."""
    mu, gap = 0.3, 0.02
    limit = math.sqrt(mu * GRAVITY / (ORBIT - gap))
    machine = chamber(restitution=0.3, sliding_friction=0.2, slip_speed=1e-4, floor_friction=mu, start_gap=gap,
        floor_motion="sliding")  # fmt: skip
    slow = Machine(**{**{k: getattr(machine, k) for k in machine.model_fields_set}, "drive": {
        "kind": "speed", "profile": {"kind": "ramp", "start": 0.0, "end": 1.2 * limit, "duration": 1.2}}})  # fmt: skip
    times = np.array([0.0, 0.9, 0.99, 1.2, 1.6])
    _, own, assembly = run(slow, times, tolerance=1e-8)
    left = ORBIT - np.hypot(own[:, 0, at.BALL_X], own[:, 0, at.BALL_Y])
    assert left[1] == pytest.approx(gap, abs=3e-4)
    assert left[2] > 0.9 * gap
    assert left[4] < 0.0
    w = 1.2 * limit
    assert wall_contacts(own, assembly.system)[1][4, 0] == pytest.approx(5e-3 * w**2 * ORBIT, rel=1e-2)


def test_two_balls_rebound_from_each_other_and_keep_their_order() -> None:
    for restitution in (0.4, 1.0):
        machine = chamber(
            balls={"count": 2, "start_angles": [0.0, 1.0], "start_speeds": [5.0, -5.0]},
            race={"contact": {"restitution": restitution}}, restitution=0.2,
        )  # fmt: skip
        states, _, _ = run(machine, np.linspace(0.0, 0.15, 301), tolerance=1e-9)
        assert (states[:, BALLS + 1] - states[:, BALLS]).min() > 0.099
        np.testing.assert_allclose(states[-1, BALLS + 2 :][:2], [-5.0 * restitution, 5.0 * restitution], rtol=1e-2)


def test_balls_pass_through_each_other_where_coincidence_is_allowed() -> None:
    balls = {"count": 2, "start_angles": [0.0, 1.0], "start_speeds": [5.0, -5.0]}
    states, _, _ = run(chamber(balls=balls, race={"collisions": False}), [0.0, 0.15], tolerance=1e-9)
    assert states[-1, BALLS] > states[-1, BALLS + 1]


def test_the_inner_wall_throws_a_ball_back() -> None:
    machine = chamber(race={"width": 0.02}, start_gap=0.005)
    _, own, _ = run(machine, np.linspace(0.0, 0.05, 2001), {(0, at.BALL_VX): -1.0})
    away = own[:, 0, at.BALL_X]
    assert away.min() == pytest.approx(ORBIT - 0.01, abs=2e-4)  # 20 mm less the diameter
    assert np.abs(own[:, 0, at.BALL_VX]).max() == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"race": {"width": 0.008}}, "does not fit into a chamber of width 8 mm"),
        ({"race": {"width": -0.01}}, "width: given -0.01; must be greater than zero"),
        ({"race": {"width": 0.2}}, "that leaves no inner wall within a radius of 105 mm"),
        ({"race": {"width": 0.02}, "start_gap": 0.015}, "start_gap: given 15 mm; a ball has 10 mm at most"),
        ({"balls": {"diameter": 0.3}}, "larger than an orbit"),
        ({"balls": {"motion": "point"}}, "motion = 'rolling'"),
        ({"restitution": 1.2}, "restitution: given 1.2; must be between 0 and 1"),
        ({"damping": 3.0}, "give either 'restitution' or 'damping'"),
        ({"stiffness": None}, "give either 'stiffness' (linear spring) or 'reduced_modulus' (Hertz)"),
        ({"friction_law": {"kind": "stribeck", "peak": 0.5}}, "resolved.friction_law.peak_speed: missing"),
        (
            {"friction_law": {"kind": "stribeck", "peak": 0.1, "peak_speed": 1.0}, "sliding_friction": 0.2},
            "friction_law.peak: given 0.1; must not be less than the sliding friction, 0.2",
        ),
        ({"friction_law": {"kind": "stribek"}}, "friction_law.kind: given 'stribek'; did you mean 'stribeck'?"),
        ({"slip_speed": 0.0}, "slip_speed: given 0.0; must be greater than zero"),
        ({"race": {"friction": {"rolling_resistance": 0.01}}}, "resolved.rest_speed: missing"),
        ({"race": {"harmonics": [{"order": 60, "amplitude": 1e-3}]}}, "a ball of 5 mm radius cannot follow the outer wall"),
        ({"race": {"harmonics": [{"order": 30, "amplitude": 2e-3}], "width": 0.02}}, "cannot follow the inner wall"),
        ({"race": {"harmonics": [{"order": 2, "amplitude": 0.02}], "width": 0.1}}, "the inner wall would leave the ball center"),
        ({"race": {"partitions": {"count": 80}}}, "4.5 deg between partitions are less than the 5.732 deg of a ball"),
    ],
)  # fmt: skip
def test_an_impossible_contact_is_refused_with_the_reason(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(MachineError) as error:
        assemble(chamber(**changes))
    assert words in str(error.value)


def test_guided_and_resolved_races_do_not_mix() -> None:
    machine = chamber()
    guided = {"orbit_radius": 0.05, "drag": {"law": "viscous", "damping": 0.0}, "balls": [BALL]}
    mixed = [*machine.balancers, {"races": [guided]}]
    with pytest.raises(MachineError, match=r"balancers\[2\].races\[1\].resolved: missing here"):
        assemble(Machine(**{**{k: getattr(machine, k) for k in machine.model_fields_set}, "balancers": mixed}))
