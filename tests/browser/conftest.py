"""A server of the bench and a real Chromium, once for all tests of a module."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
ARGUMENTS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


def free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


class Server:
    """The command ``autobalancer app``, started as a user starts it."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.port = folder, free_port()
        self.address = f"http://127.0.0.1:{self.port}/"
        self.start()

    def start(self) -> None:
        words = ["app", "--port", str(self.port), "--folder", str(self.folder), "--no-browser"]
        alone = {
            name: value for name, value in os.environ.items() if "PYTEST" not in name
        }  # NiceGUI tests itself with it
        self.process = subprocess.Popen([sys.executable, "-m", "autobalancer", *words], env=alone)
        for _ in range(600):
            with socket.socket() as one:
                if one.connect_ex(("127.0.0.1", self.port)) == 0:
                    return
            assert self.process.poll() is None, "the server ended"
            time.sleep(0.1)
        raise AssertionError("the server does not answer")

    def stop(self) -> None:
        self.process.terminate()
        self.process.wait(20)


@pytest.fixture(scope="session")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    running = Server(tmp_path_factory.mktemp("bench"))
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


@pytest.fixture
def page(chromium: Any, server: Server) -> Iterator[Any]:
    """A page of 1280 by 860; afterwards it must have asked no other host, and have had no errors."""
    context = chromium.new_context(viewport={"width": 1280, "height": 860}, accept_downloads=True)
    opened = context.new_page()
    opened.set_default_timeout(20_000)
    asked: list[str] = []
    errors: list[str] = []
    opened.on("request", lambda request: asked.append(request.url))
    opened.on("pageerror", lambda error: errors.append(str(error)))
    opened.on("console", lambda said: errors.append(said.text) if said.type == "error" else None)
    opened.goto(server.address)
    opened.wait_for_selector('[data-at="name"]')
    yield opened
    context.close()
    others = [url for url in asked if not url.startswith((server.address, "data:", "blob:"))]
    assert not others, f"requests to other hosts: {others}"
    lost = ("ERR_CONNECTION", "WebSocket connection")  # said while a test starts the server again
    assert not [text for text in errors if not any(words in text for words in lost)]


def at(page: Any, place: str) -> Any:
    """What the page marks with this name."""
    return page.locator(f'[data-at="{place}"]')


def sample(page: Any, name: str, title: str) -> None:
    """Take a sample machine; its list is opened again where a change of the page has shut it, as a person would."""
    api = pytest.importorskip("playwright.sync_api")
    at(page, "name").wait_for()
    page.get_by_role("button", name="Empty machine").click()
    api.expect(at(page, "name")).to_have_value("New machine")
    for _ in range(5):
        try:
            page.get_by_label("sample machine").fill(name)
            page.get_by_role("option", name=name, exact=True).click(timeout=3000)
            break
        except api.TimeoutError:
            continue
    api.expect(at(page, "name")).to_have_value(title)
