"""What is drawn on a map besides the growth rate: border speeds, operating points, fluids of the catalog."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.assembly.quantities import si_value, value_of
from autobalancer.catalog.fluid_table import fluid, fluids
from autobalancer.errors import CatalogError, QuestionError
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.machine.plain_names import dimension_of
from autobalancer.stability.host.planar import Floats
from autobalancer.stability.maps.curve import VARIABLES, border_curve, unbalances_to_capability
from autobalancer.stability.maps.map_rates import with_values
from autobalancer.stability.maps.speeds import borders_of
from autobalancer.stability.stall.notes import CAPTURE, RELEASE
from autobalancer.units import to_si

COARSE = 11  # values of each axis at which release and capture speed are found


def with_borders(
    found: xr.Dataset,
    machine: Machine,
    values: dict[str, Floats],
    count: int,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """The border speeds over the axis that is not the speed, at ``count`` of its values; ``progress`` counts these."""
    other = next(name for name in values if name != "speed")
    axis = np.unique(values[other])
    chosen = axis[np.unique(np.linspace(0, axis.size - 1, min(count, axis.size)).round().astype(int))]
    if other == "unbalance" and isinstance(machine.rotor, PlanarRotor):  # the border has a narrow peak over it
        dense = unbalances_to_capability(machine, 2 * count)
        chosen = np.unique([*chosen, *dense[(dense >= axis[0]) & (dense <= axis[-1])]])
    curve = border_curve(machine, other, chosen, up_to=float(values["speed"].max()), progress=progress)
    dim = dimension_of(other)
    kept = [name for name in (*VARIABLES.values(), "critical_speed") if name in curve]
    return found.merge(curve[kept].rename({dim: f"{dim}_of_border"}))


def with_release(found: xr.Dataset, machine: Machine, values: dict[str, Floats]) -> xr.Dataset:
    """Release and capture speed over two axes without the speed, at a few values of each."""
    few = [
        axis[np.unique(np.linspace(0, axis.size - 1, min(COARSE, axis.size)).round().astype(int))]
        for axis in (np.unique(axis) for axis in values.values())
    ]
    speeds = np.full((2, *(axis.size for axis in few)), np.nan)
    for i, first in enumerate(few[0].tolist()):
        for j, second in enumerate(few[1].tolist()):
            changed, p = with_values(machine, dict(zip(values, (first, second), strict=True)))
            borders = borders_of(changed, p, (RELEASE, CAPTURE), float(found.attrs["speed"]))
            named = {border.name: border.speed for border in borders}
            speeds[:, i, j] = [named.get(name, math.nan) for name in (RELEASE, CAPTURE)]
    dims = [f"{dimension_of(name)}_of_border" for name in values]
    found = found.assign_coords(dict(zip(dims, few, strict=True)))
    for name, table in zip((RELEASE, CAPTURE), speeds, strict=True):
        found[name.replace(" ", "_")] = (dims, table, {"long_name": name, "units": "rad/s"})
    return found


def with_operating_points(
    found: xr.Dataset, machine: Machine, names: list[str], points: Mapping[str, tuple[Any, Any]]
) -> xr.Dataset:
    """Named points on the map; the machine itself is the first, if it has a value along both axes."""
    rows: dict[str, tuple[float, ...]] = {}
    own = tuple(value_of(machine, name) for name in names)
    if all(math.isfinite(value) for value in own):
        rows[machine.name] = own
    for label, pair in points.items():
        if len(pair) != 2:
            raise QuestionError(f"operating point {label!r}: given {len(pair)} values; give one along each axis")
        rows[label] = tuple(
            float(to_si(value, "rad/s")) if name == "speed" else si_value(machine, name, value)
            for name, value in zip(names, pair, strict=True)
        )
    if not rows:
        return found
    table = np.array(list(rows.values()))
    for name, column in zip(names, table.T, strict=True):
        dim = dimension_of(name)
        attrs = {
            "long_name": f"{found[dim].attrs['long_name']} of the operating point",
            "units": found[dim].attrs["units"],
        }
        found[f"operating_{dim}"] = ("operating_point", column, attrs)
    return found.assign_coords(operating_point=("operating_point", list(rows)))


def with_fluids(found: xr.Dataset, machine: Machine, names: list[str]) -> xr.Dataset:
    """The fluids of the catalog along a viscosity axis, at the temperature of the machine's fluid, else 25 degC."""
    if "viscosity" not in names:
        return found
    temperature = _temperature(machine)
    low, high = float(found["viscosity"].min()), float(found["viscosity"].max())
    rows = []
    for entry in fluids():
        try:
            state = fluid(entry.name, temperature)
        except CatalogError:  # not known at this temperature
            continue
        if low <= state.viscosity <= high:
            rows.append((entry.name, entry.family, state.viscosity, state.density))
    if not rows:
        return found
    rows.sort(key=lambda row: row[2])
    found = found.assign_coords(fluid=("fluid", [row[0] for row in rows]))
    found["fluid_family"] = ("fluid", [row[1] for row in rows], {"long_name": "family of the fluid"})
    attrs = {"long_name": "kinematic viscosity of the fluid", "units": "m^2/s", "temperature": temperature}
    found["fluid_viscosity"] = ("fluid", [row[2] for row in rows], attrs)
    attrs = {"long_name": "its density; the map keeps that of the machine's fluid", "units": "kg/m^3"}
    found["fluid_density"] = ("fluid", [row[3] for row in rows], attrs)
    return found


def _temperature(machine: Machine) -> float:
    for balancer in machine.balancers:
        for race in balancer.races:
            if race.fluid is not None and race.fluid.temperature is not None:
                return float(race.fluid.temperature)
    return 298.15
