"""Studies and designs: nothing of them is loaded until somebody comes here, so that the page opens at once."""

from __future__ import annotations

from typing import Any

from nicegui import run, ui

from autobalancer.app.pages.bench import Bench


class StudiesPage:
    """Stands for the page until it is seen."""

    def __init__(self, bench: Bench, dark: Any) -> None:
        self.bench, self.dark = bench, dark
        self.opened: Any = None
        self.begun = False
        self.place = ui.column().classes("w-full gap-3")
        with self.place:
            ui.spinner(size="1.4em")

    async def seen(self, now: bool) -> None:
        """The person has come to this page, or has left it."""
        if self.opened is not None:
            self.opened.seen(now)
        elif now and not self.begun:
            self.begun = True
            made: Any = await run.io_bound(_opened)
            self.place.clear()
            with self.place:
                self.opened = made(self.bench, self.dark)


def _opened() -> Any:
    from autobalancer.app.pages.studies.opened import Opened

    return Opened
