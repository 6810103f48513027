"""The page Stability: one analysis beside the other, and the report."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime
from functools import partial
from html import escape
from pathlib import Path
from typing import Any

from nicegui import run, ui
from nicegui.element import Element

import autobalancer as ab
from autobalancer.app.form_fields import alike, machine_with, text_with
from autobalancer.app.pages.describe import PENCIL
from autobalancer.app.pages.elements import FLAT, Bench, Work, button, hinted, marked, notes_html, table_html
from autobalancer.app.store.analyses import (
    ANALYSES,
    About,
    Entry,
    Known,
    LatestAnswers,
    answer_text,
    defaults,
    known_of,
    no_analysis_reason,
)
from autobalancer.app.store.jobs import Job, Latest
from autobalancer.app.store.pictures import (
    MapPicture,
    PointStatement,
    exact_statement,
    file_of,
    map_picture,
    statement_from_map,
    svg_of,
)
from autobalancer.assembly.quantities import value_of
from autobalancer.errors import AutobalancerError, unwarned
from autobalancer.machine import Machine
from autobalancer.progress import Progress

# One analysis on the page: its form, the line of its job, its picture, and what it says.


FIELD = "dense outlined hide-bottom-space options-dense"
PANEL_FORMS = {"png": "picture (PNG)", "svg": "picture (SVG)", "nc": "numbers (netCDF)"}
SOON = 6.0  # s, after which something is probably compiled
COMPILING = "working; what is asked for the first time is compiled before, up to a minute or two"
OLD = "This answer is of {name} as it was on {made}; the machine of the page is another one."


class Panel:
    """Asks one question in the queue of jobs, and shows its latest answer, whenever that was made."""

    def __init__(self, bench: Bench, name: str, answers: LatestAnswers) -> None:
        self.bench, self.name, self.answers = bench, name, answers
        self.analysis = ANALYSES[name]
        self.known: Known | None = None
        self.own: dict[str, str] = {}  # what the user has entered
        self.inputs: dict[str, Any] = {}
        self.about: About | None = None
        self.drawing = Latest(PENCIL)
        self.filling = False
        self.waits = self.wanted = False  # for what is known of another machine; whether it was started meanwhile
        self.why = ""  # why the question is not for the machine
        with ui.element("section").classes("card"):
            ui.label(self.analysis.about).classes("quiet")
            self.form = ui.row().classes("items-start gap-2 w-full q-mt-sm")
            with self.form:
                for key, entry in self.analysis.entries.items():
                    self.inputs[key] = self._entry(key, entry)
                self.button = button("Work it out", self.start, "play_arrow", "unelevated no-caps", at=f"ask {name}")
                self.work = Work(bench, name, self._word)
            self.wrong = marked(ui.label().classes("wrong").props('role="alert"'), at=f"wrong {name}")
        self.wrong.set_visibility(False)
        with ui.element("section").classes("card") as self.card:
            self.old = marked(ui.label().classes("note"), at=f"old {name}")
            self.place()
            self.words = marked(ui.html("", sanitize=False).classes("w-full"), at=f"words {name}")
            with ui.row().classes("gap-2 items-center q-mt-sm"):
                ui.label("Save as").classes("quiet")
                for kind, word in PANEL_FORMS.items():
                    button(word, partial(self.save, kind), at=f"save {name} {kind}")
        self.card.set_visibility(False)
        self.work.follow(self.title, self.over)

    @property
    def title(self) -> str:
        """Of its jobs."""
        return f"analysis {self.name}"

    def _word(self, job: Job) -> str:
        if job.share:
            return self.analysis.word(job.share)
        return COMPILING if job.begun and time.monotonic() - job.begun > SOON else "working"

    def place(self) -> None:
        """Make room for the picture."""
        self.picture = ui.html("", sanitize=False).classes("w-full stability-picture")
        marked(self.picture, at=f"picture {self.name}")

    def _entry(self, key: str, entry: Entry) -> Any:
        if entry.choices is not None:
            one: Any = ui.select({}, label=entry.label, on_change=partial(self._entered, key))
        else:
            one = ui.input(entry.label, on_change=partial(self._entered, key)).props("debounce=150")
        marked(one.props(FIELD), at=f"{self.name} {key}").classes("entry-of-analysis" + (" wide" if entry.wide else ""))
        hinted(one.without_auto_validation(), entry.help)
        return one

    def _entered(self, key: str, event: Any) -> None:
        if self.filling:
            return
        self.own[key] = str(event.value or "")
        self.inputs[key].error = None
        if self.analysis.entries[key].choices is not None:  # what depends on it is no longer the user's
            later = list(self.inputs)[list(self.inputs).index(key) + 1 :]
            self.own = {one: text for one, text in self.own.items() if one not in later or one == "speed"}
            self.fill(self.known, "")

    def fill(self, known: Known | None, why: str) -> None:
        """Take what is known of the machine into the form, or say why the question is not for it."""
        self.known = known
        why = why or (self.analysis.refusal(known) if known is not None else "")
        self.form.set_visibility(not why)
        self.why = why
        self.card.set_visibility(self.about is not None and not why)
        self.say_wrong(f"{self.analysis.title} {why}." if why else "")
        if known is None or why:
            return
        self.filling = True
        given = defaults(self.analysis, known, self.own)
        for key, entry in self.analysis.entries.items():
            if entry.choices is not None:
                self.inputs[key].set_options(dict(entry.choices(known)), value=given[key])
            else:
                self.inputs[key].set_value(given[key])
        self.filling = False
        self.mark_old()

    def ready(self) -> None:
        """The form is that of the machine of the page; what was started meanwhile begins."""
        wanted, self.waits, self.wanted = self.wanted, False, False
        if wanted:
            self.work.said.set_text("")
        if wanted and not self.why:
            self.start()

    def say_wrong(self, text: str) -> None:
        """What is wrong, below the form."""
        self.wrong.set_text(text)
        self.wrong.set_visibility(bool(text))

    def given(self) -> dict[str, str]:
        """The texts of the form."""
        return {key: str(one.value or "") for key, one in self.inputs.items()}

    def start(self) -> None:
        """Put the question into the queue; it goes on when the page is closed."""
        machine, text = self.bench.reading.machine, self.bench.whole_text
        if self.waits:  # the form is still that of the machine before
            self.wanted = True
            self.work.said.set_text("begins")
            return
        if not isinstance(machine, Machine):
            return
        given = self.given()
        self.fault("")
        try:
            asked = self.analysis.read(machine, given)
        except AutobalancerError as error:
            self.fault(str(error))
            return
        self.work.start(
            self.title, lambda job: self.answers.ask(self.name, machine, text, asked, given, job), self.over
        )

    def fault(self, message: str) -> None:
        """Say what is wrong beside its entry, or below the form."""
        name, rest = self.analysis.wrong_entry(message)
        for key, one in self.inputs.items():
            one.error = rest if key == name else None
        self.say_wrong("" if name else message)

    def over(self, job: Job) -> None:
        """The job has ended."""
        if job.state == "failed":
            self.fault(job.message)
        elif job.result == self.name:
            self.show()

    def show(self) -> None:
        """Draw the latest answer in the background, if there is one."""
        about = self.answers.about(self.name)
        if about is None:
            return

        def work() -> Any:
            try:
                found = self.answers.answer(self.name)
                return found, self.drawn(found, about), self.told(found, about)
            except AutobalancerError as error:
                return None, str(error), ""

        self.picture.classes(add="old")  # until the new one is there
        self.drawing.start(work, partial(self._put, about))

    async def save(self, kind: str) -> None:
        """Send the answer to the browser as a file."""
        file = f"{self.name}.{kind}"
        if kind == "nc":
            ui.download.file(self.answers.path(self.name), file)
            return
        try:
            found = await run.io_bound(self.answers.answer, self.name)
            made = await run.io_bound(file_of, partial(ab.plot.answer, found), kind)
            if made is not None:  # the server does not end just now
                ui.download.content(made, file)
        except AutobalancerError as error:
            ui.notify(str(error), type="warning")

    def drawn(self, found: Any, about: About) -> Any:
        """The picture; called in another thread."""
        alternative = f"{self.analysis.title} of {about.name}. {' '.join(f'{text}.' for text in answer_text(found))}"
        return svg_of(lambda: ab.plot.answer(found), alternative.strip())

    def told(self, found: Any, about: About) -> str:
        """What is said below the picture."""
        lines = "".join(f"<div>{escape(text)}</div>" for text in answer_text(found))
        table = table_html(found.columns(), look="spaced") if self.analysis.table else ""
        return f'{table}<div class="quiet">{lines}</div>{notes_html(about.notes)}'

    def _put(self, about: About, made: Any) -> None:
        if self.card.is_deleted:
            return
        found, drawn, words = made
        with self.card:
            self.about = about
            self.picture.classes(remove="old")
            self.card.set_visibility(not self.why)
            self.words.set_content(words)
            if found is None:
                self.picture.set_content(f'<div class="wrong">{escape(drawn)}</div>')
            else:
                self.put(found, drawn)
            self.mark_old()

    def put(self, found: Any, drawn: Any) -> None:
        """Put the picture on the page."""
        self.picture.set_content(drawn)

    def mark_old(self) -> None:
        """Say so if the picture is not of the machine as it is."""
        old = self.about is not None and not self.is_of_the_machine()
        self.old.set_visibility(old)
        if old and self.about is not None:
            self.old.set_text(OLD.format(name=self.about.name, made=self.about.made))

    def is_of_the_machine(self) -> bool:
        """Whether the answer is of the machine of the page."""
        machine = self.bench.reading.machine
        if self.about is None or self.about.text == self.bench.whole_text:
            return True
        try:
            return isinstance(machine, Machine) and alike(self.about.machine, machine)
        except AutobalancerError:
            return False


FACTS = ThreadPoolExecutor(1, thread_name_prefix="facts")
REPORT = "report "
FORMS = ("pdf", "html")
LOOK = Path(__file__).with_name("stability_look.css")


class StabilityPage:
    """Panels that are made when they are first seen; each keeps its answer."""

    def __init__(self, bench: Bench) -> None:
        self.bench, self.latest = bench, Latest(FACTS)
        self.answers = LatestAnswers(bench.home)
        self.panels: dict[str, Panel] = {}
        self.known: Known | None = None
        self.why = ""
        self.visible, self.stale, self.asking = False, True, False
        ui.add_css(LOOK)
        with ui.element("section").classes("card bar"), ui.row().classes("items-center gap-2 w-full"):
            with ui.tabs(on_change=lambda event: self._open(event.value)).props("dense no-caps") as self.tabs:
                for name, analysis in ANALYSES.items():
                    marked(ui.tab(name, analysis.title), at=f"analysis {name}")
            ui.space()
            self._reports()
        self.rooms = ui.tab_panels(self.tabs, value="map", animated=False, keep_alive=True).classes("w-full")
        with self.rooms:
            self.places = {name: ui.tab_panel(name) for name in ANALYSES}
        bench.on_change(lambda _origin: self._changed())

    def seen(self, now: bool) -> None:
        """Whether the page is shown; what nobody sees is worked out when somebody does."""
        self.visible = now
        if now:
            self._open(str(self.tabs.value or "map"))
            if self.stale:
                self._changed()

    def _open(self, name: str) -> None:
        if name in self.panels or not self.visible:
            return
        with self.places[name]:
            panel = self.panels[name] = (MapPanel if name == "map" else Panel)(self.bench, name, self.answers)
        if self.known is not None or self.why:
            panel.fill(self.known, self.why)
        panel.waits = self.asking
        panel.show()

    def _changed(self) -> None:
        """Find out in the background what the forms need of the machine; only the latest text counts."""
        self.stale = not self.visible
        if self.stale:
            return
        machine: Any = self.bench.reading.machine
        why = no_analysis_reason(machine)
        if why:
            self.latest.number += 1  # what is under way is outdated
            self._fill(None, why)
            return

        def work() -> Known | str:
            try:
                with unwarned():
                    return known_of(machine)
            except AutobalancerError as error:
                return f"is not possible: {error}"
            except Exception as error:  # the panels must not wait for ever
                return f"is not possible: unexpected: {type(error).__name__}: {error}"

        def then(found: Known | str) -> None:
            self._fill(*((None, found) if isinstance(found, str) else (found, "")))

        self.asking = True
        for panel in self.panels.values():
            panel.waits = True
        self.latest.start(work, then)

    def _fill(self, known: Known | None, why: str) -> None:
        if self.rooms.is_deleted:
            return
        self.known, self.why, self.asking = known, why, False
        for panel in self.panels.values():
            with panel.card:
                panel.fill(known, why)
                panel.ready()

    def _reports(self) -> None:
        self.report = Work(self.bench, "report", lambda job: f"report: {job.share:.0%}")
        ui.label("Report").classes("quiet")
        for form in FORMS:
            hint = "drawing, facts, borders, run-up, basin and 40 random starts of this machine in one file"
            word, look, label = form.upper(), "outline dense no-caps", f"report as {form.upper()}"
            button(word, partial(self._report, form), look=look, at=f"report.{form}", label=label, hint=hint)
        self.made = ui.row().classes("items-center gap-2")
        self.report.follow(REPORT, self._reported)
        self._offer()

    def _offer(self) -> None:
        """Links to the reports that were made."""
        self.made.clear()
        with self.made:
            for form in FORMS:
                path = self.bench.home / "reports" / f"report.{form}"
                if path.is_file():
                    made = datetime.fromtimestamp(path.stat().st_mtime, UTC)
                    word, hint = f"{form.upper()} of {made:%H:%M} UTC", f"made on {made:%Y-%m-%d}"
                    button(word, partial(ui.download, path), look=f"{FLAT} size=sm", at=f"made.{form}", hint=hint)

    def _report(self, form: str) -> None:
        machine = self.bench.reading.machine
        if not isinstance(machine, Machine):
            ui.notify(f"a report {no_analysis_reason(machine)}", type="warning")
            return
        path = self.bench.home / "reports" / f"report.{form}"

        def work(job: Job) -> str:
            _report_file(machine, path, job.progress)
            return form

        self.report.start(f"{REPORT}{machine.name}", work, self._reported)

    def _reported(self, job: Job) -> None:
        if job.state == "failed":
            ui.notify(f"no report: {job.message}", type="warning", multi_line=True, timeout=10000)
        elif job.state == "done":
            self._offer()
            ui.download(self.bench.home / "reports" / f"report.{job.result}")


def _report_file(machine: Any, path: Path, progress: Progress) -> Path:
    """The report of a machine as ``.html`` or ``.pdf``."""
    from autobalancer.reporting.report import report

    path.parent.mkdir(parents=True, exist_ok=True)
    return report(machine, path, starts=40, progress=progress)


# The stability map with the point that one moves: another speed, another oil, and what the machine would do there.


KEYBOARD_HELP = "Drag the point, click, or use the arrow keys: with shift in larger steps, with alt in smaller."
POINT = ThreadPoolExecutor(1, thread_name_prefix="point")
VERDICTS = {"stable": "verdict good", "unstable": "verdict bad"}  # classes


class MapPanel(Panel):
    """The map; its point says at once what the map has there, and soon after what the full equations say."""

    def place(self) -> None:
        """Make room for the map, and beside it for the words of its point."""
        self.map: MapPicture | None = None
        self.found: Any = None
        self.values: dict[str, float] = {}
        self.moved = False  # by the user
        self.exact = Latest(POINT)
        with ui.element("div").classes("map-and-point"):
            with ui.element("div").classes("map-place"):
                super().place()
                self.point = MapPoint(self._moved)
            with ui.column().classes("gap-2 point-words"):
                ui.html("<h2 class='head'>The point</h2>", sanitize=False)
                with ui.row().classes("gap-2 w-full no-wrap"):
                    self.boxes = [
                        marked(ui.input("").props("dense outlined hide-bottom-space"), at=f"point {k}") for k in "xy"
                    ]
                for number, box in enumerate(self.boxes):
                    box.on("change", lambda _event, number=number: self._typed(number)).without_auto_validation()
                self.verdict = ui.label().props('role="status" aria-live="polite" data-at="point verdict"')
                self.borders = ui.html("", sanitize=False).classes("w-full").props('data-at="point borders"')
                with ui.row().classes("gap-2"):
                    self.take = ui.button("Take into the machine", icon="input", on_click=self._take)
                    hinted(self.take.props('outline no-caps data-at="take point"'), "undo brings the machine back")
                    self.back = ui.button("Back to the machine", icon="undo", on_click=self._own)
                    self.back.props('flat no-caps data-at="own point"')
                ui.label(
                    "Drag the point, click, or use the arrow keys: with shift in larger steps, with alt in smaller."
                ).classes("quiet")

    def drawn(self, found: Any, about: About) -> Any:
        """The picture with its scales."""
        words = " ".join(f"{text}." for text in answer_text(found))
        return map_picture(found, f"{self.analysis.title} of {about.name}. {words}")

    def put(self, found: Any, drawn: MapPicture) -> None:
        """Put the map on the page, its point where the machine is."""
        self.found, self.map = found, drawn
        self.picture.set_content(drawn.svg)
        self.point.show(drawn)
        for box, scale in zip(self.boxes, (drawn.x, drawn.y), strict=True):
            box.props["label"] = scale.short
        if self.moved and self.map.knows(self.values):
            self._see(self.values, last=True)
        else:
            self._own()

    def fill(self, known: Any, why: str) -> None:
        """Also where the machine itself is."""
        super().fill(known, why)
        if self.map is not None and self.values:
            self._mark()

    def is_of_the_machine(self) -> bool:
        """A map stays that of a machine that has another speed or another oil."""
        if super().is_of_the_machine():
            return True
        machine = self.bench.reading.machine
        if self.about is None or not isinstance(machine, Machine):
            return False
        try:
            return alike(machine_with(self.about.machine, self._of_machine()), machine)
        except AutobalancerError:
            return False

    def _of_machine(self) -> dict[str, float]:
        """The values of the machine of the page along both axes, as far as it has them."""
        machine = self.bench.reading.machine
        if self.map is None or not isinstance(machine, Machine):
            return {}
        try:
            found = {name: value_of(machine, name) for name in (self.map.x.name, self.map.y.name)}
        except AutobalancerError:
            return {}
        return {name: value for name, value in found.items() if value > 0.0}

    def _own(self) -> None:
        """The point back to the machine, else to the middle."""
        if self.map is None:
            return
        own, self.moved = {**self.map.values(0.5, 0.5), **self._of_machine()}, False
        self._see(own if self.map.shares(own) else self.map.values(0.5, 0.5), last=True)

    def _moved(self, x: float, y: float, last: bool) -> None:
        if self.map is not None:
            self.moved = True
            self._see(self.map.values(x, y), last=last)

    def _typed(self, number: int) -> None:
        """Another value of one axis, as it is written in the box."""
        if self.map is None:
            return
        box, scale = self.boxes[number], (self.map.x, self.map.y)[number]
        try:
            shown = float(str(box.value).strip())
        except ValueError:
            box.error = f"a number in {scale.sign}" if scale.sign else "a number"
            return
        wanted = {**self.values, scale.name: shown / scale.factor}
        if self.map.shares(wanted) is None:
            box.error = f"from {scale.low:.4g} to {scale.high:.4g} on this map"
            return
        self.moved = True
        self._see(wanted, last=True)

    def _see(self, values: dict[str, float], *, last: bool) -> None:
        """Say what the map has at a point, and ask what the equations say; older questions are dropped."""
        assert self.map is not None
        assert self.about is not None
        self.values = values
        for box, scale in zip(self.boxes, (self.map.x, self.map.y), strict=True):
            box.value, box.error = f"{values[scale.name] * scale.factor:.4g}", None
        self._mark()
        self._say(statement_from_map(self.found, values))
        machine = self.about.machine

        def work() -> PointStatement | str:
            try:
                return exact_statement(machine, values, borders=last)
            except AutobalancerError as error:
                return str(error)

        self.exact.start(work, self._say)

    def _mark(self) -> None:
        assert self.map is not None
        own = self._of_machine()
        self.point.put(self.map.shares(self.values), self.map.shares(own) if len(own) == 2 else None)
        away = any(abs(value / self.values[name] - 1.0) > 1e-3 for name, value in own.items())
        self.take.set_enabled(away and self.is_of_the_machine())

    def _say(self, seen: PointStatement | str) -> None:
        if self.card.is_deleted:
            return
        if isinstance(seen, str):
            self.verdict.set_text(seen)
            self.verdict.classes(replace="wrong")
            return
        if seen.exact and not seen.borders:  # while the point moves, borders are those of the map
            seen.borders = statement_from_map(self.found, self.values).borders
        assert self.map is not None
        self.verdict.set_text(seen.words())
        self.verdict.classes(replace=VERDICTS.get(seen.verdict, "verdict"))
        cells = ((name, at, side, near) for name, at, side, near in seen.rows(self.values["speed"]))
        rows = "".join(
            f"<tr{' class=nearest' if near else ''}><td>{escape(name)}</td><td>{escape(at)}</td><td>{escape(side)}</td></tr>"
            for name, at, side, near in cells
        )
        head = "<tr><th>border here</th><th>speed</th><th>point is</th></tr>"
        self.borders.set_content(f'<table class="facts">{head}{rows}</table>' if rows else "")
        where = ", ".join(f"{one.label} {one.text(self.values[one.name])}" for one in (self.map.x, self.map.y))
        self.point.say(f"{where}: {seen.words()}", seen.verdict)

    def _take(self) -> None:
        """Write the values of the point into the text of the machine, as far as it has them."""
        machine, left = self.bench.reading.machine, []
        if not isinstance(machine, Machine):
            return
        text = self.bench.text
        for name, value in self.values.items():
            try:
                text = text_with(text, machine, {name: value})
                machine = machine_with(machine, {name: value})
            except AutobalancerError as error:
                left.append(str(error))
        self.bench.set_text(text)
        if left:
            ui.notify("not taken: " + "; ".join(left), type="warning", multi_line=True, timeout=10000)
        else:
            ui.notify("taken into the machine; undo brings it back", type="positive")


# A point that is dragged over the picture of a stability map, as an element of the page.


Moved = Callable[[float, float, bool], None]
LOOKS = {"stable": "stable", "unstable": "unstable"}


class MapPoint(Element, component="map_point.js"):
    """Lies over the picture of a map; ``moved`` gets the shares of both axes, and whether the point was let go."""

    def __init__(self, moved: Moved) -> None:
        super().__init__()
        self._props |= {"size": [1, 1], "area": [0, 0, 1, 1], "point": None, "machine": None, "answer": 0}
        self._props |= {"words": "", "look": "", "label": "operating point: arrow keys move it"}
        self.on("moved", lambda event: self._tell(event.args, moved))
        self.moves = 0  # how many the browser has told

    def show(self, drawn: MapPicture) -> None:
        """Lie over another map."""
        self._props |= {"size": list(drawn.size), "area": list(drawn.area)}
        self.update()

    def put(self, point: tuple[float, float] | None, machine: tuple[float, float] | None) -> None:
        """Put the point, and the mark of the machine itself, at these shares."""
        self._props |= {"point": point and list(point), "machine": machine and list(machine), "answer": self.moves}
        self.update()

    def say(self, words: str, verdict: str) -> None:
        """What is known at the point, for those who do not see it."""
        self._props |= {"words": words, "look": LOOKS.get(verdict, "")}
        self.update()

    def _tell(self, args: Any, moved: Moved) -> None:
        try:
            x, y, self.moves = float(args["x"]), float(args["y"]), int(args["number"])
        except (TypeError, KeyError, ValueError):
            return  # nothing that our page sends
        if 0.0 <= x <= 1.0 and 0.0 <= y <= 1.0:
            moved(x, y, bool(args.get("last")))
