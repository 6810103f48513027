"""The ends of ordinary runs over axes of starts, for machines whose ends are verdicts: members of an ensemble."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np
import xarray as xr

from autobalancer.assembly.parameters import with_value_at
from autobalancer.catalog.friction_table import NONE_GIVEN
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.results.answers.ensemble import IMPOSSIBLE
from autobalancer.stability.basins.basin import released
from autobalancer.stability.basins.starts import axis_name, unit_of_axis
from autobalancer.studies.ensemble.ensemble import ensemble
from autobalancer.studies.random_starts import (
    ENDS,
    KEPT,
    distributions,
    driven_to,
    ends_of,
    falling_note,
    long_enough,
    peak_without_balls,
    refuse_excitations,
    refuse_no_unbalance,
)

OVERLAPPING = "overlapping start"
OF_RUNS = (*KEPT, "outcome", "verdict", "vibration_without_balls", "residual_share", "seed", "reason")
_AXIS = re.compile(r"ball_angle\[\d+\]|ball_speed(\[\d+\])?|acceleration")


def gridded_starts(
    machine: Machine,
    speed: float,
    axes: Mapping[str, Sequence[float]],
    *,
    seed: int = 0,
    acceleration: float | None = None,
    hold: float | None = None,
    tolerance: float = 1e-6,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Run a machine to a speed from every point of a grid of starts; an end is the verdict on the run.

    Parameters
    ----------
    machine
        Any machine with balls in races. Its unbalance is that after all schedules; the rotor starts undeflected. Start angles of
        balls that no axis names are those of the machine.
    speed
        Rotor speed, rad/s.
    axes
        One or two of ``ball_angle[i]``, ``ball_speed[i]``, ``ball_speed``, ``acceleration`` with their values, SI.
    acceleration, hold
        Of a ramp from rest, rad/s^2, None starts at ``speed``; time at ``speed``, s, by default :func:`long_enough`.

    Returns
    -------
    xarray.Dataset
        As of :func:`autobalancer.basin` over these axes; its states are the words of the verdict.

    Raises
    ------
    QuestionError
        For unknown axes, start angles that are missing, where no verdict is possible.
    """
    _refuse(machine, axes)
    refuse_excitations(machine)
    hold = hold or long_enough(machine, speed)
    shape = tuple(len(values) for values in axes.values())
    grids = dict(zip(axes, (grid.ravel() for grid in np.meshgrid(*axes.values(), indexing="ij")), strict=True))
    rates = grids.pop("acceleration", np.full(math.prod(shape), acceleration or 0.0))
    order, parts, done = list[int](), list[xr.Dataset](), 0
    for rate in np.unique(rates):
        own = np.flatnonzero(rates == rate)
        ramp = speed / float(rate) if rate else 0.0
        steady = with_value_at(driven_to(machine, speed, ramp, drawn=False), "run", {"duration": ramp + hold})
        columns = {name: values[own].tolist() for name, values in grids.items()} or _as_it_is(machine, seed)
        told = partial(_told, progress, done, rates.size)
        parts.append(
            ensemble(
                steady, columns, seed=seed, tolerance=tolerance, impossible="record", workers=workers, progress=told
            )
        )
        order, done = [*order, *own.tolist()], done + own.size
    names = [name for name in OF_RUNS if all(name in part for part in parts)]
    runs = xr.concat([part.reset_coords("seed")[names] for part in parts], "member", combine_attrs="override")
    runs = runs.isel(member=np.argsort(order)).rename(member="run")
    runs.attrs |= {"hold": hold, "seed": seed, "speed": speed, "tolerance": tolerance}
    found = _dataset(machine, axes, shape, runs, acceleration)
    if acceleration:
        found["peak_without_balls"] = peak_without_balls(steady, tolerance)
    found.attrs |= falling_note(machine, 0.0 if acceleration or "acceleration" in axes else speed)
    return found


def _refuse(machine: Machine, axes: Mapping[str, Sequence[float]]) -> None:
    balls = len(resolve(machine))
    for name, values in axes.items():
        ball = name.partition("[")[2].rstrip("]")
        if not _AXIS.fullmatch(name) or (ball and not 1 <= int(ball) <= balls):
            raise QuestionError(
                f"basin: no axis {name!r}; there are ball_angle[1] to ball_angle[{balls}], ball_speed[i], ball_speed, "
                "acceleration"
            )
        if not len(values) or not np.all(np.isfinite(values)):
            raise QuestionError("basin: each axis needs a list of finite numbers")
        if name == "acceleration" and min(values) <= 0.0:
            raise QuestionError("basin: an acceleration must be greater than zero")


def _as_it_is(machine: Machine, seed: int) -> dict[str, list[float]]:
    """A column that changes nothing: the start of the machine."""
    first = resolve(machine)[0].start_angle
    return {"seed": [seed]} if first is None else {"ball_angle[1]": [float(first)]}


def _told(progress: Callable[[int, int], None] | None, before: int, total: int, done: int, _: int) -> None:
    if progress is not None:
        progress(before + done, total)


def _dataset(
    machine: Machine,
    axes: Mapping[str, Sequence[float]],
    shape: tuple[int, ...],
    runs: xr.Dataset,
    acceleration: float | None,
) -> xr.Dataset:
    """Shares over the starts that are possible, and every run at its place in the grid."""
    possible = np.flatnonzero(runs["outcome"].values != IMPOSSIBLE)
    reason = str(runs["reason"].values[0]) if "reason" in runs else ""
    if not possible.size:
        raise QuestionError(f"basin: no start is possible: {reason}")
    counted = runs.isel(run=possible)
    refuse_no_unbalance(counted)
    found = ends_of(counted, (*ENDS, OVERLAPPING)).drop_vars("seed")
    states = np.full(runs.sizes["run"], len(ENDS))
    states[possible] = found["state"].values
    spread = distributions(counted, bool(acceleration))
    dims = tuple(name.replace("[", "_").rstrip("]") for name in axes)
    over = {name: (dims, runs[name].values.reshape(shape), runs[name].attrs) for name in KEPT}
    over["state"] = (dims, states.reshape(shape), found["state"].attrs)
    found = found.drop_vars(["state", "share_low", "share_high"]).merge(spread.drop_vars(KEPT)).assign(over)
    for dim, (path, values) in zip(dims, axes.items(), strict=True):
        label = {"long_name": axis_name(path), "units": unit_of_axis(path)}
        found = found.assign_coords({dim: (dim, np.asarray(values, np.float64), label)})
    rubs = any(race.friction is not None for balancer in machine.balancers for race in balancer.races)
    found.attrs = {
        **runs.attrs,
        "title": f"Basins of {machine.name}",
        "states": [*ENDS, OVERLAPPING],
        "acceleration": acceleration or 0.0,
        "overlapping": int(states.size - possible.size),
        "released": released(axes, acceleration, resolve(machine)),
        **({} if rubs else {"friction_text": NONE_GIVEN}),
    }
    return found
