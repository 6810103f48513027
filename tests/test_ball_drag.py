"""Drag of a ball in its race by finite elements: exact solutions, reciprocity, thin films, closed races, refusals."""

from __future__ import annotations

import json
import math
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli import app
from autobalancer.errors import MachineError, QuestionError, UnitError
from autobalancer.flow.ball_problem import BallForces, ball_forces
from autobalancer.flow.finite_elements import Fineness, Flow, Shape, developed, slow_flow, spaces
from autobalancer.laws.impacts import film_slopes

pytest.importorskip("gmsh", exc_type=(ImportError, OSError))
pytest.importorskip("skfem")
ROOT = Path(__file__).parents[1]
DISCOIDAL = ROOT / "examples/machines/discoidal.toml"
STOKES = 6.0 * math.pi
WIDE = Fineness(0.2, 0.35, 5.0, 0.7)
COARSE = Fineness(0.35, 0.4, 0.8, 0.8)
RIG = ab.flow.Channel(0.0123, 0.0138, 0.02)  # Spannan 2021, table 6.2


meshed = cache(spaces)


@cache
def slow(shape: Shape, fineness: Fineness, share: float) -> Flow:
    mesh = meshed(shape, fineness)
    return slow_flow(mesh, share * mesh.rolling)


def forces(shape: Shape, fineness: Fineness, share: float = 0.0) -> BallForces:
    return ball_forces(slow(shape, fineness, share))


def test_films_on_a_plane_have_the_logarithms_of_goldman_cox_and_brenner() -> None:
    slides, rolls = film_slopes(0.0), film_slopes(-1.0)
    assert slides.force / STOKES == pytest.approx(-8.0 / 15.0)
    assert slides.torque / (8.0 * math.pi) == pytest.approx(-1.0 / 10.0)
    assert (rolls.force - slides.force) / STOKES == pytest.approx(2.0 / 15.0)
    assert (rolls.torque - slides.torque) / (8.0 * math.pi) == pytest.approx(2.0 / 5.0)


SMALL = Shape(2.24, 3.25, 0.1, 3.5, 3.5, 12.5)


def test_force_of_a_turn_and_torque_of_a_slide_are_equal() -> None:
    """Lorentz' reciprocal theorem, which the discrete equations obey exactly."""
    sliding, rolling = (forces(replace(SMALL, orbit=math.inf), COARSE, share) for share in (0.0, 1.0))
    assert rolling.along - sliding.along == pytest.approx(sliding.torque, abs=1e-5)
    assert sliding.torque > 1.0


def test_slow_flow_is_the_same_ahead_and_behind_and_lifts_no_ball() -> None:
    flow = slow(SMALL, COARSE, 1.0)
    assert abs(ball_forces(flow).lift) < 0.01 * ball_forces(flow).along


@pytest.mark.slow
def test_a_ball_between_two_planes_is_dragged_as_faxen_found() -> None:
    """Happel and Brenner (1983), 7-4.28; two lengths of the planes are continued to infinite ones, by the inverse square."""
    k = 0.25  # radius over the distance to each plane
    faxen = 1.0 / (1.0 - 1.004 * k + 0.418 * k**3 + 0.21 * k**4 - 0.169 * k**5)
    mesh = Fineness(0.2, 0.3, 3.5, 0.7)
    near, far = (forces(Shape(8.0, length, 3.0, length / 2, length / 2), mesh).along for length in (48.0, 96.0))
    assert (far + (far - near) / 3.0) / STOKES == pytest.approx(faxen, rel=0.007)


@pytest.mark.slow
def test_a_ball_near_a_plane_is_dragged_as_goldman_cox_and_brenner_found() -> None:
    film = 0.02  # their expansions with the next terms, in gap log gap
    log = math.log(1.0 / film)
    slides = 8.0 / 15.0 * log + 0.9588 + 64.0 / 375.0 * film * log
    tips = 1.0 / 10.0 * log - 0.1895 + 43.0 / 250.0 * film * log
    turns = 2.0 / 5.0 * log + 0.3817 + 66.0 / 125.0 * film * log
    shape, mesh = Shape(50.0, 50.0, film, 30.0, 30.0), Fineness(0.15, 0.35, 6.0, 0.5)
    sliding, rolling = (forces(shape, mesh, share) for share in (0.0, 1.0))
    assert sliding.along / STOKES == pytest.approx(slides, rel=0.01)
    assert sliding.torque / (8.0 * math.pi) == pytest.approx(-tips, abs=0.008)
    assert rolling.torque / (8.0 * math.pi) == pytest.approx(turns - tips, rel=0.015)


@pytest.mark.slow
def test_the_drag_grows_by_the_theory_of_films_as_the_gap_of_the_mesh_closes() -> None:
    """To a few percent: its next terms are of the order of the gap."""
    shapes = [Shape(2.24, 3.25, gap, 5.0, 5.0, 12.5) for gap in (0.02, 0.01)]
    wide, narrow = (forces(shape, Fineness(across=0.5), 1.0) for shape in shapes)
    slopes, unit = film_slopes(-1.08, -1.08, 13.51), math.log(2.0)
    assert narrow.along - wide.along == pytest.approx(-slopes.force * unit, rel=0.08)
    assert narrow.torque - wide.torque == pytest.approx(slopes.torque * unit, rel=0.08)


def test_pressure_drives_through_a_square_duct_what_the_series_of_poiseuille_says() -> None:
    square = Shape(2.0, 2.0, 0.1, 5.0, 5.0)
    empty = np.zeros(0)
    odd = np.arange(1, 200, 2)
    share = 1.0 - 192.0 / math.pi**5 * np.sum(np.tanh(0.5 * math.pi * odd) / odd**5)
    assert developed(square, empty, empty).drop == pytest.approx(12.0 / (2.0**2 * share), rel=1e-4)
    bent = Shape(2.0, 2.0, 0.1, 5.0, 5.0, 2000.0)
    assert developed(bent, empty, empty).drop == pytest.approx(developed(square, empty, empty).drop, rel=1e-3)


@pytest.mark.slow
def test_where_the_mesh_of_a_closed_race_ends_does_not_matter() -> None:
    around = 2.0 * math.pi * 12.5
    found = [slow(Shape(2.24, 3.25, 0.1, n, n, 12.5, rest=around - 2 * n), COARSE, 1.0) for n in (4.5, 7.0)]
    assert found[0].through == pytest.approx(found[1].through, rel=0.01)
    assert ball_forces(found[0]).drag() == pytest.approx(ball_forces(found[1]).drag(), rel=0.01)
    still = forces(Shape(2.24, 3.25, 0.1, 4.5, 4.5, 12.5), COARSE, 1.0)
    assert ball_forces(found[0]).drag() < 0.9 * still.drag(), "a ball in a closed race takes fluid along"


@pytest.mark.slow
def test_a_finer_mesh_differs_by_less_and_less() -> None:
    shape = Shape(2.24, 3.25, 0.1, 4.0, 4.0)
    values = [forces(shape, COARSE.finer(factor), 1.0).drag() for factor in (1.0, 1.5, 2.25)]
    assert abs(values[2] - values[1]) < 0.5 * abs(values[1] - values[0])
    assert values[2] == pytest.approx(values[1], rel=0.01)


def test_the_line_of_a_result_is_the_drag_of_a_machine_file(tmp_path: Path) -> None:
    found = ab.flow.ball_drag(DISCOIDAL, [0.0, 5.0], gap="10 um", mesh_gap=0.1, fineness=0.5)
    text = DISCOIDAL.read_text(encoding="utf-8")
    (line,) = (line for line in text.splitlines() if line.startswith("drag"))
    path = tmp_path / "computed.toml"
    path.write_text(text.replace(line, found.attrs["drag"]), encoding="utf-8")
    law = ab.load_machine(path).balancers[0].races[0].drag
    assert law is not None
    assert law.law == "table"
    np.testing.assert_allclose(np.multiply(law.reynolds, law.coefficient), found["cd_times_re"], rtol=1e-3)
    assert float(found.cd_times_re[1] / found.cd_times_re[0]) == pytest.approx(1.0, abs=0.02), (
        "Stokes' range ends above Re = 5"
    )
    decades = math.log10(0.1 * 6.15e-3 / 1e-5)
    film = decades * found.attrs["cd_times_re_per_decade"]
    assert float(found.cd_times_re[0] - found.cd_times_re_of_mesh[0]) == pytest.approx(film)


@pytest.mark.slow
def test_two_balls_of_a_race_take_more_fluid_along_than_one_and_feel_less_drag() -> None:
    orbit = 0.07695
    one, two = (
        ab.flow.ball_drag(
            ab.flow.Channel(0.0123, 0.0138, 0.02, orbit, 2.0 * math.pi * orbit / count), [0.0], gap=1e-5, fineness=0.6
        )
        for count in (1, 2)
    )
    assert float(two.through_flow[0]) > 1.5 * float(one.through_flow[0])
    assert float(two.cd_times_re[0]) < 0.95 * float(one.cd_times_re[0])


@pytest.mark.slow
def test_two_balls_in_line_share_the_drag_as_stimson_and_jeffery_found() -> None:
    """0.702 of the drag of one at 1.543 diameters (1926); walls, 50 radii away, hold two balls back more than one."""
    mesh, walls = Fineness(0.25, 0.3, 10.0, 0.7), 1.9 / 50.0
    shape = Shape(100.0, 100.0, 49.0, 60.0, 60.0)
    alone, pair = forces(shape, mesh).along, slow(replace(shape, second=2.0 * 1.5431), mesh, 0.0)
    ratio = 0.7018 * (1.0 - walls) / (1.0 - 2.0 * 0.7018 * walls)
    for ball in (0, 1):
        assert ball_forces(pair, ball).along / alone == pytest.approx(ratio, rel=0.015)


@pytest.mark.slow
def test_a_ball_behind_another_is_shielded_and_both_are_drawn_and_kept(tmp_path: Path) -> None:
    channel = ab.flow.Channel(0.0123, 0.0138, 0.02, 0.07695)
    options = {"gap": 1e-5, "mesh_gap": 0.1, "fineness": 0.5}
    alone, pair = (ab.flow.ball_drag(channel, [0.0, 20.0], **options, ball_ahead=far) for far in (None, 0.016))  # type: ignore[arg-type]
    assert 0.9 < float(pair.cd_times_re[0] / alone.cd_times_re[0]) < 1.0, (
        "slow fluid has to be pushed past each of them"
    )
    behind, ahead = pair.cd_times_re.values, pair.cd_times_re_ahead.values
    assert behind[0] == pytest.approx(ahead[0], rel=0.05), "slow flow takes no side; a mesh as coarse as this one does"
    assert behind[1] / behind[0] < ahead[1] / ahead[0], "with inertia the ball behind feels less"
    ab.save_run(pair, tmp_path / "pair.nc")
    axes = ab.plot.answer(tmp_path / "pair.nc").axes
    assert len(axes[0].patches) >= 2
    assert axes[1].get_ylabel() == r"$c_d\,\mathrm{Re}$"


def test_the_command_prints_what_the_function_finds(tmp_path: Path) -> None:
    command = [
        "ball-drag",
        str(DISCOIDAL),
        "--gap",
        "10 um",
        "--reynolds",
        "0",
        "--mesh-gap",
        "0.1",
        "--fineness",
        "0.5",
    ]
    answer = CliRunner().invoke(app, [*command, "--json"])
    assert answer.exit_code == 0, answer.output
    found = ab.flow.ball_drag(DISCOIDAL, [0.0], gap=1e-5, mesh_gap=0.1, fineness=0.5)
    assert json.loads(answer.output)["cd_times_re"] == pytest.approx(found["cd_times_re"].values.tolist())
    refused = CliRunner().invoke(app, [*command[:2], "--gap", "10"])
    assert refused.exit_code == 2


@pytest.mark.slow
def test_inertia_lifts_a_sliding_ball_from_a_plane_as_cox_and_hsu_found() -> None:
    """18 pi/32 of rho U^2 r^2, at a distance that is small for inertia (Cox and Hsu 1977)."""
    from autobalancer.flow.finite_elements import flow_with_inertia

    start = slow(Shape(40.0, 40.0, 1.0, 25.0, 40.0), Fineness(0.25, 0.25, 4.0, 0.7), 0.0)
    assert ball_forces(flow_with_inertia(start, 0.2)).lift / 0.1 == pytest.approx(18.0 * math.pi / 32.0, rel=0.03)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"gap": 0.0}, "gap: given 0 mm; must be positive"),
        ({"gap": "2 mm"}, "smaller than the play of the ball"),
        ({"gap": 1e-6, "mesh_gap": 1e-4}, "mesh_gap: given 0.0001 ball radii; must be at least the gap"),
        ({"gap": 1e-8, "mesh_gap": 1e-3}, "a mesh resolves gaps from 0.003 on"),
        ({"gap": 1e-6, "mesh_gap": 0.0035, "fineness": 4.0}, "elements with this fineness, more than 150000; give"),
        ({"gap": 1e-6, "fineness": 9.0}, "fineness: given 9; must be between 0.5 and 4"),
        ({"gap": 1e-6, "motion": "jumping"}, "motion: given 'jumping'; must be 'rolling', 'sliding'"),
        ({"gap": 1e-6, "reynolds": [10.0, 5.0]}, "reynolds: given 10, 5; must be ascending numbers from 0 to 300"),
        ({"gap": 1e-6, "reynolds": [1000.0]}, "faster flow is not steady"),
        ({"gap": 1e-6, "reynolds": "0:500:3"}, "reynolds: given 0, 250, 500; must be"),
        (
            {"gap": 1e-6, "ball_ahead": "12.4 mm"},
            "ball_ahead: given 12.4 mm from center to center; must be at least 1.03",
        ),
    ],
)
def test_a_question_without_an_answer_is_refused(options: dict[str, object], message: str) -> None:
    with pytest.raises(QuestionError, match=message):
        ab.flow.ball_drag(RIG, **({"reynolds": [0.0]} | options))  # type: ignore[arg-type]


def test_lids_that_nearly_touch_the_ball_are_refused() -> None:
    with pytest.raises(QuestionError, match=r"the play of the ball at the lids is 0\.00163 ball radii"):
        ab.flow.ball_drag(ab.flow.Channel(0.0123, 0.0138, 0.01232), [0.0], gap=1e-6)


def test_a_gap_without_a_length_and_a_ball_that_does_not_fit_are_refused() -> None:
    with pytest.raises(UnitError, match="gap: given '1 s'"):
        ab.flow.ball_drag(RIG, gap="1 s")
    with pytest.raises(MachineError, match=r"a width of 12 mm for a ball of 12.3 mm"):
        ab.flow.Channel("12.3 mm", "12 mm", "20 mm")  # type: ignore[arg-type]
    with pytest.raises(MachineError, match="of orbit for each ball"):
        ab.flow.Channel(0.0123, 0.0138, 0.02, 0.07695, 1.0)


def test_without_the_extra_the_message_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "skfem", None)
    with pytest.raises(QuestionError, match=r'pip install "autobalancer\[drag\]"'):
        ab.flow.ball_drag(RIG, gap=1e-6)
