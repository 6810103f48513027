"""Tacho, angle and orders: what is found of run-ups whose motion is known."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline
from scipy.io import savemat, wavfile
from scipy.signal import lfilter

import autobalancer as ab
from autobalancer.errors import QuestionError, RangeWarning
from autobalancer.measurement.tracking import filtered_orders, passed_by_filter, subtracted

MASS, STIFFNESS, DAMPING, UNBALANCE = 12.27, 44654.0, 68.37, 594e-6  # the discoidal rig of Spannan (2021), table 6.4
RATE, GROWTH, START, LENGTH = 1000.0, 4.0, 15.0, 20.0
TIME = np.arange(int(LENGTH * RATE)) / RATE


def angle(t: np.ndarray) -> np.ndarray:
    return START * t + 0.5 * GROWTH * t**2


@pytest.fixture(scope="module")
def motion() -> np.ndarray:
    """Center of an isotropic rotor that runs up through its resonance, x + iy in m; its equation is solved to 1e-10."""

    def rates(t: float, s: np.ndarray) -> list[complex]:
        speed = START + GROWTH * t
        force = UNBALANCE * (speed**2 - 1j * GROWTH) * np.exp(1j * angle(np.asarray(t)))
        return [s[1], (force - DAMPING * s[1] - STIFFNESS * s[0]) / MASS]

    first = UNBALANCE * START**2 / (STIFFNESS - MASS * START**2 + 1j * DAMPING * START)
    start = [first + 0j, 1j * START * first]
    return solve_ivp(rates, (0.0, LENGTH), start, t_eval=TIME, rtol=1e-9, atol=1e-14, method="DOP853").y[0]


def tacho(turned: np.ndarray, pulses: int = 1) -> np.ndarray:
    """A pulse that rises through half of its height when a mark passes."""
    within = np.angle(np.exp(1j * (pulses * turned - 0.8)))
    return 5.0 / (1.0 + np.exp((np.abs(within) - 0.8) / 0.12))


def measured(values: dict[str, np.ndarray], pulses: np.ndarray | None = None) -> xr.Dataset:
    channels = {name: ab.measure.Channel(one, "displacement", direction="x") for name, one in values.items()}
    mark = tacho(angle(TIME)) if pulses is None else pulses
    return ab.measure.signals(TIME, {**channels, "tacho": ab.measure.Channel(mark, "tacho")}, origin="test")


def envelope(motion: np.ndarray, at: np.ndarray) -> np.ndarray:
    known = motion * np.exp(-1j * angle(TIME))
    return np.interp(at, TIME, known.real) + 1j * np.interp(at, TIME, known.imag)


@pytest.mark.parametrize(
    ("how", "percent", "degrees"),
    [({}, 0.2, 0.1), ({"method": "vold-kalman", "bandwidth": 6.0}, 0.2, 0.1)],
    ids=["fit", "vold-kalman"],
)
def test_orders_of_a_run_up_through_resonance_are_those_of_the_motion(
    motion: np.ndarray, how: dict[str, object], percent: float, degrees: float
) -> None:
    found = ab.measure.orders(measured({"a": motion.real}), **how)
    inner = found.isel(time=(found["speed"].values > 20.0) & (found["speed"].values < 90.0))
    ratio = inner.complex_amplitude("a") / envelope(motion, inner["time"].values)
    assert 100.0 * np.abs(np.abs(ratio) - 1.0).max() < percent
    assert np.degrees(np.abs(np.angle(ratio))).max() < degrees
    assert inner["speed"].values[np.argmax(inner["amplitude"].values)] == pytest.approx(62.0, abs=1.0)


def test_a_plain_window_flattens_a_resonance_that_the_fit_does_not(motion: np.ndarray) -> None:
    from autobalancer.measurement.tracking import fitted_orders

    centers = np.interp(np.arange(10.0, 15.0, 0.05), TIME, angle(TIME))
    known = envelope(motion, np.interp(centers, angle(TIME), TIME))
    errors = [
        np.abs(
            fitted_orders(angle(TIME), motion.real[None], np.ones(1), centers, 4.0, degree).amplitude[0, 0] / known
            - 1.0
        )
        for degree in (0, 2)
    ]
    assert errors[0].max() > 0.01
    assert errors[1].max() < 0.05 * errors[0].max()


def test_the_stated_bias_is_that_of_the_window_and_of_the_filter(motion: np.ndarray) -> None:
    for how in ({"revolutions": 9.0}, {"method": "vold-kalman", "bandwidth": 2.0}):
        found = ab.measure.orders(measured({"a": motion.real}), **how)
        found = found.isel(time=(found["speed"].values > 40.0) & (found["speed"].values < 80.0))
        real = np.abs(found.complex_amplitude("a") - envelope(motion, found["time"].values)).max()
        assert real > 1e-6
        assert float(found["bias"].max()) == pytest.approx(real, rel=0.5)


def low_passed(noise: np.ndarray, corner: float) -> np.ndarray:
    keep = np.exp(-2.0 * np.pi * corner / RATE)
    return lfilter([np.sqrt(1.0 - keep**2)], [1.0, -keep], noise)


NOISES = {  # of the repetitions, m, from white noise of deviation one
    "white": lambda one: 3e-6 * one,
    "corner at 3 Hz": lambda one: 6e-6 * low_passed(one, 3.0),
    "random walk": lambda one: 3e-7 * np.cumsum(one, axis=1),
    "hum": lambda one: 3e-6 * one + 2e-5 * np.cos(2.0 * np.pi * 16.7 * TIME + 9.0 * one[:, :1]),
    "grows": lambda one: 2e-7 * (START + GROWTH * TIME) * one,
}


@pytest.mark.filterwarnings("ignore:.*which is no order")
@pytest.mark.parametrize("how", [{}, {"method": "vold-kalman", "bandwidth": 4.0}], ids=["fit", "vold-kalman"])
@pytest.mark.parametrize("kind", NOISES)
def test_intervals_hold_the_motion_whatever_the_noise(motion: np.ndarray, kind: str, how: dict[str, object]) -> None:
    noise = NOISES[kind](np.random.default_rng(3).standard_normal((16, TIME.size)))
    found = ab.measure.orders(measured({f"n{k}": motion.real + row for k, row in enumerate(noise)}), **how)
    inside = np.array([held(found, name, envelope(motion, found["time"].values)) for name in found["channel"].values])
    assert inside.mean() >= 0.93
    if kind != "hum":  # which is a wave, so that 1.96 deviations hold it always
        assert inside.mean() <= 0.985
    assert ("n0: a vibration at about 16." in found.attrs["warnings"]) == (kind == "hum")


def held(found: xr.Dataset, name: str, known: np.ndarray) -> np.ndarray:
    """Whether amplitude and phase are within 1.96 deviations, of points with a tenth of the greatest amplitude."""
    one, large = found.sel(order=1.0, channel=name), np.abs(known) > 0.1 * np.abs(known).max()
    size = np.abs(one["amplitude"].values - np.abs(known)) / np.hypot(one["amplitude_deviation"], one["bias"]).values
    turned = np.abs(np.angle(np.exp(1j * (one["phase"].values - np.angle(known)))))
    phase = turned / np.hypot(one["phase_deviation"], one["bias"] / np.abs(known)).values
    return np.array([size, phase])[:, large] < 1.96


@pytest.mark.filterwarnings("ignore:.*which is no order")
def test_intervals_of_an_acceleration_that_became_a_displacement_hold_it(motion: np.ndarray) -> None:
    exact, rng = make_interp_spline(TIME, motion.real, k=7).derivative(2)(TIME), np.random.default_rng(4)
    values = exact + 0.02 * rng.standard_normal((16, TIME.size))
    channels = {f"n{k}": ab.measure.Channel(row, "acceleration", direction="x") for k, row in enumerate(values)}
    signals = ab.measure.signals(TIME, {**channels, "tacho": ab.measure.Channel(tacho(angle(TIME)), "tacho")})
    found = ab.measure.orders(ab.measure.converted(signals, "displacement", corner="0.5 Hz"))
    found = found.isel(time=found["speed"].values > 35.0)  # the high pass takes no more there
    inside = np.array([held(found, name, envelope(motion, found["time"].values)) for name in channels])
    assert 0.93 <= inside.mean() <= 0.985
    late = ab.measure.converted(signals.drop_vars(list(channels)[6:]), "displacement", corner="2 Hz")
    late = ab.measure.orders(late, method="vold-kalman")
    late = late.isel(time=late["time"].values > TIME[-1] - 0.1)  # the ends, which the conversion makes wrong
    ends = np.array([held(late, name, envelope(motion, late["time"].values)) for name in list(channels)[:6]])
    assert ends.mean() >= 0.93


def test_a_filter_is_as_wide_as_a_resonance_needs_and_a_narrow_one_says_what_it_takes(motion: np.ndarray) -> None:
    peak = np.abs(motion).max()
    found = ab.measure.orders(measured({"a": motion.real}), method="vold-kalman")
    assert float(found["amplitude"].max()) == pytest.approx(peak, rel=0.02)
    with pytest.warns(RangeWarning, match="a: the amplitude of order 1 .* % of the greatest; take more bandwidth"):
        narrow = ab.measure.orders(measured({"a": motion.real}), method="vold-kalman", bandwidth=1.0)
    assert float(narrow["amplitude"].max()) < 0.95 * peak
    assert float((narrow["amplitude"] + narrow["bias"]).max()) > 0.97 * peak


def test_orders_that_are_asked_for_together_do_not_disturb_one_another() -> None:
    turned = angle(TIME)
    both = 1e-5 * np.cos(turned + 0.4) + 4e-5 * np.cos(2.0 * turned - 1.1) + 2e-5 * np.cos(3.0 * turned + 2.0)
    for how in ({}, {"method": "vold-kalman", "bandwidth": 2.0}):
        found = ab.measure.orders(measured({"a": both}), (1.0, 2.0, 3.0), **how)
        inner = found.isel(time=slice(found.sizes["time"] // 10, -found.sizes["time"] // 10))
        for order, known in ((3.0, 2e-5 * np.exp(2j)), (1.0, 1e-5 * np.exp(0.4j)), (2.0, 4e-5 * np.exp(-1.1j))):
            assert np.abs(inner.complex_amplitude("a", order) / known - 1.0).max() < 3e-3


def test_an_angle_that_was_measured_needs_no_tacho() -> None:
    turned = angle(TIME)
    known = measured({"a": 1e-5 * np.cos(turned + 0.4)}).assign(rotor_angle=("time", turned))
    found = ab.measure.orders(known)
    inner = found.isel(time=slice(found.sizes["time"] // 10, -found.sizes["time"] // 10))
    assert np.abs(inner.complex_amplitude("a", 1.0) / (1e-5 * np.exp(0.4j)) - 1.0).max() < 1e-3
    np.testing.assert_allclose(inner["speed"], np.interp(inner["time"], TIME, np.gradient(turned, TIME)), rtol=1e-6)


def test_half_of_the_bandwidth_is_passed_by_three_decibels() -> None:
    t = np.arange(8000) / 1000.0
    slow = np.cos(2.0 * np.pi * t)
    inner = slice(2000, 6000)
    for poles in (1, 2, 3):
        found = (
            filtered_orders(130.0 * t, (slow * np.cos(130.0 * t))[None], np.ones(1), 2.0, 1000.0, poles)
            .amplitude[0, 0]
            .real
        )
        assert found[inner] @ slow[inner] / (slow[inner] @ slow[inner]) == pytest.approx(2.0**-0.5, rel=0.01)
        assert passed_by_filter(np.array([0.0, 1.0, -1.0]), 2.0, 1000.0, poles) == pytest.approx(
            [1.0, 2.0**-0.5, 2.0**-0.5]
        )


def test_runout_is_told_from_unbalance_by_its_growth_with_the_speed(motion: np.ndarray) -> None:
    runout = 12e-6 * np.exp(0.9j)
    seen = motion.real + (runout * np.exp(1j * angle(TIME))).real
    found = ab.measure.orders(measured({"a": seen}), slow_roll=(0.0, 5.0))
    assert float(found["runout_amplitude"][0, 0]) == pytest.approx(12e-6, rel=0.04)
    assert float(found["runout_phase"][0, 0]) == pytest.approx(0.9, abs=0.08)
    for end, most in (
        (2.5, 1e-5),
        (3.5, 3e-6),
        (5.0, 2e-6),
    ):  # the mean, with the second, with the fourth power of the speed
        left = ab.measure.orders(measured({"a": seen}), slow_roll=(0.0, end))
        off = left["runout_amplitude"] * np.exp(1j * left["runout_phase"]) - runout
        assert float(np.abs(off)[0, 0]) < 1.5 * float(left["runout_deviation"][0, 0]) < 1.5 * most
    late = found.isel(time=found["speed"].values > 85.0)
    assert np.abs(late.complex_amplitude("a") / envelope(motion, late["time"].values) - 1.0).max() < 0.012
    again = ab.measure.orders(
        measured({"a": seen}), slow_roll=ab.measure.orders(measured({"a": seen})).isel(time=slice(40))
    )
    assert float(again["runout_amplitude"][0, 0]) == pytest.approx(12e-6, rel=0.08)


@pytest.fixture(scope="module")
def held_slowly() -> tuple[xr.Dataset, complex, np.ndarray]:
    """Orders of 4 s at 200 rpm and a run-up by 55 rpm/s, with run-out and unbalance; the run-out, and the vibration."""
    t, slow, runout = np.arange(10_000) / 1e3, 200.0 * np.pi / 30.0, 6e-6 * np.exp(0.7j)
    since = np.maximum(0.0, t - 4.0)
    speed, turned = slow + 5.76 * since, slow * t + 2.88 * since**2
    vibration = UNBALANCE * speed**2 / (157e3 - MASS * speed**2 + 1j * DAMPING * speed)  # 1080 rpm; 1.7 um at 200 rpm
    seen = ((runout + vibration) * np.exp(1j * turned)).real
    noise = 2e-6 * np.random.default_rng(0).standard_normal((8, t.size))
    channels = {f"n{k}": ab.measure.Channel(seen + row, "displacement") for k, row in enumerate(noise)}
    signals = ab.measure.signals(t, {**channels, "tacho": ab.measure.Channel(tacho(turned), "tacho")})
    orders = ab.measure.orders(signals)
    at = orders["time"].values
    return orders, runout, np.interp(at, t, vibration.real) + 1j * np.interp(at, t, vibration.imag)


@pytest.mark.parametrize("slow_roll", ["0:4 s", "1:3 s", "own measurement"])
@pytest.mark.parametrize("jumps", [False, True])
def test_vibration_at_a_steady_slow_roll_is_told_by_the_next_speeds(
    held_slowly: tuple[xr.Dataset, complex, np.ndarray], slow_roll: str, jumps: bool
) -> None:
    orders, runout, vibration = held_slowly
    still = orders.isel(time=orders["time"].values < 3.5)
    kept = (orders["time"].values < 3.5) | (orders["speed"].values > 45.0 * jumps)
    found = subtracted(orders.isel(time=kept), still if slow_roll == "own measurement" else slow_roll)
    off = (found["runout_amplitude"] * np.exp(1j * found["runout_phase"])).values - runout
    stated = found["runout_deviation"].values
    assert (np.abs(off) < 1.96 * np.sqrt(2.0) * stated).all()
    assert (stated < 2.2e-6).all()  # the vibration there, 1.7 um, and what the next speed has grown beyond the square
    amplitude = (found["amplitude"] * np.exp(1j * found["phase"])).values - vibration[kept]
    deviation = np.hypot(found["amplitude_deviation"], found["bias"]).values
    assert np.mean([np.abs(part) < 1.96 * deviation for part in (amplitude.real, amplitude.imag)]) > 0.93
    if not jumps:  # the vibration there, 1.7 um, is no part of the run-out any more
        assert (np.abs(off) < 0.5e-6).all()
        assert "with the growth of the vibration up to 33" in found.attrs["runout"]


def test_an_interval_in_which_vibration_would_be_taken_for_runout_is_refused(
    held_slowly: tuple[xr.Dataset, complex, np.ndarray],
) -> None:
    orders = held_slowly[0]
    fast = r"from 8 s to 9 s the rotor turns at 4.* rpm, but at 199.* rpm .* from 0.* s to .* s: .* give this interval"
    with pytest.raises(QuestionError, match=fast):
        subtracted(orders, "8:9 s")
    with pytest.raises(QuestionError, match=r"turns at 4.* rpm, but at 199.* rpm and little more"):
        subtracted(orders, orders.isel(time=orders["time"].values > 8.0))
    still = orders.isel(time=orders["time"].values < 3.5)
    with pytest.raises(QuestionError, match=r"at 200 rpm, and the record goes to 200.* rpm: vibration cannot be told"):
        subtracted(still, "0:3 s")


def test_what_a_tacho_that_stops_leaves_out_is_said() -> None:
    turned, still = angle(TIME), (TIME < 3.0) | (TIME > 15.0)
    with pytest.warns(RangeWarning) as told:
        found = ab.measure.rotor_angle(measured({}, np.where(still, 0.0, tacho(turned))))
    words = "\n".join(str(one.message) for one in told)
    assert re.search(r"first pulse comes at 3 s; the 3 s before it, 15 % of the record, are left out", words)
    assert re.search(r"last pulse comes at 1[45]\.\d+ s; the 5\.\d+ s after it, 25\.\d %", words)
    assert words in found.attrs["warnings"]
    assert not ab.measure.rotor_angle(measured({})).attrs["warnings"]


@pytest.mark.filterwarnings("ignore:tacho. none of its 6 pulses")
@pytest.mark.parametrize("pulses", [1, 6])
def test_the_angle_of_a_tacho_is_that_of_the_rotor(pulses: int) -> None:
    found = ab.measure.rotor_angle(measured({}, tacho(angle(TIME), pulses)), pulses=pulses)
    error = found["rotor_angle"].values - angle(found["time"].values)
    error -= 2.0 * np.pi / pulses * np.round(error.mean() / (2.0 * np.pi / pulses))
    assert np.degrees(np.abs(error).max()) < 0.3
    assert np.abs(found["speed"].values - START - GROWTH * found["time"].values)[5:-5].max() < 0.3
    turned = ab.measure.rotor_angle(measured({}, tacho(angle(TIME), pulses)), pulses=pulses, tacho_angle="90 deg")
    assert (turned["rotor_angle"] - found["rotor_angle"]).values == pytest.approx(np.pi / 2)


def test_an_encoder_needs_an_index_to_know_the_zero_mark() -> None:
    late = angle(TIME) - 2.0  # so that the first pulse is not that of the zero mark
    channels = {"tacho": ab.measure.Channel(tacho(late, 6), "tacho"), "z": ab.measure.Channel(tacho(late), "voltage")}
    signals = ab.measure.signals(TIME, channels)
    found = ab.measure.rotor_angle(signals, pulses=6, index="z")
    error = np.angle(np.exp(1j * (found["rotor_angle"].values - np.interp(found["time"].values, TIME, late))))
    assert np.degrees(np.abs(error).max()) < 0.5
    with pytest.warns(RangeWarning, match="none of its 6 pulses a turn is known to be the zero mark"):
        unknown = ab.measure.rotor_angle(signals, pulses=6)
    assert np.ptp((unknown["rotor_angle"] - found["rotor_angle"]).values) < 1e-9
    with pytest.raises(QuestionError, match="come at many angles"):
        ab.measure.rotor_angle(signals, pulses=5, index="z")


def test_jitter_of_pulses_is_smoothed_and_the_angle_says_how_sure_it_is() -> None:
    from autobalancer.measurement.tacho import smooth_angle

    counts = np.arange(120.0)
    exact = (-START + np.sqrt(START**2 + 4.0 * np.pi * GROWTH * counts)) / GROWTH
    errors, stated = [], []
    for seed in range(12):
        jittered = exact + 4e-4 * np.random.default_rng(seed).standard_normal(counts.size)
        smooth = smooth_angle(jittered, 2.0 * np.pi * counts)
        assert smooth.jitter == pytest.approx(4e-4, rel=0.25)
        errors.append(smooth.spline(exact) - 2.0 * np.pi * counts)
        stated.append(smooth.deviation(exact))
    raw = 4e-4 * (START + GROWTH * exact)
    assert np.sqrt((np.array(errors) ** 2).mean()) < 0.5 * np.sqrt((raw**2).mean())
    assert np.sqrt((np.array(errors) ** 2).mean()) == pytest.approx(np.sqrt((np.array(stated) ** 2).mean()), rel=0.3)


def test_missing_and_double_pulses_are_told_with_their_times_and_repaired() -> None:
    good = tacho(angle(TIME))
    instants = [np.interp(2.0 * np.pi * k, angle(TIME), TIME) for k in (20, 21, 50, 70)]
    bad = good.copy()
    for instant in (instants[0], instants[1], instants[2]):
        bad[np.abs(TIME - instant - 0.02) < 0.05 * (instant < 20.0)] = 0.0
    bad[np.abs(TIME - instants[3] - 0.0525) < 0.003] = 5.0
    with pytest.warns(RangeWarning, match=r"tacho: 3 missing after .* 1 too many at"):
        found = ab.measure.rotor_angle(measured({}, bad))
    clean = ab.measure.rotor_angle(measured({}, good))
    assert found["rotor_angle"].values == pytest.approx(clean["rotor_angle"].values, abs=0.02)
    assert len(found.attrs["missing_pulses"]) == 2, "two in line are one place"
    assert found.attrs["extra_pulses"] == pytest.approx([instants[3] + 0.05], abs=2e-3)
    with pytest.raises(QuestionError, match="3 missing after"):
        ab.measure.rotor_angle(measured({}, bad), repair=False)


def test_a_rotor_that_starts_from_rest_misses_no_pulse() -> None:
    from autobalancer.measurement.tacho import repaired

    times = np.sqrt(np.arange(1.0, 60.0))
    found = repaired(times)
    assert found.counts.tolist() == list(range(59))
    assert not found.missing.size


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"tacho": "b"}, "no channel 'b'; there are a, tacho"),
        ({"pulses": 0}, "whole number from 1"),
        ({"edge": "both"}, "must be 'rising' or 'falling'"),
        ({"orders": 0.0}, "numbers above zero"),
        ({"orders": 60.0}, "beyond half of the sampling rate"),
        ({"revolutions": 500.0}, "were measured"),
        ({"method": "fft"}, "'fit' or 'vold-kalman'"),
        ({"channels": "tacho"}, "vibration: given 'tacho'; must be 'a'"),
        ({"slow_roll": (30.0, 40.0)}, "0 points from 30 s to 40 s"),
        ({"threshold": 9.0}, "no pulse crosses the threshold; the signal is between"),
    ],
)
def test_an_impossible_question_is_refused(motion: np.ndarray, change: dict[str, object], words: str) -> None:
    with pytest.raises(QuestionError, match=words):
        ab.measure.orders(measured({"a": motion.real}), **change)


def test_orders_are_kept_in_a_file_and_drawn(motion: np.ndarray, tmp_path: Path) -> None:
    found = ab.measure.orders(measured({"a": motion.real}), (1.0, 2.0))
    ab.save_run(found, tmp_path / "o.nc")
    again = ab.load_run(tmp_path / "o.nc")
    assert type(again) is type(found)
    assert repr(again) == repr(found)
    figure = ab.plot.orders(tmp_path / "o.nc", over="time")
    assert len(figure.axes[0].get_lines()) == 2
    with pytest.raises(QuestionError, match="speed' or 'time"):
        ab.plot.orders(found, over="order")


@pytest.fixture
def by_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Records of more than 3000 samples stay in their files, of which 1500 samples are in memory at once."""
    from autobalancer.files import text_files as table
    from autobalancer.measurement import load_signals as load
    from autobalancer.measurement import signal_formats as formats
    from autobalancer.measurement import tacho as angles
    from autobalancer.results import signals
    from autobalancer.results import signals as universal_file

    for module in (signals, formats, load, universal_file, angles):
        monkeypatch.setattr(module, "LONG", 3000)
    monkeypatch.setattr(formats, "LONG_TABLE", 3000)
    monkeypatch.setattr(table, "PIECE", 100_000)
    monkeypatch.setattr(signals, "BLOCK", 1500)
    monkeypatch.setattr(angles, "BLOCK", 1500)
    monkeypatch.setattr(load, "BLOCK", 1500)


def long_record(path: Path, motion: np.ndarray) -> Path:
    """The same record as a file of each kind that need not be brought into memory as a whole."""
    values = {"x [m]": motion.real, "y [m]": motion.imag, "tacho [V]": tacho(angle(TIME))}
    if path.suffix == ".npz":
        (np.savez_compressed if path.stem == "packed" else np.savez)(path, time=TIME, **values)
    elif path.suffix == ".mat":
        savemat(path, {"time": TIME, **{name.split()[0]: v for name, v in values.items()}}, do_compression=True)
        path.with_suffix(".channels.toml").write_text(
            "".join(f'[channels.{name.split()[0]}]\nunit = "{name.split()[1][1:-1]}"\n' for name in values)
        )
    elif path.suffix == ".csv":
        rows = np.column_stack([TIME, *values.values()])
        np.savetxt(path, rows, "%.17g", ",", header=",".join(["time [s]", *values]), comments="")
    elif path.suffix == ".wav":
        rows = np.stack([1e3 * motion.real, 1e3 * motion.imag, 0.1 * values["tacho [V]"]], axis=1)
        wavfile.write(path, int(RATE), rows)
        words = [("x", "displacement", "1 mm"), ("y", "displacement", "1 mm"), ("tacho", "tacho", "10 V")]
        path.with_suffix(".channels.toml").write_text(
            "".join(
                f'[channels.{name}]\ncolumn = "{k}"\nquantity = "{kind}"\nfull_scale = "{full}"\n'
                for k, (name, kind, full) in enumerate(words, 1)
            )
        )
    elif path.suffix == ".h5":
        h5py = pytest.importorskip("h5py")
        with h5py.File(path, "w") as file:
            file["rate"] = RATE
            for name, numbers in values.items():
                file[name.split()[0]] = numbers
                file[name.split()[0]].attrs["units"] = name.split()[1][1:-1]
    else:
        lines = [f"{'':4}-1", f"{58:6}b{1:6}{2:6}{11:12}{8 * TIME.size:12}{0:6}{0:6}{0:12}{0:12}"]
        blocks = []
        for name, numbers in values.items():
            short, kind = name.split()[0], "tacho" if name[0] == "t" else "displacement"
            words = [short, "NONE", "NONE", "NONE", f"autobalancer {kind} {short.removesuffix('tacho')}"]
            shape = f"{4:10}{TIME.size:10}{1:10}{0.0:13.5E}{1.0 / RATE:13.5E}{0.0:13.5E}"
            axes = [
                f"{code:10}{0:5}{0:5}{0:5} {what:<20} {unit:<20}"
                for code, what, unit in (
                    (17, "time", "s"),
                    (0, kind, name.split()[1][1:-1]),
                    (0, "NONE", "NONE"),
                    (0, "NONE", "NONE"),
                )
            ]
            node = f"{1:5}{0:10}{1:5}{0:10} {'A':<10}{0:4} {'NONE':<10}{0:4}"
            head = "\n".join([*lines, *words, node, shape, *axes]) + "\n"
            blocks.append(head.encode() + numbers.astype("<f8").tobytes() + b"\n    -1\n")
        path.write_bytes(b"".join(blocks))
    return path


@pytest.mark.parametrize("name", ["a.npz", "packed.npz", "a.wav", "a.h5", "a.uff", "a.csv", "a.mat"])
def test_a_long_record_stays_in_its_file_and_gives_the_same_orders_and_maps(
    motion: np.ndarray, tmp_path: Path, request: pytest.FixtureRequest, name: str
) -> None:
    file = long_record(tmp_path / name, motion)

    def asked() -> list[xr.Dataset]:
        turned = ab.measure.rotor_angle(ab.measure.load_signals(file))
        over = ("order", "frequency") if name == "a.h5" else ()  # maps read as orders do
        maps = [ab.measure.order_map(turned, "x", over=one, revolutions=8.0) for one in over]
        return [turned, ab.measure.orders(turned, (1, 2)), *maps]

    whole = asked()
    request.getfixturevalue("by_blocks")
    parts = asked()
    assert not parts[0]["x"]._in_memory
    assert not parts[0]["speed"]._in_memory
    for one, other in zip(whole, parts, strict=True):
        for name in one.variables:
            if one[name].dtype.kind == "f":
                scale = float(np.abs(one[name].values).max())
                away = (
                    np.abs(np.exp(1j * one[name].values) - np.exp(1j * other[name].values))
                    if name == "phase"
                    else (np.abs(one[name].values - other[name].values) / scale)
                )
                near = (
                    one["amplitude"].values > 1e-2 * np.abs(one["amplitude"].values).max() if name == "phase" else True
                )
                assert (away * near).max() < 1e-10, name  # splines and least squares: their condition times 1e-16
    assert str(whole[0].columns()[4].values[0])[:9] == str(parts[0].columns()[4].values[0])[:9]


def test_a_slower_rate_changes_filtered_orders_of_a_long_record_by_less_than_a_thousandth(
    motion: np.ndarray, by_blocks: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    from autobalancer.measurement import tracking as question

    turned = ab.measure.rotor_angle(measured({"a": motion.real}))
    fast = ab.measure.orders(turned, method="vold-kalman", bandwidth=4.0)
    monkeypatch.setattr(question, "LONG", 3000)
    monkeypatch.setattr(question, "REACH", 2.0)  # so that 90 rad/s need not the whole rate of 1 kHz
    slow = ab.measure.orders(turned, method="vold-kalman", bandwidth=4.0)
    assert "of the signals at" in slow.attrs["method"]
    at = slow["time"].values
    inner = (at > at[0] + 0.5) & (at < at[-1] - 0.5)
    known = np.interp(at, fast["time"].values, fast["amplitude"].values[0, 0])
    assert np.abs(slow["amplitude"].values[0, 0] - known)[inner].max() < 1e-3 * known.max()
