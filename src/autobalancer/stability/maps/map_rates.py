"""The growth rates of a map: compiled and in threads for equal balls, state by state otherwise."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np

from autobalancer.assembly.forces.rows import has_forces
from autobalancer.assembly.quantities import with_quantity
from autobalancer.assembly.terms import weightless
from autobalancer.errors import MachineError
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.stability.host.planar import Floats, Plane
from autobalancer.stability.maps.balanced import balanced_states
from autobalancer.stability.states.described import Described, described

MEMBERS = 6  # of a continuum of balanced states, at most
TASKS = 32  # at least so many pieces of work, if there is enough of it


def rates_over(
    machine: Machine,
    values: dict[str, Floats],
    speed: float,
    worst: bool,
    workers: int | None,
    progress: Callable[[int, int], None] | None,
) -> Floats:
    """Growth rates over two parameters, 1/s, in their order; nan without a balanced state."""
    planar = isinstance(machine.rotor, PlanarRotor) and not has_forces(machine)
    inner = ("unbalance", "speed") if planar else ("speed",)
    outer = [name for name in values if name not in inner]  # those that need another machine
    speeds = values.get("speed", np.array([speed]))
    rows = list(product(*(values[name].tolist() for name in outer)))
    machines, planes = zip(*(with_values(machine, dict(zip(outer, row, strict=True))) for row in rows), strict=True)
    own = np.array([np.nan])  # the unbalance of the machine
    sizes = values.get("unbalance", own) if planar else own
    parts = np.array_split(np.arange(sizes.size), max(1, min(sizes.size, TASKS // len(rows))))
    tasks = [(row, part) for row in range(len(rows)) for part in parts]
    result = np.empty((len(rows), sizes.size, speeds.size))

    def work(task: tuple[int, Floats]) -> None:
        row, part = task
        for k in part:
            here = planes[row]
            p = with_size(here, float(sizes[k])) if isinstance(here, Plane) and not np.isnan(sizes[k]) else here
            result[row, k] = _rates(machines[row], p, speeds, worst)

    with ThreadPoolExecutor(workers or os.cpu_count() or 1) as pool:
        for done, _ in enumerate(pool.map(work, tasks), 1):
            if progress is not None:
                progress(done, len(tasks))
    order = [*outer, *(name for name in inner if name in values)]
    kept = result.reshape([values[name].size for name in order])
    return np.ascontiguousarray(kept.transpose([order.index(name) for name in values]))


def with_size(p: Plane, size: float) -> Plane:
    """The plane with another size of its unbalance."""
    direction = p.unbalance / abs(p.unbalance) if p.unbalance else 1.0
    return replace(p, unbalance=size * direction)


def _rates(machine: Machine, p: Described, speeds: Floats, worst: bool) -> Floats:
    members = balanced_states(p)[:MEMBERS]
    found = np.array([member.rates(speeds) for member in members])
    return np.asarray((np.fmax if worst else np.fmin).reduce(found))


def with_values(machine: Machine, values: dict[str, Any]) -> tuple[Machine, Described]:
    """The machine with other values of its parameters, and its numbers.

    Raises
    ------
    MachineError
        If they make no possible machine; the message names them.
    """
    try:
        for name, value in values.items():
            machine = with_quantity(machine, name, value)
        return machine, described(weightless(machine), None)
    except MachineError as error:
        given = ", ".join(f"{name} = {value}" for name, value in values.items())
        raise MachineError(f"{given}: {error}") from None
