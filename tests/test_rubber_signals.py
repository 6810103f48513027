"""Rubber from recorded force and deflection: loops found in a record, their stiffness, loss and uncertainty."""

from __future__ import annotations

import numpy as np
import pytest

import autobalancer as ab
from autobalancer.errors import QuestionError
from autobalancer.laws.rubber import RubberLaw
from autobalancer.measure import rubber_signals

HERTZ = 2.0 * np.pi
SAMPLE = "rubber_signals"
LAW = RubberLaw(30e3, 20.0, ((6e3, 5e-5), (5e3, 2e-4), (4e3, 8e-4)), (), "elastoplastic")  # that of the sample


def record(
    amplitudes,
    k: float = 4e4,
    loss: float = 3e3,
    *,
    hertz: float = 10.0,
    periods: int = 6,
    noise: float = 0.0,
    seed: int = 0,
):
    """Force and deflection of a linear element, one amplitude after the other."""
    w, n = HERTZ * hertz, 50
    t = np.arange(len(amplitudes) * periods * n) / (hertz * n)
    size = np.repeat(amplitudes, periods * n)
    x, f = size * np.sin(w * t), size * (k * np.sin(w * t) + loss * np.cos(w * t))
    rng = np.random.default_rng(seed)
    f = f + noise * rng.standard_normal(t.size)
    force = ab.measure.Channel(f, "force")
    return ab.measure.signals(t, {"x": ab.measure.Channel(x, "displacement"), "f": force}, origin="shaker")


def test_a_linear_element_is_found_exactly_at_every_amplitude():
    found = rubber_signals([record([1e-4, 4e-4, 1e-3]), record([2e-4], hertz=20.0)])
    np.testing.assert_allclose(found.frequency / HERTZ, [10.0, 10.0, 10.0, 20.0], rtol=2e-5)
    np.testing.assert_allclose(found.amplitude, [1e-4, 4e-4, 1e-3, 2e-4], rtol=1e-3)
    np.testing.assert_allclose(found.stiffness, 4e4, rtol=1e-3)
    np.testing.assert_allclose(found.loss, 3e3, rtol=5e-3)


def test_the_loops_of_the_sample_have_the_stiffness_and_loss_of_its_rubber():
    found = rubber_signals(ab.catalog.example_path(SAMPLE))
    np.testing.assert_allclose(1e3 * found.amplitude, [0.04, 0.1, 0.25, 0.6, 1.2], rtol=2e-3)
    true = LAW.stiffness(found.amplitude, found.frequency, "line")
    assert (np.abs(found.stiffness - true.real) < 2.5 * found.stiffness_uncertainty).all()
    assert (np.abs(found.loss - true.imag) < 2.5 * found.loss_uncertainty).all()


def test_the_fitted_rubber_of_the_sample_has_its_stiffness_between_the_loops():
    found = ab.measure.rubber(rubber_signals(ab.catalog.example_path(SAMPLE)))
    between = np.array([0.06e-3, 0.15e-3, 0.4e-3, 0.9e-3])
    true, fitted = (law.stiffness(between, 8.0 * HERTZ, "line") for law in (LAW, found.law))
    np.testing.assert_allclose(fitted.real, true.real, rtol=0.02)
    np.testing.assert_allclose(
        fitted.imag, true.imag, rtol=0.12
    )  # 5 loops for a chain of elements with other amplitudes
    assert "breakaway_amplitude" in found.toml()


def test_the_scatter_of_periods_says_how_sure_a_loop_is():
    off = []
    for seed in range(40):
        found = rubber_signals(
            record([4e-4], noise=0.3, seed=seed, periods=12), frequency=10.0 * HERTZ, calibration=1e-6
        )
        off.append(
            (
                (found.stiffness[0] - 4e4) / found.stiffness_uncertainty[0],
                (found.loss[0] - 3e3) / found.loss_uncertainty[0],
            )
        )
    assert np.sqrt(np.mean(np.square(off), axis=0)) == pytest.approx(
        [1.1, 1.1], abs=0.35
    )  # Student with 10 periods; 40 records


def test_bad_records_are_refused_with_time_or_name():
    good = record([4e-4])
    clipped = good.assign(f=good["f"].clip(max=10.0).assign_attrs(good["f"].attrs))
    with pytest.raises(QuestionError, match=r"channel 'f' is clipped at 10, first at 0.01 s"):
        rubber_signals(clipped)
    with pytest.raises(QuestionError, match=r"rubber pushes back and takes energy"):
        rubber_signals(record([4e-4], loss=-3e3))
    with pytest.raises(QuestionError, match=r"no 4 periods of .* in a row have one amplitude"):
        rubber_signals(record([1e-4, 2e-4, 4e-4], periods=3), frequency=10.0 * HERTZ)
    with pytest.raises(QuestionError, match="channel: given 'force'; must be 'x' or 'f'"):
        rubber_signals(good, force="force")
    with pytest.raises(QuestionError, match="channel 'f' is a force, not a displacement"):
        rubber_signals(good, deflection="f")
