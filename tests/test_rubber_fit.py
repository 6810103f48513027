"""Rubber from measured loops and resonances."""

import json
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli.main import app
from autobalancer.errors import QuestionError, ResultError
from autobalancer.laws.rubber import RubberLaw
from autobalancer.measurement.rubber import hysteresis

KNOWN = RubberLaw(
    25325.0, 20.6, ((9432.0, 3e-5), (4211.0, 1e-4), (4293.0, 3e-4), (5481.0, 1e-3), (5621.0, 3e-3))
)  # of the rig of Spannan (2021), section 6.1
AMPLITUDE = np.array([0.03, 0.06, 0.12, 0.25, 0.5, 1.0]) * 1e-3
HERTZ = 2.0 * np.pi


def loops(rubber=KNOWN, frequencies=(5.0, 20.0), amplitude=AMPLITUDE, **options):
    w, x = (one.ravel() for one in np.meshgrid(HERTZ * np.array(frequencies), amplitude))
    k = rubber.stiffness(x, w, "line")
    return ab.measure.rubber_loops(w, x, np.abs(k), k.imag / w, **options)


def test_a_fit_gives_back_the_rubber_from_which_loops_were_made():
    found = ab.measure.rubber(loops(), spacing=3.0)
    assert found.fitted.real == pytest.approx(
        found.points.stiffness, rel=0.01
    )  # another chain of amplitudes, half a step off
    assert found.fitted.imag == pytest.approx(found.points.loss, rel=0.04)
    assert found.law.viscous == pytest.approx(20.6, rel=0.1)
    exact = ab.measure.rubber(loops(KNOWN, amplitude=np.array([0.02, 0.05, 0.1, 0.3, 1.0]) * 1e-3), spacing=10.0**0.5)
    unlike = np.abs(exact.fitted / KNOWN.stiffness(exact.points.amplitude, exact.points.frequency, "line") - 1.0)
    assert unlike.max() < 0.01


def test_the_uncertainty_covers_what_noise_does_to_the_fit():
    random, points = np.random.default_rng(4), loops(stiffness_uncertainty=0.01, loss_uncertainty=0.03)
    at, misses = np.geomspace(4e-5, 9e-4, 9), []
    for _ in range(12):
        noisy = replace(
            points,
            stiffness=points.stiffness + points.stiffness_uncertainty * random.standard_normal(len(points)),
            loss=points.loss + points.loss_uncertainty * random.standard_normal(len(points)),
        )
        found = ab.measure.rubber(noisy)
        miss = found.stiffness(at, HERTZ * 10.0, "line") - KNOWN.stiffness(at, HERTZ * 10.0, "line")
        sure = found.uncertainty(at, HERTZ * 10.0, "line")
        misses += [miss.real / sure[0], miss.imag / sure[1]]
    assert 0.4 < np.sqrt(np.mean(np.square(misses))) < 1.6


def test_resonances_at_several_amplitudes_say_the_same_as_loops():
    mass, x = 12.28, AMPLITUDE
    w = np.sqrt(KNOWN.stiffness(x, 60.0, "line").real / mass)
    for _ in range(3):
        k = KNOWN.stiffness(x, w, "line")
        decay = k.imag / (2.0 * mass * w)
        w = np.sqrt(k.real / mass - decay**2)
    points = ab.measure.rubber_resonances(mass, w, x, decay)
    assert points.stiffness == pytest.approx(k.real)
    found = ab.measure.rubber([points, loops()])
    assert found.fitted.real == pytest.approx(found.points.stiffness, rel=0.02)
    without = ab.measure.rubber_resonances(mass, w, x)
    assert np.isnan(without.loss).all()
    assert without.stiffness == pytest.approx(k.real, rel=0.01)  # the decay rate squared is left out


def test_maxwell_elements_are_found_where_stiffness_rises_with_frequency():
    stiffer = RubberLaw(30000.0, 0.0, ((5000.0, 1e-4), (5000.0, 4e-4)), ((8000.0, 5e-3),))
    found = ab.measure.rubber(loops(stiffer, (2.0, 8.0, 30.0)), relaxation_times=["5 ms"], viscous=False, spacing=2.0)
    assert found.law.maxwell[0][0] == pytest.approx(8000.0, rel=0.05)
    with pytest.raises(QuestionError, match="this would extrapolate"):
        found.stiffness(1e-4, HERTZ * 60.0)


def test_the_fitted_rubber_stands_in_a_machine_file():
    found = ab.measure.rubber(loops())
    text = (
        'name = "one"\naxis = "vertical"\n[rotor]\nkind = "planar"\nmass = 12.0\n'
        + found.toml()
        + '[drive]\nkind = "speed"\n'
        '[drive.profile]\nkind = "constant"\nspeed = "10 rad/s"\n'
    )
    machine = ab.parse_machine(text)
    assert machine.rotor.rubber.initial_stiffness == pytest.approx(found.law.at_rest().real, rel=1e-5)
    assert found.rubber.largest_amplitude == pytest.approx(3e-3)
    assert "friction, 0.75 mm" in repr(found)


def test_a_fit_does_not_extrapolate_unless_asked():
    found = ab.measure.rubber(loops())
    with pytest.raises(QuestionError, match=r"given 2 to 2 mm, but measured was 0.03 to 1 mm"):
        found.stiffness(2e-3, 60.0)
    assert found.law.stiffness(2e-3, 60.0).real < found.stiffness(1e-3, 60.0).real


def changed(points, row, **factors):
    def scaled(name):
        values = getattr(points, name).copy()
        values[row] *= factors[name]
        return values

    return replace(points, **{name: scaled(name) for name in factors})


def without(points, row):
    keep = [i for i in range(len(points)) if i != row]
    return replace(
        points,
        **{
            name: getattr(points, name)[keep] if isinstance(getattr(points, name), np.ndarray)
            else tuple(getattr(points, name)[i] for i in keep)
            for name in points.__dict__
        },
    )  # fmt: skip


@pytest.mark.parametrize(
    ("points", "said"),
    [
        (lambda: changed(loops(), 5, stiffness=1.3), r"rises with the amplitude.*loop 6 \(20 Hz, 0.12 mm\)"),
        (lambda: changed(loops(), 11, stiffness=0.8), r"falls with the frequency.*loop 12 \(20 Hz, 1 mm\)"),
        (lambda: without(loops(), 5), "has holes: 20 Hz at 0.12 mm"),
        (lambda: loops(amplitude=np.array([1e-5, 1e-3])), "a hole of a factor 100"),
        (lambda: loops(amplitude=np.array([1e-3])), "all 2 points have one amplitude, 1 mm"),
        (lambda: [loops(), changed(loops(), 3, loss=1.5)], "loop 4 .* and loop 4 .* contradict each other: loss"),
        (lambda: loops(RubberLaw(4e4, 30.0)), "show no softening"),
        (list, "no measurements"),
    ],
)
def test_tables_that_no_rubber_can_have_are_refused_by_the_name_of_their_points(points, said):
    with pytest.raises(QuestionError, match=said):
        ab.measure.rubber(points())


def test_less_loss_than_softening_costs_is_named_as_a_contradiction():
    points = loops()
    lossless = replace(points, loss=0.2 * points.loss, loss_uncertainty=0.2 * points.loss_uncertainty)
    found = ab.measure.rubber(lossless)
    assert any("contradict each other" in text for text in found.remarks)
    assert not any("contradict each other" in text for text in ab.measure.rubber(points).remarks)


def test_impossible_numbers_are_named():
    with pytest.raises(QuestionError, match=r"amplitude: value 2 is nan.*hole"):
        ab.measure.rubber_loops([1.0, 1.0], [1e-3, np.nan], [1.0, 1.0], [0.1, 0.1])
    with pytest.raises(QuestionError, match="check the units"):
        ab.measure.rubber_loops([100.0], [1e-3], [1e3], [100.0])
    with pytest.raises(QuestionError, match="damping: given 1 values for 2"):
        ab.measure.rubber_loops([1.0, 1.0], [1e-3, 2e-3], [1.0, 1.0], [0.1])
    with pytest.raises(QuestionError, match="decay_rate"):
        ab.measure.rubber_resonances(1.0, [1.0], [1e-3], [-1.0])


def test_a_recorded_loop_gives_stiffness_and_damping_of_its_first_harmonic():
    w, x, k, b = 60.0, 2e-4, 4e4, 70.0
    time = np.linspace(0.0, 1.03, 4000)
    loop = hysteresis(
        time,
        x * np.sin(w * time),
        k * x * np.sin(w * time) + b * w * x * np.cos(w * time) + 0.1 * np.sin(3 * w * time),
        w,
    )
    assert loop.periods == 9
    assert loop.amplitude == pytest.approx(x, rel=1e-6)
    assert loop.damping == pytest.approx(b, rel=1e-4)
    assert loop.stiffness == pytest.approx(np.hypot(k, b * w), rel=1e-6)
    assert loop.energy == pytest.approx(np.pi * x**2 * b * w, rel=1e-4)  # Spannan (2021), (6.5)
    with pytest.raises(QuestionError, match="at least one period"):
        hysteresis(time[:100], time[:100], time[:100], w)


def test_the_command_fits_the_sample_and_writes_a_part_of_a_machine_file(tmp_path: Path):
    table = str(ab.catalog.example_path("rubber_loops"))
    out = tmp_path / "rubber.toml"
    told = CliRunner().invoke(app, ["rubber", table, "--out", str(out)])
    assert told.exit_code == 0, told.output
    assert "[rotor.rubber.friction]" in out.read_text()
    data = json.loads(CliRunner().invoke(app, ["rubber", table, "--json"]).output)
    assert data["elastic"] == pytest.approx(ab.measure.rubber(table).law.elastic)
    assert data["points"][0]["name"] == "line 4 (5 Hz, 0.03 mm)"
    for point in data["points"]:
        true = KNOWN.stiffness(point["amplitude"], point["frequency"], "line")
        assert point["fitted_stiffness"] == pytest.approx(true.real, rel=0.03)  # noise of 1 %
        assert point["fitted_loss"] == pytest.approx(true.imag, rel=0.12)  # noise of 3 %, another chain


def test_a_table_with_an_unknown_motion_or_a_missing_column_is_refused(tmp_path: Path):
    table = tmp_path / "one.csv"
    table.write_text("frequency [Hz], amplitude [mm], mass [kg], motion\n10, 0.1, 12, round\n")
    with pytest.raises(ResultError, match="line 2: motion: given 'round'; must be line or circle"):
        ab.measure.load_rubber(table)
    table.write_text("frequency [Hz], amplitude [mm], stiffness [N/m]\n10, 0.1, 12\n")
    with pytest.raises(ResultError, match="no column 'damping'"):
        ab.measure.load_rubber(table)
    table.write_text("frequency [Hz], amplitude [mm], mass [kg], motion\n10, 0.1, 12, circle\n9, 0.4, 12, circle\n")
    points = ab.measure.load_rubber(table)
    assert points.motion == ("circle", "circle")
    assert points.stiffness == pytest.approx(12.0 * (HERTZ * np.array([10.0, 9.0])) ** 2)


def test_the_picture_shows_curves_and_points():
    found = ab.measure.rubber(loops())
    figure = ab.plot.answer(found)
    stiffness, loss = figure.axes
    line = next(one for one in stiffness.lines if one.get_label().startswith("in a line"))
    at = np.interp(0.25, line.get_xdata(), line.get_ydata())
    assert at == pytest.approx(1e-3 * found.law.stiffness(2.5e-4, HERTZ * 12.5, "line").real, rel=1e-3)
    assert len(stiffness.containers) == len(loss.containers) == 1
    plt.close(figure)
    estimated = ab.plot.answer(found, points_label="amplitude estimated,")
    names = estimated.axes[0].get_legend_handles_labels()[1]
    assert "amplitude estimated, in a line" in names
    assert not any(name.startswith("measured") for name in names)
    plt.close(estimated)
    with pytest.raises(QuestionError, match="given a float; it draws a result of"):
        ab.plot.answer(3.0)
