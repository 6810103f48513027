"""Stability on the page: the map, and a point that follows a slider."""

from __future__ import annotations

from typing import Any

import pytest
from playwright.sync_api import expect
from tests.browser.conftest import at, sample

pytestmark = pytest.mark.browser
COMPILING = 300_000  # ms; a fresh checkout compiles the equations first


def test_the_point_of_the_map_follows_the_slider_of_the_speed(page: Any) -> None:
    sample(page, "discoidal", "Discoidal rotor, planar stand-in")
    page.get_by_role("tab", name="Stability").click()
    at(page, "ask map").click()
    drawn = at(page, "analysis").locator("svg")
    expect(drawn).to_have_attribute(
        "aria-label", "Stability map of Discoidal rotor, planar stand-in", timeout=COMPILING
    )
    before = at(page, "analysis").inner_html()
    page.locator('[data-at="slider speed"] [role=slider], [data-at="slider speed"][role=slider]').first.press(
        "ArrowRight"
    )
    moved = "before => document.querySelector('[data-at=analysis]').innerHTML !== before"
    page.wait_for_function(moved, arg=before, timeout=COMPILING)
