"""Measured data: the files of the user, and what is done with one of them."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from dataclasses import asdict
from html import escape
from pathlib import Path
from typing import Any

from fastapi import Request, Response
from fastapi.responses import FileResponse, PlainTextResponse
from nicegui import app, events, run, ui

from autobalancer.app.pages.elements import Bench, Work, hinted, marked, picker, say_refused, user_of
from autobalancer.app.store.jobs import Job
from autobalancer.app.store.kept_runs import user_folder
from autobalancer.app.store.measured_files import (
    LARGEST,
    QUANTITIES,
    SUFFIXES,
    Column,
    Measured,
    Measurements,
    Reading,
    samples,
)
from autobalancer.errors import AutobalancerError
from autobalancer.machine import Machine


class MeasuredPage:
    """The list of files; the one that is open has its columns, looks, runs and fits."""

    def __init__(self, bench: Bench) -> None:
        self.bench, self.shelf = bench, Measurements(bench.home)
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


# What the columns of a measured file mean: the first lines of the file beside a row for each column.


FIELD = "dense outlined hide-bottom-space"
MORE = (
    ("rate", "samples a second", "where no column has the time, such as 2 kHz"),
    ("start", "from", "of the piece that is read, such as 0.5 s"),
    ("end", "to", "of the piece that is read"),
    ("resample", "resample to", "brings uneven samples to an even rate, such as 1 kHz"),
)


class Columns:
    """The form of one file; ``read`` is called with what it says."""

    def __init__(self, entry: Measured, preview: list[str], places: list[str], read: Callable[[Reading], None]) -> None:
        self.reading = entry.reading
        ui.html(f"<h2>{escape(entry.file)}</h2>", sanitize=False)
        text = escape("\n".join(preview))
        ui.html(
            f'<pre class="preview" data-at="preview" tabindex="0" aria-label="first lines">{text}</pre>', sanitize=False
        )
        if not self.reading.columns:
            return
        if self.reading.clock:
            ui.label(f"time: {self.reading.clock}").classes("quiet").props('data-at="clock"')
        with ui.element("div").classes("columns").props('role="table" aria-label="columns of the file"'):
            for column in self.reading.columns:
                self._row(column, places)
        with ui.row().classes("items-center gap-2 q-mt-sm"):
            for key, label, help_ in MORE:
                box = marked(ui.input(label, value=getattr(self.reading, key)).props(FIELD), at=f"reading {key}")
                hinted(box.style("width: 170px"), help_).bind_value_to(self.reading, key, lambda text: text or "")
            large = ui.checkbox("large values are right", value=self.reading.implausible).props("dense")
            hinted(large, "takes vibrations so large that their unit is probably wrong")
            large.bind_value_to(self.reading, "implausible")
            ui.button("Read", icon="check", on_click=lambda: read(self.reading)).props(
                'unelevated no-caps data-at="read columns"'
            )

    def _row(self, column: Column, places: list[str]) -> None:
        hinted(ui.label(column.column).classes("key ellipsis"), column.column)
        kind = ui.select(QUANTITIES, value=column.quantity, label="is").props(FIELD).props("options-dense")
        kind.bind_value_to(column, "quantity")
        _named(kind, "quantity", column)
        self._text(column, "unit", "of its numbers, such as um; of voltages V, with a sensitivity")
        self._text(column, "direction", "x, y, z, or degrees from x", ["x", "y", "z"])
        self._text(column, "place", "the station where the sensor is; empty for the rotor", places)
        self._text(column, "uncertainty", "one standard deviation of a value, such as 1 um; fits of samples need it")
        self._text(column, "sensitivity", "of the sensor, such as 8 mV/um, where the numbers are voltages")
        self._text(column, "name", "of the channel")

    def _text(self, column: Column, key: str, help_: str, offered: list[str] | None = None) -> None:
        word = {"uncertainty": "noise"}.get(key, key)
        box = hinted(ui.input(word, value=getattr(column, key), autocomplete=offered).props(FIELD), help_)
        box.bind_value_to(column, key, lambda text: text or "")
        _named(box, word, column)


def _named(element: Any, what: str, column: Column) -> None:
    """Its name for those who do not see it, and for tests."""
    marked(element, at=f"{what} of {column.column}", label=f"{what} of {column.column}")


# Measured files, their waveforms and the fits to them as answers of the server.


def serve_measured(root: Path) -> None:
    """Answer with the measurements of whoever asks."""

    def shelf_of(request: Request) -> Measurements:
        return Measurements(user_folder(root, user_of(request)))

    @app.get("/measured/{name}/wave.bin")
    async def waves(request: Request, name: str) -> Response:
        from autobalancer.app.store.signal_pictures import wave_block

        shelf = shelf_of(request)
        try:
            found = await asyncio.to_thread(lambda: wave_block(shelf.data(name)))
        except AutobalancerError as error:
            return PlainTextResponse(str(error), 404)
        return Response(found, media_type="application/octet-stream")

    @app.get("/measured/{name}/file")
    async def file(request: Request, name: str) -> Response:
        try:
            path = shelf_of(request).path(name)
        except AutobalancerError as error:
            return PlainTextResponse(str(error), 404)
        return FileResponse(path, media_type="application/octet-stream", filename=path.name)

    @app.get("/measured/{name}/fit/{fit}/{kind}")
    async def fitted(request: Request, name: str, fit: str, kind: str) -> Response:
        from autobalancer.app.store.fits import FILES_OF, fit_file

        try:
            path = fit_file(shelf_of(request), name, fit, kind)
        except AutobalancerError as error:
            return PlainTextResponse(str(error), 404)
        return FileResponse(path, media_type=FILES_OF[kind], filename=f"{fit}-{kind}")
