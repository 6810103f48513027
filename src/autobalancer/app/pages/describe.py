"""Describe: where a machine comes from, its form, its text, its drawing, and what is known of it."""

from __future__ import annotations

from typing import Any

from nicegui import events, ui

from autobalancer.app.pages.bench import Bench
from autobalancer.app.pages.check import Check
from autobalancer.app.pages.editor import toml_editor
from autobalancer.app.pages.form import Form
from autobalancer.app.pages.inputs import picker, say_refused
from autobalancer.app.text.document import EMPTY
from autobalancer.files.examples import example_text, examples
from autobalancer.files.rigs import rig_text, rigs

LARGEST = 1_000_000  # bytes of a machine file


def describe(bench: Bench, dark: Any) -> None:
    """Put this part of the page."""
    _sources(bench)
    with ui.element("div").classes("describe"):
        with ui.element("section").classes("card tall").props('aria-label="form"'):
            ui.html("<h2>Form</h2>", sanitize=False)
            Form(bench)
        with ui.element("section").classes("card text").props('aria-label="text"'):
            ui.html("<h2>Machine file (TOML)</h2>", sanitize=False)
            toml_editor(bench, dark).props('data-at="toml"')
        with ui.column().classes("gap-3 w-full"):
            Check(bench)


def _sources(bench: Bench) -> None:
    """A new machine, a sample, a published rig, a file."""

    async def upload(event: events.UploadEventArguments) -> None:
        content = await event.file.read()
        box.reset()
        try:
            bench.set_text(content[: LARGEST + 1].decode("utf-8-sig").replace("\r\n", "\n"))
            bench.insist()
        except ValueError:
            ui.notify("this file is no text; a machine file is TOML", type="negative")

    with ui.row().classes("items-center gap-2 w-full sources"):
        ui.button("Empty machine", icon="note_add", on_click=lambda: bench.set_text(EMPTY)).props(
            "outline dense no-caps"
        )
        picker(list(examples()), "sample machine", lambda name: bench.set_text(example_text(name)), at="sample")
        picker(list(rigs()), "published rig", lambda name: bench.set_text(rig_text(name)), at="rig")
        box = ui.upload(on_upload=upload, auto_upload=True, max_file_size=LARGEST, max_files=1)
        box.on("rejected", lambda event: say_refused(event, "a machine file", ".toml", LARGEST))
        box.props("accept=.toml").classes("hidden").props('data-at="upload"')
        ui.button("Open a file", icon="folder_open", on_click=lambda: box.run_method("pickFiles")).props(
            "outline dense no-caps"
        )
