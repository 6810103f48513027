"""Measured data: the files of the user, and what is done with one of them."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any

from nicegui import events, run, ui

from autobalancer.app.pages.bench import Bench
from autobalancer.app.pages.hint import hinted, marked
from autobalancer.app.pages.inputs import picker, say_refused
from autobalancer.app.pages.measured.columns import Columns
from autobalancer.app.pages.work import Work
from autobalancer.app.store.jobs import Job
from autobalancer.app.store.measured.columns import Reading
from autobalancer.app.store.measured.shelf import LARGEST, SUFFIXES, Measured, Shelf, samples
from autobalancer.errors import AutobalancerError
from autobalancer.machine import Machine


class MeasuredPage:
    """The list of files; the one that is open has its columns, looks, runs and fits."""

    def __init__(self, bench: Bench) -> None:
        self.bench, self.shelf = bench, Shelf(bench.home)
        self.name = ""
        with ui.element("section").classes("card"):
            self._sources()
            self.list = ui.column().classes("w-full gap-0 q-mt-sm")
        self.columns = ui.element("section").classes("card").props('aria-label="columns"')
        self.rest = ui.column().classes("w-full gap-3")
        self.opened: Any = None
        self._hide()
        self.refresh()

    def _hide(self) -> None:
        self.columns.set_visibility(bool(self.name))
        self.rest.set_visibility(False)

    def _sources(self) -> None:
        async def upload(event: events.UploadEventArguments) -> None:
            content = await event.file.read()
            file = event.file.name
            box.reset()
            self.work.start(f"read {file}", lambda _job: self.shelf.add(file, content), self._added)

        def take(sample: str) -> None:
            self.work.start(f"read {sample}", lambda _job: self.shelf.add_sample(sample), self._added)

        async def offer() -> None:
            select.set_options(list(await run.io_bound(samples) or ()))

        with ui.row().classes("items-center gap-2 w-full"):
            box = ui.upload(on_upload=upload, auto_upload=True, max_file_size=LARGEST, max_files=1)
            box.on("rejected", lambda event: say_refused(event, "a measured file", ", ".join(SUFFIXES), LARGEST))
            box.classes("hidden").props('data-at="measured upload"').props["accept"] = ",".join(SUFFIXES)
            button = ui.button("Open a file", icon="upload_file", on_click=lambda: box.run_method("pickFiles"))
            button.props('unelevated no-caps data-at="open measured"')
            hinted(button, "a table (CSV, TSV), universal file, MATLAB, NumPy, sound, netCDF of this package")
            select = picker([], "sample measurement", take, at="measured sample")
            ui.timer(0.5, offer, once=True)
            self.work = Work(self.bench, "measured")
        self.wrong = ui.label().classes("wrong").props('role="alert" data-at="measured wrong"')

    def _added(self, job: Job) -> None:
        self.wrong.set_text(job.message if job.state == "failed" else "")
        self.refresh()
        if job.state == "done":
            self.open(job.result)

    def refresh(self) -> None:
        """Read the folder again."""
        self.list.clear()
        with self.list:
            entries = self.shelf.entries()
            for entry in entries:
                self._line(entry)
            if not entries:
                said = "No measurements yet. Open a file of a logger, such as CSV, MATLAB or sound, or take a sample."
                ui.label(said).classes("quiet").props('data-at="no measurement"')

    def seen(self) -> None:
        """The person has come to this page: there may be other runs by now."""
        if self.opened is not None:
            self.opened.beside.refresh()

    def _line(self, entry: Measured) -> None:
        with marked(ui.row().classes("items-center gap-2 w-full no-wrap archive-line"), at=entry.name):
            with ui.column().classes("gap-0").style("flex: 1 1 auto; min-width: 0"):
                ui.label(entry.file).classes("key ellipsis")
                ui.label(f"{entry.made} UTC · {entry.kind} · {entry.bytes / 1e3:.0f} kB").classes("quiet ellipsis")
            opens = ui.button("open", on_click=lambda: self.open(entry.name)).props("flat dense no-caps")
            marked(opens, label=f"open {entry.file}")
            link = ui.link("file", f"/measured/{entry.name}/file").props("download")
            marked(link, label=f"download {entry.file}")
            bin_ = ui.button(icon="delete_outline", on_click=lambda: self._delete(entry)).props("flat dense round")
            marked(bin_, label=f"delete {entry.file}")

    def _delete(self, entry: Measured) -> None:
        with ui.dialog(value=True) as dialog, ui.card():
            ui.label(f"Delete {entry.file} of {entry.made} and the fits to it? They cannot be brought back.")

            def gone() -> None:
                dialog.close()
                try:
                    self.shelf.delete(entry.name)
                except AutobalancerError as error:
                    ui.notify(str(error), type="warning")
                if self.name == entry.name:
                    self.name = ""
                    self._hide()
                self.refresh()

            with ui.row():
                ui.button("Delete", on_click=gone).props("no-caps color=negative")
                ui.button("Keep", on_click=dialog.close).props("no-caps flat")

    def open(self, name: str) -> None:
        """Show a file: its first lines and columns, and if these suffice what is in it."""

        def work(_job: Job) -> Any:
            _opened()
            entry, lines = self.shelf.entry(name), self.shelf.preview(name)
            try:
                return entry, lines, self.shelf.data(name), ""
            except AutobalancerError as error:
                return entry, lines, None, str(error)

        self.work.start(f"read {name}", work, lambda job: self._show(name, job))

    def _read(self, reading: Reading) -> None:
        try:
            self.shelf.describe(self.name, reading)
        except AutobalancerError as error:
            ui.notify(str(error), type="warning")
            return
        self.open(self.name)

    def _show(self, name: str, job: Job) -> None:
        if job.state != "done":
            self.wrong.set_text(job.message or job.state)
            return
        entry, lines, data, wrong = job.result
        self.name = name
        self._hide()
        self.columns.clear()
        machine = self.bench.reading.machine
        places = [one.name for one in machine.stations] if isinstance(machine, Machine) else []
        with self.columns:
            Columns(entry, lines, places, self._read)
            for note in job.notes:
                ui.label(note).classes("note")
            ui.label(wrong).classes("wrong").props('role="alert" data-at="columns wrong"').set_visibility(bool(wrong))
        if data is None:
            return
        self.rest.set_visibility(True)
        if self.opened is None:
            with self.rest:
                self.opened = _opened()(self.bench, self.shelf)
        self.opened.show(name, data, f"{abs(hash(json.dumps(asdict(entry.reading)))):x}")


def _opened() -> Any:
    """What computes is imported with the first file, in the thread of its job, so that the page opens at once."""
    from autobalancer.app.pages.measured.opened import Opened

    return Opened
