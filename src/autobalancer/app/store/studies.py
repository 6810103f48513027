"""Studies and designs of a user: their files, runs that can be resumed, tables and pictures of what came out."""

from __future__ import annotations

import contextlib
import math
import re
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.api import design
from autobalancer.app.store.jobs import Job
from autobalancer.errors import QuestionError, ResultError
from autobalancer.files.machine_file import machine_text
from autobalancer.files.samples import example_path, sample_names
from autobalancer.plots.studies import design as design_picture
from autobalancer.plots.studies import envelopes as envelopes_picture
from autobalancer.plots.studies import rest_positions
from autobalancer.plots.studies import sensitivity as sensitivity_picture
from autobalancer.plots.studies import study as study_picture
from autobalancer.results.answers.studied import Studied
from autobalancer.results.folder_store import Shelf, part_files, read_part
from autobalancer.results.store import load_run, save_run
from autobalancer.safe_file import write_safely, write_text_safely
from autobalancer.studies.design.design import RUNS
from autobalancer.studies.design.designs import Designed, designed_machine
from autobalancer.studies.study.chunk import study_dataset
from autobalancer.studies.study.study import envelopes, sensitivity, study
from autobalancer.studies.study.study_file import read_study
from autobalancer.tables import Column

# The studies and designs of a user, each in a folder of its own: what was asked, its machine, finished parts, result.
#
# Whatever happens to the server, the finished parts are there, and the same study goes on with the same bits.


STUDY, DESIGN = "study", "design"
MOST, ROOM = 200, 4_000_000_000  # of one user, and their bytes
RESULT, PARTS = "result.nc", "parts"
RESULT_FILES = re.compile(r"result\.nc|report_\d{1,4}\.(?:html|pdf)")  # files beside the texts


@dataclass
class StudyEntry:
    """What a list shows of a study or a design."""

    name: str
    kind: str  # study or design
    title: str
    machine: str
    machine_file: str
    made: str
    total: int = 0  # members of a study, runs of a design; at most, and 0 while it is not known
    seconds: float = 0.0  # that it worked, in all
    finished: bool = False
    message: str = ""  # why it stopped
    notes: list[str] = field(default_factory=list)
    more: list[str] = field(default_factory=list)  # other files that it names

    @property
    def file(self) -> str:
        """The name of its text."""
        return f"{self.kind}.toml"

    @property
    def command(self) -> str:
        """The command that does the same."""
        return f"autobalancer {self.kind} {self.file}"


class Studies(Shelf[StudyEntry]):
    """All studies and designs below the folder of a user."""

    def __init__(self, home: Path) -> None:
        super().__init__(home / "studies", StudyEntry, "study")

    def add(self, entry: StudyEntry, text: str, machine: str, more: dict[str, bytes] | None = None) -> str:
        """Keep what is asked, with the text of its machine and other files that it names; gives its name.

        Raises
        ------
        QuestionError
            If there are too many, or they take too much room.
        """
        there = [path.stat().st_size for path in self.home.rglob("*") if path.is_file()]
        if len(self) >= MOST or sum(there) > ROOM:
            raise QuestionError("too many studies are kept already; delete some of them first")
        folder = self.new()
        entry.name, entry.made = folder.name, f"{datetime.now(UTC):%Y-%m-%d %H:%M:%S}"
        write_text_safely(folder / entry.file, text)
        if machine:
            write_text_safely(folder / entry.machine_file, machine)
        for file, content in (more or {}).items():
            write_safely(folder / file, lambda path, content=content: path.write_bytes(content))  # type: ignore[misc]
        entry.more = list(more or {})
        self.note(entry)
        return entry.name

    def text(self, name: str) -> str:
        """The study or the specification as it was asked."""
        return (self.folder(name) / self.entry(name).file).read_text(encoding="utf-8")

    def file(self, name: str, kind: str) -> Path:
        """A file of a study or design: its text, its machine, its result, a report.

        Raises
        ------
        QuestionError
            If there is no such file.
        """
        entry = self.entry(name)
        known = kind in (entry.file, "machine.toml", *entry.more) or RESULT_FILES.fullmatch(kind)
        path = self.folder(name) / (entry.machine_file if kind == "machine.toml" else kind)
        if not known or not path.is_file():
            raise QuestionError(f"study {name}: has no {kind[:20]!r}")
        return path


def sample_text(name: str) -> str:
    """The text of a study or design that comes with the package.

    Raises
    ------
    QuestionError
        If there is none of this name.
    """
    if name not in (*sample_names("studies"), *sample_names("designs")):
        raise QuestionError(f"{name[:40]!r}: no such sample")
    return example_path(name).read_text(encoding="utf-8")


# A study in the background: its progress with the time to go, what is known so far, and going on where it stopped.


FEWEST = 2.0  # s of work before a time to go is said
TRUE_OR_FALSE = ("balanced", "stalled", "balanced_before")
FIRST = ("balanced", "stalled", "peak_deflection", "settling_time", "residual_unbalance", "vibration")


@dataclass
class StudyProgress:
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
    entry, told = shelf.entry(name), StudyProgress()
    job.result = told

    def progress(done: int, total: int) -> None:
        told.told(done, total)
        job.progress(done, total)

    with stopped_is_noted(shelf, entry, job):
        found = study(shelf.file(name, entry.file), folder=shelf.folder(name) / PARTS, progress=progress)
        save_run(found, shelf.folder(name) / RESULT)
        entry.finished = True
    return name


class stopped_is_noted:
    """Keeps in the entry of a study or design how long it worked, and why it stopped."""

    def __init__(self, shelf: Studies, entry: StudyEntry, job: Job) -> None:
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
        for span, path in part_files(self.shelf.folder(self.name) / PARTS).items():
            if span not in self._parts:
                self._parts[span] = read_part(path)
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
    return load_run(path)


def done_of(shelf: Studies, name: str) -> int:
    """How many members of a study, or runs of a design, are on the disk."""
    parts = shelf.folder(name) / PARTS
    return sum(last - first for one in (parts, *parts.glob(f"{RUNS}/*")) for first, last in part_files(one))


def progress_text(shelf: Studies, entry: StudyEntry) -> str:
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
    return Studied.of(numbers).columns("rpm")


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


# A design in the background: candidates that ran so far, the answer, machines and reports of those that were chosen.


SO_FAR = "so_far.nc"  # what was known when a candidate had run


@dataclass
class Searched(StudyProgress):
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
        with contextlib.suppress(ResultError):  # it is on the page in any case
            save_run(found, shelf.folder(name) / SO_FAR)
        told.found = found

    with stopped_is_noted(shelf, entry, job):
        asked = shelf.file(name, entry.file)
        found = design(asked, folder=shelf.folder(name) / PARTS, progress=progress, seen=seen)
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
            found = load_run(path)
            return found if isinstance(found, Designed) else None
    return None


def design_figure(found: Designed) -> tuple[Callable[[], Any], str]:
    """The Pareto front, and its words."""
    return lambda: design_picture(found), table_text(
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


# Pictures of a study with their words, for those who do not see them: the package's own plots.


OVER, RESTS, DRIVES, FAN = "over", "rests", "drives", "fan"
WORDS = {OVER: "over the grid", RESTS: "rest positions", DRIVES: "what drives it", FAN: "fan of run-ups"}
FAN_RUNS = 60
SAID = 12  # rows of a table that the words of a picture repeat

FigureAndText = tuple[Callable[[], Any], str]  # draws a figure; says what it shows


def offered(found: Studied) -> dict[str, str]:
    """Which pictures there are of a study."""
    grid = bool(found.grid_names())
    known = {OVER: WORDS[OVER] if grid else "distribution"}
    if "ball_angle_to_unbalance" in found:
        known[RESTS] = WORDS[RESTS]
    if [name for name in np.atleast_1d(found.attrs.get("inputs", [])) if str(name) != "start"] or (
        found.attrs.get("plan") == "sensitivity"
    ):
        known[DRIVES] = WORDS[DRIVES]
    if "balanced" in found and not found.sudden:
        known[FAN] = WORDS[FAN]
    return known


def study_figure(
    shelf: Studies, name: str, found: Studied, kind: str, quantity: str, point: int, job: Job
) -> FigureAndText:
    """A picture of a study, ready to be drawn.

    Raises
    ------
    QuestionError
        If the study has no such picture, in the words of the package.
    """
    if kind == RESTS:
        return lambda: rest_positions(found), _rests(found)
    if kind == DRIVES:
        driven = sensitivity(found, quantity)
        return lambda: sensitivity_picture(driven, point=point), table_text(driven.heading(), driven.columns())
    if kind == FAN:
        asked = shelf.file(name, shelf.entry(name).file)
        fan = envelopes(asked, members=FAN_RUNS, point=point, progress=job.progress)
        return lambda: envelopes_picture(fan), table_text(str(fan.attrs["title"]), _some_rows(fan.columns("rpm")))
    return lambda: study_picture(found, quantity), table_text(
        f"{found.heading()}: {quantity.replace('_', ' ')}", columns_of(found, quantity)
    )


def table_text(title: str, columns: list[Column]) -> str:
    """A table in words."""
    cells = [[f"{column.head} {cell} {column.unit}".strip() for cell in column.cells()] for column in columns]
    rows = [", ".join(row) for row in zip(*cells, strict=True)]
    more = f"; and {len(rows) - SAID} more" if len(rows) > SAID else ""
    return f"{title}. {'; '.join(rows[:SAID])}{more}"


def _some_rows(columns: list[Column]) -> list[Column]:
    """A few rows of a long table."""
    count = max((len(column.values) for column in columns), default=0)
    rows = np.unique(np.linspace(0, count - 1, min(count, SAID)).astype(int))
    return [Column(one.head, [one.values[row] for row in rows], one.unit, one.form) for one in columns]


def _rests(found: Studied) -> str:
    """Of each point, how many balls end within 15 degrees of where."""
    texts = found.point_texts("rpm")
    parts = []
    for where, text in zip(found.at_points(), texts, strict=True):
        angles = np.degrees(found["ball_angle_to_unbalance"].values[where & found.counted()])
        known = angles[np.isfinite(angles)] % 360.0
        if known.size:
            counts = np.bincount(((known + 15.0) // 30.0).astype(int) % 12, minlength=12)
            best = int(counts.argmax())
            parts.append(
                f"{text or 'all'}: most balls, {100.0 * counts[best] / known.size:.0f} %, near {30 * best} degrees"
            )
    return f"{found.heading()}: places of the balls at the end, counted from the unbalance. {'; '.join(parts[:SAID])}"
