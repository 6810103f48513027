"""The page Stability: one analysis beside the other, and the report."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any

from nicegui import core, ui

from autobalancer.app.pages.bench import Bench
from autobalancer.app.pages.hint import hinted, marked
from autobalancer.app.pages.stability.moved_point import MapPanel
from autobalancer.app.pages.stability.panel import Panel
from autobalancer.app.pages.work import Work
from autobalancer.app.store.analyses import ANALYSES, report_file
from autobalancer.app.store.jobs import Job, Latest
from autobalancer.app.store.known import Known, known_of, why_not_at_all
from autobalancer.app.store.latest import LatestAnswers
from autobalancer.errors import AutobalancerError, unwarned
from autobalancer.machine import Machine

FACTS = ThreadPoolExecutor(1, thread_name_prefix="facts")
REPORT = "report "
FORMS = ("pdf", "html")
LOOK = Path(__file__).with_name("look.css")


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
        why = why_not_at_all(machine)
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
            if core.loop is not None:
                known, wrong = (None, found) if isinstance(found, str) else (found, "")
                core.loop.call_soon_threadsafe(self._fill, known, wrong)

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
            button = ui.button(form.upper(), on_click=partial(self._report, form))
            marked(button.props("outline dense no-caps"), at=f"report.{form}", label=f"report as {form.upper()}")
            hinted(button, "drawing, facts, borders, run-up, basin and 40 random starts of this machine in one file")
        self.made = ui.row().classes("items-center gap-2")
        going = [job for job in self.bench.jobs.of(self.bench.user) if not job.over and job.title.startswith(REPORT)]
        if going:
            self.report.watch(going[0], self._reported)
        self._offer()

    def _offer(self) -> None:
        """Links to the reports that were made."""
        self.made.clear()
        with self.made:
            for form in FORMS:
                path = self.bench.home / "reports" / f"report.{form}"
                if path.is_file():
                    made = datetime.fromtimestamp(path.stat().st_mtime, UTC)
                    link = ui.button(f"{form.upper()} of {made:%H:%M} UTC", on_click=partial(ui.download, path))
                    hinted(link.props("flat dense no-caps size=sm"), f"made on {made:%Y-%m-%d}")
                    marked(link, at=f"made.{form}")

    def _report(self, form: str) -> None:
        machine = self.bench.reading.machine
        if not isinstance(machine, Machine):
            ui.notify(f"a report {why_not_at_all(machine)}", type="warning")
            return
        path = self.bench.home / "reports" / f"report.{form}"

        def work(job: Job) -> str:
            report_file(machine, path, job.progress)
            return form

        self.report.start(f"{REPORT}{machine.name}", work, self._reported)

    def _reported(self, job: Job) -> None:
        if job.state == "failed":
            ui.notify(f"no report: {job.message}", type="warning", multi_line=True, timeout=10000)
        elif job.state == "done":
            self._offer()
            ui.download(self.bench.home / "reports" / f"report.{job.result}")
