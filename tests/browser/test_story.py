"""The whole story in a real browser: from an empty machine to its report; all that is saved is opened; without a mouse."""

from __future__ import annotations

import csv
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from tests.browser.conftest import COMPILING, at, sample, taken, until
from tests.browser.test_run import READY, blue, pixels, started

import autobalancer as ab

pytestmark = pytest.mark.browser
expect = pytest.importorskip("playwright.sync_api").expect
DURATION = "6 s"
SAMPLE = ("stall_and_release", "Stall and release")
RACE = "balancers[1].races[1]"
FILLED = {  # what a newcomer writes, in the units that stand beside the fields
    f"{RACE}.balls[1].diameter": "10",
    "rotor.mass": "10",
    "rotor.critical_speed": "1200",
    "rotor.damping_ratio": "0,02",
    "unbalances[1].mass": "5",
    "unbalances[1].radius": "60",
    "drive.profile.end": "3000",
    "drive.profile.duration": "5",
}
MOST_CLICKS = 15  # from nothing to the first run
LISTEN = """() => {
  window.said = [];
  new MutationObserver(() => document.querySelectorAll('.q-notification__message').forEach((one) => said.push(one.innerText)))
    .observe(document.body, { childList: true, subtree: true });
}"""


def test_from_an_empty_machine_to_its_report(page: Any, tmp_path: Path) -> None:
    page.evaluate(LISTEN)
    page.get_by_role("button", name="Empty machine").click()
    expect(at(page, "name")).to_have_value("New machine")
    expect(page.locator("svg.begun")).to_be_visible()
    expect(page.locator(".q-field--error")).to_have_count(0)
    clicks = 1
    at(page, f"{RACE}.orbit_radius").fill("60")
    expect(at(page, "toml")).to_contain_text('orbit_radius = "60 mm"')
    clicks += 1
    for key, value in FILLED.items():
        if key == "rotor.mass":  # lengths suffice for a drawing
            expect(at(page, "drawing").locator("svg.drawn")).to_be_visible(timeout=COMPILING)
        at(page, key).fill(value)
        expect(at(page, "toml")).to_contain_text(f"{key.split('.')[-1]} = {_written(value)}")
        clicks += 1
    expect(page.locator(".q-field--error")).to_have_count(0)
    taken(page, at(page, f"{RACE}.fluid.name").click, "silicone oil 10")
    clicks += 2
    expect(at(page, "check")).to_contain_text("critical speed", timeout=COMPILING)
    run(page)
    clicks += 2
    assert clicks <= MOST_CLICKS
    until(lambda: len(blue(pixels(page))) > 40, "the first ball is in the scene")
    page.get_by_role("tab", name="Archive").click()
    expect(page.locator(".archive-line").first).to_contain_text("New machine")
    page.get_by_role("tab", name="Stability").click()
    with page.expect_download(timeout=COMPILING) as download:
        at(page, "report.pdf").click()
    report = tmp_path / "report.pdf"
    download.value.save_as(report)
    assert report.read_bytes().startswith(b"%PDF")
    assert report.stat().st_size > 50_000
    page.get_by_role("tab", name="Describe").click()
    changes_without_alarm(page)
    assert page.evaluate("said") == []


def _written(value: str) -> str:
    return value.replace(",", ".") if "," in value else f'"{value} '


def changes_without_alarm(page: Any) -> None:
    """Keys and parts come and go, and a part becomes one of another kind."""
    at(page, f"add to {RACE}").click()
    page.get_by_role("listitem").filter(has_text=re.compile("^eccentricity[^_]")).first.click()
    at(page, f"{RACE}.eccentricity").fill("0.05")
    expect(at(page, "toml")).to_contain_text('eccentricity = "0.05 mm"')
    page.get_by_label("remove eccentricity").click()
    expect(at(page, "toml")).not_to_contain_text("eccentricity")
    page.get_by_role("button", name="add unbalance").click()
    expect(at(page, "unbalances[2].radius")).to_be_visible()
    expect(page.locator(".q-field--error, .wrong:visible")).to_have_count(
        1
    )  # what is missing stands in the check alone
    page.get_by_label("remove unbalance 2").click()
    expect(at(page, "unbalances[2].radius")).to_have_count(0)
    taken(page, at(page, f"{RACE}.drag.law").click, "viscous")
    expect(at(page, f"{RACE}.drag.damping")).to_be_visible()
    taken(page, at(page, f"{RACE}.drag.law").click, "discoidal")
    expect(at(page, f"{RACE}.drag.damping")).to_have_count(0)


def run(page: Any) -> None:
    """Run what is on the page and wait until all of it is there."""
    started(page)
    page.wait_for_selector(READY, timeout=COMPILING)
    expect(at(page, "state")).to_contain_text("done", timeout=COMPILING)


def saved(page: Any, kind: str, folder: Path) -> Path:
    """A file that the page gives."""
    with page.expect_download(timeout=COMPILING) as download:
        at(page, kind).click()
    path = folder / kind
    download.value.save_as(path)
    return path


def test_all_that_is_saved_is_what_was_run(page: Any, tmp_path: Path) -> None:
    sample(page, *SAMPLE)
    page.get_by_role("tab", name="Run").click()
    at(page, "duration").fill(DURATION)
    run(page)
    text = saved(page, "machine.toml", tmp_path).read_text()
    assert tomllib.loads(text)["rotor"]["kind"] == "planar"
    assert tomllib.loads(text)["run"]["duration"] == DURATION
    kept = ab.load_run(saved(page, "run.nc", tmp_path))
    assert kept.attrs["end_time"] == pytest.approx(6.0)
    with saved(page, "measures.csv", tmp_path).open() as table:
        measures = {row["measure"]: float(row["value"]) for row in csv.DictReader(table)}
    assert measures["peak_deflection"] == pytest.approx(float(ab.run_measures(kept)["peak_deflection"]))
    assert np.asarray(Image.open(saved(page, "picture.png", tmp_path))).std() > 5.0
    assert "<svg" in saved(page, "picture.svg", tmp_path).read_text()[:2000]
    film = Image.open(saved(page, "film.gif", tmp_path))
    assert getattr(film, "n_frames", 1) > 10
    script = saved(page, "script.py", tmp_path)
    (tmp_path / "run.nc").rename(tmp_path / "page.nc")
    subprocess.run([sys.executable, script.name], cwd=tmp_path, check=True, capture_output=True, timeout=900)
    again = ab.load_run(tmp_path / "run.nc")
    assert again["ball_angle_in_rotor"].values == pytest.approx(kept["ball_angle_in_rotor"].values)


def focused(page: Any, place: str, steps: int = 400) -> None:
    """Go forward with Tab until what is marked so has the focus."""
    has = "place => document.activeElement?.closest(`[data-at='${place}']`) !== null"
    for _ in range(steps):
        if page.evaluate(has, place):
            return
        page.keyboard.press("Tab")
    raise AssertionError(f"Tab does not reach {place}")


def test_a_machine_is_changed_and_run_without_a_mouse(page: Any) -> None:
    sample(page, *SAMPLE)
    page.get_by_role("tab", name="Describe").focus()
    focused(page, "rotor.damping")
    page.keyboard.press("Control+A")
    page.keyboard.type("321")
    expect(at(page, "toml")).to_contain_text('damping = "321 ')
    page.get_by_role("tab", name="Describe").focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Enter")
    focused(page, "start run")
    page.keyboard.press("Enter")
    page.wait_for_selector(READY, timeout=COMPILING)
    expect(at(page, "state")).to_contain_text("done", timeout=COMPILING)
    focused(page, "view")
    until(lambda: len(blue(pixels(page))) > 40, "the first ball is in the scene")
