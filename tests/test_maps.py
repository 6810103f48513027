"""Stability maps: the compiled growth rate against the linearized equations, and what a map and its pictures say."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.references.planar_linear import matrices
from tests.references.planar_states import equilibria_of
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.assembly.quantities import with_quantity, with_value_at
from autobalancer.cli import app
from autobalancer.errors import AutobalancerError, MachineError, QuestionError
from autobalancer.machine import Machine
from autobalancer.stability.host.stations import Plane, plane
from autobalancer.stability.maps.balanced import (
    PlanarBalancer,
    balanced_states,
    growth_rate,
    growth_rates,
    planar_eigenvalues,
    scaled_growth_rates,
)
from autobalancer.stability.states.linearized import deciding_eigenvalues, eigensystem

MACHINES = Path(__file__).parents[1] / "examples" / "machines"
DISCOIDAL = MACHINES / "discoidal.toml"


def random_plane(random: np.random.Generator, count: int = 2) -> Plane:
    """An isotropic machine with equal balls and an unbalance that they can balance."""
    mass, critical = random.uniform(1.0, 30.0), 10 ** random.uniform(1.0, 3.0)
    orbit, ball = random.uniform(0.03, 0.2), 10 ** random.uniform(-3.5, -1.0) * mass / count
    inertia = random.uniform(1.0, 3.0) * ball * orbit**2
    ones = np.ones(count)
    return Plane(
        mass=mass,
        stiffness=(mass * critical**2,) * 2,
        damping=(10 ** random.uniform(-3.0, 0.3) * mass * critical,) * 2,
        unbalance=complex(random.uniform(0.02, 0.98) * count * ball * orbit * np.exp(1j * random.uniform(-3.0, 3.0))),
        ball_mass=ball * ones,
        moment=ball * orbit * ones,
        inertia=inertia * ones,
        drag=10 ** random.uniform(-4.0, 1.0) * inertia * critical * ones,
        race=np.zeros(count, np.int64),
        offset=np.zeros(count, np.complex128),
    )


@pytest.mark.parametrize("seed", range(40))
def test_the_compiled_growth_rate_is_that_of_the_linearized_equations(seed: int) -> None:
    random = np.random.default_rng(seed)
    p = random_plane(random, 2 + seed % 3)
    critical = math.sqrt(p.stiffness[0] / p.mass)
    balancer = PlanarBalancer(p.mass, p.stiffness[0], p.damping[0], p.moment.size, p.moment[0], p.inertia[0], p.drag[0])
    speeds = critical * 10 ** random.uniform(-0.5, 1.2, 30)
    expected, spreads = [], []
    for speed in speeds:
        state = next(s for s in equilibria_of(p, float(speed)) if s.name == "balanced")
        values, _ = eigensystem(*matrices(p, float(speed), state))
        expected.append(float(deciding_eigenvalues(values, state.freedom).real.max()))
        spreads.append(abs(np.exp(2j * state.angles).sum()))
    rates, _ = growth_rates(balancer, speeds, np.array(spreads))
    assert np.abs(rates - expected).max() < 1e-9 * critical


def test_the_compiled_growth_rate_and_frequency_are_those_of_numpy_at_ten_thousand_random_points() -> None:
    random = np.random.default_rng(1)
    n = 10_000
    points = np.column_stack(
        [10 ** random.uniform(a, b, n) for a, b in ((-1.0, 1.6), (-3.0, 0.3), (-5.0, 1.5), (-5.0, -0.4))]
        + [random.uniform(0.0, 1.0, n)]
    )
    rates, frequencies = scaled_growth_rates(points, 1.0)
    for row in random.integers(0, n, 1500):
        w, g, d, h, q = points[row]
        values = planar_eigenvalues(PlanarBalancer(1.0, 1.0, g, 2, math.sqrt(h), 1.0, d), w, 2.0 * q)
        best = values[np.argmax(values.real)]
        assert rates[row] == pytest.approx(best.real, abs=1e-9)
        nearest = values[np.abs(values.real - best.real) < 1e-8]
        assert np.abs(np.abs(nearest.imag) - frequencies[row]).min() < 1e-6


def test_degenerate_points_have_a_growth_rate_too() -> None:
    grid = ([0.01, 1.0, 1.0000001, 5.0, 1000.0], [0.0, 2.0, 5.0], [0.0, 1e-9, 3.0, 1e4], [1e-12, 0.45], [0.0, 0.5, 1.0])
    points = np.array(np.meshgrid(*grid)).reshape(5, -1).T
    rates, _ = scaled_growth_rates(np.ascontiguousarray(points), 1.0)
    assert np.isfinite(rates).all()
    for (w, g, d, h, q), rate in zip(points, rates, strict=True):
        expected = growth_rate(PlanarBalancer(1.0, 1.0, g, 2, math.sqrt(h), 1.0, d), w, 2.0 * q)
        assert rate == pytest.approx(expected, abs=3e-7 * max(1.0, w))  # double roots know half of the digits


def test_a_map_has_the_growth_rates_of_its_machines() -> None:
    machine = ab.load_machine(DISCOIDAL)
    speeds, viscosities = ["60 rad/s", "64 rad/s", "90 rad/s"], [1e-6, "20 mm^2/s"]
    found = ab.stability.map(machine, {"speed": speeds, "viscosity": viscosities})
    assert found["growth_rate"].dims == ("speed", "viscosity")
    for viscosity in (1e-6, 20e-6):
        changed = with_quantity(machine, "viscosity", viscosity)
        expected = ab.stability.eigenvalues(changed, [60.0, 64.0, 90.0])["growth_rate"].values
        assert found["growth_rate"].sel(viscosity=viscosity).values == pytest.approx(expected, abs=1e-9 * 60.0)
        at = found.isel(viscosity_of_border=int(viscosity > 1e-5))
        for border in ab.stability.borders(changed):
            variable = border.name.replace(", ", "_").replace(" ", "_")
            assert float(at[variable]) == border.speed
    turned = ab.stability.map(machine, {"viscosity": viscosities, "speed": speeds}, borders=0)
    assert turned["growth_rate"].equals(found["growth_rate"].transpose("viscosity", "speed"))
    assert "exact_border" not in turned


def test_threads_do_not_change_a_map() -> None:
    axes = {"speed": np.linspace(40.0, 130.0, 60), "unbalance": np.linspace(0.0, 1.2e-3, 50)}
    one, two = (ab.stability.map(DISCOIDAL, axes, borders=0, workers=n)["growth_rate"] for n in (1, 2))
    assert one.equals(two)


def test_the_exact_border_is_the_zero_of_the_growth_rate() -> None:
    speeds = np.linspace(60.0, 100.0, 401)
    found = ab.stability.map(DISCOIDAL, {"speed": speeds, "viscosity": np.geomspace(1e-6, 50e-6, 9)})
    for number, border in enumerate(found["exact_border"].values):
        rates = found["growth_rate"].isel(viscosity=number).values
        assert (rates[speeds > border] < 0.0).all()
        assert rates[speeds < border][-1] > 0.0


def test_a_map_over_the_unbalance_ends_at_the_capability_and_is_symmetric_to_right_angles_by_s2() -> None:
    machine = ab.load_machine(DISCOIDAL)
    ball = float(plane(machine).moment[0])
    shares = np.array([0.3, math.sqrt(4.0 - 0.3**2), 2.001])  # |S2| = |share^2 - 2| is the same for the first two
    found = ab.stability.map(machine, {"unbalance": shares * ball, "speed": [62.0, 80.0]}, borders=0)["growth_rate"]
    assert found[1].values == pytest.approx(found[0].values, rel=1e-8)
    assert np.isnan(found[2]).all()


def test_a_map_at_one_speed_takes_that_of_the_drive() -> None:
    axes = {"viscosity": [1e-6, 1e-5], "ball_mass": ["5 g", "7 g", "8 g"]}
    at_end = ab.stability.map(DISCOIDAL, axes)
    assert at_end.attrs["speed"] == pytest.approx(1200.0 * math.pi / 30.0)
    again = ab.stability.map(DISCOIDAL, axes, speed="1200 rpm")
    assert again["growth_rate"].equals(at_end["growth_rate"])
    row = ab.stability.map(DISCOIDAL, {"speed": ["1200 rpm"], "viscosity": [1e-5]}, borders=0)
    own = with_quantity(with_quantity(ab.load_machine(DISCOIDAL), "viscosity", 1e-5), "ball_mass", "7 g")
    assert float(at_end["growth_rate"][1, 1]) == pytest.approx(
        float(ab.stability.eigenvalues(own, [at_end.attrs["speed"]])["growth_rate"][0]), abs=1e-8
    )
    assert row["growth_rate"].shape == (1, 1)


def test_maps_of_unequal_balls_and_orthotropic_supports_are_those_of_eigenvalues() -> None:
    machine = ab.load_machine(DISCOIDAL)
    balls = [{"count": 1, "mass": f"{mass} g", "diameter": "12 mm"} for mass in (7.0, 9.0)]
    for changed, route in (
        (with_value_at(machine, "balancers[1].races[1].balls", balls), "eigenvalues"),
        (with_value_at(machine, "rotor.stiffness", ("40 kN/m", "50 kN/m")), "multipliers of a rotor at rest"),
    ):
        assert balanced_states(plane(changed))[0].route == route
        found = ab.stability.map(changed, {"speed": [66.0, 90.0], "viscosity": [2e-5, 5e-5]}, borders=0)
        assert route in found.attrs["theory"]
        expected = ab.stability.eigenvalues(with_quantity(changed, "viscosity", 2e-5), [66.0, 90.0])[
            "growth_rate"
        ].values
        assert found["growth_rate"][:, 0].values == pytest.approx(expected, abs=1e-6)


def test_of_many_balls_the_worst_positions_are_less_stable_than_the_best() -> None:
    machine = with_quantity(ab.load_machine(DISCOIDAL), "count", 4)
    axes = {"speed": np.linspace(62.0, 80.0, 10), "viscosity": [2e-6]}
    worst, best = (
        ab.stability.map(machine, axes, positions=which, borders=0)["growth_rate"] for which in ("worst", "best")
    )
    assert (worst.values >= best.values).all()
    assert (worst.values > best.values + 1e-4).any()


def test_operating_points_and_fluids_are_marked_where_they_are() -> None:
    found = ab.stability.map(
        DISCOIDAL,
        {"speed": [50.0, 130.0], "viscosity": [1e-6, 60e-6]},
        operating_points={"measured": ("64 rad/s", "0.65 mm^2/s")},
        borders=0,
    )
    assert list(found["operating_point"].values) == ["Discoidal rotor, planar stand-in", "measured"]
    assert found["operating_viscosity"].values == pytest.approx([20e-6, 0.65e-6], rel=1e-9)
    assert found["operating_speed"].values == pytest.approx([40.0 * math.pi, 64.0])
    names = list(found["fluid"].values)
    assert "silicone oil 20" in names
    assert "silicone oil 100" not in names
    assert float(found["fluid_viscosity"].sel(fluid="silicone oil 20")) == pytest.approx(20e-6, rel=1e-9)


@pytest.mark.parametrize("factor", [0.2, 5.0])
def test_a_map_scales_with_time(factor: float) -> None:
    p = random_plane(np.random.default_rng(3))
    faster = replace(
        p,
        stiffness=(factor**2 * p.stiffness[0],) * 2,
        damping=(factor * p.damping[0],) * 2,
        drag=factor * p.drag,
    )
    speeds = math.sqrt(p.stiffness[0] / p.mass) * np.linspace(0.5, 4.0, 30)
    one, other = (balanced_states(q)[0].rates(w) for q, w in ((p, speeds), (faster, factor * speeds)))
    assert other == pytest.approx(factor * one, rel=1e-9)


AXES = {"speed": [50.0, 130.0], "viscosity": [1e-6, 60e-6]}


@pytest.mark.parametrize(
    ("axes", "options", "message"),
    [
        ({"speed": [1.0]}, {}, "given 1 parameters; give two"),
        ({"speed": [1.0], "sped": [1.0]}, {}, "'sped' is not a parameter; available are speed, viscosity"),
        ({"speed": [], "drag": [1.0]}, {}, "given no values"),
        ({"speed": [0.0, 1.0], "drag": [1.0]}, {}, "must be greater than zero"),
        (AXES, {"speed": 3.0}, "given twice"),
        (AXES, {"positions": "median"}, "must be 'worst' or 'best'"),
        (AXES, {"operating_points": {"p": (1.0,)}}, "given 1 values"),
        ({"drag": [1.0], "viscosity": [1.0]}, {"speed": -1.0}, "must be greater than zero"),
    ],
)
def test_bad_maps_are_refused_with_a_reason(axes: dict[str, Any], options: dict[str, Any], message: str) -> None:
    with pytest.raises(QuestionError, match=re.escape(message)):
        ab.stability.map(DISCOIDAL, axes, **options)


def test_an_impossible_combination_is_named() -> None:
    with pytest.raises(MachineError, match=r"ball_diameter = 0\.03"):
        ab.stability.map(DISCOIDAL, {"speed": [100.0], "ball_diameter": ["10 mm", "30 mm"]}, borders=0)
    with pytest.raises(QuestionError, match="neither an axis nor prescribed"):
        ab.stability.map(MACHINES / "stall_and_release.toml", {"drag": [1e-4], "ball_mass": [1e-3]})


@pytest.fixture(scope="module")
def thin_map() -> xr.Dataset:
    machine = with_quantity(ab.load_machine(DISCOIDAL), "viscosity", "0.65 mm^2/s")
    return ab.stability.map(
        machine, {"speed": np.linspace(50.0, 130.0, 41), "viscosity": np.geomspace(2e-7, 1e-4, 41)}, borders=21
    )


def labels(figure: Any) -> list[str]:
    return [text.get_text() for text in figure.legends[0].get_texts()]


def test_the_picture_of_a_map_names_every_border_and_has_the_units_asked_for(thin_map: xr.Dataset) -> None:
    figure = ab.plot.map(thin_map, speed_unit="rad/s")
    for name in ("averaged border", "exact border", "exact border, worst case", "release speed", "critical speed"):
        assert name in labels(figure)
    axes = figure.axes[0]
    assert "(rad/s)" in axes.get_xlabel()
    assert "(mm²/s)" in axes.get_ylabel()
    assert axes.get_yscale() == "log"
    assert any(text.get_text() == "silicone oil 0.65" for text in axes.texts)
    exact = next(line for line in axes.get_lines() if line.get_label() == "exact border")
    assert np.allclose(exact.get_xdata(), thin_map["exact_border"])
    turned = ab.plot.map(thin_map, x="viscosity", speed_unit="Hz", fluids=False).axes[0]
    assert "(Hz)" in turned.get_ylabel()
    assert not turned.texts


def absent(figure: Any) -> str:
    return " ".join(figure.legends[0].get_title().get_text().split())


def test_a_border_outside_the_picture_has_no_key_but_is_named() -> None:
    machine = with_quantity(ab.load_machine(DISCOIDAL), "viscosity", "0.65 mm^2/s")
    axes = {"speed": np.linspace(50.0, 130.0, 21), "unbalance": np.linspace(0.0, 1.2e-3, 21)}
    figure = ab.plot.map(ab.stability.map(machine, axes))
    assert "averaged border (never)" in absent(figure)
    assert "release speed (above it)" in absent(figure)
    assert "no balanced state" in labels(figure)
    drawn = {str(line.get_label()) for line in figure.axes[0].get_lines()}
    assert set(labels(figure)) - drawn <= {"no balanced state", machine.name}  # a patch, and the mark of the machine
    assert not any(name in entry for entry in labels(figure) for name in ("averaged", "release"))


def test_a_map_over_the_temperature_is_in_degrees_celsius() -> None:
    found = ab.stability.map(
        DISCOIDAL,
        {"speed": [60.0, 125.0], "temperature": ["10 degC", "60 degC"]},
        operating_points={"warm": (100.0, "40 degC")},
        borders=3,
    )
    figure = ab.plot.map(found)
    axes = figure.axes[0]
    assert axes.get_ylabel() == "temperature of the fluid, $T$ (°C)"
    assert axes.get_ylim() == pytest.approx((10.0, 60.0))
    exact = next(line for line in axes.get_lines() if line.get_label() == "exact border")
    assert exact.get_ydata()[[0, -1]] == pytest.approx([10.0, 60.0])
    marks = [float(line.get_ydata()[0]) for line in axes.get_lines() if line.get_marker() in ("o", "D")]
    assert any(abs(mark - 40.0) < 1e-9 for mark in marks)


def test_a_map_without_the_speed_has_release_and_capture_of_each_of_its_machines() -> None:
    machine = with_quantity(ab.load_machine(DISCOIDAL), "viscosity", "0.65 mm^2/s")
    axes = {"viscosity": np.geomspace(5e-7, 5e-6, 5), "ball_mass": np.linspace(4e-3, 8e-3, 5)}
    found = ab.stability.map(machine, axes, speed=150.0)
    one = with_quantity(with_quantity(machine, "viscosity", axes["viscosity"][1]), "ball_mass", axes["ball_mass"][2])
    for border in ab.stability.borders(one, only=("release speed", "capture speed"), up_to=150.0):
        table = found[border.name.replace(" ", "_")].transpose("viscosity_of_border", "ball_mass_of_border")
        assert float(table[1, 2]) == pytest.approx(border.speed, rel=1e-12)
    assert "release speed as high as the speed of the map" in labels(ab.plot.map(found))


def test_the_picture_of_a_border_curve_names_its_lines() -> None:
    machine = with_quantity(ab.load_machine(DISCOIDAL), "viscosity", "0.65 mm^2/s")
    found = ab.stability.border_curve(machine, "unbalance", np.linspace(0.0, 1.1e-3, 12))
    assert np.isnan(found["exact_border"][-1]), "the balls cannot balance so much"
    line = next(line for line in ab.plot.answer(found).axes[0].lines if line.get_label() == "exact border")
    ends = np.asarray(line.get_xdata())[np.isfinite(np.asarray(line.get_ydata()))]
    assert ends[-1] == pytest.approx(1e6 * found.attrs["capability"]), "the line ends where the balls balance no more"
    assert "not of this one" in str(found["averaged_border_note"][-1].item())
    assert "not of this one" not in str(found["averaged_border_note"][0].item())
    figure = ab.plot.answer(found, speed_unit="rad/s")
    assert "averaged border (never)" in absent(figure)
    assert "release speed (30" in absent(figure)
    assert "exact border" in labels(figure)
    assert not any(name in entry for entry in labels(figure) for name in ("averaged", "release"))


def test_the_title_of_border_speeds_names_only_those_that_are_drawn() -> None:
    cases = (
        (("exact border",), {"exact border ignores"}),
        (("exact border", "averaged border"), {"averaged and exact border ignore "}),
    )
    for only, words in cases:
        figure = ab.plot.answer(
            ab.stability.border_curve("docs/machines/real_race.toml", "stiffness", [9e4, 1e5], only=only)
        )
        assert [word in figure.get_suptitle() for word in words] == [True]
        assert ("averaged border" in labels(figure)) == ("averaged" in figure.get_suptitle())


def test_the_picture_of_the_eigenvalues_shades_the_verdicts_and_names_the_motion() -> None:
    found = ab.stability.eigenvalues(DISCOIDAL, list(np.linspace(40.0, 125.0, 60)))
    figure = ab.plot.answer(found, speed_unit="rad/s")
    upper, lower = figure.axes
    assert {"stable", "unstable"} <= {text.get_text() for text in upper.get_legend().get_texts()}
    motions = {f"leading mode: {motion}" for motion in found["leading_motion"].values}
    assert any(text.get_text() in motions for text in upper.texts)
    assert "rad/s" in lower.get_xlabel()


@pytest.mark.parametrize("located", [True, False])
def test_the_shade_of_stability_begins_at_the_border(located: bool) -> None:
    found = ab.stability.eigenvalues(DISCOIDAL, [50.0, 62.0, 71.0, 100.0])
    ranges = ab.stability.ranges(DISCOIDAL, found) if located else None
    upper = ab.plot.answer(found, speed_unit="rad/s", ranges=ranges).axes[0]
    stable = next(patch for patch in upper.patches if patch.get_label() == "stable")
    begin = stable.get_x()
    line = next(line for line in upper.get_lines() if line.get_label() == "greatest real part")
    border = {entry.name: entry.speed for entry in ab.stability.borders(DISCOIDAL)}["exact border"]
    assert abs(begin - border) < (1e-5 if located else 4.0)
    assert float(np.interp(begin, line.get_xdata(), line.get_ydata())) == pytest.approx(0.0, abs=1e-9)


def test_pictures_of_something_else_are_refused(thin_map: xr.Dataset) -> None:
    for call, message in (
        (lambda: ab.plot.map(xr.Dataset()), "not a result of stability.map"),
        (lambda: ab.plot.map(thin_map, x="drag"), "must be 'speed' or 'viscosity'"),
        (lambda: ab.plot.map(thin_map, speed_unit="mph"), "must be 'rpm'"),
        (lambda: ab.plot.map(thin_map.isel(speed=[0])), "one value along an axis"),
        (lambda: ab.plot.answer(thin_map, "eigenvalues"), "is of a result of stability.eigenvalues; .* there are map"),
        (lambda: ab.plot.answer(thin_map, highest=9.0), "no argument 'highest' for the picture 'map'; there are"),
        (lambda: ab.plot.answer(ab.stability.eigenvalues(DISCOIDAL, [100.0])), "one speed only"),
    ):
        with pytest.raises(QuestionError, match=message):
            call()


def run(*arguments: str, code: int = 0) -> str:
    result = CliRunner(env={"COLUMNS": "200"}).invoke(app, list(arguments))
    assert result.exit_code == code, result.output
    return re.sub(r"\x1b\[[0-9;]*m", "", result.output)


def test_the_commands_print_what_the_functions_return(tmp_path: Path) -> None:
    file = str(DISCOIDAL)
    text = run("eigenvalues", file, "--speeds", "500 rpm:1500 rpm:12", "--plot", str(tmp_path / "s.png"))
    assert re.search(r"621\.47 +1500 +stable", text), "the border is located between the speeds"
    text = run(
        *("map", file, "--x", "speed=50:130 rad/s:9", "--y", "viscosity=0.2:100 mm^2/s:9:log"),
        *("--out", str(tmp_path / "m.nc"), "--plot", str(tmp_path / "m.svg"), "--point", "p=64 rad/s, 1 mm^2/s"),
    )
    assert "81 points, 81 with a balanced state" in text
    assert ab.load_run(tmp_path / "m.nc")["growth_rate"].shape == (9, 9)
    text = run(
        *(
            "borders",
            file,
            "--over",
            "count=2:4:3",
            "--plot",
            str(tmp_path / "b.pdf"),
            "--windows",
            "--up-to",
            "3000 rpm",
        ),
        *("--minimum-viscosity-at", "1200 rpm"),
    )
    assert "exact border               621.47 rpm" in text
    assert "exact border: 0.07558 mm^2/s" in text
    assert {path.name for path in tmp_path.iterdir()} == {"s.png", "m.nc", "m.svg", "b.pdf"}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("eigenvalues", "--speeds", "5:1 rpm:2"), "must ascend"),
        (("eigenvalues", "--speeds", "5:1"), "without a unit"),
        (("eigenvalues", "--speeds", "5 rpm", "--state", "lost"), "must be 'balanced'"),
        (("map", "--x", "speed=1:2 rpm:3", "--y", "speed=1:2 rpm:3"), "two different parameters"),
        (("map", "--x", "speed=1:2 rpm", "--y", "drag=1:2 N*m*s:3"), "from:to:count"),
        (("map", "--x", "speed=0:2 rpm:3:log", "--y", "drag=1:2 N*m*s:3"), "ends above zero"),
        (("map", "--x", "speed", "--y", "drag=1:2 N*m*s:3"), "NAME=from:to:count"),
        (("borders", "--plot", "x.png"), "name it with --over"),
        (("borders", "--over", "damping"), "give those of 'damping'"),
    ],
)
def test_a_command_that_makes_no_sense_ends_with_code_2(arguments: tuple[str, ...], message: str) -> None:
    name, *rest = arguments
    assert message in " ".join(run(name, str(DISCOIDAL), *rest, code=2).split())


def test_all_errors_are_of_the_package() -> None:
    machine = with_value_at(ab.load_machine(DISCOIDAL), "balancers", ())
    assert isinstance(machine, Machine)
    for ask in (ab.stability.borders, ab.stability.minimum_viscosity, ab.stability.stable_windows):
        with pytest.raises(AutobalancerError):
            ask(machine, *(() if ask is ab.stability.borders else (80.0,)))
