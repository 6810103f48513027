"""What a run is saved as: result, table, machine, a Python script that does the same, pictures, a film."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path
from typing import Any

from autobalancer.app.store.archive import FILES, Archive
from autobalancer.app.store.drawn import file_of
from autobalancer.app.store.names import run_folder
from autobalancer.either_kind import animate
from autobalancer.errors import QuestionError
from autobalancer.plots.chamber.history import chamber_run
from autobalancer.plots.drawing.style import DRAWING
from autobalancer.plots.run.run_up import run_up
from autobalancer.results.chamber.shape import is_chamber_run

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
        draw = chamber_run if is_chamber_run(run) else run_up
        return file_of(lambda: draw(run), kind.rpartition(".")[2])
    if kind == "film.gif":
        path = run_folder(archive.home, name) / kind
        if not path.is_file():
            raise QuestionError(f"run {name}: has no film yet")
        return path
    return archive.file(name, kind)


def film(archive: Archive, name: str, progress: Any) -> str:
    """Make the film of a run; gives the name of its file."""
    run = archive.run(name)
    path = run_folder(archive.home, name) / "film.gif"
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
print(ab.measures(run))
ab.save_run(run, "run.nc")
'''


def _table(archive: Archive, name: str) -> str:
    """The measures of a run."""
    with FILES:
        entry = archive.entry(name)
    out = io.StringIO()
    writer = csv.writer(out)
    writer.writerow(["measure", "of", "value", "unit", "meaning"])
    for key, (value, unit, meaning) in entry.measures.items():
        name, _, which = key.removesuffix("]").partition("[")
        writer.writerow([name, which, repr(value), unit, meaning])
    return out.getvalue()
