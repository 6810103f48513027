"""Studies on the page, without a browser: their text and its form, runs that are stopped and go on, tables and words."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import autobalancer as ab
from autobalancer.app.form_fields import offered as numbers
from autobalancer.app.form_fields import varied_rows, with_entry, with_kind, with_row
from autobalancer.app.problems import MOST, about, read_design_text, read_study_text
from autobalancer.app.store.jobs import Job
from autobalancer.app.store.studies import (
    DESIGN,
    STUDY,
    Known,
    Studies,
    StudyEntry,
    StudyProgress,
    chosen_text,
    columns_of,
    design_figure,
    design_of,
    done_of,
    offered,
    places,
    progress_text,
    quantities_of,
    reasons_html,
    run_design,
    run_study,
    sample_text,
    study_figure,
)
from autobalancer.errors import QuestionError
from autobalancer.files.examples import example_text
from autobalancer.files.samples import sample_names
from autobalancer.machine import Machine
from autobalancer.studies.design.chambers import ChamberSpec
from autobalancer.studies.study.study_spec import LogNormal, Uniform

PAGE = example_text("stall_and_release")
STUDIED = """machine = "machine.toml"
members = 24
duration = "2 s"
[vary]
drag = ["1e-4 N*m*s", "3e-4 N*m*s"]
[vary."unbalances[1].mass"]
distribution = "normal"
standard_deviation = "10 %"
"""


@pytest.mark.parametrize("name", sample_names("studies"))
def test_every_sample_is_a_study_on_the_page(name: str) -> None:
    text = sample_text(name)
    found = read_study_text(text, PAGE)
    assert found.study is not None, found.message
    assert {row.name.split(".")[-1] for row in varied_rows(text)} == {
        one.split(".")[-1] for one in (*found.study.written["vary"],)
    }


@pytest.mark.parametrize(
    ("more", "key", "words"),
    [
        ("members = 0", "members", "must be 1 or more"),
        ("vary.stiffness.distribution = 'norml'", "vary.stiffness.distribution", "must be one of 'normal'"),
        (
            'vary."unbalances[1].mass" = { distribution = "uniform", low = "3 g", high = "2 g" }',
            "",
            "low must be below",
        ),
        ("stop.of = 'peak'", "stop.of", "given 'peak'; this study has"),
        (f"members = {MOST + 1}", "members", f"at most {MOST}"),
        ("vary.foo = [1]", "vary.foo", "no such name"),
        ("members = ", "", "not valid TOML"),
    ],
)
def test_what_is_wrong_is_said_of_its_key_in_the_words_of_the_reader(more: str, key: str, words: str) -> None:
    found = read_study_text(f'machine = "machine.toml"\n{more}', PAGE)
    assert found.study is None
    assert words in found.message
    assert not key or key in found.problems


@pytest.mark.parametrize(
    "text",
    [
        'machine = "/etc/passwd"',
        'machine = "../../secret.toml"',
        'machine = "machine.toml"\n[vary]\n"balancers[1].races[1].roundness" = [{ file = "/etc/passwd" }]',
    ],
)
def test_a_study_on_the_page_reads_no_file_of_the_server(text: str) -> None:
    found = read_study_text(text, PAGE)
    assert found.study is None
    assert "passwd" in found.message or "secret" in found.message


def test_the_form_writes_what_the_reader_of_studies_reads() -> None:
    machine: Any = ab.example("stall_and_release")
    text = with_row('machine = "machine.toml"  # of the page\n', numbers(PAGE, machine)["rotor.damping"])
    (row,) = varied_rows(text)
    assert row.entries == {"standard_deviation": "10 %"}
    text = with_kind(text, row, "uniform", numbers(PAGE, machine)["rotor.damping"])
    text = with_entry(text, varied_rows(text)[0], "high", "130 N*s/m")
    study = read_study_text(text, PAGE).study
    assert study is not None
    found = study.scatter["rotor.damping"]
    assert isinstance(found, Uniform)
    assert (found.low, found.high) == (pytest.approx(0.9 * machine.rotor.damping), 130.0)
    text = with_kind(text, varied_rows(text)[0], "values", None)
    text = with_entry(text, varied_rows(text)[0], "values", "20, 30, 40 N*s/m")
    study = read_study_text(text, PAGE).study
    assert study is not None
    assert study.grid["rotor.damping"] == ["20 N*s/m", "30 N*s/m", "40 N*s/m"]
    assert varied_rows(text)[0].entries["values"] == "20, 30, 40 N*s/m"
    assert about(study) == "3000 members: 1000 draws at each of 3 points"
    text = with_kind(text, varied_rows(text)[0], "log-normal", None)
    study = read_study_text(text, PAGE).study
    assert isinstance(study.scatter["rotor.damping"] if study else None, LogNormal)
    assert "# of the page" in text


class Ending(Job):
    """A job that somebody cancels when so many members are done."""

    after = 20

    def progress(self, done: float, total: float) -> None:
        self.share = done / total
        if done >= self.after:
            self.stop.set()
            raise KeyboardInterrupt


def kept(shelf: Studies, text: str = STUDIED) -> str:
    study = read_study_text(text, PAGE).study
    assert study is not None
    entry = StudyEntry("", STUDY, "a study", study.machine.name, "machine.toml", "", study.count)
    return shelf.add(entry, text, PAGE)


def test_a_cancelled_study_is_known_so_far_and_goes_on_with_the_same_bits(tmp_path: Path) -> None:
    shelf = Studies(tmp_path)
    name = kept(shelf)
    known = Known(shelf, name)
    assert known.look() is None
    with pytest.raises(KeyboardInterrupt):
        run_study(shelf, name, Ending(1, "ada", name, 60.0))
    shelf = Studies(tmp_path)  # after a restart
    assert not shelf.entry(name).finished
    assert shelf.entry(name).message == "cancelled"
    part = known.look()
    assert part is not None
    assert 16 <= part.sizes["member"] == done_of(shelf, name) < 48
    job = Ending(2, "ada", name, 60.0)
    job.after = 1000
    run_study(shelf, name, job)
    assert shelf.entry(name).finished
    again = kept(shelf)
    run_study(shelf, again, job)
    whole, other = Known(shelf, name).look(), Known(shelf, again).look()
    assert whole is not None
    assert other is not None
    for quantity in ("peak_deflection", "verdict", "settling_time"):
        assert np.array_equal(whole[quantity].values.astype(str), other[quantity].values.astype(str))
        assert np.array_equal(
            part[quantity].values.astype(str), whole[quantity].values[: part.sizes["member"]].astype(str)
        )
    heads = {column.head for column in columns_of(whole, "peak_deflection")}
    assert ("stalled" in heads) == whole["stalled"].values.astype(bool).any()
    assert {"peak_deflection", "stalled"} <= set(quantities_of(whole))
    for kind in ("over", "drives"):
        assert kind in offered(whole)
        words = study_figure(shelf, name, whole, kind, "peak_deflection", 1, job)[1]
        assert "peak deflection" in words
        assert "mass" in words if kind == "drives" else "drag" in words
    shelf.delete(again)
    assert [one.name for one in shelf.entries()] == [name]


def test_a_study_that_cannot_run_says_why(tmp_path: Path) -> None:
    shelf = Studies(tmp_path)
    text = STUDIED.replace('standard_deviation = "10 %"', 'standard_deviation = "300 %"')
    name = kept(shelf, text)
    with pytest.raises(QuestionError, match="cannot be built"):
        run_study(shelf, name, Job(1, "ada", name, 60.0))
    assert "Narrow the distributions" in shelf.entry(name).message


def test_no_name_of_a_study_or_file_leaves_its_folder(tmp_path: Path) -> None:
    shelf = Studies(tmp_path / "ada")
    name = kept(shelf)
    assert shelf.file(name, "machine.toml").read_text(encoding="utf-8") == PAGE
    for wrong in ("..", "../x", "", "20261123-012345-zzzzzz", "a\0b", name + "/.."):
        with pytest.raises(QuestionError):
            shelf.folder(wrong)
        with pytest.raises(QuestionError):
            shelf.file(name, wrong)
    assert Studies(tmp_path / "bob").entries() == []


def test_the_time_to_go_is_that_of_the_members_left() -> None:
    told = StudyProgress()
    told.told(100, 400)  # there already when it began
    told.begun -= 10.0
    told.told(150, 400)
    assert told.left == pytest.approx(50.0, rel=1e-2)
    assert str(told) == "150 of 400 members, 50 s to go"


@pytest.mark.parametrize("name", sample_names("designs"))
def test_every_sample_is_a_design_on_the_page(name: str) -> None:
    found = read_design_text(sample_text(name), PAGE)
    assert found.spec is not None, found.message
    assert (found.measured is not None) == (name == "measured_rotor_design")


@pytest.mark.parametrize(
    ("more", "key", "words"),
    [
        ("limits.stall_probability = 0.001", "limits.stall_probability", "contradicts search.members"),
        ("rotor.receptance = '/etc/passwd'", "rotor.receptance", "name a file of the page Measured"),
        ("rotor.receptance = '../discoidal_hammer.csv'", "rotor.receptance", "name a file of the page Measured"),
        ("unbalance = '3 kg'", "unbalance", "3 kg"),
        ("limits.peak = '1 mm'", "limits.peak", "peak"),
        ("search.members = 5000", "search.members", "at most 2000"),
    ],
)
def test_what_is_wrong_with_a_design_is_said_of_its_key(more: str, key: str, words: str) -> None:
    found = read_design_text(f"machine = 'discoidal.toml'\n{more}\n[candidates]\ncount = [2]\n", PAGE)
    assert found.spec is None
    assert words in found.message
    assert key in found.problems


def test_a_deep_chamber_of_the_page_is_designed_there_with_the_keys_of_chambers() -> None:
    page = example_text("deep_chamber")
    asked = "machine = 'machine.toml'\nruns.duration = '1 s'\n"
    found, wrong = (read_design_text(asked + more, page) for more in ("", "runs.last = '2 s'\n"))
    assert isinstance(found.spec, ChamberSpec)
    assert (found.spec.machine.name, found.spec.last, found.of.file) == ("Deep chamber", 0.1, "machine.toml")
    assert "a full run lasts 1 s only" in wrong.problems["runs.last"]
    assert "balls in races" in read_study_text(asked, page).message


DESIGNED = """machine = "discoidal.toml"
[limits]
border_margin = 0.2
share = 0.75
[candidates]
count = [2]
fluids = ["silicone oil 1", "silicone oil 10", "silicone oil 20"]
[search]
members = 14
tolerance = 1e-4
"""


class Stopping(Job):
    """A job that somebody cancels as soon as one candidate has run."""

    stops = True

    def progress(self, done: float, total: float) -> None:
        if self.stops and self.result.found is not None:
            raise KeyboardInterrupt


def test_a_cancelled_design_is_known_so_far_and_goes_on_with_the_same_numbers(tmp_path: Path) -> None:
    shelf, found = Studies(tmp_path), read_design_text(DESIGNED, PAGE)
    assert found.spec is not None
    entry = StudyEntry("", DESIGN, "a design", found.spec.machine.name, found.of.file, "")
    name, job = shelf.add(entry, DESIGNED, found.of.text), Stopping(1, "ada", "", 60.0)
    with pytest.raises(KeyboardInterrupt):
        run_design(shelf, name, job)
    part = design_of(shelf, name, job)
    assert part is not None
    assert len(places(part)) == 1
    assert not Studies(tmp_path).entry(name).finished
    assert progress_text(shelf, shelf.entry(name)) == "14 of 28 runs"
    left = design_of(Studies(tmp_path), name, None)  # by a server that was killed
    assert left is not None
    assert places(left) == places(part)
    job.stops = False
    run_design(shelf, name, job)
    whole = design_of(Studies(tmp_path), name, None)  # after a restart
    assert whole is not None
    assert len(places(whole)) == 2
    assert "silicone oil 1: " in reasons_html(whole)
    assert "stall at the critical speed" in reasons_html(whole)
    first = int(np.flatnonzero(np.isfinite(part["place"].values))[0])
    assert part["peak_deflection"].values[first] == whole["peak_deflection"].values[first]
    machine = ab.parse_machine(chosen_text(whole, 1))
    assert machine.balancers[0].races[0].balls[0].count == 2
    assert "silicone oil" in design_figure(whole)[1]
    with pytest.raises(QuestionError):
        chosen_text(whole, 3)


@pytest.mark.parametrize("name", ["stall_and_release", "rigid_rotor", "discoidal_rig", "cfrp_rig", "rodrigues_rig"])
def test_the_numbers_of_every_kind_of_rotor_can_vary(name: str) -> None:
    text = example_text(name)
    machine = ab.parse_machine(text)
    assert isinstance(machine, Machine)
    known = numbers(text, machine)
    assert known["unbalance"].value > 0.0
    assert any(path.startswith("rotor") for path in known)
