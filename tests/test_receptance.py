"""Stability from a measured receptance: files, fit, closed loop, and a hammer test on a simulated rotor."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import typer
from tests.references.pictures import size_of
from tests.references.planar_linear import matrices
from tests.references.planar_states import Equilibrium
from tests.references.receptances import Host, chain, measured, planar_model, tilting, universal_text
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli.identify import receptance as command
from autobalancer.errors import QuestionError, ResultError
from autobalancer.machine import Machine
from autobalancer.measurement.loop import (
    RaceBalls,
    balls_of,
    equal_balls,
    loop_eigenvalues,
    loop_matrix,
    positions,
    receptance_border,
    receptance_loop,
    receptance_stability,
    spread,
)
from autobalancer.rotordynamics.rational_fit import modes_of
from autobalancer.rotordynamics.receptances import load_receptance, pole_model
from autobalancer.simulation.record import SampleTimes
from autobalancer.stability.host.stations import Plane
from autobalancer.stability.maps.balanced import PlanarBalancer, growth_rate, worst_case_border
from autobalancer.stability.states.linearized import deciding_eigenvalues, eigensystem

FREQUENCY = 2.0 * math.pi * np.linspace(2.0, 40.0, 381)
ROTOR = (12.27, 68.37, 44654.0)  # kg, N s/m, N/m: Spannan (2021), table 6.4
OIL = equal_balls(2, 6.656e-3, 0.077, 3e-5, spin_ratio=0.4)


def planar(frequency: np.ndarray) -> np.ndarray:
    mass, damping, stiffness = ROTOR
    return 1.0 / (stiffness - mass * frequency**2 + 1j * damping * frequency)


def balancer(balls: RaceBalls = OIL) -> PlanarBalancer:
    mass, damping, stiffness = ROTOR
    numbers = balls.moment[0], balls.inertia[0], balls.drag[0]
    return PlanarBalancer(mass + balls.mass.sum(), stiffness, damping, balls.count, *map(float, numbers))


def exact_border(level: float, low: float = 61.0, high: float = 250.0) -> float:
    """By bisection on the polynomial of degree eight; the state is stable at ``high``."""
    assert growth_rate(balancer(), low, level) > 0.0 > growth_rate(balancer(), high, level)
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if growth_rate(balancer(), middle, level) > 0.0 else (low, middle)
    return high


def unequal_balls(random: np.random.Generator, count: int) -> RaceBalls:
    moment = random.uniform(1e-3, 3e-3, count)
    return RaceBalls(moment / 0.1, moment, 0.14 * moment, random.uniform(1e-4, 1e-3, count))


def same_values(found: np.ndarray, expected: np.ndarray, tolerance: float) -> None:
    assert found.size == expected.size
    apart = np.abs(found[:, None] - expected)
    scale = tolerance * np.abs(expected).max()
    assert apart.min(axis=0).max() < scale
    assert apart.min(axis=1).max() < scale


# the closed loop


@pytest.mark.parametrize("count", [1, 2, 3, 5])
@pytest.mark.parametrize("speed", [80.0, 130.0, 400.0])
def test_the_loop_of_a_planar_rotor_has_the_eigenvalues_of_its_full_equations(count: int, speed: float) -> None:
    random = np.random.default_rng(count)
    balls, angles = unequal_balls(random, count), random.uniform(-3.0, 3.0, count)
    arrays = balls.mass, balls.moment, balls.inertia, balls.drag, np.zeros(count, np.int64), np.zeros(count, complex)
    plane = Plane(10.0, (1e5, 1e5), (60.0, 60.0), 0j, *arrays)
    freedom = max(count - 2, 0)
    values, _ = eigensystem(*matrices(plane, speed, Equilibrium("balanced", angles, 0j, freedom, 0)))
    expected = deciding_eigenvalues(values, freedom)
    with_balls = loop_eigenvalues(planar_model(10.0, 60.0, 1e5), balls, angles, speed)
    same_values(with_balls, expected, 1e-11)
    added = float(balls.mass.sum())
    same_values(loop_eigenvalues(planar_model(10.0 - added, 60.0, 1e5, added), balls, angles, speed), expected, 1e-11)


@pytest.mark.parametrize("speed", [60.0, 95.0, 260.0])
@pytest.mark.parametrize("gyroscopic", [False, True])
def test_the_loop_of_a_rotor_with_more_modes_has_the_eigenvalues_of_its_full_equations(
    speed: float, gyroscopic: bool
) -> None:
    host: Host = tilting(speed) if gyroscopic else chain()
    random = np.random.default_rng(7)
    for count in (2, 4):
        balls, angles = unequal_balls(random, count), random.uniform(-3.0, 3.0, count)
        values = host.eigenvalues(balls, angles, speed)
        expected = np.delete(values, np.argsort(np.abs(values))[: count - 2])
        model = replace(host.poles(), added_mass=float(balls.mass.sum()))
        same_values(loop_eigenvalues(model, balls, angles, speed), expected, 1e-9)


def test_the_eigenvalues_are_the_roots_of_the_characteristic_determinant() -> None:
    host, random = chain(), np.random.default_rng(3)
    balls, angles = unequal_balls(random, 3), random.uniform(-3.0, 3.0, 3)
    model = replace(host.poles(), added_mass=float(balls.mass.sum()))
    values = loop_eigenvalues(model, balls, angles, 95.0)
    slow = values[np.abs(values + balls.drag[:, None] / balls.inertia[:, None]).min(axis=0) > 1e-3]
    assert np.abs(np.linalg.det(np.eye(2) - loop_matrix(model, balls, angles, 95.0, slow))).max() < 1e-6


def test_balls_may_be_weighed_in_before_or_after_the_test() -> None:
    mass, damping, stiffness = ROTOR
    added = float(OIL.mass.sum())
    before = planar_model(mass, damping, stiffness, added)
    after = planar_model(mass + added, damping, stiffness)
    assert before.at(FREQUENCY) == pytest.approx(after.at(FREQUENCY), rel=1e-12)


# the fit


def test_a_fit_to_exact_values_finds_the_poles_and_residues() -> None:
    host = chain()
    fit = ab.measure.receptance(measured(FREQUENCY, host.receptance(FREQUENCY)))
    exact, found = host.poles(), pole_model(fit)
    assert fit.attrs["modes"] == 2
    same_values(found.poles, exact.poles, 1e-10)
    same_values(found.residues, exact.residues, 1e-9)
    assert fit.attrs["fit_error"] < 1e-12
    assert fit.attrs["effective_mass"] == pytest.approx(5.0, rel=1e-9)
    assert fit.attrs["warnings"] == ""


def test_exact_values_of_a_planar_rotor_give_the_eigenvalues_of_its_full_equations() -> None:
    fit = ab.measure.receptance(measured(FREQUENCY, planar(FREQUENCY)))
    model = pole_model(fit, float(OIL.mass.sum()))
    exact = planar_model(*ROTOR, float(OIL.mass.sum()))
    for speed in (70.0, 90.0, 120.0):
        angles = np.array([2.0, -2.0])
        same_values(loop_eigenvalues(model, OIL, angles, speed), loop_eigenvalues(exact, OIL, angles, speed), 1e-10)


@pytest.mark.slow
def test_noise_does_not_add_modes_and_a_mode_beyond_the_band_is_seen_by_its_tail() -> None:
    modes = [(40.0, 0.02, 0.3), (75.0, 0.01, 0.1), (130.0, 0.03, 0.15), (190.0, 0.005, 0.2), (400.0, 0.01, 0.3)]
    sigma = 1j * FREQUENCY
    values = sum(shape**2 / (sigma**2 + 2.0 * zeta * w * sigma + w**2) for w, zeta, shape in modes)
    for seed in range(2):
        fit = ab.measure.receptance(measured(FREQUENCY, np.asarray(values), 0.01, seed))
        assert fit.attrs["modes"] == 5
        assert fit.attrs["fit_error"] == pytest.approx(0.01, rel=0.1)
        for (w, zeta, _), (frequency, ratio) in zip(modes[:4], modes_of(fit)[:4], strict=True):
            assert frequency == pytest.approx(w, rel=1e-3)
            assert ratio == pytest.approx(zeta, rel=0.05)
        assert modes_of(fit)[4][0] == pytest.approx(400.0, rel=0.05)


def test_a_fit_is_stable_has_mass_and_is_real_whatever_the_noise() -> None:
    for seed in range(4):
        fit = ab.measure.receptance(measured(FREQUENCY, chain().receptance(FREQUENCY), 0.2, seed))
        model = pole_model(fit)
        assert model.poles.real.max() < 0.0
        assert abs(model.residues.sum()) < 1e-9 * np.abs(model.residues).max()
        same_values(model.poles.conj(), model.poles, 1e-12)
        assert fit.attrs["effective_mass"] > 0.0


def test_noise_of_equal_size_everywhere_may_be_fitted_as_such() -> None:
    random = np.random.default_rng(5)
    values = planar(FREQUENCY)
    noise = 0.01 * np.abs(values).max() * (random.normal(size=values.size) + 1j * random.normal(size=values.size))
    fit = ab.measure.receptance(measured(FREQUENCY, values + noise / math.sqrt(2.0)), noise="absolute")
    (frequency, ratio), *more = modes_of(fit)
    assert not more
    assert frequency == pytest.approx(math.sqrt(ROTOR[2] / ROTOR[0]), rel=1e-3)
    assert ratio == pytest.approx(ROTOR[1] / (2.0 * math.sqrt(ROTOR[0] * ROTOR[2])), rel=0.02)


def test_lines_without_coherence_do_not_count() -> None:
    good = measured(FREQUENCY, planar(FREQUENCY), 0.01)
    values = good["receptance_real"].values.copy()
    values[150:160] *= -3.0
    bad = good.assign(receptance_real=("frequency", values))
    coherence = np.full(FREQUENCY.size, 0.999)
    coherence[150:160] = 0.001
    fit = ab.measure.receptance(bad.assign(coherence=("frequency", coherence)))
    assert modes_of(fit)[0][0] == pytest.approx(math.sqrt(ROTOR[2] / ROTOR[0]), rel=1e-3)


def test_a_force_of_the_wrong_sign_and_the_other_convention_are_refused() -> None:
    for values in (-planar(FREQUENCY), planar(FREQUENCY).conj()):
        with pytest.raises(QuestionError, match="turn the sign of the force, or take the complex conjugate"):
            ab.measure.receptance(measured(FREQUENCY, values))
    with pytest.raises(QuestionError, match="3 values are too few"):
        ab.measure.receptance(measured(FREQUENCY[:3], planar(FREQUENCY[:3])))


# borders, margins, coverage


@pytest.mark.parametrize("degrees", [100.0, 120.0, 160.0])
def test_the_border_from_exact_values_is_the_exact_border(degrees: float) -> None:
    cosine = math.cos(math.radians(degrees))
    fit = ab.measure.receptance(measured(FREQUENCY, planar(FREQUENCY)))
    found = receptance_border(fit, OIL, balls_on_rotor=False, unbalance=-2.0 * OIL.moment[0] * cosine)
    expected = exact_border(2.0 * abs(2.0 * cosine**2 - 1.0))
    assert found.attrs["exact_border"] == pytest.approx(expected, rel=1e-8)
    assert found.attrs["warnings"] == ""


def test_the_worst_case_is_that_of_balls_evenly_spread() -> None:
    thick = OIL.with_drag(3.0)
    fit = ab.measure.receptance(measured(FREQUENCY, planar(FREQUENCY)))
    found = receptance_border(fit, thick, balls_on_rotor=False)
    assert found.attrs["state"].startswith("worst case")
    assert found.attrs["exact_border"] == pytest.approx(worst_case_border(balancer(thick)), rel=1e-8)


@pytest.mark.parametrize("seed", range(3))
def test_a_hammer_test_on_a_simulated_rotor_gives_the_border_within_two_percent(seed: int) -> None:
    mass, damping, stiffness = ROTOR
    rotor = Machine(
        name="on the bench",
        axis="vertical",
        rotor={"mass": mass, "stiffness": stiffness, "damping": damping},
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": 0.0}},
        start={"velocity": [0.1, 0.0]},  # just after a blow of mass x 0.1 m/s
    )
    step, random = 1e-3, np.random.default_rng(seed)
    time = np.arange(10_000) * step
    x = ab.simulate(rotor, duration=10.0, save=SampleTimes(time), tolerance=1e-10)["x"].values
    heard = x + 2e-3 * np.abs(x).max() * random.normal(size=x.size)
    hertz = np.fft.rfftfreq(time.size, step)
    values = np.fft.rfft(heard) * step / (mass * 0.1)
    band = (hertz >= 3.0) & (hertz <= 30.0)
    fit = ab.measure.receptance(measured(2.0 * math.pi * hertz[band], values[band]), noise="absolute")
    found = receptance_border(fit, OIL, balls_on_rotor=False, unbalance=500e-6, resamples=8)
    cosine = 500e-6 / (2.0 * OIL.moment[0])
    expected = exact_border(2.0 * abs(2.0 * cosine**2 - 1.0), high=180.0)
    assert found.attrs["exact_border"] == pytest.approx(expected, rel=0.02)
    assert abs(found.attrs["exact_border"] - expected) < 5.0 * found.attrs["exact_border_deviation"]


@pytest.mark.parametrize("seed", range(3))
def test_one_percent_of_noise_moves_the_border_of_a_rotor_with_two_modes_by_less_than_two_percent(seed: int) -> None:
    host, balls = chain(), equal_balls(3, 0.012, 0.08, 4e-5, spin_ratio=0.4)
    angles = np.array([0.2, 2.3, -2.1])
    borders = []
    for noise in (0.0, 0.01):
        fit = ab.measure.receptance(measured(FREQUENCY, host.receptance(FREQUENCY), noise, seed))
        borders.append(receptance_border(fit, balls, balls_on_rotor=False, angles=angles).attrs["exact_border"])
    just_below, just_above = (host.eigenvalues(balls, angles, f * borders[0]) for f in (0.999, 1.001))
    assert np.sort(just_below.real)[-2] > 1e-6 > np.sort(just_above.real)[-2]  # one is zero: three balls can be moved
    assert borders[1] == pytest.approx(borders[0], rel=0.02)


def test_the_least_drag_puts_the_border_at_the_speed() -> None:
    fit = ab.measure.receptance(measured(FREQUENCY, planar(FREQUENCY)))
    at = receptance_stability(fit, OIL, [75.0], balls_on_rotor=False, unbalance=500e-6)
    factor = float(at["drag_factor"][0])
    border = receptance_border(fit, OIL.with_drag(factor), balls_on_rotor=False, unbalance=500e-6)
    assert border.attrs["exact_border"] == pytest.approx(75.0, rel=1e-7)
    below = receptance_stability(fit, OIL, [50.0], balls_on_rotor=False, unbalance=500e-6)
    assert math.isinf(float(below["drag_factor"][0]))


def test_margins_are_where_the_curve_crosses_the_real_axis_and_the_unit_circle() -> None:
    fit = ab.measure.receptance(measured(FREQUENCY, planar(FREQUENCY)))
    loop = receptance_loop(fit, OIL, 90.0, balls_on_rotor=False)
    curve = loop["loop_real"].values + 1j * loop["loop_imag"].values
    crossing = np.flatnonzero(np.diff(np.sign(curve.imag)) != 0.0)
    real = [
        float(curve.real[i] - curve.imag[i] * np.diff(curve.real)[i] / np.diff(curve.imag)[i])
        for i in crossing.tolist()
    ]
    assert loop.attrs["growth_rate"] < 0.0
    assert loop.attrs["gain_margin"] == pytest.approx(1.0 / max(r for r in real if 0.0 < r < 1.0), rel=1e-3)
    size, angle = np.log(np.abs(curve)), np.angle(curve)
    circle = np.flatnonzero(np.diff(np.sign(size)) != 0.0)
    share = size[circle] / (size[circle] - size[circle + 1])
    across = np.abs(angle[circle] + share * (angle[circle + 1] - angle[circle]))
    assert loop.attrs["phase_margin"] == pytest.approx(across.min(), rel=1e-2)


def test_the_curve_passes_the_critical_point_at_the_border() -> None:
    fit = ab.measure.receptance(measured(FREQUENCY, planar(FREQUENCY)))
    thick = OIL.with_drag(3.0)
    border = worst_case_border(balancer(thick))
    loop = receptance_loop(fit, thick, border, balls_on_rotor=False)
    assert np.abs(loop["loop_real"].values + 1j * loop["loop_imag"].values - 1.0).min() < 3e-3
    assert abs(loop.attrs["growth_rate"]) < 1e-7


def test_measured_values_lie_on_the_curve_of_the_loop() -> None:
    fit = ab.measure.receptance(measured(FREQUENCY, planar(FREQUENCY)))
    loop = receptance_loop(fit, OIL, 90.0, balls_on_rotor=False)
    model = planar_model(*ROTOR, float(OIL.mass.sum()))
    right_angle = np.array([0.75 * math.pi, -0.75 * math.pi])
    turning = 1j * (FREQUENCY - 90.0)
    expected = loop_matrix(model, OIL, right_angle, 90.0, turning)[:, 0, 0]
    values = loop["measured_loop_real"].values + 1j * loop["measured_loop_imag"].values
    assert values == pytest.approx(expected, rel=1e-10)
    curve = np.interp(FREQUENCY, loop["loop_frequency"], loop["loop_real"])
    assert curve[:40] == pytest.approx(expected.real[:40], rel=2e-2)


def test_margins_shrink_to_nothing_at_the_border() -> None:
    fit = ab.measure.receptance(measured(FREQUENCY, planar(FREQUENCY)))
    border = receptance_border(fit, OIL, balls_on_rotor=False, unbalance=500e-6).attrs["exact_border"]
    at = receptance_stability(fit, OIL, [1.0001 * border, 1.3 * border], balls_on_rotor=False, unbalance=500e-6)
    assert float(at["gain_margin"][0]) == pytest.approx(1.0, abs=5e-3)
    assert float(at["phase_margin"][0]) < 5e-3
    assert float(at["gain_margin"][1]) > 1.5
    assert float(at["phase_margin"][1]) > 0.05


def test_what_was_not_measured_is_said() -> None:
    short = FREQUENCY[FREQUENCY < 70.0]
    fit = ab.measure.receptance(measured(short, planar(short)))
    within = receptance_stability(fit, OIL, [65.0], balls_on_rotor=False, unbalance=500e-6)
    beyond = receptance_stability(fit, OIL, [65.0, 100.0], balls_on_rotor=False, unbalance=500e-6)
    assert within["covered"].values.tolist() == [True]
    assert within.attrs["warnings"] == ""
    assert beyond["covered"].values.tolist() == [True, False]
    assert "extrapolated" in beyond.attrs["warnings"]
    border = receptance_border(fit, OIL, balls_on_rotor=False, unbalance=500e-6, searched=(61.0, 200.0))
    assert "extrapolated" in border.attrs["warnings"]


def test_positions_close_the_balance_and_the_worst_case_goes_through_all_spreads() -> None:
    (two,) = positions(OIL, 300e-6, None)
    assert abs((OIL.moment * np.exp(1j * two)).sum() + 300e-6) < 1e-15
    three = equal_balls(3, 0.01, 0.1, 1e-4, spin_ratio=0.4)
    found = [spread(three, angles) for angles in positions(three, None, None)]
    assert found == pytest.approx(np.linspace(0.0, 1.0, 9).tolist(), abs=1e-7)
    with pytest.raises(QuestionError, match="3 balls can balance it in many ways"):
        positions(three, 1e-4, None)
    with pytest.raises(QuestionError, match="cannot balance 2000 g mm"):
        positions(OIL, 2e-3, None)
    with pytest.raises(QuestionError, match="drag"):
        equal_balls(2, 0.01, 0.1, 0.0, spin_ratio=0.4)


def test_the_balls_of_a_machine_are_those_it_resolves() -> None:
    rig = Path(__file__).parents[1] / "examples" / "machines"
    found = balls_of(rig / "discoidal.toml")
    assert found.count == 2
    assert found.mass.sum() == pytest.approx(ab.check(rig / "discoidal.toml").races[0].effective_mass)
    with pytest.raises(QuestionError, match="off the axis"):
        balls_of(rig / "eccentric_race.toml")


# files

HERTZ = np.linspace(2.0, 40.0, 39)
TRUE = planar(2.0 * math.pi * HERTZ)
MOTIONS = {8: TRUE, 11: 2j * math.pi * HERTZ * TRUE, 12: -((2.0 * math.pi * HERTZ) ** 2) * TRUE}


def is_true(found: object, tolerance: float = 1e-12) -> None:
    assert found["frequency"].values == pytest.approx(2.0 * math.pi * HERTZ, rel=tolerance)  # type: ignore[index]
    values = found["receptance_real"].values + 1j * found["receptance_imag"].values  # type: ignore[index]
    assert values == pytest.approx(TRUE, rel=tolerance, abs=tolerance * np.abs(TRUE).max())


@pytest.mark.parametrize(
    ("head", "scale", "motion"),
    [
        ("frequency [Hz], real [m/N], imag [m/N]", 1.0, 8),
        ("Freq (Hz);Re (mm/s/N);Im (mm/s/N)", 1e3, 11),
        ("frequency [Hz]\treal part [m/s2/N]\timag part [m/s2/N]\tremark", 1.0, 12),
        ("f [Hz], real [g_0/lbf], imag [g_0/lbf], coherence", 4.4482216152605 / 9.80665, 12),
    ],
)
def test_tables_are_read_in_their_units(tmp_path: Path, head: str, scale: float, motion: int) -> None:
    mark = next(m for m in (";", "\t", ",") if m in head)
    extra = "".join(f"{mark}{0.9}" for _ in range(head.count(mark) - 2))
    lines = ["# a comment", head]
    for f, value in zip(HERTZ, MOTIONS[motion] * scale, strict=True):
        lines.append(mark.join(repr(float(x)) for x in (f, value.real, value.imag)) + extra)
    text = "\n".join(lines)
    path = tmp_path / "test.csv"
    path.write_text(text.replace(".", ",") if mark == ";" else text, encoding="utf-8")
    found = load_receptance(path)
    is_true(found)
    assert ("coherence" in found) == ("coherence" in head)


def test_a_table_of_amplitude_and_phase_is_read_and_its_line_at_zero_left_out(tmp_path: Path) -> None:
    rows = [f"{f},{abs(v)},{math.degrees(np.angle(v))}" for f, v in zip(HERTZ, TRUE, strict=True)]
    path = tmp_path / "test.csv"
    path.write_text("\n".join(["frequency [Hz],amplitude [m/N],phase [deg]", "0,2e-5,0", *rows]), encoding="utf-8")
    is_true(load_receptance(path))


@pytest.mark.parametrize("motion", [8, 11, 12])
@pytest.mark.parametrize("double", [False, True])
@pytest.mark.parametrize("even", [False, True])
def test_universal_files_are_read_in_every_form(tmp_path: Path, motion: int, double: bool, even: bool) -> None:
    path = tmp_path / "test.uff"
    path.write_text(universal_text(HERTZ, MOTIONS[motion], motion=motion, double=double, even=even), encoding="ascii")
    is_true(load_receptance(path), 1e-9 if double and even else 2e-5)


def test_units_of_a_universal_file_come_from_its_labels_or_its_dataset_164(tmp_path: Path) -> None:
    inches = (
        "\n".join(
            [
                "    -1",
                "   164",
                f"{7:10d}{'Inch (pound f)':20s}{2:10d}",
                f"{39.37007874:25.17E}{0.224808943:25.17E}{1.8:25.17E}",
            ]
        ).replace("E", "D")
        + "\n    -1"
    )
    values = MOTIONS[12] * 39.37007874 / 0.224808943
    path = tmp_path / "test.unv"
    path.write_text(universal_text(HERTZ, values, double=True, units=inches), encoding="ascii")
    is_true(load_receptance(path), 1e-8)
    path.write_text(universal_text(HERTZ, MOTIONS[12] / 9.80665, double=True, motion_unit="g"), encoding="ascii")
    is_true(load_receptance(path), 1e-9)
    path.write_text(universal_text(HERTZ, MOTIONS[12], motion_unit="volt"), encoding="ascii")
    with pytest.raises(ResultError, match="function 1: unit label"):
        load_receptance(path)


def test_a_blow_against_the_accelerometer_turns_the_sign(tmp_path: Path) -> None:
    path = tmp_path / "test.uff"
    path.write_text(universal_text(HERTZ, -MOTIONS[12], double=True, directions=(1, -1)), encoding="ascii")
    is_true(load_receptance(path), 1e-9)


def test_of_several_functions_one_is_chosen_by_its_number(tmp_path: Path) -> None:
    path = tmp_path / "test.uff"
    one, other = universal_text(HERTZ, MOTIONS[12], double=True), universal_text(HERTZ, 2.0 * MOTIONS[12], double=True)
    path.write_text(other + one, encoding="ascii")
    with pytest.raises(ResultError, match=r"choose one function by its number.*2: accelerance, node 7 direction 1"):
        load_receptance(path)
    is_true(load_receptance(path, function=2), 1e-9)
    across = universal_text(HERTZ, 3.0 * MOTIONS[12], double=True, directions=(2, 1))
    path.write_text(across + one, encoding="ascii")
    is_true(load_receptance(path), 1e-9)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "no table"),
        ("frequency [Hz], real [m/N]\n1,2", "no column 'imag'"),
        ("frequency, real [m/N], imag [m/N]\n1,2,3", "'frequency' has no unit"),
        ("frequency [Hz], real [N/m], imag [N/m]\n1,2,3", "'N/m' is not a unit of a frequency response"),
        ("frequency [m], real [m/N], imag [m/N]\n1,2,3", "unit of column 'frequency'"),
        ("frequency [Hz], real [m/N], imag [mm/N]\n1,2,3", "different units"),
        ("frequency [Hz], real [m/N], imag [m/N]\n1,2,x", "line 2, column 'imag': 'x' is not a number"),
        ("frequency [Hz], real [m/N], imag [m/N]\n1,2", "line 2: 2 cells for 3 columns"),
        ("frequency [Hz], real [m/N], imag [m/N]\n1,2,3\n1,2,4", "a frequency comes twice"),
        ("frequency [Hz], real [m/N], imag [m/N]\n1,2,nan", "not a finite number"),
        ("frequency [Hz], real [m/N], imag [m/N]\n1,0,0", "a value is exactly zero"),
        ("    -1\n    58b     1\n    -1\n", "dataset 58b of function 1: its head is not whole"),
        ("    -1\n    15\n    -1\n", "no dataset 58"),
        ("    -1\n    58\nNONE\nNONE\n    -1\n", "dataset 58 of function 1: its head is not whole"),
    ],
)
def test_files_that_cannot_be_read_are_refused_in_words(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "test.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ResultError, match=words):
        load_receptance(path)
    with pytest.raises(ResultError, match="cannot be read"):
        load_receptance(tmp_path / "nowhere.csv")


# command and pictures


def hammer_file(folder: Path) -> Path:
    values = measured(FREQUENCY, planar(FREQUENCY), 0.01)
    columns = FREQUENCY / (2.0 * math.pi), values["receptance_real"].values, values["receptance_imag"].values
    head = "frequency [Hz], real [m/N], imag [m/N]"
    path = folder / "hammer.csv"
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=head, comments="", fmt="%.9e")
    return path


def test_the_command_prints_border_drag_and_margins_and_draws(tmp_path: Path) -> None:
    app = typer.Typer()
    app.command()(command)
    file, out = hammer_file(tmp_path), tmp_path / "loop.png"
    balls = ["--balls", "2", "--ball-mass", "6.656 g", "--orbit-radius", "77 mm", "--drag", "3e-5 N*m*s"]
    asked = [str(file), *balls, "--unbalance", "500 g*mm", "--speed", "1200 rpm", "--resamples", "0"]
    text = CliRunner().invoke(app, [*asked, "--plot", str(out)], catch_exceptions=False).output
    assert "exact border" in text
    assert "phase margin" in text
    assert size_of(out) == (840, 810)
    numbers = json.loads(CliRunner().invoke(app, [*asked, "--json"], catch_exceptions=False).output)
    cosine = 500e-6 / (2.0 * OIL.moment[0])
    assert numbers["exact_border"] == pytest.approx(exact_border(2.0 * abs(2.0 * cosine**2 - 1.0)), rel=0.02)
    assert numbers["speeds"][0]["speed"] == pytest.approx(40.0 * math.pi)
    assert numbers["warnings"] == []


def test_the_command_takes_balls_unbalance_and_oil_from_a_machine(tmp_path: Path) -> None:
    app = typer.Typer()
    app.command()(command)
    rig = Path(__file__).parents[1] / "examples" / "machines" / "discoidal.toml"
    asked = [str(hammer_file(tmp_path)), "--machine", str(rig), "--speed", "1200 rpm", "--resamples", "0"]
    text = CliRunner().invoke(app, asked, catch_exceptions=False).output
    assert "mm^2/s" in text
    numbers = json.loads(CliRunner().invoke(app, [*asked, "--json"], catch_exceptions=False).output)
    exact = {border.name: border.speed for border in ab.stability.borders(rig)}["exact border"]
    assert numbers["exact_border"] == pytest.approx(exact, rel=0.02)


def test_pictures_show_fit_and_loop(tmp_path: Path) -> None:
    fit = ab.measure.receptance(load_receptance(hammer_file(tmp_path)))
    assert len(ab.plot.answer(fit).axes) == 2
    for speed in (70.0, 100.0):
        title = ab.plot.answer(receptance_loop(fit, OIL, speed, balls_on_rotor=False)).get_suptitle()
        assert ("unstable" in title) == (speed == 70.0)
    with pytest.raises(QuestionError, match=r"is of a result of measure\.receptance_loop"):
        ab.plot.answer(fit, "nyquist")
    with pytest.raises(QuestionError, match="there is no picture of this result"):
        ab.plot.answer(load_receptance(hammer_file(tmp_path)))
