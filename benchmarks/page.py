"""The page in a browser: what a user waits for, how much is sent, what the server keeps, how smoothly balls move.

Server and headless Chromium share this computer. A view counts as there when form, drawing and facts are; a run when its
waveforms are painted. Chromium draws three dimensions without a graphics card on a computer that has none, which the row says.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from tools.browser import ARGUMENTS, CHROMIUM, Server

from autobalancer.app.store.jobs import Job
from autobalancer.app.store.kept_runs import Archive
from autobalancer.files.machine_file import machine_text
from benchmarks import measured
from benchmarks.chamber import machine as chamber_machine

LIMITS = {"first_view_s": 2.0, "click_to_waveform_s": 0.5, "wire_mb": 2.0}
REPEATS = 7
RUNS, FIRST_RUNS = 500, 50  # those after the first are watched for memory
BALLS = 1000
CROWD = "A thousand balls"
PATIENCE = 600_000  # ms; a fresh checkout compiles the equations first
LATEST = """() => document.querySelector('[data-at="run.nc"]')?.getAttribute('href') ?? ''"""
OVER = """(before) => {
  const link = document.querySelector('[data-at="run.nc"]');
  return link && link.getAttribute('href') !== before && !document.querySelector('[data-at="start run"]').disabled;
}"""
PRESSED = """() => {
  const seen = (window.seen = {});
  const button = document.querySelector('[data-at="start run"]');
  button.addEventListener('click', () => (seen.clicked = performance.now()), { once: true, capture: true });
  new MutationObserver((changes, watcher) => {
    const added = changes.flatMap((one) => [...one.addedNodes]);
    if (!added.some((one) => one.classList?.contains('abv'))) return;
    watcher.disconnect();
    // the next frame begins when this one is on its way to the screen
    requestAnimationFrame(() => requestAnimationFrame(() => (seen.drawn = performance.now())));
  }).observe(document.querySelector('[data-at=view]'), { childList: true, subtree: true });
}"""
RENDERER = """() => {
  const gl = document.createElement('canvas').getContext('webgl');
  const about = gl.getExtension('WEBGL_debug_renderer_info');
  return gl.getParameter(about ? about.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
}"""


def bench() -> list[dict[str, Any]]:
    """Five rows; none where Chromium or Playwright is missing."""
    if CHROMIUM is None or find_spec("playwright") is None:
        print("page: no Chromium or no Playwright here")
        return []
    with tempfile.TemporaryDirectory() as place:
        crowd(Path(place) / "local")
        with open_server(Path(place)) as server, open_browser() as browser:
            page = opened(browser, server)
            run(page)
            page.context.close()
            views = [first_view(browser, server) for _ in range(REPEATS)]
            page = opened(browser, server)
            clicks = [click_to_waveform(page) for _ in range(REPEATS)]
            page.context.close()
            rate, by = frame_rate(opened(browser, server))
            grown = memory_growth(opened(browser, server), server)
    median = f"median of {REPEATS}"
    return [
        limited("first_view_s", statistics.median(time for time, _ in views), f"a fresh browser, {median}"),
        limited("click_to_waveform_s", statistics.median(clicks), f"20 s of stall and release, warm, {median}"),
        limited("wire_mb", max(size for _, size in views) / 1e6, "all that the first view fetches"),
        measured("page_memory_growth_mb", grown, "MB", note=f"of the server, runs {FIRST_RUNS} to {RUNS} of one page"),
        measured("frames_per_s_1000_balls", rate, "1/s", note=f"drawn by {by}"),
    ]


def limited(name: str, value: float, note: str) -> dict[str, Any]:
    """A row whose peer is the limit we set ourselves."""
    limit, unit = LIMITS[name], "s" if name.endswith("_s") else "MB"
    row = measured(name, value, unit, note=note)
    return row | {"peer": f"limit {limit:g} {unit}", "ratio": limit / value}


def crowd(home: Path) -> None:
    """A kept run of a deep chamber with a thousand balls."""
    text = machine_text(chamber_machine(BALLS, 160.0).model_copy(update={"name": CROWD}))
    job = Job(1, "local", "run", 600.0)
    job.begun = time.monotonic()
    Archive(home).simulate(text, job, duration="0.005 s")


@contextmanager
def open_server(folder: Path) -> Iterator[Server]:
    """A server for some time."""
    server = Server(folder)
    try:
        yield server
    finally:
        server.stop()


@contextmanager
def open_browser() -> Iterator[Any]:
    """A browser for some time."""
    with import_module("playwright.sync_api").sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield browser
        browser.close()


def fresh(browser: Any) -> Any:
    """A tab of a browser that has nothing of the page yet."""
    page = browser.new_context(viewport={"width": 1280, "height": 860}).new_page()
    page.set_default_timeout(PATIENCE)
    return page


def opened(browser: Any, server: Server) -> Any:
    """A page on its part Run."""
    page = fresh(browser)
    page.goto(server.address)
    there(page)
    page.get_by_role("tab", name="Run").click()
    return page


def there(page: Any) -> None:
    """Wait for form, drawing and facts."""
    for place in ('[data-at="name"]', '[data-at="drawing"] svg', '[data-at="check"] td'):
        page.wait_for_selector(place)


def run(page: Any) -> None:
    """Press Run and wait until it is over."""
    before = page.evaluate(LATEST)
    page.locator('[data-at="start run"]').click()
    page.wait_for_function(OVER, arg=before)


def first_view(browser: Any, server: Server) -> tuple[float, int]:
    """Seconds until form, drawing and facts are there, and the bytes that came."""
    page = fresh(browser)
    wire = page.context.new_cdp_session(page)
    wire.send("Network.enable")
    sizes: list[int] = []
    wire.on("Network.loadingFinished", lambda event: sizes.append(int(event["encodedDataLength"])))
    wire.on("Network.webSocketFrameReceived", lambda event: sizes.append(len(event["response"]["payloadData"])))
    begun = time.perf_counter()
    page.goto(server.address, wait_until="commit")
    there(page)
    taken = time.perf_counter() - begun
    page.wait_for_timeout(2000)  # what is fetched afterwards counts for the bytes
    page.context.close()
    return taken, sum(sizes)


def click_to_waveform(page: Any) -> float:
    """Seconds from the click on Run to the painted waveforms."""
    page.wait_for_timeout(1000)  # a person looks at the last run first
    page.evaluate(PRESSED)
    run(page)
    page.wait_for_function("() => window.seen.drawn")
    return float(page.evaluate("() => (window.seen.drawn - window.seen.clicked) / 1000"))


def memory_growth(page: Any, server: Server) -> float:
    """By how many megabytes the memory of the server grows over many short runs."""
    page.get_by_label("duration").fill("0.2 s")
    for _ in range(FIRST_RUNS):
        run(page)
    before = resident(server)
    for _ in range(RUNS - FIRST_RUNS):
        run(page)
    return resident(server) - before


def resident(server: Server) -> float:
    """Memory of the server, MB."""
    text = Path(f"/proc/{server.process.pid}/status").read_text(encoding="utf-8")
    line = next(line for line in text.splitlines() if line.startswith("VmRSS"))
    return int(line.split()[1]) / 1000.0


def frame_rate(page: Any) -> tuple[float, str]:
    """Pictures per second while a thousand balls move, and what draws them."""
    page.get_by_role("tab", name="Archive").click()
    page.get_by_label("search").fill(CROWD)
    page.get_by_role("button", name="see").last.click()
    page.wait_for_selector(".abv[data-ready=yes]")
    by = page.evaluate(RENDERER)
    page.get_by_role("button", name="play").click()
    page.wait_for_selector(".abv[data-rate]")
    page.wait_for_timeout(5000)
    rate = float(page.locator(".abv").get_attribute("data-rate"))
    page.context.close()
    return rate, "software, without a graphics card" if "SwiftShader" in by or "llvmpipe" in by else by
