"""What a result says of balls on real races."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.references.races import races
from tests.references.resolved import states_at
from tests.references.standing_races import DENSITY, DIAMETER, GRAVITY, ORBIT, standing

import autobalancer as ab
from autobalancer.assembly.places import places_of
from autobalancer.assembly.system import assemble
from autobalancer.machine import Unbalance
from autobalancer.simulation.record import Samples
from autobalancer.simulation.saved import wall_forces

MASS = DENSITY * math.pi / 6.0 * DIAMETER**3


def test_a_run_says_when_a_ball_rests_and_how_hard_it_is_pressed() -> None:
    machine = standing(angles=[1.0], friction={"rolling_resistance": 0.05, "adherence": 0.1})
    run = ab.simulate(machine, duration=20.0, save=Samples(401), tolerance=1e-10)
    rests, force = run["ball_at_rest"].values[:, 0], run["ball_normal_force"].values[:, 0]
    psi, rate = run["ball_angle_in_rotor"].values[:, 0] + 0.5 * math.pi, run["ball_speed_in_rotor"].values[:, 0]
    np.testing.assert_array_equal(rests, rate == 0.0)
    assert rests[-1]
    assert not rests[1:20].any()
    np.testing.assert_allclose(force, MASS * (GRAVITY * np.cos(psi) + ORBIT * rate**2), rtol=1e-7)
    assert run["ball_normal_force"].attrs["units"] == "N"
    assert "left_race_time" not in run.attrs


def test_normal_forces_follow_the_unbalance_and_the_drive_in_force() -> None:
    machine = standing(axis="vertical", angles=[1.0], beta=1e-3, friction={})
    profile = {"kind": "table", "time": [0.0, 1.0, 2.0], "speed": [0.0, 100.0, 100.0]}
    machine = machine.model_copy(update={"drive": type(machine.drive)(profile=profile)})
    run = ab.simulate(machine, duration=2.0, save=Samples(101), tolerance=1e-11)
    whole = run["ball_speed_in_space"].values[:, 0]
    np.testing.assert_allclose(run["ball_normal_force"].values[:, 0], MASS * ORBIT * whole**2, rtol=1e-6, atol=1e-9)
    reference = races(machine)
    assert reference.numbers[0][0] == pytest.approx(MASS)


def test_a_ball_thrown_over_the_top_too_slowly_would_have_left_its_race() -> None:
    """It leaves where cos psi = -v^2/(g eps); the path is that of the frictionless pendulum until then."""
    speed = 14.0
    run = ab.simulate(standing(angles=[0.0], speeds=[speed], friction={}), duration=0.4, save=Samples(8001))
    psi = run["ball_angle_in_rotor"].values[:, 0] + 0.5 * math.pi
    leaves = math.acos(-(1.4 * ORBIT * speed**2 - 2.0 * GRAVITY) / (GRAVITY * (3.4)))
    when = float(run["time"][np.argmax(psi > leaves)])
    assert run.attrs["left_race_ball"] == 1
    assert run.attrs["left_race_time"] == pytest.approx(when, abs=1.01 * 0.4 / 8000)
    assert "would have left" in " ".join(run.attrs["remarks"])
    # the guided ball swings back, and the race presses it again where it left it
    back = float(run["time"][np.flatnonzero(psi > leaves)[-1]])
    assert run.attrs["left_race_end"] == pytest.approx(back, abs=2.01 * 0.4 / 8000)
    assert f"to {run.attrs['left_race_end']:.5g} s, 1 ball" in " ".join(run.attrs["remarks"])


def test_a_ball_that_is_off_its_race_at_the_end_of_a_run_is_said_so() -> None:
    run = ab.simulate(standing(angles=[0.0], speeds=[14.0], friction={}), duration=0.25, save=Samples(401))
    assert "to the end of the run, 1 ball (first ball 1) would have left the race" in " ".join(run.attrs["remarks"])


def test_plain_and_real_races_press_alike_and_both_say_when_a_ball_would_have_fallen_off() -> None:
    fast = {"kind": "speed", "profile": {"kind": "ramp", "start": 3.0, "end": 40.0, "duration": 2.0}}
    drum = standing(angles=[2.5], beta=2e-3).model_copy(update={"unbalances": (Unbalance(moment=2e-4),)})
    light = {"kind": "planar", "mass": 0.05, "stiffness": 75.0, "damping": 0.5}
    drum = ab.with_parameter(ab.with_parameter(drum, "drive", fast), "rotor", light)
    times = np.linspace(0.0, 2.0, 401)
    rough = ab.with_parameter(drum, "balancers[1].races[1].friction", {"rolling_resistance": 0.0, "adherence": 0.0})
    kept = ab.SampleTimes(times.tolist())
    run = ab.simulate(rough, duration=2.0, save=kept, tolerance=1e-11)
    plain = ab.simulate(drum, duration=2.0, save=kept, tolerance=1e-11)
    assembly = assemble(drum)
    force = wall_forces(states_at(assembly, times, 1e-11), times, assembly, places_of(drum, assembly))
    np.testing.assert_allclose(force, run["ball_normal_force"], rtol=1e-5, atol=1e-5 * MASS * GRAVITY)
    assert force.min() < -0.1 * MASS * GRAVITY
    assert plain.attrs["left_race_time"] == run.attrs["left_race_time"]
    upright = drum.model_copy(update={"axis": "vertical"})  # in axes that turn with the rotor
    run = ab.simulate(rough.model_copy(update={"axis": "vertical"}), duration=2.0, save=kept, tolerance=1e-11)
    assembly = assemble(upright)
    assert assembly.system.rotating
    force = wall_forces(states_at(assembly, times, 1e-11), times, assembly, places_of(upright, assembly))
    np.testing.assert_allclose(force, run["ball_normal_force"], rtol=1e-5, atol=1e-5 * MASS * GRAVITY)


def test_plain_races_say_nothing_of_friction() -> None:
    machine = standing(angles=[0.2], beta=1e-3)
    run = ab.simulate(machine, duration=0.1, save=Samples(5))
    assert "ball_at_rest" not in run
    assert "ball_normal_force" not in run


def test_a_rotor_that_its_drive_does_not_take_past_the_resonance_is_said_to_stay_there() -> None:
    """The dampers of 100 N s/m take the torque c w a^2 there: 3 N m are too little to get past, 50 N m are not."""
    machine = ab.example("stall_and_release")
    machine = ab.with_parameter(machine, "unbalances[1].mass", "100 g")
    for torque, stays in ((3.0, True), (50.0, False)):
        drive = {"kind": "torque", "torque": torque, "damping": torque / 500.0}
        weak = ab.with_parameter(machine, "drive", drive)
        run = ab.simulate(weak, duration=60.0, hold_balls=True)
        assert run.attrs.get("held_at_critical_speed", 0.0) == (250.0 if stays else 0.0)
        assert ("does not take the rotor past the critical speed of 2387 rpm" in repr(ab.verdict(run))) is stays
        speed, whirl = float(run["envelope_speed"][-1]), float(run["envelope_high"][-1])
        assert 100.0 * speed * whirl**2 == pytest.approx(torque * (1.0 - speed / 500.0), rel=1e-6)
        assert (speed < 250.0) is stays
        # balls settle after the run-up, which has not ended where the rotor does not arrive at its speed
        run = ab.simulate(weak, duration=20.0, save=[ab.Envelope(300), ab.LastRevolutions()])
        found, swept = ab.run_measures(run), ab.sweep(weak, {}, seeds=1, duration=20.0)
        judged = ab.verdict(run)
        assert np.isnan([float(found["settling_time"][0]), float(swept["settling_time"][0])]).all() == stays
        assert (
            np.isfinite([float(found["held_at_critical_speed"]), float(swept["held_at_critical_speed"][0])]).all()
            == stays
        )
        assert ("but the run-up has not ended" in repr(judged)) is stays
        assert (judged.held_rotor is not None) is stays
    # a drive whose torque ends at 240 rad/s takes the rotor where it shall go
    drive = {"kind": "torque", "torque": 3.0, "damping": 3.0 / 240.0}
    slow = ab.with_parameter(ab.example("stall_and_release"), "drive", drive)
    run = ab.simulate(slow, duration=60.0, hold_balls=True)
    assert 0.9 * 250.0 < float(run["envelope_speed"][-1]) < 250.0
    assert "held_at_critical_speed" not in run.attrs
