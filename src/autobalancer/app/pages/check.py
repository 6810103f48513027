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
from autobalancer.app.text.problems import drawable, for_page
from autobalancer.either_kind import check
from autobalancer.errors import AutobalancerError, unwarned
from autobalancer.shown import rpm_and_si
from autobalancer.sketch.machine import machine as machine_picture

POOL = ThreadPoolExecutor(1, thread_name_prefix="check")
PENCIL = ThreadPoolExecutor(1, thread_name_prefix="drawing")
WANTED = "The facts come when there is enough to know. Still wanted, or not possible yet:"
NEUTRAL = """<svg role="img" aria-label="a rotor on its springs, with balls in a race, not to scale" class="begun"
 viewBox="0 0 320 130">
<path d="M20 60H180M75 20H125V100H75ZM40 60v30m-8 0h16M160 60v30m-8 0h16" />
<path d="M36 90l8 6-8 6 8 6-8 6M156 90l8 6-8 6 8 6-8 6" />
<circle cx="255" cy="60" r="48" /><circle cx="255" cy="60" r="32" /><circle cx="255" cy="60" r="4" />
<circle cx="222" cy="83" r="8" class="ball" /><circle cx="226" cy="32" r="8" class="ball" />
<path d="M255 60L290 45" class="heavy" />
</svg>"""


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
            message = escape(self.bench.reading.message)
            if not self.bench.begun:
                self.drawing.classes(add="old")
                self.facts.set_content(f'<div class="wrong">{message}</div>')
                return
            self.facts.set_content(f'<div class="quiet">{WANTED}</div><div class="quiet told">{message}</div>')
            begun = drawable(self.bench.text)
            if begun is None:
                self.pencil.number += 1
                self.drawing.set_content(NEUTRAL)
                self.drawing.classes(remove="old")
            else:
                self.pencil.start(partial(_said, _drawing, begun), partial(self._later, self.drawing))
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
        possible = self.bench.reading.machine is not None or (target is self.drawing and self.bench.begun)
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
    rows = "".join(
        f"<tr><td>{escape(name)}</td><td>{escape(for_page(text))}</td></tr>" for name, text in found.rows(rpm_and_si)
    )
    notes = "".join(f'<div class="note">{escape(for_page(text))}</div>' for text in found.warnings)
    return f'<table class="facts">{rows}</table>{notes}'
