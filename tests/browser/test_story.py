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
from tests.browser.conftest import COMPILING, at, sample, until
from tests.browser.test_run import READY, blue, pixels, started

import autobalancer as ab

pytestmark = pytest.mark.browser
expect = pytest.importorskip("playwright.sync_api").expect
DURATION = "6 s"
SAMPLE = ("stall_and_release", "Stall and release")
ROTOR = {"mass": "9.995", "stiffness": "625000", "damping": "100", "inertia": "0.05"}
PASTE = """text => {
  const held = new DataTransfer();
  held.setData('text/plain', text);
  const paste = new ClipboardEvent('paste', { clipboardData: held, bubbles: true, cancelable: true });
  document.querySelector('.cm-content').dispatchEvent(paste);
}"""
PARTS = """
[drive.profile]
kind = "ramp"
start = 0
end = "500 rad/s"
duration = "5 s"

[[unbalances]]
mass = "5 g"
radius = "100 mm"

[[balancers]]
[[balancers.races]]
orbit_radius = "100 mm"
drag = { law = "beta", beta = "1.4685e-4 N*m*s" }
[[balancers.races.balls]]
count = 2
mass = "2.5 g"
material = "steel"
motion = "rolling"
"""


def test_from_an_empty_machine_to_its_report(page: Any, tmp_path: Path) -> None:
    page.get_by_role("button", name="Empty machine").click()
    expect(at(page, "name")).to_have_value("New machine")
    for key, value in ROTOR.items():
        add(page, "rotor", key, value)
    write(page, PARTS)
    expect(at(page, "balancers[1].races[1].orbit_radius")).to_have_value("100")
    expect(at(page, "check")).to_contain_text("critical speed", timeout=COMPILING)
    expect(at(page, "drawing").locator("svg")).to_be_visible()
    run(page)
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


def add(page: Any, path: str, key: str, value: str) -> None:
    """Give a key its value; add it first where the form has no field for it."""
    field = at(page, f"{path}.{key}")
    if not field.count():
        at(page, f"add to {path}").click()
        page.get_by_role("listitem").filter(has_text=re.compile(f"^{key}")).first.click()
    field.fill(value)
    expect(at(page, "toml")).to_contain_text(f'{key} = "{value} ')


def write(page: Any, text: str) -> None:
    """Write at the end of the text of the machine."""
    page.locator(".cm-content").click()
    page.keyboard.press("Control+End")
    page.evaluate(PASTE, "\n" + text)


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
    assert measures["peak_deflection"] == pytest.approx(float(ab.measures(kept)["peak_deflection"]))
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
