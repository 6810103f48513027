"""A thousand run-ups: parameters varied, measures collected, all cores used."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_races
from autobalancer.files.machine_file import machine_text
from autobalancer.machine import Machine
from autobalancer.machine.path import dimension_of_path
from autobalancer.patience import shows_progress
from autobalancer.results.answers.swept import Swept
from autobalancer.results.measure_table import SWEPT, label_of
from autobalancer.results.provenance import provenance
from autobalancer.results.recorded import SETTLING_FROM, known_origin
from autobalancer.results.verdict.rule import BALANCED
from autobalancer.studies.ensemble.columns import Columns
from autobalancer.studies.ensemble.execute import run_groups
from autobalancer.studies.ensemble.integration import Plan
from autobalancer.studies.ensemble.members import Members
from autobalancer.studies.sweep_row import named
from autobalancer.studies.variations import coordinate, listed
from autobalancer.units import optional_argument


@shows_progress
def sweep(
    machine: Machine | str | Path,
    variations: Mapping[str, Any],
    *,
    grid: bool = True,
    duration: float | str | None = None,
    tolerance: float = 1e-7,
    bins: int = 500,
    seed: int = 0,
    vary_seed: bool = False,
    seeds: int | None = None,
    workers: int | None = None,
    max_steps: int = 10_000_000,
    settling_from: str = SETTLING_FROM[0],
    progress: Callable[[int, int], None] | None = None,
) -> Swept:
    """Run a machine once for every combination of parameters.

    Parameters
    ----------
    machine
        A machine or the path of a machine file.
    variations
        Path of a parameter, such as ``"balancers[1].races[1].drag.beta"``, or a plain name of
        :data:`~autobalancer.machine.plain_names.QUANTITIES`, such as ``"viscosity"``, to its values: SI, texts with units,
        a range as one text such as ``"1:100 mm^2/s:5:log"``, or whole parts as a dict. A single value may stand without a list.
    grid
        True: every combination, one dimension for each parameter. False: all lists have the same length and are varied together,
        along the dimension ``run``.
    duration, tolerance
        As for :func:`autobalancer.simulate`.
    bins
        Resolution in time of the measures; settling times are interpolated within a bin.
    seed, vary_seed
        Start positions of balls that have none; ``vary_seed`` gives each run its own.
    seeds
        Number of start positions with which every combination is run, from ``seed`` on, along the dimension ``seed``. Then
        ``variations`` may be empty.
    workers
        Threads; by default one for each core. The result does not depend on it.
    max_steps
        Of one run, which ends with the outcome "budget spent" then.
    settling_from
        From where settling times count: the end of the ``"run-up"``, or the last ``"release"`` of a stalled ball, see
        :func:`autobalancer.settling_time`.
    progress
        Called with (runs done, runs in all).

    Returns
    -------
    xarray.Dataset
        Peak deflection and its speed; at the end vibration, static deflection, force on the supports, residual unbalance, and
        the vibration without balls; settling time, release speed, final ball angles; ``outcome`` and ``verdict``, and
        ``balanced``, whose mean is the share of balanced runs.

    Raises
    ------
    QuestionError
        For an unknown parameter, empty or unequal lists, a missing duration, fewer than one of ``seeds``.
    MachineError
        If a combination makes no possible machine; the message names it. Nothing has run by then.
    """
    duration, _ = optional_argument("duration", duration, "s"), known_origin(settling_from)
    machine = balls_in_races(machine)
    variations = {name: listed(machine, name, values) for name, values in variations.items()}
    if duration is None and machine.run is None:
        raise QuestionError("duration: the machine has no 'run.duration'; give one here")
    if duration is not None and not (math.isfinite(duration) and duration > 0.0):
        raise QuestionError(f"duration: given {duration!r}; must be a time greater than zero, in seconds")
    end = float(duration) if duration is not None else float(machine.run.duration)  # type: ignore[union-attr]
    if seeds is not None and (seeds < 1 or vary_seed):
        raise QuestionError(f"seeds: given {seeds}; must be at least 1, and is taken in place of vary_seed")
    shape, points = _points(variations, grid) if variations or seeds is None else ((), [()])
    shape = (*shape, seeds) if seeds is not None else shape
    lists: dict[str, Sequence[Any]] = {name: [point[i] for point in points] for i, name in enumerate(variations)}
    own = np.arange(seed, seed + len(points)) if vary_seed else None
    columns = Columns(len(points), lists, seeds=own)
    drawn = np.arange(seed, seed + seeds) if seeds is not None else None
    groups, _ = Members(machine, columns, drawn, seed, "").sorted(Plan(end, tolerance, bins, max_steps), "refuse")
    ran, _, interrupted = run_groups(groups, workers, progress)
    if interrupted:
        raise KeyboardInterrupt
    rows: list[dict[str, Any]] = [{}] * (len(points) * (seeds or 1))
    for one in ran:
        for number, row, steps in zip(one.group.numbers, one.found.rows, one.found.counts[:, 0], strict=True):
            rows[number] = named(row, end, int(steps), settling_from)
    about = {"duration": end, "tolerance": tolerance, "bins": bins, "seed": seed, "settling_from": settling_from}
    found = _dataset(machine, variations, grid, shape, rows, about)
    return Swept.of(found.assign_coords(seed=drawn) if drawn is not None else found)


def _points(variations: Mapping[str, Sequence[Any]], grid: bool) -> tuple[tuple[int, ...], list[tuple[Any, ...]]]:
    sizes = {path: len(values) for path, values in variations.items()}
    if not sizes or min(sizes.values()) == 0:
        raise QuestionError("variations: give at least one parameter, and at least one value for each")
    if grid:
        return tuple(sizes.values()), list(product(*variations.values()))
    if len(set(sizes.values())) > 1:
        raise QuestionError(f"variations: with grid=False all lists must have one length; given {sizes}")
    return (next(iter(sizes.values())),), list(zip(*variations.values(), strict=True))


def _dataset(
    machine: Machine,
    variations: Mapping[str, Sequence[Any]],
    grid: bool,
    shape: tuple[int, ...],
    rows: list[dict[str, Any]],
    about: dict[str, Any],
) -> xr.Dataset:
    names = [dimension_of_path(path) for path in variations]
    dims = (tuple(names) if grid else ("run",)) if names else ()
    dims = dims if len(dims) == len(shape) else (*dims, "seed")
    variables: dict[str, Any] = {}
    for measure in SWEPT:
        name, label = measure.name, label_of(measure, about["settling_from"])
        if measure.per_ball:
            each = [row.get(name, np.zeros(0)) for row in rows]
            padded = np.full((len(rows), max(values.size for values in each)), np.nan)
            for place, values in zip(padded, each, strict=True):
                place[: values.size] = values
            variables[name] = ((*dims, "ball"), padded.reshape((*shape, padded.shape[1])), label)
        else:
            variables[name] = (dims, np.reshape([float(row.get(name, np.nan)) for row in rows], shape), label)
    for name in ("outcome", "verdict"):
        variables[name] = (dims, np.array([row[name] for row in rows], dtype=object).reshape(shape))
    balanced = [row["verdict"] == BALANCED for row in rows]
    variables["balanced"] = (
        dims,
        np.reshape(balanced, shape),
        {"long_name": "whether the verdict is 'balanced'"},
    )
    return xr.Dataset(
        variables,
        coords={
            name: (name if grid else "run", *coordinate(machine, path, values))
            for name, (path, values) in zip(names, variations.items(), strict=True)
        },
        attrs={
            "title": f"Sweep of {machine.name}",
            **provenance(),
            "machine": machine_text(machine),
            "machine_name": machine.name,
            "parameters": list(variations),
            **about,
        },
    )
