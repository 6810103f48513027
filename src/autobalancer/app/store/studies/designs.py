"""A design in the background: candidates that ran so far, the answer, machines and reports of those that were chosen."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from html import escape
from typing import Any

from autobalancer.app.store.archive import FILES
from autobalancer.app.store.jobs import Job
from autobalancer.app.store.studies.pictures import said
from autobalancer.app.store.studies.shelf import DESIGN, PARTS, RESULT, Studies
from autobalancer.app.store.studies.work import Told, result_of, stopped_is_noted
from autobalancer.errors import QuestionError, ResultError
from autobalancer.files.machine_file import load_race_machine, machine_text
from autobalancer.plots.studies.design import design as design_picture
from autobalancer.reporting.report import report
from autobalancer.results.answers.studied import Studied
from autobalancer.results.store import load_run, save_run
from autobalancer.studies.design.answer import Designed
from autobalancer.studies.design.chosen import designed_machine
from autobalancer.studies.design.design import design

SO_FAR = "so_far.nc"  # what was known when a candidate had run
STARTS = 40  # of the report on the page


@dataclass
class Searched(Told):
    """How far a design has come, and what is known so far."""

    found: Designed | None = None

    def __str__(self) -> str:
        """In words."""
        if not self.done:
            return "candidates are screened by closed forms and exact borders"
        return super().__str__().replace("members", "runs")


def run_design(shelf: Studies, name: str, job: Job) -> str:
    """Search a design, or go on with one; finished runs are on the disk at any time.

    Raises
    ------
    KeyboardInterrupt
        If it is cancelled or reaches its time limit; the same call goes on.
    QuestionError
        If no candidate is left, or it cannot be run.
    """
    entry, told = shelf.entry(name), Searched()
    job.result = told

    def progress(done: int, total: int) -> None:
        if done and entry.total != total:
            entry.total = total
            shelf.note(entry)
        told.told(done, total)
        job.progress(done, total)

    def seen(found: Designed) -> None:
        with FILES, contextlib.suppress(ResultError):  # it is on the page in any case
            save_run(found, shelf.folder(name) / SO_FAR)
        told.found = found

    with stopped_is_noted(shelf, entry, job):
        asked = shelf.file(name, entry.file)
        found = design(asked, folder=shelf.folder(name) / PARTS, progress=progress, seen=seen)
        with FILES:
            save_run(found, shelf.folder(name) / RESULT)
        entry.finished = True
    return name


def design_of(shelf: Studies, name: str, job: Job | None) -> Designed | None:
    """The answer of a design, or what is known so far, also of one that was interrupted.

    Raises
    ------
    ResultError
        If a file is damaged.
    """
    told = job.result if job is not None else None
    files = [shelf.folder(name) / file for file in (RESULT, SO_FAR)]
    if not files[0].is_file() and isinstance(told, Searched) and told.found is not None:
        return told.found
    for path in files:
        if path.is_file():
            with FILES:
                found = load_run(path)
            return found if isinstance(found, Designed) else None
    return None


def design_drawn(found: Designed) -> tuple[Callable[[], Any], str]:
    """The Pareto front, and its words."""
    return lambda: design_picture(found), said(
        f"{found.heading()}: the two objectives of each design", found.columns("rpm")
    )


def places(found: Designed) -> dict[int, str]:
    """The designs that ran, the best first."""
    best = found.best()
    return {place: f"{place}: {label}" for place, label in enumerate(map(str, best["label"].values), start=1)}


def chosen_text(found: Designed, place: int) -> str:
    """The machine file of a design.

    Raises
    ------
    QuestionError
        If no design has this place.
    """
    return machine_text(designed_machine(found, place))


def reasons_html(found: Designed) -> str:
    """What was ruled out and why."""
    texts = found.reasons()
    if not texts:
        return ""
    rows = "".join(f"<li>{escape(text)}</li>" for text in texts)
    return f'<h3>Ruled out, and why</h3><ul class="reasons" data-at="ruled out">{rows}</ul>'


def write_report(shelf: Studies, name: str, place: int, form: str, job: Job) -> str:
    """The report of a design, or of the machine of a study with the study; gives the name of its file.

    Raises
    ------
    QuestionError
        If it is not finished, or what a report needs is not installed.
    """
    found: Any = result_of(shelf, name)
    if shelf.entry(name).kind == DESIGN:
        machine, file = designed_machine(found, place), f"report_{place}.{form}"
    elif isinstance(found, Studied):
        machine, file = load_race_machine(shelf.file(name, "machine.toml")), f"report_0.{form}"
    else:
        raise QuestionError(f"study {name}: has no result of which a report is made")
    report(machine, shelf.folder(name) / file, study=found, starts=STARTS, progress=job.progress)
    return file
