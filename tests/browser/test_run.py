"""Run a machine in a real browser: picture, waveforms, archive, export, and what survives a restart."""

from __future__ import annotations

import io
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from tests.browser.conftest import COMPILING, at, sample, until
from tools.browser import Server

pytestmark = pytest.mark.browser
expect = pytest.importorskip("playwright.sync_api").expect
READY = ".abv[data-ready=yes]"


def ran(page: Any) -> None:
    """Run a sample and wait for the picture and the verdict."""
    sample(page, "stall_and_release", "Stall and release")
    started(page)
    page.wait_for_selector(READY, timeout=COMPILING)
    expect(at(page, "verdict")).to_contain_text(
        re.compile("balanced, but the greatest deflection .*: vibration 0"), timeout=COMPILING
    )


@pytest.fixture(scope="module")
def shown(first_page: Any) -> Iterator[Any]:
    """A page with a run, which the tests look at one after the other."""
    page, faultless = first_page
    ran(page)
    yield page
    faultless()


def started(page: Any) -> None:
    """Go to the page Run and start."""
    page.get_by_role("tab", name="Run").click()
    at(page, "start run").click(timeout=COMPILING)  # when the run before has ended


def pixels(page: Any) -> Any:
    """The scene as it is seen."""
    return np.asarray(Image.open(io.BytesIO(page.locator(".abv-scene").screenshot())).convert("RGB")).astype(int)


def blue(picture: Any) -> Any:
    """Where the first ball is: its color is that of the package, however it is lit."""
    red, green, most = picture[..., 0], picture[..., 1], picture[..., 2]
    return np.argwhere((most - red > 60) & (most - green > 25) & (most > 70))


def test_a_duration_without_a_unit_is_told_where_it_is_written_and_starts_nothing(page: Any, server: Server) -> None:
    kept = server.folder / "local" / "runs"
    before = len(list(kept.glob("*/note.json")))
    sample(page, "stall_and_release", "Stall and release")
    page.get_by_role("tab", name="Run").click()
    at(page, "duration").fill("20")
    expect(page.locator("label", has=at(page, "duration"))).to_contain_text('write it as "20 s"')
    at(page, "start run").click(timeout=COMPILING)
    at(page, "duration").fill("0.1 s")
    expect(page.locator("label", has=at(page, "duration"))).not_to_contain_text("write it")
    at(page, "start run").click()
    expect(at(page, "state")).to_contain_text("done in", timeout=COMPILING)
    assert len(list(kept.glob("*/note.json"))) == before + 1


def test_a_run_is_drawn_and_its_balls_move_with_the_time(shown: Any) -> None:
    slider = shown.get_by_label("time", exact=True)
    slider.fill("200")
    until(lambda: len(blue(pixels(shown))) > 40, "the first ball is in the picture")
    first = blue(pixels(shown))
    slider.fill("1500")

    def elsewhere() -> bool:
        later = blue(pixels(shown))
        return len(later) > 40 and bool(np.hypot(*(first.mean(axis=0) - later.mean(axis=0))) > 5.0)

    until(elsewhere, "the ball is elsewhere at another time")
    waves = shown.locator("canvas.abv-wave")
    assert waves.count() == 4

    def band() -> bool:
        drawn = np.asarray(Image.open(io.BytesIO(waves.nth(1).screenshot())).convert("RGB")).astype(int)
        return len(blue(drawn)) > 100

    until(band, "the deflection is a blue band")


def test_a_waveform_is_zoomed_by_keyboard_and_the_whole_run_comes_back(shown: Any) -> None:
    wave = shown.locator("canvas.abv-wave").first
    whole = wave.screenshot()
    shown.get_by_label("zoom in").focus()
    shown.keyboard.press("Enter")
    until(lambda: wave.screenshot() != whole, "less of the run is seen")
    shown.get_by_label("show the whole run").press("Enter")
    shown.mouse.move(5, 5)
    until(lambda: wave.screenshot() == whole, "the whole run is seen again")


def test_a_run_is_saved_in_every_form(shown: Any, tmp_path: Path) -> None:
    saved = {}
    for kind in ("machine.toml", "script.py", "measures.csv", "run.nc", "picture.svg"):
        with shown.expect_download(timeout=COMPILING) as download:
            at(shown, kind).click()
        saved[kind] = tmp_path / kind
        download.value.save_as(saved[kind])
    assert tomllib.loads(saved["machine.toml"].read_text())["name"] == "Stall and release"
    assert "ab.simulate(machine)" in saved["script.py"].read_text()
    assert "peak_deflection" in saved["measures.csv"].read_text()
    assert "<svg" in saved["picture.svg"].read_text()[:2000]
    import autobalancer as ab

    assert ab.load_run(saved["run.nc"]).attrs["outcome"] == "finished"


def test_the_archive_finds_tags_and_compares_runs_and_survives_a_restart(shown: Any, server: Any) -> None:
    first = at(shown, "machine.toml").get_attribute("href")
    shown.get_by_role("tab", name="Archive").click()
    boxes = shown.get_by_role("checkbox")
    before = len(list((server.folder / "local" / "runs").glob("*/note.json")))
    expect(boxes).to_have_count(before)
    shown.get_by_role("tab", name="Describe").click()
    at(shown, "rotor.damping").fill("200")
    expect(at(shown, "toml")).to_contain_text('damping = "200 N*s/m"')
    started(shown)
    expect(at(shown, "machine.toml")).not_to_have_attribute("href", str(first), timeout=COMPILING)
    shown.get_by_role("tab", name="Archive").click()
    expect(boxes).to_have_count(before + 1)
    boxes.nth(0).click()
    expect(at(shown, "compared")).to_contain_text("Side by side")
    boxes.nth(1).click()
    expect(at(shown, "compared")).to_contain_text("rotor.damping")
    expect(at(shown, "compared")).to_contain_text("200 N*s/m")
    shown.goto("about:blank")  # an open page loads itself again when the server is back, just when the test does
    server.stop()
    server.start()
    shown.goto(server.address)
    shown.get_by_role("tab", name="Archive").click()
    shown.get_by_role("button", name="see").first.click()
    shown.wait_for_selector(READY, timeout=COMPILING)
    latest = sorted(path.parent.name for path in (server.folder / "local" / "runs").glob("*/note.json"))[-1]
    expect(shown).to_have_url(f"{server.address}#run/{latest}")
    shown.reload()  # the address finds the run
    shown.wait_for_selector(READY, timeout=COMPILING)
    expect(at(shown, "machine.toml")).to_have_attribute("href", f"/run/{latest}/machine.toml")
    shown.go_back()
    expect(at(shown, "tab archive")).to_have_attribute("aria-selected", "true")


def test_the_rest_of_the_server_says_nothing_of_other_files(shown: Any, server: Any) -> None:
    for path in (
        "run/../draft.toml/x",
        "run/..%2f..%2fetc/passwd",
        "run/20260101-000000-000000/view.bin",
        "run/x/run.nc",
    ):
        assert shown.request.get(server.address + path).status in (404, 422)
