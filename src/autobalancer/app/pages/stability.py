"""Stability: the map over speed and viscosity, natural frequencies, unbalance response, and the report."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from html import escape
from typing import Any

from nicegui import core, ui

from autobalancer.app.pages.bench import Bench
from autobalancer.app.pages.check import PENCIL
from autobalancer.app.store.analyses import campbell_of, map_of, report_file, response_of
from autobalancer.app.store.drawn import ONE, svg_of
from autobalancer.app.store.jobs import Job, Latest
from autobalancer.errors import AutobalancerError
from autobalancer.machine import Machine

ASKED: dict[str, tuple[str, Callable[[Machine], Callable[[], Any]]]] = {
    "map": ("Stability map", map_of),
    "campbell": ("Campbell diagram", campbell_of),
    "response": ("Unbalance response", response_of),
}


class StabilityPage:
    """One picture at a time, worked out when it is asked for."""

    def __init__(self, bench: Bench) -> None:
        self.bench, self.latest = bench, Latest(PENCIL)
        with ui.element("section").classes("card"), ui.row().classes("items-center gap-2 w-full"):
            for name, (title, _) in ASKED.items():
                ui.button(title, on_click=partial(self.ask, name)).props(f'outline no-caps data-at="ask {name}"')
            self.busy = ui.spinner(size="1.2em")
            ui.space()
            for form in ("pdf", "html"):
                button = ui.button(f"Report ({form.upper()})", icon="description")
                button.props(f'outline no-caps data-at="report.{form}"').on_click(partial(self._report, form))
            self.word = ui.label().classes("quiet").props('role="status"')
        with ui.element("section").classes("card") as self.card:
            self.picture = ui.html("", sanitize=False).classes("w-full tall-picture").props('data-at="analysis"')
        self.card.set_visibility(False)
        self.busy.set_visibility(False)

    def ask(self, name: str) -> None:
        """Work a picture out in the background and show it."""
        machine = self.bench.reading.machine
        if not isinstance(machine, Machine):
            ui.notify("these pictures are for a possible machine with balls in races", type="warning")
            return
        self.card.set_visibility(True)
        self._draw(ASKED[name][0], partial(ASKED[name][1], machine), machine)

    def _draw(self, title: str, make: Callable[[], Callable[[], Any]], machine: Machine) -> None:
        self.busy.set_visibility(True)

        def work() -> str:
            try:
                return svg_of(make(), f"{title} of {machine.name}")
            except AutobalancerError as error:
                return f'<div class="wrong">{escape(str(error))}</div>'

        def then(content: str) -> None:
            if core.loop is not None:
                core.loop.call_soon_threadsafe(self._put, content)

        self.latest.start(work, then)

    def _put(self, content: str) -> None:
        if not self.picture.is_deleted:
            with self.picture:
                self.picture.set_content(content)
                self.busy.set_visibility(False)

    def _report(self, form: str) -> None:
        machine = self.bench.reading.machine
        if not isinstance(machine, Machine):
            ui.notify("a report is for a possible machine with balls in races", type="warning")
            return
        path = self.bench.home / "reports" / f"report.{form}"

        def work(job: Job) -> str:
            with ONE:  # its pictures are Matplotlib's
                report_file(machine, path, job.progress)
            return path.name

        try:
            job = self.bench.jobs.start(self.bench.user, f"report {machine.name}", work)
        except AutobalancerError as error:
            ui.notify(str(error), type="warning")
            return

        def look() -> None:
            self.word.set_text(f"report: {100.0 * job.share:.0f} %")
            if job.over:
                timer.deactivate()
                self.word.set_text("the report is made" if job.state == "done" else job.message or job.state)
                if job.state == "done":
                    ui.download(path)

        timer = ui.timer(0.3, look)
