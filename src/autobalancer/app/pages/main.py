"""The page as a whole: its head, its parts, and how it starts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from fastapi import Request
from nicegui import app, ui

from autobalancer.app.pages.archive import ArchivePage
from autobalancer.app.pages.bench import Bench
from autobalancer.app.pages.describe import describe
from autobalancer.app.pages.files import serve_files, user_of
from autobalancer.app.pages.run import RunPage
from autobalancer.app.pages.stability import StabilityPage
from autobalancer.app.store.jobs import Jobs, keep_warnings
from autobalancer.app.store.names import user_folder

LOOK = Path(__file__).with_name("look.css")


def build(root: Path, limit: float) -> Any:
    """Make the page; runs are kept below ``root``, and a job may take ``limit`` seconds."""
    jobs = Jobs(limit=limit)
    keep_warnings()
    app.on_shutdown(jobs.close)

    serve_files(root)

    @ui.page("/", title="autobalancer", dark=None)
    def page(request: Request) -> None:
        user = user_of(request)
        home = user_folder(root, user)
        home.mkdir(parents=True, exist_ok=True)
        _page(Bench(user, home, jobs))

    return app


def _page(bench: Bench) -> None:
    ui.add_css(LOOK)
    ui.colors(primary="#0072B2", negative="#b42318", positive="#00795a")
    dark = ui.dark_mode(None)
    with ui.header().classes("items-center q-py-xs q-px-md gap-3 no-wrap"):
        ui.label("autobalancer").classes("text-weight-bold").style("font-size: 1.05rem")
        with ui.tabs().props("dense no-caps inline-label") as tabs:
            ui.tab("describe", "Describe", icon="tune")
            ui.tab("run", "Run", icon="play_circle_outline")
            ui.tab("stability", "Stability", icon="grid_on")
            ui.tab("archive", "Archive", icon="inventory_2")
        ui.space()
        name = ui.label().classes("quiet ellipsis")
        for icon, what, act in (("undo", "undo", bench.undo), ("redo", "redo", bench.redo)):
            ui.button(icon=icon, on_click=act).props(f'flat dense round aria-label="{what}"').tooltip(what).props(
                f'data-at="{what}"'
            )

        def shade() -> None:
            dark.value = not dark.value

        ui.button(icon="contrast", on_click=shade).props('flat dense round aria-label="light or dark"').props(
            'data-at="shade"'
        )

    def follow(_origin: object = None) -> None:
        machine = bench.reading.machine
        name.set_text(machine.name if machine is not None else "not possible yet")

    bench.on_change(follow)
    follow()
    with ui.column().classes("page"), ui.tab_panels(tabs, value="describe", animated=False, keep_alive=True):
        with ui.tab_panel("describe"):
            describe(bench, dark)
        with ui.tab_panel("run"):
            run = RunPage(bench, dark)

        with ui.tab_panel("stability"):
            StabilityPage(bench)

        def see(name: str) -> None:
            tabs.set_value("run")
            run.show(name)

        with ui.tab_panel("archive"):
            archive = ArchivePage(bench, see)
    tabs.on_value_change(lambda event: archive.refresh() if event.value == "archive" else None)
