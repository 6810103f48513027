"""The study or design that is open, also while it runs: what came out, files, reports, and the command that repeats it."""

from __future__ import annotations

from dataclasses import replace
from html import escape
from typing import Any

from nicegui import run, ui

from autobalancer.app.pages.bench import Bench
from autobalancer.app.pages.hint import marked
from autobalancer.app.pages.studies.design_result import DesignResult
from autobalancer.app.pages.studies.kept import state_of
from autobalancer.app.pages.studies.study_result import StudyResult
from autobalancer.app.pages.work import Work
from autobalancer.app.store.jobs import Job
from autobalancer.app.store.studies.designs import write_report
from autobalancer.app.store.studies.shelf import DESIGN, Kept, Studies
from autobalancer.app.store.studies.work import how_far
from autobalancer.errors import AutobalancerError

EVERY = 2.0  # s, between two looks at what is finished
FORMS = ("pdf", "html")


class Results:
    """One at a time."""

    def __init__(self, bench: Bench, shelf: Studies) -> None:
        self.bench, self.shelf = bench, shelf
        self.entry = Kept("", "", "", "", "", "")
        self.body: Any = None
        self.looking = False
        self.filed: Kept | None = None  # whose files are offered
        self.card = ui.element("section").classes("card").props('aria-label="result" data-at="study result"')
        with self.card:
            self.title = ui.html("", sanitize=False)
            self.state = ui.label().classes("quiet").props('role="status" data-at="result state"')
            self.wrong = ui.label().classes("wrong").props('role="alert" data-at="result wrong"')
            self.place = ui.column().classes("w-full gap-2")
            self.more = ui.column().classes("w-full gap-1 q-mt-sm")
            self.work = Work(bench, "study report")
        self.card.set_visibility(False)
        self.timer = ui.timer(EVERY, self.look, active=False)

    def seen(self, now: bool) -> None:
        """Whether somebody looks."""
        self.timer.active = now and self.body is not None

    def show(self, name: str) -> None:
        """Show another study or design."""
        try:
            self.entry = self.shelf.entry(name)
        except AutobalancerError as error:
            ui.notify(str(error), type="warning")
            return
        self.card.set_visibility(True)
        self.title.set_content(f"<h2>{escape(self.entry.title)}</h2>")
        self.place.clear()
        with self.place:
            kind = DesignResult if self.entry.kind == DESIGN else StudyResult
            self.body = kind(self.bench, self.shelf, self.entry)
        self._files()
        self.timer.activate()
        with self.card:  # the line that was clicked may be gone
            ui.run_javascript(f'document.getElementById("c{self.card.id}")?.scrollIntoView({{block: "start"}})')
            ui.timer(0.05, self.look, once=True)

    def _job(self) -> Job | None:
        return next((job for job in self.bench.long.of(self.bench.user) if job.title == self.entry.name), None)

    async def look(self) -> None:
        """Read what is finished, and show it; what is finished as a whole is read once."""
        body, job = self.body, self._job()
        if body is None or self.looking:
            return
        self.looking = True
        going = job is not None and not job.over
        found, wrong = None, ""
        try:
            found = await run.io_bound(body.read, job)
            entry = self.shelf.entry(body.entry.name)
            wrong = "" if going or entry.finished else entry.message
        except AutobalancerError as error:
            entry, wrong = self.entry, str(error)
        self.looking = False
        if body is not self.body or self.card.is_deleted:
            return
        self.entry = body.entry = entry
        self.state.set_text(self._said(job if going else None, found is not None))
        self.wrong.set_text(wrong if wrong != "cancelled" else "")
        if found is not None:
            body.put(found, going)
        if not going:
            self.timer.deactivate()
            self._files()

    def _said(self, job: Job | None, known: bool) -> str:
        if job is None:
            part = how_far(self.shelf, self.entry)
            stopped = f"stopped{f' after {part}' if part else ''}; what is finished is kept, and Resume goes on"
            return "finished" if self.entry.finished else stopped
        if job.state != "running":
            return state_of(job)
        return f"{'known so far' if known else 'nothing is known yet'}: {state_of(job)}"

    def _files(self) -> None:
        entry = self.entry
        if entry == self.filed:
            return
        self.filed = replace(entry)
        self.more.clear()
        with self.more:
            with ui.row().classes("items-center gap-2"):
                ui.label("Save as").classes("quiet")
                for kind, word in _links(entry).items():
                    marked(ui.link(word, f"/study/{entry.name}/{kind}").props("download"), at=kind)
                for form in FORMS if entry.finished else ():
                    button = ui.button(f"Report ({form.upper()})", icon="description")
                    marked(button.props("outline dense no-caps"), at=f"study report {form}")
                    button.on_click(lambda form=form: self._report(form))
            ui.label("The same on the command line, with these files in one folder:").classes("quiet")
            ui.html(f'<pre class="said" data-at="command">{escape(entry.command)}</pre>', sanitize=False)

    def _report(self, form: str) -> None:
        name, place = self.entry.name, self.body.chosen

        def then(job: Job) -> None:
            if job.state == "done":
                ui.download(f"/study/{name}/{job.result}")
            elif job.state == "failed":
                self.wrong.set_text(job.message)

        self.work.start(f"report {name}", lambda job: write_report(self.shelf, name, place, form, job), then)


def _links(entry: Kept) -> dict[str, Any]:
    known = {entry.file: f"{entry.kind} (TOML)"}
    if entry.machine_file:
        known["machine.toml"] = "machine (TOML)"
    known |= {name: name for name in entry.more}
    if entry.finished:
        word = "candidates" if entry.kind == DESIGN else "members"
        known |= {"result.nc": f"{word} (netCDF)", "table.csv": f"{word} (CSV)"}
    return known
