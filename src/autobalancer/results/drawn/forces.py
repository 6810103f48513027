"""What pictures draw of the forces on the balls of a run: lines in the axes of each race."""

from __future__ import annotations

import tomllib
from contextlib import suppress
from typing import Any

import xarray as xr

from autobalancer.errors import MachineError
from autobalancer.machine import Force
from autobalancer.machine.leaves import find

ForcesOfRaces = dict[tuple[int, int], list[Force]]


def forces_of(run: xr.Dataset) -> ForcesOfRaces:
    """The forces of each race, by the numbers of its balancer and itself from 1; those that are not known here are left out."""
    text = run.attrs.get("machine", "")
    found: ForcesOfRaces = {}
    if "forces" not in text:
        return found
    for b, balancer in enumerate(tomllib.loads(text).get("balancers", []), 1):
        for r, race in enumerate(balancer.get("races", []), 1):
            forces = race.get("forces", [])
            for table in forces if isinstance(forces, list) else [forces]:
                with suppress(MachineError):
                    found.setdefault((b, r), []).append(_leaf(table))
    return found


def _leaf(table: dict[str, Any]) -> Force:
    leaf = find(Force, table.get("kind"))(**table)
    assert isinstance(leaf, Force)
    return leaf


def lines_of(forces: list[Force], orbit: float, places: list[complex], speed: float) -> list[list[complex]]:
    """All lines of the forces of one race with balls at these places from its center, m, at a ``speed`` of the rotor, rad/s."""
    return [line for force in forces for line in force.drawn(orbit, places, speed)]
