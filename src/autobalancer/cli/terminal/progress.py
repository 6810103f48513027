"""Progress bars on a terminal; in a pipe a line now and then of what takes long."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from autobalancer.cli.terminal.patience import FIRST

Update = Callable[..., None]
LONGEST = 300.0  # s between two lines in a pipe


@contextmanager
def progress_bar(text: str, *columns: Any) -> Iterator[Update]:
    """Yield what is called with (done, total) and fields of the columns, such as ``description`` or ``now``."""
    from autobalancer.cli.terminal.console import Console
    from autobalancer.cli.terminal.printable import plain

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
    """Says now and then how far something has come: after 20 s, then each time after half as long again, 5 minutes at most."""

    def __init__(self, text: str, console: Any) -> None:
        self.text, self.console, self.begin, self.next = text, console, time.monotonic(), FIRST

    def __call__(self, done: float, total: float | None = None, **fields: Any) -> None:
        waited = time.monotonic() - self.begin
        if waited < self.next or not total:
            return
        self.next = waited + min(max(0.5 * waited, FIRST), LONGEST)
        how_far = fields.get("now") or f"{done:g} of {total:g}"
        self.console.print(f"{self.text}: {how_far} after {waited:.0f} s", highlight=False)


def of_time(update: Update) -> Callable[[float, float], None]:
    """Progress that is said as a time of a longer one."""
    return lambda now, end: update(now, end, now=f"{now:.4g} s of {end:.4g} s")
