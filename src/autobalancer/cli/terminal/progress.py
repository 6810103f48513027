"""Progress bars on a terminal; nothing at all in a pipe."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

Update = Callable[..., None]


@contextmanager
def progress_bar(text: str, *columns: Any) -> Iterator[Update]:
    """Yield what is called with (done, total) and fields of the columns, such as ``description`` or ``now``."""
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    from autobalancer.cli.terminal.console import Console
    from autobalancer.cli.terminal.printable import plain

    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda done, total=None, **fields: None
        return
    usual = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[now]}"), TimeRemainingColumn())
    with Progress(*(columns or usual), console=console, transient=True) as bar:
        task = bar.add_task(plain(text), total=None, now="")

        def update(done: float, total: float | None = None, **fields: Any) -> None:
            bar.update(task, completed=done, total=total, **fields)

        yield update


def of_time(update: Update) -> Callable[[float, float], None]:
    """Progress that is said as a time of a longer one."""
    return lambda now, end: update(now, end, now=f"{now:.4g} s of {end:.4g} s")
