"""How well a chamber balances over the number of balls and their friction: Pakuła (2021), figures 10 and 12."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import xarray as xr

from autobalancer.errors import MachineError, QuestionError
from autobalancer.files.given import balls_in_chambers
from autobalancer.files.machine_file import machine_text
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.patience import shows_progress
from autobalancer.results.archive.folder import Archive
from autobalancer.studies.chamber_many import Cell, Job, Many, gathered, measured_runs
from autobalancer.studies.chamber_runs import refuse_unmeasurable
from autobalancer.units import argument, optional_argument
from autobalancer.units.ranges import listed, whole

MOST_RUNS = 100_000  # of one study


@shows_progress
def amplitudes(
    machine: ChamberMachine | str | Path,
    counts: Sequence[int] | Mapping[str, Sequence[int]] | str,
    frictions: Sequence[float] | str,
    *,
    duration: float | str,
    layers: Sequence[str] = ("deep", "single"),
    archive: Archive | str | Path | None = None,
    step: float | str | None = None,
    sample: float | str = 1e-3,
    seeds: Sequence[int] = (0,),
    last: float | str | None = None,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Run a machine with every number of balls and every friction, at equal total mass of the balls.

    Parameters
    ----------
    machine
        With one deep chamber and one group of balls; their total mass is kept.
    counts
        Numbers of balls, for all or for each of ``layers``; for all also as one text such as ``"3,8,20"``.
    frictions
        Coefficients of friction, also as one text.
    duration, step, sample
        As for ``simulate_chamber``, in s.
    layers
        ``"deep"``, ``"single"`` or both.
    archive
        Folder in which all runs are kept. With an archive, a study that was stopped continues; finished runs are not repeated.
    seeds
        Seeds of the filling. How balls pile up and when they are carried along depends on tiny differences at the start.
    last
        Seconds at the end that are the steady state.
    workers
        Threads; the answer does not depend on it.
    progress
        Called with (runs done, runs in all).

    Returns
    -------
    xarray.Dataset
        Over ``layers``, ``friction``, ``balls`` and ``seed`` every measure of :func:`chamber_measures` as a number, nan where
        the balls do not fit or a run failed, and ``outcome``. :func:`over_seeds` makes means and spreads of it.

    Raises
    ------
    QuestionError
        For an empty list, a machine with several chambers, or runs that are too short to be measured.
    MachineError
        For a friction that is not possible.
    """
    counts = whole("counts", counts) if isinstance(counts, str) else counts
    frictions = listed("frictions", frictions, "") if isinstance(frictions, str) else frictions
    machine, duration = balls_in_chambers(machine), argument("duration", duration, "s")
    step = optional_argument("step", step, "s")
    sample = argument("sample", sample, "s")
    last = optional_argument("last", last, "s")
    each = {name: list(counts[name] if isinstance(counts, Mapping) else counts) for name in layers}
    numbers = sorted({number for several in each.values() for number in several})
    for name, values in (("counts", numbers), ("frictions", frictions), ("layers", layers), ("seeds", seeds)):
        if len(values) == 0:
            raise QuestionError(f"{name}: given none; give at least one")
    asked = len(frictions) * len(seeds) * sum(map(len, each.values()))
    if asked > MOST_RUNS:
        raise QuestionError(f"amplitudes: {asked} runs are asked for; at most {MOST_RUNS} are possible, ask for fewer")
    refuse_unmeasurable(duration, sample, last)
    own = machine.chambers[0]
    for friction in frictions:  # refused here, not noted as a gap
        variant(machine, balls=own.balls[0].count, friction=friction, layers="single" if own.depth is None else "deep")
    kept = archive if isinstance(archive, Archive) or archive is None else Archive(archive)
    cells = [Cell(*cell) for cell in product(layers, frictions, numbers, seeds) if cell[2] in each[cell[0]]]

    jobs = [_job(machine, cell) for cell in cells]
    how = Many(duration, last, kept, workers, step, sample)
    found = gathered(cells, measured_runs(jobs, how, progress))
    title = f"Amplitudes of {machine.name} over balls and friction"
    about = {"machine": machine_text(machine), "machine_name": machine.name, "duration": duration}
    found.attrs = {"title": title, **found.attrs, **about}
    return found


def _job(machine: ChamberMachine, cell: Cell) -> Job:
    name = f"{cell.layers}-n{cell.balls}-mu{cell.friction:g}-s{cell.seed}"
    try:
        varied = variant(machine, balls=cell.balls, friction=cell.friction, layers=cell.layers)
    except MachineError as reason:
        return Job(name, reason, cell.seed, {})
    return Job(name, varied, cell.seed, {"layers": cell.layers})


# The same machine with other balls, another friction, a chamber of one layer.


LAYERS = ("deep", "single")


def variant(
    machine: ChamberMachine | str | Path,
    *,
    balls: int,
    friction: float | None = None,
    layers: str = "deep",
    body: str | None = None,
) -> ChamberMachine:
    """A machine with another number of balls of the same total mass, in its deep chamber or in one of a single layer.

    Parameters
    ----------
    machine
        With one chamber and one group of balls.
    balls
        How many; the smaller, the more there are. Cylinders keep their length over their diameter.
    friction
        Of all contacts; by default that of the machine.
    layers
        ``"deep"``: depth as described; ``"single"``: as deep as a ball and a hundredth.
    body
        ``"ball"`` for balls in place of cylinders, of the same mass together; by default as the machine has them.

    Raises
    ------
    QuestionError
        If the machine has several chambers or groups of balls, or ``layers`` or ``body`` is none of these.
    MachineError
        If balls of this size do not go into the chamber.
    """
    if layers not in LAYERS:
        raise QuestionError(f"layers: given {layers!r}; must be one of {', '.join(LAYERS)}")
    machine = balls_in_chambers(machine)
    if len(machine.chambers) != 1 or len(machine.chambers[0].balls) != 1:
        raise QuestionError(
            "machine: has several chambers or groups of balls; the study is of one chamber with equal balls"
        )
    data: dict[str, Any] = tomllib.loads(machine_text(machine))
    chamber = data["chambers"][0] if isinstance(data["chambers"], list) else data["chambers"]
    group = machine.chambers[0].balls[0]
    chamber["balls"] = [{"count": balls, "density": group.density, "total_mass": group.count * group.ball_mass}]
    body = group.body if body is None else body
    if body not in ("ball", group.body):
        raise QuestionError(
            f"body: given {body!r}; a machine with {group.body}s has variants with {_and_balls(group.body)}"
        )
    if group.length is not None and body != "ball":
        same = {"body": group.body, "length": group.length * (group.count / balls) ** (1.0 / 3.0)}
        chamber["balls"][0].update(same)
    if layers == "single":
        chamber.pop("depth", None)
    elif machine.chambers[0].depth is None:
        raise QuestionError(
            "machine: its chamber has no depth, so it is one of a single layer; give chambers.depth, or ask for the "
            "single layer alone"
        )
    if friction is not None:
        data["contact"]["friction"] = friction
    return ChamberMachine(**data)


def _and_balls(body: str) -> str:
    return "'ball'; describe cylinders in the machine file" if body == "ball" else f"'ball' and {body!r}"
