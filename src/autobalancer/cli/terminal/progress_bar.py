"""Progress bars on a terminal; in a pipe a line now and then of what takes long."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import rich.console
from rich.text import Text

from autobalancer.tables import printable

Update = Callable[..., None]
SOON, LONGEST = 5.0, 300.0  # s until the first line in a pipe, and between two at most


@contextmanager
def progress_bar(text: str, *columns: Any) -> Iterator[Update]:
    """Yield what is called with (done, total) and fields of the columns, such as ``description`` or ``now``."""

    console = Console(stderr=True)
    if not console.is_terminal:
        yield _Words(text, console) if not columns else lambda done, total=None, **fields: None
        return
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    usual = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[now]}"), TimeRemainingColumn())
    with Progress(*(columns or usual), console=console, transient=True) as bar:
        task = bar.add_task(plain(text), total=None, now="")

        def update(done: float, total: float | None = None, **fields: Any) -> None:
            bar.update(task, completed=done, total=total, **fields)

        yield update


class _Words:
    """Says now and then how far something has come: after 5 s, then each time after half as long again, 5 minutes at most."""

    def __init__(self, text: str, console: Any) -> None:
        self.text, self.console, self.begin, self.next = text, console, time.monotonic(), SOON

    def __call__(self, done: float, total: float | None = None, **fields: Any) -> None:
        waited = time.monotonic() - self.begin
        if waited < self.next or not total:
            return
        self.next = waited + min(max(0.5 * waited, SOON), LONGEST)
        how_far = fields.get("now") or (f"{done:g} of {total:g}" if total > 1.0 else f"{done / total:.0%}")
        self.console.print(f"{self.text}: {how_far} after {waited:.0f} s", highlight=False)


# A word when a run takes long, also where no progress bar is seen.


FIRST = 20.0  # s of waiting after which it is said, and after three times as long again
LONG = 120.0  # s still to wait that are worth a word


class Patience:
    """Says once in a while how long a run will still take.

    Parameters
    ----------
    console
        Where it is said.
    """

    def __init__(self, console: Any) -> None:
        self.console, self.begin, self.next = console, time.monotonic(), FIRST

    def look(self, now: float, end: float) -> None:
        """The run has come to ``now`` of ``end``, s."""
        waited = time.monotonic() - self.begin
        if waited < self.next or now >= end:
            return
        self.next = 3.0 * waited
        still = waited * (end - now) / now if now > 0.0 else float("inf")
        if still > LONG:
            minutes = f"another {still / 60.0:.2g} minutes" if still < 1e5 else "days or more"
            self.console.print(
                f"note: {now:.3g} s of {end:.3g} s after {waited:.0f} s of computing; at this pace it takes {minutes}. Ctrl-C "
                "ends the run and keeps what was computed",
                style="yellow",
            )


# Texts of others on the terminal, where square brackets are markup.


def plain(text: object) -> str:
    """The text for ``rich``, which takes square brackets for markup."""
    from rich.markup import escape

    return escape(printable(text))


# The terminal, on which names are data: no markup, no emoji codes, no orders to the terminal.


class Console(rich.console.Console):
    """As that of rich, but square brackets and colons in a text are shown as they are."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(markup=False, emoji=False, **settings)

    def render_str(self, text: str, **settings: Any) -> Text:
        """A text of a table or a line."""
        return super().render_str(printable(text), **settings)

    def note(self, text: object) -> None:
        """A remark that stands out."""
        self.print(Text.assemble(("note:", "yellow"), f" {printable(text)}"))
