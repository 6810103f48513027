"""What one open page works on: the text of a machine, its history, and who wants to know of changes."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from pathlib import Path

from autobalancer.app.store.jobs import Jobs
from autobalancer.app.text.problems import LARGEST, Reading, read
from autobalancer.files.examples import example_text
from autobalancer.safe_file import write_text_safely

FIRST = "stall_and_release"  # what a new user sees
UNDONE = 200  # texts that can be brought back


class Bench:
    """The machine of a page; ``set_text`` is the only way in which it changes."""

    def __init__(self, user: str, home: Path, jobs: Jobs) -> None:
        self.user, self.home, self.jobs = user, home, jobs
        self._draft = home / "draft.toml"
        self.text = self._kept()
        self.reading: Reading = read(self.text)
        self.past: list[str] = []
        self.future: list[str] = []
        self._listeners: list[Callable[[object], None]] = []

    def on_change(self, listener: Callable[[object], None]) -> None:
        """Call ``listener`` with the origin of every change."""
        self._listeners.append(listener)

    def set_text(self, text: str, origin: object = None, *, keep: bool = True) -> None:
        """Take another text; ``origin`` is who changed it, and ``keep`` whether it can be undone."""
        if text == self.text or len(text) > LARGEST:
            return
        if keep:
            self.past = [*self.past, self.text][-UNDONE:]
            self.future = []
        self.text = text
        self.reading = read(text)
        with contextlib.suppress(OSError):
            write_text_safely(self._draft, text)
        for listener in self._listeners:
            listener(origin)

    def undo(self) -> None:
        """Go back to the text before."""
        if self.past:
            self.future.append(self.text)
            self.set_text(self.past.pop(), keep=False)

    def redo(self) -> None:
        """Bring back what was undone."""
        if self.future:
            self.past.append(self.text)
            self.set_text(self.future.pop(), keep=False)

    def _kept(self) -> str:
        """The text with which the user left the page."""
        with contextlib.suppress(OSError, ValueError):
            return self._draft.read_text(encoding="utf-8")[:LARGEST]
        return example_text(FIRST)
