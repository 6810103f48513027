"""Run a machine in a real browser: picture, waveforms, archive, export, and what survives a restart."""

from __future__ import annotations

import io
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import expect
from tests.browser.conftest import at, sample

pytestmark = pytest.mark.browser
COMPILING = 300_000  # ms; a fresh checkout compiles the equations first
READY = ".abv[data-ready=yes]"


def ran(page: Any) -> None:
    """Run a sample and wait for the picture and the verdict."""
    sample(page, "stall_and_release", "Stall and release")
    started(page)
    page.wait_for_selector(READY, timeout=COMPILING)
    expect(at(page, "verdict")).to_contain_text("balanced: vibration", timeout=COMPILING)


def started(page: Any) -> None:
    """Go to the page Run and start; once more where the page was still being drawn under the first click."""
    page.get_by_role("tab", name="Run").click()
    for _ in range(3):
        at(page, "run").click()
        try:
            expect(at(page, "state")).not_to_have_text("", timeout=5000)
            return
        except AssertionError:
            continue


def pixels(page: Any) -> Any:
    """The scene as it is seen."""
    return np.asarray(Image.open(io.BytesIO(page.locator(".abv-scene").screenshot())).convert("RGB")).astype(int)


def blue(picture: Any) -> Any:
    """Where the first ball is: its color is that of the package, however it is lit."""
    red, green, most = picture[..., 0], picture[..., 1], picture[..., 2]
    return np.argwhere((most - red > 60) & (most - green > 25) & (most > 70))


def test_a_run_is_drawn_and_its_balls_move_with_the_time(page: Any) -> None:
    ran(page)
    slider = page.get_by_label("time", exact=True)
    slider.fill("200")
    first = blue(pixels(page))
    assert len(first) > 40, "the first ball is in the picture"
    slider.fill("1500")
    later = blue(pixels(page))
    assert len(later) > 40
    assert np.hypot(*(first.mean(axis=0) - later.mean(axis=0))) > 5.0, "it is elsewhere at another time"
    waves = page.locator("canvas.abv-wave")
    assert waves.count() == 4
    drawn = np.asarray(Image.open(io.BytesIO(waves.nth(1).screenshot())).convert("RGB")).astype(int)
    assert len(blue(drawn)) > 100, "the deflection is a blue band"


def test_a_waveform_is_zoomed_by_keyboard_and_the_whole_run_comes_back(page: Any) -> None:
    ran(page)
    wave = page.locator("canvas.abv-wave").first
    whole = wave.screenshot()
    page.get_by_label("zoom in").focus()
    page.keyboard.press("Enter")
    assert wave.screenshot() != whole
    page.get_by_label("show the whole run").press("Enter")
    page.mouse.move(5, 5)
    assert wave.screenshot() == whole


def test_a_run_is_saved_in_every_form(page: Any, tmp_path: Path) -> None:
    ran(page)
    saved = {}
    for kind in ("machine.toml", "script.py", "measures.csv", "run.nc", "picture.svg"):
        with page.expect_download() as download:
            at(page, kind).click()
        saved[kind] = tmp_path / kind
        download.value.save_as(saved[kind])
    assert tomllib.loads(saved["machine.toml"].read_text())["name"] == "Stall and release"
    assert "ab.simulate(machine)" in saved["script.py"].read_text()
    assert "peak_deflection" in saved["measures.csv"].read_text()
    assert "<svg" in saved["picture.svg"].read_text()[:2000]
    import autobalancer as ab

    assert ab.load_run(saved["run.nc"]).attrs["outcome"] == "finished"


def test_the_archive_finds_tags_and_compares_runs_and_survives_a_restart(page: Any, server: Any) -> None:
    ran(page)
    page.get_by_role("tab", name="Archive").click()
    boxes = page.get_by_role("checkbox")
    expect(boxes.first).to_be_visible()
    before = boxes.count()
    page.get_by_role("tab", name="Describe").click()
    at(page, "rotor.damping").fill("200")
    expect(at(page, "toml")).to_contain_text('damping = "200 N*s/m"')
    started(page)
    for _ in range(60):  # the state may still be that of the first run
        page.get_by_role("tab", name="Archive").click()
        page.wait_for_timeout(500)
        if boxes.count() > before:
            break
        page.get_by_role("tab", name="Run").click()
    assert boxes.count() == before + 1
    boxes.nth(0).click()
    expect(at(page, "compared")).to_contain_text("Side by side")
    boxes.nth(1).click()
    expect(at(page, "compared")).to_contain_text("rotor.damping")
    expect(at(page, "compared")).to_contain_text("200 N*s/m")
    server.stop()
    server.start()
    page.goto(server.address)
    page.get_by_role("tab", name="Archive").click()
    page.get_by_role("button", name="see").first.click()
    page.wait_for_selector(READY)


def test_the_rest_of_the_server_says_nothing_of_other_files(page: Any, server: Any) -> None:
    for path in (
        "run/../draft.toml/x",
        "run/..%2f..%2fetc/passwd",
        "run/20260101-000000-000000/view.bin",
        "run/x/run.nc",
    ):
        assert page.request.get(server.address + path).status in (404, 422)
