"""The runs of a user, each in a folder of its own: machine, result, measures, and what the page draws."""

from __future__ import annotations

import csv
import io
import json
import math
import re
import shutil
import time
import tomllib
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import xarray as xr

from autobalancer.api import run_measures, simulate, verdict
from autobalancer.app.store.jobs import Job
from autobalancer.app.store.pictures import file_of
from autobalancer.app.view.packed import packed
from autobalancer.errors import AutobalancerError, QuestionError, ResultError
from autobalancer.files.machine_file import parse_machine
from autobalancer.machine_kinds import machine_kind
from autobalancer.plots.film_frames import animate
from autobalancer.plots.style import DRAWING
from autobalancer.results.folder_store import Shelf
from autobalancer.results.store import load_run, save_run
from autobalancer.safe_file import write_safely, write_text_safely
from autobalancer.simulation import held_run

MOST = 2000  # runs of one user
UNREADABLE = "cannot be shown"
STARTED = time.time()
LONGEST = 3600.0  # s, in which a run that has its folder has its note, too
TAG = 40  # characters of a tag
EACH = 16  # balls with a measure of their own


@dataclass
class Entry:
    """What a list of runs shows of one."""

    name: str
    machine: str
    made: str
    seconds: float
    outcome: str
    verdict: str = ""
    tags: list[str] = field(default_factory=list)
    measures: dict[str, Any] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    duration: str = ""  # that was asked for in place of the machine's

    def has(self, text: str) -> bool:
        """Whether every word of a search is in its machine, tags, verdict or date."""
        where = " ".join([self.machine, *self.tags, self.verdict, self.outcome, self.made]).lower()
        return all(word in where for word in text.lower().split())


class Archive(Shelf[Entry]):
    """All runs below the folder of a user."""

    def __init__(self, home: Path) -> None:
        super().__init__(home / "runs", Entry, "run")

    def found(self, text: str = "") -> list[Entry]:
        """The runs that a search finds, the latest first; one that cannot be read says so in place of its machine."""
        return [one for one in self.entries(lambda name: Entry(name, UNREADABLE, "", 0.0, "")) if one.has(text)]

    def file(self, name: str, kind: str) -> Path:
        """A file of a run: ``view.bin``, ``run.nc`` or ``machine.toml``.

        Raises
        ------
        QuestionError
            If there is no such run or file.
        """
        path = self.folder(name) / kind
        if kind not in ("view.bin", "run.nc", "machine.toml") or not path.is_file():
            raise QuestionError(f"run {name}: has no {kind[:20]!r}")
        return path

    def text(self, name: str) -> str:
        """The machine of a run."""
        return self.file(name, "machine.toml").read_text(encoding="utf-8")

    def run(self, name: str) -> xr.Dataset:
        """The result of a run."""
        return load_run(self.file(name, "run.nc"))

    def tag(self, name: str, tags: list[str]) -> None:
        """Give a run other tags."""
        entry = self.entry(name)
        entry.tags = sorted({tag.strip()[:TAG] for tag in tags if tag.strip()})
        self.note(entry)

    def simulate(self, text: str, job: Job, *, duration: str = "", seed: int = 0) -> str:
        """Run the machine of a text and keep the result; gives its name as soon as it can be drawn.

        Raises
        ------
        QuestionError
            If the archive is full, or the run has no samples.
        MachineError
            If the machine is not possible.
        """
        if len(self) >= MOST:
            raise QuestionError(f"the archive has {MOST} runs; delete some of them first")
        machine = parse_machine(text, "machine")
        run = simulate(machine, duration=duration or None, seed=seed, progress=job.progress, keep_on_interrupt=True)
        if job.stop.is_set() and run.sizes.get("time", 0) < 2:
            raise QuestionError("cancelled before there was anything to show; nothing was kept")
        folder = self.new()
        name = folder.name
        entry = Entry(name, machine.name, f"{datetime.now(UTC):%Y-%m-%d %H:%M:%S}", 0.0, str(run.attrs["outcome_text"]))
        try:
            view = packed(run)
            write_safely(folder / "view.bin", lambda path: path.write_bytes(view))
            write_text_safely(folder / "machine.toml", text)
            job.result = name
            entry.measures, entry.verdict = _measured(run), _judged(run, machine)
            entry.notes, entry.duration = list(job.notes), duration
            entry.seconds = float(run.attrs.get("end_time", run.attrs.get("duration", 0.0)))
            save_run(run, folder / "run.nc")
            self.note(entry)
        except BaseException as error:  # half a run is none
            job.result = None
            shutil.rmtree(folder, ignore_errors=True)
            if isinstance(error, ResultError):  # says which file; that folder is none of the user's business
                raise ResultError(f"the run was not kept: {str(error).removeprefix(f'{folder}/')}") from None
            raise
        return name


def differences(first: str, second: str) -> list[tuple[str, str, str]]:
    """The entries in which two machines differ: path, value of the first, value of the second."""
    a, b = (dict(_flat(tomllib.loads(text))) for text in (first, second))
    paths = [*a, *(path for path in b if path not in a)]
    return [(path, a.get(path, "–"), b.get(path, "–")) for path in paths if a.get(path) != b.get(path)]


def _flat(data: Any, path: str = "") -> Any:
    if isinstance(data, dict):
        for key, value in data.items():
            yield from _flat(value, f"{path}.{key}".lstrip("."))
    elif isinstance(data, list) and data and isinstance(data[0], dict):
        for number, value in enumerate(data, 1):
            yield from _flat(value, f"{path}[{number}]")
    else:
        yield path, _text(data)


def _text(data: Any) -> str:
    """One entry as it reads in a machine file, but for quotation marks."""
    if isinstance(data, bool):
        return "true" if data else "false"
    return ", ".join(map(_text, data)) if isinstance(data, list) else str(data)


def _measured(run: xr.Dataset) -> dict[str, Any]:
    """Measures by name: value, unit, meaning; of those with a number for each ball, place or plane ``name[of which]``."""
    try:
        found = run_measures(run)
    except AutobalancerError:
        return {}
    rows = {}
    for name in found:
        if found[name].ndim > 1 or found[name].dtype.kind != "f":
            continue
        about = found[name].attrs
        for which, value in _named_values(found[name]):
            if math.isfinite(value):
                meaning = f"{about.get('long_name', name)}{f': {which}' if which else ''}"
                rows[f"{name}[{which}]" if which else str(name)] = [value, str(about.get("units", "")), meaning]
    return rows


def _named_values(found: xr.DataArray) -> list[tuple[str, float]]:
    """Of which each number is; of many balls the ends alone."""
    values = [float(value) for value in found.values.ravel()]
    if len(values) == 1:
        return [("", values[0])]
    if len(values) > EACH:
        known = [value for value in values if math.isfinite(value)]
        return [("least", min(known)), ("greatest", max(known))] if known else []
    (of,) = found.dims
    names = [str(name) for name in found[of].values] if of in found.coords else [str(k + 1) for k in range(len(values))]
    return list(zip([f"{of} {name}" if name.isdigit() else name for name in names], values, strict=True))


def _judged(run: xr.Dataset, machine: Any) -> str:
    """The verdict in one sentence; empty where it cannot be said."""
    try:
        return str(verdict(run, held_run(machine, run))).splitlines()[0]
    except (AutobalancerError, KeyError):
        return ""


# Names of users: checked, so that no path leaves the folder of its user.


LOCAL = "local"  # the user of a server without tokens
USER = re.compile(r"[a-z0-9][a-z0-9_-]{0,31}")


def user_folder(root: Path, user: str) -> Path:
    """The folder of a user.

    Raises
    ------
    QuestionError
        If the name is not possible.
    """
    if not USER.fullmatch(user):
        raise QuestionError(
            f"user {user[:40]!r}: not possible; take up to 32 small letters, digits, '-' and '_', a letter or digit first"
        )
    return root / user


# What a run is saved as: result, table, machine, a Python script that does the same, pictures, a film.


TYPES = {
    "run.nc": "application/x-netcdf",
    "view.bin": "application/octet-stream",
    "machine.toml": "application/toml",
    "measures.csv": "text/csv; charset=utf-8",
    "script.py": "text/x-python; charset=utf-8",
    "picture.png": "image/png",
    "picture.svg": "image/svg+xml",
    "film.gif": "image/gif",
}


def exported(archive: Archive, name: str, kind: str) -> bytes | Path:
    """A run in another form.

    Raises
    ------
    QuestionError
        If there is no such run or form, or a film has not been made.
    """
    if kind not in TYPES:
        raise QuestionError(f"{kind[:40]!r}: no such form of a run; there are {', '.join(TYPES)}")
    if kind == "measures.csv":
        return _table(archive, name).encode()
    if kind == "script.py":
        return script(archive.text(name), archive.entry(name).duration).encode()
    if kind.startswith("picture."):
        run = archive.run(name)
        return file_of(lambda: machine_kind(run)["picture"](run), kind.rpartition(".")[2])
    if kind == "film.gif":
        path = archive.folder(name) / kind
        if not path.is_file():
            raise QuestionError(f"run {name}: has no film yet")
        return path
    return archive.file(name, kind)


def film(archive: Archive, name: str, progress: Any) -> str:
    """Make the film of a run; gives the name of its file."""
    run = archive.run(name)
    path = archive.folder(name) / "film.gif"
    with DRAWING:
        animate(run, path, width=640, fps=12, duration=8.0, progress=progress)
    return path.name


def script(text: str, duration: str = "") -> str:
    """A Python script that runs the machine of a text as the page did, with the ``duration`` that was given there."""
    fence = "'''"
    quoted = f"r{fence}{text}{fence}" if fence not in text and not text.endswith("\\") else json.dumps(text)
    length = f", duration={json.dumps(duration)}" if duration else ""
    return f'''"""Runs a machine as the page did, and shows what came out."""

import autobalancer as ab

MACHINE = {quoted}

machine = ab.parse_machine(MACHINE)
print(ab.check(machine))
run = ab.simulate(machine{length})
print(ab.verdict(run))
print(ab.run_measures(run))
ab.save_run(run, "run.nc")
'''


def _table(archive: Archive, name: str) -> str:
    """The measures of a run."""
    entry = archive.entry(name)
    out = io.StringIO()
    writer = csv.writer(out)
    writer.writerow(["measure", "of", "value", "unit", "meaning"])
    for key, (value, unit, meaning) in entry.measures.items():
        name, _, which = key.removesuffix("]").partition("[")
        writer.writerow([name, which, repr(value), unit, meaning])
    return out.getvalue()
