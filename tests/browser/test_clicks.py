"""No click is lost: not while the page opens, not while it is drawn anew, and not in silence when the server is late."""

from __future__ import annotations

import signal
import time
from typing import Any

import pytest
from tests.browser.conftest import COMPILING, WRITTEN, at, sample
from tools.browser import Server

pytestmark = pytest.mark.browser
expect = pytest.importorskip("playwright.sync_api").expect
TIMES = 3


@pytest.fixture
def page(same_page: Any) -> Any:
    return same_page


def runs(server: Server) -> int:
    """Runs that the server has kept."""
    return len(list((server.folder / "local" / "runs").glob("*/note.json")))


def kept(server: Server, wanted: int) -> None:
    """Wait until there are so many runs, and see that no more come."""
    end = time.monotonic() + COMPILING / 1000
    while runs(server) < wanted and time.monotonic() < end:
        time.sleep(0.05)
    assert runs(server) == wanted


def press_run(page: Any) -> None:
    """Both clicks with nothing between them."""
    page.get_by_role("tab", name="Run").click()
    at(page, "start run").click(timeout=COMPILING)  # when the run before has ended


def test_a_click_while_the_page_opens_is_not_lost(page: Any, server: Server) -> None:
    press_run(page)
    kept(server, before := max(runs(server), 1))
    for number in range(1, TIMES + 1):
        page.goto(server.address, wait_until="commit")
        press_run(page)
        kept(server, before + number)


def test_a_click_while_the_form_is_made_anew_is_not_lost(page: Any, server: Server) -> None:
    before = runs(server)
    for number in range(1, TIMES + 1):
        page.get_by_role("tab", name="Describe").click()
        at(page, "rotor.damping").fill(str(100 + number))  # the form, the drawing and the facts follow
        page.get_by_label("undo").click()
        press_run(page)
        kept(server, before + number)
        expect(at(page, "start run")).to_be_enabled()


def test_a_tab_shows_its_part_also_while_the_server_is_late_and_the_page_says_that_it_waits(
    page: Any, server: Server
) -> None:
    before = runs(server)
    server.process.send_signal(signal.SIGSTOP)
    try:
        press_run(page)
        expect(page.locator("body.waits")).to_be_visible()
        time.sleep(1.0)
    finally:
        server.process.send_signal(signal.SIGCONT)
    kept(server, before + 1)
    expect(page.locator("body.waits")).to_have_count(0)


@pytest.mark.parametrize("changed", [False, True], ids=["the same machine", "another machine"])
def test_what_is_written_as_soon_as_the_form_is_seen_again_is_not_lost(
    page: Any, server: Server, changed: bool
) -> None:
    sample(page, "discoidal", "Discoidal rotor, planar stand-in")
    page.get_by_role("tab", name="Run").click()
    at(page, "start run").wait_for()
    page.get_by_label("undo").click()
    expect(page.locator("header")).to_contain_text("not possible yet")  # the empty machine
    server.process.send_signal(signal.SIGSTOP)  # the page is quicker than the server
    try:
        page.get_by_role("tab", name="Describe").click()
        expect(at(page, "name")).to_have_value("New machine")
        at(page, "rotor.mass").fill("20")
        page.wait_for_timeout(WRITTEN)
    finally:
        server.process.send_signal(signal.SIGCONT)
    expect(at(page, "toml")).to_contain_text('mass = "20 kg"')
    expect(at(page, "rotor.mass")).to_have_value("20")


def test_what_is_written_into_a_field_that_is_just_replaced_is_not_lost_in_silence(page: Any, server: Server) -> None:
    sample(page, "discoidal", "Discoidal rotor, planar stand-in")
    server.process.send_signal(signal.SIGSTOP)
    try:
        page.get_by_label("undo").click()
        at(page, "rotor.mass").fill("33")  # of the machine that goes
    finally:
        server.process.send_signal(signal.SIGCONT)
    expect(page.get_by_text("The page had just changed under this; please do it again.")).to_be_visible()
    expect(at(page, "name")).to_have_value("New machine")


def test_help_is_there_also_where_the_form_was_made_behind_another_part(page: Any) -> None:
    sample(page, "discoidal", "Discoidal rotor, planar stand-in")
    page.get_by_role("tab", name="Run").click()
    page.get_by_label("undo").click()
    expect(page.locator("header")).to_contain_text("not possible yet")
    page.get_by_label("redo").click()
    expect(page.locator("header")).to_contain_text("Discoidal rotor")
    page.get_by_role("tab", name="Describe").click()
    text = at(page, "description")
    page.wait_for_function(
        "one => one.clientHeight >= one.scrollHeight", arg=text.element_handle()
    )  # all lines are seen
    at(page, "rotor.mass").hover()
    expect(page.get_by_role("tooltip").filter(has_text="without balls")).to_be_visible()


def test_every_mark_on_the_page_is_there_once(page: Any) -> None:
    marks = page.evaluate(
        "() => Object.values(mounted_app.elements).map((one) => one.props['data-at']).filter(Boolean)"
    )
    assert len(marks) > 30
    assert sorted(marks) == sorted(set(marks))
