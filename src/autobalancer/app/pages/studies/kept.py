"""The list of studies and designs: how far each is, and what can be done with it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from nicegui import ui

from autobalancer.app.pages.bench import Bench
from autobalancer.app.pages.hint import marked
from autobalancer.app.store.jobs import Job
from autobalancer.app.store.studies.shelf import Kept, Studies
from autobalancer.app.store.studies.work import how_far, time_text
from autobalancer.errors import AutobalancerError

SHOWN = 60  # entries of the list


@dataclass
class Line:
    """What is shown of one; word and bar change while it waits or runs."""

    entry: Kept
    job: Job | None
    row: Any
    word: Any = None
    bar: Any = None


class KeptList:
    """Reads the folder and the queue; ``open`` and ``resume`` are called with a name."""

    def __init__(
        self, bench: Bench, shelf: Studies, open_: Callable[[str], None], resume: Callable[[str], None]
    ) -> None:
        self.bench, self.shelf, self.open, self.resume = bench, shelf, open_, resume
        self.lines: dict[str, Line] = {}
        ui.html("<h2>Kept studies and designs</h2>", sanitize=False)
        self.list = ui.column().classes("w-full gap-0").props('data-at="kept studies"')
        self.none = ui.label("Nothing yet; define a study above and start it.").classes("quiet")
        self.timer = ui.timer(0.5, self.look)

    def seen(self, now: bool) -> None:
        """Whether somebody looks."""
        self.timer.active = now
        if now:
            self.refresh()

    def refresh(self) -> None:
        """Read the folder again; lines that are right stay under the hand of whoever uses them."""
        going = self._going()
        wanted = {entry.name: entry for entry in self.shelf.entries()[:SHOWN]}
        for name, line in [*self.lines.items()]:
            if wanted.get(name) != line.entry or going.get(name) is not line.job:
                line.row.delete()
                del self.lines[name]
        for place, entry in enumerate(wanted.values()):
            if entry.name not in self.lines:
                with self.list:
                    line = self.lines[entry.name] = self._line(entry, going.get(entry.name))
                line.row.move(target_index=place)
        self.none.set_visibility(not wanted)

    def _going(self) -> dict[str, Job]:
        """Those that wait or run."""
        return {job.title: job for job in self.bench.long.of(self.bench.user) if not job.over}

    def look(self) -> None:
        """Say how far those are that wait or run."""
        going = self._going()
        shown = {name: line.job for name, line in self.lines.items() if line.job is not None}
        if set(going) != set(shown) or any(shown[name] is not job for name, job in going.items()):
            self.refresh()  # another page of the user may have started or deleted some
        for name, line in self.lines.items():
            if line.job is not None and name in going:
                line.word.set_text(state_of(line.job))
                line.bar.value = line.job.share

    def _line(self, entry: Kept, job: Job | None) -> Line:
        row = marked(ui.row().classes("items-center gap-2 w-full no-wrap archive-line"), at=entry.name)
        line = Line(entry, job, row)
        with row:
            with ui.column().classes("gap-0").style("flex: 1 1 auto; min-width: 0"):
                ui.label(entry.title).classes("key ellipsis")
                line.word = ui.label(state_of(job) if job is not None else self._rests(entry)).classes("quiet ellipsis")
                line.word.props('data-at="kept state"')
            if job is not None:
                line.bar = ui.linear_progress(job.share, show_value=False).style("flex: 0 1 200px; min-width: 60px")
                marked(line.bar.props("rounded"), label=f"progress of {entry.title}")
                cancel = ui.button("Cancel", icon="stop", on_click=lambda: self.bench.long.cancel(job))
                cancel.props('flat dense no-caps data-at="cancel study"')
            elif not entry.finished:
                again = ui.button("Resume", icon="play_arrow", on_click=lambda: self.resume(entry.name))
                marked(again.props("flat dense no-caps"), at="resume study", label=f"resume {entry.title}")
            opens = ui.button("open", on_click=lambda: self.open(entry.name)).props("flat dense no-caps")
            marked(opens, label=f"open {entry.title}")
            if job is None:
                bin_ = ui.button(icon="delete_outline", on_click=lambda: self._delete(entry)).props("flat dense round")
                marked(bin_, label=f"delete {entry.title}")
        return line

    def _rests(self, entry: Kept) -> str:
        """What is known of one that does not run."""
        made = f"{entry.kind} of {entry.machine} · {entry.made} UTC"
        if entry.finished:
            return f"{made} · finished in {time_text(entry.seconds)}"
        part = how_far(self.shelf, entry)
        return f"{made} · {entry.message or 'interrupted'}{f', {part} are kept' if part else ''}"

    def _delete(self, entry: Kept) -> None:
        with ui.dialog(value=True) as dialog, ui.card():
            ui.label(f"Delete {entry.title} of {entry.made} with all its parts? They cannot be brought back.")

            def gone() -> None:
                dialog.close()
                if any(job.title == entry.name and not job.over for job in self.bench.long.of(self.bench.user)):
                    ui.notify("it runs; cancel it first", type="warning")
                    return
                try:
                    self.shelf.delete(entry.name)
                except (AutobalancerError, OSError) as error:
                    ui.notify(str(error), type="warning")
                self.refresh()

            with ui.row():
                ui.button("Delete", on_click=gone).props("no-caps color=negative")
                ui.button("Keep", on_click=dialog.close).props("no-caps flat")


def state_of(job: Job) -> str:
    """How far a job is."""
    if job.state == "waiting":
        return "waits for its turn"
    return f"{100.0 * job.share:.0f} % · {job.result if job.result is not None else 'begins'}"
