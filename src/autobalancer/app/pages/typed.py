"""A text that is being written: who asks for it gets also what was typed a moment ago, so that no change overwrites another."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from pathlib import Path

from autobalancer.app.text.problems import LARGEST
from autobalancer.errors import ResultError
from autobalancer.safe_file import write_text_safely

UNDONE = 200  # texts that can be brought back


class Typed:
    """The text, who wants to know of changes, and what an editor waits with until the typing pauses.

    It stays in the file at ``path`` when the page is left; ``first`` is what there is before. :meth:`set_text` is the only way in
    which it changes. Where another page has changed the file meanwhile, ``on_other_page`` is called, and its text can be brought
    back by undoing twice.
    """

    def __init__(self, path: Path, first: str) -> None:
        self._path, self._text = path, first
        with contextlib.suppress(OSError, ValueError):
            self._text = path.read_text(encoding="utf-8")[:LARGEST]
        self._written = self._text  # as this page knows the file
        self.on_other_page: Callable[[], None] = lambda: None
        self.typing: Callable[[], None] | None = None
        self._listeners: list[Callable[[object], None]] = []
        self.past: list[str] = []
        self.future: list[str] = []

    def take(self) -> None:
        """Take what is being typed."""
        typing, self.typing = self.typing, None
        if typing is not None:
            typing()

    @property
    def text(self) -> str:
        """With all that was typed."""
        self.take()
        return self._text

    def edit(self, change: Callable[[str], str], origin: object = None) -> None:
        """Change the text; where something typed has to be taken first, the entries of ``origin`` are not up to date either."""
        late = self.typing is not None
        text = change(self.text)
        self.set_text(text, None if late else origin)

    def on_change(self, listener: Callable[[object], None]) -> None:
        """Call ``listener`` with the origin of every change."""
        self._listeners.append(listener)

    def set_text(self, text: str, origin: object = None, *, keep: bool = True) -> None:
        """Take another text; ``origin`` is who changed it, and ``keep`` whether it can be undone."""
        self.take()
        if text == self._text or len(text) > LARGEST:
            return
        other = self._of_other_page()
        if keep:
            self.past = [*self.past, *([] if other is None else [other]), self._text][-UNDONE:]
            self.future = []
        self._text = text
        self._understand()
        with contextlib.suppress(OSError, ResultError):  # a full disk: the page goes on
            write_text_safely(self._path, text)
            self._written = text
        self.tell(origin)
        if other is not None:
            self.on_other_page()

    def tell(self, origin: object) -> None:
        """Call everyone who wants to know."""
        for listener in self._listeners:
            listener(origin)

    def look(self) -> None:
        """Follow another page that has changed the file, unless somebody types here; undo brings the text of this one back."""
        other = self._of_other_page() if self.typing is None else None
        if other is not None:
            self.past = [*self.past, self._text][-UNDONE:]
            self._text = self._written = other
            self._understand()
            self.tell(None)

    def _of_other_page(self) -> str | None:
        """What another page has written into the file since this one read or wrote it."""
        try:
            there = self._path.read_text(encoding="utf-8")[:LARGEST]
        except (OSError, ValueError):
            return None
        return there if there.splitlines() != self._written.splitlines() else None

    def undo(self) -> None:
        """Go back to the text before."""
        self.take()
        if self.past:
            self.future.append(self._text)
            self.set_text(self.past.pop(), keep=False)

    def redo(self) -> None:
        """Bring back what was undone."""
        self.take()
        if self.future:
            self.past.append(self._text)
            self.set_text(self.future.pop(), keep=False)

    def _understand(self) -> None:
        """What is made of every text before anybody is told of it."""
