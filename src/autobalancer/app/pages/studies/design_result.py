"""What came out of a design, or is known so far: the ranked designs, their Pareto front, what was ruled out and why."""

from __future__ import annotations

from html import escape
from typing import Any

from nicegui import ui

from autobalancer.app.pages.bench import Bench
from autobalancer.app.pages.hint import hinted
from autobalancer.app.pages.studies.saved import Saved
from autobalancer.app.pages.studies.tables import notes_html, table_html, warnings_html
from autobalancer.app.pages.work import Work
from autobalancer.app.store.drawn import svg_of
from autobalancer.app.store.jobs import Job
from autobalancer.app.store.studies.designs import chosen_text, design_drawn, design_of, places, reasons_html
from autobalancer.app.store.studies.shelf import Kept, Studies
from autobalancer.errors import AutobalancerError
from autobalancer.shown import html_table
from autobalancer.studies.design.answer import Designed


class DesignResult:
    """One design; ``read`` may be called in another thread."""

    def __init__(self, bench: Bench, shelf: Studies, entry: Kept) -> None:
        self.bench, self.shelf, self.entry = bench, shelf, entry
        self.found: Designed | None = None
        self.ran = 0
        with ui.row().classes("items-center gap-2 w-full") as self.tools:
            self.place = ui.select({}, label="design").props('dense outlined options-dense data-at="place"')
            self.place.style("width: 420px; max-width: 100%")
            take = ui.button("Take it into Describe", icon="input", on_click=self._take)
            hinted(take.props('outline dense no-caps data-at="take design"'), "undo brings the machine before back")
            self.link = ui.link("its machine (TOML)", "").props('download data-at="design machine file"')
            self.work = Work(bench, "design picture")
            self.saved = Saved(self.work, entry.name)
        self.place.on_value_change(lambda _event: self._linked())
        self.picture = ui.html("", sanitize=False).classes("w-full measured-picture").props('data-at="front"')
        self.table = ui.html("", sanitize=False).classes("w-full")
        self.tools.set_visibility(False)

    @property
    def chosen(self) -> int:
        """The place of the design that is chosen."""
        return int(self.place.value or 1)

    def read(self, job: Job | None) -> Designed | None:
        """The answer, or what is known of it."""
        return design_of(self.shelf, self.entry.name, job)

    def put(self, found: Designed, going: bool) -> None:
        """Show it."""
        known = places(found)
        changed, self.found, self.ran = len(known) != self.ran or not going, found, len(known)
        if not changed or not known:
            return
        self.tools.set_visibility(True)
        self.place.set_options(known, value=self.place.value if self.place.value in known else 1)
        self._linked()
        facts = html_table(("", ""), found.facts()).replace("<table>", '<table class="facts">', 1)
        table = table_html(found.columns("rpm"), "designs")
        notes = notes_html([str(text) for text in found.remarks() if not str(text).startswith("ruled out")])
        out = reasons_html(found)
        self.table.set_content(f"{table}{notes}{out}<h3>What was asked</h3>{facts}{warnings_html(self.entry.notes)}")
        self._draw(found)

    def _linked(self) -> None:
        self.link.props["href"] = f"/study/{self.entry.name}/design_{self.chosen}.toml"
        self.link.set_visibility(self.entry.finished)

    def _draw(self, found: Designed) -> None:
        def work(_job: Job) -> tuple[str, Any]:
            draw, words = design_drawn(found)
            return svg_of(draw, words), draw

        def then(job: Job) -> None:
            if job.state == "cancelled" or self.picture.is_deleted:
                return
            wrong = f'<div class="wrong">{escape(job.message)}</div>'
            content, draw = job.result if job.state == "done" else (wrong, None)
            self.picture.set_content(content)
            self.saved.put(draw)

        self.work.start("picture of a design", work, then)

    def _take(self) -> None:
        if self.found is None:
            return
        try:
            self.bench.set_text(chosen_text(self.found, self.chosen))
        except AutobalancerError as error:
            ui.notify(str(error), type="warning")
            return
        ui.notify("the design is on the page Describe; undo brings the machine before back", type="positive")
