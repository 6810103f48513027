"""Measures of a deep chamber, on runs whose motion is known in closed form."""

from __future__ import annotations

import re

import numpy as np
import pytest
import xarray as xr
from tests.references.chamber_machines import small_machine
from tests.references.chamber_runs import BALL, CHAMBER, chamber_run

import autobalancer as ab
from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import machine_text
from autobalancer.results.chamber_measures import (
    UNITS,
    ball_places_in_rotor,
    ball_settling_time,
    balls_carried,
    balls_unbalance,
    catalog_numbers,
    catalog_unit,
    chamber_measures,
    collision_statistics,
    residual_of_balls,
)
from autobalancer.results.measure_table import CHAMBER_MEASURES
from autobalancer.results.unconstrained_body import LooseBody, pakula_body, unconstrained_motion
from autobalancer.simulation.chamber.bounds import body_without_balancing
from autobalancer.simulation.chamber.chamber_run import default_step
from autobalancer.simulation.chamber.chamber_verdict import chamber_verdict
from autobalancer.studies.compare import chamber_row

RUN = chamber_run()
DESCRIBED = RUN.assign_attrs(machine=machine_text(small_machine(unbalances=[{"moment": 0.008}])))
ANGLES, AXIAL = np.array([2.6, 3.0, 3.4]), np.array([-0.02, 0.0, 0.03])
ARM = CHAMBER - BALL


def test_amplitude_is_half_of_the_range_in_steady_state() -> None:
    found = chamber_measures(RUN)
    assert float(found["vertical_amplitude"]) == pytest.approx(20e-6, rel=1e-3)
    assert float(found["horizontal_amplitude"]) == pytest.approx(10e-6, rel=1e-3)
    assert float(found["rotation_amplitude"]) == pytest.approx(1e-5, rel=1e-3)
    assert float(found["vertical_synchronous"]) == pytest.approx(20e-6, rel=1e-9)
    assert float(chamber_measures(RUN, last=3.5)["vertical_amplitude"]) == pytest.approx(1e-3, rel=0.03)


def test_a_run_whose_speed_still_changes_has_no_numbers_of_a_steady_state() -> None:
    faster = RUN.assign(speed=RUN["speed"] * np.linspace(0.5, 1.0, RUN["time"].size))
    steady = ("vertical_amplitude", "vertical_synchronous", "rotation_amplitude", "residual_unbalance", "vertical_peak")
    for run, known in ((RUN, True), (faster, False)):
        found = ab.run_measures(run, unbalance=0.008)
        assert all(np.isfinite(found[name]) == known for name in steady)
        assert found["vertical_amplitude"].attrs["units"] == "m"
        assert np.isfinite(found["hardest_contact"])
        assert np.isfinite(found["bearing_1_rms"]).values.tolist() == [True, known]
    assert np.isfinite(ab.run_measures(faster, last=1.0)["vertical_amplitude"])


def test_vibration_at_another_frequency_is_not_synchronous() -> None:
    run = RUN.copy()
    run["body_position"] = run["body_position"].copy()
    run["body_position"][:, 2] += 5e-6 * np.sin(0.7 * run["rotor_angle"])
    found = chamber_measures(run, last=2.0)
    assert float(found["vertical_synchronous"]) == pytest.approx(20e-6, rel=5e-3)
    assert float(found["vertical_amplitude"]) == pytest.approx(25e-6, rel=5e-3)


def test_the_peak_of_the_transient_has_its_size_and_time() -> None:
    found = chamber_measures(RUN)
    assert float(found["vertical_peak"]) == pytest.approx(2.01e-3, abs=15e-6)
    assert float(found["vertical_peak_time"]) == pytest.approx(1.0, abs=0.05)


def test_balls_that_turn_with_the_rotor_stand_still_in_it() -> None:
    place = ball_places_in_rotor(RUN).isel(time=slice(2100, None)).values
    expected = np.stack([AXIAL, ARM * np.cos(ANGLES), ARM * np.sin(ANGLES)], axis=1)
    np.testing.assert_allclose(place, np.broadcast_to(expected, place.shape), atol=2e-5 * ARM)


def test_a_ball_has_settled_when_it_is_within_its_radius_of_its_place() -> None:
    # it swings along the circle by 2 (1 - t/2) rad and along the axis: solve for one radius
    early = np.linspace(0.0, 0.2, 200001)
    away = np.sqrt((2.0 * ARM * np.sin(early)) ** 2 + (np.abs(AXIAL)[:, None] * early) ** 2)
    expected = 2.0 * (1.0 - np.array([np.interp(BALL, row, early) for row in away]))
    np.testing.assert_allclose(ball_settling_time(RUN), expected, atol=2e-3)
    tighter = ball_settling_time(RUN, tolerance=0.1).values
    assert np.all(tighter > expected)
    assert np.all(tighter < 2.0)


def test_balls_at_the_bottom_neither_settle_nor_go_around() -> None:
    lazy = chamber_run(carried=False)
    assert np.isnan(ball_settling_time(lazy)).all()
    assert not balls_carried(lazy).any()
    assert balls_carried(RUN).all()
    found = ab.run_measures(lazy, unbalance=0.008)
    assert float(found["share_carried"]) == 0.0
    assert np.isnan([float(found[name]) for name in ("settling_time", "residual_unbalance", "residual_couple")]).all()
    assert np.isnan(residual_of_balls(lazy, 0.008)["static"]).all(), "no curve over time either"


def test_the_balls_balance_what_is_opposite_to_them() -> None:
    own = 0.03 * ARM * np.exp(1j * ANGLES).sum()
    couple = (0.03 * ARM * AXIAL * np.exp(1j * ANGLES)).sum()
    late = RUN.isel(time=slice(2100, None))
    found = balls_unbalance(late)
    expected = np.array([own.real, own.imag])
    np.testing.assert_allclose(found["static"], np.broadcast_to(expected, found["static"].shape), atol=1e-6)
    left = residual_of_balls(late, -own, -couple)
    assert float(left["static"].max()) < 3e-7
    assert float(left["couple"].max()) < 1e-8
    assert float(residual_of_balls(late, own)["static"].mean()) == pytest.approx(2.0 * abs(own), rel=1e-4)
    moved = residual_of_balls(late, -own, -couple, chamber_places=np.array([0.5]))
    assert float(moved["couple"].mean()) == pytest.approx(0.5 * abs(own), rel=1e-3)


def test_reactions_are_told_apart_in_transient_and_steady_state() -> None:
    found = chamber_measures(RUN, last=1.9)
    assert float(found["bearing_1_greatest"].sel(stage="steady")) == pytest.approx(np.hypot(500.0, 100.0), rel=1e-3)
    assert float(found["bearing_1_rms"].sel(stage="steady")) == pytest.approx(np.hypot(500.0, 100.0 / 2**0.5), rel=1e-3)
    assert float(found["bearing_2_rms"].sel(stage="transient")) == pytest.approx(500.0)
    assert float(found["constraint_x_greatest"].sel(stage="steady")) == 0.0
    assert float(found["constraint_x_greatest"].sel(stage="transient")) == pytest.approx(50.0, rel=0.01)
    assert float(found["constraint_moment_z_greatest"].sel(stage="transient")) == pytest.approx(2.0)
    assert float(found["constraint_moment_z_mean"].sel(stage="transient")) == pytest.approx(-2.0 / 2.1, rel=1e-3)


def test_contacts_are_counted_and_the_hardest_is_found() -> None:
    found = collision_statistics(RUN, bins=8)
    assert float(found["contacts_ball"]) == RUN["contacts_ball"].values.sum()
    assert float(found["contacts_wall"]) == 3.0 * float(found["contacts_ball"])
    np.testing.assert_allclose(found["contacts_ball_rate"][:4], 2000.0, rtol=0.01)
    assert float(found["contacts_ball_rate"][5:].max()) == 0.0
    assert float(found["hardest_contact"]) == 110.0
    assert float(found["hardest_contact_time"]) == 0.0


def test_all_measures_go_into_the_catalogue_as_numbers() -> None:
    found = chamber_measures(RUN, unbalance=0.008)
    numbers = catalog_numbers(DESCRIBED)
    assert numbers["vertical_amplitude"] == pytest.approx(20e-6, rel=1e-3)
    assert numbers["steady_bearing_1_greatest"] > 500.0
    assert numbers["residual_unbalance"] == pytest.approx(abs(0.008 + 0.03 * ARM * np.exp(1j * ANGLES).sum()), rel=1e-3)
    assert numbers["energy_error"] == pytest.approx(4e-6 / RUN["work_motor"].values[-1])
    assert all("units" in found[name].attrs and found[name].attrs["long_name"] for name in found.data_vars)


BODY = LooseBody(120.0, 25.0, 20.0, 32500.0, 41.0, height=0.3, depth=0.2, half_width=1.0)


def loaded(force: np.ndarray, moment_y: np.ndarray, moment_z: np.ndarray, step: float) -> xr.Dataset:
    zero = np.zeros_like(force)
    return xr.Dataset(
        {
            "constraint_force": (("time", "axis"), np.stack([force, zero, zero], axis=1)),
            "constraint_moment": (("time", "axis"), np.stack([zero, moment_y, moment_z], axis=1)),
        },
        coords={"time": step * np.arange(force.size)},
    )


def test_a_released_body_under_constant_loads_goes_to_its_static_deflection() -> None:
    ones = np.ones(40001)
    found = unconstrained_motion(loaded(100.0 * ones, 7.0 * ones, -3.0 * ones, 1e-3), BODY).isel(time=-1)
    assert float(found["x"]) == pytest.approx(100.0 / 65000.0, rel=1e-4)
    assert float(found["rotation_y"]) == pytest.approx(7.0 / (32500.0 * (4 * 0.09 + 4 * 0.04)), rel=1e-4)
    assert float(found["rotation_z"]) == pytest.approx(-3.0 / (32500.0 * (4 * 1.0 + 2 * 0.04)), rel=1e-4)


def test_a_blow_sets_a_released_body_swinging_with_its_impulse() -> None:
    force = np.zeros(2001)
    force[1] = 1000.0  # the mean from 0 to 1 ms: impulse 1 N s
    free = LooseBody(**{**vars(BODY), "damping": 0.0})
    found = unconstrained_motion(loaded(force, 0.0 * force, 0.0 * force, 1e-3), free)
    rate = np.sqrt(65000.0 / 120.0)
    time = found["time"].values[1:]
    expected = 1000.0 / 65000.0 * (np.cos(rate * (time - 1e-3)) - np.cos(rate * time))
    np.testing.assert_allclose(found["x"].values[1:], expected, atol=1e-12)
    assert float(found["x"].max()) == pytest.approx(1.0 / (120.0 * rate), rel=1e-3)


def test_the_motion_does_not_depend_on_how_finely_a_held_load_is_sampled() -> None:
    coarse = np.array([0.0, 50.0, -20.0, 30.0, 0.0, 10.0])
    fine = np.concatenate([[0.0], np.repeat(coarse[1:], 100)])
    one = unconstrained_motion(loaded(coarse, coarse, coarse, 0.1), BODY)
    two = unconstrained_motion(loaded(fine, fine, fine, 1e-3), BODY).isel(time=slice(None, None, 100))
    for name in ("x", "rotation_y", "rotation_z"):
        np.testing.assert_allclose(one[name].values, two[name].values, rtol=1e-9)


def test_reactions_of_the_steady_state_can_be_left_out() -> None:
    found = unconstrained_motion(RUN, pakula_body(0.3), until=1.0)
    assert float(np.abs(found["x_load"].sel(time=slice(1.0005, None))).max()) == 0.0
    assert float(np.abs(found["x_load"].sel(time=slice(0.0, 1.0))).max()) > 10.0


def test_what_cannot_be_measured_is_refused() -> None:
    with pytest.raises(QuestionError, match="last: given 9 s; must be above zero and within the 4 s"):
        chamber_measures(RUN, last=9.0)
    with pytest.raises(QuestionError, match="fewer than two samples"):
        chamber_measures(RUN, last=1e-5)
    with pytest.raises(QuestionError, match="has 1 samples"):
        chamber_measures(RUN.isel(time=slice(0, 1)))
    with pytest.raises(QuestionError, match="fewer than four per revolution"):
        balls_carried(RUN.isel(time=slice(None, None, 15)))
    with pytest.raises(QuestionError, match="tolerance: given 0 ball radii"):
        ball_settling_time(RUN, tolerance=0.0)
    with pytest.raises(QuestionError, match="mass: given -1"):
        unconstrained_motion(RUN, LooseBody(**{**vars(BODY), "mass": -1.0}))
    with pytest.raises(QuestionError, match="not at equal times"):
        unconstrained_motion(RUN.isel(time=[0, 1, 3]), BODY)


def test_the_verdict_compares_with_the_unbalance_of_the_body_without_balancing() -> None:
    stiffness, damping, speed = (3e4, 6e4), (40.0, 80.0), 157.0
    support = {"position": [0, 0, 0], "stiffness": [0, *stiffness], "damping": [0, *damping]}
    machine = small_machine(supports=[support])
    told = {"machine": machine_text(machine), "outcome": "finished"}
    # 121 kg with the balls, and nothing couples y, z and the rotation
    y, z = (0.06 * speed**2 / (k - 121.0 * speed**2 + 1j * c * speed) for k, c in zip(stiffness, damping, strict=True))
    without = 0.5 * (abs(y - 1j * 1j * z) + abs(y + 1j * 1j * z))  # z follows y by a quarter of a turn
    # the run circles with 10 um horizontally and 20 um vertically about 100 um below
    small = chamber_verdict(chamber_run().assign_attrs(told))
    assert small.places[0].without_balls == pytest.approx(without, rel=1e-9)
    assert small.places[0].vibration == pytest.approx(20e-6, rel=1e-2)
    assert small.places[0].static == pytest.approx(100e-6, rel=1e-2)
    assert small.word == "balanced"
    assert chamber_verdict(chamber_run(amplitude=0.5 * without).assign_attrs(told)).word == "partly balanced"
    assert chamber_verdict(chamber_run(amplitude=2.0 * without).assign_attrs(told)).word == "worse than without balls"
    moving = chamber_verdict(chamber_run(settled=4.0, peak=without).assign_attrs(told | {"outcome": "interrupted"}))
    assert moving.because.startswith("the run did not finish")
    with pytest.raises(QuestionError, match="of which machine"):
        chamber_verdict(RUN)


def test_a_free_vibration_is_not_taken_for_what_balls_leave_that_do_not_turn_with_the_rotor() -> None:
    """The body alone, m z'' + c z' + k z = 0, decays with c/2m; what turns with the rotor is as without balls."""
    stiffness, damping, mass = 3e4, 40.0, 121.0
    support = {"position": [0, 0, 0], "stiffness": [0, stiffness, 2 * stiffness], "damping": [0, damping, 2 * damping]}
    told = {"machine": machine_text(small_machine(supports=[support])), "outcome": "finished"}
    without = chamber_verdict(RUN.assign_attrs(told)).places[0].without_balls
    # of balls that turn with the rotor a small one does not count either
    calm = chamber_run(amplitude=0.095 * without, peak=0.0).assign_attrs(told)
    time = calm["time"].values
    calm["body_position"][:, 2] += 0.05 * without * np.exp(-damping / mass * time) * np.cos(22.27 * time)
    judged = chamber_verdict(calm)
    assert judged.places[0].vibration > 0.1 * without
    assert (judged.word, judged.ratio) == ("balanced", pytest.approx(0.095, rel=0.01))
    lazy = chamber_run(carried=False, amplitude=without, peak=0.0).assign_attrs(told)
    rate, time = damping / (2.0 * mass), lazy["time"].values
    words = {}
    for size in (5.0 * without, 0.05 * without):
        free = lazy.copy(deep=True)
        free["body_position"][:, 1] += size * np.exp(-rate * time) * np.cos(np.sqrt(stiffness / mass - rate**2) * time)
        words[size] = chamber_verdict(free)
    moving, still = words.values()
    assert (moving.word, still.word) == ("not settled yet", "not balanced")
    assert still.ratio == pytest.approx(1.0, abs=0.06)
    assert moving.ratio > 1.5, "what the sensors read, and no word on balls"
    begin = 0.9 * time[-1]  # of the steady state; a longer run has less than a tenth of that without balls there
    needed = (begin + np.log(50.0 * np.exp(-rate * begin)) / rate) / 0.9
    first = repr(moving).splitlines()[0]
    said = re.search(r"run for about (\S+) s \(run.duration\)", first)
    assert said is not None, first
    assert float(said[1]) == pytest.approx(needed, rel=0.05)
    share = re.search(r"turn with the rotor, (\S+) % of that without balls; run for", first)
    assert share is not None, first
    assert float(share[1]) == pytest.approx(100.0, abs=2.0)


def test_a_motor_that_does_not_take_a_chamber_past_its_critical_speed_is_said_to_hold_it_there() -> None:
    told = {"machine": machine_text(small_machine()), "outcome": "finished", "critical_speeds": [15.42, 23.18]}
    run = chamber_run().assign_attrs(told)
    held, passed = (chamber_verdict(run.assign(speed=run["speed"] * 0.0 + speed)) for speed in (22.0, 157.0))
    assert "the drive does not take the rotor past the second critical speed of 221 rpm (it stays at 210 rpm)" in repr(
        held
    )
    assert "but the run-up has not ended" in repr(held)
    assert passed.held_rotor is None


def test_the_verdict_on_deep_chambers_counts_settling_from_the_end_of_the_run_up_as_that_of_races_does() -> None:
    run = chamber_run().assign_attrs({"machine": machine_text(small_machine()), "outcome": "finished"})
    at = float(ball_settling_time(run).max())
    constant = chamber_verdict(run).settling
    assert constant is not None
    assert (constant.duration, constant.counted_from, constant.settled_at) == (
        pytest.approx(at),
        "start",
        pytest.approx(at),
    )
    for end in (0.5 * at, 1.5 * at):
        ramp = np.minimum(run["time"] / end, 1.0)
        after = chamber_verdict(run.assign(speed=run["speed"] * (0.5 + 0.5 * ramp))).settling
        assert after is not None
        assert after.duration == pytest.approx(max(at - end, 0.0), abs=0.01)
        assert after.counted_from == "end of the run-up"
        driven = run.assign(speed=run["speed"] * (0.5 + 0.5 * ramp))
        measured = ab.run_measures(driven)
        assert str(measured["counted_from"].values) == after.counted_from
        for told in (
            float(measured["settling_time"]),
            chamber_row(small_machine(), driven, None, 10)[0]["settling_time"],
        ):
            assert told == pytest.approx(after.duration, abs=1e-9)


def test_the_static_deflection_does_not_depend_on_where_in_a_turn_the_steady_state_begins() -> None:
    # the run circles about a place 100 um below, with 20 um vertically; 0.42 s are ten turns and a half, of which the plain
    # mean keeps up to 20 um/(pi 10.5) = 0.6 um
    told = {"machine": machine_text(small_machine()), "outcome": "finished"}
    for last in (0.4, 0.41, 0.42, 0.43):
        found = chamber_verdict(chamber_run().assign_attrs(told), last)
        assert found.places[0].static == pytest.approx(100e-6, abs=0.02e-6)
        assert found.supports[0].static == pytest.approx(500.0, abs=0.1)  # 100 N turn with the rotor


def test_the_verdict_on_a_run_under_way_says_how_far_it_got_and_no_number_of_a_steady_state() -> None:
    told = {"machine": machine_text(small_machine()), "outcome": "finished"}
    run = chamber_run().assign_attrs(told)
    faster = run.assign(speed=run["speed"] * np.linspace(0.5, 1.0, run["time"].size))
    found = chamber_verdict(faster)
    assert found.word == "no verdict"
    assert "the speed still changes" in found.because
    assert found.places == found.supports == ()
    assert np.isnan([found.residual, found.grade_after, found.ratio]).all()
    shown = str(found)
    assert not any(word in shown for word in ("residual", "vibration ", "static", "support", "ISO"))
    assert found.peak is not None
    assert found.peak.deflection == pytest.approx(2e-3 - 1e-4, rel=0.03)  # from the rest position without balls
    assert chamber_verdict(faster, last=1.0).places


def test_a_measure_has_its_unit_and_meaning_from_the_table_in_runs_archives_and_studies() -> None:
    found, numbers = chamber_measures(RUN, unbalance=0.008), catalog_numbers(DESCRIBED)
    of_balls = [measure for measure in CHAMBER_MEASURES if measure.needs != "cylinders"]
    assert list(found.data_vars) == [measure.name for measure in of_balls]
    for measure in of_balls:
        assert found[measure.name].attrs == {"units": measure.unit, "long_name": measure.text}
    assert {name for name in UNITS if "tilting" not in name} == set(numbers)
    assert [catalog_unit(name) for name in ("steady_bearing_1_rms", "vertical_peak", "step")] == ["N", "m", "s"]
    assert "residual_unbalance" not in chamber_measures(RUN), "the unbalance of this rotor is not known"
    assert "vertical amplitude in steady state" in repr(found)


def test_a_run_with_held_balls_ends_in_the_steady_vibration_of_the_body_and_takes_longer_steps() -> None:
    feet = [[0.3, 0.4], [0.3, -0.4], [-0.3, 0.4], [-0.3, -0.4]]
    damped = [{"position": [*foot, -0.15], "stiffness": [8125.0] * 3, "damping": [800.0] * 3} for foot in feet]
    drive = {"kind": "speed", "profile": {"kind": "constant", "speed": 30.0}}
    aside = [
        {"radius": 0.1, "depth": 0.1, "position": 0.4, "balls": [{"count": 3, "density": 7800.0, "total_mass": 5.0}]}
    ]
    body = {"freedom": "free", "mass": 20.0, "inertia": [2.0, 2.0, 2.0]}
    changed = {"gravity": [0.0, 0.0, 0.0], "unbalances": [{"moment": 1e-5}]}  # so small that its motion is linear
    machine = small_machine(supports=damped, drive=drive, chambers=aside, body=body, **changed)
    run = ab.simulate(machine, duration=4.0, hold_balls=True)
    late = run.isel(time=slice(-300, None))
    y, z = late["body_position"].values[:, 1], late["body_position"].values[:, 2]
    assert np.hypot(y, z).max() == pytest.approx(body_without_balancing(machine, 30.0), rel=1e-4)
    assert run.sizes["ball"] == 0
    assert run.attrs["step"] > 5.0 * default_step(machine)
    assert chamber_verdict(run).because == "the machine has no balls"


def test_a_passage_that_balls_make_worse_stands_in_the_first_line_of_a_chamber_too() -> None:
    told = {"machine": machine_text(small_machine())}
    run, held = (chamber_run(peak=peak).assign_attrs(told) for peak in (2e-3, 1e-3))
    assert "the greatest deflection on the way is" in repr(chamber_verdict(run, held=held)).splitlines()[0]
    assert "on the way" not in repr(chamber_verdict(held, held=run)).splitlines()[0]
    alone = chamber_verdict(run)
    assert alone.without_held
    assert alone.peak_without_balls is None
