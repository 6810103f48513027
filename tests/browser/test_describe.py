"""Describe a machine in a real browser: form, text and drawing are one, and what is impossible is said beside its field."""

from __future__ import annotations

import re
from typing import Any

import pytest
from playwright.sync_api import expect
from tests.browser.conftest import at, sample

pytestmark = pytest.mark.browser


ORBIT = "balancers[1].races[1].orbit_radius"


def message(page: Any, place: str) -> Any:
    return page.locator(".q-field", has=at(page, place)).locator(".q-field__messages")


def test_an_edit_of_the_form_is_in_the_text_and_in_the_drawing_and_can_be_undone(page: Any) -> None:
    sample(page, "discoidal", "Discoidal rotor, planar stand-in")
    field = at(page, ORBIT)
    expect(field).to_have_value("76.95")
    expect(at(page, "drawing").locator("svg")).to_be_visible()
    page.wait_for_timeout(300)
    before = at(page, "drawing").inner_html()
    field.fill("50")
    expect(at(page, "toml")).to_contain_text('orbit_radius = "50 mm"')
    expect(at(page, "toml")).to_contain_text("# linear at any speed")  # comments stay
    page.wait_for_function("before => document.querySelector('[data-at=drawing]').innerHTML !== before", arg=before)
    page.get_by_label("undo").click()
    expect(at(page, "toml")).to_contain_text('orbit_radius = "76.95 mm"')


def test_another_unit_keeps_the_quantity(page: Any) -> None:
    sample(page, "discoidal", "Discoidal rotor, planar stand-in")
    page.get_by_label("unit of orbit_radius").click()
    page.get_by_role("option", name="cm", exact=True).click()
    expect(at(page, "toml")).to_contain_text('orbit_radius = "7.695 cm"')


def test_an_impossible_entry_is_refused_beside_its_field_in_the_words_of_the_file_reader(page: Any) -> None:
    sample(page, "discoidal", "Discoidal rotor, planar stand-in")
    at(page, ORBIT).fill("-3")
    expect(message(page, ORBIT)).to_have_text("given '-3 mm'; must be greater than zero")


def test_the_text_and_the_form_of_an_empty_machine_say_what_is_missing(page: Any) -> None:
    page.get_by_role("button", name="Empty machine").click()
    expect(message(page, "rotor.mass")).to_have_text("missing; it has no default")
    at(page, "rotor.mass").fill("10")
    expect(at(page, "toml")).to_contain_text('mass = "10 kg"')


def test_capability_critical_speed_and_borders_follow_an_edit(page: Any) -> None:
    sample(page, "stall_and_release", "Stall and release")
    expect(at(page, "check")).to_contain_text("critical speed")
    at(page, "rotor.stiffness").fill("2500")
    expect(at(page, "check")).to_contain_text(re.compile(r"4774\.6 rpm \(500 rad/s\)"))
