"""Races and balls from measurements: waves of a profile, friction from rests, drag from the lag of a ball."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import QuestionError
from autobalancer.files.examples import example_text
from autobalancer.laws.stall import rest_ends
from autobalancer.measure import drag_from_lag, race_shape, rest_friction
from autobalancer.measurement.race_measurements import _gain
from autobalancer.plots.balancing import race_shape as picture
from autobalancer.plots.balancing import rests

RNG = np.random.default_rng(11)


def profile(phi: np.ndarray) -> np.ndarray:
    """83 mm, 12 um off the axis at 57 deg, an oval of 18 um and three waves of 4 um."""
    return 83e-3 + 12e-6 * np.cos(phi - 1.0) + 18e-6 * np.cos(2.0 * (phi - 2.7)) + 4e-6 * np.cos(3.0 * (phi - 0.7))


def test_waves_of_an_uneven_profile_are_exact_and_eccentricity_is_no_wave():
    phi = np.sort(2.0 * np.pi * (np.arange(60) + 0.4 * RNG.random(60)) / 60)
    mixed = RNG.permutation(phi)
    found = race_shape(mixed, profile(mixed))
    np.testing.assert_allclose(found.amplitude[:3], [18e-6, 4e-6, 0.0], atol=1e-12)
    assert float(found.crest[0]) % np.pi == pytest.approx(2.7)
    assert found.attrs["radius"] == pytest.approx(83e-3, rel=1e-12)
    assert found.attrs["eccentricity"] == pytest.approx(12e-6, rel=1e-6)
    assert found.attrs["eccentricity_angle"] == pytest.approx(1.0, rel=1e-6)
    fine = np.linspace(0.0, 2.0 * np.pi, 20001)
    shape = profile(fine) - 83e-3 - 12e-6 * np.cos(fine - 1.0)
    assert found.attrs["roundness"] == pytest.approx(np.ptp(shape), rel=1e-4)


def test_the_stated_deviation_of_a_wave_is_that_of_many_profiles():
    phi = 2.0 * np.pi * np.arange(90) / 90
    off, stated = [], []
    for _ in range(60):
        found = race_shape(phi, profile(phi) + 1e-6 * RNG.standard_normal(90), waves=8)
        off.append(float(found.amplitude[0]) - 18e-6)
        stated.append(float(found.amplitude_deviation[0]))
    assert np.sqrt(np.mean(np.square(off))) == pytest.approx(np.mean(stated), rel=0.3)  # of 60: 9 %, three times


def test_the_lines_for_a_machine_file_make_the_race_that_was_measured():
    text = race_shape(ab.catalog.example_path("race_profile")).machine_lines()
    base = example_text("one_ball_run_up")
    machine = ab.parse_machine(base.replace('orbit_radius = "76.95 mm"\n', text))
    race = machine.balancers[0].races[0]
    assert [wave.order for wave in race.harmonics] == [2, 3]  # no wave of the noise
    assert float(race.harmonics[0].amplitude) == pytest.approx(18e-6, rel=0.05)
    assert float(race.eccentricity) == pytest.approx(12e-6, rel=0.05)
    assert "eccentricity" not in race_shape(ab.catalog.example_path("race_profile"), center="setup").machine_lines()


def test_bad_profiles_are_refused_with_the_angle():
    phi = 2.0 * np.pi * np.arange(90) / 90
    with pytest.raises(QuestionError, match=r"nothing was measured from 76 to 124 deg"):
        race_shape(np.delete(phi, range(20, 31)), np.delete(profile(phi), range(20, 31)))
    with pytest.raises(QuestionError, match=r"15 waves need at least 33"):
        race_shape(phi[::4], profile(phi)[::4])
    dirty = profile(phi) + 1e-7 * RNG.standard_normal(90)
    dirty[25] += 60e-6
    with pytest.raises(QuestionError, match=r"the point at 100 deg is .* um off its neighbors"):
        race_shape(phi, dirty)


def test_friction_from_rests_covers_the_true_one_as_often_as_stated():
    machine, speed, true = ab.example("one_ball_run_up"), 1200.0 * np.pi / 30.0, 2e-4
    gain, load = _gain(machine, speed)
    assert load == pytest.approx(594e-6)
    one = resolve(machine)[0]
    ends = rest_ends(gain, load, one.moment, one.orbit_radius, true)
    within = 0
    for _ in range(16):
        found = rest_friction(machine, RNG.uniform(*ends, 20), speed)
        within += found.low <= true <= found.high
    assert within >= 13  # 95 % of 16 are 15.2, less two and a half standard deviations


def test_bad_rests_are_refused():
    machine = ab.example("one_ball_run_up")
    with pytest.raises(QuestionError, match="given 3 rests"):
        rest_friction(machine, [0.1, 0.2, 0.3], 120.0)
    with pytest.raises(QuestionError, match=r"a rest at 171.9 deg is more than 90 deg off"):
        rest_friction(machine, [0.1, 0.2, 0.3, 3.0, 0.0], 120.0)
    with pytest.raises(QuestionError, match="2 balls"):
        rest_friction(ab.example("discoidal"), np.linspace(-0.2, 0.2, 9), 120.0)


def lag_of(drag: float, rolling: float, time: np.ndarray, acceleration: float) -> np.ndarray:
    """Speed of the ball of the sample by an integration of its own equation, the rotor at rest in its place."""
    ball = resolve(ab.example("one_ball_run_up"))[0]
    roll = 0.4 * ball.mass * ball.radius  # a steel ball that rolls
    inertia = ball.inertia
    spin = ball.effective_mass * ball.orbit_radius**2 - roll * ball.orbit_radius

    def rate(t: float, v: np.ndarray) -> list[float]:
        push = rolling * ball.effective_mass * ball.orbit_radius**2 * (acceleration * t + v[0]) ** 2 * np.sign(-v[0])
        return [(-drag * v[0] + push - spin * acceleration) / inertia]

    found = solve_ivp(rate, (0.0, time[-1]), [0.0], t_eval=time, rtol=1e-10, atol=1e-12)
    return acceleration * time + found.y[0]


def test_drag_and_rolling_resistance_follow_from_the_lag_of_a_ball():
    time = np.linspace(0.0, 8.0, 201)
    seen = lag_of(2e-4, 0.002, time, 4.0)
    found = drag_from_lag(ab.example("one_ball_run_up"), time, 4.0 * time, seen)
    assert found.drag == pytest.approx(2e-4, rel=1e-3)
    assert found.rolling_resistance == pytest.approx(0.002, rel=1e-2)
    off = []
    for _ in range(30):
        noisy = drag_from_lag(ab.example("one_ball_run_up"), time, 4.0 * time, seen + 0.02 * RNG.standard_normal(201))
        off.append(((noisy.drag - 2e-4) / noisy.drag_deviation, noisy.scatter))
    assert np.sqrt(np.mean(np.square(off), axis=0)) == pytest.approx([1.0, 0.02], rel=0.4)  # of 30: 13 %, three times


def test_the_lag_of_a_simulated_ball_gives_the_drag_of_its_machine():
    machine = with_value_at(ab.example("one_ball_run_up"), "rotor.stiffness", 1e9)
    table = {"kind": "speed", "profile": {"kind": "table", "time": [0.0, 5.0], "speed": [0.0, 8.0]}}
    machine = with_value_at(machine, "drive", table)
    run = ab.simulate(machine, duration=5.0, save=ab.SampleTimes(np.linspace(0.0, 5.0, 101).tolist()))
    found = drag_from_lag(
        machine, run.time.values, run.speed.values, run.ball_speed_in_space.values[:, 0], rolling=False
    )
    assert found.drag == pytest.approx(1.88168e-4, rel=1e-5)
    with pytest.raises(QuestionError, match="does not lag"):
        drag_from_lag(machine, run.time.values, run.speed.values, run.speed.values)
    with pytest.raises(QuestionError, match="times must ascend"):
        drag_from_lag(machine, run.time.values[::-1], run.speed.values, run.speed.values)


def test_pictures_show_the_waves_and_the_interval_of_rests():
    shape = race_shape(ab.catalog.example_path("race_profile"))
    bars = picture(shape).axes[1].patches
    assert bars[0].get_height() == pytest.approx(1e6 * float(shape.amplitude[0]))
    machine = ab.example("one_ball_run_up")
    found = rest_friction(machine, ab.catalog.example_path("rest_positions"), 1200.0 * np.pi / 30.0)
    edges = sorted(line.get_xdata()[0] for line in rests(found).axes[0].lines[:2])
    assert edges[1] - edges[0] == pytest.approx(found.width)
