"""Spectra, maps, integration, damping and orbits of signals whose motion is known."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli.main import app
from autobalancer.errors import QuestionError
from autobalancer.measurement.spectrum import detect_lines

RATE = 1000.0
TIME = np.arange(12000) / RATE
SPEED = 62.0  # rad/s
BALLS = 53.0  # as in Spannan (2021), figure 6.22


def measured(quantity: str = "displacement", **values: np.ndarray) -> xr.Dataset:
    size = next(iter(values.values())).size
    channels = {name: ab.measure.Channel(one, quantity, direction=name[:1]) for name, one in values.items()}
    return ab.measure.signals(np.arange(size) / RATE, channels, origin="test")


def turning(signals: xr.Dataset, angle: np.ndarray) -> xr.Dataset:
    channel = ab.measure.Channel(angle, "angle")
    whole = {
        str(n): ab.measure.Channel(v.values, v.attrs["quantity"], "", v.attrs["direction"]) for n, v in signals.items()
    }
    return ab.measure.rotor_angle(ab.measure.signals(signals["time"].values, {**whole, "angle": channel}))


@pytest.mark.parametrize("window", ["hann", "flattop", "blackmanharris", "boxcar"])
def test_a_line_has_its_amplitude_and_frequency_wherever_it_falls(window: str) -> None:
    for hertz in (50.0, 50.21, 50.37, 50.5):
        found = ab.measure.spectrum(
            measured(x=3e-5 * np.cos(2.0 * np.pi * hertz * TIME)), window=window, resolution="1 Hz"
        )
        k = int(np.argmax(found["line_amplitude"].values))
        assert float(found["line_frequency"][k]) / (2.0 * np.pi) == pytest.approx(hertz, abs=0.01)
        assert float(found["line_amplitude"][k]) == pytest.approx(3e-5, rel=5e-3)


def test_the_density_of_white_noise_is_its_variance_over_half_of_the_rate() -> None:
    noise = np.random.default_rng(2).standard_normal(TIME.size)
    for window in ("hann", "flattop"):
        found = ab.measure.spectrum(measured(x=1e-3 * noise), window=window, resolution="4 Hz")
        inner = found["density"].values[0, 3:-3]
        assert inner.mean() == pytest.approx(1e-6 / (0.5 * RATE), rel=0.05)
        assert inner.std() / inner.mean() == pytest.approx(found.attrs["density_deviation"], rel=0.35)
    assert not found.sizes["line"]


def test_lines_of_balls_that_do_not_turn_with_the_rotor_are_named() -> None:
    parts = ((1.0, SPEED), (0.8, BALLS), (0.1, 2.0 * SPEED), (0.05, 2.0 * SPEED - BALLS))
    x = 1e-5 * sum(size * np.cos(w * TIME) for size, w in parts)
    found = ab.measure.spectrum(turning(measured(x=x), SPEED * TIME), resolution="0.2 Hz", natural=[BALLS + 0.5])
    names = dict(zip(np.round(found["line_frequency"].values).tolist(), found["line_name"].values, strict=True))
    assert names[62] == "order 1"
    assert names[124] == "order 2"
    assert names[53].startswith("subsynchronous, 0.855 of the speed: balls that turn at 53 rad/s, or a whirl")
    assert names[53].endswith("near the natural frequency 53.5 rad/s")
    assert names[71] == "mirror of the subsynchronous line"
    assert found.attrs["speed"] == pytest.approx(SPEED)


@pytest.mark.parametrize(("window", "resolution"), [("hann", 0.5), ("hann", 2.0), ("flattop", 0.5), ("boxcar", 0.5)])
def test_frequency_and_amplitude_of_a_line_scatter_as_their_deviations_say(window: str, resolution: float) -> None:
    random, time = np.random.default_rng(5), TIME[:2000]
    off = []
    for _ in range(60):
        hertz = random.uniform(50.0, 52.0)
        x = np.cos(2.0 * np.pi * hertz * time + random.uniform(0.0, 6.0)) + 0.1 * random.standard_normal(time.size)
        found = ab.measure.spectrum(measured(x=1e-5 * x), window=window, resolution=f"{resolution} Hz")
        one = found.isel(line=int(np.argmax(found["line_amplitude"].values)))
        of_frequency = float(one["line_frequency"] - 2.0 * np.pi * hertz) / float(one["line_frequency_deviation"])
        off.append((of_frequency, float(one["line_amplitude"] - 1e-5) / float(one["line_amplitude_deviation"])))
    scatter = np.sqrt(np.mean(np.square(off), axis=0))
    if window != "boxcar":  # its leakage counts as noise
        assert (scatter > 0.7).all(), scatter  # 60 draws: one standard deviation of the scatter is 0.09
    assert (scatter < 1.4).all(), scatter


def test_the_lowest_frequencies_of_noise_have_no_more_lines_than_the_others() -> None:
    random, weights = np.random.default_rng(3), np.hanning(401)[:-1]
    frequency, low, all_lines = np.arange(201.0), 0, 0
    for _ in range(800):
        x = random.standard_normal(400)
        seen = np.abs(np.fft.rfft((x - x.mean()) * weights))
        at = detect_lines(frequency, seen, weights).frequency
        low, all_lines = low + int((at < 20.0).sum()), all_lines + at.size
    assert low <= 3 + 3 * all_lines // 10  # a tenth of all is expected


def test_side_lines_of_balls_that_beat_with_the_unbalance_are_named() -> None:
    apart = SPEED - BALLS
    parts = ((1.0, SPEED), (0.8, BALLS), (0.1, SPEED + apart), (0.05, SPEED - 2.0 * apart), (0.05, SPEED + 2.0 * apart))
    x = 1e-5 * sum(size * np.cos(w * TIME) for size, w in parts)
    found = ab.measure.spectrum(turning(measured(x=x), SPEED * TIME), resolution="0.2 Hz")
    assert [str(name).split(",")[0] for name in found["line_name"].values] == [
        "speed - 2 times its difference from that line",
        "subsynchronous",
        "order 1",
        "mirror of the subsynchronous line",
        "speed + 2 times its difference from that line",
    ]


def test_an_order_is_a_line_of_the_order_map_and_a_natural_frequency_of_the_other() -> None:
    angle = 40.0 * TIME + 4.0 * TIME**2
    signals = turning(measured(x=1e-5 * np.cos(2.0 * angle) + 1e-5 * np.cos(300.0 * TIME)), angle)
    orders = ab.measure.order_map(signals, revolutions=12)
    assert orders["amplitude"].sel(order=2.0).values == pytest.approx(1e-5, rel=0.06)
    other = ab.measure.order_map(signals, over="frequency", highest=500.0)
    near = other["amplitude"].sel(frequency=300.0, method="nearest")
    assert near.values == pytest.approx(1e-5, rel=0.5)
    assert np.ptp(orders["speed"].values) > 50.0
    assert ab.plot.order_map(orders).axes
    assert ab.plot.order_map(other).axes
    with pytest.raises(QuestionError, match="were measured"):
        ab.measure.order_map(signals, revolutions=1000)


def test_acceleration_becomes_displacement_and_back_without_a_shift_of_the_phase() -> None:
    w = 2.0 * np.pi * 25.0
    x = 2e-4 * np.cos(w * TIME + 0.3)
    drift = -(w**2) * x + 0.5 + 0.02 * TIME
    inner = slice(3000, -3000)
    for to, known in (("displacement", x), ("velocity", -2e-4 * w * np.sin(w * TIME + 0.3))):
        found = ab.measure.converted(measured("acceleration", x=drift), to, corner="2 Hz")
        assert found["x"].values[inner] == pytest.approx(known[inner], abs=2e-3 * np.abs(known).max())
        assert found["x"].attrs["quantity"] == to
        assert found["x"].attrs["corner"] == pytest.approx(2.0)
    back = ab.measure.converted(measured(x=x), "acceleration")
    assert back["x"].values[inner] == pytest.approx(-(w**2) * x[inner], abs=1e-3 * 2e-4 * w**2)
    with pytest.raises(QuestionError, match="corner: missing; to make a displacement of the acceleration 'x'"):
        ab.measure.converted(measured("acceleration", x=drift), "displacement")


def test_the_command_writes_a_displacement_that_other_commands_read(tmp_path: Path) -> None:
    acceleration, moved = tmp_path / "acceleration.nc", tmp_path / "moved.nc"
    ab.save_run(measured("acceleration", x=-5.0 * np.cos(200.0 * TIME)), acceleration)
    words = ["measure", "signals", str(acceleration), "--to", "displacement", "--out", str(moved)]
    missing = CliRunner().invoke(app, words)
    assert missing.exit_code == 2
    assert "corner: missing" in missing.output
    assert CliRunner().invoke(app, [*words, "--corner", "2 Hz"]).exit_code == 0
    inner = slice(3000, -3000)
    assert ab.measure.load_signals(moved)["x"].values[inner] == pytest.approx(
        1.25e-4 * np.cos(200.0 * TIME[inner]), abs=1e-6
    )
    alone = CliRunner().invoke(app, ["measure", "signals", str(acceleration), "--corner", "2 Hz"])
    assert alone.exit_code == 2
    assert "--to" in alone.output


def test_damping_at_forty_decibels_is_within_one_percent_and_its_deviation_is_that_of_repetitions() -> None:
    t, w, ratio = np.arange(1500) / RATE, 60.3, 0.046
    decay = np.exp(-ratio * w * t) * np.cos(w * np.sqrt(1.0 - ratio**2) * t)
    errors, stated = [], []
    for seed in range(20):
        noise = 0.01 / np.sqrt(2.0) * np.random.default_rng(seed).standard_normal(t.size)
        found = ab.measure.damping(measured("acceleration", x=decay + noise), robust=False)
        errors.append(float(found["damping_ratio"][0]) / ratio - 1.0)
        stated.append(float(found["damping_ratio_uncertainty"][0]) / ratio)
    assert np.abs(errors).max() < 0.01
    assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(np.mean(stated), rel=0.4)
    assert len(ab.plot.answer(found).axes) == 2
    begin = float(found["time"][0])
    assert found.attrs["title"].endswith(f"amplitude and phase at {begin:.5g} s")
    assert f"{found.sizes['time']} values over time" in repr(found)


def test_a_spectrum_says_why_its_lines_have_no_order() -> None:
    found = ab.measure.spectrum(measured(x=1e-5 * np.cos(300.0 * TIME)), resolution="1 Hz")
    assert "not known or not steady" in dict(found.facts())["speed"]


def test_a_vibration_that_is_driven_is_not_taken_for_a_decay_in_silence() -> None:
    time, random = np.arange(4000) / RATE, np.random.default_rng(5)
    noise = 0.01 * random.standard_normal(time.size)
    decay = np.exp(-2.0 * time) * np.cos(60.0 * time)
    kinds = {"": decay, "in waves": decay + 0.3 * np.cos(90.0 * time), "is driven": np.cos(60.0 * time)}
    for said, values in kinds.items():
        warned = ab.measure.damping(measured("acceleration", x=values + noise)).attrs["warnings"]
        assert said in warned
        assert bool(warned) == bool(said)


def test_half_of_the_power_gives_the_damping_of_a_slow_run_up_and_warns_of_a_fast_one() -> None:
    ratio, natural = 0.03, 60.0
    w = np.linspace(45.0, 75.0, 600)
    answer = w**2 / (natural**2 - w**2 + 2j * ratio * natural * w)
    size = np.abs(answer)[None, None]
    for duration, words in ((6000.0, ""), (2.0, "the run-up is fast")):
        dims = ("order", "channel", "time")
        entries = {
            name: (dims, one * size)
            for name, one in (("amplitude", 1.0), ("phase", 0.0), ("amplitude_deviation", 1e-3))
        }
        coords = {"order": [1.0], "channel": ["x"], "time": np.linspace(0.0, duration, 600), "speed": ("time", w)}
        from autobalancer.results.signals import Orders

        found = ab.measure.half_power(Orders.of(xr.Dataset({**entries, "phase_deviation": entries["phase"]}, coords)))
        assert float(found["damping_ratio"]) == pytest.approx(ratio, rel=0.01)
        assert words in found.attrs["warnings"]
        assert bool(found.attrs["warnings"]) == bool(words)


def test_an_orbit_is_the_ellipse_of_its_forward_and_backward_circle() -> None:
    angle = SPEED * TIME
    z = 3e-5 * np.exp(1j * (angle + 0.4)) + 1e-5 * np.exp(-1j * (angle - 1.0)) + 4e-6 * np.exp(2j * angle)
    found = ab.measure.orbit(turning(measured(x=z.real, y=z.imag), angle), at=5.0)
    assert found["forward"].values == pytest.approx([3e-5, 4e-6], rel=1e-3)
    assert found["backward"].values == pytest.approx([1e-5, 0.0], abs=1e-8)
    assert found["semi_minor"].values == pytest.approx([2e-5, 4e-6], rel=1e-3)
    assert float(found["tilt"][0]) == pytest.approx(0.5 * (0.4 + 1.0), abs=1e-3)
    whole = sum(found["filtered_x"].values[k] + 1j * found["filtered_y"].values[k] for k in range(2))
    assert np.abs(whole[0] - (3e-5 * np.exp(0.4j) + 1e-5 * np.exp(1j) + 4e-6)) < 1e-8
    assert ab.plot.answer(found).axes
    with pytest.raises(QuestionError, match="it must be from"):
        ab.measure.orbit(turning(measured(x=z.real, y=z.imag), angle), at=0.1)
    with pytest.raises(QuestionError, match="no displacement; bring velocities or accelerations"):
        ab.measure.orbit(turning(measured("velocity", x=z.real, y=z.imag), angle), at=5.0)


@pytest.mark.parametrize(("first", "second"), [(45.0, 135.0), (-45.0, 45.0), (90.0, 0.0), (20.0, 80.0)])
def test_the_orbit_of_probes_that_look_anywhere_is_that_along_the_axes(first: float, second: float) -> None:
    angle = SPEED * TIME
    z = 3e-5 * np.exp(1j * (angle + 0.4)) + 1e-5 * np.exp(-1j * (angle - 1.0))
    seen = {
        name: ab.measure.Channel((z * np.exp(-1j * np.radians(way))).real, "displacement", "A", way)
        for name, way in (("one", first), ("other", second))
    }
    signals = turning(ab.measure.signals(TIME, seen), angle)
    right = (second - first) % 360.0 == 90.0
    names = {} if right else {"x": "one", "y": "other"}
    found = ab.measure.orbit(signals, **names, at=5.0, orders=(1.0,))
    assert (found["forward"].item(), found["backward"].item()) == pytest.approx((3e-5, 1e-5), rel=1e-3)
    assert found["tilt"].item() == pytest.approx(0.5 * (0.4 + 1.0), abs=1e-3)
    chosen = ab.measure.orbit(signals, x="one", y="other", at=5.0, orders=(1.0,))
    np.testing.assert_allclose(chosen["x"], found["x"], atol=1e-12)


def test_an_orbit_offers_only_pairs_that_it_takes() -> None:
    wave = 1e-5 * np.cos(SPEED * TIME)
    ways: dict[str, str | float] = {"a": 10.0, "b": 12.0, "c": "", "d": 100.0, "e": "x", "f": "y"}
    channels = {name: ab.measure.Channel(wave, "displacement", "B" * (name in "ef"), way) for name, way in ways.items()}
    signals = turning(ab.measure.signals(TIME, channels), SPEED * TIME)
    with pytest.raises(QuestionError, match=r"several pairs .* x='a', y='d' or x='b', y='d' or x='e', y='f'"):
        ab.measure.orbit(signals)
    assert ab.measure.orbit(signals, x="a").attrs["title"].startswith("orbit of a and d")
    with pytest.raises(QuestionError, match="a and b look along 10 and 12 deg, nearly one line"):
        ab.measure.orbit(signals, x="a", y="b")
    with pytest.raises(QuestionError, match=r"no two displacements at right angles .* c \(no direction\)"):
        ab.measure.orbit(signals.drop_vars(["d", "e", "f"]))


def test_spectra_are_kept_in_files_and_questions_without_an_answer_refused(tmp_path: Path) -> None:
    signals = measured(x=1e-5 * np.cos(300.0 * TIME))
    found = ab.measure.spectrum(signals)
    ab.save_run(found, tmp_path / "s.nc")
    assert repr(ab.load_run(tmp_path / "s.nc")) == repr(found)
    assert ab.plot.spectrum(tmp_path / "s.nc", log=False).axes
    for change, words in (
        ({"window": "kaiser"}, "must be 'hann'"),
        ({"resolution": "0.01 Hz"}, "the signals have 12 s"),
    ):
        with pytest.raises(QuestionError, match=words):
            ab.measure.spectrum(signals, **change)
    with pytest.raises(QuestionError, match="with the quantity tacho or angle there is none"):
        ab.measure.order_map(signals)


def test_the_envelope_of_a_run_up_holds_the_wave_and_its_speed() -> None:
    angle = 40.0 * TIME + 4.0 * TIME**2
    size = 1e-5 * (1.0 + 0.2 * TIME)
    found = ab.measure.envelope(turning(measured(x=size * np.cos(angle)), angle))
    middle = found["envelope_time"].values
    assert found["envelope_high"].values[0] == pytest.approx(1e-5 * (1.0 + 0.2 * middle), rel=0.03)
    assert found["envelope_low"].values[0] == pytest.approx(-1e-5 * (1.0 + 0.2 * middle), rel=0.03)
    assert found["envelope_speed"].values == pytest.approx(40.0 + 8.0 * found["envelope_end"].values, abs=0.02)
    assert np.diff(found["envelope_end"].values)[0] > 1.8 * np.diff(found["envelope_end"].values)[-1]
    with pytest.raises(QuestionError, match="give bin_length"):
        ab.measure.envelope(measured(x=size))
    assert ab.measure.envelope(measured(x=size), bin_length="0.5 s").sizes["bin"] == 23
