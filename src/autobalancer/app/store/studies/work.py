"""A study in the background: its progress with the time to go, what is known so far, and going on where it stopped."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.app.store.archive import FILES
from autobalancer.app.store.jobs import Job
from autobalancer.app.store.studies.shelf import PARTS, RESULT, STUDY, Kept, Studies
from autobalancer.errors import QuestionError
from autobalancer.results.answers.studied import Studied
from autobalancer.results.shares import wilson_interval
from autobalancer.results.store import load_run, save_run
from autobalancer.shown import Column
from autobalancer.studies.design.design import RUNS
from autobalancer.studies.study.dataset import study_dataset
from autobalancer.studies.study.reading import read_study
from autobalancer.studies.study.store import finished, read_chunk
from autobalancer.studies.study.study import study

FEWEST = 2.0  # s of work before a time to go is said
TRUE_OR_FALSE = ("balanced", "stalled", "balanced_before")
ENDS = ("95 % from", "95 % to")
FIRST = ("balanced", "stalled", "peak_deflection", "settling_time", "residual_unbalance", "vibration")


@dataclass
class Told:
    """How far a study has come."""

    done: int = 0
    total: int = 0
    begun: float = field(default_factory=time.monotonic)
    first: int = -1  # members that were there when it began

    def told(self, done: int, total: int) -> None:
        """Note how many of how many are done."""
        if self.first < 0:
            self.first, self.begun = done, time.monotonic()
        self.done, self.total = done, total

    @property
    def left(self) -> float:
        """Seconds to go, as fast as so far; nan while that is not known."""
        now = time.monotonic() - self.begun
        if now < FEWEST or self.done <= self.first:
            return math.nan
        return now / (self.done - self.first) * (self.total - self.done)

    def __str__(self) -> str:
        """In words."""
        if not self.total:
            return "checks and compiles"
        said = f"{self.done} of {self.total} members"
        return said if math.isnan(self.left) else f"{said}, {time_text(self.left)} to go"


def time_text(seconds: float) -> str:
    """A time as people say it."""
    if seconds < 90.0:
        return f"{max(seconds, 1.0):.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 5400.0 else f"{seconds / 3600.0:.1f} h"


def run_study(shelf: Studies, name: str, job: Job) -> str:
    """Run a study, or go on with one; finished members are on the disk at any time.

    Raises
    ------
    KeyboardInterrupt
        If it is cancelled or reaches its time limit; the same call goes on.
    QuestionError
        If it cannot be run.
    """
    entry, told = shelf.entry(name), Told()
    job.result = told

    def progress(done: int, total: int) -> None:
        told.told(done, total)
        job.progress(done, total)

    with stopped_is_noted(shelf, entry, job):
        found = study(shelf.file(name, entry.file), folder=shelf.folder(name) / PARTS, progress=progress)
        with FILES:
            save_run(found, shelf.folder(name) / RESULT)
        entry.finished = True
    return name


class stopped_is_noted:
    """Keeps in the entry of a study or design how long it worked, and why it stopped."""

    def __init__(self, shelf: Studies, entry: Kept, job: Job) -> None:
        self.shelf, self.entry, self.job = shelf, entry, job

    def __enter__(self) -> None:
        self.begun = time.monotonic()
        self.entry.message = ""  # whoever finds it after a crash is told that it was interrupted
        self.shelf.note(self.entry)

    def __exit__(self, kind: Any, error: Any, _trace: Any) -> None:
        self.entry.seconds += time.monotonic() - self.begun
        if kind is not None:
            self.entry.message = self.job.message or ("cancelled" if kind is KeyboardInterrupt else str(error))
            self.entry.message = self.entry.message.replace(f"{self.shelf.folder(self.entry.name)}/", "")
        self.entry.notes = list(dict.fromkeys([*self.entry.notes, *self.job.notes]))
        self.shelf.note(self.entry)


class Known:
    """What is known of one study so far; each part is read once."""

    def __init__(self, shelf: Studies, name: str) -> None:
        self.shelf, self.name = shelf, name
        self._parts: dict[tuple[int, int], Any] = {}
        self._asked: Any = None
        self._whole: xr.Dataset | None = None

    def look(self) -> Studied | None:
        """The result, or that of the parts that are finished; ``None`` before the first.

        Raises
        ------
        QuestionError
            If there is no such study.
        ResultError
            If a file is damaged.
        """
        if self._whole is None and (self.shelf.folder(self.name) / RESULT).is_file():
            self._whole = result_of(self.shelf, self.name)
        if isinstance(self._whole, Studied):
            return self._whole
        for span, path in finished(self.shelf.folder(self.name) / PARTS).items():
            if span not in self._parts:
                self._parts[span] = read_chunk(path)
        if not self._parts:
            return None
        if self._asked is None:
            self._asked = read_study(self.shelf.file(self.name, f"{STUDY}.toml"))
        return Studied.of(study_dataset(self._asked, self._parts, self._asked.count))


def result_of(shelf: Studies, name: str) -> xr.Dataset:
    """The result of a finished study or design.

    Raises
    ------
    QuestionError
        If there is none yet.
    """
    path = shelf.folder(name) / RESULT
    if not path.is_file():
        raise QuestionError(f"study {name}: is not finished")
    with FILES:
        return load_run(path)


def done_of(shelf: Studies, name: str) -> int:
    """How many members of a study, or runs of a design, are on the disk."""
    parts = shelf.folder(name) / PARTS
    return sum(last - first for one in (parts, *parts.glob(f"{RUNS}/*")) for first, last in finished(one))


def how_far(shelf: Studies, entry: Kept) -> str:
    """How much of one that does not run is finished; empty where that is not known."""
    word = "members" if entry.kind == STUDY else "runs"
    try:
        return f"{done_of(shelf, entry.name)} of {entry.total} {word}" if entry.total else ""
    except QuestionError:  # it was deleted meanwhile
        return ""


def columns_of(found: Studied, quantity: str) -> list[Column]:
    """A row for each point of the grid: members, shares with their intervals, and percentiles of a quantity."""
    asked = np.atleast_1d(found.attrs.get("show", [])).astype(str).tolist()
    wanted = [name for name in (quantity, *asked) if name and name not in TRUE_OR_FALSE]
    numbers = found.assign_attrs(show=list(dict.fromkeys(wanted)))
    columns = Studied.of(numbers).columns("rpm")
    if "stalled" not in found:
        return columns
    at = next(k for k, column in enumerate(columns) if column.head == "members") + 1
    here = [where & found.counted() for where in found.at_points()]
    totals = np.array([max(int(where.sum()), 1) for where in here])
    counts = np.array([int((found["stalled"].values.astype(bool) & where).sum()) for where in here])
    parts = (("stall", counts / totals), *zip(ENDS, wilson_interval(counts, totals), strict=True))
    return [*columns[:at], *(Column(head, 100.0 * share, "%", ".2f") for head, share in parts), *columns[at:]]


def quantities_of(found: xr.Dataset) -> dict[str, str]:
    """What of a study can be drawn over its grid: names and their meaning; what no member has is left out."""
    known = {}
    for name in map(str, found.data_vars):
        values = found[name]
        if values.dims != ("member",) or values.dtype.kind not in "fib" or name in ("steps", "drawn_again"):
            continue
        if values.dtype.kind != "f" or bool(values.notnull().any()):
            known[name] = name.replace("_", " ")
    return dict(sorted(known.items(), key=lambda one: FIRST.index(one[0]) if one[0] in FIRST else len(FIRST)))
