"""Run: start, watch, cancel, and see what happened."""

from __future__ import annotations

import json
import re
import time
from collections.abc import Iterator
from html import escape
from itertools import groupby
from typing import Any

from nicegui import ui

from autobalancer.app.pages.bench import Bench
from autobalancer.app.pages.hint import hinted, marked
from autobalancer.app.pages.run_view import RunView
from autobalancer.app.pages.work import Work
from autobalancer.app.store.archive import Archive, Entry
from autobalancer.app.store.export import film as film_of
from autobalancer.app.store.jobs import Job
from autobalancer.app.text.document import with_value
from autobalancer.app.text.fields import PLAIN, written
from autobalancer.app.text.problems import for_page
from autobalancer.errors import AutobalancerError, UnitError
from autobalancer.results.display_units import moment_text
from autobalancer.units import to_si

WORDS = {
    "machine.toml": "machine (TOML)",
    "script.py": "Python script",
    "run.nc": "result (netCDF)",
    "measures.csv": "measures (CSV)",
    "picture.png": "picture (PNG)",
    "picture.svg": "picture (SVG)",
}
SOON = 6.0  # s without progress, after which something is probably compiled
LEAST = 1e-12  # m; a smaller deflection is said to be smaller


class RunPage:
    """One run at a time; what is under way goes on when the page is closed."""

    def __init__(self, bench: Bench) -> None:
        self.bench, self.archive = bench, Archive(bench.home)
        self.job: Job | None = None
        self.name = ""
        self.drawn = ""
        with ui.element("section").classes("card"), ui.row().classes("items-center gap-3 w-full"):
            self.start = ui.button("Run", icon="play_arrow", on_click=self.run).props(
                'unelevated no-caps data-at="start run"'
            )
            self.duration = ui.input("duration", placeholder="as in the file", validation=_wrong).style("width: 150px")
            self.duration.props('dense outlined stack-label hide-bottom-space data-at="duration"')
            hinted(self.duration, 'such as "20 s"; empty for run.duration of the machine')
            self.cancel = ui.button("Cancel", icon="stop", on_click=self.end).props('outline no-caps data-at="cancel"')
            self.bar = ui.linear_progress(0.0, show_value=False).style("flex: 1 1 120px; max-width: 320px")
            self.bar.props('aria-label="progress" rounded')
            self.word = ui.label().classes("quiet").props('data-at="state" role="status"')
            self.filming = Work(bench, "film", lambda job: f"film: {job.share:.0%}")
        self.none = ui.element("section").classes("card quiet").props('data-at="no run"')
        with self.none:
            ui.label("Run shows here the moving picture, the waveforms, the verdict and the measures of the machine.")
            ui.label("Earlier runs are on the page Archive.")
        self.verdict = ui.element("section").classes("card").props('data-at="verdict"')
        with ui.element("section").classes("card") as self.picture:
            self.view = RunView().props('data-at="view"')
        self.more = ui.element("section").classes("card")
        self.timer = ui.timer(0.1, self.look, active=False)
        self._idle()
        waiting = next((job for job in bench.jobs.of(bench.user) if not job.over and job.title.startswith("run")), None)
        if waiting is not None:
            self._watch(waiting)

    def run(self) -> None:
        """Put the machine of the page into the queue."""
        if not self.duration.validate():
            return
        if self.bench.reading.machine is None:
            self.bench.insist()
            ui.notify("the machine is not possible yet; see its form on the page Describe", type="warning")
            return
        text, length = self.bench.text, _decimal(self.duration.value)
        if length:
            text = with_value(text, ("run", "duration"), length)

        def work(job: Job) -> str:
            return self.archive.simulate(text, job)

        try:
            self._watch(self.bench.jobs.start(self.bench.user, f"run {self.bench.reading.machine.name}", work))
        except AutobalancerError as error:
            ui.notify(str(error), type="warning")

    def end(self) -> None:
        """Cancel what runs; what was computed is kept."""
        if self.job is not None:
            self.bench.jobs.cancel(self.job)

    def _watch(self, job: Job) -> None:
        self.job = job
        self.start.disable()
        self.word.classes(add="quiet", remove="wrong")
        for one in (self.cancel, self.bar):
            one.set_visibility(True)
        self._pale(picture=True, words=True)
        self.timer.activate()
        self.look()

    def _idle(self) -> None:
        self.start.enable()
        for one in (self.cancel, self.bar):
            one.set_visibility(False)
        self._room()

    def _room(self) -> None:
        """Show the parts that have something to show."""
        self.none.set_visibility(not self.drawn)
        self.picture.set_visibility(bool(self.drawn))
        for one in (self.verdict, self.more):
            one.set_visibility(bool(self.name))

    def _pale(self, *, picture: bool, words: bool) -> None:
        """What is of an earlier run than the one under way is pale."""
        for one, pale in ((self.picture, picture), (self.verdict, words), (self.more, words)):
            one.classes(add="old") if pale else one.classes(remove="old")

    def look(self) -> None:
        """Show how far the job is; the picture as soon as there is one."""
        job = self.job
        if job is None:
            return
        self.bar.value = job.share
        self.word.set_text(_told(job))
        if job.result and job.result != self.drawn:
            self.drawn = job.result
            self.view.show(job.result)
            self._room()
            self._pale(picture=False, words=True)
        if not job.over:
            return
        self.timer.deactivate()
        self.job = None
        if job.result and job.state in ("done", "cancelled"):
            self.show(job.result)
        words = {"failed": job.message, "cancelled": job.message or "cancelled"}
        self.word.set_text(words.get(job.state, job.message or f"done in {job.seconds:.2g} s"))
        failed = job.state == "failed"
        self.word.classes(add="wrong" if failed else "quiet", remove="quiet" if failed else "wrong")
        old = job.result is None  # what is shown is of a run before
        self._pale(picture=old, words=old)
        self._idle()

    def show(self, name: str) -> None:
        """Show a run of the archive."""
        entry = self.archive.entry(name)
        self.name = name
        if self.drawn != name:
            self.drawn = name
            self.view.show(name)
        self._tell(entry)
        ui.run_javascript(f"shownRun({json.dumps(name)})")
        self._pale(picture=False, words=False)
        self._room()

    def _tell(self, entry: Entry) -> None:
        self.verdict.clear()
        with self.verdict:
            color = "good" if entry.verdict.startswith("balanced") else ""
            said = escape(for_page(entry.verdict or entry.outcome))
            title = f"<h2>{escape(entry.machine)}</h2><div class='{color}'>{said}</div>"
            notes = "".join(f'<div class="note">{escape(text)}</div>' for text in entry.notes)
            ui.html(f"{title}<div class='quiet'>{escape(entry.outcome)}; {entry.made} UTC</div>{notes}", sanitize=False)
            with ui.row().classes("gap-2 q-mt-sm items-center"):
                ui.label("Save as").classes("quiet")
                for kind, word in WORDS.items():
                    marked(ui.link(word, f"/run/{entry.name}/{kind}").props("download"), at=kind)
                film = ui.button("make a film (GIF)", on_click=lambda: self._film(entry.name))
                film.props('flat dense no-caps data-at="film.gif"')
        self.more.clear()
        with self.more:
            rows = "".join(_rows(entry.measures))
            ui.html(f"<h2>Measures</h2><table class='facts'>{rows}</table>", sanitize=False).props('data-at="measures"')

    def _film(self, name: str) -> None:
        def work(job: Job) -> str:
            return film_of(self.archive, name, job.progress)

        def then(job: Job) -> None:
            if job.state == "done":
                ui.download(f"/run/{name}/film.gif")
            elif job.message:
                ui.notify(job.message, type="warning")

        self.filming.start(f"film {name}", work, then)


def _wrong(duration: str | None) -> str | None:
    """What is wrong with a duration, in few words; nothing if none is given."""
    if not (duration or "").strip():
        return None
    try:
        return None if to_si(_decimal(duration), "s") > 0.0 else "must be above 0 s"
    except UnitError:
        if "," in str(duration):
            return "write a decimal point"
        number = PLAIN.fullmatch(str(duration).strip())
        return f'write it as "{number[0] if number else 20} s"'


def _decimal(duration: str | None) -> str:
    """What was typed, a decimal comma as a point."""
    number, unit = re.fullmatch(r"\s*([-+\d.,eE]*)\s*(.*?)\s*", duration or "").groups()  # type: ignore[union-attr]
    return written(number, unit, "s") if number else unit


def _told(job: Job) -> str:
    """How far a run is."""
    if job.state == "waiting":
        return "waits for its turn"
    if job.result:
        return "the run is there; its verdict and measures are worked out"
    if not job.share and job.begun and time.monotonic() - job.begun > SOON:
        return "compiles: the first run of this kind waits up to a minute or two"
    return f"{100.0 * job.share:.0f} %"


def _rows(measures: dict[str, Any]) -> Iterator[str]:
    """A row for each measure; numbers of several balls, places or planes stand in one, each after its name."""
    for _, keys in groupby(measures, lambda key: str(key).partition("[")[0]):
        cells, meaning = [], ""
        for key in keys:
            value, unit, meaning = measures[key]
            which = key.partition("[")[2].removesuffix("]")
            cells.append(f"<span class='which'>{escape(which)}</span> <span>{escape(shown(value, unit))}</span>")
            meaning = meaning.removesuffix(f": {which}") if which else meaning
        yield f"<tr><td>{escape(meaning)}</td><td class='number'>{'<br>'.join(cells)}</td></tr>"


def shown(value: float, unit: str) -> str:
    """A measure as a person reads it."""
    if unit == "rad/s":
        return f"{value * 9.549296585513721:.5g} rpm"
    if unit == "rad":
        return f"{value * 57.29577951308232:.5g}°"
    if unit == "m" and 0.0 < abs(value) < LEAST:
        return "< 0.001 nm"
    if unit == "m" and value:
        scale, name = next(
            ((s, n) for s, n in ((1e9, "nm"), (1e6, "µm"), (1e3, "mm")) if abs(value) * s < 1000.0), (1.0, "m")
        )
        return f"{value * scale:.4g} {name}"
    if unit == "kg m":
        return moment_text(value)
    return f"{value:.4g} {'' if unit == '1' else unit}".strip()
