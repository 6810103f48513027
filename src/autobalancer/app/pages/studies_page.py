"""Studies and designs: nothing of them is loaded until somebody comes here, so that the page opens at once."""

from __future__ import annotations

import contextlib
import json
import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Generic, TypeVar

from fastapi import Response
from fastapi.responses import FileResponse
from nicegui import events, ui

from autobalancer.app.form_fields import (
    SHOWN,
    VALUES,
    WORDS,
    Number,
    Row,
    as_entry,
    as_list,
    entry_text,
    fields_of,
    offered,
    varied_rows,
    with_entry,
    with_kind,
    with_row,
)
from autobalancer.app.pages.elements import (
    FLAT,
    Bench,
    Typed,
    button,
    hinted,
    marked,
    picker,
    refusals,
    serve_at,
    toml_editor,
    uploader,
)
from autobalancer.app.pages.study_results import Results, StudyList
from autobalancer.app.problems import (
    DesignReading,
    StudyReading,
    about,
    data_of,
    read_design_text,
    read_study_text,
    value_at,
    with_value,
    without,
)
from autobalancer.app.problems import EntryPath as DocumentPath
from autobalancer.app.store import studies as kept
from autobalancer.app.store.measured_files import Measurements
from autobalancer.catalog.product_tables import fluids
from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.files.samples import sample_names
from autobalancer.machine import Machine
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.machine.part import Part
from autobalancer.results.measure_table import SWEPT
from autobalancer.results.store import result_csv
from autobalancer.studies.design.chambers import ChamberSpec, ChamberSpecification
from autobalancer.studies.design.specification import (
    OBJECTIVES,
    Candidates,
    Limits,
    Operation,
    Search,
    Space,
    Specification,
)
from autobalancer.studies.study.chunk import BALANCED, OUTPUTS, RUN, STALLED, STANDING
from autobalancer.studies.study.study_file import StudyFile
from autobalancer.studies.study.study_spec import KINDS, MIDDLES

# Define, start, and what is kept: one form at a time, the list of studies and designs, and the one that is open.


LARGEST = 1_000_000  # bytes of a file
FIRST_DESIGN = "centrifuge_design"  # what a new user sees
SAMPLES = {kept.STUDY: "studies", kept.DESIGN: "designs"}


class Opened:
    """The page Studies."""

    def __init__(self, bench: Bench, dark: Any) -> None:
        self.bench, self.shelf, self.dark = bench, kept.Studies(bench.home), dark
        self.study = Typed(bench.home / "study_draft.toml", FIRST)
        self.design = Typed(bench.home / "design_draft.toml", _sample(FIRST_DESIGN))
        panels: dict[str, Any] = {}
        with ui.row().classes("items-center gap-2 w-full sources"):
            which = ui.toggle({kept.STUDY: "Study", kept.DESIGN: "Design"}, value=kept.STUDY).props(
                'no-caps dense padding="5px 14px" data-at="which"'
            )
            for kind, draft in ((kept.STUDY, self.study), (kept.DESIGN, self.design)):
                panels[f"{kind} sources"] = self._sources(kind, draft)
        for kind in (kept.STUDY, kept.DESIGN):
            panels[kind] = ui.element("div").classes("asked")
            with panels[kind]:
                self._cards(kind)
        with ui.element("section").classes("card").props('aria-label="kept studies and designs"'):
            self.list = StudyList(bench, self.shelf, self._open, self._resume)
        self.results = Results(bench, self.shelf)

        def turn() -> None:
            for name, panel in panels.items():
                panel.set_visibility(name.split()[0] == which.value)

        which.on_value_change(lambda _event: turn())
        turn()
        self.list.refresh()

    def seen(self, now: bool) -> None:
        """The person has come to this page, or has left it."""
        self.list.seen(now)
        self.results.seen(now)

    def _cards(self, kind: str) -> None:
        study = kind == kept.STUDY
        with marked(ui.element("section").classes("card"), label=f"form of the {kind}"):
            title = "What varies, and how" if study else "What is asked of the balancer"
            ui.html(f"<h2>{title}</h2>", sanitize=False)
            if study:
                DefineStudy(self.bench, self.study, self._start_study)
            else:
                DefineDesign(self.bench, self.design, self._measured, self._start_design)
        with marked(ui.element("section").classes("card"), label=f"text of the {kind}"):
            ui.html(f"<h2>{'Study file' if study else 'Specification'} (TOML)</h2>", sanitize=False)
            editor = toml_editor(self.study if study else self.design, self.dark)
            marked(editor.classes("short"), at=f"{kind} toml")

    def _sources(self, kind: str, draft: Typed) -> Any:
        async def upload(event: events.UploadEventArguments) -> None:
            content = await event.file.read()
            box.reset()
            try:
                draft.set_text(content[: LARGEST + 1].decode("utf-8-sig").replace("\r\n", "\n"))
            except ValueError:
                ui.notify(f"this file is no text; the file of a {kind} is TOML", type="negative")

        with ui.row().classes("items-center gap-2") as row:
            if kind == kept.STUDY:
                button("New study", partial(draft.set_text, FIRST), "note_add", "outline dense no-caps", at="new study")
            names = list(sample_names(SAMPLES[kind]))
            picker(names, f"sample {kind}", lambda name: draft.set_text(_sample(name)), at=f"sample {kind}")
            box = uploader(upload, f"the file of a {kind}", (".toml",), LARGEST, at=f"{kind} upload")
            button("Open a file", lambda: box.run_method("pickFiles"), "folder_open", "outline dense no-caps")
            button("Undo", draft.undo, "undo", at=f"{kind} undo")
        return row

    def _start_study(self, reading: StudyReading) -> None:
        study = reading.study
        if study is None:
            return
        title = study.name if study.name != "study" else f"study of {study.machine.name}"
        entry = kept.StudyEntry("", kept.STUDY, title, study.machine.name, reading.of.file, "", study.count)
        self._begin(entry, self.study.text, reading.of.text, {})

    def _start_design(self, reading: DesignReading) -> None:
        spec = reading.spec
        if spec is None:
            return
        title = spec.name if spec.name != "design" else f"design for {spec.machine.name}"
        entry = kept.StudyEntry("", kept.DESIGN, title, spec.machine.name, reading.of.file, "")
        measured = {} if reading.measured is None else {reading.measured.name: reading.measured.read_bytes()}
        self._begin(entry, self.design.text, reading.of.text, measured)

    def _begin(self, entry: kept.StudyEntry, text: str, machine: str, more: dict[str, bytes]) -> None:
        with refusals():
            self._resume(self.shelf.add(entry, text, machine, more))

    def _measured(self, file: str) -> Path | None:
        """A measured file of the user."""
        shelf = Measurements(self.bench.home)
        return next((shelf.path(one.name) for one in shelf.entries() if one.file == file), None)

    def _resume(self, name: str) -> None:
        """Put it into the queue; it goes on when the page is closed."""
        going = any(job.title == name and not job.over for job in self.bench.long.of(self.bench.user))
        with refusals():
            run = kept.run_study if self.shelf.entry(name).kind == kept.STUDY else kept.run_design
            if not going:  # another page of the user may have been quicker
                self.bench.long.start(self.bench.user, name, lambda job: run(self.shelf, name, job))
        self.list.refresh()
        self._open(name)

    def _open(self, name: str) -> None:
        self.results.show(name)


def _sample(name: str) -> str:
    """A sample, with its name in the text."""
    text = kept.sample_text(name)
    return text if "\nname" in text else with_value(text, ("name",), name)


# A study as a form and as its text: what varies, the plan, when it stops, what is asked of every run.


FIRST = """machine = "machine.toml"   # the one on the page Describe
members = 200              # draws, at most

[vary.unbalance]
distribution = "normal"
standard_deviation = "10 %"
"""
R = TypeVar("R", StudyReading, DesignReading)
HELP = {VALUES: "a list such as 5, 10, 20 mm^2/s, or a range such as 5:50 mm^2/s:4; all are run with every draw"}


class Define(Generic[R]):
    """Form and text of a study or a design; ``start`` is called with what was read."""

    kind: str

    def __init__(self, bench: Bench, draft: Typed, start: Callable[[R], None]) -> None:
        self.bench, self.draft = bench, draft
        self.entries = Entries(draft)
        self.reading: R = self.read()
        self.place = ui.column().classes("w-full gap-2")
        with ui.row().classes("items-center gap-2 w-full q-mt-sm"):
            act, look = lambda: start(self.reading), "unelevated no-caps"
            self.go = button("Start", act, "play_arrow", look, at=f"start {self.kind}")
            self.said = marked(ui.label().classes("quiet"), at=f"{self.kind} size")
        self.wrong = marked(ui.label().classes("wrong").props('role="alert"'), at=f"{self.kind} wrong")
        draft.on_change(lambda origin: self._look(again=origin is not self.entries))
        bench.on_change(lambda _origin: self._look(again=True))
        self._look(again=True)

    def read(self) -> R:
        """What the text says."""
        raise NotImplementedError

    def size(self) -> str:
        """How much work it is; empty where it is not possible yet."""
        raise NotImplementedError

    def build(self, data: dict[str, Any]) -> None:
        """Put the entries on the page."""
        raise NotImplementedError

    def _look(self, *, again: bool) -> None:
        self.reading = self.read()
        if again:
            self.place.clear()
            self.entries.shown = {}
            with self.place:
                data = data_of(self.draft.text)
                if data is None:
                    ui.label("The text is not valid TOML; the form comes back when it is.").classes("quiet")
                else:
                    self.build(data)
        self.entries.mark(self.reading.problems)
        said = self.size()
        self.said.set_text(said)
        self.wrong.set_text(self.reading.message)
        self.go.set_enabled(bool(said))


class DefineStudy(Define[StudyReading]):
    """What varies, the plan, when it stops, what is asked."""

    kind = kept.STUDY

    def read(self) -> StudyReading:
        """What the text says."""
        return read_study_text(self.draft.text, self.bench.whole_text)

    def size(self) -> str:
        """How much work it is."""
        return about(self.reading.study) if self.reading.study is not None else ""

    def build(self, _data: dict[str, Any]) -> None:
        """Put the entries on the page."""
        machine = self.reading.of.machine
        self.offer: dict[str, Number] = offered(self.reading.of.text, machine) if machine is not None else {}
        self._machine(machine)
        with ui.column().classes("w-full gap-1").props('data-at="varies"'):
            for row in varied_rows(self.draft.text):
                self._row(row)
        self._more()
        self._plan()
        self._stop()
        self._asked()

    def _machine(self, machine: Machine | None) -> None:
        of = self.reading.of
        with ui.row().classes("items-center gap-2 w-full"):
            where = "of the page Describe" if of.file == "machine.toml" else f"sample {of.file}"
            text = f"{machine.name}, {where}" if machine is not None else NO_QUANTITY
            ui.label(f"Machine: {text}").classes("key").props('data-at="study machine"')
            if of.file != "machine.toml" and machine is not None:

                def take() -> None:
                    self.bench.set_text(of.text)
                    self.draft.set_text(with_value(self.draft.text, ("machine",), "machine.toml"))

                hint = "the study is of the machine of that page then; undo brings the machine before back"
                at, look = "study machine to describe", f"{FLAT} size=sm"
                button("take it into Describe", take, "input", look, at=at, hint=hint)

    def _row(self, row: Row) -> None:
        number = self.offer.get(row.name)
        with marked(ui.column().classes("w-full gap-1 spread"), at=f"varies {row.name}"):
            with ui.row().classes("items-center gap-2 w-full no-wrap"):
                hinted(ui.label(row.label).classes("key"), row.name)
                ui.label(f"now {number.given}" if number is not None else "").classes("quiet")
                ui.space()
                look, label = "flat dense round size=sm", f"do not vary {row.label}"
                button("", lambda: self._drop(row), "close", look, label=label)
            with ui.element("div").classes("fields"):
                kind = ui.select(WORDS, value=row.kind if row.kind in WORDS else None, label="distribution")
                marked(kind.props("dense outlined options-dense").classes("field"), at=f"distribution of {row.name}")
                kind.on_value_change(lambda event: self._kind(row, event.value))
                kind.without_auto_validation()
                self.entries.shown[f"vary.{row.name}"] = kind
                for key in SHOWN.get(row.kind, ()):
                    self._part(row, key)

    def _part(self, row: Row, key: str) -> None:
        box = ui.input(
            key.replace("_", " "), value=row.entries.get(key, ""), placeholder="of the machine" * (key in MIDDLES)
        )
        marked(box.props(LOOK), at=f"{key} of {row.name}")
        box.classes("field wide" if key == VALUES else "field")
        known = {field.name: field.help for field in fields_of(KINDS[row.kind])} if row.kind in KINDS else HELP
        hinted(box, known[key]).without_auto_validation()
        box.on_value_change(lambda event: self._edit(lambda text: with_entry(text, row, key, event.value or "")))
        if key != VALUES or row.kind != VALUES:
            self.entries.shown[f"vary.{row.name}.{key}"] = box

    def _more(self) -> None:
        known = {name: f"{one.label}: {one.given}" for name, one in self.offer.items()}

        def take(name: str) -> None:
            if not any(row.name == name for row in varied_rows(self.draft.text)):
                self._edit(lambda text: with_row(text, self.offer[name]), focus=f"distribution of {name}")

        picker(known, "add what varies: a number of the machine", take, at="add varies").classes("w-full")

    def _plan(self) -> None:
        self.entries.table("Draws and runs", StudyFile, but=("machine", "name", "vary", "results", "show"))

    def _stop(self) -> None:
        stop = value_at(data_of(self.draft.text), ("stop",))
        on = isinstance(stop, dict)
        box = ui.checkbox("stop as soon as a number is known well enough", value=on).props('dense data-at="stop"')

        def turned(event: Any) -> None:
            name = self._names()[0]
            fresh = {"of": name, "half_width": 0.05} if name == BALANCED else {"of": name, "relative": 0.05}
            self._edit(
                lambda text: with_value(text, ("stop",), fresh) if event.value else without(text, ("stop",)),
                focus="stop",
            )

        box.on_value_change(turned)
        if not isinstance(stop, dict):
            return
        put, share = self.entries, stop.get("of") in (BALANCED, STALLED)
        with ui.element("div").classes("fields"):
            names = {name: name.replace("_", " ") for name in self._names()}
            of = put.choice("of", ("stop", "of"), names, "", "the quantity that is to be known")
            of.on_value_change(lambda event: self._stop_of(event.value))
            if not share:
                kinds = {"mean": "mean", "quantile": "quantile"}
                put.choice("statistic", ("stop", "statistic"), kinds, "mean", "of which the interval is asked")
                put.line("at", ("stop", "at"), "level of the quantile, such as 0.95", "0.5")
            tip = "half of the 95 % interval: of shares such as 0.05, of numbers with their unit"
            put.line("half width", ("stop", "half_width"), tip)
            put.line("or relative", ("stop", "relative"), "half of the interval over the value, such as 0.05")

    def _stop_of(self, name: str) -> None:
        fresh = {"of": name, "half_width": 0.05} if name in (BALANCED, STALLED) else {"of": name, "relative": 0.05}
        self._edit(lambda text: with_value(text, ("stop",), fresh), focus="stop.of")

    def _asked(self) -> None:
        with ui.element("div").classes("fields wide-fields"):
            said = "all measures of a run; border speeds, critical speed and capability need no run"
            self.entries.several("results", ("results",), OUTPUTS, [RUN], said)
            self.entries.several("shown in the table", ("show",), self._names()[2:], [], "medians and percentiles")

    def _names(self) -> list[str]:
        """Quantities of the members."""
        given = value_at(data_of(self.draft.text), ("results",))
        results = [given] if isinstance(given, str) else given if isinstance(given, list) else [RUN]
        standing = [STANDING[one].name for one in results if one in STANDING]
        if RUN not in results:
            return standing or [BALANCED]
        return [BALANCED, STALLED, *(one.name for one in SWEPT if not one.per_ball), *standing]

    def _kind(self, row: Row, kind: str) -> None:
        now = next((one for one in varied_rows(self.draft.text) if one.name == row.name), row)
        if kind and kind != now.kind:
            self._edit(
                lambda text: with_kind(text, now, kind, self.offer.get(row.name)), focus=f"distribution of {row.name}"
            )

    def _drop(self, row: Row) -> None:
        self._edit(lambda text: without(text, row.at), focus="add varies")

    def _edit(self, change: Callable[[str], str], *, focus: str = "") -> None:
        """Change the text; where other entries belong to it, the form is made anew, and ``focus`` has the focus."""
        try:
            self.draft.edit(change, None if focus else self.entries)
        except (AutobalancerError, ValueError, LookupError, TypeError) as error:  # the text may just have changed
            ui.notify(str(error), type="warning")
            return
        if focus:
            with self.place:  # the row that was changed is gone
                self.entries.focus(focus)


# The specification of a design as a form of its most used entries and as its text.


class DefineDesign(Define[DesignReading]):
    """The specification; ``find`` gives a measured file."""

    kind = kept.DESIGN

    def __init__(
        self,
        bench: Bench,
        draft: Typed,
        find: Callable[[str], Path | None],
        start: Callable[[DesignReading], None],
    ) -> None:
        self.find = find
        super().__init__(bench, draft, start)

    def read(self) -> DesignReading:
        """What the text says."""
        return read_design_text(self.draft.text, self.bench.whole_text, self.find)

    def size(self) -> str:
        """How much work it is."""
        spec = self.reading.spec
        if isinstance(spec, ChamberSpec):
            return f"short runs of the candidates that are left, {spec.fillings} full runs of {spec.budget} of them"
        return "" if spec is None else f"{spec.search.members} runs of each candidate that is left"

    def build(self, data: dict[str, Any]) -> None:
        """Put the entries on the page."""
        self._machine()
        if isinstance(self.reading.of.machine, ChamberMachine):
            self.entries.table("Unbalance", ChamberSpecification, but=("machine", "name"))
            for name in ("limits", "candidates", "runs"):
                part: Any = ChamberSpecification.model_fields[name].annotation
                self.entries.table(name.capitalize(), part, (name,))
            return
        self.entries.table("Unbalance and temperature", Specification, but=("machine", "name", "scatter"))
        self.entries.table("Operation", Operation, ("operation",))
        self.entries.table("Space", Space, ("space",))
        self.entries.table("Limits", Limits, ("limits",))
        self.entries.table("Candidates", Candidates, ("candidates",), but=("fluids",))
        self._fluids(data)
        self._search()

    def _machine(self) -> None:
        of = self.reading.of
        where = "of the page Describe" if of.file == "machine.toml" else f"sample {of.file}"
        text = (
            f"{of.machine.name}, {where}" if of.machine is not None else NO_QUANTITY if of.file else "a measured rotor"
        )
        with ui.row().classes("items-center gap-2 w-full"):
            ui.label(f"Machine: {text}").classes("key").props('data-at="design machine"')
            if of.file not in ("", "machine.toml"):
                button("take the one of Describe", self._page, look=f"{FLAT} size=sm", at="design of page")

    def _page(self) -> None:
        self.entries.put(("machine",), "machine.toml", self)
        with self.place:  # the button is gone
            self.entries.focus("unbalance.from")

    def _fluids(self, data: dict[str, Any]) -> None:
        held = value_at(data, ("candidates", "fluids"))
        path: DocumentPath = ("candidates", "fluids")
        if held is not None and not (isinstance(held, list) and all(isinstance(one, str) for one in held)):
            box = ui.input("fluids", value="blends, or a fluid for each race: see the text").props(f"{LOOK} readonly")
            self.entries.known(box.classes("w-full"), path, "of the races")
            return
        names = list(dict.fromkeys([*(held or []), *(one.name for one in fluids())]))
        self.entries.several("fluids", path, names, [], "of the races; the machine keeps its own if none is chosen")
        self.entries.shown["candidates.fluids"].classes("w-full")

    def _search(self) -> None:
        self.entries.table("Search", Search, ("search",), but=("objectives",))
        names = list(OBJECTIVES)
        said = "two numbers that should be small; they make the Pareto front"
        default = ["peak_deflection", "settling_time"]
        self.entries.several("objectives", ("search", "objectives"), names, default, said)
        self.entries.shown["search.objectives"].classes("w-full")


def _several(given: str) -> Any:
    """A word, one value, or a list."""
    given = given.strip()
    if "," in given:
        return as_list(given)
    value = as_entry(given)
    return [value] if isinstance(value, int) else value


# Entries of the forms of studies and designs: each shows what stands at a key of the text, and changes it there.


FOCUS = """let left = 60;
const go = () => {{
  const marked = [...document.querySelectorAll("[data-at]")].find((one) => one.dataset.at === {place});
  const wanted = marked?.tabIndex >= 0 ? marked : marked?.querySelector("input");
  if (wanted && document.activeElement === document.body) wanted.focus();
  else if (left--) requestAnimationFrame(go);
}};
requestAnimationFrame(go);"""  # once the entry that had the focus is gone; whoever is elsewhere by then stays there
NO_QUANTITY = "none that is possible here"
LOOK = "dense outlined stack-label debounce=350"


class Entries:
    """Puts entries on the page; ``shown`` are those that can carry an error, by their key."""

    def __init__(self, draft: Typed) -> None:
        self.draft = draft
        self.shown: dict[str, Any] = {}

    def put(self, path: DocumentPath, value: Any, origin: object | None = None) -> None:
        """Write a value to the text; without one the key goes."""

        def change(text: str) -> str:
            there = value_at(data_of(text), path) is not None
            if value is None or value == "":
                return without(text, path) if there else text
            return with_value(text, path, value)

        with contextlib.suppress(ValueError, KeyError, TypeError):  # the text is no TOML; its editor says so
            self.draft.edit(change, self if origin is None else origin)

    def line(
        self, label: str, path: DocumentPath, help_: str, hint: str = "", made: Callable[[str], Any] = as_entry
    ) -> Any:
        """A number, a quantity with its unit, or a text."""
        box = ui.input(label, value=entry_text(value_at(data_of(self.draft.text), path)), placeholder=hint).props(LOOK)
        box.on_value_change(lambda event: self.put(path, made(event.value or "")))
        return self.known(box, path, help_)

    def table(self, title: str, part: type[Part], path: DocumentPath = (), but: Sequence[str] = ()) -> None:
        """An entry for each key of a table that has no tables of its own, as the class that checks it says."""
        ui.label(title).classes("box-title q-mt-xs")
        with ui.element("div").classes("fields"):
            for field in fields_of(part):
                at, label = (*path, field.name), field.name.replace("_", " ")
                held = value_at(data_of(self.draft.text), at)
                if field.name in but or field.kind in ("table", "tables"):
                    continue
                if field.ends and not field.many:
                    self.ends(label, at, field.help)
                elif field.kind == "choice":
                    self.choice(label, at, {word: word for word in field.choices}, field.default, field.help)
                elif isinstance(held, dict) or (
                    isinstance(held, list) and any(isinstance(one, (dict, list)) for one in held)
                ):
                    self.known(ui.input(label, value="see the text").props(f"{LOOK} readonly"), at, field.help)
                else:
                    self.line(label, at, field.help, made=_several if field.many else as_entry)

    def ends(self, label: str, path: DocumentPath, help_: str) -> None:
        """From and to; a single value stands in both."""

        def changed(end: str, given: str) -> None:
            now = value_at(data_of(self.draft.text), path)
            known = dict(now) if isinstance(now, dict) else {} if now is None else {"from": now, "to": now}
            kept = {key: value for key, value in (known | {end: as_entry(given)}).items() if value != ""}
            self.put(path, kept or None)

        held = value_at(data_of(self.draft.text), path)
        for end in ("from", "to"):
            box = ui.input(f"{label} {end}", value=entry_text(held.get(end) if isinstance(held, dict) else held)).props(
                LOOK
            )
            box.on_value_change(lambda event, end=end: changed(end, event.value or ""))
            self.known(box, (*path, end), help_)

    def choice(self, label: str, path: DocumentPath, choices: Mapping[str, str], default: str, help_: str) -> Any:
        """One of several words; the default is not written."""
        value = value_at(data_of(self.draft.text), path)
        box = ui.select(dict(choices), value=value if value in choices else default, label=label)
        box.on_value_change(lambda event: self.put(path, None if event.value == default else event.value))
        return self.known(box.props("dense outlined options-dense"), path, help_)

    def several(
        self, label: str, path: DocumentPath, choices: Sequence[str], default: Sequence[str], help_: str
    ) -> Any:
        """Some of several words."""
        value = value_at(data_of(self.draft.text), path)
        given = [value] if isinstance(value, str) else value if isinstance(value, list) else list(default)
        box = ui.select(list(choices), value=[one for one in given if one in choices], label=label, multiple=True)
        box.on_value_change(lambda event: self.put(path, list(event.value) if list(event.value) != default else None))
        return self.known(box.props("dense outlined options-dense use-chips"), path, help_)

    def known(self, box: Any, path: DocumentPath, help_: str) -> Any:
        """An entry with its help, its name for tests, and a place for its error."""
        key = ".".join(map(str, path))
        self.shown[key] = box
        marked(box.classes("field").without_auto_validation(), at=key, about=help_)
        hinted(box, help_)
        return box

    def focus(self, place: str) -> None:
        """Give the focus, which a form that is made anew loses, to the entry with this mark."""
        ui.run_javascript(FOCUS.format(place=json.dumps(place)))

    def mark(self, problems: Mapping[str, str]) -> None:
        """Put what is wrong beside the entry of each key, or of the table in which it is."""
        for box in self.shown.values():
            box.error = None
        for key, message in problems.items():
            near = key
            while near and near not in self.shown:
                near = near.rpartition(".")[0]
            if near:
                self.shown[near].error = message


class StudiesPage:
    """Stands for the page until it is seen."""

    def __init__(self, bench: Bench, dark: Any) -> None:
        self.bench, self.dark = bench, dark
        self.opened: Opened | None = None
        self.place = ui.column().classes("w-full gap-3")

    def seen(self, now: bool) -> None:
        """The person has come to this page, or has left it."""
        if self.opened is not None:
            self.opened.seen(now)
        elif now:
            with self.place:
                self.opened = Opened(self.bench, self.dark)


# Files of studies and designs as answers of the server.


TABLE = "table.csv"
CHOSEN = re.compile(r"design_(\d{1,4})\.toml")
TYPES = {
    ".toml": "application/toml",
    ".nc": "application/x-netcdf",
    ".csv": "text/csv; charset=utf-8",
    ".html": "text/html; charset=utf-8",
    ".pdf": "application/pdf",
}


def serve_studies(root: Path) -> None:
    """Answer ``/study/NAME/FILE`` with the studies of whoever asks."""

    def answer(home: Path, name: str, kind: str) -> Response:
        shelf, chosen = kept.Studies(home), CHOSEN.fullmatch(kind)
        if kind == TABLE or chosen:
            text = result_csv(kept.result_of(shelf, name)) if chosen is None else _chosen(shelf, name, int(chosen[1]))
            as_file = {"content-disposition": f'attachment; filename="{name}-{kind}"'}
            return Response(text, media_type=TYPES[Path(kind).suffix], headers=as_file)
        path = shelf.file(name, kind)
        # the texts keep their names, by which one names the other
        called = path.name if path.suffix == ".toml" else f"{name}-{path.name}"
        return FileResponse(path, media_type=TYPES[path.suffix], filename=called)

    serve_at(root, "/study/{name}/{kind}", answer)


def _chosen(shelf: kept.Studies, name: str, place: int) -> str:
    found = kept.design_of(shelf, name, None)
    if found is None:
        raise QuestionError(f"study {name}: is no finished design")
    return kept.chosen_text(found, place)
