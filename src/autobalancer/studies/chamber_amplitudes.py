"""How well a chamber balances over the number of balls and their friction: Pakuła (2021), figures 10 and 12."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.errors import MachineError, QuestionError
from autobalancer.files.machine_file import machine_text
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.results.archive import Archive
from autobalancer.results.chamber_measures import catalogue_measures, chamber_measures
from autobalancer.results.provenance import provenance
from autobalancer.simulation.chamber import simulate_chamber
from autobalancer.studies.chamber_machines import chamber_variant
from autobalancer.studies.chamber_runs import archived_run

OPTIMAL = {"deep": (8, 50), "single": (3, 10)}  # ranges of figure 12


def chamber_amplitudes(
    machine: ChamberMachine,
    counts: Sequence[int] | Mapping[str, Sequence[int]],
    frictions: Sequence[float],
    *,
    duration: float,
    layers: Sequence[str] = ("deep", "single"),
    archive: Archive | str | Path | None = None,
    step: float | None = None,
    sample: float = 1e-3,
    seeds: Sequence[int] = (0,),
    last: float | None = None,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Run a machine with every number of balls and every friction, at equal total mass of the balls.

    Parameters
    ----------
    machine
        With one deep chamber and one group of balls; their total mass is kept.
    counts
        Numbers of balls, for all or for each of ``layers``.
    frictions
        Coefficients of friction.
    duration, step, sample
        As for ``simulate_chamber``, in s.
    layers
        ``"deep"``, ``"single"`` or both.
    archive
        Folder in which all runs are kept. With one, a study that was stopped goes on; what is finished is not run again.
    seeds
        Of the filling; the measures are means over them.
    last
        Seconds at the end that are the steady state.
    workers
        Threads; the answer does not depend on it.
    progress
        Called with (runs done, runs in all).

    Returns
    -------
    xarray.Dataset
        Over ``layers``, ``friction`` and ``balls`` every measure of :func:`chamber_measures` as a number, nan where the balls
        do not fit or a run failed, and ``outcome``.

    Raises
    ------
    QuestionError
        For an empty list, or a machine with several chambers.
    """
    each = {name: list(counts[name] if isinstance(counts, Mapping) else counts) for name in layers}
    numbers = sorted({number for several in each.values() for number in several})
    for name, values in (("counts", numbers), ("frictions", frictions), ("layers", layers), ("seeds", seeds)):
        if len(values) == 0:
            raise QuestionError(f"{name}: given none; give at least one")
    kept = archive if isinstance(archive, Archive) or archive is None else Archive(archive)
    jobs = [(*cell, seed) for cell in product(layers, frictions, numbers) if cell[2] in each[cell[0]] for seed in seeds]
    done = 0

    def one(job: tuple[str, float, int, int]) -> dict[str, Any]:
        nonlocal done
        layer, friction, balls, _ = job
        told: dict[str, Any] = {}
        try:
            variant = chamber_variant(machine, balls=balls, friction=friction, layers=layer)
            told = _measured(variant, kept, job, duration, step, sample, last)
        except MachineError as reason:
            told = {"outcome": f"does not fit: {reason}"}
        done += 1
        if progress is not None:
            progress(done, len(jobs))
        return told

    workers = workers if workers is not None else os.cpu_count() or 1
    if workers == 1:
        rows = [one(job) for job in jobs]
    else:
        with ThreadPoolExecutor(workers) as pool:
            rows = list(pool.map(one, jobs))
    found = _dataset(jobs, rows, list(layers), list(frictions), numbers)
    found.attrs.update(machine=machine_text(machine), machine_name=machine.name, duration=duration, seeds=list(seeds))
    return found


def optimal_means(study: xr.Dataset, ranges: Mapping[str, tuple[int, int]] | None = None) -> xr.Dataset:
    """Means of the amplitudes over the numbers of balls in a range for each of ``layers`` (Pakuła 2021, figure 12).

    Returns
    -------
    xarray.Dataset
        Over ``layers`` and ``friction``: means of the amplitudes, and ``runs``, how many of the study are in each.

    Raises
    ------
    QuestionError
        If the study has no number of balls in a range.
    """
    chosen = {**OPTIMAL, **(ranges or {})}
    pieces = []
    for layer in study["layers"].values:
        low, high = chosen[str(layer)]
        within = study.sel(layers=layer).where((study["balls"] >= low) & (study["balls"] <= high), drop=True)
        if within.sizes["balls"] == 0:
            raise QuestionError(f"ranges: the study has no number of balls from {low} to {high} for {layer!r}")
        names = [str(name) for name in study.data_vars if str(name).endswith(("_amplitude", "_synchronous"))]
        mean = within[names].mean("balls", skipna=True, keep_attrs=True)
        mean["runs"] = within["vertical_amplitude"].notnull().sum("balls")
        pieces.append(mean)
    return xr.concat(pieces, "layers", coords="minimal", compat="override")


def _measured(
    machine: ChamberMachine,
    archive: Archive | None,
    job: tuple[str, float, int, int],
    duration: float,
    step: float | None,
    sample: float,
    last: float | None,
) -> dict[str, Any]:
    layer, friction, balls, seed = job
    if archive is not None:
        run = archived_run(
            archive,
            f"{layer}-n{balls}-mu{friction:g}-s{seed}",
            machine,
            duration=duration,
            parameters={"layers": layer},
            step=step,
            sample=sample,
            seed=seed,
            last=last,
        )
        return {"outcome": run.note["outcome"]["outcome"], **run.note["measures"]}
    ended = simulate_chamber(machine, duration=duration, step=step, sample=sample, seed=seed)
    outcome = str(ended.attrs["outcome"])
    if outcome != "finished":
        return {"outcome": outcome}
    return {"outcome": outcome, **catalogue_measures(chamber_measures(ended, last=last))}


def _dataset(
    jobs: list[tuple[str, float, int, int]],
    rows: list[dict[str, Any]],
    layers: list[str],
    frictions: list[float],
    counts: list[int],
) -> xr.Dataset:
    dims = ("layers", "friction", "balls")
    shape = (len(layers), len(frictions), len(counts))
    names = sorted({name for row in rows for name in row if name != "outcome"})
    values: dict[str, list[list[float]]] = {name: [[] for _ in range(math.prod(shape))] for name in names}
    outcome = np.full(shape, "not asked", dtype=object)
    for (layer, friction, balls, _), row in zip(jobs, rows, strict=True):
        cell = (layers.index(layer), frictions.index(friction), counts.index(balls))
        flat = int(np.ravel_multi_index(cell, shape))
        outcome[cell] = row["outcome"]
        for name in names:
            value = row.get(name)
            if value is not None:
                values[name][flat].append(float(value))
    found = xr.Dataset(coords={"layers": layers, "friction": frictions, "balls": counts}, attrs=provenance())
    for name, cells in values.items():
        means = [float(np.mean(cell)) if cell else np.nan for cell in cells]
        found[name] = (
            dims,
            np.array(means).reshape(shape),
            {"units": _unit(name), "long_name": name.replace("_", " ")},
        )
    found["outcome"] = (dims, outcome)
    return found


def _unit(name: str) -> str:
    if name.startswith("rotation") and not name.endswith("time"):
        return "rad"
    if name.endswith(("_amplitude", "_synchronous", "_peak")):
        return "m"
    return "s" if name.endswith("time") else ""
