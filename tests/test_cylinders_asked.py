"""Cylinders in a chamber from the machine file to the archive: what is refused, said, kept and drawn."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import PolyCollection
from tests.references.chamber_machines import cylinder_machine
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli.main import app
from autobalancer.errors import MachineError, QuestionError
from autobalancer.files.machine_file import save_machine
from autobalancer.laws.capabilities import chamber_capability
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.plots.chamber_view import Camera, cylinder_outlines
from autobalancer.results.archive import Archive
from autobalancer.simulation.chamber import simulate_chamber
from autobalancer.simulation.chamber.bounds import fill
from autobalancer.simulation.chamber.chamber_summary import chamber_summary
from autobalancer.studies.chamber_study import archived_run, variant

WEIGHT = {"gravity": [0.0, 0.0, -9.81]}
HISTORY = {"law": "history", "shear_ratio": 0.8}
TURNING: dict[str, Any] = {"positions": [[0.0, 0.0, 0.0]], "velocities": [[0.0, 0.0, 0.0]], "spins": [[1.0, 2.0, 0.0]]}


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"balls": {"length": None}}, "length: missing; a cylinder needs it"),
        ({"balls": {"body": "ball"}}, "length: a ball has none; leave it out, or set body = 'cylinder'"),
        ({"balls": {"body": "roller"}}, "body"),
        ({"balls": TURNING}, "spins: a cylinder stays parallel to the rotor and turns about x only"),
        ({"balls": {"length": 0.21}}, "their length is 210 mm; the chamber is only 200 mm deep"),
        ({"balls": {"length": -0.01}}, "length"),
        ({"contact": HISTORY}, "contact.law: given 'history'; cylinders know 'restitution' only"),
        ({"contact": {"youngs_modulus": None, "stiffness": 1e8}}, "contact.stiffness: is that of balls"),
        ({"contact": {"rebound": {"yield_speed": 0.1}}}, "rebound"),
    ],
)
def test_what_cylinders_do_not_know_is_refused(changed: dict[str, Any], said: str) -> None:
    with pytest.raises(ValueError, match=said.replace("(", r"\(")):
        cylinder_machine(**changed)


def test_balls_and_cylinders_do_not_share_a_machine() -> None:
    given = cylinder_machine().model_dump(exclude_unset=True)
    given["chambers"][0]["balls"] = [*given["chambers"][0]["balls"], {"count": 1, "density": 7800.0, "diameter": 0.01}]
    with pytest.raises(ValueError, match="have balls and cylinders; a machine has the one or the other"):
        ChamberMachine(**given)


def test_cylinders_that_overlap_or_stand_in_a_wall_are_refused() -> None:
    places = [[0.0, 0.0, 0.0], [0.02, 0.015, 0.0]]
    with pytest.raises(MachineError, match=r"cylinders 1 and 2 overlap by 5 mm"):
        simulate_chamber(cylinder_machine(balls={"count": 2, "positions": places}), duration=0.01)
    with pytest.raises(MachineError, match="cylinder 1 stands in the wall"):
        simulate_chamber(cylinder_machine(balls={"positions": [[0.09, 0.0, 0.0]]}), duration=0.01)
    # side by side in the same place across the axis, behind each other along it
    simulate_chamber(cylinder_machine(balls={"count": 2, "positions": [[0.0] * 3, [0.031, 0.0, 0.0]]}), duration=0.001)


def test_filled_cylinders_do_not_overlap_and_too_many_are_refused_with_the_number_that_fits() -> None:
    sizes = [{"body": "cylinder", "count": 30, "density": 7800.0, "diameter": d, "length": 0.03} for d in (0.02, 0.012)]
    machine = cylinder_machine(chamber={"depth": 0.1, "balls": sizes}, **WEIGHT)
    places, settles = fill(machine, 1)
    radius = np.repeat([0.01, 0.006], 30)
    across = np.hypot(*(places[:, None, 1:] - places[:, 1:]).T) - (radius[:, None] + radius)
    along = np.abs(places[:, None, 0] - places[:, 0]) - 0.03
    assert settles
    assert np.maximum(across, along)[np.triu_indices(60, 1)].min() > 0.0
    assert np.abs(places[:, 0]).max() < 0.035 + 1e-12
    with pytest.raises(MachineError, match=r"500 cylinders of 20 mm by 30 mm do not fit .* at most \d+ do"):
        fill(cylinder_machine(chamber={"depth": 0.1}, balls={"count": 500}, **WEIGHT))


def test_cylinders_fill_the_depth_by_their_length() -> None:
    row = chamber_capability(0.1, 0.1, [(3, 0.01, 0.03, 0.0166)])
    assert row == pytest.approx(3.0 * 0.03 * 0.09, rel=1e-12)
    assert chamber_capability(0.1, 0.1, [(3, 0.01, 0.03, 0.03)]) == pytest.approx(
        0.03 * 0.09 * (1.0 + 2.0 * math.cos(2.0 * math.asin(1.0 / 9.0))), rel=1e-12
    )


def test_check_says_how_far_a_cylinder_can_tilt_and_warns_where_it_is_much(tmp_path: Path) -> None:
    guided = cylinder_machine(chamber={"depth": 0.0304}, contact={"friction": 0.3}, **WEIGHT)
    # 20 a - 15 a^2 = 0.4 in mm
    assert chamber_summary(guided).chambers[0].tilt == pytest.approx((20.0 - math.sqrt(376.0)) / 30.0, rel=1e-3)
    assert not [text for text in chamber_summary(guided).warnings if "cylinder" in text]
    loose = cylinder_machine(contact={"friction": 0.8}, **WEIGHT)
    said = CliRunner().invoke(app, ["check", str(save_machine(loose, tmp_path / "m.toml"))], env={"COLUMNS": "200"})
    words = " ".join(said.output.split())
    assert "1 cylinder of 20 mm by 30 mm" in words
    assert "so that one could turn over" in words
    assert "a cylinder of 20 mm by 30 mm could turn over there" in words
    assert "friction of 0.8 at a flat wall can tip a cylinder" in words


def test_a_variant_of_cylinders_keeps_their_shape_and_their_mass_together() -> None:
    found = variant(cylinder_machine(balls={"count": 8}), balls=1, layers="single").chambers[0]
    assert found.balls[0].length == pytest.approx(0.06, rel=1e-12)
    assert found.balls[0].radius == pytest.approx(0.02, rel=1e-12)
    assert found.inner_depth == pytest.approx(0.0606, rel=1e-12)


def test_an_archived_run_of_cylinders_is_the_run_and_goes_on_to_the_same_bits(tmp_path: Path) -> None:
    given = ab.example("chamber_cylinders").model_dump(exclude_unset=True)
    machine = ChamberMachine(**(given | {"contact": given["contact"] | {"youngs_modulus": 2e8}}))
    whole = simulate_chamber(machine, duration=0.04)

    def stop(now: float, end: float) -> None:
        if now > 0.015:
            raise KeyboardInterrupt

    asked: dict[str, Any] = {"duration": 0.04, "part": 10}
    with pytest.raises(KeyboardInterrupt):
        archived_run(Archive(tmp_path), "one", machine, **asked, progress=stop)
    run = archived_run(Archive(tmp_path), "one", machine, **asked)
    xr.testing.assert_identical(run.samples().drop_attrs(), whole.drop_attrs())
    assert run.samples()["ball_length"].values == pytest.approx(np.full(10, 0.03))
    assert Archive(tmp_path).runs("body == 'cylinder'").sizes["run"] == 1
    assert "cylinders" in " ".join(ab.verdict(whole).notes)
    told = ab.run_measures(whole)
    assert "tilting" in told
    texts = [one.attrs["long_name"] for one in told.data_vars.values()]
    assert "settling time of the last cylinder, from the end of the run-up" in texts
    assert not [text for text in [*texts, *str(ab.verdict(whole)).splitlines()] if re.search(r"\bballs?\b", text)]


@pytest.mark.parametrize("asked", [["chamber", "bounds", "rolls.toml"], ["design", "shelf.toml"]])
def test_a_chamber_question_that_refuses_a_machine_names_its_file(
    asked: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    save_machine(cylinder_machine(), "rolls.toml")
    Path("shelf.toml").write_text('machine = "rolls.toml"\nruns.duration = "1 s"\n', encoding="utf-8")
    said = CliRunner().invoke(app, asked)
    assert said.exit_code == 2
    assert f"{asked[-1]}: its" in "".join(said.output.split("\n")).replace("machine: ", "")


def test_runs_of_balls_have_nothing_of_cylinders() -> None:
    run = simulate_chamber(ab.example("deep_chamber"), duration=0.01, step=1e-6, sample=1e-4, settle=False)
    assert "ball_length" not in run.coords
    assert "tilting" not in run
    assert "tilting" not in ab.run_measures(run)


def test_a_cylinder_seen_from_the_side_is_a_rectangle_and_from_the_end_a_circle() -> None:
    places, radius, length = np.array([[0.3, 0.4]]), np.array([0.01]), np.array([0.03])
    side = cylinder_outlines(Camera(90.0, 0.0).axes(), places, radius, length)[0] - places
    assert np.ptp(side, axis=0) == pytest.approx([0.03, 0.02], rel=1e-6)
    x, y = side.T
    area = 0.5 * abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))
    assert area == pytest.approx(0.03 * 0.02, rel=1e-6)
    whole, end = cylinder_outlines(Camera(0.0, 0.0).axes(), places, radius, length) - places
    assert np.hypot(*whole.T) == pytest.approx(np.full(len(whole), 0.01), rel=1e-12)
    assert end == pytest.approx(whole, abs=1e-15)


def test_pictures_draw_cylinders_by_their_length() -> None:
    machine = cylinder_machine(balls={"count": 3, "positions": [[x, 0.05, 0.0] for x in (-0.04, 0.0, 0.04)]})
    run = simulate_chamber(machine, duration=0.01)
    figure = ab.plot.chamber_arrangement(run, [0.0])
    (drawn,) = [found for found in figure.axes[1].collections[::3] if isinstance(found, PolyCollection)]
    heights = [np.ptp(path.vertices[:, 1]) for path in drawn.get_paths()]
    assert heights == pytest.approx([30.0] * 3)
    assert "speed of a cylinder" in figure.axes[-1].get_ylabel()
    rates = ab.plot.answer(run, "collisions").axes[0].get_legend()
    assert rates is not None
    assert rates.get_texts()[0].get_text() == "between cylinders"


def test_a_variant_has_balls_of_the_same_mass_together_in_place_of_cylinders() -> None:
    machine = cylinder_machine(balls={"count": 8})
    balls = variant(machine, balls=8, layers="single", body="ball").chambers[0].balls[0]
    assert balls.length is None
    assert balls.ball_mass == pytest.approx(machine.chambers[0].balls[0].ball_mass, rel=1e-12)
    with pytest.raises(QuestionError, match="body: given 'cylinder'; a machine with balls has variants with 'ball'"):
        variant(ab.example("deep_chamber"), balls=8, body="cylinder")
