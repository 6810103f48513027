"""The equilibrium-angle experiment from files: machine, table of measurements, evaluation, command line."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli import app
from autobalancer.drag.discoidal import discoidal
from autobalancer.errors import QuestionError, ResultError
from autobalancer.measurement.equilibrium_angles import (
    AngleSeries,
    TurnedRace,
    angle_machine,
    equilibrium_angles,
    fit_rolling_resistance,
    rolling_resistance_deviation,
)

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
MACHINE = EXAMPLES / "machines" / "equilibrium_angle.toml"
TABLE = EXAMPLES / "measurements" / "equilibrium_angles.csv"
RACE = "balancers[1].races[1]."
OILS = [(953.0, 298e-6), (939.0, 23e-6), (950.0, 50e-6), (876.0, 10e-6), (844.0, 5e-6)]


def made(race: TurnedRace, friction: float, noise: float, random: np.random.Generator) -> list[AngleSeries]:
    """Twelve angles from 8 to 82 degrees in each oil."""
    found = []
    for density, viscosity in OILS:
        series = AngleSeries(f"{viscosity:g}", np.empty(0), np.empty(0), density, viscosity)
        grid = np.geomspace(1e-2, 100.0, 20_001)
        angles = equilibrium_angles(series.race(race), discoidal(), grid, friction)
        speeds = np.interp(np.radians(np.linspace(8.0, 82.0, 12)), angles[angles < 1.5], grid[angles < 1.5])
        exact = equilibrium_angles(series.race(race), discoidal(), speeds, friction)
        measured = exact + math.radians(noise) * random.standard_normal(12)
        found.append(AngleSeries(series.name, speeds, measured, density, viscosity))
    return found


def test_the_simulated_ball_of_a_machine_file_climbs_as_the_statics_say() -> None:
    found = ab.measure.equilibrium_angle(MACHINE, np.linspace(1.0, 6.0, 12), simulation=True, duration=100.0)
    assert float(np.abs(found["simulated_angle"] - found["angle"]).max()) < math.radians(0.5)
    assert (np.diff(found["angle"].values) > 0.0).all()
    assert float(found["angle"][-1]) > math.radians(50.0)
    assert (found["angle_with_pressure"] < found["angle"]).all()


@pytest.mark.parametrize("law", [{"law": "cd_times_re", "cd_times_re": 387.0}, {"law": "viscous", "damping": 6.7e-4}])
def test_with_linear_drag_the_sine_of_the_angle_is_proportional_to_the_speed(law: dict[str, object]) -> None:
    machine = ab.with_parameter(
        ab.with_parameter(ab.load_machine(MACHINE), RACE + "drag", law), RACE + "friction", None
    )
    speeds = np.array([0.5, 1.0, 2.0])
    angle = ab.measure.equilibrium_angle(machine, speeds)["angle"].values
    given = angle_machine(machine)
    beta = law.get("damping", math.pi / 8.0 * 387.0 * 950.0 * 50e-6 * 0.0123 * 0.07695**2)
    np.testing.assert_allclose(np.sin(angle), beta * speeds / (given.race.weight * 0.07695), rtol=1e-9)  # type: ignore[operator]
    assert given.law.log_slope(1e4) == -1.0
    assert ab.laws.linear_drag_law(24.0).outside(1e9) == ""


def test_speeds_that_are_not_given_end_where_the_ball_stands_at_85_degrees() -> None:
    found = ab.measure.equilibrium_angle(MACHINE)
    assert math.degrees(float(found["angle"][-1])) == pytest.approx(85.0, abs=0.5)
    assert found.attrs["rolling_resistance"] == 0.05


@pytest.mark.parametrize(("pressure", "way"), [(0.0, "left out"), (3.0, "included")])
def test_each_evaluation_gives_back_friction_and_drag_of_its_own_balance_of_forces(pressure: float, way: str) -> None:
    given = angle_machine(MACHINE)
    race = given.race if not pressure else given.pressed
    assert race.pressure == pressure
    found = ab.measure.evaluate_angles(MACHINE, made(race, 0.08, 0.0, np.random.default_rng(0)), resamples=2)
    one, other = found.sel(pressure_force=way), found.drop_sel(pressure_force=way).isel(pressure_force=0)
    assert float(one["rolling_resistance"]) == pytest.approx(0.08, abs=1e-3)
    assert float(np.abs(one["drag_coefficient"] / one["law_coefficient"] - 1.0).max()) < 0.02
    assert float(np.abs(other["drag_coefficient"] / other["law_coefficient"] - 1.0).max()) > 5e-3


def test_the_standard_deviation_is_that_of_repeated_experiments() -> None:
    race, random = angle_machine(MACHINE).race, np.random.default_rng(3)
    fitted, deviations = [], []
    for _ in range(10):
        series = [(one.race(race), one.speeds, one.angles) for one in made(race, 0.05, 0.5, random)]
        fitted.append(fit_rolling_resistance(series))
        deviations.append(rolling_resistance_deviation(series, resamples=12))
    scatter = float(np.std(fitted, ddof=1))
    assert abs(float(np.mean(fitted)) - 0.05) < 2.0 * scatter / math.sqrt(10.0)
    assert 0.5 * scatter < float(np.mean(deviations)) < 2.0 * scatter


def test_more_noise_does_not_pull_the_coefficient_down() -> None:
    """Small angles say little; without their weights a degree of noise takes a tenth of the coefficient away."""
    race, random = angle_machine(MACHINE).race, np.random.default_rng(5)
    fitted = [
        fit_rolling_resistance([(one.race(race), one.speeds, one.angles) for one in made(race, 0.05, 1.0, random)])
        for _ in range(12)
    ]
    assert float(np.mean(fitted)) == pytest.approx(0.05, abs=2.5e-3)


def test_the_table_of_the_examples_gives_the_friction_with_which_it_was_made() -> None:
    found = ab.measure.evaluate_angles(MACHINE, ab.measure.load_angle_series(TABLE), resamples=20).sel(
        pressure_force="left out"
    )
    assert found.attrs["rolling_resistance_from"] == "fitted"
    assert abs(float(found["rolling_resistance"]) - 0.05) < 2.0 * float(found["rolling_resistance_deviation"])
    assert len(set(found["series"].values)) == 10


def test_fluids_of_a_table_are_described_named_or_those_of_the_machine(tmp_path: Path) -> None:
    def read(text: str) -> list[AngleSeries]:
        (tmp_path / "t.csv").write_text(text, encoding="utf-8")
        return ab.measure.load_angle_series(tmp_path / "t.csv")

    one, other = read("density [g/cm^3]; viscosity [cSt]; speed [Hz]; angle [rad]\n0,95; 50; 1; 0,5\n0,9; 20; 1; 0,5\n")
    assert (one.fluid_density, one.viscosity) == (pytest.approx(950.0), pytest.approx(50e-6))
    assert one.speeds[0] == pytest.approx(2.0 * math.pi)
    assert other.name == "fluid, 20 mm^2/s"
    named = read(
        "fluid, temperature [degC], speed [rpm], angle [deg]\nsilicone oil 50, 25, 10, 9\nsilicone oil 50, 40, 10, 7\n"
    )
    oils = [ab.catalog.fluid("silicone oil 50", 273.15 + t) for t in (25.0, 40.0)]
    assert [series.viscosity for series in named] == pytest.approx([oil.viscosity for oil in oils])
    (alone,) = read("speed [rpm], angle [deg]\n10, 9\n20, 18\n")
    race = angle_machine(MACHINE).race
    assert alone.race(race) == race
    found = ab.measure.evaluate_angles(MACHINE, [alone])
    assert found.attrs["rolling_resistance_from"] == "machine"
    assert (found["rolling_resistance"] == 0.05).all()


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("speed [rpm], angle\n1, 2\n", "no column 'angle' with a unit; the first line must name the columns"),
        ("speed [rpm], angle [mm]\n1, 2\n", "unit of column 'angle'"),
        ("speed [rpm], angle [deg]\n1, nan\n", "line 2, column 'angle': 'nan' is not a number"),
        ("speed [rpm], angle [deg]\n1\n", "line 2: 1 cells for 2 columns"),
        ("density [kg/m^3], speed [rpm], angle [deg]\n1, 1, 2\n", "column 'density' alone describes no fluid"),
        ("density [kg/m^3], viscosity [cSt], speed [rpm], angle [deg]\n1, 0, 1, 2\n", "'viscosity' holds 0"),
        (
            "fluid, speed [rpm], angle [deg]\nolive oil, 1, 2\n",
            "column 'fluid': .*; or describe the fluid by the columns",
        ),
    ],
)
def test_tables_that_cannot_be_read_are_refused_in_words(tmp_path: Path, text: str, says: str) -> None:
    (tmp_path / "t.csv").write_text(text, encoding="utf-8")
    with pytest.raises(ResultError, match=says):
        ab.measure.load_angle_series(tmp_path / "t.csv")


@pytest.mark.parametrize(
    ("path", "value", "says"),
    [
        ("axis", "vertical", "axis = 'horizontal'"),
        (RACE + "balls", [{"count": 2, "diameter": 0.0123, "density": 7800.0}], "has 2 balls"),
        (RACE + "eccentricity", 1e-5, "not circular and centered on the axis"),
        (RACE + "drag", {"law": "viscous", "damping": 0.0}, "the ball has no drag"),
    ],
)
def test_machines_that_do_not_fit_the_experiment_are_refused(path: str, value: object, says: str) -> None:
    with pytest.raises(QuestionError, match=says):
        angle_machine(ab.with_parameter(ab.load_machine(MACHINE), path, value))


def test_questions_that_make_no_sense_are_refused() -> None:
    steep = AngleSeries("", np.array([1.0]), np.array([1.7]))
    for question, says in (
        (lambda: ab.measure.equilibrium_angle(MACHINE, [2.0, 1.0]), "must ascend"),
        (lambda: ab.measure.equilibrium_angle(MACHINE, [1.0], simulation=True), "two speeds or more"),
        (lambda: ab.measure.equilibrium_angle(MACHINE, [50.0, 60.0], simulation=True), "the ball has no equilibrium"),
        (lambda: ab.measure.evaluate_angles(MACHINE, []), "no series"),
        (lambda: ab.measure.evaluate_angles(MACHINE, [steep]), "given angles up to 97.4 deg"),
        (lambda: ab.measure.evaluate_angles(MACHINE, [steep], rolling=-0.1), "given -0.1"),
    ):
        with pytest.raises(QuestionError, match=says):
            question()


def test_the_command_line_evaluates_a_table_and_keeps_result_and_picture(tmp_path: Path) -> None:
    out, plot = tmp_path / "angle.nc", tmp_path / "angle.svg"
    arguments = ["equilibrium-angle", str(MACHINE), "--measured", str(TABLE), "--resamples", "3"]
    told = CliRunner().invoke(app, [*arguments, "--out", str(out), "--plot", str(plot), "--json"])
    assert told.exit_code == 0, told.output
    numbers = json.loads(told.output)
    assert numbers["rolling_resistance"][0] == pytest.approx(0.05, abs=0.01)
    drawn = plot.read_text(encoding="utf-8")
    series = [entry.name for entry in ab.measure.load_angle_series(TABLE)]
    for text in ("Reynolds number", "drag coefficient $c_d$", "angle from the lowest point (°)", *series):
        assert f"<!-- {text} -->" in drawn  # what Matplotlib writes before a text
    assert ab.load_run(out)["drag_coefficient"].shape == (2, 120)
    told = CliRunner().invoke(app, [*arguments, "--rolling", "0.04", "--pressure"])
    assert "rolling resistance 0.04" in told.output
    assert "as given" in told.output


def test_the_command_line_shows_the_angle_over_the_speed(tmp_path: Path) -> None:
    out, plot = tmp_path / "angle.nc", tmp_path / "angle.png"
    arguments = [
        "equilibrium-angle",
        str(MACHINE),
        "--speeds",
        "5 rpm:60 rpm:12",
        "--out",
        str(out),
        "--plot",
        str(plot),
    ]
    told = CliRunner().invoke(app, arguments)
    assert told.exit_code == 0, told.output
    assert "statics" in told.output
    assert ab.load_run(out).sizes["speed"] == 12
    told = CliRunner().invoke(app, ["equilibrium-angle", str(MACHINE), "--json"])
    assert math.degrees(max(json.loads(told.output)["angle"])) == pytest.approx(85.0, abs=0.5)
    told = CliRunner().invoke(app, ["equilibrium-angle", str(MACHINE), "--measured", str(TABLE), "--simulate"])
    assert told.exit_code == 2
    assert "leave out --speeds and --simulate" in told.output
    told = CliRunner().invoke(app, ["equilibrium-angle", str(EXAMPLES / "machines" / "discoidal.toml")])
    assert told.exit_code == 2
    assert "axis = 'horizontal'" in told.output


def test_pictures_of_other_results_are_refused() -> None:
    found = ab.measure.equilibrium_angle(MACHINE, [1.0, 2.0])
    with pytest.raises(QuestionError, match=r"which is of a result of measure\.evaluate_angles"):
        ab.plot.answer(found, "measured_drag")
    evaluated = ab.measure.evaluate_angles(MACHINE, ab.measure.load_angle_series(TABLE), rolling=0.05)
    with pytest.raises(QuestionError, match=r"which is of a result of measure\.equilibrium_angle"):
        ab.plot.answer(evaluated, "equilibrium_angle")
    with pytest.raises(QuestionError, match="'left out' or 'included'"):
        ab.plot.answer(evaluated, pressure_force="both")
