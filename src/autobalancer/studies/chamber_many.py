"""Many runs of deep chambers for a study: on all cores, the longest first, in an archive, stopped by Ctrl-C at once; and their
measures as arrays over layers, friction, number of balls and seed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from threading import Event
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from autobalancer.errors import MachineError, QuestionError
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.results.answers.chamber_study import ChamberStudy
from autobalancer.results.archive.folder import Archive
from autobalancer.results.chamber.measures import catalog_unit
from autobalancer.results.provenance import provenance
from autobalancer.simulation.chamber.run import default_step
from autobalancer.studies.chamber_runs import measured_run
from autobalancer.studies.in_threads import in_threads

DIMS = ("layers", "friction", "balls", "seed")
NOT_ASKED = "not asked"


class Job(NamedTuple):
    """One run: its name in an archive, its machine or why there is none, the seed of its filling, what the catalogue adds."""

    name: str
    machine: ChamberMachine | MachineError
    seed: int
    parameters: Mapping[str, Any]


@dataclass(frozen=True)
class Many:
    """How all runs of a study are made: s, where they are kept, and on how many threads; ``None`` for one each core."""

    duration: float
    last: float | None
    archive: Archive | None
    workers: int | None
    step: float | None = None
    sample: float = 1e-3


def measured_runs(
    jobs: Sequence[Job], how: Many, progress: Callable[[int, int], None] | None = None
) -> list[dict[str, Any]]:
    """Outcome and measures of each run by name, as :func:`measured_run` has them; ``does not fit`` with the reason as outcome.

    The answers do not depend on the number of threads. After Ctrl-C every run stops within a fraction of a second; an archive
    keeps what it computed. ``progress`` is called with (runs done, runs in all).
    """
    stop = Event()

    def watch(now: float, end: float) -> None:
        if stop.is_set():
            raise KeyboardInterrupt

    def one(job: Job) -> dict[str, Any]:
        if isinstance(job.machine, MachineError):
            return {"outcome": f"does not fit: {job.machine}"}
        asked = {"duration": how.duration, "step": how.step, "sample": how.sample, "seed": job.seed}
        try:
            return measured_run(
                how.archive, job.name, job.machine, job.parameters, last=how.last, progress=watch, **asked
            )
        except MachineError as reason:
            return {"outcome": f"does not fit: {reason}"}

    return in_threads(one, jobs, how.workers, progress, cost=lambda job: _cost(job, how.step), stop=stop)


def _cost(job: Job, step: float | None) -> float:
    """Balls times steps in a second: the time that a run takes is in proportion."""
    if isinstance(job.machine, MachineError):
        return 0.0
    balls = sum(group.count for chamber in job.machine.chambers for group in chamber.balls)
    return balls / (default_step(job.machine) if step is None else step)


class Cell(NamedTuple):
    """One run of a study: ``"deep"`` or ``"single"``, friction, number of balls, seed of the filling."""

    layers: str
    friction: float
    balls: int
    seed: int


def gathered(cells: Sequence[Cell], rows: Sequence[Mapping[str, Any]]) -> xr.Dataset:
    """Runs as one dataset.

    Parameters
    ----------
    cells
        Which run each row is of.
    rows
        ``outcome`` and measures by name; a missing or unknown one counts as nan.

    Returns
    -------
    xarray.Dataset
        Over ``layers``, ``friction``, ``balls`` and ``seed``: every measure, nan where there is none, and ``outcome``.

    Raises
    ------
    QuestionError
        If there is no run.
    """
    if not cells:
        raise QuestionError("study: no runs were asked for; give at least one of each")
    labels: list[list[Any]] = [
        list(dict.fromkeys(cell.layers for cell in cells)),
        sorted({cell.friction for cell in cells}),
        sorted({cell.balls for cell in cells}),
        sorted({cell.seed for cell in cells}),
    ]
    shape = tuple(len(values) for values in labels)
    names = sorted({name for row in rows for name in row if name != "outcome"})
    values = {name: np.full(shape, np.nan) for name in names}
    outcome = np.full(shape, NOT_ASKED, dtype=object)
    for cell, row in zip(cells, rows, strict=True):
        place = tuple(of.index(value) for of, value in zip(labels, cell, strict=True))
        outcome[place] = row["outcome"]
        for name in names:
            value = row.get(name)
            values[name][place] = np.nan if value is None else float(value)
    found: dict[str, Any] = {
        name: (DIMS, numbers, {"units": catalog_unit(name), "long_name": name.replace("_", " ")})
        for name, numbers in values.items()
    }
    found["outcome"] = (DIMS, outcome)
    return ChamberStudy(found, dict(zip(DIMS, labels, strict=True)), provenance())
