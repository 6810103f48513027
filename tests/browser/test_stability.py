"""Stability on the page: the map of the machine."""

from __future__ import annotations

from typing import Any

import pytest
from playwright.sync_api import expect
from tests.browser.conftest import at, sample

pytestmark = pytest.mark.browser
COMPILING = 300_000  # ms; a fresh checkout compiles the equations first


def test_the_map_of_the_machine_is_drawn_in_the_background(page: Any) -> None:
    sample(page, "discoidal", "Discoidal rotor, planar stand-in")
    page.get_by_role("tab", name="Stability").click()
    at(page, "ask map").click()
    drawn = at(page, "analysis").locator("svg")
    expect(drawn).to_have_attribute(
        "aria-label", "Stability map of Discoidal rotor, planar stand-in", timeout=COMPILING
    )
