"""What came out of a study, or is known so far: shares with intervals, percentiles, pictures."""

from __future__ import annotations

from html import escape
from typing import Any

from nicegui import ui

from autobalancer.app.pages.bench import Bench
from autobalancer.app.pages.hint import marked
from autobalancer.app.pages.studies.saved import Saved
from autobalancer.app.pages.studies.tables import notes_html, table_html, warnings_html
from autobalancer.app.pages.work import Work
from autobalancer.app.store.drawn import svg_of
from autobalancer.app.store.jobs import Job
from autobalancer.app.store.studies.pictures import DRIVES, FAN, default_quantity, drawn, needs_quantity, offered
from autobalancer.app.store.studies.shelf import Kept, Studies
from autobalancer.app.store.studies.work import Known, columns_of, quantities_of
from autobalancer.results.answers.studied import Studied


class StudyResult:
    """One study; ``read`` may be called in another thread."""

    chosen = 0  # of which design a report is made

    def __init__(self, bench: Bench, shelf: Studies, entry: Kept) -> None:
        self.shelf, self.entry = shelf, entry
        self.known = Known(shelf, entry.name)
        self.found: Studied | None = None
        self.kind = ""
        with ui.row().classes("items-center gap-2 w-full") as self.tools:
            self.quantity = ui.select({}, label="quantity").props("dense outlined options-dense")
            self.quantity.style("width: 240px").props('data-at="quantity"')
            self.buttons = ui.row().classes("gap-2")
            self.points = ui.select({}, label="at").props("dense outlined options-dense")
            self.points.style("width: 240px").props('data-at="point"')
            self.work = Work(bench, "study picture")
            self.saved = Saved(self.work, entry.name)
        self.picture = (
            ui.html("", sanitize=False).classes("w-full measured-picture narrow").props('data-at="study picture"')
        )
        self.table = ui.html("", sanitize=False).classes("w-full").props('data-at="study table"')
        for one in (self.quantity, self.points):
            one.on_value_change(lambda _event: self._again())
        self.tools.set_visibility(False)

    def read(self, _job: Job | None) -> Studied | None:
        """What is finished."""
        return self.known.look()

    def put(self, found: Studied, going: bool) -> None:
        """Show it; once it does not change any more, with a picture."""
        first, self.found = self.found is None, found
        known = quantities_of(found)
        if first:
            self._offer(found, known)
        elif set(known) - set(self.quantity.options):
            self.quantity.set_options(known, value=self.quantity.value)
        self._tell()
        if not going and not self.kind:
            self._draw("")

    def _offer(self, found: Studied, known: dict[str, str]) -> None:
        self.quantity.set_options(known, value=default_quantity(found, known) or None)
        texts = found.point_texts("rpm")
        self.points.set_options({k: text or "all" for k, text in enumerate(texts, start=1)}, value=1)
        self.points.set_visibility(False)
        self.tools.set_visibility(True)
        with self.buttons:
            for kind, word in offered(found).items():
                button = ui.button(word, on_click=lambda kind=kind: self._draw(kind)).props("outline dense no-caps")
                marked(button, at=f"picture {kind}")

    def _tell(self) -> None:
        """The table of the chosen quantity, and what is to be known about it."""
        if self.found is None:
            return
        table = table_html(columns_of(self.found, self.quantity.value or ""), "study numbers")
        notes = notes_html([text for text in self.found.remarks() if not text.startswith("interrupted")])
        self.table.set_content(f"{table}{notes}{warnings_html(self.entry.notes)}")

    def _again(self) -> None:
        """Another quantity or point."""
        self._tell()
        if self.kind and (self.quantity.value or not needs_quantity(self.kind)):
            self._draw(self.kind)

    def _draw(self, kind: str) -> None:
        found, name = self.found, self.entry.name
        if found is None:
            return
        self.kind = kind or next(iter(offered(found)))
        here, quantity = self.kind, str(self.quantity.value or "")
        self.points.set_visibility(len(self.points.options) > 1 and here in (DRIVES, FAN))
        point = int(self.points.value or 1)

        def work(job: Job) -> tuple[str, Any]:
            draw, words = drawn(self.shelf, name, found, here, quantity, point, job)
            return svg_of(draw, words), draw

        self.picture.classes(add="old")  # until the new one is there

        def then(job: Job) -> None:
            if self.picture.is_deleted:
                return
            self.picture.classes(remove="old")
            if here != self.kind or job.state == "cancelled":
                return
            wrong = f'<div class="wrong">{escape(job.message)}</div>'
            content, draw = job.result if job.state == "done" else (wrong, None)
            self.picture.set_content(content)
            self.saved.put(draw)

        self.work.start("picture of a study", work, then)
