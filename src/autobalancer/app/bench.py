"""The page as a whole: its head, its parts, and how it starts."""

from __future__ import annotations

import contextlib
import json
import re
import time
import warnings
from collections.abc import Callable, Iterator
from functools import partial
from html import escape
from itertools import groupby
from pathlib import Path
from typing import Any

import nicegui
from fastapi import Request, Response
from fastapi.responses import FileResponse
from nicegui import Client, app, core, ui
from nicegui.element import Element

from autobalancer.app.form_fields import PLAIN, written
from autobalancer.app.pages.describe import describe
from autobalancer.app.pages.elements import (
    Bench,
    Lines,
    Work,
    button,
    delete_button,
    hinted,
    marked,
    notes_html,
    refusals,
    serve_at,
    user_of,
)
from autobalancer.app.pages.measured_page import MeasuredPage
from autobalancer.app.pages.stability_page import StabilityPage
from autobalancer.app.pages.studies_page import StudiesPage, serve_studies
from autobalancer.app.problems import for_page, with_value
from autobalancer.app.store.fits import fit_file
from autobalancer.app.store.jobs import Job, Jobs, here
from autobalancer.app.store.kept_runs import (
    LONGEST,
    STARTED,
    TYPES,
    UNREADABLE,
    Archive,
    Entry,
    differences,
    exported,
    user_folder,
)
from autobalancer.app.store.kept_runs import film as film_of
from autobalancer.app.store.measured_files import Measurements
from autobalancer.errors import AutobalancerError, QuestionError, UnitError
from autobalancer.results.display_units import moment_text
from autobalancer.units import to_si

LOOK = Path(__file__).with_name("look.css")
LONGER = 12.0  # times as long as other jobs a study or design may take before it waits to be resumed

PARTS = {
    "describe": "tune",
    "run": "play_circle_outline",
    "stability": "grid_on",
    "studies": "scatter_plot",
    "measured": "sensors",
    "archive": "inventory_2",
}
LOOKS = 2.0  # s between looks whether another page has changed the machine
OPENING = "opening"  # a file that is there while a page is made
ASIDE = "The page could not be opened with its texts last time. They are set aside, as *draft.aside in the folder of the runs."
OTHER_PAGE = "Another page had changed the machine meanwhile. Undo twice brings its text."


def build(root: Path, limit: float, *, several: bool = False) -> Any:
    """Make the page; runs are kept below ``root``, and a job may take ``limit`` seconds. ``several`` users share the workers."""
    jobs, long = Jobs(limit=limit, each=1 if several else None), Jobs(workers=1, limit=LONGER * limit)
    _keep_warnings()
    confirm()
    app.on_shutdown(jobs.close)
    app.state.jobs = jobs
    app.on_shutdown(long.close)

    _serve_files(root)
    _serve_measured(root)
    serve_studies(root)

    @ui.page("/", title="autobalancer", dark=None, language="en-US")
    def page(request: Request) -> None:
        user = user_of(request)
        home = user_folder(root, user)
        home.mkdir(parents=True, exist_ok=True)
        aside = _set_aside(home / OPENING)
        _page(Bench(user, home, jobs, long))
        with contextlib.suppress(OSError):
            (home / OPENING).unlink()
        if aside:
            ui.notify(ASIDE, type="warning", timeout=0, close_button="close")

    return app


# Measured files, their waveforms and the fits to them as answers of the server.


def _serve_measured(root: Path) -> None:
    """Answer with the measurements of whoever asks."""

    raw = "application/octet-stream"

    def waves(home: Path, name: str) -> Response:
        from autobalancer.app.store.signal_pictures import wave_block

        return Response(wave_block(Measurements(home).data(name)), media_type=raw)

    def file(home: Path, name: str) -> Response:
        path = Measurements(home).path(name)
        return FileResponse(path, media_type=raw, filename=path.name)

    def fitted(home: Path, name: str, fit: str, kind: str) -> Response:
        from autobalancer.app.store.fits import FIT_FILES

        path = fit_file(Measurements(home), name, fit, kind)
        return FileResponse(path, media_type=FIT_FILES[kind], filename=f"{fit}-{kind}")

    serve_at(root, "/measured/{name}/wave.bin", waves)
    serve_at(root, "/measured/{name}/file", file)
    serve_at(root, "/measured/{name}/fit/{fit}/{kind}", fitted)


def _serve_files(root: Path) -> None:
    """Answer ``/run/NAME/FORM`` with the runs of whoever asks."""

    def answer(home: Path, name: str, kind: str) -> Response:
        found = exported(Archive(home), name, kind)
        as_file = {"content-disposition": f'attachment; filename="{name}-{kind}"'} if kind != "view.bin" else {}
        if isinstance(found, Path):
            return FileResponse(found, media_type=TYPES[kind], headers=as_file)
        return Response(found, media_type=TYPES[kind], headers=as_file)

    serve_at(root, "/run/{name}/{kind}", answer)


def _keep_warnings() -> None:
    """From now on, warnings of a job become its notes; all others go their way."""
    others = warnings.showwarning

    def show(message: Warning | str, category: type[Warning], *place: Any) -> None:
        job = getattr(here, "job", None)
        if job is None:
            others(message, category, *place)
        elif str(message) not in job.notes:
            job.notes.append(str(message))

    warnings.showwarning = show  # type: ignore[assignment]
    warnings.filterwarnings("always", module="autobalancer")


def _set_aside(mark: Path) -> bool:
    """Put away the texts with which the page did not open last time, and mark that it is being opened."""
    aside = mark.exists()
    with contextlib.suppress(OSError):
        if aside:
            for draft in mark.parent.glob("*draft.toml"):
                draft.replace(draft.with_suffix(".aside"))
        mark.touch()
    return aside


def _page(bench: Bench) -> None:
    ui.add_css(LOOK)
    watch()
    ui.colors(primary="#0072B2", negative="#b42318", positive="#00795a")
    dark = ui.dark_mode(None)
    with ui.header().classes("items-center q-py-xs q-px-md gap-3 no-wrap"):
        ui.html("<h1>autobalancer</h1>", sanitize=False)
        with Tabs().props("dense no-caps inline-label") as tabs:
            for part, icon in PARTS.items():
                marked(ui.tab(part, part.capitalize(), icon=icon), at=f"tab {part}")
        ui.space()
        name = ui.label().classes("quiet ellipsis")
        for icon, what, act in (("undo", "undo", bench.undo), ("redo", "redo", bench.redo)):
            button("", act, icon, "flat dense round", at=what, label=what, hint=what)

        def shade(event: Any) -> None:
            dark.value = not event.args

        other = ui.button(icon="contrast").props('flat dense round aria-label="light or dark" data-at="shade"')
        other.on("click", shade, js_handler="() => emit(document.body.classList.contains('body--dark'))")

    def follow(_origin: object = None) -> None:
        machine = bench.reading.machine
        name.set_text(machine.name if machine is not None else "not possible yet")

    bench.on_change(follow)
    bench.on_other_page = lambda: ui.notify(OTHER_PAGE, type="warning", timeout=15_000)
    ui.timer(LOOKS, bench.look)
    follow()
    with ui.column().classes("page"), ui.tab_panels(value="describe", animated=False, keep_alive=True) as panels:
        with ui.tab_panel("describe"):
            describe(bench, dark)
        with ui.tab_panel("run"):
            run = RunPage(bench)

        with ui.tab_panel("stability"):
            stability = StabilityPage(bench)

        with ui.tab_panel("studies"):
            studies = StudiesPage(bench, dark)

        with ui.tab_panel("measured"):
            measured = MeasuredPage(bench)

        def see(name: str) -> None:
            tabs.go("run")
            run.show(name)

        def asked(event: Any) -> None:
            """The address names a run."""
            with refusals():
                run.show(str(event.args))

        ui.on("run_asked", asked)

        with ui.tab_panel("archive"):
            archive = ArchivePage(bench, see)
    tabs.show_in(panels)
    tabs.on_value_change(lambda event: archive.refresh() if event.value == "archive" else None)
    tabs.on_value_change(lambda event: studies.seen(event.value == "studies"))
    tabs.on_value_change(lambda event: measured.seen() if event.value == "measured" else None)
    tabs.on_value_change(lambda event: stability.seen(event.value == "stability"))


# The parts of the page: a click on a tab shows its part at once, in the browser; the server is only told.


ADDRESS = """<script>(() => {  // the part that is shown, and the run, stand in the address: back and reload find them
  let run = "";
  const [part, name] = [0, 1].map((k) => () => location.hash.slice(1).split("/")[k] || "");
  const tab = (one) => document.querySelector(`.q-tab[data-at="tab ${CSS.escape(one || "describe")}"]`);
  window.shownPart = (one) => {
    if (one !== (part() || "describe")) history.pushState(null, "", `#${one}${one === "run" && run ? `/${run}` : ""}`);
  };
  window.shownRun = (one) => {
    run = one;
    if (part() === "run") history.replaceState(null, "", `#run/${run}`);
  };
  function go() {
    if (!window.did_handshake || !tab()) return false;
    if (tab(part())?.getAttribute("aria-selected") === "false") tab(part()).click();
    if (name() && name() !== run) emitEvent("run_asked", name());
    return true;
  }
  window.addEventListener("popstate", go);
  const begin = () => part() && (go() || setTimeout(begin, 50));
  window.addEventListener("load", begin);
})();</script>"""

FIT = (  # texts of several lines that were made while another part was shown find their height now, as after an animation
    "document.querySelectorAll('.q-textarea--autogrow textarea').forEach("
    "(one) => one.dispatchEvent(new Event('animationend')))"
)


class Tabs(ui.tabs):
    """Tabs that do not wait for the server; ``panels`` are what they show."""

    LOOPBACK = False

    def __init__(self) -> None:
        super().__init__()
        self.panels: Any = None

    def show_in(self, panels: ui.tab_panels) -> None:
        """Let a click change ``panels``, which were made without tabs."""
        self.panels = panels
        ui.add_head_html(ADDRESS)
        self.set_value(panels.value)
        self.on(
            "update:model-value",
            js_handler=f"(name) => {{ [{self.id}, {panels.id}].forEach("
            "(id) => { mounted_app.elements[id].props['model-value'] = name; }); "
            f"Vue.nextTick(() => {FIT}); shownPart(name); }}",
        )

    def go(self, name: str) -> None:
        """Show a part for a reason of the server's."""
        self.panels.props["model-value"] = name
        self.panels.update()  # the server does not know what the browser shows
        self.set_value(name)
        ui.run_javascript(f"shownPart({json.dumps(name)})")


# Archive: find runs, tag them, load them again, compare up to three, delete.


ROWS_SHOWN = 60  # runs of a list
COLORS = ("#0072B2", "#D55E00", "#009E73")
MOST = 3  # runs side by side


class ArchivePage:
    """The runs of the user; ``show`` is called with the name of one that is to be seen again."""

    def __init__(self, bench: Bench, show: Callable[[str], None]) -> None:
        self.bench, self.archive, self.open = bench, Archive(bench.home), show
        self.chosen: list[str] = []
        with ui.element("section").classes("card"):
            with ui.row().classes("items-center gap-3 w-full"):
                self.search = ui.input("search").props('dense outlined clearable debounce=300 data-at="search"')
                self.search.style("width: 280px").on_value_change(lambda _event: self.refresh())
                self.count = ui.label().classes("quiet")
            self.lines = Lines[Entry](self._line)
            self.none = ui.label("No runs yet; start one on the page Run.").classes("quiet")
        self.archive.tidy(STARTED - LONGEST)
        self.boxes: dict[str, Any] = {}
        self.side = ui.element("section").classes("card").props('data-at="compared"')
        self.refresh()

    def refresh(self) -> None:
        """Read the folder again."""
        found = self.archive.found(self.search.value or "")
        there = {entry.name for entry in found}
        self.chosen = [name for name in self.chosen if name in there]
        self.count.set_text(f"{len(found)} run{'s' * (len(found) != 1)}")
        self.none.set_visibility(not found)
        self.lines.follow({entry.name: entry for entry in found[:ROWS_SHOWN]})
        self.boxes = {name: box for name, box in self.boxes.items() if name in self.lines.known}
        self._compare()

    def _line(self, entry: Entry, line: Any) -> None:
        """One run; whatever is wrong with it, the others are shown, and it can be deleted."""
        try:
            if entry.machine == UNREADABLE:
                raise QuestionError(UNREADABLE)
            self._run(entry)
        except Exception:
            line.clear()
            ui.label(f"the run {entry.name} {UNREADABLE}").classes("wrong").style("flex: 1 1 auto")
        question = f"Delete the run of {entry.machine} of {entry.made}? It cannot be brought back."
        gone = partial(self.archive.delete, entry.name)
        delete_button(f"the run of {entry.machine}", question, gone, self.refresh)

    def _run(self, entry: Entry) -> None:
        box = ui.checkbox(value=entry.name in self.chosen).props("dense")
        self.boxes[entry.name] = marked(box, label=f"compare {entry.machine}")
        box.on_value_change(lambda event: self._choose(entry.name, bool(event.value)))
        with ui.column().classes("gap-0").style("flex: 1 1 auto; min-width: 0"):
            ui.label(entry.machine).classes("key ellipsis")
            ui.label(f"{entry.made} UTC · {entry.seconds:.6g} s · {for_page(entry.verdict or entry.outcome)}").classes(
                "quiet"
            )
        tags = ui.input_chips(value=entry.tags, new_value_mode="add-unique").props('dense borderless label="tags"')
        tags.style("width: 210px; flex: 0 0 auto").on_value_change(
            lambda event: self._tag(entry.name, list(event.value or []))
        )
        button("see", lambda: self._try(self.open, entry.name))
        button("edit", lambda: self._try(self._edit, entry.name), hint="take its machine onto the page Describe")

    def _edit(self, name: str) -> None:
        self.bench.set_text(self.archive.text(name))

    def _try(self, act: Callable[[str], None], name: str) -> None:
        with refusals():
            act(name)

    def _tag(self, name: str, tags: list[str]) -> None:
        self.archive.tag(name, tags)
        self.lines.known[name] = (self.archive.entry(name), self.lines.known[name][1])

    def _choose(self, name: str, wanted: bool) -> None:
        self.chosen = [one for one in self.chosen if one != name]
        if wanted:
            self.chosen = [*self.chosen, name]
            if len(self.chosen) > MOST:
                self.boxes[self.chosen[0]].set_value(False)
        self._compare()

    def _compare(self) -> None:
        self.side.clear()
        self.side.set_visibility(bool(self.chosen))
        if not self.chosen:
            return
        try:
            entries = [self.archive.entry(name) for name in self.chosen]
            texts = [self.archive.text(name) for name in self.chosen]
            curves = [_curves(self.archive, name) for name in self.chosen]
        except (AutobalancerError, OSError, ValueError) as error:
            with self.side:
                ui.label(str(error)).classes("wrong")
            return
        with self.side:
            ui.html("<h2>Side by side</h2>", sanitize=False)
            ui.echart(_overlay(entries, curves)).style("height: 300px; width: 100%").props(
                'role="img" aria-label="greatest deflection of the chosen runs over time"'
            )
            ui.html(_table(entries, texts), sanitize=False).classes("w-full")


def _curves(archive: Archive, name: str) -> list[list[float]]:
    """Greatest deflection (µm) over time."""
    run = archive.run(name)
    if "envelope_high" in run:
        time, size = run["envelope_time"].values, run["envelope_high"].values
    elif "deflection" in run:
        time, size = run["time"].values, run["deflection"].values
    else:
        time = run["time"].values
        size = abs(run["body_position"].transpose("time", "axis").values[:, 1:]).max(axis=1)
    thin = max(1, len(time) // 1000)
    return [[float(t), float(f"{1e6 * s:.5g}")] for t, s in zip(time[::thin], size[::thin], strict=True)]


def _overlay(entries: list[Entry], curves: list[list[list[float]]]) -> dict[str, Any]:
    gray = "#808a93"
    axis = {"type": "value", "nameLocation": "middle", "axisLabel": {"color": gray}, "nameTextStyle": {"color": gray}}
    lines = {"splitLine": {"lineStyle": {"color": gray, "opacity": 0.25}}}
    return {
        "animation": False,
        "grid": {"left": 70, "right": 20, "top": 34, "bottom": 62},
        "legend": {"top": 0, "textStyle": {"color": gray}},
        "tooltip": {"trigger": "axis"},
        "xAxis": {
            **axis,
            **lines,
            "axisLabel": {"color": gray, "showMaxLabel": False},  # the end is no round number
            "name": "time (s)",
            "nameGap": 24,
            "max": "dataMax",
        },
        "yAxis": {**axis, **lines, "name": "greatest deflection (µm)", "nameGap": 52},
        "dataZoom": [{"type": "inside"}, {"type": "slider", "height": 16, "bottom": 6}],
        "series": [
            {
                "type": "line",
                "name": f"{number}: {entry.machine}",
                "showSymbol": False,
                "data": curve,
                "lineStyle": {"width": 1.4},
                "color": COLORS[number - 1],
            }
            for number, (entry, curve) in enumerate(zip(entries, curves, strict=True), 1)
        ],
    }


def _table(entries: list[Entry], texts: list[str]) -> str:
    """Measures side by side, and the entries in which the machines differ from the first."""
    heads = "".join(f"<th>{number}: {escape(entry.machine)}</th>" for number, entry in enumerate(entries, 1))
    meanings = {name: values[2] for entry in entries for name, values in entry.measures.items()}
    rows = [
        f"<tr><td>verdict</td>{''.join(f'<td>{escape(entry.verdict or entry.outcome)}</td>' for entry in entries)}</tr>"
    ]
    lengths = "".join(f"<td class='number'>{entry.seconds:.6g} s</td>" for entry in entries)
    rows.append(f"<tr><td>length of the run</td>{lengths}</tr>")
    for name, meaning in meanings.items():
        texts_of = [measure_text(*entry.measures[name][:2]) if name in entry.measures else "–" for entry in entries]
        cells = "".join(f"<td class='number'>{escape(text)}</td>" for text in texts_of)
        rows.append(f"<tr><td>{escape(meaning)}</td>{cells}</tr>")
    changed: dict[str, list[str]] = {}
    for number, text in enumerate(texts[1:], 1):
        for path, first, other in differences(texts[0], text):
            changed.setdefault(path, [first] * len(texts))[number] = other
    for path, values in changed.items():
        rows.append(f"<tr><td>{escape(path)}</td>{''.join(f'<td>{escape(value[:80])}</td>' for value in values)}</tr>")
    return f"<table class='facts'><tr><td></td>{heads}</tr>{''.join(rows)}</table>"


# Run: start, watch, cancel, and see what happened.


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
            self.start = button("Run", self.run, "play_arrow", "unelevated no-caps", at="start run")
            self.duration = ui.input("duration", placeholder="as in the file", validation=_wrong).style("width: 150px")
            self.duration.props('dense outlined stack-label hide-bottom-space data-at="duration"')
            hinted(self.duration, 'such as "20 s"; empty for run.duration of the machine')
            self.cancel = button("Cancel", self.end, "stop", "outline no-caps", at="cancel")
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
        text, length = self.bench.whole_text, _decimal(self.duration.value)
        if length:
            text = with_value(text, ("run", "duration"), length)

        title, archive = f"run {self.bench.reading.machine.name}", self.archive
        with refusals():
            self._watch(self.bench.jobs.start(self.bench.user, title, lambda job: archive.simulate(text, job)))

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
        self.bar.props(add="indeterminate" if not job.share else "", remove="indeterminate" if job.share else "")
        self.word.set_text(_progress_text(job))
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
            made = f"<div class='quiet'>{escape(entry.outcome)}; {entry.made} UTC</div>"
            ui.html(f"{title}{made}{notes_html(entry.notes)}", sanitize=False)
            with ui.row().classes("gap-2 q-mt-sm items-center"):
                ui.label("Save as").classes("quiet")
                for kind, word in WORDS.items():
                    marked(ui.link(word, f"/run/{entry.name}/{kind}").props("download"), at=kind)
                button("make a film (GIF)", lambda: self._film(entry.name), at="film.gif")
        self.more.clear()
        with self.more:
            rows = "".join(_measure_rows(entry.measures))
            ui.html(f"<h2>Measures</h2><table class='facts'>{rows}</table>", sanitize=False).props('data-at="measures"')

    def _film(self, name: str) -> None:
        def then(job: Job) -> None:
            if job.state == "done":
                ui.download(f"/run/{name}/film.gif")
            elif job.message:
                ui.notify(job.message, type="warning")

        self.filming.start(f"film {name}", lambda job: film_of(self.archive, name, job.progress), then)


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


def _progress_text(job: Job) -> str:
    """How far a run is."""
    if job.state == "waiting":
        return "waits for its turn"
    if job.result:
        return "the run is there; its verdict and measures are worked out"
    if not job.share and job.begun and time.monotonic() - job.begun > SOON:
        return "compiles: the first run of this kind waits up to a minute or two"
    return f"{100.0 * job.share:.0f} %"


def _measure_rows(measures: dict[str, Any]) -> Iterator[str]:
    """A row for each measure; numbers of several balls, places or planes stand in one, each after its name."""
    for _, keys in groupby(measures, lambda key: str(key).partition("[")[0]):
        cells, meaning = [], ""
        for key in keys:
            value, unit, meaning = measures[key]
            which = key.partition("[")[2].removesuffix("]")
            cells.append(f"<span class='which'>{escape(which)}</span> <span>{escape(measure_text(value, unit))}</span>")
            meaning = meaning.removesuffix(f": {which}") if which else meaning
        yield f"<tr><td>{escape(meaning)}</td><td class='number'>{'<br>'.join(cells)}</td></tr>"


def measure_text(value: float, unit: str) -> str:
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


# The moving picture of a run as an element of the page.


SCENE = Path(nicegui.__file__).parent / "elements" / "scene" / "dist"  # NiceGUI brings three.js in one file
VIEW = Path(__file__).with_name("view")


class RunView(Element, component="run_view.js", esm={"nicegui-scene": str(SCENE), "autobalancer-view": str(VIEW)}):
    """Scene, races, orbit and waveforms of one run, animated in the browser."""

    def __init__(self) -> None:
        super().__init__()
        self._props["source"] = ""
        self.classes("view")

    def show(self, name: str) -> None:
        """Show the run of a name; empty for none."""
        self._props["source"] = f"/run/{name}/view.bin" if name else ""
        self.update()


# Nothing pressed on the page is lost in silence: the server confirms it, and the browser says what is not confirmed.


SCRIPT = Path(__file__).with_name("sign.js")


def confirm() -> None:
    """Let the server answer every event; once for all pages."""
    known = core.sio.handlers["/"]["event"]

    def taken(socket: str, told: dict[str, Any]) -> str:
        client = Client.instances.get(told["client_id"])
        if client is not None and told["id"] not in client.elements:
            return "gone"
        known(socket, told)
        return "taken"

    core.sio.on("event", taken)


def watch() -> None:
    """Put what waits for these answers onto a page."""
    ui.add_head_html(f"<script>{SCRIPT.read_text(encoding='utf-8')}</script>")
