"""What is known of the machine at once: capability, critical speeds, borders; only the latest text counts."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from html import escape
from typing import Any

from nicegui import core, ui

from autobalancer.app.pages.bench import Bench
from autobalancer.app.pages.hint import hinted
from autobalancer.app.store.drawn import svg_of
from autobalancer.app.store.jobs import Latest
from autobalancer.app.text.document import EMPTY
from autobalancer.either_kind import check
from autobalancer.errors import AutobalancerError, unwarned
from autobalancer.shown import rpm_and_si
from autobalancer.sketch.machine import machine as machine_picture

POOL = ThreadPoolExecutor(1, thread_name_prefix="check")
PENCIL = ThreadPoolExecutor(1, thread_name_prefix="drawing")


class Check:
    """Drawing and facts of the machine; both follow every edit."""

    def __init__(self, bench: Bench) -> None:
        self.bench = bench
        self.latest, self.pencil = Latest(POOL), Latest(PENCIL)
        with ui.element("section").classes("card"):
            with ui.row().classes("items-center gap-2 w-full"):
                ui.html("<h2 class='head'>Drawing</h2>", sanitize=False)
                button = ui.button(icon="open_in_full", on_click=self.enlarge).props("flat dense round size=sm")
                hinted(button.props('aria-label="larger drawing" data-at="enlarge"'), "larger")
            self.drawing = ui.html("", sanitize=False).classes("w-full").props('data-at="drawing"')
        with ui.element("section").classes("card tall-rest"):
            with ui.row().classes("items-center gap-2 w-full"):
                ui.html("<h2 class='head'>Check</h2>", sanitize=False)
                self.busy = ui.spinner(size="1.1em")
            self.facts = ui.html("", sanitize=False).classes("w-full").props('data-at="check"')
        with ui.dialog().props('aria-label="drawing"') as self.dialog, ui.card().classes("large"):
            ui.button(icon="close", on_click=self.dialog.close).props('flat dense round aria-label="close"').classes(
                "ml-auto"
            )
            self.large = ui.html("", sanitize=False).classes("w-full").props('data-at="large drawing"')
        bench.on_change(lambda _origin: self.follow())
        self.follow()

    def enlarge(self) -> None:
        """Show the drawing as large as the window."""
        self.large.set_content(self.drawing.content)
        self.dialog.open()

    def follow(self) -> None:
        """Show the drawing now, and ask for the facts."""
        machine = self.bench.reading.machine
        if machine is None:
            self.latest.number += (
                1  # what is under way is outdated; a drawing on its way is that of the last possible machine
            )
            self.busy.set_visibility(False)
            self.facts.classes(remove="old")
            if self.bench.text == EMPTY:
                self.pencil.number += 1
                self.drawing.set_content("")  # of the machine before, with which this one begins nothing
            self.drawing.classes(add="old")
            self.facts.set_content(f'<div class="wrong">{escape(self.bench.reading.message)}</div>')
            return
        self.busy.set_visibility(True)
        for shown in (self.drawing, self.facts):
            shown.classes(add="old")  # until the new one is there
        self.pencil.start(partial(_said, _drawing, machine), partial(self._later, self.drawing))
        self.latest.start(partial(_said, _facts, machine), partial(self._later, self.facts))

    def _later(self, target: Any, content: str) -> None:
        """Called in another thread."""
        if core.loop is not None:
            core.loop.call_soon_threadsafe(self._put, target, content)

    def _put(self, target: Any, content: str) -> None:
        possible = self.bench.reading.machine is not None
        if target.is_deleted or (target is self.facts and not possible):
            return
        with target:
            target.set_content(content)
            if possible:
                target.classes(remove="old")
            if target is self.facts:
                self.busy.set_visibility(False)


def _said(ask: Callable[[Any], str], machine: Any) -> str:
    """An answer, or what is wrong."""
    try:
        with unwarned():  # the facts have them as notes
            return ask(machine)
    except AutobalancerError as error:
        return f'<div class="wrong">{escape(str(error))}</div>'


def _drawing(machine: Any) -> str:
    return svg_of(
        lambda: machine_picture(machine, title=""), f"Drawing of {machine.name}: from the side and from above"
    )


def _facts(machine: Any) -> str:
    return facts_html(check(machine))


def facts_html(found: Any) -> str:
    """Rows and notes of what is known."""
    rows = "".join(f"<tr><td>{escape(name)}</td><td>{escape(text)}</td></tr>" for name, text in found.rows(rpm_and_si))
    notes = "".join(f'<div class="note">{escape(text)}</div>' for text in found.warnings)
    return f'<table class="facts">{rows}</table>{notes}'
