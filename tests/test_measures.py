"""Measures read off runs."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.references.stalled_pair import run_up

import autobalancer as ab
import autobalancer.machine as machines
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import AutobalancerError, QuestionError, ResultError
from autobalancer.results.measure_table import (
    MEASURES,
    SWEPT,
    Measure,
    ball_angle_to_unbalance,
    break_away_speed,
    deflection_envelope,
    measured,
    peak_deflection,
    residual_vibration,
    settling_time,
)
from autobalancer.results.measure_table import swept as swept_of
from autobalancer.results.run_arrays import Balls, recorded_of, settling
from autobalancer.results.time_series import (
    residual_unbalance,
    static_deflection,
    support_forces,
    vibration,
    whole_turns,
)
from autobalancer.results.verdict import headline

MACHINES = Path(__file__).parents[1] / "examples" / "machines"


@pytest.fixture(scope="module")
def stalled_run() -> xr.Dataset:
    return ab.simulate(MACHINES / "stall_and_release.toml", save=(ab.Samples(20_001), ab.Envelope(2000)))


def test_stalled_balls_hang_below_the_critical_speed_and_break_away_near_the_formula(stalled_run: xr.Dataset) -> None:
    released = ab.run_measures(stalled_run, "break_away_speed").values
    formula = 250.0 * (1.0 + 2.0 * (2.5e-4 * 250.0) ** 2 / (100.0 * 1.4685e-4))
    # no earlier than the torque balance is lost, and later by the time that drag takes to speed up a ball, I / beta = 0.24 s
    later = 500.0 / 15.0 * 1.4 * 2.5e-4 * 0.1 / 1.4685e-4
    assert ((released > formula) & (released < formula + 2.0 * later)).all()


def test_in_a_quick_run_up_balls_break_away_where_they_begin_to_follow_the_rotor_for_good() -> None:
    ramp = {"kind": "ramp", "end": 500.0, "duration": 4.0}
    quick = ab.with_parameter(ab.load_machine(MACHINES / "stall_and_release.toml"), "drive.profile", ramp)
    run = ab.simulate(quick, duration=6.0, save=[ab.Samples(20_001), ab.Envelope(1000)])
    speed, slip = run["speed"].values, -run["ball_speed_in_rotor"].values.T
    for released, behind in zip(ab.run_measures(run, "break_away_speed").values, slip, strict=True):
        at, own = int(np.argmax(speed >= released)), speed - behind
        # it never falls so far behind again, and was never so fast in its stall
        assert behind[at:].max() == behind[at]
        assert behind[-1] < 1e-3 * speed[-1]
        assert own[(speed > 255.0) & (speed < released)].max() < own[at]
        # its last swing through the critical speed is earlier: there it still hangs
        swing = speed[np.flatnonzero((speed > 255.0) & (own < 250.0))[-1]]
        assert swing < 0.95 * released
        assert own[speed < 0.5 * (swing + released)][-1] < 1.05 * 250.0
    rough = run.drop_vars([name for name, values in run.variables.items() if "time" in values.dims])
    np.testing.assert_allclose(
        ab.run_measures(rough, "break_away_speed"), ab.run_measures(run, "break_away_speed"), rtol=1e-3
    )


def test_balls_behind_at_the_second_critical_speed_are_stalled_in_all_answers() -> None:
    """A rigid rotor whose tilting mode has the whirl f^2 - f w J_p/J_t = 2 k a^2/J_t , above w_c at w."""
    supports = tuple(machines.Support(position=z, stiffness=30e3, damping=30.0) for z in (-0.12, 0.12))
    balls = [{"count": 2, "mass": 0.005, "motion": "point"}]
    race = machines.Race(orbit_radius=0.05, collisions=False, drag={"law": "viscous", "damping": 1e-4}, balls=balls)
    machine = machines.Machine(
        name="tilting",
        axis="vertical",
        rotor=machines.RigidRotor(mass=5.0, transverse_inertia=0.03, polar_inertia=0.015, supports=supports),
        balancers=[machines.Balancer(station=z, races=[race]) for z in (-0.1, 0.1)],
        unbalances=[machines.Unbalance(mass=0.004, radius=0.05, station=0.1)],
        drive={"kind": "speed", "profile": {"kind": "ramp", "end": 400.0, "duration": 5.0}},
    )
    run = ab.simulate(machine, duration=8.0)
    inertia = 0.03 + 4 * 0.005 * 0.1**2  # with the balls, which are points of the tilting mode
    share = 0.5 * 0.015 / inertia * 400.0
    whirl = share + np.sqrt(share**2 + 2.0 * 30e3 * 0.12**2 / inertia)
    judged = ab.verdict(run)
    assert judged.stall is not None
    assert judged.stall.balls == (1, 2, 3, 4)
    second = run.attrs["critical_speeds"][1]
    assert all(0.85 * whirl < speed < whirl for speed in judged.stall.speeds)
    assert min(judged.stall.speeds) > second > 200.0
    assert judged.stall.modes == (2, 2, 2, 2)
    assert judged.stall.critical_speeds == (second,) * 4
    assert judged.stall.whirls == pytest.approx([whirl] * 4, rel=1e-6)
    assert "4 of 4 balls stalled at the second critical speed of " in headline(judged)
    measures = ab.run_measures(run)
    assert float(measures["stalled_balls"]) == 4.0
    row = next(line for line in str(measures).splitlines() if line.startswith("stalled_balls"))
    assert row.split()[1] == "4"  # a count, no share
    assert "%" not in row
    swept = ab.sweep(machine, {}, seeds=1, duration=8.0)
    assert swept["stalled_balls"].values.tolist() == [4.0]
    compared = ab.compare([machine], duration=8.0)
    assert compared["stalled_balls"].values.tolist() == [4.0]
    assert "4 balls stalled" in str(compared)
    assert "seed 0" in str(compared)


def test_the_peak_of_the_run_up_is_where_the_balls_break_away(stalled_run: xr.Dataset) -> None:
    peak = ab.run_measures(stalled_run, "peak_deflection")
    # a pair that cannot part goes on until its orbit ends; the phase of the beat then still counts 3e-4
    deflection, speed = run_up(360.0, 400.0, 500.0 / 15.0)
    assert float(peak["deflection"]) == pytest.approx(deflection, rel=5e-4)
    assert 383.0 < float(peak["speed"]) < speed


def test_balls_end_opposite_to_the_unbalance_and_the_rotor_is_at_rest(stalled_run: xr.Dataset) -> None:
    final = ab.run_measures(stalled_run, "ball_angle_to_unbalance").isel(time=-1)
    # both are needed whole: they close in on each other ever more slowly until they touch at 0.042 rad
    assert np.all(np.pi - np.abs(final) > 0.042)
    np.testing.assert_allclose(np.abs(final), np.pi, atol=0.08)
    assert ab.run_measures(stalled_run, "residual_vibration", last=0.5) < 1e-6


def test_envelope_and_samples_tell_the_same_peak(stalled_run: xr.Dataset) -> None:
    from_samples = stalled_run.drop_vars([name for name in stalled_run if str(name).startswith("envelope")])
    exact = float(ab.run_measures(stalled_run, "peak_deflection")["deflection"])
    sampled = float(ab.run_measures(from_samples, "peak_deflection")["deflection"])
    assert sampled <= exact
    assert sampled == pytest.approx(exact, rel=1e-3)


def test_the_residual_is_the_sum_of_unbalance_and_balls(stalled_run: xr.Dataset) -> None:
    angle = stalled_run["ball_angle_in_rotor"].values[100]
    expected = abs(5e-4 + (2.5e-4 * np.exp(1j * angle)).sum())
    assert float(stalled_run["residual_unbalance"][100]) == pytest.approx(expected, rel=1e-9)


def test_a_ball_settles_when_it_stays_near_its_last_angle() -> None:
    run = ab.simulate(MACHINES / "eccentric_race.toml", duration=5.0)
    time, angle = run["time"].values, run["ball_angle_in_rotor"].values
    for ball, settled in enumerate(ab.run_measures(run, "settling_time")["settled_at"].values):
        away = np.abs(angle[:, ball] - angle[-1, ball]) > np.deg2rad(2.0)
        assert not away[time >= settled].any()
        assert away[time < settled][-1]
        k = np.flatnonzero(away)[-1]  # between two samples, 2.5 ms apart
        distance = np.abs(angle[k : k + 2, ball] - angle[-1, ball])
        assert settled == pytest.approx(np.interp(-np.deg2rad(2.0), -distance, time[k : k + 2]), abs=1e-5)


def test_all_balls_settle_from_one_moment_and_those_that_settle_earlier_are_never_slower(
    stalled_run: xr.Dataset,
) -> None:
    found = ab.run_measures(stalled_run, "settling_time")  # both balls are released during the run-up
    assert str(found["counted_from"].values) == "end of the run-up"
    speed = stalled_run["speed"].values
    end = np.interp(0.999 * speed[-1], speed, stalled_run["time"])
    np.testing.assert_allclose(found, found["settled_at"] - end, atol=1e-4)
    free = ab.run_measures(stalled_run, "settling_time", settling_from="release")
    assert str(free["counted_from"].values) == "release"
    last = float(ab.run_measures(stalled_run)["break_away_time"].max())
    np.testing.assert_allclose(free, found["settled_at"] - last, atol=1e-12)
    with pytest.raises(QuestionError, match=r"settling_from: given 'ramp'; must be 'run-up' or 'release'"):
        ab.run_measures(stalled_run, settling_from="ramp")
    # the same run with a ramp that goes on while the balls are in their places
    slow = stalled_run.assign(speed=stalled_run["speed"].where(stalled_run["time"] < 19.0, 501.0))
    before = ab.run_measures(slow, "settling_time")
    np.testing.assert_array_equal(before, 0.0)
    np.testing.assert_array_equal(before["settled_at"], found["settled_at"])
    at_speed = {"kind": "speed", "profile": {"kind": "constant", "speed": 500.0}}
    machine = ab.with_parameter(ab.load_machine(MACHINES / "stall_and_release.toml"), "drive", at_speed)
    started = ab.run_measures(ab.simulate(machine, duration=5.0), "settling_time")
    assert str(started["counted_from"].values) == "start"
    np.testing.assert_array_equal(started, started["settled_at"])


def test_balls_that_gravity_swings_once_a_revolution_have_settled() -> None:
    machine = ab.load_machine(MACHINES / "stall_and_release.toml")
    machine = machine.model_copy(update={"axis": "horizontal", "gravity": 80.0})
    at_speed = {"kind": "speed", "profile": {"kind": "constant", "speed": 400.0}}
    run = ab.simulate(ab.with_parameter(machine, "drive", at_speed), duration=12.0)
    last = run["ball_speed_in_rotor"].values[-1]
    assert np.abs(last).max() > 1e-3 * 400.0  # faster than a ball that rests, at this moment
    assert np.isfinite(ab.run_measures(run, "settling_time")).all()
    # the residual is what turns with the rotor: by it the rotor vibrates once a revolution, not by what swings
    residual = float(ab.run_measures(run, "residual_unbalance")["residual"][0])
    assert residual < 0.7 * run["residual_unbalance"].values[-200:].mean()
    last = run.isel(turn=whole_turns(run))
    synchronous = (
        (last["turn_place_x"] + 1j * last["turn_place_y"])[:, 0] * np.exp(-1j * last["turn_rotor_angle"])
    ).mean()
    rotor = machine.rotor
    mass = rotor.mass + sum(ball.mass for ball in resolve(machine))
    dynamic = abs(rotor.stiffness - mass * 400.0**2 + 400.0j * rotor.damping)
    assert abs(complex(synchronous)) == pytest.approx(residual * 400.0**2 / dynamic, rel=1e-4)


def test_a_ball_that_still_moves_has_not_settled() -> None:
    run = ab.simulate(MACHINES / "stall_and_release.toml", duration=10.0)  # stalled at the end
    assert np.isnan(ab.run_measures(run, "settling_time")).all()
    assert np.isnan(ab.run_measures(run, "break_away_speed")).all()


def creeping_balls(rest: float, amplitude: float, rate: float, end: float = 20.0) -> Balls:
    """Two balls on a rotor of constant speed that go to ``rest`` (rad) as an exponential does."""
    time = np.linspace(0.0, end, 2001)
    angle = rest + amplitude * np.exp(-rate * time)[:, None] * np.array([1.0, -1.0])
    return Balls(0.0, time, np.full(time.size, 500.0), angle, -rate * (angle - rest))


@pytest.mark.parametrize("rate", [0.01, 0.1, 0.15, 0.3, 3.0])
def test_a_ball_has_settled_where_its_way_to_come_is_no_longer_than_the_tolerance(rate: float) -> None:
    """However slowly it goes: against the place to which the exponential leads, not against the last one."""
    found = settling(creeping_balls(1.0, 0.5, rate), 250.0, ()).duration
    exact = np.log(0.5 / np.deg2rad(2.0)) / rate  # there it comes within the tolerance
    if 20.0 - exact >= 0.05 * 20.0:
        np.testing.assert_allclose(found, exact, atol=1e-3)
    else:
        assert np.isnan(found).all()


def test_a_result_file_gives_back_the_run_and_says_where_it_came_from(stalled_run: xr.Dataset, tmp_path: Path) -> None:
    path = ab.save_run(stalled_run, tmp_path / "deep" / "run.nc")
    again = ab.load_run(path)
    xr.testing.assert_identical(again.drop_attrs(), stalled_run.drop_attrs())
    assert again.attrs["critical_speeds"] == stalled_run.attrs["critical_speeds"]
    assert again["speed"].attrs["units"] == "rad/s"
    from autobalancer.files.machine_file import parse_machine

    assert parse_machine(again.attrs["machine"]) == ab.load_machine(MACHINES / "stall_and_release.toml")


def test_files_that_are_no_results_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ResultError, match="no such file"):
        ab.load_run(tmp_path / "none.nc")
    (tmp_path / "text.nc").write_text("hello")
    with pytest.raises(ResultError, match="not a readable result file"):
        ab.load_run(tmp_path / "text.nc")
    xr.Dataset({"a": 1}).to_netcdf(tmp_path / "foreign.nc")
    with pytest.raises(ResultError, match="was not written by autobalancer"):
        ab.load_run(tmp_path / "foreign.nc")


def test_a_run_that_kept_nothing_cannot_be_measured() -> None:
    run = ab.simulate(MACHINES / "discoidal.toml", duration=1.0, save=())
    with pytest.raises(QuestionError, match="kept neither samples"):
        ab.run_measures(run, "peak_deflection")


def test_a_sweep_gives_what_single_runs_give_on_any_number_of_threads() -> None:
    machine = ab.load_machine(MACHINES / "eccentric_race.toml")
    variations = {"balancers[1].races[1].drag.damping": [5e-4, "1e-3 N*m*s"], "rotor.damping": [80.0, 120.0, 160.0]}
    one = ab.sweep(machine, variations, duration=4.0, workers=1)
    two = ab.sweep(machine, variations, duration=4.0, workers=2)
    xr.testing.assert_identical(one.drop_attrs(), two.drop_attrs())
    texts = {"unbalances[1].mass": ["4 g", "5 g"], "rotor.stiffness": ["600 kN/m", "700 kN/m"]}
    axes = ab.sweep(MACHINES / "eccentric_race.toml", texts, grid=False, duration=0.1)
    np.testing.assert_allclose(axes["unbalances_1_mass"], [4e-3, 5e-3])
    assert [axes[name].attrs["units"] for name in ("unbalances_1_mass", "rotor_stiffness")] == ["kg", "N/m"]
    assert ab.sweep(machine, {"axis": ["vertical", "horizontal"]}, duration=0.1)["axis"].attrs["units"] == ""
    single = ab.with_parameter(machine, "rotor.damping", 120.0)
    run = ab.simulate(single, duration=4.0, save=ab.Envelope(500), tolerance=1e-7)
    cell = one.isel(rotor_damping=1).sel(balancers_1_races_1_drag_damping=1e-3)
    assert float(cell["peak_deflection"]) == pytest.approx(
        float(ab.run_measures(run, "peak_deflection")["deflection"]), rel=1e-12
    )
    np.testing.assert_allclose(
        np.abs(cell["ball_angle_to_unbalance"]), np.abs(np.angle(np.exp(1j * run["envelope_ball_angle_in_rotor"][-1])))
    )


def of_all(found: xr.Dataset, name: str) -> float:
    """What a sweep keeps of a measure along places or supports: the greatest."""
    return float(found[name].max())


@pytest.mark.parametrize(("file", "duration"), [("stall_and_release", 20.0), ("two_plane_rotor", 8.0)])
def test_a_sweep_and_the_measures_of_a_run_with_the_same_data_are_the_same_numbers(file: str, duration: float) -> None:
    machine = ab.load_machine(MACHINES / f"{file}.toml")
    swept = ab.sweep(machine, {}, seeds=1, duration=duration).isel(seed=0)
    saved = [ab.Envelope(500), ab.LastRevolutions()]
    run = ab.simulate(machine, duration=duration, save=saved, tolerance=1e-7)
    found = ab.run_measures(run)
    for name in ("peak_deflection", "peak_speed", "time_near_peak", "residual_vibration"):
        assert float(swept[name]) == pytest.approx(float(found[name]), rel=1e-9)
    for name in ("vibration", "velocity_rms", "static_deflection", "vibration_without_balls"):
        assert float(swept[name]) == pytest.approx(of_all(found, name), rel=1e-9)
    assert float(swept["support_force"]) == pytest.approx(of_all(found, "vibrating_force"), rel=1e-9)
    assert swept["peak_deflection"].attrs == found["peak_deflection"].attrs, "both name the station"
    assert f"peak: greatest deflection at {run.attrs['reference_station']!r}" in swept.remarks()
    assert float(swept["residual_unbalance"]) == pytest.approx(float(found["residual_unbalance"].sum()), rel=1e-9)
    for name in ("settling_time", "settled_at"):  # nan if one has not settled
        assert float(swept[name]) == pytest.approx(float(found[name].max(skipna=False)), rel=1e-9, nan_ok=True)
    assert float(swept["break_away_speed"]) == pytest.approx(of_all(found, "break_away_speed"), rel=1e-9, nan_ok=True)

    # with samples the balls are seen more often than once in a bin; nothing else changes
    run = ab.simulate(machine, duration=duration, save=[ab.Samples(), *saved], tolerance=1e-7)
    fine = ab.run_measures(run)
    np.testing.assert_allclose(swept["ball_angle_to_unbalance"], fine["final_ball_angle_to_unbalance"], rtol=1e-9)
    of_balls = ["settling_time", "settled_at", "break_away_speed", "final_ball_angle_to_unbalance", "counted_from"]
    of_balls += ["break_away_time", "stalled_time", "greatest_ball_speed", "peak_force"]
    kept, again = (each.drop_vars(of_balls, errors="ignore") for each in (found, fine))
    xr.testing.assert_allclose(kept, again, rtol=1e-9)
    late = float(swept["settled_at"]) - float(fine["settled_at"].max(skipna=False))
    assert late == pytest.approx(0.0, abs=0.1 * duration / 500)  # interpolated within a bin
    change = float(np.abs(np.diff(run["envelope_speed"])).max())
    assert float(swept["break_away_speed"]) == pytest.approx(of_all(fine, "break_away_speed"), abs=change, nan_ok=True)


def test_the_balls_of_an_envelope_are_those_at_the_end_of_each_bin(stalled_run: xr.Dataset) -> None:
    at = stalled_run["envelope_end"].values
    speed = np.interp(at, stalled_run["time"], stalled_run["speed"])
    np.testing.assert_allclose(stalled_run["envelope_speed"], speed, rtol=1e-9)
    samples = [name for name, values in stalled_run.variables.items() if "time" in values.dims]
    rough = ab.run_measures(stalled_run.drop_vars(samples), "settling_time")
    fine = ab.run_measures(stalled_run, "settling_time")
    np.testing.assert_allclose(
        rough["settled_at"], fine["settled_at"], atol=0.05 * 0.01
    )  # interpolated in bins of 10 ms


def test_every_measure_of_a_run_stands_once_in_the_table_and_carries_its_unit(stalled_run: xr.Dataset) -> None:
    table = {measure.name: measure for measure in MEASURES}
    assert len(table) == len(MEASURES)
    found = ab.run_measures(stalled_run)
    assert {str(name) for name in found} <= set(table)
    for name in found:
        assert found[name].attrs["units"] == table[str(name)].unit
        assert found[name].dims == ((table[str(name)].along,) if table[str(name)].along else ())
    lowest = Measure("lowest_deflection", "m", "", "least deflection", lambda r: r.bins.low.min())
    labels = measured(recorded_of(stalled_run), (*MEASURES, lowest), lambda measure: {"units": measure.unit})
    assert list(labels)[-1] == "lowest_deflection", "an entry of the table is all that a measure of a run needs"
    assert swept_of((*MEASURES, lowest)) == SWEPT, "no sweep dies of a measure that it does not compute"
    swept = ab.sweep(MACHINES / "discoidal.toml", {}, seeds=1, duration=0.1)
    assert {entry.name for entry in SWEPT} == set(map(str, swept)) - {"outcome", "verdict", "balanced"}


def test_a_slow_passage_is_near_its_peak_as_long_as_the_response_curve_is_above_half_and_stalled_balls_stretch_it() -> (
    None
):
    machine = ab.load_machine(MACHINES / "stall_and_release.toml")
    fast = ab.run_measures(ab.simulate(machine, hold_balls=True))["time_near_peak"]
    stalled = ab.run_measures(ab.simulate(machine))["time_near_peak"]
    assert float(stalled) > 3.0 * float(fast)
    duration = 300.0
    slow = ab.with_parameter(machine, "drive.profile.duration", duration)
    run = ab.simulate(slow, hold_balls=True, duration=duration, save=ab.Envelope(5000))
    w = np.linspace(1.0, 500.0, 100_000)
    mass = 625_000.0 / 250.0**2  # with its balls
    response = w**2 / np.abs(625_000.0 + 100.0j * w - mass * w**2)
    above = w[response > 0.5 * response.max()]
    formula = (above[-1] - above[0]) * duration / 500.0
    # the rotor lags the ramp by about its decay time of 0.2 s, and a bin is 0.06 s of 10.6 s
    assert float(ab.run_measures(run)["time_near_peak"]) == pytest.approx(formula, rel=0.01)


def test_a_sweep_names_the_parameter_that_is_impossible() -> None:
    with pytest.raises(ab.errors.MachineError, match=r"parameter 'rotor.mass' = '-1 kg'"):
        ab.sweep(MACHINES / "discoidal.toml", {"rotor.mass": ["-1 kg"]}, duration=1.0)
    with pytest.raises(QuestionError, match="no 'massx' there"):
        ab.sweep(MACHINES / "discoidal.toml", {"rotor.massx": [1.0]}, duration=1.0)


RUN_FUNCTIONS = (
    ab.run_measures, deflection_envelope, residual_vibration, peak_deflection, settling_time, break_away_speed,
    ball_angle_to_unbalance, vibration, static_deflection, residual_unbalance, support_forces, ab.verdict,
    ab.run_measures, ab.verdict,
)  # fmt: skip


@pytest.mark.parametrize("function", RUN_FUNCTIONS, ids=lambda function: function.__name__)
def test_a_function_of_a_run_says_so_to_who_gives_a_machine_a_path_or_another_result(function: Any) -> None:
    path = MACHINES / "discoidal.toml"
    with pytest.raises(
        QuestionError, match=r"given a machine; it measures a run, as in ab.(run_measures|verdict)\(ab.simul"
    ):
        function(ab.load_machine(path))
    with pytest.raises(QuestionError, match=r"ab.load_run\('run.nc'\)"):
        function(str(path))
    with pytest.raises(QuestionError):
        function(xr.Dataset())


def test_the_release_speed_of_a_machine_is_a_border_and_the_message_says_so() -> None:
    machine = ab.load_machine(MACHINES / "discoidal.toml")
    with pytest.raises(QuestionError, match=r"of the machine itself ask ab.stability.borders\(machine\)"):
        ab.run_measures(machine, "break_away_speed")


@pytest.mark.parametrize(
    ("name", "values", "message"),
    [
        ("speed", [100.0], "did you mean 'drive.profile.speed' or 'start.speed'?"),
        ("rotor.dampng", [1.0], "did you mean 'rotor.damping'?"),
        ("balancers.races.drag", [1.0], r"choose an entry, [1]; did you mean 'balancers[1].races[1].drag'?"),
        ("rotor.mass", [12.0, -1.0], "variation with rotor.mass = -1: "),
        ("balancers[1].races[1].balls[1].diameter", ["100 mm"], "diameter = 100 mm: "),
        ("viscosity", ["10 kg"], "variation with viscosity = 10 kg: given '10 kg'"),
    ],
)
def test_a_sweep_that_cannot_be_names_the_paths_that_fit_or_the_variation(
    name: str, values: list[Any], message: str
) -> None:
    with pytest.raises(AutobalancerError, match=re.escape(message)):
        ab.sweep(MACHINES / "discoidal.toml", {name: values}, duration=0.05)


def test_a_sweep_over_whole_parts_has_them_as_texts_and_can_be_saved(tmp_path: Path) -> None:
    laws = [{"law": "viscous", "damping": "1e-4 N*m*s"}, {"law": "viscous", "damping": "2e-4 N*m*s"}]
    path = "balancers[1].races[1].drag"
    whole = ab.sweep(MACHINES / "discoidal.toml", {path: laws}, duration=0.5)
    axis = whole["balancers_1_races_1_drag"]
    assert axis.values.tolist() == [
        "law = viscous, damping = 1e-4 N*m*s",
        "law = viscous, damping = 2e-4 N*m*s",
    ]
    ab.save_run(whole, tmp_path / "laws.nc")
    assert ab.load_run(tmp_path / "laws.nc")["balancers_1_races_1_drag"].equals(axis)
    numbers = ab.sweep(MACHINES / "discoidal.toml", {"drag": [1e-4, 2e-4]}, duration=0.5)  # a plain name of the same
    assert whole["peak_deflection"].values == pytest.approx(numbers["peak_deflection"].values, rel=1e-9)
