"""The picture that is shown, as a file."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nicegui import ui

from autobalancer.app.pages.hint import marked
from autobalancer.app.pages.work import Work
from autobalancer.app.store.drawn import file_of
from autobalancer.app.store.jobs import Job

FORMS = ("png", "svg")


class Saved:
    """Two buttons that save what ``draw`` draws; nothing while there is no picture."""

    def __init__(self, work: Work, name: str) -> None:
        self.work, self.name = work, name
        self.draw: Callable[[], Any] | None = None
        with ui.row().classes("items-center gap-1") as self.line:
            for form in FORMS:
                button = ui.button(form.upper(), icon="download", on_click=lambda form=form: self._save(form))
                marked(button, at=f"save picture {form}", label=f"save the picture as {form.upper()}")
                button.props("flat dense no-caps size=sm")
        self.line.set_visibility(False)

    def put(self, draw: Callable[[], Any] | None) -> None:
        """Another picture, or none."""
        self.draw = draw
        self.line.set_visibility(draw is not None)

    def _save(self, form: str) -> None:
        draw = self.draw
        if draw is None:
            return

        def then(job: Job) -> None:
            if job.state == "done":
                ui.download.content(job.result, f"{self.name}.{form}")

        self.work.start("file of a picture", lambda _job: file_of(draw, form), then)
