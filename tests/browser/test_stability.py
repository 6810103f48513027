"""Stability on the page: the map and its point, other analyses, and what is said of machines that they are not for."""

from __future__ import annotations

import io
import json
import re
import signal
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from tests.browser.conftest import COMPILING, Server, at, sample, taken

import autobalancer as ab

pytestmark = pytest.mark.browser
expect = pytest.importorskip("playwright.sync_api").expect


def opened(page: Any, name: str, title: str) -> None:
    """A sample on the page Stability, with its forms filled in."""
    sample(page, name, title)
    page.get_by_role("tab", name="Stability", exact=True).click()


def mapped(page: Any) -> Any:
    """The map of the discoidal rotor; gives its point."""
    opened(page, "discoidal", "Discoidal rotor, planar stand-in")
    expect(at(page, "map speed")).to_have_value(re.compile(r"287\.9:1380 rpm:61"))
    at(page, "ask map").click()
    expect(at(page, "picture map").locator("svg")).to_have_attribute(
        "aria-label", re.compile("^Stability map of Discoidal rotor, planar stand-in. 2501 points"), timeout=COMPILING
    )
    expect(at(page, "point x")).to_have_value("1200")
    expect(at(page, "point y")).to_have_value("20")
    return at(page, "point").locator(".dot")


def middle(place: Any) -> tuple[float, float]:
    box = place.bounding_box()
    return box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]


def test_the_point_is_dragged_over_the_border_and_taken_into_the_machine(page: Any) -> None:
    point = mapped(page)
    expect(at(page, "point verdict")).to_have_text(re.compile(r"^stable: .* 1/s$"), timeout=COMPILING)
    x, y = middle(point)
    under = np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("RGB")).astype(int)[int(y) + 12, int(x) + 12]
    assert under[1] > under[0] + 20, "the point is in the green"
    page.mouse.move(x, y)
    page.mouse.down()
    for k in range(1, 11):
        page.mouse.move(x - 37 * k, y)
        page.wait_for_timeout(20)
    expect(at(page, "point verdict")).to_have_text(re.compile("^unstable: "))  # while it is held
    page.mouse.up()
    expect(at(page, "point verdict")).to_have_text(
        re.compile(r"^unstable: a small disturbance grows with \S+ 1/s$"), timeout=COMPILING
    )
    expect(at(page, "point borders")).to_contain_text("below")
    at(page, "take point").click()
    expect(at(page, "take point")).to_be_disabled()
    speed = at(page, "point x").input_value()  # where it was let go, which the server knows by now
    assert float(speed) < 576.0, "below the critical speed"
    expect(at(page, "old map")).to_be_hidden()  # a map stays that of a machine with another speed or oil
    page.get_by_role("tab", name="Describe").click()
    expect(at(page, "toml")).to_contain_text(f'"12.7 rad/s", "{speed} rpm"]')
    expect(at(page, "toml")).to_contain_text("# linear at any speed")  # comments stay
    page.get_by_label("undo").click()
    expect(at(page, "toml")).to_contain_text('"12.7 rad/s", "1200 rpm"]')


def test_the_point_is_moved_by_keyboard_and_by_what_is_typed(page: Any) -> None:
    point = mapped(page)
    before = middle(point)
    at(page, "point").focus()
    page.keyboard.press("Shift+ArrowLeft")
    page.keyboard.press("ArrowUp")
    expect(at(page, "point x")).to_have_value("1145")  # 5 % of the axis
    expect(at(page, "point y")).to_have_value("20.94")  # 1 % of two decades
    expect(at(page, "point")).to_have_attribute(
        "aria-valuetext", re.compile(r"^rotor speed 1145 rpm, .*: stable: "), timeout=COMPILING
    )
    after = middle(point)
    assert after[0] < before[0] - 10.0
    assert after[1] < before[1] - 2.0
    at(page, "point x").fill("600")
    at(page, "point x").press("Enter")
    expect(at(page, "point verdict")).to_have_text(re.compile("^unstable: "))
    at(page, "point x").fill("9000")
    at(page, "point x").press("Enter")
    message = page.locator(".q-field", has=at(page, "point x")).locator(".q-field__messages")
    expect(message).to_have_text("from 287.9 to 1380 on this map")
    at(page, "own point").click()
    expect(at(page, "point x")).to_have_value("1200")


def test_a_basin_goes_on_when_the_page_is_closed_and_its_picture_is_there_again(
    page: Any, server: Any, tmp_path: Path
) -> None:
    opened(page, "discoidal", "Discoidal rotor, planar stand-in")
    at(page, "analysis basin").click()
    expect(at(page, "basin speed")).to_have_value("1200 rpm")
    at(page, "basin number").fill("50")
    at(page, "ask basin").click()
    begun = at(page, "basin state").filter(has_text=re.compile(r"working|waits|begins|%"))
    expect(begun.or_(at(page, "picture basin").locator("svg")).first).to_be_visible()
    page.goto("about:blank")
    page.goto(server.address)
    page.get_by_role("tab", name="Stability", exact=True).click()
    at(page, "analysis basin").click()
    expect(at(page, "picture basin").locator("svg")).to_be_visible(timeout=COMPILING)
    expect(at(page, "words basin")).to_contain_text("balanced")
    at(page, "analysis campbell").click()
    at(page, "ask campbell").click()
    expect(at(page, "picture campbell").locator("svg")).to_be_visible(timeout=COMPILING)
    saved = {}
    for kind in ("png", "svg", "nc"):
        with page.expect_download(timeout=COMPILING) as download:
            at(page, f"save campbell {kind}").click()
        saved[kind] = tmp_path / download.value.suggested_filename
        download.value.save_as(saved[kind])
    assert Image.open(saved["png"]).size[0] > 800
    assert "<svg" in saved["svg"].read_text()[:2000]
    assert ab.load_run(saved["nc"]).attrs["machine_name"] == "Discoidal rotor, planar stand-in"
    page.get_by_role("tab", name="Describe").click()
    at(page, "rotor.mass").fill("20")
    page.get_by_role("tab", name="Stability", exact=True).click()
    expect(at(page, "old campbell")).to_contain_text("the machine of the page is another one")


def test_a_question_that_is_asked_at_once_is_of_the_machine_as_it_is_now(page: Any, server: Server) -> None:
    opened(page, "discoidal", "Discoidal rotor, planar stand-in")
    at(page, "analysis campbell").click()
    speeds = at(page, "campbell speeds")
    expect(speeds).to_have_value(re.compile("rpm"))
    before = speeds.input_value()
    page.get_by_role("tab", name="Describe").click()
    sample(page, "stall_and_release", "Stall and release")
    server.process.send_signal(signal.SIGSTOP)  # the page is quicker than the server
    try:
        page.get_by_role("tab", name="Stability", exact=True).click()
        at(page, "ask campbell").click()
    finally:
        server.process.send_signal(signal.SIGCONT)
    picture = at(page, "picture campbell").locator("svg")
    expect(picture).to_have_attribute("aria-label", re.compile("of Stall and release"), timeout=COMPILING)
    expect(speeds).not_to_have_value(before)
    about = json.loads((server.folder / "local" / "stability" / "campbell" / "note.json").read_text(encoding="utf-8"))
    assert about["given"]["speeds"] == speeds.input_value()


def test_the_server_ends_soon_while_a_page_is_open_and_something_is_worked_out(chromium: Any, tmp_path: Path) -> None:
    server = Server(tmp_path)
    page = chromium.new_page()
    page.goto(server.address)
    opened(page, "rigid_rotor", "Rigid rotor")
    expect(at(page, "map speed")).to_have_value(re.compile("rpm"))
    at(page, "ask map").click()
    expect(at(page, "map cancel")).to_be_visible()
    server.process.terminate()
    begun = time.monotonic()
    assert server.process.wait(60) == 143
    assert (
        time.monotonic() - begun < 30.0
    )  # 2 s for connections, 3 s for jobs, and a loaded machine; compiling takes longer
    page.close()


def test_what_is_impossible_is_said_beside_its_entry_and_by_machines_that_a_question_is_not_for(page: Any) -> None:
    opened(page, "washing_machine", "Washing machine")
    expect(at(page, "wrong map")).to_contain_text("without gravity across the axis")
    at(page, "analysis response").click()
    at(page, "response speeds").fill("90:300 rpm")
    at(page, "ask response").click()
    message = page.locator(".q-field", has=at(page, "response speeds")).locator(".q-field__messages")
    expect(message).to_contain_text("without the number of values")
    page.get_by_role("tab", name="Describe").click()
    taken(page, lambda: page.get_by_label("sample machine").fill("deep_chamber"), "deep_chamber")
    page.get_by_role("tab", name="Stability", exact=True).click()
    expect(at(page, "wrong response")).to_contain_text("deep chamber")
    expect(at(page, "ask response")).to_be_hidden()
