"""The commands of archive and studies, from machine file to table and picture."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from tests.references.chamber_machines import small_machine
from tests.references.pictures import film_of, size_of
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli.main import app
from autobalancer.errors import MachineError, QuestionError
from autobalancer.files.machine_file import machine_text, save_machine
from autobalancer.results.archive import Archive
from autobalancer.studies.chamber_study import archived_run


def told(*words: str, code: int = 0) -> str:
    """Output of a command, without the line breaks of a narrow terminal."""
    ran = CliRunner().invoke(app, list(words), env={"COLUMNS": "220"})
    assert ran.exit_code == code, ran.output
    return " ".join(ran.output.split())


@pytest.fixture
def machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return save_machine(small_machine(), tmp_path / "small.toml")


@pytest.mark.slow
def test_a_study_fills_an_archive_that_can_be_asked(machine: Path) -> None:
    asked = ("--balls", "2,3", "--single", "none", "--friction", "0.5", "--duration", "0.1 s", "--archive", "runs")
    said = told("chamber", "amplitudes", str(machine), *asked, "--plot", "a.png")
    assert "written: small_amplitudes.nc" in said
    assert "chamber friction" in said, "a table of the amplitudes"
    assert size_of("a.png") == (585, 540)
    drawn = told("plot", "small_amplitudes.nc", "--out", "d", "--kind", "carried")
    assert drawn == "written: d/small_amplitudes_carried.png new folder: d"
    assert "no number of balls from 8 to 50 for 'deep'" in told(
        "plot", "small_amplitudes.nc", "--kind", "means", code=2
    )
    assert "2 runs" in told("chamber", "archive", "runs")
    rows = json.loads(told("chamber", "archive", "runs", "--where", "balls == 3", "--json"))
    assert [row["run"] for row in rows] == ["deep-n3-mu0.5-s0"]
    assert rows[0]["state"] == "finished"
    assert rows[0]["vertical_amplitude"] > 0.0
    assert "written: deep-n3-mu0.5-s0.nc" in told("chamber", "archive", "runs", "--export", "deep-n3-mu0.5-s0")
    assert "written: b.png" in told("chamber", "archive", "runs", "--plot", "b.png", "--by", "friction")
    assert "given 'color'" in told("chamber", "archive", "runs", "--show", "color", code=2)
    assert "given 'speed'" in told("chamber", "archive", "runs", "--where", "speed > 1", code=2)


def test_a_study_that_cannot_be_measured_is_refused_before_it_runs(machine: Path) -> None:
    asked = ("chamber", "amplitudes", str(machine), "--balls", "2,3", "--archive", "runs", "--friction")
    assert "last: given 1 s; must be above zero and within the 0.1 s" in told(
        *asked, "0.5", "--duration", "0.1 s", "--last", "1 s", code=2
    )
    assert "duration: given 0 s; a run to measure must be" in told(*asked, "0.5", "--duration", "0 s", code=2)
    assert "contact.friction: given -0.5; must be between" in told(*asked, "0.5,-0.5", "--duration", "0.1 s", code=2)
    none = ("--balls", "none", "--single", "none", "--friction", "0.5", "--duration", "0.1 s")
    assert "--balls, --single: given none for both" in told("chamber", "amplitudes", str(machine), *none, code=2)
    once = ("--duration", "0.1 s", "--archive", "runs", "--last", "1 s")
    assert "within the 0.1 s of a run" in told("chamber", "reactions", str(machine), *once, code=2)
    assert not Path("runs").exists()


def test_bounds_say_each_speed_once_and_in_one_unit(machine: Path) -> None:
    said = told("chamber", "bounds", str(machine))
    assert "speed 1500 rpm, highest critical speed" in said
    assert "(" not in said[said.index("highest critical speed") : said.index("unbalance")]


@pytest.mark.slow
def test_a_result_and_a_run_of_an_archive_are_drawn_and_filmed_like_any_other(machine: Path) -> None:
    ran = told("simulate", str(machine), "--duration", "0.1 s", "--out", "x.nc")
    assert "finished: reached 0.1 s" in ran
    assert "share of the balls that go around with the rotor" in ran
    archived_run(Archive("runs"), "small", small_machine(), duration=0.05)
    output = told("plot", "x.nc", "--out", "q", "--end", "0.05 s", "--deflection-unit", "mm")
    kinds = ("history", "energy", "collisions", "bearings", "reactions", "arrangement")
    assert output == " ".join([*(f"written: q/x_{kind}.png" for kind in kinds), "new folder: q"])
    assert told("plot", "runs/small", "--kind", "arrangement", "--time", "0.02 s", "--out", "r.svg") == "written: r.svg"
    short = ("--seconds", "0.2 s", "--fps", "10", "--width", "320")
    assert told("animate", "x.nc", "--out", "a.gif", *short, "--azimuth", "90", "--elevation", "0") == "written: a.gif"
    assert told("animate", "runs/small", "--frame", "rotor", *short) == "written: runs/small.mp4"
    for film in ("a.gif", "runs/small.mp4"):
        assert film_of(film) == (2, pytest.approx(0.2), (320, 182))
    assert size_of("q/x_history.png") == (1080, 1080)


def test_what_has_no_meaning_for_a_chamber_is_refused_and_the_way_is_told(machine: Path) -> None:
    told("simulate", str(machine), "--duration", "0.01 s", "--sample", "0.5 ms", "--out", "x.nc")
    assert "of x.nc there are history, energy" in told("plot", "x.nc", "--kind", "orbit", code=2)
    assert "--log: has no meaning for the pictures of this" in told("plot", "x.nc", "--log", code=2)
    assert "the run goes from 0 s to 0.01 s" in told("plot", "x.nc", "--start", "2 s", code=2)
    assert "a deep chamber takes --step and --sample" in told("simulate", str(machine), "--samples", "9", code=2)
    wrong = ("--method", "tsitouras", "--duration", "1 s")
    assert "method: given 'tsitouras'; must be 'verlet'" in told("simulate", str(machine), *wrong, code=2)
    assert "folder without a run in it" in told("plot", ".", code=2)
    archived_run(Archive("runs"), "small", small_machine(), duration=0.01)
    assert "its archive is runs" in told("chamber", "archive", "runs/small", code=2)
    assert "choose one of its runs: runs/small" in told("animate", "runs", code=2)


def test_one_run_gives_all_pictures(machine: Path) -> None:
    asked = ("--duration", "0.1 s", "--archive", "runs", "--height", "0.2 m", "--out", "p")
    output = told("chamber", "reactions", str(machine), *asked)
    assert "run small: reached 0.1 s" in output
    names = {path.name for path in Path("p").iterdir()}
    kinds = ("history", "energy", "collisions", "bearings", "reactions", "arrangement")
    assert names == {f"small_{kind}.png" for kind in kinds}


def test_the_step_size_study_prints_its_table(machine: Path) -> None:
    output = told("chamber", "step-size", "--phases", "10", "--speeds", "4 m/s", "--steps", "1e-5,1e-6 s")
    assert "1e-05" in output
    assert "square" in output
    assert "--speeds: given 'fast'" in told("chamber", "step-size", "--speeds", "fast", code=2)


def test_wrong_words_are_answered(machine: Path) -> None:
    assert "no such folder" in told("chamber", "archive", "nowhere", code=2)
    asked = ("--friction", "0.5", "--duration", "1 s")
    assert "must be whole numbers" in told("chamber", "amplitudes", str(machine), "--balls", "2.5", *asked, code=2)
    Path("planar.toml").write_text((Path(__file__).parents[1] / "examples/machines/discoidal.toml").read_text())
    assert "this question is for deep chambers, which have 'chambers' in their file" in told(
        "chamber", "amplitudes", "planar.toml", "--balls", "2", *asked, code=2
    )


def test_what_is_asked_of_the_answer_is_refused_before_the_runs(machine: Path) -> None:
    asked = (str(machine), "--duration", "1 s", "--archive", "runs")
    assert "--height" in told("chamber", "reactions", *asked, "--height", "2 kg", code=2)
    assert "--until" in told("chamber", "reactions", *asked, "--until", "late", code=2)
    Path("taken").write_text("a file")
    assert "taken" in told("chamber", "reactions", *asked, "--out", "taken", code=2)
    few = ("--balls", "2,3", "--single", "none", "--friction", "0.5", "--means", "means.png")
    assert "means are over 8 to 50 balls (deep)" in told("chamber", "amplitudes", *asked, *few, code=2)
    assert not Path("runs").exists()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "restitution = 0.54",
            "restitution = 1.2",
            "contact.restitution: given 1.2; must be greater than 0 and at most 1",
        ),
        ("restitution = 0.54", "restitution = 0", "contact.restitution: given 0; must be greater than 0"),
        ("friction = 0.5", "friction = -0.1", "contact.friction: given -0.1; must be between 0 and 5"),
        ("total_mass = 1.0", "total_mass = 60.0", "3 balls of 169.8 mm do not fit"),
        ("total_mass = 1.0", "total_mass = 200.0", "the chamber is only 200 mm"),
        ("count = 3", "count = 2, positions = [[0, 0, 0], [0, 0, 0.01]]", "balls 1 and 2 overlap by"),
        ("count = 3", "count = 1, positions = [[0, 0, 0.09]]", "ball 1 stands in the wall"),
    ],
)
def test_what_cannot_be_is_refused_with_its_place_and_leaves_nothing(
    machine: Path, old: str, new: str, message: str
) -> None:
    text = machine.read_text()
    assert text.count(old) == 1
    machine.write_text(text.replace(old, new))
    assert message in told("simulate", str(machine), "--duration", "0.01 s", code=2)
    assert not Path("small.nc").exists()


def test_a_study_lists_the_points_that_have_no_result_and_fails_where_none_has(tmp_path: Path) -> None:
    heavy = {"radius": 0.1, "depth": 0.2, "balls": [{"count": 1, "density": 7800.0, "mass": 20.0}]}
    file = save_machine(small_machine(chambers=[heavy]), tmp_path / "heavy.toml")
    out = str(tmp_path / "found.nc")
    asked = ("chamber", "amplitudes", str(file), "--balls", "none", "--duration", "0.02 s", "--friction", "0.5")
    said = told(*asked, "--single", "1,3", "--out", out)
    assert "no result at layers single, friction 0.5, balls 3, seed 0: does not fit" in said
    assert "no point of the study has a result" in told(*asked, "--single", "3", "--out", out, code=2)


def test_a_machine_with_chambers_is_read_from_a_text_and_changed_at_a_path() -> None:
    machine = ab.example("deep_chamber")
    assert ab.parse_machine(machine_text(machine)) == machine
    changed = ab.with_parameter(machine, "contact.friction", 0.4)
    assert changed.contact.friction == 0.4
    assert ab.with_parameter(changed, "contact.friction", machine.contact.friction) == machine
    with pytest.raises(QuestionError, match=r"no 'friktion' there; .*did you mean 'contact\.friction'"):
        ab.with_parameter(machine, "contact.friktion", 0.4)
    with pytest.raises(MachineError, match=r"parameter 'contact\.friction' = -1"):
        ab.with_parameter(machine, "contact.friction", -1)
    with pytest.raises(QuestionError, match="no 'viscosity' there"):
        ab.with_parameter(machine, "viscosity", 1.0)
