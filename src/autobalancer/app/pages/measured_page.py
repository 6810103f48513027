"""Measured data: the files of the user, and what is done with one of them."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from nicegui import events, run, ui
from nicegui.element import Element

from autobalancer.app.form_fields import USUAL, in_unit, numbers_of, with_numbers
from autobalancer.app.pages.elements import (
    Bench,
    Work,
    button,
    delete_button,
    hinted,
    marked,
    notes_html,
    picker,
    refusals,
    uploader,
)
from autobalancer.app.problems import with_value
from autobalancer.app.store.fits import METHODS, FitEntry, Free, Question, Trials, fit, fit_file, fits
from autobalancer.app.store.jobs import Job
from autobalancer.app.store.kept_runs import Archive
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
from autobalancer.app.store.pictures import svg_of
from autobalancer.app.store.signal_pictures import (
    LOOKS,
    PictureOptions,
    drive_of,
    order_table,
    picture,
    turning,
    vibrations,
)
from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.files.machine_file import parse_machine
from autobalancer.machine import Machine
from autobalancer.machine.path import label_of_path
from autobalancer.measurement.overlay import overlay
from autobalancer.measurement.pairs import is_orders
from autobalancer.plots.fits import identification
from autobalancer.results.answers.answer import Answer
from autobalancer.results.signals import Signals
from autobalancer.results.store import load_run
from autobalancer.simulation.record import Samples
from autobalancer.simulation.run import simulate_races

# What is done with one measurement: looks, runs beside it, fits.


class Opened:
    """Three cards, made when the first measurement is opened."""

    def __init__(self, bench: Bench, shelf: Measurements) -> None:
        with _card("look"):
            self.looks = Looks(bench, shelf)
        with _card("beside a run"):
            self.beside = Beside(bench, lambda: self.looks.asked)
        with _card("fit"):
            self.fit = Fit(bench, shelf, lambda: self.looks.asked)

    def show(self, name: str, data: xr.Dataset, version: str) -> None:
        """Show another measurement."""
        self.looks.show(name, data, version)
        self.beside.show(data)
        self.fit.show(name, data)


def _card(label: str) -> Any:
    return marked(ui.element("section").classes("card"), label=label)


# A measurement beside a run of the archive.


RUNS = 60  # of the list


A_TURN = 32  # samples of a run in a turn of the rotor, of which a signal is interpolated
MOST = 400_000  # samples of a run that is made again


class Beside:
    """One run at a time."""

    def __init__(self, bench: Bench, asked: Callable[[], PictureOptions]) -> None:
        self.bench, self.archive, self.asked = bench, Archive(bench.home), asked
        self.data: xr.Dataset | None = None
        ui.html("<h2>Beside a run</h2>", sanitize=False)
        with ui.row().classes("items-center gap-2 w-full"):
            self.run = ui.select({}, label="run of the archive").props("dense outlined options-dense")
            self.run.style("width: 380px").props('data-at="beside run"')
            button("Put beside", self.ask, look="outline no-caps", at="beside")
            word, hint = "Take its speed as the drive", "drive.profile and start.rotor_angle of the page Describe"
            self.drive = button(word, self.take, look="flat no-caps", at="take drive", hint=hint)
            self.work = Work(bench, "beside")
        self.out = ui.html("", sanitize=False).classes("w-full measured-picture").props('data-at="beside picture"')
        self.words = ui.html("", sanitize=False).classes("w-full").props('data-at="beside words"')

    def refresh(self) -> None:
        """Read the archive again."""
        runs = {one.name: f"{one.machine}, {one.made} UTC" for one in self.archive.entries()[:RUNS]}
        self.run.set_options(runs, value=self.run.value if self.run.value in runs else next(iter(runs), None))

    def show(self, data: xr.Dataset) -> None:
        """For another measurement."""
        self.data = data
        self.refresh()
        self.out.set_content("")
        self.words.set_content("")
        self.drive.set_visibility(isinstance(data, Signals) and turning(data))

    def ask(self) -> None:
        """Put the measurement beside the chosen run."""
        data, run, asked = self.data, self.run.value, PictureOptions(**vars(self.asked()))
        if data is None:
            return
        if not run:
            ui.notify("there is no run yet; start one on the page Run", type="warning")
            return

        def work(job: Job) -> tuple[str, str]:
            found, note = _beside(self.archive, run, data, asked, job)
            words = f'<pre class="said">{escape(found.told())}</pre>{notes_html([note] if note else [])}'
            return svg_of(picture(found), f"measured beside the run of {found.attrs.get('machine_name', '')}"), words

        def then(words: str | None, _job: Job) -> None:
            self.words.set_content(words or "")

        self.work.draw("put beside", work, self.out, then, lambda: data is self.data)

    def take(self) -> None:
        """Give the machine of the page the measured speed."""
        data, asked = self.data, PictureOptions(**vars(self.asked()))

        def then(job: Job) -> None:
            if job.state != "done":
                ui.notify(job.message or job.state, type="warning")
                return
            profile, angle = job.result
            with refusals():
                text: Any = with_value(self.bench.whole_text, ("drive",), {"kind": "speed", "profile": profile})
                self.bench.set_text(with_value(text, ("start", "rotor_angle"), angle))
                ui.notify("the machine turns as was measured; undo brings its own drive back", type="positive")

        self.work.start("speed of a measurement", lambda _job: drive_of(data, asked), then)  # type: ignore[arg-type]


def _beside(archive: Archive, run: str, measured: xr.Dataset, asked: PictureOptions, job: Job) -> tuple[Answer, str]:
    """A measurement beside a run, and what was done for it.

    A run of the archive has about two thousand samples. Where these are too few, the same machine is run again, with more.

    Raises
    ------
    QuestionError
        If their times do not meet, a place is not in the run, or the run is one of a deep chamber.
    """
    known = archive.run(run)
    options: dict[str, Any] = {}
    if isinstance(measured, Signals) and turning(measured):
        options = {"pulses": int(float(asked.pulses or "1")), "tacho_angle": asked.tacho_angle.strip() or None}
    try:
        return overlay(known, measured, **options), ""
    except QuestionError:
        if "rotor_angle" not in known or known.sizes["time"] >= _needed(known):
            raise
    machine = parse_machine(archive.text(run), "machine")
    if not isinstance(machine, Machine):
        raise QuestionError("a run of a deep chamber cannot be put beside a measurement")
    again = simulate_races(
        machine,
        duration=float(known.attrs["end_time"]),
        seed=int(known.attrs.get("seed", 0)),
        save=Samples(_needed(known)),
        progress=job.progress,
    )
    note = f"the run was made again with {_needed(known)} samples in place of {known.sizes['time']}"
    return overlay(again, measured, **options), note


def _needed(run: xr.Dataset) -> int:
    """Samples with which a run can be seen between its samples, also where it is fastest."""
    turns = float(np.ptp(run["time"].values) * np.abs(run["speed"].values).max()) / (2.0 * np.pi)
    return int(min(MOST, np.ceil(A_TURN * turns) + 20))


# Fit numbers of the machine to a measurement: what is free, the search, and what came out.


FIELD = "dense outlined hide-bottom-space"
TITLE = "fit to "


class Fit:
    """The form of a fit, its progress, and the fits to one measurement."""

    def __init__(self, bench: Bench, shelf: Measurements, asked: Callable[[], PictureOptions]) -> None:
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
        ways = {key: text for key, text in METHODS.items() if signals or (key != "samples" and "amplitude" in data)}
        ways = ways or {"samples": METHODS["samples"]}
        self.question.way = next(iter(ways))
        self.form.clear()
        with self.form:
            self._put(ways)
        self.picture.set_content("")
        self.work.follow(f"{TITLE}{name}", self._over)
        self.refresh()

    def _put(self, ways: dict[str, str]) -> None:
        with ui.row().classes("items-center gap-2"):
            self.add = picker({}, "free: add a number of the machine", self._free, at="fit add").style("width: 420px")
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
            button("Fit", self.start, "play_arrow", "unelevated no-caps", at="fit")
            self.work = Work(self.bench, "fit", _progress_text)
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
                    look, label = "flat dense round size=sm", f"hold {label_of_path(one.path)}"
                    button("", partial(self._fix, one), "close", look, label=label)

    def _fix(self, one: Free) -> None:
        self.question.free.remove(one)
        self._rows()

    def start(self) -> None:
        """Put the fit into the queue; it goes on when the page is closed."""
        if self.bench.reading.machine is None:
            ui.notify("the machine is not possible yet; see its form", type="warning")
            return
        name, text, asked = self.name, self.bench.whole_text, PictureOptions(**vars(self.asked()))
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
            found = fits(self.shelf, self.name).entries()
        except AutobalancerError:
            return
        with self.list:
            for entry in found:
                self._entry(entry)

    def _entry(self, entry: FitEntry) -> None:
        with marked(ui.column().classes("w-full gap-0 fit"), at=entry.name):
            ui.html(_table(entry, self._units()), sanitize=False).classes("w-full")
            with ui.row().classes("items-center gap-2"):
                hint = "undo brings the machine back"
                button("load into Describe", lambda: self._load(entry), "input", at="load fit", hint=hint)
                if entry.finished:
                    button("picture", lambda: self._draw(entry.name), "show_chart")
                for kind, word in (("fitted.toml", "machine (TOML)"), ("fit.nc", "numbers (netCDF)")):
                    if entry.finished or kind == "fitted.toml":
                        link = ui.link(word, f"/measured/{self.name}/fit/{entry.name}/{kind}")
                        marked(link.props("download"), at=kind)
                button("", lambda: self._delete(entry), "delete_outline", "flat dense round", label="delete this fit")

    def _units(self) -> dict[str, str]:
        """In which the machine of the page has its numbers."""
        machine = self.bench.reading.machine
        known = numbers_of(self.bench.text, machine) if isinstance(machine, Machine) else []
        return {one.path: one.unit for one in known}

    def _load(self, entry: FitEntry) -> None:
        with refusals():
            text = fit_file(self.shelf, self.name, entry.name, "fitted.toml").read_text(encoding="utf-8")
            fitted: Any = parse_machine(text, "machine")
            self.bench.set_text(with_numbers(self.bench.text, fitted, [row["path"] for row in entry.rows]))
            ui.notify("the fitted machine is on the page Describe; undo brings the one before back", type="positive")

    def _delete(self, entry: FitEntry) -> None:
        fits(self.shelf, self.name).delete(entry.name)
        self.refresh()

    def _draw(self, fit_name: str) -> None:
        name, about = self.name, "measured, before and after the fit"

        def work(_job: Job) -> tuple[str, None]:
            return svg_of(_fit_picture(self.shelf, name, fit_name), about), None

        self.work.draw("picture of a fit", work, self.picture, wanted=lambda: name == self.name)


def _fit_picture(shelf: Measurements, name: str, fit_name: str) -> Callable[[], Any]:
    """Measured and fitted, before and after."""
    data = load_run(fit_file(shelf, name, fit_name, "fit.nc"))
    return lambda: identification(data)


def _progress_text(job: Job) -> str:
    """How far a fit is: a search does not know how many trials it needs."""
    known = job.result
    if not isinstance(known, Trials):
        return "working"
    if known.count == 0:
        return "the first trial is under way"
    return f"trial {known.count}; deviations of the best are {known.best:.3g} times their noise"


def _table(entry: FitEntry, units: dict[str, str]) -> str:
    rows = "".join(_row(row, units.get(row["path"], USUAL.get(row["unit"], row["unit"]))) for row in entry.rows)
    notes = notes_html(entry.notes)
    heads = "".join(f'<th class="number">{word}</th>' for word in ("fitted", "interval of 95 %", "before"))
    head = f"<tr><th></th>{heads}</tr>"
    title = f"{entry.machine}, {entry.made} UTC; {METHODS[entry.way]}; deviations {entry.scatter:.3g} times their noise"
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


# Looks at a measurement: waveforms, orders over the speed, maps, spectra, an orbit, a decay.


WORDS = {
    "orders": ("orders", "of the rotor speed, such as 1, 2"),
    "slow_roll": (
        "slow roll",
        "time in which the rotor turns slowly, such as 0:4 s; the run-out seen there is subtracted",
    ),
    "revolutions": ("revolutions", "of a window; empty for 4 of orders, 16 of maps"),
    "pulses": ("pulses a turn", "of the tacho"),
    "tacho_angle": ("tacho looks at", "direction from the x axis, such as 90 deg"),
    "start": ("from", "of the piece that is looked at; of an orbit its instant"),
    "end": ("to", "of the piece that is looked at"),
}
NEEDS_TURNING = ("orders", "map", "frequencies", "orbit")


class Looks:
    """The waveforms, and one picture at a time."""

    def __init__(self, bench: Bench, shelf: Measurements) -> None:
        self.shelf, self.asked = shelf, PictureOptions()
        self.name = ""
        with ui.row().classes("items-center gap-2 w-full"):
            ui.html("<h2 class='head'>Look</h2>", sanitize=False)
            self.work = Work(bench, "look")
        self.waves = WaveView().props('data-at="waves"')
        self.asking = ui.column().classes("w-full gap-2 q-mt-sm")
        self.picture = ui.html("", sanitize=False).classes("w-full measured-picture").props('data-at="look"')
        self.words = ui.html("", sanitize=False).classes("w-full").props('data-at="look words"')

    def show(self, name: str, data: xr.Dataset, version: str) -> None:
        """Show another measurement."""
        self.name, self.asked = name, PictureOptions()
        self.picture.set_content("")
        self.words.set_content(f'<pre class="said">{escape(data.told())}</pre>' if isinstance(data, Signals) else "")
        self.waves.show(name if isinstance(data, Signals) else "", version)
        self.asking.clear()
        if isinstance(data, Signals):
            with self.asking:
                self._form(data)
        elif is_orders(data):
            self._ask(
                "orders of the table", lambda: (order_table(data), "") if "time" not in data.dims else _tracked(data)
            )

    def _form(self, data: xr.Dataset) -> None:
        names = vibrations(data)
        if not names:
            ui.label("No channel is a vibration, so there is no picture but the waveforms.").classes("quiet")
            return
        turns = turning(data)
        with ui.row().classes("items-center gap-2"):
            choice = ui.select(
                {"": "all channels of one unit", **{name: name for name in names}}, value="", label="channel"
            )
            choice.props(FIELD).props("options-dense").style("width: 190px").bind_value_to(self.asked, "channel")
            for key, (label, help_) in WORDS.items():
                if turns or key in ("start", "end"):
                    box = marked(ui.input(label, value=getattr(self.asked, key)).props(FIELD), at=f"ask {key}")
                    hinted(box.style("width: 130px"), help_)
                    box.bind_value_to(self.asked, key, lambda text: text or "")
        with ui.row().classes("items-center gap-2"):
            for key, (title, _) in LOOKS.items():
                if turns or key not in NEEDS_TURNING:
                    button(title, partial(self._look, key, data), look="outline no-caps", at=f"look {key}")

    def _look(self, key: str, data: xr.Dataset) -> None:
        asked = PictureOptions(**vars(self.asked))
        self._ask(LOOKS[key][0], lambda: LOOKS[key][1](data, asked))

    def _ask(self, title: str, make: Any) -> None:
        name = self.name

        def work(_job: Job) -> tuple[str, str]:
            draw, words = make()
            return svg_of(draw, f"{title} of the measurement"), words

        def then(words: str | None, job: Job) -> None:
            if words is not None:
                said = f'<pre class="said">{escape(words)}</pre>' if words else ""
                self.words.set_content(said + notes_html(job.notes))

        self.work.draw(f"look {name}", work, self.picture, then, lambda: name == self.name)


def _tracked(data: xr.Dataset) -> Any:
    from autobalancer.plots.signals import orders as picture

    return (lambda: picture(data)), str(data)


# Waveforms of measured signals as an element of the page.


VIEW = Path(__file__).parents[1] / "view"


class WaveView(Element, component="wave_view.js", esm={"autobalancer-view": str(VIEW)}):
    """All channels over time, drawn and zoomed in the browser."""

    def __init__(self) -> None:
        super().__init__()
        self._props["source"] = ""
        self.classes("w-full")

    def show(self, name: str, version: str = "") -> None:
        """Show the signals of a name; another version fetches them again, and an empty name shows none."""
        self._props["source"] = f"/measured/{name}/wave.bin?v={version}" if name else ""
        self.update()


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
        self.opened: Opened | None = None
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
            box = uploader(upload, "a measured file", SUFFIXES, LARGEST, at="measured upload")
            hint = "a table (CSV, TSV), universal file, MATLAB, NumPy, sound, netCDF of this package"
            pick, look = partial(box.run_method, "pickFiles"), "unelevated no-caps"
            button("Open a file", pick, "upload_file", look, at="open measured", hint=hint)
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
            button("open", lambda: self.open(entry.name), label=f"open {entry.file}")
            link = ui.link("file", f"/measured/{entry.name}/file").props("download")
            marked(link, label=f"download {entry.file}")
            question = f"Delete {entry.file} of {entry.made} and the fits to it? They cannot be brought back."
            delete_button(entry.file, question, partial(self.shelf.delete, entry.name), partial(self._gone, entry.name))

    def _gone(self, name: str) -> None:
        if self.name == name:
            self.name = ""
            self._hide()
        self.refresh()

    def open(self, name: str) -> None:
        """Show a file: its first lines and columns, and if these suffice what is in it."""

        def work(_job: Job) -> Any:
            entry, lines = self.shelf.entry(name), self.shelf.preview(name)
            try:
                return entry, lines, self.shelf.data(name), ""
            except AutobalancerError as error:
                return entry, lines, None, str(error)

        self.work.start(f"read {name}", work, lambda job: self._show(name, job))

    def _read(self, reading: Reading) -> None:
        with refusals():
            self.shelf.describe(self.name, reading)
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
                self.opened = Opened(self.bench, self.shelf)
        self.opened.show(name, data, f"{abs(hash(json.dumps(asdict(entry.reading)))):x}")


# What the columns of a measured file mean: the first lines of the file beside a row for each column.


OPTIONAL_FIELDS = (
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
            for key, label, help_ in OPTIONAL_FIELDS:
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
        _label(kind, "quantity", column)
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
        _label(box, word, column)


def _label(element: Any, what: str, column: Column) -> None:
    """Its name for those who do not see it, and for tests."""
    marked(element, at=f"{what} of {column.column}", label=f"{what} of {column.column}")
