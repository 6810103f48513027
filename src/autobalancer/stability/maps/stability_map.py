"""Stability maps: the growth rate of the balanced state over any two parameters."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
import xarray as xr

from autobalancer.arrays import Floats
from autobalancer.assembly.quantities import parameter_range, si_value, value_of, with_quantity
from autobalancer.assembly.terms import Theory, unknown, weightless
from autobalancer.catalog.product_tables import fluid, fluids
from autobalancer.errors import CatalogError, QuestionError, one_of
from autobalancer.files.machine_file import balls_in_races
from autobalancer.machine import Machine
from autobalancer.machine.path import QUANTITIES, axis_attributes, dimension_of, parts_of
from autobalancer.memory import refuse_beyond_memory
from autobalancer.progress import shows_progress
from autobalancer.results.answers.answer import Answer
from autobalancer.results.labels import labeled
from autobalancer.stability.border import attributes
from autobalancer.stability.friction import held_share
from autobalancer.stability.host.stations import is_planar
from autobalancer.stability.maps.balanced import balanced_states
from autobalancer.stability.maps.curve import (
    VARIABLES,
    border_curve,
    rates_over,
    unbalances_to_capability,
    with_values,
)
from autobalancer.stability.maps.exact import borders_of, positive_speed
from autobalancer.stability.stall.capture import CAPTURE, RELEASE
from autobalancer.stability.states.rest_states import described
from autobalancer.units import to_si

Axis = Sequence[Any] | Floats | str
Progress = Callable[[int, int], None]


@shows_progress
def map(
    machine: Machine | str | Path,
    axes: Mapping[str, Axis],
    *,
    speed: float | str | None = None,
    positions: Literal["worst", "best"] = "worst",
    operating_points: Mapping[str, tuple[Any, Any]] | None = None,
    borders: int = 61,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Answer:
    """Growth rate of the balanced state over two parameters, with the border speeds.

    Two or more equal balls on a planar rotor with isotropic supports use compiled code, about a microsecond per point;
    for other machines the eigenvalues are computed or, on anisotropic supports, the multipliers of every point.

    Parameters
    ----------
    machine
        A machine or the path of a machine file.
    axes
        Two parameters with their values, SI, strings with units, or a range such as ``"500:3000 rpm:200"``: ``"speed"``, names of
        :data:`autobalancer.machine.path.QUANTITIES` such as ``"viscosity"``, or paths.
    speed
        The rotor speed where it is not an axis, rad/s; by default the one at which the machine's drive ends.
    positions
        For more than two balls, which have many balanced positions: use the least or the most stable one.
    operating_points
        Name to a pair of values along the axes. The machine itself is one if it has both values.
    borders
        With the speed as an axis: number of values of the other parameter at which border speeds are computed; 0 for none,
        also for no release speed over the plane of two other parameters.
    workers
        Threads of the compiled code; by default one for each core.
    progress
        Called with (rows done, rows in all); values at which border speeds are computed count as rows.

    Returns
    -------
    xarray.Dataset
        ``growth_rate`` (1/s) over both parameters, nan where there is no balanced state; the borders of
        :func:`border_curve` over ``<other>_of_border``, or without the speed as an axis ``release_speed`` and
        ``capture_speed`` over coarser values of both; with friction ``held_share`` over ``<name>_of_friction``: the whirl
        that friction holds over that of the unbalance alone, above one where balls at rest do not move; ``operating_point``
        with its values; for a viscosity the fluids of the catalog along it.

    Raises
    ------
    QuestionError
        Unless there are two different axes with values, for an unknown name, a missing speed, or no balls.
    MachineError
        If a combination makes no possible machine; the message names it.
    """
    machine = balls_in_races(machine)
    if len(axes) != 2:
        raise QuestionError(f"stability map: given {len(axes)} parameters; give two, such as 'speed' and 'viscosity'")
    one_of("positions", positions, "worst", "best")
    values = {name: _numbers(machine, name, axis) for name, axis in axes.items()}
    refuse_beyond_memory(
        "stability map", math.prod(v.size for v in values.values()), "points", 400.0, "; ask for fewer"
    )
    fixed = math.nan
    if "speed" not in axes:
        fixed = value_of(machine, "speed") if speed is None else positive_speed(speed)
        if not fixed > 0.0:
            raise QuestionError(
                "speed: it is neither an axis nor prescribed by the machine's drive; give one, in rad/s"
            )
    elif speed is not None:
        raise QuestionError("speed: given twice, as an axis and as a number; leave out one of them")
    later = min(borders, max(axis.size for name, axis in values.items() if name != "speed")) if "speed" in axes else 0
    first, second = _split_progress(progress, later)
    # growth rates at all points; the rest of the map stands on them
    rates = rates_over(machine, values, fixed, positions == "worst", workers, first)
    dataset = _dataset(machine, values, rates, fixed, positions)
    if later > 0:
        dataset = with_borders(dataset, machine, values, borders, second)
    elif borders > 0:
        dataset = with_release(dataset, machine, values)
    # what a person wants to see beside stability: friction that holds balls, points, fluids
    dataset = with_friction_share(dataset, machine, values)
    dataset = with_operating_points(dataset, machine, list(values), operating_points or {})
    return Answer.of(with_fluids(dataset, machine, list(values)), "StabilityMap")


def _split_progress(progress: Progress | None, later: int) -> tuple[Progress | None, Progress | None]:
    """Progress of rows, and of about ``later`` values that follow them, as one."""
    if progress is None:
        return None, None
    told, rows = progress, 0

    def first(done: int, total: int) -> None:
        nonlocal rows
        rows = total
        told(done, total + later)

    return first, lambda done, total: told(rows + done, rows + total)


def _numbers(machine: Machine, name: str, axis: Axis) -> Floats:
    for part in parts_of(name):
        if part not in ("speed", *QUANTITIES) and "." not in part:
            raise QuestionError(
                f"{part!r} is not a parameter; available are speed, {', '.join(QUANTITIES)}, and paths with dots"
            )
    if isinstance(axis, str):
        axis = parameter_range(machine, name, axis)
    points = [value.item() if isinstance(value, np.generic) else value for value in axis]
    if not points:
        raise QuestionError(f"{name}: given no values; give at least one")
    if name != "speed":
        with_quantity(machine, name, points[0])  # says what is wrong before the work begins
        return np.array([si_value(machine, name, value) for value in points], np.float64)
    numbers = np.array([float(to_si(value, "rad/s")) for value in points])
    if not (numbers > 0.0).all():
        raise QuestionError(f"speed: given {float(numbers.min()):.6g} rad/s; must be greater than zero")
    return numbers


def _dataset(machine: Machine, values: dict[str, Floats], rates: Floats, speed: float, positions: str) -> xr.Dataset:
    axes = {dimension_of(name): (name, numbers) for name, numbers in values.items()}
    p = described(weightless(machine), None)
    about = attributes(machine, f"Stability map of {machine.name}", Theory.AT_REST) | {
        "parameters": list(values),
        "positions": positions if p.moment.size > 2 else "only ones",
        "unbalance": abs(p.unbalance),
        "theory": f"exact: full equations, {balanced_states(p)[0].route}",
        "ignores": ", ".join(unknown(with_friction(machine, values), Theory.AT_REST)),
        **({} if math.isnan(speed) else {"speed": speed}),
    }
    result = labeled({"growth_rate": (tuple(axes), rates, "growth rate of the balanced state", "1/s")}, None, about)
    return result.assign_coords({dim: (dim, numbers, axis_attributes(name)) for dim, (name, numbers) in axes.items()})


# What is drawn on a map besides the growth rate: border speeds, operating points, fluids of the catalog.


COARSE = 11  # values of each axis at which release and capture speed are found


def with_borders(
    dataset: xr.Dataset,
    machine: Machine,
    values: dict[str, Floats],
    count: int,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """The border speeds over the axis that is not the speed, at ``count`` of its values; ``progress`` counts these."""
    other = next(name for name in values if name != "speed")
    axis = np.unique(values[other])
    chosen = _thinned(axis, count)
    if other == "unbalance" and is_planar(machine):  # the border has a narrow peak over it
        dense = unbalances_to_capability(machine, 2 * count)
        chosen = np.unique([*chosen, *dense[(dense >= axis[0]) & (dense <= axis[-1])]])
    curve = border_curve(machine, other, chosen, up_to=float(values["speed"].max()), progress=progress)
    dim = dimension_of(other)
    kept = [name for name in (*VARIABLES.values(), "critical_speed") if name in curve]
    return dataset.merge(curve[kept].rename({dim: f"{dim}_of_border"}))


def with_release(dataset: xr.Dataset, machine: Machine, values: dict[str, Floats]) -> xr.Dataset:
    """Release and capture speed over two axes without the speed, at a few values of each."""
    few = [_thinned(axis, COARSE) for axis in values.values()]
    speeds = np.full((2, *(axis.size for axis in few)), np.nan)
    for i, first in enumerate(few[0].tolist()):
        for j, second in enumerate(few[1].tolist()):
            changed, p = with_values(machine, dict(zip(values, (first, second), strict=True)))
            borders = borders_of(changed, p, (RELEASE, CAPTURE), float(dataset.attrs["speed"]))
            named = {border.name: border.speed for border in borders}
            speeds[:, i, j] = [named.get(name, math.nan) for name in (RELEASE, CAPTURE)]
    dims = [f"{dimension_of(name)}_of_border" for name in values]
    dataset = dataset.assign_coords(dict(zip(dims, few, strict=True)))
    for name, table in zip((RELEASE, CAPTURE), speeds, strict=True):
        dataset[name.replace(" ", "_")] = (dims, table, {"long_name": name, "units": "rad/s"})
    return dataset


def with_operating_points(
    dataset: xr.Dataset, machine: Machine, names: list[str], points: Mapping[str, tuple[Any, Any]]
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
        return dataset
    table = np.array(list(rows.values()))
    for name, column in zip(names, table.T, strict=True):
        dim = dimension_of(name)
        attrs = {
            "long_name": f"{dataset[dim].attrs['long_name']} of the operating point",
            "units": dataset[dim].attrs["units"],
        }
        dataset[f"operating_{dim}"] = ("operating_point", column, attrs)
    return dataset.assign_coords(operating_point=("operating_point", list(rows)))


def with_fluids(dataset: xr.Dataset, machine: Machine, names: list[str]) -> xr.Dataset:
    """The fluids of the catalog along a viscosity axis, at the temperature of the machine's fluid, else 25 degC."""
    if "viscosity" not in names:
        return dataset
    races = (race for balancer in machine.balancers for race in balancer.races)
    known = (race.fluid.temperature for race in races if race.fluid is not None and race.fluid.temperature is not None)
    temperature = float(next(known, 298.15))
    low, high = float(dataset["viscosity"].min()), float(dataset["viscosity"].max())
    rows = []
    for entry in fluids():
        try:
            state = fluid(entry.name, temperature)
        except CatalogError:  # not known at this temperature
            continue
        if low <= state.viscosity <= high:
            rows.append((entry.name, entry.family, state.viscosity, state.density))
    if not rows:
        return dataset
    rows.sort(key=lambda row: row[2])
    dataset = dataset.assign_coords(fluid=("fluid", [row[0] for row in rows]))
    dataset["fluid_family"] = ("fluid", [row[1] for row in rows], {"long_name": "family of the fluid"})
    attrs = {"long_name": "kinematic viscosity of the fluid", "units": "m^2/s", "temperature": temperature}
    dataset["fluid_viscosity"] = ("fluid", [row[2] for row in rows], attrs)
    attrs = {"long_name": "its density; the map keeps that of the machine's fluid", "units": "kg/m^3"}
    dataset["fluid_density"] = ("fluid", [row[3] for row in rows], attrs)
    return dataset


# Where on a map friction holds balls at rest: the whirl it holds against that of the unbalance.


COARSE_VALUES = 25  # values of a parameter
SPEEDS = 120


def with_friction(machine: Machine, values: Mapping[str, Floats]) -> Machine:
    """The machine as it is somewhere on the map: with rolling resistance if that is an axis."""
    name = "rolling_resistance"
    return with_quantity(machine, name, float(values[name].max())) if name in values else machine


def with_friction_share(dataset: xr.Dataset, machine: Machine, values: dict[str, Floats]) -> xr.Dataset:
    """``held_share`` over coarser values of both axes; nothing is added to a map without friction."""
    races = [race for balancer in with_friction(machine, values).balancers for race in balancer.races]
    if all(race.friction is None for race in races):
        return dataset
    few = {name: _thinned(axis, SPEEDS if name == "speed" else COARSE_VALUES) for name, axis in values.items()}
    shares = np.empty(tuple(axis.size for axis in few.values()))
    names = list(few)
    if "speed" in names:
        other = 1 - names.index("speed")
        for number, value in enumerate(few[names[other]].tolist()):
            row = held_share(with_quantity(machine, names[other], value), few["speed"])
            shares[(slice(None), number) if other == 1 else (number, slice(None))] = row
    else:
        speed = np.array([float(dataset.attrs["speed"])])
        for i, first in enumerate(few[names[0]].tolist()):
            changed = with_quantity(machine, names[0], first)
            for j, second in enumerate(few[names[1]].tolist()):
                shares[i, j] = held_share(with_quantity(changed, names[1], second), speed)[0]
    dims = {name: f"{dimension_of(name)}_of_friction" for name in names}
    dataset = dataset.assign_coords({dims[name]: axis for name, axis in few.items()})
    text = {"long_name": "whirl that friction holds over that of the unbalance alone", "units": "1"}
    dataset["held_share"] = (tuple(dims.values()), shares, text)
    return dataset


def _thinned(axis: Floats, count: int) -> Floats:
    """So many of its values, ascending, evenly chosen."""
    ordered = np.unique(axis)
    return np.asarray(
        ordered[np.unique(np.linspace(0, ordered.size - 1, min(count, ordered.size)).round().astype(int))]
    )
