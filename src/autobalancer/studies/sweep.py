"""A thousand run-ups: parameters varied, measures collected, all cores used."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.assembly.mass_spread import MASS_SPREAD
from autobalancer.assembly.parameters import with_parameter
from autobalancer.assembly.system import Assembly, unbalance_at
from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import load_machine, machine_text
from autobalancer.kernels.integrators import tableau as tableaus
from autobalancer.kernels.integrators.memory import ACCEPTED, NEXT_BIN, TIME
from autobalancer.kernels.integrators.runge_kutta import RUNNING, advance
from autobalancer.kernels.system import BALLS, SPEED
from autobalancer.machine import Machine
from autobalancer.results.provenance import provenance
from autobalancer.results.series import released_at, settled_from, wrapped
from autobalancer.simulation.equations import equations
from autobalancer.simulation.fresh import memory_for
from autobalancer.simulation.outcome import outcome
from autobalancer.simulation.prepare import prepare
from autobalancer.simulation.record import record_for
from autobalancer.simulation.sampling import Envelope
from autobalancer.studies.in_threads import in_threads

LABELS = {
    "peak_deflection": ("greatest deflection", "m"),
    "peak_speed": ("rotor speed at the greatest deflection", "rad/s"),
    "residual_vibration": ("greatest deflection in the last twentieth of the run", "m"),
    "settling_time": ("settling time of the last ball", "s"),
    "release_speed": ("greatest release speed of a stalled ball", "rad/s"),
    "ball_angle_to_unbalance": ("final ball angle from the unbalance", "rad"),
}


def sweep(
    machine: Machine | str | Path,
    variations: Mapping[str, Sequence[Any]],
    *,
    grid: bool = True,
    duration: float | None = None,
    tolerance: float = 1e-7,
    bins: int = 500,
    seed: int = 0,
    vary_seed: bool = False,
    workers: int | None = None,
    max_steps: int = 10_000_000,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Run a machine once for every combination of parameters.

    Parameters
    ----------
    machine
        A machine or the path of a machine file.
    variations
        Path of a parameter, such as ``"balancers[1].races[1].drag.beta"``, to its values (SI or with units).
    grid
        True: every combination, one dimension for each parameter. False: all lists have one length and go together,
        along the dimension ``run``.
    duration, tolerance
        As for :func:`autobalancer.simulate`.
    bins
        Resolution in time of the measures.
    seed, vary_seed
        Start positions of balls that have none; ``vary_seed`` gives each run its own.
    workers
        Threads; by default one for each core. The result does not depend on it.
    progress
        Called with (runs done, runs in all).

    Returns
    -------
    xarray.Dataset
        Peak deflection, its speed, residual vibration, settling time, release speed, final ball angles, outcome.

    Raises
    ------
    QuestionError
        For an unknown parameter, empty or unequal lists, a missing duration.
    MachineError
        If a combination makes no possible machine; the message names it.
    """
    if not isinstance(machine, Machine):
        machine = load_machine(machine)
    if duration is None and machine.run is None:
        raise QuestionError("duration: the machine has no 'run.duration'; give one here")
    if duration is not None and not (math.isfinite(duration) and duration > 0.0):
        raise QuestionError(f"duration: given {duration!r}; must be a time greater than zero, in seconds")
    end = float(duration) if duration is not None else float(machine.run.duration)  # type: ignore[union-attr]
    shape, points = _points(variations, grid)
    assemblies = [
        prepare(
            _with(machine, variations, point),
            end,
            seed=seed + number * vary_seed,
            mass_spread=MASS_SPREAD,
            max_steps=max_steps,
        )
        for number, point in enumerate(points)
    ]

    def one(assembly: Assembly) -> dict[str, Any]:
        return _run(assembly, end, tolerance, bins, max_steps)

    rows = in_threads(one, assemblies, workers, progress)
    return _dataset(machine, variations, grid, shape, rows, end, tolerance, seed)


def _points(variations: Mapping[str, Sequence[Any]], grid: bool) -> tuple[tuple[int, ...], list[tuple[Any, ...]]]:
    sizes = {path: len(values) for path, values in variations.items()}
    if not sizes or min(sizes.values()) == 0:
        raise QuestionError("variations: give at least one parameter, and at least one value for each")
    if grid:
        return tuple(sizes.values()), list(product(*variations.values()))
    if len(set(sizes.values())) > 1:
        raise QuestionError(f"variations: with grid=False all lists must have one length; given {sizes}")
    return (next(iter(sizes.values())),), list(zip(*variations.values(), strict=True))


def _with(machine: Machine, variations: Mapping[str, Sequence[Any]], point: tuple[Any, ...]) -> Machine:
    for path, value in zip(variations, point, strict=True):
        machine = with_parameter(machine, path, float(value) if isinstance(value, np.floating) else value)
    return machine


def _run(assembly: Assembly, end: float, tolerance: float, bins: int, max_steps: int) -> dict[str, Any]:
    pair = tableaus.dormand_prince_8()
    record = record_for([Envelope(bins)], (), assembly, end)
    memory = memory_for(assembly, end, tolerance, pair)
    status = advance(equations(assembly), assembly.system, pair, record, memory, max_steps)
    count, n = int(memory.counts[NEXT_BIN]), len(assembly.balls)
    steps = int(memory.counts[ACCEPTED])
    found: dict[str, Any] = {
        "outcome": outcome(status, memory.clock[TIME], end, interrupted=False, steps=steps).name
        if status != RUNNING
        else "budget spent",
        "ball_angle_to_unbalance": np.full(n, np.nan),
    }
    if count == 0:
        return found
    high, states = record.bin_high[:count], record.bin_states[:count]
    time, speed = record.bin_edges[1 : count + 1], states[:, SPEED]
    angle, lag = states[:, BALLS : BALLS + n], states[:, BALLS + n : BALLS + 2 * n]
    peak = int(np.argmax(high))
    found |= {
        "peak_deflection": high[peak],
        "peak_speed": speed[peak],
        "residual_vibration": high[time > 0.95 * time[-1]].max(),
    }
    if n:
        unbalance = unbalance_at(assembly.system, end)
        critical = min(assembly.critical_speeds, default=math.nan)
        settled = settled_from(time, angle, speed, math.radians(2.0))
        released = released_at(speed, lag + speed[:, None], critical)
        found |= {
            "settling_time": settled.max(),
            "release_speed": np.nanmax(released) if np.isfinite(released).any() else np.nan,
            "ball_angle_to_unbalance": wrapped(angle[-1] - np.angle(unbalance)),
        }
    return found


def _dataset(
    machine: Machine,
    variations: Mapping[str, Sequence[Any]],
    grid: bool,
    shape: tuple[int, ...],
    rows: list[dict[str, Any]],
    end: float,
    tolerance: float,
    seed: int,
) -> xr.Dataset:
    names = [path.replace("[", "_").replace("]", "").replace(".", "_") for path in variations]
    dims = tuple(names) if grid else ("run",)
    result = xr.Dataset(
        attrs={
            "title": f"Sweep of {machine.name}",
            **provenance(),
            "machine": machine_text(machine),
            "machine_name": machine.name,
            "parameters": list(variations),
            "duration": end,
            "tolerance": tolerance,
            "seed": seed,
        }
    )
    for name, (path, values) in zip(names, variations.items(), strict=True):
        numbers = [_number(machine, path, value) for value in values]
        result = result.assign_coords({name: (name if grid else "run", numbers, {"long_name": path})})
    for name, (text, unit) in LABELS.items():
        cells = np.array([np.asarray(row.get(name, np.nan)) for row in rows], np.float64)
        extra = ("ball",) if cells.ndim == 2 else ()
        result[name] = (
            (*dims, *extra),
            cells.reshape(shape + cells.shape[1:]),
            {"long_name": text, "units": unit},
        )
    result["outcome"] = (dims, np.array([row["outcome"] for row in rows], dtype=object).reshape(shape))
    return result


def _number(machine: Machine, path: str, value: Any) -> Any:
    """The SI number that a text became, for the axis."""
    if not isinstance(value, str):
        return value
    entry: Any = with_parameter(machine, path, value)
    for piece in path.split("."):
        name, *places = piece.replace("]", "").split("[")
        entry = getattr(entry, name)
        for place in places:
            entry = entry[int(place) - 1]
    return float(entry) if isinstance(entry, float) else entry
