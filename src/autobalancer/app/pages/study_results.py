"""The study or design that is open, also while it runs: what came out, files, reports, and the command that repeats it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from html import escape
from typing import Any

import numpy as np
from nicegui import run, ui

from autobalancer.app.pages.elements import (
    FLAT,
    Bench,
    Lines,
    Work,
    button,
    delete_button,
    marked,
    notes_html,
    refusals,
    table_html,
)
from autobalancer.app.store import studies as kept
from autobalancer.app.store.jobs import Job
from autobalancer.app.store.pictures import file_of, svg_of
from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.files.machine_file import load_race_machine
from autobalancer.machine_kinds import RACES, machine_kind
from autobalancer.reporting.report import report
from autobalancer.results.answers.studied import Studied
from autobalancer.studies.design.designs import Designed, designed_machine
from autobalancer.tables import html_table

REFRESH_SECONDS = 2.0  # s, between two looks at what is finished
FORMS = ("pdf", "html")


STARTS = 40  # of the report on the page


class Results:
    """One at a time."""

    def __init__(self, bench: Bench, shelf: kept.Studies) -> None:
        self.bench, self.shelf = bench, shelf
        self.entry = kept.StudyEntry("", "", "", "", "", "")
        self.body: Any = None
        self.looking = False
        self.filed: kept.StudyEntry | None = None  # whose files are offered
        self.card = ui.element("section").classes("card").props('aria-label="result" data-at="study result"')
        with self.card:
            self.title = ui.html("", sanitize=False)
            self.state = ui.label().classes("quiet").props('role="status" data-at="result state"')
            self.wrong = ui.label().classes("wrong").props('role="alert" data-at="result wrong"')
            self.place = ui.column().classes("w-full gap-2")
            self.more = ui.column().classes("w-full gap-1 q-mt-sm")
            self.work = Work(bench, "study report")
        self.card.set_visibility(False)
        self.timer = ui.timer(REFRESH_SECONDS, self.look, active=False)

    def seen(self, now: bool) -> None:
        """Whether somebody looks."""
        self.timer.active = now and self.body is not None

    def show(self, name: str) -> None:
        """Show another study or design."""
        with refusals():
            self.entry = self.shelf.entry(name)
        if self.entry.name != name:
            return
        self.card.set_visibility(True)
        self.title.set_content(f"<h2>{escape(self.entry.title)}</h2>")
        self.place.clear()
        with self.place:
            kind = DesignResult if self.entry.kind == kept.DESIGN else StudyResult
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
            part = kept.progress_text(self.shelf, self.entry)
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
                for form in FORMS if self._reportable() else ():
                    act, word = partial(self._report, form), f"Report ({form.upper()})"
                    button(word, act, "description", "outline dense no-caps", at=f"study report {form}")
            ui.label("The same on the command line, with these files in one folder:").classes("quiet")
            ui.html(f'<pre class="said" data-at="command">{escape(entry.command)}</pre>', sanitize=False)

    def _reportable(self) -> bool:
        """Whether there is something to report on: of a design a machine with races."""
        if self.entry.kind != kept.DESIGN or not self.entry.finished:
            return self.entry.finished
        with suppress(QuestionError):
            return machine_kind(designed_machine(kept.result_of(self.shelf, self.entry.name))) is RACES
        return False

    def _report(self, form: str) -> None:
        name, place = self.entry.name, self.body.chosen

        def then(job: Job) -> None:
            if job.state == "done":
                ui.download(f"/study/{name}/{job.result}")
            elif job.state == "failed":
                self.wrong.set_text(job.message)

        self.work.start(f"report {name}", lambda job: _write_report(self.shelf, name, place, form, job), then)


def _write_report(shelf: kept.Studies, name: str, place: int, form: str, job: Job) -> str:
    """The report of a design, or of the machine of a study with the study; gives the name of its file.

    Raises
    ------
    QuestionError
        If it is not finished, or what a report needs is not installed.
    """
    found: Any = kept.result_of(shelf, name)
    if shelf.entry(name).kind == kept.DESIGN:
        machine, file = designed_machine(found, place), f"report_{place}.{form}"
    elif isinstance(found, Studied):
        machine, file = load_race_machine(shelf.file(name, "machine.toml")), f"report_0.{form}"
    else:
        raise QuestionError(f"study {name}: has no result of which a report is made")
    report(machine, shelf.folder(name) / file, study=found, starts=STARTS, progress=job.progress)
    return file


def _links(entry: kept.StudyEntry) -> dict[str, Any]:
    known = {entry.file: f"{entry.kind} (TOML)"}
    if entry.machine_file:
        known["machine.toml"] = "machine (TOML)"
    known |= {name: name for name in entry.more}
    if entry.finished:
        word = "candidates" if entry.kind == kept.DESIGN else "members"
        known |= {"result.nc": f"{word} (netCDF)", "table.csv": f"{word} (CSV)"}
    return known


# What came out of a study, or is known so far: shares with intervals, percentiles, pictures.


class StudyResult:
    """One study; ``read`` may be called in another thread."""

    chosen = 0  # of which design a report is made

    def __init__(self, bench: Bench, shelf: kept.Studies, entry: kept.StudyEntry) -> None:
        self.shelf, self.entry = shelf, entry
        self.known = kept.Known(shelf, entry.name)
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
        known = kept.quantities_of(found)
        if first:
            self._offer(found, known)
        elif set(known) - set(self.quantity.options):
            self.quantity.set_options(known, value=self.quantity.value)
        self._tell()
        if not going and not self.kind:
            self._draw("")

    def _offer(self, found: Studied, known: dict[str, str]) -> None:
        self.quantity.set_options(known, value=_default_quantity(found, known) or None)
        texts = found.point_texts("rpm")
        self.points.set_options({k: text or "all" for k, text in enumerate(texts, start=1)}, value=1)
        self.points.set_visibility(False)
        self.tools.set_visibility(True)
        with self.buttons:
            for kind, word in kept.offered(found).items():
                button(word, partial(self._draw, kind), look="outline dense no-caps", at=f"picture {kind}")

    def _tell(self) -> None:
        """The table of the chosen quantity, and what is to be known about it."""
        if self.found is None:
            return
        table = table_html(kept.columns_of(self.found, self.quantity.value or ""), "study numbers")
        notes = notes_html([text for text in self.found.remarks() if not text.startswith("interrupted")], "quiet")
        self.table.set_content(f"{table}{notes}{notes_html(self.entry.notes)}")

    def _again(self) -> None:
        """Another quantity or point."""
        self._tell()
        # whether a picture shows one quantity
        if self.kind and (self.quantity.value or self.kind not in (kept.OVER, kept.DRIVES)):
            self._draw(self.kind)

    def _draw(self, kind: str) -> None:
        found, name = self.found, self.entry.name
        if found is None:
            return
        self.kind = kind or next(iter(kept.offered(found)))
        here, quantity = self.kind, str(self.quantity.value or "")
        self.points.set_visibility(len(self.points.options) > 1 and here in (kept.DRIVES, kept.FAN))
        point = int(self.points.value or 1)

        def work(job: Job) -> tuple[str, Any]:
            draw, words = kept.study_figure(self.shelf, name, found, here, quantity, point, job)
            return svg_of(draw, words), draw

        self.work.draw("picture of a study", work, self.picture, self.saved.put, lambda: here == self.kind)


def _default_quantity(found: Studied, known: dict[str, str]) -> str:
    """What is shown first: what the study shows in its table, else who is balanced, else what is not the same in all members."""
    asked = np.atleast_1d(found.attrs.get("show", [])).astype(str).tolist()
    differs = [name for name in known if np.unique(found[name].values.astype(float)).size > 1]
    return next((name for name in (*asked, "balanced", *differs, *known) if name in known), "")


# What came out of a design, or is known so far: the ranked designs, their Pareto front, what was ruled out and why.


class DesignResult:
    """One design; ``read`` may be called in another thread."""

    def __init__(self, bench: Bench, shelf: kept.Studies, entry: kept.StudyEntry) -> None:
        self.bench, self.shelf, self.entry = bench, shelf, entry
        self.found: Designed | None = None
        self.ran = 0
        with ui.row().classes("items-center gap-2 w-full") as self.tools:
            self.place = ui.select({}, label="design").props('dense outlined options-dense data-at="place"')
            self.place.style("width: 420px; max-width: 100%")
            look, hint = "outline dense no-caps", "undo brings the machine before back"
            button("Take it into Describe", self._take, "input", look, at="take design", hint=hint)
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
        return kept.design_of(self.shelf, self.entry.name, job)

    def put(self, found: Designed, going: bool) -> None:
        """Show it."""
        known = kept.places(found)
        changed, self.found, self.ran = len(known) != self.ran or not going, found, len(known)
        if not changed or not known:
            return
        self.tools.set_visibility(True)
        self.place.set_options(known, value=self.place.value if self.place.value in known else 1)
        self._linked()
        facts = html_table(("", ""), found.facts()).replace("<table>", '<table class="facts">', 1)
        table = table_html(found.columns("rpm"), "designs")
        notes = notes_html([str(text) for text in found.remarks() if not str(text).startswith("ruled out")], "quiet")
        asked = f"{kept.reasons_html(found)}<h3>What was asked</h3>{facts}"
        self.table.set_content(f"{table}{notes}{asked}{notes_html(self.entry.notes)}")
        self._draw(found)

    def _linked(self) -> None:
        self.link.props["href"] = f"/study/{self.entry.name}/design_{self.chosen}.toml"
        self.link.set_visibility(self.entry.finished)

    def _draw(self, found: Designed) -> None:
        def work(_job: Job) -> tuple[str, Any]:
            draw, words = kept.design_figure(found)
            return svg_of(draw, words), draw

        self.work.draw("picture of a design", work, self.picture, self.saved.put)

    def _take(self) -> None:
        if self.found is None:
            return
        with refusals():
            self.bench.set_text(kept.chosen_text(self.found, self.chosen))
            ui.notify("the design is on the page Describe; undo brings the machine before back", type="positive")


# The picture that is shown, as a file.


SAVED_FORMS = ("png", "svg")


class Saved:
    """Two buttons that save what ``draw`` draws; nothing while there is no picture."""

    def __init__(self, work: Work, name: str) -> None:
        self.work, self.name = work, name
        self.draw: Callable[[], Any] | None = None
        with ui.row().classes("items-center gap-1") as self.line:
            for form in SAVED_FORMS:
                act, word, label = partial(self._save, form), form.upper(), f"save the picture as {form.upper()}"
                button(word, act, "download", f"{FLAT} size=sm", at=f"save picture {form}", label=label)
        self.line.set_visibility(False)

    def put(self, draw: Callable[[], Any] | None, _job: Job | None = None) -> None:
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


# The list of studies and designs: how far each is, and what can be done with it.


ROWS_SHOWN = 60  # entries of the list


@dataclass
class Line:
    """What changes of a line while its job waits or runs."""

    job: Job | None
    word: Any
    bar: Any = None


class StudyList:
    """Reads the folder and the queue; ``open`` and ``resume`` are called with a name."""

    def __init__(
        self, bench: Bench, shelf: kept.Studies, open_: Callable[[str], None], resume: Callable[[str], None]
    ) -> None:
        self.bench, self.shelf, self.open, self.resume = bench, shelf, open_, resume
        self.moving: dict[str, Line] = {}
        ui.html("<h2>Kept studies and designs</h2>", sanitize=False)
        self.lines = Lines[kept.StudyEntry](self._line)
        self.lines.list.props('data-at="kept studies"')
        self.none = ui.label("Nothing yet; define a study above and start it.").classes("quiet")
        self.timer = ui.timer(0.5, self.look)

    def seen(self, now: bool) -> None:
        """Whether somebody looks."""
        self.timer.active = now
        if now:
            self.refresh()

    def refresh(self) -> None:
        """Read the folder again."""
        going = self._going()
        wanted = {entry.name: entry for entry in self.shelf.entries()[:ROWS_SHOWN]}
        self.lines.follow(wanted, lambda name: going.get(name) is self.moving[name].job)
        self.moving = {name: line for name, line in self.moving.items() if name in wanted}
        self.none.set_visibility(not wanted)

    def _going(self) -> dict[str, Job]:
        """Those that wait or run."""
        return {job.title: job for job in self.bench.long.of(self.bench.user) if not job.over}

    def look(self) -> None:
        """Say how far those are that wait or run."""
        going = self._going()
        shown = {name: line.job for name, line in self.moving.items() if line.job is not None}
        if set(going) != set(shown) or any(shown[name] is not job for name, job in going.items()):
            self.refresh()  # another page of the user may have started or deleted some
        for name, line in self.moving.items():
            if line.job is not None and name in going:
                line.word.set_text(state_of(line.job))
                line.bar.value = line.job.share

    def _line(self, entry: kept.StudyEntry, _row: Any) -> None:
        name, job = entry.name, self._going().get(entry.name)
        with ui.column().classes("gap-0").style("flex: 1 1 auto; min-width: 0"):
            ui.label(entry.title).classes("key ellipsis")
            word = ui.label(state_of(job) if job is not None else self._rests(entry)).classes("quiet ellipsis")
        line = self.moving[name] = Line(job, word.props('data-at="kept state"'))
        if job is not None:
            line.bar = ui.linear_progress(job.share, show_value=False).style("flex: 0 1 200px; min-width: 60px")
            marked(line.bar.props("rounded"), label=f"progress of {entry.title}")
            button("Cancel", lambda: self.bench.long.cancel(job), "stop", at="cancel study")
        elif not entry.finished:
            label = f"resume {entry.title}"
            button("Resume", lambda: self.resume(name), "play_arrow", at="resume study", label=label)
        button("open", lambda: self.open(name), label=f"open {entry.title}")
        if job is None:
            question = f"Delete {entry.title} of {entry.made} with all its parts? They cannot be brought back."
            delete_button(entry.title, question, lambda: self._delete(name), self.refresh)

    def _rests(self, entry: kept.StudyEntry) -> str:
        """What is known of one that does not run."""
        made = f"{entry.kind} of {entry.machine} · {entry.made} UTC"
        if entry.finished:
            return f"{made} · finished in {kept.time_text(entry.seconds)}"
        part = kept.progress_text(self.shelf, entry)
        return f"{made} · {entry.message or 'interrupted'}{f', {part} are kept' if part else ''}"

    def _delete(self, name: str) -> None:
        if name in self._going():
            raise QuestionError("it runs; cancel it first")
        self.shelf.delete(name)


def state_of(job: Job) -> str:
    """How far a job is."""
    if job.state == "waiting":
        return "waits for its turn"
    return f"{100.0 * job.share:.0f} % · {job.result if job.result is not None else 'begins'}"
