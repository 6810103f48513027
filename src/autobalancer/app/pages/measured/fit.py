"""Fit numbers of the machine to a measurement: what is free, the search, and what came out."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from typing import Any

import xarray as xr
from nicegui import ui

from autobalancer.app.pages.bench import Bench
from autobalancer.app.pages.hint import hinted, marked
from autobalancer.app.pages.inputs import picker
from autobalancer.app.pages.work import Work
from autobalancer.app.store.drawn import svg_of
from autobalancer.app.store.jobs import Job
from autobalancer.app.store.measured.fits import (
    WAYS,
    FitEntry,
    Free,
    Question,
    Trials,
    delete_fit,
    fit,
    fit_file,
    fit_picture,
    fits,
)
from autobalancer.app.store.measured.looks import Asked
from autobalancer.app.store.measured.shelf import Shelf
from autobalancer.app.text.fields import in_unit
from autobalancer.app.text.numbers import USUAL, numbers_of, with_numbers
from autobalancer.errors import AutobalancerError
from autobalancer.files.machine_file import parse_machine
from autobalancer.machine import Machine
from autobalancer.machine.path import label_of_path
from autobalancer.results.signals.signals import Signals

FIELD = "dense outlined hide-bottom-space"
TITLE = "fit to "


class Fit:
    """The form of a fit, its progress, and the fits to one measurement."""

    def __init__(self, bench: Bench, shelf: Shelf, asked: Callable[[], Asked]) -> None:
        self.bench, self.shelf, self.asked = bench, shelf, asked
        self.name = ""
        self.question = Question([])
        with ui.row().classes("items-center gap-2 w-full"):
            ui.html("<h2 class='head'>Fit the machine</h2>", sanitize=False)
            self.machine = ui.label().classes("quiet")
        self.form = ui.column().classes("w-full gap-2")
        self.list = ui.column().classes("w-full gap-2 q-mt-sm").props('data-at="fits"')
        self.picture = ui.html("", sanitize=False).classes("w-full measured-picture").props('data-at="fit picture"')
        bench.on_change(lambda _origin: self._say_machine())
        self._say_machine()

    def _say_machine(self) -> None:
        machine = self.bench.reading.machine
        self.machine.set_text(f"of the page Describe: {machine.name}" if machine is not None else "no possible machine")
        if self.name:
            self._offer()

    def show(self, name: str, data: xr.Dataset) -> None:
        """For another measurement."""
        self.name, self.question = name, Question([])
        signals = isinstance(data, Signals)
        ways = {key: text for key, text in WAYS.items() if signals or (key != "samples" and "amplitude" in data)}
        ways = ways or {"samples": WAYS["samples"]}
        self.question.way = next(iter(ways))
        self.form.clear()
        with self.form:
            self._put(ways)
        self.picture.set_content("")
        title = f"{TITLE}{name}"
        going = next((one for one in self.bench.jobs.of(self.bench.user) if not one.over and one.title == title), None)
        if going is not None:
            self.work.watch(going, self._over)
        self.refresh()

    def _put(self, ways: dict[str, str]) -> None:
        with ui.row().classes("items-center gap-2"):
            self.add = picker({}, "free: add a number of the machine", self._free, at="fit add", width=420)
        self._offer()
        self.rows = ui.column().classes("w-full gap-1")
        with ui.row().classes("items-center gap-2"):
            way = ui.select(ways, value=self.question.way, label="what is fitted").props("dense outlined options-dense")
            way.style("width: 420px").props('data-at="fit way"').bind_value_to(self.question, "way")
            self._text("error", "noise, where not known", "one standard deviation: 2 % of orders, or such as 1 um")
            self._text("lowest", "lowest speed", "of orders that are used, such as 300 rpm")
            self._text("highest", "highest speed", "of orders that are used")
            starts = ui.number("searches", value=1, min=1, max=20, precision=0).props(FIELD).style("width: 100px")
            hinted(starts, "from so many places within the bounds")
            starts.bind_value_to(self.question, "starts", lambda value: int(value or 1))
            balls = ui.checkbox("with the mass of the balls").props("dense").bind_value_to(self.question, "balls")
            hinted(balls, "in the steady response; runs have their balls anyway")
        with ui.row().classes("items-center gap-2"):
            ui.button("Fit", icon="play_arrow", on_click=self.start).props('unelevated no-caps data-at="fit"')
            self.work = Work(self.bench, "fit", _told)
        ui.label("Slow roll, tacho and piece are taken as they stand under Look.").classes("quiet")

    def _text(self, key: str, label: str, help_: str) -> None:
        box = marked(hinted(ui.input(label).props(FIELD).style("width: 176px"), help_), at=f"fit {key}")
        box.bind_value_to(self.question, key, lambda text: text or "")

    def _offer(self) -> None:
        machine = self.bench.reading.machine
        known = numbers_of(self.bench.text, machine) if isinstance(machine, Machine) else []
        self.add.set_options({one.path: f"{one.label}: {one.given}" for one in known}, value=None)

    def _free(self, path: str) -> None:
        machine = self.bench.reading.machine
        if not isinstance(machine, Machine):
            return
        if any(one.path == path for one in self.question.free):
            return
        number = next(one for one in numbers_of(self.bench.text, machine) if one.path == path)
        self.question.free.append(Free(path, *number.around()))
        self._rows()

    def _rows(self) -> None:
        self.rows.clear()
        with self.rows:
            for one in self.question.free:
                with marked(ui.row().classes("items-center gap-2 no-wrap"), at=f"free {one.path}"):
                    hinted(ui.label(label_of_path(one.path)).classes("key").style("min-width: 200px"), one.path)
                    for key, label in (("lower", "from"), ("upper", "to")):
                        box = ui.input(label, value=getattr(one, key)).props(FIELD).style("width: 150px")
                        box.bind_value_to(one, key, lambda text: text or "")
                    bin_ = ui.button(icon="close", on_click=lambda one=one: self._fix(one)).props(
                        "flat dense round size=sm"
                    )
                    marked(bin_, label=f"hold {label_of_path(one.path)}")

    def _fix(self, one: Free) -> None:
        self.question.free.remove(one)
        self._rows()

    def start(self) -> None:
        """Put the fit into the queue; it goes on when the page is closed."""
        if self.bench.reading.machine is None:
            ui.notify("the machine is not possible yet; see its form", type="warning")
            return
        name, text, asked = self.name, self.bench.text, Asked(**vars(self.asked()))
        question = Question(**{**vars(self.question), "free": [Free(**vars(one)) for one in self.question.free]})
        self.work.start(f"{TITLE}{name}", lambda job: fit(self.shelf, name, text, question, asked, job), self._over)

    def _over(self, job: Job) -> None:
        if job.state == "failed":
            self.picture.set_content(f'<div class="wrong" data-at="fit wrong">{escape(job.message)}</div>')
            return
        self.picture.set_content("")
        self.refresh()
        if isinstance(job.result, str) and job.state == "done":
            self._draw(job.result)

    def refresh(self) -> None:
        """Read the fits of the measurement again."""
        self.list.clear()
        try:
            found = fits(self.shelf, self.name)
        except AutobalancerError:
            return
        with self.list:
            for entry in found:
                self._entry(entry)

    def _entry(self, entry: FitEntry) -> None:
        with marked(ui.column().classes("w-full gap-0 fit"), at=entry.name):
            ui.html(_table(entry, self._units()), sanitize=False).classes("w-full")
            with ui.row().classes("items-center gap-2"):
                load = ui.button("load into Describe", icon="input", on_click=lambda: self._load(entry))
                hinted(load.props('flat dense no-caps data-at="load fit"'), "undo brings the machine back")
                if entry.finished:
                    ui.button("picture", icon="show_chart", on_click=lambda: self._draw(entry.name)).props(
                        "flat dense no-caps"
                    )
                for kind, word in (("fitted.toml", "machine (TOML)"), ("fit.nc", "numbers (netCDF)")):
                    if entry.finished or kind == "fitted.toml":
                        link = ui.link(word, f"/measured/{self.name}/fit/{entry.name}/{kind}")
                        marked(link.props("download"), at=kind)
                bin_ = ui.button(icon="delete_outline", on_click=lambda: self._delete(entry)).props("flat dense round")
                bin_.props('aria-label="delete this fit"')

    def _units(self) -> dict[str, str]:
        """In which the machine of the page has its numbers."""
        machine = self.bench.reading.machine
        known = numbers_of(self.bench.text, machine) if isinstance(machine, Machine) else []
        return {one.path: one.unit for one in known}

    def _load(self, entry: FitEntry) -> None:
        try:
            text = fit_file(self.shelf, self.name, entry.name, "fitted.toml").read_text(encoding="utf-8")
            fitted: Any = parse_machine(text, "machine")
        except AutobalancerError as error:
            ui.notify(str(error), type="warning")
            return
        self.bench.set_text(with_numbers(self.bench.text, fitted, [row["path"] for row in entry.rows]))
        ui.notify("the fitted machine is on the page Describe; undo brings the one before back", type="positive")

    def _delete(self, entry: FitEntry) -> None:
        delete_fit(self.shelf, self.name, entry.name)
        self.refresh()

    def _draw(self, fit_name: str) -> None:
        name = self.name

        def then(job: Job) -> None:
            if name == self.name:
                wrong = f'<div class="wrong">{escape(job.message)}</div>'
                self.picture.set_content(job.result if job.state == "done" else wrong)

        about = "measured, before and after the fit"
        self.work.start("picture of a fit", lambda _job: svg_of(fit_picture(self.shelf, name, fit_name), about), then)


def _told(job: Job) -> str:
    """How far a fit is: a search does not know how many trials it needs."""
    known = job.result
    if not isinstance(known, Trials):
        return "working"
    if known.count == 0:
        return "the first trial is under way"
    return f"trial {known.count}; deviations of the best are {known.best:.3g} times their noise"


def _table(entry: FitEntry, units: dict[str, str]) -> str:
    rows = "".join(_row(row, units.get(row["path"], USUAL.get(row["unit"], row["unit"]))) for row in entry.rows)
    notes = "".join(f'<div class="note">{escape(note)}</div>' for note in entry.notes)
    heads = "".join(f'<th class="number">{word}</th>' for word in ("fitted", "interval of 95 %", "before"))
    head = f"<tr><th></th>{heads}</tr>"
    title = f"{entry.machine}, {entry.made} UTC; {WAYS[entry.way]}; deviations {entry.scatter:.3g} times their noise"
    return (
        f'<div class="quiet">{escape(title)}</div><table class="facts" data-at="fit result">{head}{rows}</table>{notes}'
    )


def _row(row: dict[str, Any], usual: str) -> str:
    unit = row["unit"]

    def shown(value: float, digits: int = 6) -> str:
        return f"{float(in_unit(f'{value:.12g}', unit, usual, unit)):.{digits}g}"

    ends = row["said"] if row["low"] is None else f"{shown(row['low'])} to {shown(row['high'])}"
    cells = [f"{shown(row['value'])} {usual}", ends, f"{shown(row['start'])} {usual}"]
    body = "".join(f'<td class="number">{escape(cell)}</td>' for cell in cells)
    return f"<tr><td>{escape(label_of_path(row['path']))}</td>{body}</tr>"
