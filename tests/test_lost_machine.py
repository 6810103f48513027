"""The search for the machine that a source does not print: its statements, chances and closed forms."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from reproductions.pakula2021.lost import runs
from reproductions.pakula2021.lost.candidate import Candidate
from reproductions.pakula2021.lost.closed import (
    filled,
    lifted_share,
    lifting_friction,
    row_of,
    single_capability,
    sliding_rise,
)
from reproductions.pakula2021.lost.drum import angle, one_ball, slip
from reproductions.pakula2021.lost.runs import Cell, Kept
from reproductions.pakula2021.lost.scores import interval, log_chance, over_counts
from reproductions.pakula2021.lost.search import RUNGS, Searched
from reproductions.pakula2021.lost.statements import contradictions, read
from reproductions.pakula2021.lost.tables import candidates, entries
from scipy.integrate import solve_ivp

import autobalancer as ab
from autobalancer.errors import QuestionError
from autobalancer.laws.capabilities import chamber_capability

TWO = """
[[statement]]
key = "from_eight"
says = "needs eight"
where = "4.2"
layers = "deep"
friction = 0.5
least = 8
{one}

[[statement]]
key = "five"
says = "five go around"
where = "4.3"
layers = "deep"
friction = {friction}
carried = [5]
{two}
"""


def table(folder: Path, text: str) -> Path:
    path = folder / "statements.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_statements_that_contradict_each_other_are_named_with_the_point_where_they_do(tmp_path: Path) -> None:
    path = table(tmp_path, TWO.format(one="", two="", friction=0.5))
    with pytest.raises(
        QuestionError,
        match=r"'from_eight' \(4\.2\) and 'five' \(4\.3\): deep chamber, friction 0\.5: 5 balls are carried by one and stuck",
    ):
        read(path)
    # one that admits it is not enough, both must; at another friction there is no contradiction
    with pytest.raises(QuestionError, match="contradict"):
        read(table(tmp_path, TWO.format(one='disputed = ["five"]', two="", friction=0.5)))
    both = TWO.format(one='disputed = ["five"]', two='disputed = ["from_eight"]', friction=0.5)
    assert len(read(table(tmp_path, both))) == 2
    assert len(read(table(tmp_path, TWO.format(one="", two="", friction=0.7)))) == 2


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("least = 8", "lest = 8", r"statement 1: no key 'lest' there; known are carried, disputed"),
        ('where = "4.2"', "", r"statement 1: 'where' is missing"),
        ("least = 8", "least = 8\nstuck = [3]", r"'from_eight': give exactly one of least, carried, stuck"),
        ('key = "five"', 'key = "from_eight"', r"key 'from_eight' is there twice"),
        ("least = 8", 'least = 8\ndisputed = ["six"]', r"disputed names 'six', which is no statement here"),
    ],
)
def test_a_table_of_statements_that_is_wrong_is_refused(tmp_path: Path, old: str, new: str, message: str) -> None:
    text = TWO.format(one="", two="", friction=0.7)
    assert old in text
    with pytest.raises(QuestionError, match=message):
        read(table(tmp_path, text.replace(old, new)))


def test_the_statements_of_the_source_contradict_each_other_three_times() -> None:
    found = {(one.key, two.key) for one, two, _ in contradictions(read())}
    assert found == {("deep_07", "as_one_ball"), ("deep_05", "five_at_05"), ("deep_03", "not_below_03")}


def test_numbers_of_one_run_that_exclude_each_other_are_a_contradiction(tmp_path: Path) -> None:
    row = '[[statement]]\nkey = "{}"\nsays = "a"\nwhere = "b"\nlayers = "deep"\nfriction = 0.7\njudged = [5]\n'
    row += 'measure = "amplitude"\nvalue = {}\nfactor = 2.0\n'
    with pytest.raises(QuestionError, match=r"amplitude from 3e-06 to 1.2e-05, and from 1.5e-05 to 6e-05"):
        read(table(tmp_path, row.format("one", 6e-6) + row.format("two", 3e-5)))
    assert len(read(table(tmp_path, row.format("one", 6e-6) + row.format("two", 2e-5)))) == 2


@pytest.mark.parametrize(("chance", "runs"), [(0.5, 12), (0.9, 20), (0.05, 8)])
def test_the_interval_of_a_chance_holds_it_as_often_as_it_says(chance: float, runs: int) -> None:
    # exact: every possible outcome with its binomial probability; Wilson's interval swings around its 90 %
    held = 0.0
    for hits in range(runs + 1):
        low, high = interval(hits, runs)
        assert 0.0 <= low <= hits / runs + 1e-12
        assert hits / runs - 1e-12 <= high <= 1.0
        held += (low <= chance <= high) * math.comb(runs, hits) * chance**hits * (1.0 - chance) ** (runs - hits)
    assert 0.84 < held < 0.99
    assert interval(0, 0) == (0.0, 1.0)


def test_a_statement_that_half_of_the_fillings_meet_scores_as_a_coin_does() -> None:
    from_eight = {statement.key: statement for statement in read()}["deep_05"]
    rows = {7: [{"share": 0.0}] * 4, 8: [{"share": 1.0}, {"share": 0.0}] * 2}
    found = log_chance(from_eight, Candidate(), lambda cell: rows.get(cell.balls, []))
    assert found == pytest.approx(0.5 * (math.log(0.9) + math.log(0.5)))
    assert math.isnan(log_chance(from_eight, Candidate(), lambda cell: []))


def test_a_mean_over_counts_takes_straight_lines_between_those_that_were_run() -> None:
    assert over_counts((3, 5), (1.0, 3.0)) == pytest.approx(2.0)
    assert over_counts((3, 5, 6), (1.0, 3.0, 9.0)) == pytest.approx((1.0 + 2.0 + 3.0 + 9.0) / 4.0)


def test_runs_are_found_again_and_a_whole_run_replaces_one_that_was_ended(tmp_path: Path) -> None:
    path, cell = tmp_path / "runs.jsonl", Cell("deep", 0.5, 8)
    line = (
        '{{"machine": "m", "cell": ["deep", 0.5, 8], "seed": 0, "found": {{"share": {}, "whole": {}, "soft": {}}}}}\n'
    )
    path.write_text(
        line.format(0.1, "false", "true") + line.format(0.3, "true", "false") + line.format(0.2, "false", "false")
    )
    assert [row["share"] for row in Kept(path).held("m", cell)] == [0.3]


def test_four_balls_in_a_row_and_the_part_of_a_race_that_is_full() -> None:
    steel = Candidate(ball_mass=2.04)  # 50 mm
    assert (row_of(steel, 4), row_of(Candidate(ball_mass=2.06), 4)) == (4, 3)
    full = Candidate(radius=steel.ball_radius(10) * (1.0 + 1.0 / math.sin(math.pi / 10.0)))
    assert filled(Candidate(ball_mass=2.04, radius=full.radius), 10) == pytest.approx(1.0)
    own = single_capability(steel, 7)
    radius = steel.ball_radius(7)
    assert own == pytest.approx(chamber_capability(steel.radius, 2.02 * radius, [(7, radius, 2.04 / 7.0)]), rel=1e-9)


def test_a_sliding_ball_rises_as_its_equation_of_motion_says_and_goes_around_from_0_713_on() -> None:
    def rates(_: float, state: np.ndarray, friction: float) -> list[float]:
        where, speed = state
        return [speed, friction * (math.cos(where) + speed**2) - math.sin(where)]

    for friction in (0.5, 0.72):
        run = solve_ivp(rates, (0.0, 40.0), [0.0, 0.0], args=(friction,), rtol=1e-10, max_step=0.02)
        where, speed = run.y
        rising = slice(0, int(np.argmax(speed < -1e-6)) or len(speed))
        wanted = [lifted_share(friction, float(x)) for x in where[rising]]
        low = where[rising] < 6.0
        np.testing.assert_allclose(speed[rising][low] ** 2, np.array(wanted)[low], atol=1e-6)
        assert (where.max() > 2.0 * math.pi) == (friction > lifting_friction())
    assert lifting_friction() == pytest.approx(0.7131, abs=1e-4)


@pytest.mark.parametrize("friction", [0.5, 0.66, 0.72])
def test_a_ball_in_a_drum_that_starts_suddenly_goes_around_only_above_that_friction(friction: float) -> None:
    run = one_ball(Candidate(), friction, [0.0, 0.02, 0.6], [0.0, 600.0, 600.0])
    highest = float(angle(run).max())
    if friction > lifting_friction():
        assert highest > 2.0 * math.pi
    else:  # the turning point of the closed form
        angles = np.linspace(0.01, math.pi, 20000)
        turn = angles[np.argmax([lifted_share(friction, float(x)) < 0.0 for x in angles])]
        # above 90 degrees it leaves the wall at last, a little before the turning point
        assert highest == pytest.approx(turn, abs=math.radians(1.0 if turn < 0.5 * math.pi else 4.0))


def test_a_ball_in_a_quickening_drum_begins_to_slide_at_the_rate_of_the_closed_form() -> None:
    friction, end = 0.3, 4.0
    border = sliding_rise(Candidate().radius, friction)
    times = [0.1 * i for i in range(round(end / 0.1) + 1)]
    run = one_ball(
        Candidate(), friction, times, [border / end * t * t for t in times]
    )  # the border at half of the time
    slides = float(run.time.values[np.argmax(slip(run, Candidate()) > 0.02)])
    assert 2.0 * slides / end == pytest.approx(1.0, abs=0.08)


def test_the_fitted_sample_is_the_machine_of_the_table_and_every_statement_is_judged_on_it() -> None:
    sample, own = ab.example("deep_chamber_fitted"), candidates()["fitted"].machine(balls=8, friction=0.5)
    apart = {"name", "description", "run"}
    assert sample.model_dump(exclude=apart) == own.model_dump(exclude=apart)
    assert {entry.statement for entry in entries() if entry.machine == "fitted"} == {one.key for one in read()}
    for entry in entries():
        assert 0.0 < entry.chance <= 1.0
        assert entry.runs == 0 or 0.0 <= entry.low < entry.high <= 1.0


def test_a_search_goes_on_where_it_was_stopped_and_only_better_machines_climb(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[float] = []

    def found(
        candidate: Candidate, cell: Cell, seed: int, *, whole: bool = False, soft: bool = False
    ) -> dict[str, Any]:
        asked.append(candidate.unbalance)
        right = (cell.balls > 7 if cell.layers == "deep" else cell.balls > 2) and cell.friction != 0.3
        numbers = {"amplitude": 6e-6, "synchronous": 6e-6, "settled": 8.6} if whole else {}
        return {"share": float(right and candidate.unbalance < 0.1), "whole": whole, "soft": soft, **numbers}

    monkeypatch.setattr(runs, "run", found)
    good, bad = Candidate(unbalance=0.08), Candidate(unbalance=0.12)
    first = Searched(tmp_path)
    assert len(first.climb(good)) == len(RUNGS)
    assert len(first.climb(bad)) == 1  # fewer of its balls go around
    done, asked[:] = len(asked), []
    again = Searched(tmp_path)
    assert again.best() == [good, bad]
    again.climb(good)
    assert done > 50
    assert asked == []
