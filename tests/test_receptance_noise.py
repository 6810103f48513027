"""Fits of measured receptances in noise: as many modes as the machine has, with honest uncertainties."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import typer
from scipy.optimize import brentq
from tests.references.receptances import accelerance, chain, measured
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.assembly.drive_train import largest_unbalance
from autobalancer.cli.identify import receptance as command
from autobalancer.errors import QuestionError
from autobalancer.measurement.loop import balls_of, equal_balls, receptance_border
from autobalancer.rotordynamics.receptances import receptance_dataset

FREQUENCY = 2.0 * math.pi * 0.25 * np.arange(1, 401)  # to 100 Hz, as an analyser gives it
MASS, DAMPING, STIFFNESS = 12.27, 68.37, 44654.0  # Spannan (2021), table 6.4
ONE = 1.0 / (STIFFNESS - MASS * FREQUENCY**2 + 1j * DAMPING * FREQUENCY)
TWO = chain().receptance(FREQUENCY)
BALLS = equal_balls(2, 6.656e-3, 0.077, 3e-5, spin_ratio=0.4)
QUANTITIES = ("mode_frequency", "mode_damping_ratio", "mode_mass")


def exact_modes(count: int) -> list[np.ndarray]:
    """Frequency, damping ratio and mass of the modes, from the matrices."""
    if count == 1:
        natural = math.sqrt(STIFFNESS / MASS)
        return [np.array([value]) for value in (natural, 0.5 * DAMPING / (MASS * natural), MASS)]
    model = chain().poles()
    up = np.flatnonzero(model.poles.imag > 0.0)
    up = up[np.argsort(np.abs(model.poles[up]))]
    poles, residues = model.poles[up], model.residues[up]
    return [np.abs(poles), -poles.real / np.abs(poles), -0.5 / (residues * poles.conj()).real]


@pytest.mark.parametrize("floor", [1e-3, 1e-2])  # m/s^2/N; the machine gives 0.08 well above its resonance
@pytest.mark.parametrize("count", [1, 2])
def test_noise_of_an_accelerometer_adds_no_modes_and_the_uncertainties_are_true(count: int, floor: float) -> None:
    """Five standard deviations for the worst of 24 values; their mean square is one within the scatter of so few."""
    deviations = []
    for seed in range(4):
        fit = ab.measure.receptance(accelerance(FREQUENCY, (ONE, TWO)[count - 1], floor, 0.005, seed))
        assert fit.attrs["modes"] == count
        for name, exact in zip(QUANTITIES, exact_modes(count), strict=True):
            deviations.append((fit[name].values - exact) / fit[f"{name}_deviation"].values)
    assert np.abs(deviations).max() < 5.0
    assert 0.5 < math.sqrt(float(np.mean(np.square(deviations)))) < 1.7


def test_a_peak_one_line_wide_leaves_its_line_its_noise() -> None:
    """The fit goes through that line whatever its noise, so what it leaves there is no measure of the noise."""
    natural, ratio, mass = 20.0 * math.pi, 0.002, 10.0
    frequency = 2.0 * math.pi * 0.5 * np.arange(1, 201)
    narrow = 1.0 / (mass * (natural**2 - frequency**2 + 2j * ratio * natural * frequency))
    for seed in range(3):
        fit = ab.measure.receptance(accelerance(frequency, narrow, 1e-2, 0.01, seed))
        assert fit.attrs["modes"] == 1
        for name, exact in zip(QUANTITIES, (natural, ratio, mass), strict=True):
            assert abs(float(fit[name][0]) - exact) < 5.0 * float(fit[f"{name}_deviation"][0])


def test_the_noise_that_is_found_is_the_noise_that_is_there() -> None:
    floor, share = 3e-3, 0.01
    fit = ab.measure.receptance(accelerance(FREQUENCY, ONE, floor, share, 0))
    true = np.hypot(share * np.abs(ONE), floor / FREQUENCY**2)
    assert np.abs(np.log(fit["noise_deviation"].values / true)).max() < math.log(1.35)
    assert float(fit["noise_deviation"][0]) > 5.0 * abs(ONE[0])  # at 0.25 Hz nothing else is measured


@pytest.mark.parametrize("seed", range(2))
def test_the_border_from_an_accelerometer_is_the_exact_border_of_the_machine(seed: int) -> None:
    """Of a machine file with this rotor, by the eigenvalues of its full equations."""
    rig = Path(__file__).parents[1] / "examples" / "machines" / "discoidal.toml"
    fit = ab.measure.receptance(accelerance(FREQUENCY, ONE, 1e-2, 0.005, seed))
    unbalance = abs(largest_unbalance(ab.load_machine(rig)))
    found = receptance_border(fit, balls_of(rig), balls_on_rotor=False, unbalance=unbalance, resamples=10)
    exact = {border.name: border.speed for border in ab.stability.borders(rig)}["exact border"]
    assert found.attrs["exact_border"] == pytest.approx(exact, rel=0.01)
    assert abs(found.attrs["exact_border"] - exact) < 5.0 * found.attrs["exact_border_deviation"]


def test_the_border_of_a_rotor_with_two_modes_is_where_its_full_equations_become_stable() -> None:
    host, angles = chain(), np.array([2.1, -2.1])
    fit = ab.measure.receptance(accelerance(FREQUENCY, TWO, 1e-2, 0.005, 0))
    found = receptance_border(fit, BALLS, balls_on_rotor=False, angles=angles, resamples=10)

    def rate(speed: float) -> float:
        return float(host.eigenvalues(BALLS, angles, speed).real.max())

    border = found.attrs["exact_border"]
    exact = brentq(rate, 0.95 * border, 1.05 * border)
    assert rate(1.1 * exact) < 0.0 < rate(0.99 * exact)
    assert border == pytest.approx(exact, rel=0.01)
    assert abs(border - exact) < 5.0 * found.attrs["exact_border_deviation"]


@pytest.mark.parametrize("with_coherence", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_blows_in_time_with_noise_and_drift_give_one_mode(with_coherence: bool) -> None:
    """Eight blows of 4 ms, white noise and a drift on the accelerometer, noise on the force; the analyser takes means.

    A drift is not periodic in the window: its errors are the same for neighbouring lines, unlike noise. One percent for
    what they leave in the mass.
    """
    rate, count, random = 1000.0, 8000, np.random.default_rng(1)
    fine = 2.0 * math.pi * np.fft.rfftfreq(16 * count, 1.0 / (8.0 * rate))
    accelerance_of = -(fine**2) / (STIFFNESS - MASS * fine**2 + 1j * DAMPING * fine)
    passed = 1.0 / np.sqrt(1.0 + (fine / (0.8 * math.pi * rate)) ** 40)  # the filter before sampling
    time = np.arange(32) / (8.0 * rate)
    blow = passed * np.fft.rfft(200.0 * np.sin(math.pi * time / 0.004), 16 * count)
    force, heard = (np.fft.irfft(values, 16 * count)[: 8 * count : 8] for values in (blow, blow * accelerance_of))
    forces, motions = [], []
    for _ in range(8):
        noise, drift, own = random.normal(size=(3, count))
        motions.append(np.fft.rfft(heard + 0.02 * noise + 0.02 * np.cumsum(drift) / math.sqrt(rate)))
        forces.append(np.fft.rfft(force + 0.05 * own))
    cross = np.mean(np.multiply(motions, np.conj(forces)), axis=0)
    power, answer = (np.mean(np.abs(values) ** 2, axis=0) for values in (forces, motions))
    frequency = 2.0 * math.pi * np.fft.rfftfreq(count, 1.0 / rate)
    band = slice(1, 1601)  # to 200 Hz
    coherence = (np.abs(cross) ** 2 / (power * answer))[band] if with_coherence else None
    test = receptance_dataset(frequency[band], (cross / power)[band], "accelerance", title="blows", coherence=coherence)
    fit = ab.measure.receptance(test)
    assert fit.attrs["modes"] == 1
    assert fit["mode_frequency"].values == pytest.approx(math.sqrt(STIFFNESS / MASS), rel=1e-3)
    assert fit["mode_mass"].values == pytest.approx(MASS, rel=0.01)
    assert "noise or drift" in fit.attrs["warnings"]


def test_a_band_fits_the_lines_in_it_only() -> None:
    noisy = accelerance(FREQUENCY, ONE, 1e-2, 0.005, 1)
    fit = ab.measure.receptance(noisy, band=("5 Hz", "40 Hz"))
    hertz = FREQUENCY / (2.0 * math.pi)
    assert fit["used"].values.astype(bool).tolist() == ((hertz >= 5.0) & (hertz <= 40.0)).tolist()
    assert fit.attrs["band_low"] == pytest.approx(10.0 * math.pi)
    assert fit.attrs["modes"] == 1
    assert fit.attrs["warnings"] == ""
    with pytest.raises(QuestionError, match=r"5 values are too few.*measured from 0\.25 to 100 Hz"):
        ab.measure.receptance(noisy, band=("5 Hz", "6 Hz"))
    with pytest.raises(QuestionError, match="band: given"):
        ab.measure.receptance(noisy, band=("6 Hz", "5 Hz"))


@pytest.mark.parametrize("width", [1, 2])
def test_mains_hum_is_no_mode_and_its_lines_are_left_out(width: int) -> None:
    noisy = accelerance(FREQUENCY, ONE, 2e-3, 0.005, width)
    at = int(np.argmin(np.abs(FREQUENCY - 100.0 * math.pi)))
    values = noisy["receptance_real"].values.copy()
    values[at : at + width] += 0.3 / FREQUENCY[at] ** 2
    fit = ab.measure.receptance(noisy.assign(receptance_real=("frequency", values)))
    assert fit.attrs["modes"] == 1
    assert set(range(at, at + width)) <= set(np.flatnonzero(fit["used"].values == 0).tolist())
    assert fit["used"].values.sum() > FREQUENCY.size - 6
    assert "left out as disturbed: 50" in fit.attrs["warnings"]


def test_a_lightly_damped_mode_between_two_lines_is_not_taken_for_hum() -> None:
    """Its half-power band is a tenth of the distance of two lines."""
    natural = 2.0 * math.pi * 50.13
    narrow = 1.0 / (30.0 * (natural**2 - FREQUENCY**2 + 2j * 0.00025 * natural * FREQUENCY))
    fit = ab.measure.receptance(accelerance(FREQUENCY, ONE + narrow, 1e-3, 0.005, 0))
    assert fit.attrs["modes"] == 2
    assert fit["mode_frequency"].values[1] == pytest.approx(natural, rel=1e-4)
    assert fit["mode_mass"].values[1] == pytest.approx(30.0, rel=0.02)


def test_three_modes_that_are_far_from_equal_are_found_whatever_the_order_before() -> None:
    """A case in which the best fits of one and two modes are far from the truth."""
    frequency = 2.0 * math.pi * np.arange(1.0, 401.0)
    modes = [(44.036, 0.01067, 3.4), (63.15, 0.01178, 3.5), (181.408, 0.04612, 1.0)]
    natural = 2.0 * math.pi * np.array([hertz for hertz, _, _ in modes])
    values = sum(
        1.0 / (m * (w**2 - frequency**2 + 2j * z * w * frequency)) for w, (_, z, m) in zip(natural, modes, strict=True)
    )
    for seed in range(3):
        fit = ab.measure.receptance(accelerance(frequency, np.asarray(values), 0.013, 0.007, seed))
        assert fit.attrs["modes"] == 3
        assert fit["mode_frequency"].values == pytest.approx(natural, rel=2e-3)


def test_more_modes_than_there_are_are_given_if_asked_for_and_said_to_be_none() -> None:
    fit = ab.measure.receptance(accelerance(FREQUENCY, ONE, 1e-2, 0.005, 1), modes=3)
    assert fit.attrs["modes"] == 3
    assert "Give fewer --modes" in fit.attrs["warnings"]


def test_a_force_at_another_place_feeds_energy_and_this_is_said() -> None:
    """Between two places with a mode between them in which they move against each other the work can have any sign."""
    host, across = chain(), np.array([0.0, 1.0])
    dynamic = -host.mass * FREQUENCY[:, None, None] ** 2 + 1j * FREQUENCY[:, None, None] * host.damping + host.stiffness
    transfer = np.linalg.solve(dynamic, np.broadcast_to(across, (FREQUENCY.size, 2))[..., None])[:, 0, 0]
    fit = ab.measure.receptance(measured(FREQUENCY, transfer, 0.005), band=("1 Hz", "24 Hz"))
    assert "feeds energy" in fit.attrs["warnings"]
    driving = ab.measure.receptance(measured(FREQUENCY, TWO, 0.005))
    assert "feeds energy" not in driving.attrs["warnings"]


def test_the_command_says_where_the_noise_is_and_how_to_leave_it_out(tmp_path: Path) -> None:
    noisy = accelerance(FREQUENCY, ONE, 2e-2, 0.005, 3)
    heard = -(FREQUENCY**2) * (noisy["receptance_real"].values + 1j * noisy["receptance_imag"].values)
    file = tmp_path / "hammer.csv"
    columns = np.column_stack([FREQUENCY / (2.0 * math.pi), heard.real, heard.imag])
    head = "frequency [Hz], real [m/s^2/N], imag [m/s^2/N]"
    np.savetxt(file, columns, delimiter=",", header=head, comments="")
    app = typer.Typer()
    app.command()(command)
    balls = ["--balls", "2", "--ball-mass", "6.656 g", "--orbit-radius", "77 mm", "--drag", "3e-5 N*m*s"]
    asked = [str(file), *balls, "--unbalance", "500 g*mm", "--resamples", "0"]
    text = " ".join(CliRunner().invoke(app, asked, catch_exceptions=False).output.split())
    assert "the noise is greater than the receptance" in text
    assert '--band "4' in text
    assert text.count("damping ratio") == 1
    within = CliRunner().invoke(app, [*asked, "--band", "5 Hz:100 Hz"], catch_exceptions=False).output
    assert "noise" not in within


def test_the_picture_shows_the_noise_and_what_was_left_out_and_its_phase_does_not_jump() -> None:
    fit = ab.measure.receptance(accelerance(FREQUENCY, ONE, 1e-2, 0.005, 1), band=("2 Hz", "100 Hz"))
    above, below = ab.plot.answer(fit).axes
    named = [text.get_text() for text in above.get_legend().get_texts()]
    assert named == ["measured", "not used", "fitted", "noise"]
    points, curve = (np.asarray(line.get_ydata(), float) for line in below.get_lines())
    assert np.abs(np.diff(curve)).max() < 90.0
    assert curve[[0, -1]] == pytest.approx([0.0, -180.0], abs=10.0)
    assert points.size > 300
    assert -240.0 < points.min() < points.max() < 60.0  # the noise does not turn -180 into +180
