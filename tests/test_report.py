"""Reports: complete, self-contained, and every number can be made again."""

from __future__ import annotations

import math
import re
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import typer
import xarray as xr

import autobalancer as ab
from autobalancer.cli.main import app
from autobalancer.errors import QuestionError
from autobalancer.measure import Sensor, record
from autobalancer.reporting import report_pages as blocks
from autobalancer.reporting import report_pages as machine_pages
from autobalancer.reporting.report import balls_page, sources_page, write_pdf
from autobalancer.reporting.report_pages import Listing, Paragraph, Report, Rows, Section, drawing

pytest.importorskip("jinja2")
ROOT = Path(__file__).parents[1]
MACHINE = ROOT / "examples/machines/discoidal.toml"


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("report") / "a.html"
    monkeypatch = pytest.MonkeyPatch()
    monkeypatch.setattr(machine_pages, "MAP", (9, 7))  # coarse pictures: their words and numbers are what is tested
    monkeypatch.setattr(blocks, "DOTS", 50)
    spec = {
        "machine": str(MACHINE),
        "members": 24,
        "duration": "2 s",
        "vary": {"stiffness": {"distribution": "normal", "standard_deviation": "9 %"}},
    }
    other = ab.with_parameter(ab.load_machine(MACHINE), "rotor.damping", 100.0)
    run = ab.simulate(other, duration="3 s", save=ab.Samples(3001))
    measured = record(run, [Sensor("displacement", direction=way, noise="40 dB") for way in ("x", "y")], 500.0)
    assert ab.report(MACHINE, path, study=ab.study(spec), grade="G 2.5", measured=measured, starts=5) == path
    monkeypatch.undo()
    return path.read_text(encoding="utf-8")


def test_a_report_has_all_its_pages_and_needs_no_other_file(page: str) -> None:
    heads = re.findall(r"<h2 id=\"s\d+\">\d+ ([^<]+)</h2>", page)
    assert heads == [
        "In short",
        "Machine",
        "Drawing",
        "Capability",
        "Balance quality (ISO 21940-11)",
        "Run-up",
        "Run-up and coast-down",
        "Measured and computed",
        "Border speeds and margins",
        "Where balancing is stable",
        "Basins at the highest speed",
        "5 random starts of the balls",
        "What small changes do",
        "Study study",
        "Which scatter drives the result",
        "Balls in their race",
        "Limits",
        "Sources",
        "Machine file",
    ]
    assert not re.findall(r"(?:src|href)=\"(?!#|data:)", page)
    assert "http" not in re.sub(r"base64,[^\"]*", "", page)
    assert all(len(alt) > 10 for alt in re.findall(r"<img alt=\"([^\"]*)\"", page))


def test_the_first_page_says_what_decides_and_where_it_stands(page: str) -> None:
    heads = [("", ""), *re.findall(r"<h2 id=\"s(\d+)\">(\d+ [^<]+)</h2>", page)]
    first = page[page.index("In short</h2>") : page.index('class="sign"')]
    rows = [re.findall(r"<td[^>]*>([^<]*)</td>", row) for row in re.findall(r"<tr>(.*?)</tr>", first, re.DOTALL)]
    found = {row[0]: row[1:] for row in rows if row}
    assert all(where in dict(heads).values() for *_, where in found.values())
    assert all(condition for question, (_, condition, *_) in found.items() if question != "notes on the machine")
    capability = ab.check(MACHINE).capability
    assert found["capability of the balls, all races"][:3] == [
        f"{1e6 * capability:.0f} g mm for 594 g mm, 1.72 times as much",
        "unbalance and fluid of the machine file",
        "yes",
    ]
    assert found["residual unbalance, race off the axis as is typical (not given)"][2] == "measure it"
    assert found["release speed"][2] == found["exact border"][2] == "yes"
    ranks = [{"NO": 0, "yes": 2, "-": 3}.get(word, 1) for *_, word, _ in found.values()]
    assert ranks == sorted(ranks)  # what is not enough comes first


def test_places_that_balls_take_at_a_low_speed_count_only_if_the_drive_leaves_them_there() -> None:
    for duration, carried, speed in (("40 s", True, "speed of 3000 rpm"), ("4000 s", False, "speed of 713.11 rpm")):
        found = ab.check(ab.with_parameter(ab.example("design"), "drive.profile.duration", duration))
        assert found.friction is not None
        assert found.friction_settled is not None
        assert found.friction_settled.planes[0].carried_on is carried
        held = found.friction if carried else found.friction_settled
        *_, (_, below, _), (_, worst, condition) = machine_pages.residuals_left(found, "600 g mm")
        assert speed in condition
        assert below == held.planes[0].residual_95
        assert worst >= held.planes[0].sticking_residual


def test_a_capability_at_the_limit_is_hardly_enough() -> None:
    for unbalance, word, text in (
        ("400 g*mm", "yes", "times as much: enough."),
        ("900 g*mm", "hardly", "enough, but hardly (1.14)"),
        ("1100 g*mm", "NO", "NOT enough"),
    ):
        page = machine_pages.capability_page(
            ab.check(ab.with_parameter(ab.load_machine(MACHINE), "unbalance", unbalance))
        )
        assert page.decisive[0].enough == word
        assert text in str(page.blocks[-1])
        if word == "hardly":
            assert "Look at: capability of the balls, all races (hardly)" in str(blocks.first_page([page]).blocks[0])


def test_a_speed_below_a_border_is_said_to_be_below_it_and_an_eccentricity_has_its_own_source() -> None:
    found = ab.check(MACHINE)
    (exact,) = (border.speed for border in found.borders if border.name == "exact border")
    for share, text in ((0.9, "; the highest speed is 10 % below it"), (1.25, "; the highest speed is 25 % above it")):
        page = machine_pages.margin_page(replace(found, highest_speed=share * exact))
        (decisive,) = (one for one in page.decisive if one.question == "exact border")
        assert decisive.found.endswith(text)
        assert "-" not in decisive.found
        assert decisive.enough == ("yes" if share > 1.0 else "NO")
    for name, source in (("discoidal", "ISO 2768-2"), ("design", "ISO 492"), ("eccentric_race", "this machine file")):
        machine = ab.example(name)
        (sources, *_) = sources_page(machine, xr.Dataset(), ab.check(machine), None).blocks
        (said,) = (text for what, text in sources.rows if what == "eccentricity of a race")
        assert source in said
        assert [one for one in ("ISO 2768-2", "ISO 492", "this machine file") if one in said] == [source]


def test_a_run_that_is_partly_balanced_is_not_enough() -> None:
    page = blocks.Section(
        "Run-up", decisive=[blocks.Decisive("is one run-up balanced?", "partly balanced: 45 %", "partly")]
    )
    assert "Not enough: is one run-up balanced: partly balanced: 45 %." in str(blocks.first_page([page]).blocks[0])


def test_small_changes_are_those_of_the_closed_forms(page: str) -> None:
    table = page[page.index("What small changes do</h2>") :]
    rows = [re.findall(r"<td[^>]*>([^<]*)</td>", row) for row in re.findall(r"<tr>(.*?)</tr>", table, re.DOTALL)[:6]]
    heads = re.findall(r"<th[^>]*>([^<]*)</th>", table)[:7]
    found = {row[0]: dict(zip(heads[1:], row[1:], strict=True)) for row in rows if row}
    stiffness = " / ".join(f"{sign}{100.0 * abs(change**0.5 - 1.0):.2g}" for sign, change in (("−", 0.9), ("+", 1.1)))
    assert found["stiffness of the supports"]["critical speed"] == stiffness
    assert found["stiffness of the supports"]["capability"] == "0 / 0"
    mass = " / ".join(f"{sign}{100.0 * abs(change**3 - 1.0):.2g}" for sign, change in (("−", 0.9), ("+", 1.1)))
    assert found["diameter of a ball"]["capability"] == mass


def test_the_numbers_are_those_of_the_machine(page: str) -> None:
    borders = {one.name: one.speed for one in ab.stability.borders(MACHINE)}
    assert f"{borders['exact border'] * 9.549296585513721:.5g} rpm" in page
    assert "G 2.5 at" in page


def test_the_commands_of_a_report_are_understood(page: str) -> None:
    command = typer.main.get_command(app)
    lines = re.findall(r"made by<pre>(.*?)</pre>", page, re.DOTALL)
    assert len(lines) >= 6
    for line in (line for block in lines for line in block.splitlines()):
        words = shlex.split(line.replace("&#34;", '"').replace("&amp;", "&"))[1:]
        name, rest = command.commands[words[0]], words[1:]  # type: ignore[attr-defined]
        name.make_context(
            words[0], [str(MACHINE) if one.endswith(".toml") else one for one in rest], resilient_parsing=True
        )


def test_the_friction_that_rolling_needs_is_that_of_a_ball_that_speeds_up_evenly() -> None:
    machine, rate, top = ab.load_machine(MACHINE), 2.0, 125.0
    time = np.linspace(0.0, 60.0, 2001)
    own = np.minimum(40.0 + rate * time, top)  # from above half of the critical speed, 30 rad/s
    speeds = {
        "speed": ("time", np.full(time.size, top)),
        "ball_speed_in_space": (("time", "ball"), np.stack([own, own], 1)),
    }
    page = balls_page(machine, ab.check(machine), xr.Dataset(speeds, {"time": time}), "")
    cells = page.blocks[2].rows[0]
    ball = math.pi / 6.0 * 0.0123**3 * 7800.0
    carried = ball / (13.339e-3 / 2.0)  # mass over effective mass
    assert cells[1] == f"{(top - 40.0) * 0.07695:.3g} m/s"
    assert cells[2] == "< 0.001 %"
    assert float(cells[3]) == pytest.approx(0.4 * carried * rate / 40.0**2, rel=0.01)


def test_any_block_becomes_a_pdf_whatever_its_signs(tmp_path: Path) -> None:
    pytest.importorskip("typst")
    odd = 'a "b" #let x = 1 $y$ \\ [c] <d> *e* @f µm²'
    picture = ab.plot.race(ab.simulate(MACHINE, duration="0.1 s"))
    blocks = [Paragraph(odd), Rows((odd, "n"), ((odd, "1"),), (False, True)), drawing(picture, odd), Listing(odd)]
    write_pdf(Report(odd, ((odd, odd),), (Section(odd, blocks, odd),)), tmp_path / "a.pdf")
    assert (tmp_path / "a.pdf").read_bytes()[:5] == b"%PDF-"


def test_what_is_no_report_is_refused(tmp_path: Path) -> None:
    with pytest.raises(QuestionError, match=r"written as .html or .pdf"):
        ab.report(MACHINE, tmp_path / "a.txt")
    with pytest.raises(QuestionError, match=r"grade: given 'fine'; write it as in ISO 21940-11"):
        ab.report(MACHINE, tmp_path / "a.html", grade="fine")
    other = {
        "machine": str(ROOT / "examples/machines/stall_and_release.toml"),
        "members": 2,
        "results": ["capability"],
        "vary": {"drag": [1e-4]},
    }
    with pytest.raises(QuestionError, match="study: it is of another machine"):
        ab.report(MACHINE, tmp_path / "a.html", study=ab.study(other))


@pytest.mark.parametrize(("suffix", "package"), [("html", "jinja2"), ("pdf", "typst")])
def test_a_report_that_could_not_be_written_is_refused_before_the_machine_runs(
    suffix: str, package: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("autobalancer.reporting.report.simulate", None)
    monkeypatch.setattr("autobalancer.reporting.report.find_spec", lambda name: None)
    with pytest.raises(QuestionError, match=rf"a.{suffix}: {package}, which .* pip install 'autobalancer\[report\]'"):
        ab.report(MACHINE, tmp_path / f"a.{suffix}")
