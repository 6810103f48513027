"""Where on a map friction holds balls at rest: the whirl it holds against that of the unbalance."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from autobalancer.assembly.quantities import with_quantity
from autobalancer.machine import Machine
from autobalancer.machine.plain_names import dimension_of
from autobalancer.stability.friction.held import held_share
from autobalancer.stability.host.planar import Floats

COARSE = 25  # values of a parameter
SPEEDS = 120


def with_friction(machine: Machine, values: Mapping[str, Floats]) -> Machine:
    """The machine as it is somewhere on the map: with rolling resistance if that is an axis."""
    name = "rolling_resistance"
    return with_quantity(machine, name, float(values[name].max())) if name in values else machine


def with_held(found: xr.Dataset, machine: Machine, values: dict[str, Floats]) -> xr.Dataset:
    """``held_share`` over coarser values of both axes; nothing is added to a map without friction."""
    races = [race for balancer in with_friction(machine, values).balancers for race in balancer.races]
    if all(race.friction is None for race in races):
        return found
    few = {name: _few(axis, SPEEDS if name == "speed" else COARSE) for name, axis in values.items()}
    shares = np.empty(tuple(axis.size for axis in few.values()))
    names = list(few)
    if "speed" in names:
        other = 1 - names.index("speed")
        for number, value in enumerate(few[names[other]].tolist()):
            row = held_share(with_quantity(machine, names[other], value), few["speed"])
            shares[(slice(None), number) if other == 1 else (number, slice(None))] = row
    else:
        speed = np.array([float(found.attrs["speed"])])
        for i, first in enumerate(few[names[0]].tolist()):
            changed = with_quantity(machine, names[0], first)
            for j, second in enumerate(few[names[1]].tolist()):
                shares[i, j] = held_share(with_quantity(changed, names[1], second), speed)[0]
    dims = {name: f"{dimension_of(name)}_of_friction" for name in names}
    found = found.assign_coords({dims[name]: axis for name, axis in few.items()})
    text = {"long_name": "whirl that friction holds over that of the unbalance alone", "units": "1"}
    found["held_share"] = (tuple(dims.values()), shares, text)
    return found


def _few(axis: Floats, count: int) -> Floats:
    ordered = np.unique(axis)
    return np.asarray(
        ordered[np.unique(np.linspace(0, ordered.size - 1, min(count, ordered.size)).round().astype(int))]
    )
