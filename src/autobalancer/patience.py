"""Progress of long functions in Python: a bar on a terminal, a line in a notebook, nothing in a pipe or a script's log."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")
Progress = Callable[[float, float], None]
SOON = 1.0  # s; what takes less shows nothing


def silent(_done: float, _total: float) -> None:
    """Progress of a part that somebody else shows as a whole."""


def shows_progress(function: Callable[P, R]) -> Callable[P, R]:
    """Give a function with the argument ``progress`` a bar of its own.

    ``None`` shows it where a person is looking, after a second; ``False`` never; a callable takes its place.
    """

    @wraps(function)
    def shown(*args: P.args, **kwargs: P.kwargs) -> R:
        given = kwargs.get("progress")
        if callable(given):
            return function(*args, **kwargs)
        bar = None if given is False else _bar(function.__name__.removesuffix("_races").removesuffix("_chamber"))
        kwargs["progress"] = bar
        try:
            return function(*args, **kwargs)
        finally:
            if bar is not None:
                bar.close()

    return shown


def _bar(text: str) -> Any:
    if in_notebook():
        return Line(text)
    return RichBar(text) if sys.stderr.isatty() else None


def in_notebook() -> bool:
    """Whether a notebook kernel runs this; asked without importing anything."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return any(kind.__name__ == "ZMQInteractiveShell" for kind in type(shell).__mro__)  # Colab has one of its own


class Line:
    """A line that is written over, as notebooks can."""

    def __init__(self, text: str) -> None:
        self.text, self.begun, self.last = text, time.monotonic(), 0.0

    def __call__(self, done: float, total: float) -> None:
        now = time.monotonic()
        if now - self.begun > SOON and now - self.last > 0.2 and total > 0.0:
            self.last = now
            print(f"\r{self.text}: {100.0 * done / total:3.0f} %", end="", file=sys.stderr, flush=True)

    def close(self) -> None:
        """Leave the line."""
        if self.last:
            print(f"\r{self.text}: {time.monotonic() - self.begun:.3g} s", file=sys.stderr, flush=True)


class RichBar:
    """A bar on a terminal that vanishes at the end."""

    def __init__(self, text: str) -> None:
        self.text, self.begun = text, time.monotonic()
        self.bar: Any = None
        self.task: Any = None

    def __call__(self, done: float, total: float) -> None:
        if self.bar is None and time.monotonic() - self.begun > SOON:
            from rich.console import Console
            from rich.progress import Progress

            self.bar = Progress(console=Console(stderr=True), transient=True)
            self.bar.start()
            self.task = self.bar.add_task(self.text)
        if self.bar is not None:
            self.bar.update(self.task, completed=done, total=total)

    def close(self) -> None:
        """Take it away."""
        if self.bar is not None:
            self.bar.stop()
