"""Define, start, and what is kept: one form at a time, the list of studies and designs, and the one that is open."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from nicegui import events, ui

from autobalancer.app.pages.bench import Bench
from autobalancer.app.pages.editor import toml_editor
from autobalancer.app.pages.hint import marked
from autobalancer.app.pages.inputs import picker, say_refused
from autobalancer.app.pages.studies.define_design import DefineDesign
from autobalancer.app.pages.studies.define_study import FIRST, DefineStudy
from autobalancer.app.pages.studies.kept import KeptList
from autobalancer.app.pages.studies.results import Results
from autobalancer.app.pages.typed import Typed
from autobalancer.app.store.measured.shelf import Shelf
from autobalancer.app.store.studies.designs import run_design
from autobalancer.app.store.studies.shelf import DESIGN, STUDY, Kept, Studies, sample_text
from autobalancer.app.store.studies.work import run_study
from autobalancer.app.text.asked import StudyReading
from autobalancer.app.text.asked_design import DesignReading
from autobalancer.app.text.document import with_value
from autobalancer.errors import AutobalancerError
from autobalancer.files.samples import sample_names

LARGEST = 1_000_000  # bytes of a file
FIRST_DESIGN = "centrifuge_design"  # what a new user sees
SAMPLES = {STUDY: "studies", DESIGN: "designs"}


class Opened:
    """The page Studies."""

    def __init__(self, bench: Bench, dark: Any) -> None:
        self.bench, self.shelf, self.dark = bench, Studies(bench.home), dark
        self.study = Typed(bench.home / "study_draft.toml", FIRST)
        self.design = Typed(bench.home / "design_draft.toml", _sample(FIRST_DESIGN))
        panels: dict[str, Any] = {}
        with ui.row().classes("items-center gap-2 w-full sources"):
            which = ui.toggle({STUDY: "Study", DESIGN: "Design"}, value=STUDY).props(
                'no-caps dense padding="5px 14px" data-at="which"'
            )
            for kind, draft in ((STUDY, self.study), (DESIGN, self.design)):
                panels[f"{kind} sources"] = self._sources(kind, draft)
        for kind in (STUDY, DESIGN):
            panels[kind] = ui.element("div").classes("asked")
            with panels[kind]:
                self._cards(kind)
        with ui.element("section").classes("card").props('aria-label="kept studies and designs"'):
            self.list = KeptList(bench, self.shelf, self._open, self._resume)
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
        study = kind == STUDY
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
            if kind == STUDY:
                new = ui.button("New study", icon="note_add", on_click=lambda: draft.set_text(FIRST))
                new.props('outline dense no-caps data-at="new study"')
            names = list(sample_names(SAMPLES[kind]))
            picker(names, f"sample {kind}", lambda name: draft.set_text(_sample(name)), at=f"sample {kind}")
            box = ui.upload(on_upload=upload, auto_upload=True, max_file_size=LARGEST, max_files=1)
            box.on("rejected", lambda event: say_refused(event, f"the file of a {kind}", ".toml", LARGEST))
            marked(box.props("accept=.toml").classes("hidden"), at=f"{kind} upload")
            ui.button("Open a file", icon="folder_open", on_click=lambda: box.run_method("pickFiles")).props(
                "outline dense no-caps"
            )
            undo = ui.button("Undo", icon="undo", on_click=draft.undo).props("flat dense no-caps")
            marked(undo, at=f"{kind} undo")
        return row

    def _start_study(self, reading: StudyReading) -> None:
        study = reading.study
        if study is None:
            return
        title = study.name if study.name != "study" else f"study of {study.machine.name}"
        entry = Kept("", STUDY, title, study.machine.name, reading.of.file, "", study.count)
        self._begin(entry, self.study.text, reading.of.text, {})

    def _start_design(self, reading: DesignReading) -> None:
        spec = reading.spec
        if spec is None:
            return
        title = spec.name if spec.name != "design" else f"design for {spec.machine.name}"
        entry = Kept("", DESIGN, title, spec.machine.name, reading.of.file, "")
        measured = {} if reading.measured is None else {reading.measured.name: reading.measured.read_bytes()}
        self._begin(entry, self.design.text, reading.of.text, measured)

    def _begin(self, entry: Kept, text: str, machine: str, more: dict[str, bytes]) -> None:
        try:
            name = self.shelf.add(entry, text, machine, more)
        except AutobalancerError as error:
            ui.notify(str(error), type="warning")
            return
        self._resume(name)

    def _measured(self, file: str) -> Path | None:
        """A measured file of the user."""
        shelf = Shelf(self.bench.home)
        return next((shelf.path(one.name) for one in shelf.entries() if one.file == file), None)

    def _resume(self, name: str) -> None:
        """Put it into the queue; it goes on when the page is closed."""
        going = any(job.title == name and not job.over for job in self.bench.long.of(self.bench.user))
        try:
            run = run_study if self.shelf.entry(name).kind == STUDY else run_design
            if not going:  # another page of the user may have been quicker
                self.bench.long.start(self.bench.user, name, lambda job: run(self.shelf, name, job))
        except AutobalancerError as error:
            ui.notify(str(error), type="warning")
        self.list.refresh()
        self._open(name)

    def _open(self, name: str) -> None:
        self.results.show(name)


def _sample(name: str) -> str:
    """A sample, with its name in the text."""
    text = sample_text(name)
    return text if "\nname" in text else with_value(text, ("name",), name)
