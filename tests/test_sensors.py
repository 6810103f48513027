"""Sensors on a simulated machine: a logger file of a run holds what the run did."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli.main import app
from autobalancer.errors import QuestionError
from autobalancer.measure import Sensor, Tacho, record

MASS, STIFFNESS, DAMPING, UNBALANCE = 10.0, 1e5, 400.0, 1e-4  # kg, N/m, N s/m, kg m
SPEED, RATE = 150.0, 4000.0  # rad/s, Hz
LAG = 0.7  # rad, of the unbalance ahead of the mark


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    """A planar rotor that whirls steadily at constant speed, its transient died out in the last half."""
    machine = ab.parse_machine(
        f"""name = "whirling rotor"
axis = "vertical"
rotor = {{ kind = "planar", mass = {MASS}, stiffness = {STIFFNESS}, damping = {DAMPING} }}
drive = {{ kind = "speed", profile = {{ kind = "constant", speed = {SPEED} }} }}
unbalances = [{{ moment = {UNBALANCE}, angle = {LAG} }}]
run = {{ duration = 1.6 }}
"""
    )
    return ab.simulate(machine, save=ab.Samples(1201))


def order_one(signals: xr.Dataset, name: str, speed: float = SPEED) -> complex:
    """Amplitude and phase against the mark, by least squares with mean and slope; the mark is at 0 at time 0."""
    time = signals["time"].values
    waves = np.column_stack([np.cos(speed * time), -np.sin(speed * time), np.ones_like(time), time])
    a, b, *_ = np.linalg.lstsq(waves, signals[name].values, rcond=None)[0]
    return complex(a, b)


def receptance() -> complex:
    """x of an unbalance of 1 kg m at the mark, by the closed form."""
    return SPEED**2 / (STIFFNESS - MASS * SPEED**2 + 1j * DAMPING * SPEED)


def test_displacement_velocity_and_acceleration_have_amplitude_and_phase_of_the_closed_form(run: xr.Dataset) -> None:
    sensors = [Sensor(q) for q in ("displacement", "velocity", "acceleration")] + [
        Sensor("displacement", direction="y")
    ]
    found = record(run, sensors, RATE, start=0.9)
    z = UNBALANCE * np.exp(1j * LAG) * receptance()
    wanted = {
        "displacement_x": z,
        "velocity_x": 1j * SPEED * z,
        "acceleration_x": -(SPEED**2) * z,
        "displacement_y": -1j * z,
    }
    for name, true in wanted.items():  # the transient has died out to e^-18
        assert abs(order_one(found, name) / true - 1.0) < 2e-4, name


def test_the_force_on_the_support_is_that_of_spring_and_damper(run: xr.Dataset) -> None:
    found = record(run, [Sensor("displacement"), Sensor("velocity"), Sensor("force")], RATE, start=0.9)
    expected = STIFFNESS * found["displacement_x"] + DAMPING * found["velocity_x"]
    np.testing.assert_allclose(found["force_x"], expected, atol=1e-3 * float(expected.std()))


def test_pulses_rise_through_half_where_the_mark_passes_and_lost_ones_leave_gaps(run: xr.Dataset) -> None:
    volts = record(run, [Tacho(pulses=2, angle=30.0)], RATE)["tacho"].values
    rows = np.flatnonzero((volts[:-1] < 2.5) & (volts[1:] >= 2.5))
    crossing = (rows + (2.5 - volts[rows]) / (volts[rows + 1] - volts[rows])) / RATE
    marks = (SPEED * crossing - np.radians(30.0)) / np.pi
    np.testing.assert_allclose(marks, np.arange(rows.size), atol=1e-9)
    assert rows.size == int((SPEED * 1.6 - np.radians(30.0)) / np.pi) + 1
    lost = record(run, [Tacho(pulses=2, missing=0.2)], RATE, seed=3)["tacho"].values
    assert 0.65 < np.sum(np.diff((lost > 2.5).astype(int)) == 1) / rows.size < 0.95


def test_noise_has_the_stated_size_and_other_channels_leave_it_alone(run: xr.Dataset) -> None:
    noisy, clean = Sensor("displacement", noise="40 dB"), Sensor("displacement", name="clean")
    found = record(run, [noisy, clean], RATE, seed=5)
    noise = (found["displacement_x"] - found["clean"]).values
    assert 20.0 * np.log10(found["clean"].std() / noise.std()) == pytest.approx(40.0, abs=0.2)
    assert found["displacement_x"].attrs["uncertainty"] == pytest.approx(noise.std(), rel=0.05)
    np.testing.assert_array_equal(record(run, [noisy], RATE, seed=5)["displacement_x"], found["displacement_x"])
    assert np.std(record(run, [noisy], RATE, seed=6)["displacement_x"] - found["displacement_x"]) > 0.0
    density = record(run, [Sensor("displacement", noise_density=1e-7), clean], RATE)
    assert np.std(density["displacement_x"] - density["clean"]) == pytest.approx(1e-7 * np.sqrt(RATE / 2), rel=0.05)


def test_a_sensor_may_clip_count_in_steps_be_offset_filter_and_see_runout(run: xr.Dataset) -> None:
    plain = record(run, [Sensor("displacement")], RATE, start=0.9)
    size = abs(order_one(plain, "displacement_x"))
    one = Sensor("displacement", offset=3.0 * size, limit=3.5 * size, step=0.01 * size, sensitivity=1.1)
    values = record(run, [one], RATE, start=0.9)["displacement_x"].values
    assert values.max() == 3.5 * size
    steps = values[values < 3.5 * size] / (0.01 * size)
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)
    assert values.min() == pytest.approx(1.9 * size, abs=0.02 * size)
    corner = SPEED / (2.0 * np.pi)
    slow = record(run, [Sensor("displacement", low_pass=corner)], RATE, start=0.9)
    passed = order_one(slow.isel(time=slice(1000, None)), "displacement_x") / order_one(plain, "displacement_x")
    assert abs(passed - 1.0 / (1.0 - 1.0 + 1j * np.sqrt(2.0))) < 0.01  # Butterworth of order 2 at its corner
    rough = Sensor("displacement", direction=90.0, runout=[(1, size, 0.3)])
    added = order_one(record(run, [rough], RATE, start=0.9), "displacement_90_deg")
    smooth = order_one(record(run, [Sensor("displacement", direction=90.0)], RATE, start=0.9), "displacement_90_deg")
    assert abs((added - smooth) / size - np.exp(1j * (0.3 - np.pi / 2))) < 1e-3


def test_too_few_samples_are_refused_with_the_number_that_is_enough(run: xr.Dataset) -> None:
    thin = run.isel(time=slice(None, None, 4))
    with pytest.raises(QuestionError, match=r"kept 301 samples, too few.*Samples\((\d+)\)") as refused:
        record(thin, [Sensor("acceleration")], RATE)
    count = int(str(refused.value).split("Samples(")[1].split(")")[0])
    assert 301 < count <= 1201


def test_wrong_sensors_are_refused_with_what_there_is(run: xr.Dataset) -> None:
    with pytest.raises(QuestionError, match="its place is 'bearing', but no place of the run has a name"):
        record(run, [Sensor("displacement", place="bearing")], RATE)
    with pytest.raises(QuestionError, match="supports of the run are 'support'"):
        record(run, [Sensor("force", place="laser")], RATE)
    with pytest.raises(QuestionError, match="two channels are called 'tacho'"):
        record(run, [Tacho(), Tacho()], RATE)
    with pytest.raises(QuestionError, match=r"sample at .* Hz or faster"):
        record(run, [Tacho(pulses=100)], RATE)
    with pytest.raises(QuestionError, match="below half of the sampling rate"):
        record(run, [Sensor("displacement", low_pass="3 kHz")], RATE)
    with pytest.raises(QuestionError, match="within the samples of the run"):
        record(run, [Tacho()], RATE, start=1.0, end=2.0)
    with pytest.raises(QuestionError, match="direction: given 'up'"):
        Sensor("displacement", direction="up")


def test_a_logger_file_is_read_back_with_what_was_written(run: xr.Dataset, tmp_path: Path) -> None:
    ab.save_run(run, tmp_path / "run.nc")
    words = ["--sensor", "displacement::x:40 dB", "--sensor", "force:support:-30", "--rate", "2 kHz"]
    for name in ("logger.csv", "logger.nc"):
        words += ["--out", str(tmp_path / name)]
    answer = CliRunner().invoke(app, ["measure", "record", str(tmp_path / "run.nc"), *words])
    assert answer.exit_code == 0, answer.output
    table, whole = (ab.measure.load_signals(tmp_path / name) for name in ("logger.csv", "logger.nc"))
    assert set(table) == set(whole) == {"displacement_x", "force_support_minus_30_deg", "tacho"}
    for name in whole:
        np.testing.assert_array_equal(table[name], whole[name])
        assert table[name].attrs["quantity"] == whole[name].attrs["quantity"]
    assert whole["force_support_minus_30_deg"].attrs["direction"] == -30.0
    assert "machine" in whole.attrs


def test_a_sensor_across_a_motion_that_is_straight_reads_noise_only(run: xr.Dataset) -> None:
    straight = run.copy()
    rounding = 1e-22 * np.random.default_rng(1).standard_normal(run.sizes["time"])
    straight["y"] = (run["y"].dims, rounding, run["y"].attrs)
    found = record(straight, [Sensor("acceleration", direction="y", noise=0.01)], RATE, seed=2)
    assert float(found["acceleration_y"].std()) == pytest.approx(0.01, rel=0.05)
