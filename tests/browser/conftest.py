"""A server of the bench and a real Chromium, once for all tests of a module."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from tools.browser import ARGUMENTS, CHROMIUM, Server

WRITTEN = 700  # ms, after which the page has sent what was written
COMPILING = 400_000  # ms; a fresh checkout compiles the equations first, and another program may have the machine
PATIENCE = 60_000  # ms, of all that is expected of the page: another program may have the machine for a while

with contextlib.suppress(ImportError):  # without Playwright the tests are skipped
    from playwright.sync_api import TimeoutError, expect

    expect.set_options(timeout=PATIENCE)


@pytest.fixture(scope="session")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    running = Server(tmp_path_factory.mktemp("bench"), "--time-limit", str(COMPILING // 1000))
    yield running
    running.stop()


@pytest.fixture(scope="session")
def chromium() -> Iterator[Any]:
    api = pytest.importorskip("playwright.sync_api")
    if CHROMIUM is None:
        pytest.skip("no Chromium here; install one, such as with apt-get install chromium")
    with api.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield browser
        browser.close()


@pytest.fixture(scope="session")
def context(chromium: Any) -> Iterator[Any]:
    """What pages share: scripts are loaded and compiled once."""
    yield (shared := chromium.new_context(viewport={"width": 1280, "height": 860}, accept_downloads=True))
    shared.close()


@pytest.fixture
def page(context: Any, server: Server) -> Iterator[Any]:
    """A page of 1280 by 860; afterwards it must have asked no other host, and have had no errors."""
    with watched(context, server) as (opened, faultless):
        yield opened
        faultless()


@pytest.fixture(scope="module")
def first_page(context: Any, server: Server) -> Iterator[Any]:
    with watched(context, server) as opened:
        yield opened


@pytest.fixture
def same_page(first_page: Any, server: Server, request: pytest.FixtureRequest) -> Iterator[Any]:
    """The same page for all tests of a module that begin on Describe: it is dear to load. A failed test leaves a new one."""
    opened, faultless = first_page
    if opened.url.partition("#")[0] != server.address or request.session.testsfailed:
        opened.goto(server.address)
    opened.get_by_role("tab", name="Describe").click()
    at(opened, "name").wait_for()
    yield opened
    faultless()


@contextlib.contextmanager
def watched(context: Any, server: Server) -> Iterator[tuple[Any, Callable[[], None]]]:
    """A page, and what sees to it that it has asked no other host and had no errors."""
    opened = context.new_page()
    opened.set_default_timeout(PATIENCE)
    asked: list[str] = []
    errors: list[str] = []
    opened.on("request", lambda request: asked.append(request.url))
    opened.on("pageerror", lambda error: errors.append(str(error)))
    opened.on("console", lambda said: errors.append(said.text) if said.type == "error" else None)
    opened.goto(server.address)
    at(opened, "name").wait_for()

    def faultless() -> None:
        others = [url for url in asked if not url.startswith((server.address, "data:", "blob:"))]
        assert not others, f"requests to other hosts: {others}"
        lost = ("ERR_CONNECTION", "WebSocket")  # said while a test starts the server again
        assert not [text for text in errors if not any(words in text for words in lost)]

    yield opened, faultless
    opened.evaluate("localStorage.clear()")
    opened.close()
    context.clear_cookies()


def at(page: Any, place: str) -> Any:
    """What the page marks with this name."""
    return page.locator(f'[data-at="{place}"]')


def sample(page: Any, name: str, title: str) -> None:
    """Take a sample machine; its list is opened again where a change of the page has shut it, as a person would."""
    at(page, "name").wait_for()
    page.get_by_role("button", name="Empty machine").click()
    expect(at(page, "name")).to_have_value("New machine")
    taken(page, lambda: page.get_by_label("sample machine").fill(name), name)
    expect(at(page, "name")).to_have_value(title)


def taken(page: Any, open_list: Callable[[], Any], option: str, *, exact: bool = True) -> None:
    """Take what a list offers; it is opened again where a change of the page has shut it, as a person would."""
    wanted = page.get_by_role("option", name=option, exact=exact)
    for seconds in (3, 6, 12, 24, 48):
        open_list()
        with contextlib.suppress(TimeoutError):
            wanted.first.click(timeout=1000 * seconds)
            return
        page.keyboard.press("Escape")
    raise AssertionError(f"{option} cannot be taken")


def until(true: Callable[[], bool], words: str) -> None:
    """Wait for what the page draws without saying when."""
    end = time.monotonic() + PATIENCE / 1000
    while not true():
        assert time.monotonic() < end, words
        time.sleep(0.05)
