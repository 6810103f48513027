"""A line of the page that shows one job: its word, its bar, its end."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nicegui import ui

from autobalancer.app.pages.bench import Bench
from autobalancer.app.pages.hint import marked
from autobalancer.app.store.jobs import Job
from autobalancer.errors import AutobalancerError


class Work:
    """Starts jobs one after the other and says how far the latest is; an older one ends when a newer is started."""

    def __init__(self, bench: Bench, at: str, word: Callable[[Job], str] | None = None) -> None:
        self.bench, self.word = bench, word
        self.job: Job | None = None
        self.then: Callable[[Job], None] = lambda _job: None
        with ui.row().classes("items-center gap-2") as self.line:
            self.spinner = ui.spinner(size="1.1em")
            self.said = marked(ui.label().classes("quiet").props('role="status"'), at=f"{at} state")
            self.cancel = ui.button("Cancel", icon="stop", on_click=self.end).props("flat dense no-caps")
            marked(self.cancel, at=f"{at} cancel")
        self.timer = ui.timer(0.15, self.look, active=False)
        self._rest()

    def start(self, title: str, work: Callable[[Job], Any], then: Callable[[Job], None]) -> None:
        """Put work into the queue; ``then`` is called on the page when it is over, whatever came of it."""
        self.end()
        try:
            self.watch(self.bench.jobs.start(self.bench.user, title, work), then)
        except AutobalancerError as error:
            ui.notify(str(error), type="warning")

    def watch(self, job: Job, then: Callable[[Job], None]) -> None:
        """Follow a job, also one that was started before the page was opened."""
        self.job, self.then = job, then
        for one in (self.spinner, self.cancel):
            one.set_visibility(True)
        self.timer.activate()
        self.look()

    def end(self) -> None:
        """Cancel what is under way."""
        if self.job is not None:
            self.bench.jobs.cancel(self.job)

    def look(self) -> None:
        """Say how far the job is."""
        job = self.job
        if job is None:
            return
        said = self.word(job) if self.word is not None else f"{100.0 * job.share:.0f} %" if job.share else "working"
        self.said.set_text("waits for its turn" if job.state == "waiting" else said)
        if not job.over:
            return
        self.job = None
        self._rest()
        self.said.set_text({"failed": "", "cancelled": job.message or "cancelled"}.get(job.state, ""))
        self.then(job)

    def _rest(self) -> None:
        self.timer.deactivate()
        for one in (self.spinner, self.cancel):
            one.set_visibility(False)
