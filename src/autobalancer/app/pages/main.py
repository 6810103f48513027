"""The page as a whole: its head, its parts, and how it starts."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Any

from fastapi import Request
from nicegui import app, ui

from autobalancer.app.pages.archive import ArchivePage
from autobalancer.app.pages.bench import Bench
from autobalancer.app.pages.describe import describe
from autobalancer.app.pages.files import serve_files, user_of
from autobalancer.app.pages.hint import hinted, marked
from autobalancer.app.pages.measured.files import serve_measured
from autobalancer.app.pages.measured.page import MeasuredPage
from autobalancer.app.pages.run import RunPage
from autobalancer.app.pages.sign import confirm, watch
from autobalancer.app.pages.stability.page import StabilityPage
from autobalancer.app.pages.studies.files import serve_studies
from autobalancer.app.pages.studies.page import StudiesPage
from autobalancer.app.pages.tabs import Tabs
from autobalancer.app.store.jobs import Jobs, keep_warnings
from autobalancer.app.store.names import user_folder
from autobalancer.errors import AutobalancerError

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
    keep_warnings()
    confirm()
    app.on_shutdown(jobs.close)
    app.state.jobs = jobs
    app.on_shutdown(long.close)

    serve_files(root)
    serve_measured(root)
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
            button = ui.button(icon=icon, on_click=act).props("flat dense round")
            hinted(marked(button, at=what, label=what), what)

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
            try:
                run.show(str(event.args))
            except AutobalancerError as error:
                ui.notify(str(error), type="warning")

        ui.on("run_asked", asked)

        with ui.tab_panel("archive"):
            archive = ArchivePage(bench, see)
    tabs.show_in(panels)
    tabs.on_value_change(lambda event: archive.refresh() if event.value == "archive" else None)
    tabs.on_value_change(lambda event: studies.seen(event.value == "studies"))
    tabs.on_value_change(lambda event: measured.seen() if event.value == "measured" else None)
    tabs.on_value_change(lambda event: stability.seen(event.value == "stability"))
