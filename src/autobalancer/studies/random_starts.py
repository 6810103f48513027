"""The ends of ordinary runs from random starts or a grid of them, and sweeps.

They are asked for where ends have no names: after run-ups from random starts, and where balls need not come to rest in the
rotor, as with gravity in its plane. Such an end is named by the verdict on its run.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any, Unpack

import numpy as np
import xarray as xr

from autobalancer.assembly.drive_train import unbalance_factor
from autobalancer.assembly.quantities import with_value_at
from autobalancer.assembly.resolved import is_resolved
from autobalancer.assembly.system import assemble, start_angles
from autobalancer.assembly.terms import weightless
from autobalancer.catalog.product_tables import NONE_GIVEN
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.files.machine_file import balls_in_races, machine_text, parse_race_machine
from autobalancer.machine import Machine
from autobalancer.machine.path import dimension_of_path
from autobalancer.progress import shows_progress
from autobalancer.random_numbers import generator, wilson_interval
from autobalancer.results.answers.answer import Answer, provenance
from autobalancer.results.answers.studied import IMPOSSIBLE, NOT_RUN
from autobalancer.results.measure_table import SWEPT, peak_deflection
from autobalancer.results.run_arrays import SETTLING_FROM, known_origin
from autobalancer.results.verdict import BALANCED, WORDS
from autobalancer.simulation import MANY_RUNS, ManyRunOptions, run_duration, run_options
from autobalancer.simulation.record import Envelope
from autobalancer.simulation.run import simulate_races
from autobalancer.stability.basins import (
    QUANTILES,
    REVOLUTIONS,
    START_ANGLE,
    axis_name,
    counted_starts,
    quantiles,
    released,
    unit_of_axis,
)
from autobalancer.stability.states.questions import equilibria
from autobalancer.stability.summary import service_of
from autobalancer.studies.ensemble.columns import Columns
from autobalancer.studies.ensemble.ensemble import Variable, ensemble, ensemble_variables
from autobalancer.studies.ensemble.layout import Plan, run_groups
from autobalancer.studies.ensemble.members import Members, with_starts, without_start_angles
from autobalancer.studies.variations import coordinate, listed

FAILED = "failed"
ENDS = (*WORDS, FAILED)
STORED_MEASURES = (
    "vibration",
    "residual_unbalance",
    "static_deflection",
    "support_force",
    "settling_time",
    "peak_deflection",
)
OVERLAPPING = "overlapping start"
OF_RUNS = (*STORED_MEASURES, "outcome", "verdict", "vibration_without_balls", "stalled_balls", "seed", "reason")
DECAYS = 10.0  # decay times after which a motion counts no longer: exp(-10)


def verdict_starts(
    machine: Machine,
    speed: float,
    axes: Mapping[str, Sequence[float]],
    *,
    random: int,
    seed: int,
    acceleration: float | None,
    hold: float | None,
    tolerance: float,
    workers: int | None,
    progress: Callable[[int, int], None] | None,
) -> xr.Dataset:
    """Run a machine to a speed from random ball angles or a grid of starts; an end is the verdict on the run.

    Parameters
    ----------
    machine
        Any machine with balls in races. Its unbalance is that after all schedules; the rotor starts undeflected. Start angles of
        balls that no axis names are those of the machine, or of the seed.
    speed
        Rotor speed, rad/s.
    axes
        One or two of ``ball_angle[i]``, ``ball_speed[i]``, ``ball_speed``, ``acceleration`` with their values, SI.
    random, seed
        Without axes, number of starts; start i, from 0, has the ball angles of seed ``seed + i``.
    acceleration, hold
        Of a ramp from rest, rad/s^2, None starts at ``speed``; time at ``speed``, s, by default :func:`long_enough`.

    Returns
    -------
    xarray.Dataset
        As of :func:`autobalancer.basin`; its states are the words of the verdict. ``vibration``, ``residual_unbalance``,
        ``static_deflection``, ``support_force`` and ``peak_deflection`` of each run are those of :func:`autobalancer.sweep`;
        ``moving_share`` is the share of the runs at whose end a ball moves, ``stalled_share`` of those where one is stalled.

    Raises
    ------
    QuestionError
        Where no verdict is possible: without unbalance, or with excitations.
    """
    if machine.excitations:
        raise QuestionError(
            "basin: the machine has excitations, so there is no verdict on its runs; leave out 'excitations', or use "
            "sweep(machine, {}, seeds=100) for the vibration alone"
        )
    if any(name.startswith("ball_angle") for name in axes):  # the others start where the seed puts them
        drawn = start_angles(resolve(machine), generator(seed))
        machine = with_starts(machine, {f"ball_angle[{number}]": angle for number, angle in enumerate(drawn, 1)})
    hold = hold or long_enough(machine, speed)
    shape = tuple(len(values) for values in axes.values()) or (random,)
    grids = dict(zip(axes, (grid.ravel() for grid in np.meshgrid(*axes.values(), indexing="ij")), strict=True))
    rates = grids.pop("acceleration", np.full(math.prod(shape), acceleration or 0.0))
    # an ensemble for each acceleration
    order, parts, done = list[int](), list[xr.Dataset](), 0
    for rate in np.unique(rates):
        own = np.flatnonzero(rates == rate)
        ramp = speed / float(rate) if rate else 0.0
        steady = with_value_at(driven_to(machine, speed, ramp, drawn=not axes), "run", {"duration": ramp + hold})
        columns = {name: values[own].tolist() for name, values in grids.items()} or (
            _as_it_is(machine, seed) if axes else None
        )
        part = ensemble(
            steady,
            columns,
            seeds=None if axes else random,
            seed=seed,
            tolerance=tolerance,
            impossible="record" if axes else "refuse",
            workers=workers,
            progress=partial(_report_progress, progress, done, rates.size),
        )
        parts.append(part)
        order, done = [*order, *own.tolist()], done + own.size
    names = [name for name in OF_RUNS if all(name in part for part in parts)]
    runs = xr.concat([part.reset_coords("seed")[names] for part in parts], "member", combine_attrs="override")
    runs = runs.isel(member=np.argsort(order)).rename(member="run")
    runs.attrs |= {"hold": hold, "seed": seed, "speed": speed, "tolerance": tolerance}
    result = _verdicts(machine, axes, shape, runs, acceleration)
    result["unbalance"] = unbalance_at(steady, speed)
    if acceleration:
        result["peak_without_balls"] = peak_without_balls(steady, tolerance)
    result.attrs["remarks"] += falling_note(machine, 0.0 if acceleration or "acceleration" in axes else speed)
    return result


def _as_it_is(machine: Machine, seed: int) -> dict[str, list[float]]:
    """A column that changes nothing: the start of the machine."""
    first = resolve(machine)[0].start_angle
    return {"seed": [seed]} if first is None else {"ball_angle[1]": [float(first)]}


def _report_progress(progress: Callable[[int, int], None] | None, before: int, total: int, done: int, _: int) -> None:
    if progress is not None:
        progress(before + done, total)


def _verdicts(
    machine: Machine,
    axes: Mapping[str, Sequence[float]],
    shape: tuple[int, ...],
    runs: xr.Dataset,
    acceleration: float | None,
) -> xr.Dataset:
    """Shares over the starts that are possible, and every run in its place: in the grid, or one after the other."""
    possible = np.flatnonzero(runs["outcome"].values != IMPOSSIBLE)
    if not possible.size:
        raise QuestionError(f"basin: no start is possible: {runs['reason'].values[0]}")
    counted = runs.isel(run=possible)
    if (counted["vibration_without_balls"] == 0.0).all():
        raise QuestionError("basin: the rotor has no unbalance, so there is nothing to balance; add one")
    ends = (*ENDS, OVERLAPPING) if axes else ENDS
    dataset = ends_of(counted, ends).merge(distributions(counted, bool(acceleration)))
    balls = resolve(machine)
    rubs = any(race.friction is not None for balancer in machine.balancers for race in balancer.races)
    attrs: dict[str, Any] = {
        **runs.attrs,
        "title": f"{'Basins' if axes else 'Random starts'} of {machine.name}",
        "states": list(ends),
        "acceleration": acceleration or 0.0,
        "released": released(axes, acceleration, balls),
        "remarks": [] if rubs else [NONE_GIVEN],
    }
    if not axes:
        drawn = [start_angles(balls, generator(int(own)), given=False) for own in runs["seed"].values]
        dataset["start_ball_angle_in_rotor"] = (("run", "ball"), np.array(drawn), START_ANGLE)
        # where every start balances, vibrations differ by nothing that counts
        by = "peak_deflection" if acceleration and (dataset["state"] == ENDS.index(BALANCED)).all() else "vibration"
        worst = int(np.nan_to_num(dataset[by].values).argmax())
        return dataset.assign_attrs(attrs | {"worst": worst, "worst_by": by})
    states = np.full(runs.sizes["run"], len(ENDS))
    states[possible] = dataset["state"].values
    dims = tuple(name.replace("[", "_").rstrip("]") for name in axes)
    over = {name: (dims, runs[name].values.reshape(shape), runs[name].attrs) for name in STORED_MEASURES}
    over["state"] = (dims, states.reshape(shape), dataset["state"].attrs)
    dataset = dataset.drop_vars(["seed", "share_low", "share_high", *over]).assign(over)
    for dim, (path, values) in zip(dims, axes.items(), strict=True):
        label = {"long_name": axis_name(path), "units": unit_of_axis(path)}
        dataset = dataset.assign_coords({dim: (dim, np.asarray(values, np.float64), label)})
    return dataset.assign_attrs(attrs | {"overlapping": int(states.size - possible.size)})


def peak_without_balls(machine: Machine, tolerance: float, duration: float | None = None) -> xr.DataArray:
    """The greatest deflection of a run with held balls, m."""
    held = simulate_races(machine, duration=duration, hold_balls=True, save=[Envelope(500)], tolerance=tolerance)
    peak = peak_deflection(held)["deflection"]
    return xr.DataArray(float(peak), attrs=peak.attrs)


def driven_to(machine: Machine, speed: float, ramp: float, *, drawn: bool = True) -> Machine:
    """The machine with its last unbalance, at a speed after a ramp from rest of this duration, s.

    Start angles that are ``drawn`` are left out.
    """
    profile = {"kind": "ramp", "end": speed, "duration": ramp} if ramp else {"kind": "constant", "speed": speed}
    machine = with_value_at(machine, "start", {})
    machine = with_value_at(machine, "drive", {"kind": "speed", "profile": profile})
    for i, unbalance in enumerate(machine.unbalances, start=1):
        if unbalance.schedule is not None:
            last = {"time": [0.0], "factor": [unbalance_factor(unbalance, math.inf)]}
            machine = with_value_at(machine, f"unbalances[{i}].schedule", last)
    return without_start_angles(machine) if drawn else machine


def long_enough(machine: Machine, speed: float) -> float:
    """Ten decay times of the slowest mode of any stable state without gravity in the plane, within REVOLUTIONS, s."""
    turn = 2.0 * math.pi / speed
    try:
        rates = -equilibria(weightless(machine), speed)["growth_rate"].values
    except AutobalancerError:
        rates = np.zeros(0)
    slowest = min(rates[rates > 0.0], default=math.inf)
    return float(np.clip(DECAYS / slowest, REVOLUTIONS[0] * turn, REVOLUTIONS[1] * turn))


def falling_note(machine: Machine, slowest: float) -> list[str]:
    """A note where guided balls stay on races from which gravity would take them."""
    if machine.axis != "horizontal" or is_resolved(machine):
        return []
    border = math.sqrt(float(machine.gravity) / min(ball.orbit_radius for ball in resolve(machine)))
    if slowest >= border:
        return []
    return [
        f"guided balls stay on their races below {border * 30.0 / math.pi:.3g} rpm too, where gravity would make balls fall "
        "that turn with the rotor; resolved balls do fall"
    ]


def ends_of(runs: xr.Dataset, ends: Sequence[str] = ENDS) -> xr.Dataset:
    """The word of each run and the share of each word."""
    words = np.where(runs["outcome"].values == "finished", runs["verdict"].values, FAILED)
    states = np.array([ends.index(word) for word in words])
    counts = np.bincount(states, minlength=len(ends))
    low, high = wilson_interval(counts, states.size)
    return xr.Dataset(
        {
            "state": ("run", states, {"long_name": "verdict on the run", "flag_meanings": list(ends)}),
            "share": ("end", counts / states.size, {"long_name": "share of the starts", "units": "1"}),
            "share_low": ("end", low, {"long_name": "lower end of its 95 % interval", "units": "1"}),
            "share_high": ("end", high, {"long_name": "upper end of its 95 % interval", "units": "1"}),
        },
        {"end": list(ends), "seed": ("run", runs["seed"].values)},
    )


def unbalance_at(machine: Machine, speed: float) -> xr.DataArray:
    """The unbalance of the rotor in its plane, of several planes the sum of what their balls have to balance, kg m."""
    service = service_of(machine, assemble(machine), speed)
    about = {"long_name": "unbalance without balls", "units": "kg m"}
    return xr.DataArray(service.unbalance if service is not None else np.nan, attrs=about)


def distributions(runs: xr.Dataset, run_up: bool) -> xr.Dataset:
    """What each run leaves, and quantiles over the runs that reached their end, balanced or not; residuals where balls rest."""
    dataset = xr.Dataset({name: ("run", runs[name].values, runs[name].attrs) for name in STORED_MEASURES})
    dataset = dataset.assign_coords(quantile=list(QUANTILES))
    finished = runs["outcome"].values == "finished"
    peaks = (("peak", "peak_deflection"),) if run_up else ()
    for name, values in (("vibration", "vibration"), *peaks):
        dataset[f"{name}_quantile"] = ("quantile", quantiles(runs[values].values[finished]), runs[values].attrs)
    dataset["quantile_starts"] = counted_starts(int(finished.sum()), finished.size, "starts whose runs finish")
    left = runs["residual_unbalance"]
    rests = finished & np.isfinite(left.values)
    dataset["residual_quantile"] = ("quantile", quantiles(left.values[rests]), left.attrs)
    dataset["residual_starts"] = counted_starts(int(rests.sum()), rests.size, "starts whose balls rest")
    moves, alone = np.isnan(runs["settling_time"].values[finished]), runs["vibration_without_balls"]
    stalls = runs["stalled_balls"].values[finished] > 0
    for name, there, text in (("moving", moves, "a ball moves"), ("stalled", stalls, "a ball is stalled")):
        about = {"long_name": f"share of the runs at whose end {text}", "units": "1"}
        dataset[f"{name}_share"] = ((), float(there.mean()) if there.size else np.nan, about)
    dataset["vibration_without_balls"] = ((), float(alone.max()), alone.attrs)
    return dataset


# A thousand run-ups: parameters varied, measures collected, all cores used.


@shows_progress
def sweep(
    machine: Machine | str | Path,
    variations: Mapping[str, Any],
    *,
    grid: bool = True,
    duration: float | str | None = None,
    bins: int = 500,
    vary_seed: bool = False,
    seeds: int | None = None,
    settling_from: str = SETTLING_FROM[0],
    **options: Unpack[ManyRunOptions],
) -> Answer:
    """Run a machine once for every combination of parameters.

    Parameters
    ----------
    machine
        A machine or the path of a machine file.
    variations
        Path of a parameter, such as ``"balancers[1].races[1].drag.damping"``, or a plain name of
        :data:`~autobalancer.machine.path.QUANTITIES`, such as ``"viscosity"``, to its values: SI, texts with units,
        a range as one text such as ``"1:100 mm^2/s:5:log"``, or whole parts as a dict. A single value may stand without a list.
    grid
        True: every combination, one dimension for each parameter. False: all lists have the same length and are varied together,
        along the dimension ``run``.
    duration
        As for :func:`autobalancer.simulate`.
    bins
        Resolution in time of the measures; settling times are interpolated within a bin.
    vary_seed
        Whether each run has start positions of its own, from ``seed`` on.
    seeds
        Number of start positions with which every combination is run, from ``seed`` on, along the dimension ``seed``. Then
        ``variations`` may be empty.
    settling_from
        From where settling times count: the end of the ``"run-up"``, or the last ``"release"`` of a stalled ball, see
        :func:`autobalancer.run_measures`.
    **options
        ``tolerance`` (1e-7), ``method``, ``max_steps``, ``seed``, ``workers``, ``progress`` and ``keep_on_interrupt``, see
        :class:`~autobalancer.simulation.ManyRunOptions`. Runs that Ctrl-C kept from running have the outcome ``not run``.

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
    how, _ = run_options("sweep", options, MANY_RUNS), known_origin(settling_from)
    tolerance, seed = how["tolerance"], how["seed"]
    machine = balls_in_races(machine)
    variations = {name: listed(machine, name, values) for name, values in variations.items()}
    end = run_duration(machine, duration)
    if seeds is not None and (seeds < 1 or vary_seed):
        raise QuestionError(f"seeds: given {seeds}; must be at least 1, and is taken in place of vary_seed")
    # points of the grid, or one point with many starts
    shape, points = _points(variations, grid) if variations or seeds is None else ((), [()])
    shape = (*shape, seeds) if seeds is not None else shape
    lists: dict[str, Sequence[Any]] = {name: [point[i] for point in points] for i, name in enumerate(variations)}
    own = np.arange(seed, seed + len(points)) if vary_seed else None
    columns = Columns(len(points), lists, seeds=own)
    drawn = np.arange(seed, seed + seeds) if seeds is not None else None
    # all members run in groups of one layout, each on several threads
    plan = Plan(end, tolerance, bins, how["max_steps"], how["method"])
    members = Members(machine, columns, drawn, seed, "")
    groups, reasons = members.sorted(plan, "refuse")
    ran, _, interrupted = run_groups(groups, how["workers"], how["progress"] or None)
    if interrupted and not how["keep_on_interrupt"]:
        raise KeyboardInterrupt
    found = ensemble_variables(members, ran, reasons, settling_from)
    about = {"duration": end, "tolerance": tolerance, "bins": bins, "seed": seed, "settling_from": settling_from}
    dataset = _dataset(machine, variations, grid, shape, found, about)
    return Answer.of(dataset.assign_coords(seed=drawn) if drawn is not None else dataset, "Swept")


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
    found: Mapping[str, Variable],
    about: dict[str, Any],
) -> xr.Dataset:
    """Members at the places of their points; one that Ctrl-C left out has no verdict."""
    names = [dimension_of_path(path) for path in variations]
    dims = (tuple(names) if grid else ("run",)) if names else ()
    dims = dims if len(dims) == len(shape) else (*dims, "seed")
    variables: dict[str, Variable] = {}
    for name in (*(measure.name for measure in SWEPT), "outcome", "verdict", "balanced"):
        _, values, label = found[name]
        variables[name] = (
            (*dims, "ball")[: len(dims) + values.ndim - 1],
            values.reshape(shape + values.shape[1:]),
            label,
        )
    variables["verdict"][1][variables["outcome"][1] == NOT_RUN] = ""
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


# The worst of random starts as a machine of its own, to run it again and look at it.


def worst_start(found: xr.Dataset) -> Machine:
    """The machine of the worst of random starts, with its start angles, its drive and the duration of its run.

    The worst has the greatest vibration at the end of its run, of run-ups that all balance the greatest deflection on the
    way, on planar machines without run-up the greatest deflection at its end; ``found.attrs["worst_by"]`` says which.
    An ordinary run of the machine repeats it, with the same tolerance and the seed ``found["seed"][found.attrs["worst"]]``
    digit for digit. A planar basin lets balls of known size pass through each other, which they do not in a run.

    Parameters
    ----------
    found
        From :func:`autobalancer.basin` with random starts.

    Raises
    ------
    QuestionError
        If ``found`` holds no random starts.
    """
    if "start_ball_angle_in_rotor" not in found:
        raise QuestionError(
            "worst_start: this is not a result of basin() with random starts; ask basin(..., random=50)"
        )
    about = found.attrs
    number, speed, acceleration = int(about["worst"]), float(about["speed"]), float(about["acceleration"])
    ramp = speed / acceleration if acceleration else 0.0
    machine = driven_to(parse_race_machine(str(about["machine"])), speed, ramp)
    angles = found["start_ball_angle_in_rotor"].values[number].tolist()
    machine = with_starts(machine, {f"ball_angle[{ball}]": angle for ball, angle in enumerate(angles, 1)})
    text = f"Start {number + 1} of {found.sizes['run']} random starts, the worst"
    return with_value_at(with_value_at(machine, "description", text), "run", {"duration": ramp + float(about["hold"])})
