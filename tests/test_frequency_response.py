"""A machine measured at one speed after the other."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.references.stalled_pair import hanging_speed

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.assembly.rotors import lateral_model, station_rows, unbalance_load
from autobalancer.errors import MachineError, QuestionError
from autobalancer.files.examples import rig
from autobalancer.machine import Machine
from autobalancer.plots.run.stepped_response import COLORS, _jumps
from autobalancer.plots.style import BALLS
from autobalancer.simulation.record import Envelope, SampleTimes
from autobalancer.studies.stepped_response import stepped_response

MACHINES = Path(__file__).parents[1] / "examples" / "machines"
STALLING = MACHINES / "stall_and_release.toml"
RPM = math.pi / 30.0


def plain_rig() -> Machine:
    """Rodrigues' rig without its balancer; C = 2.5e-4 s K lets transients die within two seconds."""
    machine = rig("rodrigues_rig")
    fields = {key: getattr(machine, key) for key in machine.model_fields_set if key != "balancers"}
    return Machine(**fields)


def synchronous(machine: Machine, speed: float) -> tuple[dict[str, complex], dict[str, complex]]:
    """Forward and backward part of the motion at each station, z = f e^(iwt) + b e^(-iwt), from M, C, G, K."""
    model = lateral_model(machine)
    load = unbalance_load(machine, model)
    turning = model.damping_at(speed) + speed * model.gyroscopic
    dynamic = -(speed**2) * model.mass + 1j * speed * turning + model.stiffness_at(speed)
    q = np.linalg.solve(dynamic, speed**2 * np.concatenate([load, -1j * load]))
    n = model.pairs
    forward, backward = {}, {}
    for name, rows in station_rows(machine, model).items():
        x, y = rows.deflection @ q[:n], rows.deflection @ q[n : 2 * n]
        forward[name] = 0.5 * (x + 1j * y)
        backward[name] = 0.5 * (x - 1j * y).conjugate()
    return forward, backward


def test_a_rotor_without_balls_answers_as_the_synchronous_closed_form_says() -> None:
    machine, speeds = plain_rig(), np.array([900.0, 1460.0, 1600.0, 2100.0, 3000.0, 5000.0]) * RPM
    found = stepped_response(machine, speeds, dwell=8.0, window=0.5, stations=["B1", "B2"], tolerance=1e-10)
    for number, speed in enumerate(speeds):
        forward, backward = synchronous(machine, speed)
        at = found.isel(speed=number)
        major = {name: abs(forward[name]) + abs(backward[name]) for name in forward}
        for name in forward:
            assert float(at["greatest_deflection"].sel(station=name)) == pytest.approx(major[name], rel=1e-6)
            seen = at.sel(station=name)
            z = complex(float(seen["synchronous_x"]), float(seen["synchronous_y"]))
            # Hann's weight leaves the backward part, two periods a turn, out up to 1e-5 in a window of a few turns
            assert abs(z - forward[name]) < 2e-4 * major[name]
        assert float(at["amplitude"]) == pytest.approx(0.5 * (major["B1"] + major["B2"]), rel=1e-6)
        angles = np.linspace(0.0, 2.0 * np.pi, 20001)
        both = [np.abs(forward[b] * np.exp(1j * angles) + backward[b] * np.exp(-1j * angles)) for b in ("B1", "B2")]
        assert float(at["greatest_mean_deflection"]) == pytest.approx(0.5 * sum(both).max(), rel=1e-6)
        assert abs(float(at["amplitude_change"])) < 1e-7
    assert found["greatest_mean_deflection"].values[3] < 0.999 * found["amplitude"].values[3]
    assert "motion" not in found


def test_carried_steps_are_one_simulation_with_a_dwell_profile() -> None:
    speeds, dwell, window, rate = [150.0, 180.0, 230.0], 0.7, 0.3, 400.0
    machine = rig("rodrigues_rig_point_balls")
    found = stepped_response(
        machine, speeds, dwell=dwell, window=window, acceleration=rate, stations=["disk"], tolerance=1e-10
    )
    profile = {"kind": "dwell", "speeds": speeds, "hold": dwell + window, "acceleration": rate}
    driven = with_value_at(machine, "drive", {"kind": "speed", "profile": profile})
    begins = np.cumsum([dwell, dwell + window + 30.0 / rate - dwell + dwell, dwell + window + 50.0 / rate])
    end = float(begins[-1] + window)
    times = np.unique(np.concatenate([np.linspace(begin, begin + window, 6001) for begin in begins]).clip(0.0, end))
    run = ab.simulate(driven, duration=end, save=SampleTimes(times), tolerance=1e-10)
    for number, begin in enumerate(begins):
        part = run.sel(time=slice(begin - 1e-12, begin + window + 1e-12))
        at = found.isel(speed=number)
        # samples miss a maximum between them by at most (w step)^2/8
        assert float(at["amplitude"]) == pytest.approx(float(part["deflection"].max()), rel=3e-5)
        angles = part["ball_angle_in_rotor"].values
        np.testing.assert_allclose(at["least_ball_angle_in_rotor"], angles.min(axis=0), atol=2e-6)
        np.testing.assert_allclose(at["greatest_ball_angle_in_rotor"], angles.max(axis=0), atol=2e-6)
        np.testing.assert_allclose(at["mean_ball_speed_in_rotor"], (angles[-1] - angles[0]) / window, atol=2e-5)


@pytest.mark.parametrize("machine", [ab.load_machine(STALLING), rig("rodrigues_rig")], ids=["planar", "rigid"])
def test_a_jump_of_the_speed_is_the_limit_of_an_ever_faster_ramp(machine: Machine) -> None:
    question: dict[str, Any] = {"dwell": 0.02, "window": 0.05, "tolerance": 1e-11}
    jump = stepped_response(machine, [200.0, 230.0], **question)
    misses = []
    for rate in (3e5, 3e6):
        ramp = stepped_response(machine, [200.0, 230.0], acceleration=rate, **question)
        keys = ("least_ball_angle_in_rotor", "amplitude", "mean_ball_speed_in_rotor")
        misses.append([float(np.abs(ramp[k] - jump[k]).max() / np.abs(jump[k]).max()) for k in keys])
    assert max(misses[1]) < 1e-4
    # the miss shrinks with the duration of the ramp
    np.testing.assert_allclose(np.array(misses[1]) / np.array(misses[0]), 0.1, rtol=3e-3)


def test_balls_stall_upwards_until_they_break_away_and_stay_with_the_rotor_downwards() -> None:
    speeds = np.arange(220.0, 440.0, 10.0)
    found = stepped_response(STALLING, speeds, dwell=6.0, window=1.0, acceleration=20.0, direction="both")
    up, down = found.sel(direction="up"), found.sel(direction="down")
    names = found.attrs["averaged_stations"]
    assert names == ["rotor"]
    stalled_up = speeds[up["motion"].values == 2]
    # the balls hang from above w_c = 250 rad/s until near w_c (1 + 2 S) = 383 rad/s
    assert stalled_up.min() == 260.0
    assert stalled_up.max() in (370.0, 380.0)
    hanging = up["mean_ball_speed_in_rotor"].sel(speed=slice(320.0, 370.0))
    assert hanging.sizes["speed"] == 6
    for at in hanging:
        speed = float(at["speed"])
        # the beat with the unbalance, cut off by the window, moves the mean by 0.02 rad/s
        np.testing.assert_allclose(at + speed, hanging_speed(speed), atol=0.03)
    # downwards they stall where the balanced state is unstable, from 273.6 rad/s on
    (border,) = (b.speed for b in ab.stability.borders(STALLING) if b.name == "exact border")
    assert speeds[down["motion"].values == 2].tolist() == [260.0, 270.0]
    assert 270.0 < border < 280.0
    ratio = up["amplitude"].sel(speed=350.0) / down["amplitude"].sel(speed=350.0)
    assert float(ratio) > 1000.0
    assert set(np.unique(up["motion"].sel(speed=slice(400.0, 440.0)))) == {0}


def test_stalled_balls_of_a_known_case_have_the_deflection_of_the_torque_balance() -> None:
    """Two balls that turn with the critical speed: drag (W - w_c) beta = half the power of the dampers over w_c."""
    machine = with_value_at(ab.load_machine(STALLING), "unbalances[1].mass", 1e-6)
    found = stepped_response(machine, np.arange(240.0, 341.0, 10.0), dwell=6.0, window=2.0, acceleration=20.0)
    at = found.sel(speed=340.0)
    assert at["ball_motion"].values.tolist() == [2, 2]
    beta, damping = 1.4685e-4, 100.0
    ball_speed = 340.0 + float(at["mean_ball_speed_in_rotor"].mean())
    whirl = math.sqrt(2.0 * beta * (340.0 - ball_speed) / (damping * ball_speed))
    assert float(at["amplitude"]) == pytest.approx(whirl, rel=0.01)


def test_fixed_starts_do_not_depend_on_threads_and_equal_the_first_carried_speed() -> None:
    speeds = np.linspace(100.0, 300.0, 9)
    one, two = (
        stepped_response(rig("rodrigues_rig"), speeds, dwell=0.5, window=0.2, start="fixed", workers=count)
        for count in (1, 2)
    )
    assert one.drop_attrs().equals(two.drop_attrs())
    first = stepped_response(rig("rodrigues_rig"), speeds[4:5], dwell=0.5, window=0.2)
    assert first["amplitude"].values[0] == one["amplitude"].values[4]


def test_a_motion_that_settles_is_left_early_and_one_that_never_does_at_the_longest_time() -> None:
    machine = plain_rig()
    quick = stepped_response(machine, [100.0], dwell=0.1, window=0.2, settle="0.1 %", longest=20.0)
    assert 0.3 < float(quick["time_at_speed"][0]) < 10.0
    assert abs(float(quick["amplitude_change"][0])) <= 1e-3
    never = stepped_response(machine, [100.0], dwell=0.1, window=0.2, settle=1e-15, longest=0.8)
    assert float(never["time_at_speed"][0]) == pytest.approx(0.7)


def test_the_amplitude_is_found_between_the_steps_of_a_loose_integration() -> None:
    """An ellipse is cut by few steps a turn at a loose tolerance; its greatest radius is found all the same."""
    machine = plain_rig()
    loose, tight = (
        stepped_response(machine, [1560.0 * RPM], dwell=4.0, window=0.5, tolerance=tolerance)
        for tolerance in (1e-6, 1e-11)
    )
    assert float(loose["amplitude"][0]) == pytest.approx(float(tight["amplitude"][0]), rel=1e-5)


@pytest.mark.parametrize("name", ["stall_and_release", "two_plane_rotor"])
def test_speeds_held_in_long_steps_are_measured_as_with_the_explicit_pair(name: str) -> None:
    machine, speeds = MACHINES / f"{name}.toml", np.array([150.0, 200.0, 240.0])
    question: dict[str, Any] = {"dwell": 0.5, "window": 0.3, "acceleration": 400.0}
    found = stepped_response(machine, speeds, **question, tolerance=1e-8)
    exact = stepped_response(machine, speeds, **question, tolerance=5e-12)  # so strict, all steps are those of the pair
    assert exact.attrs["long_steps"] == 0
    assert found.attrs["long_steps"] > 0.5 * found.attrs["steps"]
    np.testing.assert_allclose(found["amplitude"], exact["amplitude"], rtol=3e-6)
    np.testing.assert_allclose(found["greatest_deflection"], exact["greatest_deflection"], rtol=3e-6)
    for part in ("synchronous_x", "synchronous_y"):
        assert float(np.abs(found[part] - exact[part]).max()) < 3e-6 * float(exact["amplitude"].max())
    for part in ("least", "greatest"):
        angles = f"{part}_ball_angle_in_rotor"
        np.testing.assert_allclose(found[angles], exact[angles], atol=1e-5)


def test_responses_of_two_machines_side_by_side_have_the_bits_of_one_after_the_other() -> None:
    speeds, question = np.linspace(200.0, 300.0, 6), {"dwell": 0.3, "window": 0.1}
    machines = [with_value_at(ab.load_machine(STALLING), "unbalances[1].mass", mass) for mass in (1e-4, 2e-4)]

    def response(machine: Machine) -> xr.Dataset:
        return stepped_response(machine, speeds, **question)

    with ThreadPoolExecutor(2) as pool:
        together = list(pool.map(response, machines))
    for machine, one in zip(machines, together, strict=True):
        assert one.drop_attrs().equals(response(machine).drop_attrs())


def test_a_scheduled_unbalance_counts_as_after_its_schedule() -> None:
    base = plain_rig()
    late = with_value_at(base, "unbalances[1].schedule", {"time": [0.0, 3.0], "factor": [0.0, 2.0]})
    twice = with_value_at(base, "unbalances[1].moment", 2.0 * base.unbalances[0].size)
    one, two = (stepped_response(machine, [200.0], dwell=1.0, window=0.2, tolerance=1e-12) for machine in (late, twice))
    assert float(one["amplitude"][0]) == pytest.approx(float(two["amplitude"][0]), rel=1e-12)


def test_the_picture_shows_both_ways_and_every_motion() -> None:
    speeds = np.arange(230.0, 330.0, 10.0)
    how: dict[str, Any] = {"dwell": 2.0, "window": 0.5, "acceleration": 50.0, "direction": "both"}
    found = stepped_response(STALLING, speeds, **how, without_balls=True)
    bare = ab.rotor.response(STALLING, speeds[3:], balls=True)  # their mass on the rotor, no unbalance of them
    circle = np.abs(bare["x_real"] + 1j * bare["x_imag"]).values[:, 0]
    for way in found["amplitude_without_balls"].values:
        np.testing.assert_allclose(way[3:], circle, rtol=5e-3)  # the passage has not quite died
    first, *_ = found.remarks()
    assert first.startswith(
        "at 9 of 10 speeds the amplitude is more than a tenth greater than without balls, most at 3055.8"
    )
    assert "without balls up" in [column.head for column in found.columns()]
    assert "than without balls" not in found.heading()
    stalled = found.sel(speed=slice(270.0, None))  # the passage of a machine that comes no lower
    assert "the greatest deflection on the way is 3.16 times as much as without balls" in stalled.heading()
    figure = ab.plot.stepped_response(found)
    legend = figure.axes[0].get_legend()
    assert legend is not None
    labels = [text.get_text() for text in legend.get_texts()]
    assert {"upwards", "downwards", "balls stalled", "without balls"} <= set(labels)
    assert any(label.startswith("joined") for label in labels)
    assert figure.axes[0].get_yscale() == "log"
    figure.draw_without_rendering()
    assert legend.get_window_extent().x0 > 0.0
    assert figure.axes[0].get_window_extent().width > 0.85 * figure.bbox.width  # keys that are too wide make it narrow
    with pytest.raises(QuestionError, match="not a result"):
        ab.plot.stepped_response(found.drop_vars("amplitude_change"))


@pytest.mark.parametrize("log", [True, False])
def test_one_tiny_amplitude_does_not_stretch_the_axis(log: bool) -> None:
    found = stepped_response(plain_rig(), [90.0, 100.0, 110.0, 120.0], dwell=0.5, window=0.1)
    found["amplitude"][2] = 1e-16
    axes = ab.plot.stepped_response(found, log=log, deflection_unit="um").axes[0]
    low, high = axes.get_ylim()
    greatest = 1e6 * float(found["amplitude"].max())
    assert high > greatest
    drawn = np.concatenate([np.atleast_1d(line.get_ydata()) for line in axes.get_lines() if line.get_marker() == "^"])
    legend = axes.get_legend()
    assert legend is not None
    edge = [text.get_text() for text in legend.get_texts() if "lower edge" in text.get_text()]
    if log:
        assert 1e-6 * greatest < low <= 1e-5 * greatest
        assert low in drawn  # the tiny one stands on the edge
        assert len(edge) == 1
    else:
        assert not edge


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"speeds": [100.0, 90.0]}, "must ascend"),
        ({"speeds": [-1.0, 90.0]}, "above zero"),
        ({"speeds": []}, "finite speeds"),
        ({"dwell": -1.0}, "dwell: given -1.0"),
        ({"window": 0.0}, "window: given 0.0"),
        ({"acceleration": 0.0}, "acceleration: given 0.0"),
        ({"direction": "sideways"}, "must be 'up', 'down' or 'both'"),
        ({"start": "fixed", "direction": "down"}, "leave out direction"),
        ({"stations": ["B3"]}, "there is 'B1', 'B2', 'disk'"),
        ({"settle": 0.01}, "both or none"),
        ({"settle": 0.01, "longest": 0.1}, "at least dwell and window"),
        ({"tolerance": 1.0}, "between 1e-13"),
        ({"store": "here.txt"}, "ends with .nc"),
    ],
)
def test_questions_without_sense_are_refused(change: dict[str, Any], message: str) -> None:
    question = {"speeds": [100.0, 110.0], "dwell": 0.1, "window": 0.1} | change
    with pytest.raises(QuestionError, match=message):
        stepped_response(rig("rodrigues_rig"), **question)


def test_a_table_that_does_not_cover_the_speeds_is_refused() -> None:
    support = {
        "position": "110 mm",
        "table": {"speed": [0.0, 300.0], "stiffness": ["20 kN/m", "22 kN/m"], "damping": [5.0, 6.0]},
    }
    machine = with_value_at(plain_rig(), "rotor.supports[1]", support)
    with pytest.raises(MachineError, match="300 rad/s"):
        stepped_response(machine, [100.0, 400.0], dwell=0.1, window=0.1)


def test_a_speed_whose_budget_is_spent_ends_the_way_and_says_so() -> None:
    found = stepped_response(rig("rodrigues_rig"), [200.0, 300.0], dwell=5.0, window=1.0, max_steps=100)
    assert found["outcome"].values.tolist() == ["budget spent", "not reached"]
    assert found.attrs["outcome"] == "ended early"
    assert np.isnan(found["amplitude"].values).all()
    assert found["motion"].values.tolist() == [-1, -1]


def test_the_envelope_of_a_run_at_constant_speed_is_the_amplitude() -> None:
    machine = with_value_at(plain_rig(), "stations", ({"name": "B1", "position": "110 mm"},))
    machine = with_value_at(machine, "drive.profile.speed", 1000.0 * RPM)
    run = ab.simulate(machine, duration=5.0, save=Envelope(10), tolerance=1e-10)
    found = stepped_response(machine, [1000.0 * RPM], dwell=4.5, window=0.5, tolerance=1e-10)
    assert float(found["amplitude"][0]) == pytest.approx(float(run["envelope_high"][-1]), rel=1e-9)


def test_a_stepped_response_is_not_joined_across_a_jump() -> None:
    amplitude, motion = np.array([1.0, 1.2, 3.0, 3.1, 3.0]), np.array([0, 0, 0, 0, 2])
    assert _jumps(amplitude, motion).tolist() == [False, True, False, True]


def test_balls_and_what_they_do_never_share_a_color() -> None:
    assert not set(COLORS.values()) & {*BALLS}
