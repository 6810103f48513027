"""A machine fitted to the signals and the ball angles of a run-up."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from benchmarks.closed_circle import RATE, RIG, circles, parameter, seen_by_a_camera
from scipy.stats import binom

import autobalancer as ab
from autobalancer.errors import QuestionError
from autobalancer.measure import Sensor, Tacho, fit_run_up, record

DAMPING, DRAG, STIFFNESS = "rotor.damping", "balancers[1].races[1].drag.beta", "rotor.stiffness"
MOMENT = "unbalances[1].moment"


@pytest.fixture(scope="module")
def rig() -> ab.machine.Machine:
    return ab.parse_machine(RIG)


@pytest.fixture(scope="module")
def run(rig: ab.machine.Machine) -> xr.Dataset:
    true = ab.with_parameter(ab.with_parameter(rig, DAMPING, 340.0), DRAG, 1.1e-3)
    return ab.simulate(true, save=ab.Samples(601), progress=False)


@pytest.fixture(scope="module")
def signals(run: xr.Dataset) -> xr.Dataset:
    return record(run, [Sensor("displacement", noise="1 um", offset="1 mm"), Tacho()], RATE, seed=2)


def bounds(rig: ab.machine.Machine, *paths: str) -> dict[str, tuple[float, float]]:
    return {path: (0.3 * parameter(rig, path), 3.0 * parameter(rig, path)) for path in paths}


def test_one_sensor_with_an_unknown_offset_tells_damping_and_drag(rig: ab.machine.Machine, signals: xr.Dataset) -> None:
    found = fit_run_up(rig, signals, bounds(rig, DAMPING, DRAG)).data
    away = (found["value"].values - [340.0, 1.1e-3]) / found["uncertainty"].values
    assert np.abs(away).max() < 4.0
    assert (found["uncertainty"].values < 0.01 * np.array([340.0, 1.1e-3])).all()
    assert found.attrs["chi_square"] == pytest.approx(found.attrs["degrees_of_freedom"], rel=5.0 * np.sqrt(2.0 / 300.0))
    half = 0.5 * (found["interval_high"] - found["interval_low"])
    np.testing.assert_allclose(half, 1.959964 * found["uncertainty"], rtol=1e-6)


def test_a_film_tells_the_drag_whatever_the_balls_are_called(rig: ab.machine.Machine, run: xr.Dataset) -> None:
    film = seen_by_a_camera(run.isel(time=slice(0, None, 10)), np.random.default_rng(1))
    film["ball_angle"][5, 0] = np.nan
    swapped = film.isel(ball=[1, 0]).assign_coords(ball=[1, 2])
    damped = ab.with_parameter(rig, DAMPING, 340.0)
    first, second = (fit_run_up(damped, one, bounds(rig, DRAG)).data for one in (film, swapped))
    assert float(first["value"][0]) == pytest.approx(float(second["value"][0]), rel=1e-9)
    assert abs(float(first["value"][0]) - 1.1e-3) < 4.0 * float(first["uncertainty"][0])


def test_mass_stiffness_damping_and_unbalance_in_proportion_cannot_be_told_from_one_another(
    rig: ab.machine.Machine,
) -> None:
    plain = rig.model_copy(update={"balancers": ()})
    paths = ("rotor.mass", STIFFNESS, DAMPING, MOMENT)
    run = ab.simulate(plain, save=ab.Samples(601), progress=False)
    measured = record(run, [Sensor("displacement", noise="1 um")], RATE)
    found = fit_run_up(plain, measured, bounds(plain, *paths)).data
    assert found.attrs["rank"] == 3
    assert np.isinf(found["uncertainty"].values).all()
    assert any("the data do not determine the joint relative change" in note for note in found.attrs["notes"])


def test_wrong_measurements_are_refused(rig: ab.machine.Machine, signals: xr.Dataset, run: xr.Dataset) -> None:
    free = bounds(rig, DAMPING, DRAG)
    unknown = signals.copy(deep=True)
    del unknown["displacement_x"].attrs["uncertainty"]
    with pytest.raises(QuestionError, match="the noise of 'displacement_x' is not known"):
        fit_run_up(rig, unknown, free)
    meters = signals.copy(deep=True)
    meters["displacement_x"].values *= 1000.0
    with pytest.raises(QuestionError, match=r"displacement_x: .* times the simulated one; is its unit right"):
        fit_run_up(rig, meters, free)
    elsewhere = signals.copy(deep=True)
    elsewhere["displacement_x"].attrs["place"] = "bearing"
    with pytest.raises(QuestionError, match="given 'bearing'; the places of the run are 'rotor'"):
        fit_run_up(rig, elsewhere, free)
    film = seen_by_a_camera(run.isel(time=slice(0, 1)), np.random.default_rng(1))
    with pytest.raises(QuestionError, match="2 measured values for 2 parameters"):
        fit_run_up(rig, film, free)
    with pytest.raises(QuestionError, match="displacement, velocity, acceleration or force"):
        fit_run_up(rig, signals.drop_vars("displacement_x"), free)


@pytest.mark.slow
def test_intervals_of_95_percent_hold_the_true_values_as_often_as_they_say() -> None:
    held = circles(40, first=5000)
    # each rig counts once for each parameter; fewer than this happens once in a thousand times if the share is 95 %
    assert (held.sum(axis=0) >= binom.ppf(1e-3, 40, 0.95)).all()
    assert held.mean() > 0.90
