"""The search for the best design of a deep chamber: what it rules out, halves, repeats and refuses."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.references.chamber_machines import small_machine
from tests.references.pictures import size_of
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli.main import app
from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import balls_in_chambers, save_machine
from autobalancer.laws.deep_chamber import covering_fill
from autobalancer.results.chamber_measures import catalog_numbers
from autobalancer.studies.design.chambers import (
    ChamberCandidates,
    candidates_of,
    machine_of,
    numbers_of,
    rounds,
    ruled_out,
)
from autobalancer.studies.design.designs import fronts

SHELF = {"balls": [3, 4, 5], "total_mass": [0.6, 1.0], "friction": "0.65"}
ROLLS = {"body": "cylinder", "count": 3, "density": 7800.0, "diameter": 0.02, "length": 0.05}
HOW: dict[str, Any] = {"duration": 0.1, "short": 0.05, "fillings": 1, "budget": 2}
SPECIFICATION = {"limits": {"residual_vibration": "1 m", "stall_probability": 0.9}, "unbalance": [0.05, 0.06]}


def searched(runs: dict[str, Any] | None = None, **options: Any) -> Any:
    asked = SPECIFICATION | {"machine": small_machine(), "candidates": SHELF, "runs": HOW | (runs or {})}
    return ab.design(asked, **options)


def test_a_search_gives_the_same_designs_again_and_with_more_workers() -> None:
    first, again = searched(workers=1), searched(workers=2)
    for name in first.variables:
        assert first[name].identical(again[name]), name


@pytest.mark.slow
def test_an_interrupted_search_goes_on_with_what_is_in_the_archive(tmp_path: Path) -> None:
    def stop(done: int, total: int) -> None:
        if done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        searched(folder=tmp_path, workers=1, progress=stop)
    kept = {path: path.stat().st_mtime_ns for path in tmp_path.glob("*/note.json")}
    assert len(kept) == 3
    told: list[tuple[int, int]] = []
    resumed, whole = searched(folder=tmp_path, progress=lambda *now: told.append(now)), searched()
    assert all(path.stat().st_mtime_ns == then for path, then in kept.items())
    assert told[-1][0] == told[-1][1] == len(told) == len(list(tmp_path.glob("*/note.json")))
    for name in whole.variables:
        assert whole[name].identical(resumed[name]), name
    other = searched({"last": 0.04, "budget": 1}, folder=tmp_path)
    assert not np.array_equal(other["short_left"], whole["short_left"], equal_nan=True), (
        "other steady states are other runs"
    )


def test_designs_stop_where_their_reasons_say_and_the_best_one_is_a_machine(tmp_path: Path) -> None:
    found = searched()
    ruled = found["capability"].values < 0.06
    assert ruled.any()
    assert (found["stage"].values[ruled] == "capability").all()
    assert all("the balls can balance" in text for text in found["reason"].values[ruled])
    full = found["stage"].values == "runs"
    assert full.sum() == 2
    assert np.isfinite(found["residual_vibration_of_runs"].values[full]).all()
    assert np.isnan(found["residual_vibration_of_runs"].values[~full]).all()
    assert sorted(found["place"].values[full]) == [1.0, 2.0]
    worst = found["residual_vibration_of_runs"].max(["unbalance", "seed"])
    assert found["residual_vibration"].values[full] == pytest.approx(worst.values[full])
    # the words of every search: what the budget left out, and the first line
    left = found["stage"].values == "not run"
    assert left.any()
    assert all(text.startswith("not run: the budget of 2 designs was used up") for text in found["reason"].values[left])
    assert found.ruled_out() == {"capability": int(ruled.sum()), "not run": int(left.sum())}
    undecided = "no design is known to keep all limits: for 2 of 2 there are too few runs to tell; the first in order: "
    assert found.answer().startswith(undecided)
    assert "share of the runs in which a ball does not go around with the rotor: 100 (21 to 100) %" in found.answer()
    best = found.isel(design=int(np.nanargmin(found["place"].values)))
    made = ab.designed_machine(found)
    group = made.chambers[0].balls[0]
    assert (group.count, group.radius) == (int(best["balls"]), pytest.approx(0.5 * float(best["diameter"])))
    assert float(made.contact.friction) == float(best["friction"])
    assert sum(part.size for part in made.unbalances) == pytest.approx(0.06)
    assert "Assumed: friction" in made.description
    # its file holds the very machine that was judged, and for how long
    read = balls_in_chambers(save_machine(made, tmp_path / "best.toml"))
    assert read == made
    sizes = {candidate.diameter: candidate for candidate in candidates_of(small_machine(), ChamberCandidates(**SHELF))}
    judged = machine_of(small_machine(), sizes[float(best["diameter"])], 0.06)
    own = ("name", "description", "run")
    assert all(getattr(read, key) == getattr(judged, key) for key in type(judged).model_fields if key not in own)
    assert read.run is not None
    assert read.run.duration == HOW["duration"]
    assert "in 2 runs with the seed 0." in made.description
    again = ab.run_measures(ab.simulate(read, sample=1e-3, seed=0), last=0.01)
    run = best.sel(unbalance=0.06, seed=0)
    assert float(again["vertical_amplitude"]) <= float(run["residual_vibration_of_runs"])
    assert float(again["hardest_contact"]) == float(run["contact_force_of_runs"])
    # balls that still lie at the bottom leave no residual to judge a design by
    assert float(again["share_carried"]) < 1.0
    assert np.isnan([float(again["residual_unbalance"]), float(run["residual_unbalance_of_runs"])]).all()


def test_a_design_is_the_same_machine_however_its_numbers_are_written() -> None:
    machine = small_machine()
    texts = {
        "friction": "0.5",
        "diameter": "30 mm",
        "viscosity": "0.1 Pa*s",
        "fluid_density": "900 kg/m^3",
        "fill": "0.6",
    }
    numbers = {"friction": [0.5], "diameter": [0.03], "viscosity": [0.1], "fluid_density": [900.0], "fill": [0.6]}
    written, plain = (
        ab.machine_text(machine_of(machine, candidates_of(machine, ChamberCandidates(**shelf))[0]))
        for shelf in (texts, numbers)
    )
    assert written == plain


def test_short_runs_halve_the_designs_and_double_the_fillings() -> None:
    assert rounds(24, 4, 5) == [(24, 1), (12, 2), (6, 4)]
    assert rounds(9, 2, 2) == [(9, 1), (5, 2), (3, 2)]
    assert rounds(4, 4, 5) == []


def test_a_limit_below_a_bound_rules_a_design_out_and_one_above_does_not() -> None:
    chamber = {"radius": 0.1, "depth": 0.2, "balls": [{"count": 8, "density": 7800.0, "total_mass": 1.0}]}
    slippery = {"chambers": [chamber], "contact": small_machine().contact.model_dump() | {"friction": 0.2}}
    found = ab.chamber.bounds(small_machine(**slippery))
    for name, least in (
        ("residual_unbalance", found.least_residual),
        ("bearing_force", found.least_bearing_force),
        ("contact_force", found.race_force),
    ):
        assert ruled_out(found, {name: 1.001 * least}) == []
        assert len(ruled_out(found, {name: 0.999 * least})) == 1
    assert ruled_out(found, {"settling_time": 1e-6}) == [], "a motor may end its run-up at any time"
    ramp = {"kind": "ramp", "start": 0.0, "end": 157.0, "duration": 0.02}
    driven = ab.chamber.bounds(small_machine(drive={"kind": "speed", "profile": ramp}, **slippery))
    assert driven.least_settling_time == pytest.approx(driven.least_settled_at - 0.02 * 0.999, rel=1e-9)
    assert ruled_out(driven, {"settling_time": 1.001 * driven.least_settling_time}) == []
    assert len(ruled_out(driven, {"settling_time": 0.999 * driven.least_settling_time})) == 1
    assert found.shaking > 1.0
    assert found.axial_rows == 2
    assert ruled_out(found, {"stall_probability": 0.5}) == [], "balls that hop may be lifted by any friction"
    calm = ab.chamber.bounds(small_machine(unbalances=[{"moment": 0.005}], **slippery))
    assert calm.shaking < 1.0
    assert "lifts no ball" in ruled_out(calm, {"stall_probability": 0.5})[0][1]


def test_a_row_of_balls_along_the_axis_is_lifted_by_no_less_friction_than_one_ball() -> None:
    """The same six balls in one row, and in three: the machine shakes by more than gravity."""
    carried = {}
    for depth in (0.27, 0.09):
        chamber = {"radius": 0.1, "depth": depth, "balls": [{"count": 6, "density": 7800.0, "diameter": 0.044}]}
        machine = small_machine(chambers=[chamber], unbalances=[{"moment": 0.09}])
        bounds = ab.chamber.bounds(machine)
        assert bounds.shaking > 1.0
        assert bool(ruled_out(bounds, {"stall_probability": 0.5})) == (bounds.axial_rows == 1)
        run = ab.simulate(machine, duration=4.0, seed=1)
        carried[bounds.axial_rows] = float(ab.run_measures(run, last=0.5)["share_carried"])
    assert carried[1] == 0.0
    assert carried[3] > 0.0


def test_so_little_friction_lifts_no_ball_of_a_calm_machine() -> None:
    """The rule of half the friction of one ball, on many balls that push each other."""
    for count in (6, 20):
        machine = small_machine(
            unbalances=[{"moment": 0.005}],
            chambers=[{"radius": 0.1, "depth": 0.2, "balls": [{"count": count, "density": 7800.0, "total_mass": 1.0}]}],
            contact=small_machine().contact.model_dump() | {"friction": 0.3},
        )
        assert ruled_out(ab.chamber.bounds(machine), {"stall_probability": 0.5})
        run = ab.simulate(machine, duration=1.5)
        measured = ab.run_measures(run, last=0.3)
        assert float(measured["share_carried"]) == 0.0
        # the verdict says so in its first line, and no number tells a balance that there is not
        judged = ab.verdict(run, last=0.3)
        assert f", none of {count} balls turns with the rotor" in str(judged).splitlines()[0]
        assert np.isnan([judged.residual, judged.grade_after, float(measured["residual_unbalance"])]).all()
        assert "balls do not turn with the rotor: no residual to count on" in str(judged)
        assert "no grade, as balls do not turn with the rotor; without balls G " in str(judged)
        judged_numbers = numbers_of(machine, catalog_numbers(run, 0.3))  # as archives, studies and searches keep them
        assert math.isinf(judged_numbers["residual_unbalance"]), "it keeps no limit"
        line = ab.plot.chamber_run(run).axes[3].lines[0].get_ydata()
        assert np.isnan(np.asarray(line, float)[-300:]).all()


def test_a_liquid_that_turns_with_the_chamber_lifts_balls_without_friction(tmp_path: Path) -> None:
    """The closed form asks for no friction then; dry balls stay at the bottom, wet ones all go around."""
    group = {"count": 6, "density": 7800.0, "total_mass": 1.0}
    contact = small_machine().contact.model_dump() | {"friction": 0.1}
    machine = small_machine(chambers=[{"radius": 0.1, "depth": 0.2, "balls": [group]}], contact=contact)
    shelf = {"viscosity": [0.0, 0.01], "fluid_density": [900.0], "fill": [0.6]}
    asked = {"machine": machine, "candidates": shelf, "runs": {"duration": 2.0, "last": 0.4, "fillings": 1}}
    found = ab.design(asked, folder=tmp_path)
    assert found["least_friction"].values == pytest.approx([0.6033, 0.0], abs=1e-4)
    assert found["stall"].values.tolist() == [1.0, 0.0]
    # one run in which no ball stalls does not prove that none ever will; Wilson (1927): 1.96^2/(1 + 1.96^2) is possible
    sure = ab.design(asked | {"limits": {"stall_probability": 0.0}}, folder=tmp_path)
    assert sure.answer().startswith(
        "1 of 2 designs keeps all limits in 1 run of 1, though up to 79 % of all may stall (95 % confidence); the best: "
    )
    assert next(one for one in sure.columns() if one.head == "keeps limits").values == ["in 1 run of 1", "misses 1"]
    assert ab.designed_machine(found).chambers[0].square_drag > 0.0


def test_a_fluid_must_cover_the_balls_and_leave_room_for_them() -> None:
    machine = small_machine()
    radius = machine.chambers[0].balls[0].radius
    needed = covering_fill(0.1, radius)
    shelf = {"viscosity": ["0 Pa*s", 0.1], "fluid_density": 900.0, "fill": [0.9 * needed, 1.01 * needed, 0.999]}
    runs = {"duration": 0.1, "fillings": 1, "budget": 9}
    found = ab.design({"machine": machine, "candidates": shelf | {"total_mass": [1.0]}, "runs": runs})
    assert found["viscosity"].values.tolist() == [0.0, 0.1, 0.1, 0.1]
    assert "does not cover the balls" in found["reason"].values[1]
    assert found["stage"].values.tolist() == ["runs", "fluid", "runs", "fluid"]
    assert "do not go into the chamber together" in found["reason"].values[3]
    wet = machine_of(machine, candidates_of(machine, ChamberCandidates(**shelf))[2]).chambers[0]
    assert float(wet.drag) == pytest.approx(6.0 * math.pi * 0.1 * radius)


def test_on_the_first_front_no_design_is_beaten_in_both() -> None:
    found = fronts(np.array([1.0, 2.0, 3.0, 2.0, math.nan]), np.array([3.0, 1.0, 2.0, 1.0, 0.0]))
    assert found.tolist() == [0, 0, 1, 0, 2]


@pytest.mark.parametrize(
    ("shelf", "options", "message"),
    [
        ({"color": [1]}, {}, "candidates.color: unknown key"),
        ({"balls": [2.5]}, {}, "candidates.balls.*: given 2.5; must be a whole number"),
        ({"balls": []}, {}, "candidates.balls: given an empty list"),
        ({"friction": [-0.1, 0.5]}, {}, "must not be negative"),
        ({"diameter": "0 mm"}, {}, "must be greater than zero"),
        ({"diameter": [0.02], "total_mass": [1.0]}, {}, "give one of them"),
        ({"fill": [0.3]}, {}, "viscosity: missing"),
        ({"viscosity": [0.1]}, {}, "a fluid with a viscosity needs fluid_density and fill"),
        ({"viscosity": [0.1], "fluid_density": [900.0], "fill": [1.2]}, {}, "given 1.2; must be between 0 and 1"),
        ({"balls": list(range(1, 2002))}, {}, "more than 2000 designs"),
        ({}, {"limits": {"noise": 1.0}}, "limits.noise: unknown key"),
        ({}, {"limits": {"stall_probability": 2.0}}, "must be between 0 and 1"),
        ({}, {"limits": {"residual_vibration": -1.0}}, "must be greater than zero"),
        ({}, {"limits": {"residual_vibration": "1 s"}}, "limits.residual_vibration: given '1 s', but a quantity in m"),
        ({}, {"limits": {"contact_pressure": "1 GPa"}}, "give contact.youngs_modulus"),
        ({}, {"runs": {"fillings": 0, "duration": 1.0}}, "runs.fillings: given 0"),
        ({}, {"runs": {"short": 2.0, "duration": 1.0}}, "runs.short: given 2 s; a full run lasts 1 s only"),
        ({}, {"unbalance": [0.0]}, r"unbalance\[1\]: given 0.0; must be greater than zero"),
        ({}, {"unbalance": [0.5]}, "none of 1 is left; ruled out by capability 1.*the balls can balance"),
        ({"balls": [3], "diameter": "150 mm"}, {}, "ruled out by space 1.*does not fit"),
        (
            {},
            {"limits": {"bearing_force": "10 N", "settling_time": "1 ms"}},
            "ruled out by limits 1.*(settling time|bearing force) is at least",
        ),
    ],
)
def test_questions_that_make_no_sense_are_answered(
    shelf: dict[str, Any], options: dict[str, Any], message: str
) -> None:
    with pytest.raises(QuestionError, match=message):
        ab.design({"machine": small_machine(), "candidates": shelf, "runs": {"duration": 1.0}} | options)


def test_machines_that_cannot_be_varied_are_refused() -> None:
    single = [{"radius": 0.1, "balls": [{"count": 3, "density": 7800.0, "total_mass": 1.0}]}]
    steel = {"law": "restitution", "restitution": 0.5, "friction": 0.5, "youngs_modulus": 2e11}
    rolls = [{"radius": 0.1, "depth": 0.2, "balls": [ROLLS]}]
    for changed, message in (
        ({"chambers": single}, "no depth"),
        ({"chambers": rolls, "contact": steel}, "has cylinders"),
        ({"unbalances": []}, "no unbalance to balance"),
        ({"body": {"freedom": "fixed"}, "supports": []}, "no ball feels it; free the body"),
    ):
        with pytest.raises(QuestionError, match=message):
            ab.design({"machine": small_machine(**changed), "runs": {"duration": 1.0}})


@pytest.mark.slow
def test_the_command_leaves_a_table_a_picture_and_the_machine_of_the_best_design(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    save_machine(small_machine(), "small.toml")

    def told(*words: str, code: int = 0) -> str:
        ran = CliRunner().invoke(app, list(words), env={"COLUMNS": "220"})
        assert ran.exit_code == code, ran.output
        return " ".join(ran.output.split())

    Path("shelf.toml").write_text(
        """machine = "small.toml"
limits = { residual_vibration = "1 mm" }
candidates = { balls = [2, 3] }
runs = { duration = "0.05 s", fillings = 1 }
""",
        encoding="utf-8",
    )
    assert "design specification of a deep chamber without faults" in told("check", "shelf.toml")
    output = told("design", "shelf.toml", "--plot", "d.png")
    for text in ("2; 2 ran, 1 times each", "at most 95 % of all", "written: shelf_1.toml"):
        assert text in output
    assert size_of("d.png") == (1110, 660)
    assert balls_in_chambers("shelf_1.toml").name.startswith("Small chamber, ")
    assert told("plot", "shelf.nc", "--out", "p.png") == "written: p.png"
    found = xr.load_dataset("shelf.nc")
    assert ab.plot.design(found).axes[0].get_ylabel() == "ball mass (g)"
    assert sorted(json.loads(told("design", "shelf.toml", "--json"))["place"]) == [1.0, 2.0]
    around = ("chamber", "sensitivity", "shelf.nc", "--archive", "shelf_parts")
    assert "friction -10 %" in told(*around, "friction=0.1")
    assert "one sliding ball needs a friction of 0.603" in told("chamber", "bounds", "small.toml")
    assert json.loads(told("chamber", "bounds", "small.toml", "--json"))["shaking"] > 1.0
    assert "write it as NAME=VALUE" in told(*around, "friction", code=2)
    assert "must be 'unbalance', 'friction'" in told(*around, "color=0.1", code=2)
    assert "must be a share" in told(*around, "unbalance=2", code=2)
