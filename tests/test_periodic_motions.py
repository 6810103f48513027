"""Balls that swing and balls that stall: orbits by collocation against the compiled equations, simulation and closed forms."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
import xarray as xr
from tests.references.planar_flow import flow
from tests.references.stalled_pair import parting_multipliers
from tests.references.two_balls import RACE, STALL, branch, specials, stall_machine, swinging

from autobalancer.api import simulate
from autobalancer.assembly.quantities import with_value_at
from autobalancer.simulation.record import Samples
from autobalancer.stability.branch_diagrams import branches
from autobalancer.stability.host.stations import plane, stations
from autobalancer.stability.maps.balanced import growth_rate, planar_balancer_of
from autobalancer.stability.stalled_orbits import stalled_orbits
from autobalancer.stability.steady_curves import Family, Range, coincident, kinds

# balls that swing


def test_small_stable_swinging_is_born_where_the_coefficient_is_negative() -> None:
    found = swinging(0.2)
    (point,) = specials(found, "Hopf", 1)
    assert str(point["criticality"].values) == "supercritical"
    small = branch(found, 2).isel(point=slice(1, 6))
    assert (small["parameter"] < float(point["special_parameter"])).all()
    assert (small["verdict"] == "stable").all()
    # simulation: a disturbed balanced state settles on the orbit
    orbit = small.isel(point=4)
    assert settled_swing(0.2, float(orbit["parameter"]), 0.05, time=400.0) == pytest.approx(swing(orbit), rel=5e-3)


@pytest.mark.slow
def test_balls_jump_where_the_coefficient_is_positive() -> None:
    found = swinging(0.85)
    (point,) = specials(found, "Hopf", 1)
    assert str(point["criticality"].values) == "subcritical"
    small = branch(found, 2).isel(point=slice(1, 6))
    assert (small["parameter"] > float(point["special_parameter"])).all()
    assert (small["verdict"] == "unstable").all()
    # simulation: on the stable side a smaller disturbance than the orbit dies out, a larger one grows
    orbit = small.isel(point=4)
    speed, size = float(orbit["parameter"]), swing(orbit)
    assert settled_swing(0.85, speed, 0.7 * size, time=20.0) < 0.6 * size
    assert settled_swing(0.85, speed, 1.4 * size, time=20.0) > 1.6 * size


def swing(orbit: xr.Dataset) -> float:
    """Greatest half range of a ball angle."""
    return float((orbit["ball_angle_in_rotor_max"] - orbit["ball_angle_in_rotor_min"]).max() / 2.0)


def settled_swing(share: float, speed: float, disturbance: float, time: float) -> float:
    """Half range of the ball angle after a time, from the balanced state disturbed along its leading mode."""
    machine = stall_machine(share, 1e-4)
    span = Range(Family(machine, ["speed"]), speed, speed + 1.0)
    field = span.whole(0.0)
    angle = math.acos(-share)
    state = np.array([0.0, 0.0, 0.0, 0.0, angle, -angle, 0.0, 0.0])
    scale = span.scale(2)
    values, vectors = np.linalg.eig(field.jacobian(state) * scale / scale[:, None])
    values = np.where(values.imag > 0.0, values, -np.inf)
    mode = vectors[:, np.argmax(values.real)]
    mode = (mode / mode[4:6][np.argmax(np.abs(mode[4:6]))]).real * scale
    late = flow(field, state + disturbance * mode, np.linspace(time, time + 2.0, 2001), 1e-9)
    return float(np.ptp(late[:, 4:6], axis=0).max() / 2.0)


def test_the_amplitude_near_a_hopf_point_is_the_one_of_the_coefficient() -> None:
    machine = stall_machine(0.2, 1e-4)
    found = swinging(0.2)
    (point,) = specials(found, "Hopf", 1)
    speed, w = float(point["special_parameter"]), float(point["special_frequency"])
    closed = planar_balancer_of(plane(machine))
    slope = (growth_rate(closed, speed + 0.01, 1.84) - growth_rate(closed, speed - 0.01, 1.84)) / 0.02
    first = branch(found, 2).isel(point=1)
    expected = math.sqrt(-slope * (float(first["parameter"]) - speed) / (w * float(point["lyapunov_coefficient"])))
    assert swing(first) == pytest.approx(expected, rel=0.03)


def test_a_branch_of_swinging_balls_can_join_two_hopf_points() -> None:
    found = swinging(0.2)
    assert found.attrs["branch_ends"][1] == "Hopf"
    other = branches(stall_machine(0.2, 1e-4), "speed", 300.0, 273.0, from_state="in line", orbits=False)
    (point,) = specials(other, "Hopf")
    assert float(branch(found, 2)["parameter"][-1]) == pytest.approx(float(point["special_parameter"]), abs=2e-3)


# stalled balls


@cache
def stalled() -> xr.Dataset:
    return branches(STALL, "speed", 255.0, 450.0, from_state="stalled")


def test_a_stalled_orbit_satisfies_the_compiled_equations_and_has_a_multiplier_of_one() -> None:
    span = Range(Family(STALL, ["speed"]), 255.0, 450.0)
    groups = coincident(np.zeros(2), kinds([stations(STALL)]))
    ((problem, u),) = stalled_orbits(span, groups, 0.3, 60)
    orbit = problem.orbit(u)
    field, scale = span.whole(0.3), span.scale(2)
    turn = np.concatenate([np.zeros(4), 2.0 * np.pi * np.array(orbit.winding), np.zeros(2)])

    def after(state: np.ndarray) -> np.ndarray:
        return flow(field, state, np.array([0.0, orbit.period]), 1e-13)[-1]

    np.testing.assert_allclose((after(orbit.states[0]) - orbit.states[0] - turn) / scale, 0.0, atol=1e-8)
    assert orbit.winding == (-1, -1)
    assert abs(orbit.multipliers[0] - 1.0) < 1e-6
    steps = 1e-5 * np.diag(scale)
    slopes = [(after(orbit.states[0] + h) - after(orbit.states[0] - h)) / 2e-5 / scale for h in steps]
    expected = np.linalg.eigvals(np.array(slopes).T)
    for value in orbit.multipliers:
        assert np.abs(expected - value).min() < 1e-6


@pytest.mark.slow
def test_stalled_balls_release_at_a_fold_near_the_release_speed() -> None:
    found = stalled()
    balancer = planar_balancer_of(plane(STALL))
    sommerfeld = (balancer.moment * balancer.critical_speed) ** 2 / (balancer.damping * balancer.drag)
    release = balancer.critical_speed * (1.0 + 2.0 * sommerfeld)
    folds = [float(point["special_parameter"]) for point in specials(found, "fold")]
    assert max(folds) == pytest.approx(383.31503761, abs=1e-6)  # by AUTO-07p, see reproductions/auto07p
    assert max(folds) == pytest.approx(release, rel=2e-3)
    (parting,) = (float(point["special_parameter"]) for point in specials(found, "branch point"))
    assert release - 0.01 < parting < max(folds)  # here the balls part, just before
    assert parting_multipliers(parting)[1] == pytest.approx(1.0, abs=1e-6)


def released(acceleration: float) -> float:
    """Rotor speed at which hanging balls leave the critical speed in a steady run-up."""
    time = 90.0 / acceleration
    profile = {"kind": "ramp", "start": 300.0, "end": 390.0, "duration": time}
    machine = with_value_at(STALL, "drive", {"kind": "speed", "profile": profile})
    machine = with_value_at(machine, f"{RACE}.collisions", False)
    for key, value in (("start_angles", (0.0, 0.1)), ("start_speeds", (-50.0, -50.0))):
        machine = with_value_at(machine, f"{RACE}.balls[1].{key}", value)
    run = simulate(machine, duration=time, save=[Samples(36_001)], mass_spread=0.0)
    speed, balls = run["speed"].values, run["ball_speed_in_space"].values.mean(axis=1)
    hanging = np.abs(balls - 250.0) < 15.0
    assert hanging[(speed > 305.0) & (speed < 383.0)].all()
    return float(speed[np.flatnonzero(hanging)[-1]])


@pytest.mark.slow
def test_slow_run_ups_release_the_balls_where_the_stalled_orbit_ends() -> None:
    fast, slow = released(1.0), released(0.4)
    # a fold is overrun by a delay that goes with the rate to the power 2/3
    delay = (fast - slow) / (1.0 - 0.4 ** (2.0 / 3.0))
    fold = max(float(point["special_parameter"]) for point in specials(stalled(), "fold"))
    assert 0.2 < slow - fold < fast - fold < 1.5
    assert fast - delay == pytest.approx(fold, abs=0.05)


@pytest.mark.slow
def test_stalled_balls_turn_with_about_the_critical_speed_wherever_they_are_stable() -> None:
    found = stalled()
    stable = found.isel(point=np.flatnonzero(found["verdict"].values == "stable"))
    speeds = stable["ball_speed_in_space"].values
    assert np.all(np.abs(speeds - 250.0) < 9.0)
    lasting = found["parameter"].values[found["verdict"].values != "unstable"]
    doublings = [float(point["special_parameter"]) for point in specials(found, "period doubling")]
    (last,) = (value for value in doublings if 270.0 < value < 280.0)
    assert lasting.min() == pytest.approx(last, abs=1e-5)
    assert parting_multipliers(last)[0] == pytest.approx(-1.0, abs=1e-6)
