"""Analyses on the page, without a browser: their forms, the point on the map, its values in the text of the machine."""

from __future__ import annotations

import math
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

import autobalancer as ab
from autobalancer.app.form_fields import alike, machine_with, text_with
from autobalancer.app.store import pictures as map_point
from autobalancer.app.store.analyses import (
    ANALYSES,
    Known,
    LatestAnswers,
    answer_text,
    defaults,
    known_of,
    no_analysis_reason,
)
from autobalancer.app.store.jobs import Job
from autobalancer.app.store.pictures import MapPicture, exact_statement, map_picture, statement_from_map
from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.files.examples import example_text
from autobalancer.files.machine_file import parse_race_machine
from autobalancer.machine import Machine

DISCOIDAL = example_text("discoidal")
RPM = math.pi / 30.0
SMALL = {  # questions that are answered soon
    "map": {"speed": "400:1300 rpm:7", "values": "5:80 mm^2/s:5:log"},
    "borders": {"values": "5:80 mm^2/s:3:log"},
    "campbell": {"speeds": "400:1300 rpm:5"},
    "response": {"speeds": "400:1300 rpm:20"},
    "stepped": {"speeds": "900:1000 rpm:2", "dwell": "0.2 s", "window": "0.2 s"},
    "branches": {"range": "900:1000 rpm"},
    "basin": {"number": "8"},
}


@pytest.fixture(scope="module")
def machine() -> Any:
    return parse_race_machine(DISCOIDAL)


@pytest.fixture(scope="module")
def known(machine: Any) -> Known:
    return known_of(machine)


@pytest.fixture(scope="module")
def found(machine: Any) -> Any:
    axes = {"speed": "400:1300 rpm:10", "viscosity": "5:80 mm^2/s:5:log"}
    return ab.stability.map(machine, axes, borders=5, progress=False)


@pytest.fixture(scope="module")
def drawn(found: Any) -> tuple[MapPicture, Figure]:
    figures: list[Figure] = []
    keep = map_point.draw_map

    def seen(bare: Any) -> Figure:
        figures.append(keep(bare))
        return figures[0]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(map_point, "draw_map", seen)
        return map_picture(found, "a map"), figures[0]


# the text ----------------------------------------------------------------------------------------------------------------


def test_the_values_of_a_point_go_into_the_text_and_nothing_else_changes(machine: Any) -> None:
    edited = text_with(DISCOIDAL, machine, {"speed": 900.0 * RPM, "viscosity": 50e-6})
    before, after = DISCOIDAL.splitlines(), edited.splitlines()
    assert [line for line in before if line not in after] == [
        'fluid = { name = "silicone oil 20", temperature = "25 degC" }',
        'profile = { kind = "table", time = ["0 s", "5 s", "135 s"], speed = ["0 rad/s", "12.7 rad/s", "1200 rpm"] }',
    ]
    assert "# linear at any speed" in edited
    data = tomllib.loads(edited)
    assert data["drive"]["profile"]["speed"] == ["0 rad/s", "12.7 rad/s", "900 rpm"]
    fluid = data["balancers"][0]["races"][0]["fluid"]
    assert fluid["viscosity"] == "50 mm^2/s"
    assert "name" not in fluid, "another viscosity is another oil"
    assert alike(parse_race_machine(edited), machine_with(machine, {"speed": 900.0 * RPM, "viscosity": 50e-6}))


@pytest.mark.parametrize(
    ("sample", "wanted", "written"),
    [
        ("rigid_rotor", {"speed": 3000.0 * RPM, "drag": 2e-4}, ('end = "3000 rpm"', 'damping = "0.0002 N*m*s"')),
        ("two_plane_rotor", {"speed": 3000.0 * RPM}, ('speed = "3000 rpm"',)),
        ("discoidal", {"stiffness": 4e4}, ('stiffness = "40 kN/m"',)),
    ],
)
def test_a_value_keeps_the_unit_in_which_the_text_has_it(sample: str, wanted: dict[str, float], written: Any) -> None:
    text = example_text(sample)
    edited = text_with(text, parse_race_machine(text), wanted)
    assert all(part in edited for part in written)
    assert len(edited.splitlines()) == len(text.splitlines())


def test_a_held_speed_changes_as_a_whole_and_a_torque_has_none() -> None:
    held = DISCOIDAL.replace('"135 s"]', '"135 s", "140 s"]').replace('"1200 rpm"]', '"1200 rpm", "1200 rpm"]')
    edited = text_with(held, parse_race_machine(held), {"speed": 800.0 * RPM})
    assert tomllib.loads(edited)["drive"]["profile"]["speed"][2:] == ["800 rpm", "800 rpm"]
    driven = parse_race_machine(example_text("stall_and_release"))
    with pytest.raises(QuestionError, match="a torque drives this machine"):
        machine_with(driven, {"speed": 100.0})


# the point ---------------------------------------------------------------------------------------------------------------


def test_a_place_of_the_picture_is_where_matplotlib_draws_its_values(drawn: tuple[MapPicture, Figure]) -> None:
    picture, figure = drawn
    for speed, viscosity in ((500.0, 6.0), (1250.0, 70.0)):
        shares = picture.shares({"speed": speed * RPM, "viscosity": 1e-6 * viscosity})
        assert shares is not None
        left, top, width, height = picture.area
        here = left + shares[0] * width, top + (1.0 - shares[1]) * height
        x, y = figure.axes[0].transData.transform((speed, viscosity)) * 72.0 / figure.dpi
        assert here == pytest.approx((x, picture.size[1] - y), abs=0.5)  # points; of 600
    assert picture.shares({"speed": 1400.0 * RPM, "viscosity": 2e-5}) is None


def test_a_place_has_values_with_few_digits_and_comes_back(drawn: tuple[MapPicture, Figure]) -> None:
    values = drawn[0].values(0.31, 0.77)
    assert float(f"{values['speed'] / RPM:.4g}") == pytest.approx(values["speed"] / RPM, rel=1e-12)
    assert drawn[0].shares(values) == pytest.approx((0.31, 0.77), abs=1e-3)
    assert drawn[0].values(-1.0, 2.0) == drawn[0].values(0.0, 1.0)


def test_the_point_of_the_map_says_what_the_full_equations_say(machine: Any, found: Any) -> None:
    at = {"speed": float(found["speed"][4]), "viscosity": float(found["viscosity"][2])}
    exact = exact_statement(machine, at, borders=False)
    assert statement_from_map(found, at).rate == pytest.approx(exact.rate, rel=1e-9)
    same = machine_with(machine, {"viscosity": at["viscosity"]})
    wanted = ab.stability.eigenvalues(same, [at["speed"]])["growth_rate"]
    assert exact.rate == pytest.approx(float(wanted[0]), rel=1e-6)


def test_the_verdict_changes_at_the_exact_border(machine: Any) -> None:
    oil = 12e-6
    border = exact_statement(machine, {"speed": 100.0, "viscosity": oil}, borders=True).borders["exact border"]
    below, above = (
        exact_statement(machine, {"speed": share * border, "viscosity": oil}, borders=True) for share in (0.999, 1.001)
    )
    assert (below.verdict, above.verdict) == ("unstable", "stable")
    assert above.words().startswith("stable: a small disturbance dies away")
    name, _, side, nearest = next(row for row in above.rows(1.001 * border) if row[0] == "exact border")
    assert (name, side, nearest) == ("exact border", "0.1 % above", True)


def test_outside_of_the_map_nothing_is_claimed(found: Any) -> None:
    assert statement_from_map(found, {"speed": 1.0, "viscosity": 2e-5}).words() == "outside of the map"
    hole = found.copy(deep=True)
    hole["growth_rate"][4, 2] = np.nan
    there = {"speed": float(found["speed"][4]), "viscosity": float(found["viscosity"][2])}
    assert statement_from_map(hole, there).verdict == "no balanced state"
    assert math.isfinite(statement_from_map(hole, there | {"speed": float(found["speed"][5])}).rate)


# the forms ---------------------------------------------------------------------------------------------------------------


def test_the_speeds_of_a_form_are_those_of_the_machine(machine: Any, known: Known) -> None:
    critical = ab.check(machine).critical_speeds[0]
    assert (known.low, known.high) == pytest.approx((0.5 * critical / RPM, 1.15 * 1200.0))
    assert known.speed == pytest.approx(1200.0)
    for analysis in ANALYSES.values():
        texts = defaults(analysis, known)
        assert list(texts) == list(analysis.entries)
        assert analysis.read(machine, texts), "what a form begins with is possible"


def test_another_quantity_brings_its_own_values(known: Known) -> None:
    texts = defaults(ANALYSES["map"], known, {"over": "unbalance", "speed": "500:900 rpm:10"})
    assert texts == {"speed": "500:900 rpm:10", "over": "unbalance", "values": "59.4:5940 g*mm:41:log"}
    assert defaults(ANALYSES["map"], known, {"over": "plateau"})["over"] == "viscosity", "this machine has no plateau"


@pytest.mark.parametrize(
    ("sample", "refused", "why"),
    [
        ("discoidal", set(), ""),
        ("washing_machine", {"map", "borders", "branches"}, "gravity across the axis"),
        ("liquid_ring", set(ANALYSES), "liquid"),
    ],
)
def test_what_is_not_for_a_machine_is_said_before_it_is_asked(sample: str, refused: set[str], why: str) -> None:
    about = known_of(parse_race_machine(example_text(sample)))
    told = {name: analysis.refusal(about) for name, analysis in ANALYSES.items()}
    assert {name for name, text in told.items() if text} == refused
    assert all(why in text for text in told.values() if text)


def test_a_deep_chamber_and_a_rotor_without_balls_are_told_so() -> None:
    assert "deep chamber" in no_analysis_reason(ab.example("deep_chamber"))
    bare = tomllib.loads(DISCOIDAL)
    del bare["balancers"]
    about = known_of(Machine(**bare))
    told = {name for name, analysis in ANALYSES.items() if analysis.refusal(about)}
    assert told == {"map", "borders", "branches", "basin"}


def test_a_campbell_diagram_begins_with_the_modes_that_are_near_the_speeds() -> None:
    rig = parse_race_machine(example_text("discoidal_rig"))
    campbell = ANALYSES["campbell"]
    asked = campbell.read(rig, defaults(campbell, known_of(rig)))
    found = campbell.ask(rig, asked, lambda _done, _total: None)
    top = float(np.max(asked["speeds"]))
    slowest = found["frequency"].values[:, [0, -1]].min(axis=1)
    assert np.all(slowest < 2.0 * top)
    more = ab.rotor.campbell(rig, asked["speeds"], modes=found["branch"].size + 1)["frequency"].values
    assert np.all(more[-1, [0, -1]] > 2.0 * top), "the next mode is far above the speeds"


@pytest.mark.parametrize(
    ("name", "entries", "wrong"),
    [
        ("map", {"speed": "500:900"}, "speed"),
        ("map", {"values": "2:200 rpm:41"}, "values"),
        ("map", {"speed": "500:900 rpm:1000", "values": "1:9 mm^2/s:1000"}, "values"),
        ("campbell", {"modes": "none"}, "modes"),
        ("stepped", {"dwell": "5 m"}, "dwell"),
        ("branches", {"range": "500 rpm"}, "range"),
        ("basin", {"number": "1000000"}, "number"),
        ("basin", {"number": "²"}, "number"),
        ("map", {"speed": "500:900 rpm:²"}, "speed"),
        ("map", {"speed": "500:900 rpm:" + 5000 * "9"}, "speed"),
        ("basin", {"hold": "long"}, "hold"),
    ],
)
def test_what_is_impossible_is_said_of_its_entry(
    machine: Any, known: Known, name: str, entries: Any, wrong: str
) -> None:
    with pytest.raises(AutobalancerError) as refused:
        ANALYSES[name].read(machine, {**defaults(ANALYSES[name], known), **entries})
    place, words = ANALYSES[name].wrong_entry(str(refused.value))
    assert place == wrong
    assert words
    assert ANALYSES[name].wrong_entry("the machine has no balls") == ("", "the machine has no balls")


def test_the_words_of_a_response_are_its_peak() -> None:
    mass, stiffness, damping, moment = 10.0, 1e5, 100.0, 4e-4
    rotor = {"kind": "planar", "mass": mass, "stiffness": stiffness, "damping": damping}
    drive = {"kind": "speed", "profile": {"kind": "constant", "speed": 100.0}}
    data: dict[str, Any] = {"name": "rotor", "axis": "vertical", "rotor": rotor, "drive": drive}
    made = Machine(**data, unbalances=[{"moment": moment}])
    speeds = np.linspace(95.0, 105.0, 101)
    sizes = abs(moment * speeds**2 / (stiffness - mass * speeds**2 + 1j * damping * speeds))
    found = ab.rotor.response(made, speeds)
    told = re.fullmatch(r"rotor: greatest (\S+) µm at (\S+) rpm .*", answer_text(found)[0])
    assert told is not None
    assert float(told[1]) == pytest.approx(1e6 * sizes.max(), rel=2e-3)  # three digits
    assert float(told[2]) == pytest.approx(speeds[sizes.argmax()] / RPM, rel=1e-4)


# the answers -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[] if name == "campbell" else pytest.mark.slow) for name in ANALYSES]
)
def test_an_answer_is_kept_and_drawn_again(machine: Any, known: Known, name: str, tmp_path: Path) -> None:
    analysis, answers = ANALYSES[name], LatestAnswers(tmp_path)
    given = {**defaults(analysis, known), **SMALL[name]}
    job = Job(1, "ada", "a job", 600.0, begun=math.inf)
    assert answers.about(name) is None
    assert answers.ask(name, machine, DISCOIDAL, analysis.read(machine, given), given, job) == name
    assert job.share > 0.0 or name in ("campbell", "response")
    about, answer = answers.about(name), answers.answer(name)
    assert about is not None
    assert (about.given, about.machine) == (given, machine)
    assert isinstance(ab.plot.answer(answer), Figure)
    assert list(answer_text(answer)), "a picture has words, too"


@pytest.mark.slow
def test_a_stepped_response_that_is_cancelled_keeps_what_it_measured(
    machine: Any, known: Known, tmp_path: Path
) -> None:
    class Ending(Job):
        def progress(self, done: float, total: float) -> None:
            if done >= 2.0:
                raise KeyboardInterrupt

    analysis, answers = ANALYSES["stepped"], LatestAnswers(tmp_path)
    given = {**defaults(analysis, known), **SMALL["stepped"], "speeds": "900:1000 rpm:5"}
    answers.ask("stepped", machine, DISCOIDAL, analysis.read(machine, given), given, Ending(1, "ada", "a job", 600.0))
    assert int(np.isfinite(answers.answer("stepped")["amplitude"]).sum()) == 2
