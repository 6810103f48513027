"""A measurement beside a run of the archive."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from typing import Any

import xarray as xr
from nicegui import ui

from autobalancer.app.pages.bench import Bench
from autobalancer.app.pages.hint import hinted
from autobalancer.app.pages.work import Work
from autobalancer.app.store.archive import Archive
from autobalancer.app.store.drawn import svg_of
from autobalancer.app.store.jobs import Job
from autobalancer.app.store.measured.beside import beside, drive_of, picture
from autobalancer.app.store.measured.looks import Asked, turning
from autobalancer.app.text.document import with_value
from autobalancer.errors import AutobalancerError
from autobalancer.results.signals.signals import Signals

RUNS = 60  # of the list


class Beside:
    """One run at a time."""

    def __init__(self, bench: Bench, asked: Callable[[], Asked]) -> None:
        self.bench, self.archive, self.asked = bench, Archive(bench.home), asked
        self.data: xr.Dataset | None = None
        ui.html("<h2>Beside a run</h2>", sanitize=False)
        with ui.row().classes("items-center gap-2 w-full"):
            self.run = ui.select({}, label="run of the archive").props("dense outlined options-dense")
            self.run.style("width: 380px").props('data-at="beside run"')
            ui.button("Put beside", on_click=self.ask).props('outline no-caps data-at="beside"')
            self.drive = ui.button("Take its speed as the drive", on_click=self.take).props(
                'flat no-caps data-at="take drive"'
            )
            hinted(
                self.drive,
                "the machine on the page Describe turns as was measured: drive.profile and start.rotor_angle",
            )
            self.work = Work(bench, "beside")
        self.out = ui.html("", sanitize=False).classes("w-full measured-picture").props('data-at="beside picture"')
        self.words = ui.html("", sanitize=False).classes("w-full").props('data-at="beside words"')

    def refresh(self) -> None:
        """Read the archive again."""
        runs = {one.name: f"{one.machine}, {one.made} UTC" for one in self.archive.entries()[:RUNS]}
        self.run.set_options(runs, value=self.run.value if self.run.value in runs else next(iter(runs), None))

    def show(self, data: xr.Dataset) -> None:
        """For another measurement."""
        self.data = data
        self.refresh()
        self.out.set_content("")
        self.words.set_content("")
        self.drive.set_visibility(isinstance(data, Signals) and turning(data))

    def ask(self) -> None:
        """Put the measurement beside the chosen run."""
        data, run, asked = self.data, self.run.value, Asked(**vars(self.asked()))
        if data is None:
            return
        if not run:
            ui.notify("there is no run yet; start one on the page Run", type="warning")
            return

        def work(job: Job) -> tuple[str, str]:
            found, note = beside(self.archive, run, data, asked, job)
            words = f'<pre class="said">{escape(found.told())}</pre>'
            said = f'<div class="note">{escape(note)}</div>' if note else ""
            return svg_of(
                picture(found), f"measured beside the run of {found.attrs.get('machine_name', '')}"
            ), words + said

        def then(job: Job) -> None:
            if data is not self.data or job.state == "cancelled":
                return
            wrong = f'<div class="wrong">{escape(job.message)}</div>'
            drawn, words = job.result if job.state == "done" else (wrong, "")
            self.out.set_content(drawn)
            self.words.set_content(words)

        self.work.start("put beside", work, then)

    def take(self) -> None:
        """Give the machine of the page the measured speed."""
        data, asked = self.data, Asked(**vars(self.asked()))

        def then(job: Job) -> None:
            if job.state != "done":
                ui.notify(job.message or job.state, type="warning")
                return
            profile, angle = job.result
            try:
                text: Any = with_value(self.bench.text, ("drive",), {"kind": "speed", "profile": profile})
                self.bench.set_text(with_value(text, ("start", "rotor_angle"), angle))
            except (AutobalancerError, ValueError) as error:
                ui.notify(str(error), type="warning")
                return
            ui.notify("the machine turns as was measured; undo brings its own drive back", type="positive")

        self.work.start("speed of a measurement", lambda _job: drive_of(data, asked), then)  # type: ignore[arg-type]
