"""A machine fitted to the signals and the ball angles of a run-up."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from benchmarks.closed_circle import RATE, RIG, circles, measurements, parameter
from scipy.stats import binom

import autobalancer as ab
from autobalancer.errors import QuestionError
from autobalancer.measure import MeasuredRunUp, Sensor, Tacho, fit_run_up, record
from autobalancer.rotordynamics.parameter_fit import Trial
from references.seen_balls import seen_by_a_camera

DAMPING, DRAG, STIFFNESS = "rotor.damping", "balancers[1].races[1].drag.damping", "rotor.stiffness"
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


def test_signals_and_a_drawn_film_that_was_read_give_back_the_rig(rig: ab.machine.Machine, run: xr.Dataset) -> None:
    signals, film = measurements(run, 1)
    assert film.sizes["time"] == 16
    found = fit_run_up(rig, [signals, film], bounds(rig, DAMPING, DRAG)).data
    assert (np.abs(found["value"].values - [340.0, 1.1e-3]) < 4.0 * found["uncertainty"].values).all()
    assert (found["uncertainty"].values < 0.002 * found["value"].values).all()
    assert found.attrs["scatter_ratio"] == pytest.approx(1.0, abs=0.15)


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
    with pytest.raises(QuestionError, match="its place is 'bearing'; the places of the run are 'rotor'"):
        fit_run_up(rig, elsewhere, free)
    film = seen_by_a_camera(run.isel(time=slice(0, 1)), np.random.default_rng(1))
    with pytest.raises(QuestionError, match="2 measured values for 2 parameters"):
        fit_run_up(rig, film, free)
    with pytest.raises(QuestionError, match="displacement, velocity, acceleration or force"):
        fit_run_up(rig, signals.drop_vars("displacement_x"), free)


@pytest.mark.slow
def test_the_stated_deviations_are_those_of_many_draws_of_the_noise(rig: ab.machine.Machine) -> None:
    base = {path: parameter(rig, path) for path in (STIFFNESS, DAMPING, MOMENT, DRAG)}
    exact = record(
        ab.simulate(rig, save=ab.Samples(601), progress=False), [Sensor("displacement", noise="40 dB")], RATE
    )
    measured = MeasuredRunUp(exact)

    def seen(path: str, factor: float) -> np.ndarray:
        trial = Trial(ab.with_parameter(rig, path, factor * base[path]), {})
        values = measured.pairs(trial)[0].simulated
        return (values - values.mean()) / measured.rows().error

    slopes = np.array([(seen(path, 1.0001) - seen(path, 0.9999)) / 2e-4 for path in base]).T
    found = fit_run_up(rig, exact, bounds(rig, *base)).data
    stated = found["uncertainty"].values / np.array(list(base.values()))
    noise = np.random.default_rng(5).standard_normal((4000, exact.sizes["time"]))
    drawn = noise @ slopes @ np.linalg.inv(slopes.T @ slopes)
    np.testing.assert_allclose(
        drawn.std(axis=0), stated, rtol=0.04
    )  # of 4000 draws: 1.1 %; the fit is beside the truth
    assert 0.94 < (np.abs(drawn) < 1.96 * stated).mean() < 0.96


@pytest.mark.slow
def test_intervals_of_95_percent_hold_the_true_values_as_often_as_they_say() -> None:
    held = circles(5, first=5000)  # the benchmark takes a thousand
    # each rig counts once for each parameter; fewer than this happens once in a thousand times if the share is 95 %
    assert (held.sum(axis=0) >= binom.ppf(1e-3, 5, 0.95)).all()
    assert held.mean() > 0.90
