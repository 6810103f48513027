"""Machines of the tests of continuation, and how to read their branches."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import xarray as xr

from autobalancer.assembly.quantities import with_value_at
from autobalancer.files.machine_file import load_race_machine
from autobalancer.machine import Balls, Machine
from autobalancer.stability.branch_diagrams import branches

MACHINES = Path(__file__).parents[2] / "examples" / "machines"
DISCOIDAL, STALL = (load_race_machine(MACHINES / f"{name}.toml") for name in ("discoidal", "stall_and_release"))
RACE = "balancers[1].races[1]"


def stall_machine(share: float, drag: float) -> Machine:
    """The stall-and-release machine with a share of the unbalance that its balls can balance, and another drag."""
    machine = with_value_at(STALL, "unbalances[1].mass", share * 5e-3)
    return with_value_at(machine, f"{RACE}.drag.damping", drag)


def with_balls(count: int, mass: str) -> Machine:
    balls = Balls(count=count, mass=mass, material="steel", motion="rolling")
    return with_value_at(STALL, f"{RACE}.balls", (balls,))


def specials(found: xr.Dataset, kind: str, branch: int | None = None) -> list[xr.Dataset]:
    rows = [found.isel(special=i) for i in range(found.sizes["special"])]
    return [row for row in rows if row["special_type"] == kind and branch in (None, int(row["special_branch"]))]


def branch(found: xr.Dataset, number: int) -> xr.Dataset:
    return found.isel(point=np.flatnonzero(found["branch"].values == number))


@cache
def swinging(share: float) -> xr.Dataset:
    """Branches of a lightly damped pair through its Hopf point."""
    return branches(stall_machine(share, 1e-4), "speed", 300.0, 273.0)
