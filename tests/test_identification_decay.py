"""Frequency and decay rate of a motion that was left to itself."""

import numpy as np
import pytest

from autobalancer.errors import QuestionError, RangeWarning
from autobalancer.measurement.spectrum import decay_rate

TIME = np.linspace(0.2, 3.2, 3001)
CLOCK = TIME - TIME[0]
ONE = 3e-4 * np.exp(-2.8 * CLOCK) * np.cos(60.3 * CLOCK + 0.7) + 1e-5


def test_one_oscillation_comes_back_exactly() -> None:
    found = decay_rate(TIME, ONE)
    assert found["frequency"].item() == pytest.approx(60.3, rel=1e-11)
    assert found["decay_rate"].item() == pytest.approx(2.8, rel=1e-10)
    assert found["damping_ratio"].item() == pytest.approx(2.8 / np.hypot(2.8, 60.3), rel=1e-10)
    assert found["logarithmic_decrement"].item() == pytest.approx(2.0 * np.pi * 2.8 / 60.3, rel=1e-10)
    assert found["amplitude"].item() == pytest.approx(3e-4, rel=1e-10)
    assert found["phase"].item() == pytest.approx(0.7, rel=1e-10)
    assert found.attrs["offset"] == pytest.approx(1e-5, rel=1e-8)
    np.testing.assert_allclose(found["fitted"], ONE, atol=1e-14)


def test_modes_are_told_apart_and_sorted_by_strength() -> None:
    both = ONE + 1e-4 * np.exp(-5.0 * CLOCK) * np.sin(158.0 * CLOCK)
    found = decay_rate(TIME, both, 2)
    np.testing.assert_allclose(found["frequency"], [60.3, 158.0], rtol=1e-10)
    np.testing.assert_allclose(found["decay_rate"], [2.8, 5.0], rtol=1e-9)
    assert found["amplitude"].values[0] > found["amplitude"].values[1]


def test_the_successive_maxima_fall_by_the_logarithmic_decrement() -> None:
    found = decay_rate(TIME, ONE)
    level = found["fitted"].values - found.attrs["offset"]
    tops = np.flatnonzero((level[1:-1] > level[:-2]) & (level[1:-1] > level[2:])) + 1
    ratio = np.log(level[tops[0]] / level[tops[10]]) / 10.0
    assert ratio == pytest.approx(found["logarithmic_decrement"].item(), rel=5e-3)


def test_a_growing_motion_has_a_negative_decay_rate() -> None:
    found = decay_rate(CLOCK, 1e-6 * np.exp(0.9 * CLOCK) * np.cos(40.0 * CLOCK))
    assert found["decay_rate"].item() == pytest.approx(-0.9, rel=1e-8)


def test_noise_and_spikes_stay_within_the_uncertainty() -> None:
    scores = []
    for seed in range(30):
        rng = np.random.default_rng(seed)
        noisy = ONE[::3] + 3e-6 * rng.standard_normal(1001)
        noisy[rng.integers(0, 1001, 8)] += 1e-4
        found = decay_rate(TIME[::3], noisy)
        for name, true in (("frequency", 60.3), ("decay_rate", 2.8)):
            scores.append((found[name].item() - true) / found[f"{name}_uncertainty"].item())
    assert np.abs(scores).max() < 4.0
    assert 0.5 < np.std(scores) < 1.3


def test_spikes_move_a_plain_fit_further_than_a_robust_one() -> None:
    spoiled = ONE.copy()
    spoiled[500:520] += 3e-4
    plain, robust = decay_rate(TIME, spoiled, robust=False), decay_rate(TIME, spoiled)
    errors = [abs(found["decay_rate"].item() - 2.8) for found in (plain, robust)]
    assert errors[1] < 0.1 * errors[0]


@pytest.mark.parametrize(
    ("time", "signal", "modes", "says"),
    [
        (TIME[:10], ONE[:10], 1, "at least 16"),
        (TIME, ONE[:-1], 1, "same number of both"),
        (TIME**2, ONE, 1, "equal steps"),
        (TIME, np.where(CLOCK > 1.0, np.nan, ONE), 1, "not finite"),
        (TIME, np.ones_like(TIME), 1, "constant"),
        (TIME, ONE, 0, "modes: given 0"),
        (TIME, np.exp(-CLOCK), 1, "holds 0 oscillations"),
    ],
)
def test_signals_that_say_nothing_are_refused(time: np.ndarray, signal: np.ndarray, modes: int, says: str) -> None:
    with pytest.raises(QuestionError, match=says):
        decay_rate(time, signal, modes)


def test_a_pair_of_modes_that_decay_quickly_is_found_beside_a_slow_one_in_a_long_noisy_signal() -> None:
    true = {"frequency": np.array([9.59, 23.5, 26.6]), "decay_rate": np.array([2.8, 18.0, 20.5])}
    modes = zip(*true.values(), (2.0, 0.8, 1.1), strict=True)
    clean = sum(size * np.exp(-rate * CLOCK) * np.cos(2.0 * np.pi * f * CLOCK) for f, rate, size in modes)
    for seed in range(4):
        noisy = clean + 0.02 * np.random.default_rng(seed).standard_normal(CLOCK.size)
        found = decay_rate(TIME, noisy, 3).sortby("frequency")
        assert not found.attrs["warnings"]
        off = found["frequency"].values / (2.0 * np.pi) - true["frequency"]
        assert (np.abs(off) < 4.0 * found["frequency_uncertainty"].values / (2.0 * np.pi)).all()
        assert (np.abs(found["decay_rate"] - true["decay_rate"]) < 4.0 * found["decay_rate_uncertainty"]).all()


def test_a_mode_that_is_hardly_more_than_noise_is_named() -> None:
    noisy = ONE + 1e-2 * ONE.max() * np.random.default_rng(1).standard_normal(ONE.size)
    with pytest.warns(RangeWarning, match="hardly more than noise"):
        found = decay_rate(TIME, noisy, 2)
    assert "mode 2 at" in found.attrs["warnings"]
    assert "mode 1" not in found.attrs["warnings"]
    assert not decay_rate(TIME, noisy).attrs["warnings"]


def test_amplitude_and_phase_of_a_mode_scatter_as_their_uncertainties_say() -> None:
    time, one, off = TIME[::6], ONE[::6], []
    clean = decay_rate(time, one)
    for seed in range(30):
        found = decay_rate(time, one + 0.02 * one.max() * np.random.default_rng(seed).standard_normal(one.size))
        off.append([float((found[n] - clean[n])[0] / found[f"{n}_uncertainty"][0]) for n in ("amplitude", "phase")])
    scatter = np.sqrt(np.mean(np.square(off), axis=0))
    assert (scatter > 0.6).all(), scatter  # of 30 draws; one standard deviation of the scatter is 0.13
    assert (scatter < 1.4).all(), scatter


def test_intervals_hold_the_decay_under_pink_noise() -> None:
    time, off = np.arange(3000) / 1000.0, []
    shape = np.r_[0.0, np.fft.rfftfreq(6000, 1e-3)[1:] ** -0.5]
    for seed in range(24):
        noise = np.fft.irfft(shape * np.fft.rfft(np.random.default_rng(seed).standard_normal(6000)))[:3000]
        found = decay_rate(time, np.exp(-2.0 * time) * np.cos(126.0 * time) + 0.005 * noise / noise.std())
        off.append((found["decay_rate"].item() - 2.0) / found["decay_rate_uncertainty"].item())
    assert (np.abs(off) < 1.96).mean() > 0.87
    assert np.std(off) < 1.4
