"""A run and a measurement side by side."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from benchmarks.closed_circle import RIG
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli.main import app
from autobalancer.errors import QuestionError
from autobalancer.measure import Sensor, Tacho, record
from references.seen_balls import seen_by_a_camera

RATE = 4000.0


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    return ab.simulate(ab.parse_machine(RIG), save=ab.Samples(1201), progress=False)


@pytest.fixture(scope="module")
def signals(run: xr.Dataset) -> xr.Dataset:
    sensors = [Sensor("displacement", direction=way, noise="40 dB", offset="1 mm") for way in ("x", "y")]
    return record(run, [*sensors, Tacho()], RATE, seed=4)


def test_a_run_beside_its_own_signals_differs_by_their_noise_only(run: xr.Dataset, signals: xr.Dataset) -> None:
    found = ab.compare(run, signals)
    np.testing.assert_allclose(found["rms_away"], found["rms_expected"], rtol=0.06)
    off = (found["measured_value"] - found["simulated_value"]).values
    paced = np.isin(found["measure"].values, ["peak_speed", "time_at_resonance"])
    alike = np.where(paced, 0.02, 1e-9)  # the measured speed is that of the pulses, held before the first one
    assert (np.abs(off) <= 4.0 * found["value_deviation"].values + alike * np.abs(found["measured_value"].values)).all()
    assert {"peak_deflection", "peak_speed", "residual_vibration"} <= set(found["measure"].values)
    peak = found.sel(measure="peak_deflection")
    assert float(peak["measured_value"]) == pytest.approx(
        float(ab.run_measures(run, "peak_deflection").deflection), rel=0.02
    )
    sure = np.hypot(found["order_amplitude_deviation"], 1e-3 * found["order_amplitude"].max())
    assert float(np.abs((found["order_amplitude"] - found["order_amplitude_simulated"]) / sure).max()) < 5.0
    assert any("balls" in note for note in found.attrs["notes"])


def test_measures_have_no_uncertainty_where_the_noise_of_a_sensor_is_not_known(
    run: xr.Dataset, signals: xr.Dataset
) -> None:
    unknown = signals.copy(deep=True)
    del unknown["displacement_y"].attrs["uncertainty"]
    found = ab.compare(run, unknown)
    assert np.isfinite(found["measured_value"]).all()
    assert np.isnan(found["value_deviation"]).all()
    (peak,) = [line for line in str(found).splitlines() if line.startswith("peak_deflection")]
    assert peak.split()[-2] == "-"


def test_orders_of_a_run_stand_over_its_own_speed_where_the_measurement_began_at_another_time(
    run: xr.Dataset, signals: xr.Dataset
) -> None:
    later = signals.assign_coords(time=signals["time"] + 0.05 * float(signals["time"][-1]))
    peaks = []
    for measured in (signals, later):
        found = ab.compare(run, measured).isel(channel=0)
        sizes = {of: found[f"order_amplitude{of}"].values for of in ("", "_simulated")}
        peaks.append([float(found[f"order_speed{of}"][np.argmax(size)]) for of, size in sizes.items()])
        (own,) = ab.compare(run, measured).sel(measure=["peak_speed"])["measured_value"].values
        assert own == pytest.approx(peaks[0][0], rel=0.03), "the measured peak is at the measured speed"
    np.testing.assert_allclose(peaks[1], peaks[0], rtol=0.015)  # the flat peak of a quick run-up, at other instants
    wrong = float(found["order_speed"][np.argmax(sizes["_simulated"])])
    assert abs(wrong / peaks[0][1] - 1.0) > 0.03  # over the measured speed it would stand elsewhere
    assert any("the measured speed differs" in note for note in found.attrs["notes"])


def test_more_damping_is_seen_in_the_measured_peak(run: xr.Dataset) -> None:
    damped = ab.simulate(ab.with_parameter(ab.parse_machine(RIG), "rotor.damping", 360.0), save=ab.Samples(1201))
    sensors = [Sensor("displacement", direction=way, noise="40 dB") for way in (20.0, 110.0)]
    found = ab.compare(run, record(damped, sensors, RATE)).sel(measure="peak_deflection")
    lower = float(found["simulated_value"] - found["measured_value"])
    true = float(
        ab.run_measures(run, "peak_deflection").deflection - ab.run_measures(damped, "peak_deflection").deflection
    )
    assert lower == pytest.approx(true, abs=5.0 * float(found["value_deviation"]))
    assert lower > 10.0 * float(found["value_deviation"])


def test_a_film_is_compared_by_the_release_of_its_balls(run: xr.Dataset) -> None:
    film = seen_by_a_camera(run.isel(time=slice(None, None, 4)), np.random.default_rng(3)).isel(ball=[1, 0])
    found = ab.compare(run, film)
    assert (found["rms_away"] < 1.1 * found["rms_expected"]).all()
    released = found.sel(measure="break_away_speed")
    true = np.sort(ab.run_measures(run, "break_away_speed").values)
    np.testing.assert_allclose(np.sort(released["measured_value"]), true, rtol=0.02)
    assert any("no measures of the deflection" in note for note in found.attrs["notes"])


def test_what_cannot_be_compared_is_said(run: xr.Dataset, signals: xr.Dataset) -> None:
    meters = signals.copy(deep=True)
    meters["displacement_x"].values *= 1000.0
    assert any("is its unit right, such as mm for m?" in note for note in ab.compare(run, meters).attrs["notes"])
    one = ab.compare(run, signals.drop_vars(["displacement_y", "tacho"]))
    assert any("two directions" in note for note in one.attrs["notes"])
    assert any("no tacho" in note for note in one.attrs["notes"])
    assert one.sizes["measure"] == 0
    later = signals.assign_coords(time=signals["time"] + 9.0)
    with pytest.raises(
        QuestionError, match=r"from 9 s to 9\.3 s, the run from 0 s to 0\.3 s; they have no time in common"
    ):
        ab.compare(run, later)
    with pytest.raises(QuestionError, match="give the measurement, too"):
        ab.compare(run)
    with pytest.raises(QuestionError, match="in its place"):
        ab.compare([ab.parse_machine(RIG)], signals)


def test_a_comparison_says_which_place_of_the_run_a_sensor_without_one_is_beside() -> None:
    machine = ab.example("two_plane_rotor")
    one = ab.simulate(machine, duration="50 ms", save=ab.Samples(401), progress=False)
    there = ab.compare(one, record(one, [Sensor("displacement", "upper", "x")], RATE))
    assert there["place"].values.tolist() == ["upper"]
    assert not any("where" in note for note in there.attrs["notes"])
    somewhere = record(one, [Sensor("displacement", direction="x")], RATE)
    found = ab.compare(one, somewhere)
    reference = one.attrs["reference_station"]
    assert found["place"].values.tolist() == [reference]
    assert f"displacement_x, {reference} of the run" in str(found)
    (note,) = [note for note in found.attrs["notes"] if "does not say where" in note]
    assert f"compared with {reference!r}" in note
    assert "'lower', 'upper'" in note


def test_the_command_lays_a_logger_file_over_a_run(run: xr.Dataset, signals: xr.Dataset, tmp_path: Path) -> None:
    for name, data in (("run.nc", run), ("logger.csv", signals)):
        ab.save_run(data, tmp_path / name)
    words = ["compare", str(tmp_path / "run.nc"), str(tmp_path / "logger.csv"), "--plot", str(tmp_path / "both.png")]
    answer = CliRunner().invoke(app, words)
    assert answer.exit_code == 0, answer.output
    assert "peak_deflection" in answer.output
    assert "its noise is not known" in " ".join(answer.output.split())
    assert (tmp_path / "both.png").stat().st_size > 0
