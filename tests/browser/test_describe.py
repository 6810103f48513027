"""Describe a machine in a real browser: form, text and drawing are one, and what is impossible is said beside its field."""

from __future__ import annotations

import re
import signal
from typing import Any

import pytest
from tests.browser.conftest import COMPILING, WRITTEN, Server, at, sample, taken, until

pytestmark = pytest.mark.browser
expect = pytest.importorskip("playwright.sync_api").expect


@pytest.fixture
def page(same_page: Any) -> Any:
    return same_page


ORBIT = "balancers[1].races[1].orbit_radius"


def message(page: Any, place: str) -> Any:
    return page.locator(".q-field", has=at(page, place)).locator(".q-field__messages").last  # one may be on its way out


def test_an_edit_of_the_form_is_in_the_text_and_in_the_drawing_and_can_be_undone(page: Any) -> None:
    sample(page, "discoidal", "Discoidal rotor, planar stand-in")
    field = at(page, ORBIT)
    expect(field).to_have_value("76.95")
    expect(at(page, "drawing").locator("svg")).to_be_visible()
    expect(at(page, "drawing")).not_to_have_class(re.compile("old"))
    before = at(page, "drawing").inner_html()
    field.fill("50")
    expect(at(page, "toml")).to_contain_text('orbit_radius = "50 mm"')
    expect(at(page, "toml")).to_contain_text("# linear at any speed")  # comments stay
    page.wait_for_function("before => document.querySelector('[data-at=drawing]').innerHTML !== before", arg=before)
    page.get_by_label("undo").click()
    expect(at(page, "toml")).to_contain_text('orbit_radius = "76.95 mm"')


def test_what_is_typed_into_the_text_is_not_overwritten_by_an_edit_of_the_form(page: Any, server: Server) -> None:
    sample(page, "discoidal", "Discoidal rotor, planar stand-in")
    server.process.send_signal(signal.SIGSTOP)  # both come to the server at once
    try:
        page.locator(".cm-content").click()
        page.keyboard.press("Control+End")
        page.keyboard.type("\n# by hand")
        at(page, ORBIT).fill("50")
        page.wait_for_timeout(WRITTEN)
    finally:
        server.process.send_signal(signal.SIGCONT)
    expect(at(page, "toml")).to_contain_text('orbit_radius = "50 mm"')
    expect(at(page, "toml")).to_contain_text("# by hand")
    expect(at(page, ORBIT)).to_have_value("50")


def test_a_bin_stands_beside_the_header_of_its_box_and_takes_the_part_away(page: Any) -> None:
    sample(page, "discoidal", "Discoidal rotor, planar stand-in")
    expect(at(page, "toml")).to_contain_text("fluid = {")
    assert (
        page.evaluate("() => document.querySelectorAll('[role=button] button, .q-item--clickable button').length") == 0
    )
    taken_away = page.get_by_label("remove fluid")
    header = at(page, "balancers[1].races[1].fluid").locator(".q-item").first
    bin_, title = taken_away.bounding_box(), header.bounding_box()
    assert title["y"] <= bin_["y"]
    assert bin_["y"] + bin_["height"] <= title["y"] + title["height"] + 1.0
    taken_away.click()
    expect(at(page, "toml")).not_to_contain_text("fluid = {")


def test_another_unit_keeps_the_quantity_and_an_impossible_entry_is_refused_beside_its_field(page: Any) -> None:
    sample(page, "discoidal", "Discoidal rotor, planar stand-in")
    taken(page, page.get_by_label("unit of orbit_radius").click, "cm")
    expect(at(page, "toml")).to_contain_text('orbit_radius = "7.695 cm"')
    at(page, "balancers[1].races[1].balls[1].start_angles").fill(
        "10 deg, 20 deg"
    )  # without the brackets and quotes of the text
    expect(at(page, "toml")).to_contain_text('start_angles = ["10 deg", "20 deg"]')
    at(page, ORBIT).fill("-3")
    expect(message(page, ORBIT)).to_have_text("given '-3 cm'; must be greater than zero")


MATRICES = """name = "Two masses"
axis = "vertical"
stations = [{ name = "race", position = "100 mm" }]
unbalances = [{ moment = "300 g*mm", station = "race" }]
drive = { kind = "speed", profile = { kind = "constant", speed = "400 rad/s" } }
run = { duration = "0.1 s" }

[rotor]
kind = "matrices"
files = { stiffness = "K.csv", mass = "M.csv", nodes = "nodes.csv", length_unit = "mm", mass_unit = "t" }

[[balancers]]
station = "race"
races = [{ orbit_radius = "70 mm", drag = { law = "viscous", damping = "1e-4 N*m*s" }, balls = [
  { count = 2, mass = "4 g", diameter = "10 mm" } ] }]
"""
FILES = {  # of a rotor with masses of 2 kg and 3 kg on springs of 100 N/mm, and one of 50 N/mm between them
    "nodes": "node, direction, position [mm]\n1, ux, 0\n1, uy, 0\n2, ux, 100\n2, uy, 100\n",
    "stiffness": "150 0 -50 0\n0 150 0 -50\n-50 0 150 0\n0 -50 0 150\n",
    "mass": "2e-3 0 0 0\n0 2e-3 0 0\n0 0 3e-3 0\n0 0 0 3e-3\n",
}


def test_matrices_are_given_beside_the_fields_that_name_them_and_can_be_replaced_and_deleted(page: Any) -> None:
    def give(place: str, name: str, text: str) -> None:
        at(page, place).locator("input[type=file]").set_input_files(
            [{"name": name, "mimeType": "", "buffer": text.encode()}]
        )

    give("upload", "masses.toml", MATRICES)
    for key, name in (("stiffness", "K.csv"), ("mass", "M.csv"), ("nodes", "nodes.csv")):
        expect(at(page, "check")).to_contain_text(f"file '{name}': is not here")
        give(f"upload rotor.files.{key}", name, FILES[key])
    expect(at(page, "check")).to_contain_text("matrices: M.csv: 4 coordinates", timeout=COMPILING)
    give("upload rotor.files.stiffness", "K.csv", FILES["stiffness"].replace("150", "-150"))  # another of this name
    expect(at(page, "check")).to_contain_text("is negative for some motion, so it does not rest")
    at(page, "data files").click()
    page.get_by_label("delete M.csv").click()
    page.get_by_role("button", name="Delete", exact=True).click()
    expect(at(page, "check")).to_contain_text("file 'M.csv': is not here")
    expect(message(page, "rotor.files.mass")).to_contain_text("is not here")


def test_the_text_and_the_form_of_an_empty_machine_say_what_is_missing(page: Any) -> None:
    page.get_by_role("button", name="Empty machine").click()
    expect(message(page, "rotor.mass")).to_contain_text("without balls, with all attached parts")
    at(page, "rotor.mass").focus()
    page.keyboard.press("Tab")
    expect(message(page, "rotor.mass")).to_have_text("missing; it has no default")
    expect(page.locator(".q-field--error")).to_have_count(1)
    at(page, "rotor.mass").fill("10")
    expect(at(page, "toml")).to_contain_text('mass = "10 kg"')
    page.get_by_role("tab", name="Run").click()
    at(page, "start run").click()
    page.get_by_role("tab", name="Describe").click()
    expect(message(page, "drive.profile.end")).to_have_text("missing; it has no default")


def test_capability_critical_speed_and_borders_follow_an_edit(page: Any) -> None:
    sample(page, "stall_and_release", "Stall and release")
    expect(at(page, "check")).to_contain_text("critical speed", timeout=COMPILING)
    at(page, "rotor.stiffness").fill("2500")
    expect(at(page, "check")).to_contain_text(re.compile(r"4774\.6 rpm \(500 rad/s\)"), timeout=COMPILING)


def test_a_sample_that_was_changed_can_be_taken_once_more(page: Any) -> None:
    sample(page, "discoidal", "Discoidal rotor, planar stand-in")
    box = page.get_by_label("sample machine")
    expect(box).to_have_value("")
    at(page, "rotor.mass").fill("20")
    expect(at(page, "toml")).to_contain_text('mass = "20 kg"')
    taken(page, lambda: box.fill("discoidal"), "discoidal")
    expect(at(page, "toml")).to_contain_text('mass = "12.27 kg"')


def test_the_first_press_of_light_or_dark_gives_the_other_shade_also_where_the_browser_is_dark(
    chromium: Any, server: Server
) -> None:
    context = chromium.new_context(color_scheme="dark")
    dark = context.new_page()
    dark.goto(server.address)
    expect(dark.locator("body.body--dark")).to_be_visible()
    expect(dark.locator("svg.drawn").first).to_have_css("filter", re.compile("invert"))
    at(dark, "shade").click()
    expect(dark.locator("body.body--light")).to_be_visible()
    at(dark, "shade").click()
    expect(dark.locator("body.body--dark")).to_be_visible()
    context.close()


def test_the_drawing_is_shown_larger_and_put_away_by_keyboard(page: Any) -> None:
    sample(page, "two_plane_rotor", "Two-plane rotor")
    expect(at(page, "drawing")).not_to_have_class(re.compile("old"))
    small = at(page, "drawing").locator("svg").bounding_box()
    at(page, "enlarge").click()
    drawing = at(page, "large drawing").locator("svg")
    expect(drawing).to_be_visible()
    least = 2.0 * small["width"]
    until(
        lambda: drawing.bounding_box()["width"] > least, "it is large when the dialog has opened, and grows until then"
    )
    page.keyboard.press("Escape")
    expect(drawing).to_be_hidden()


def test_an_empty_machine_has_a_sketch_and_an_impossible_one_the_last_drawing_that_was_possible(page: Any) -> None:
    drawing = at(page, "drawing").locator("svg.drawn")
    sample(page, "two_plane_rotor", "Two-plane rotor")
    at(page, "rotor.mass").fill("1e30")
    expect(at(page, "check")).to_contain_text("must not be larger")
    expect(at(page, "drawing")).to_have_class(re.compile("old"))
    expect(drawing).to_have_attribute("aria-label", re.compile("Two-plane rotor"))
    page.get_by_role("button", name="Empty machine").click()
    expect(drawing).to_have_count(0)
