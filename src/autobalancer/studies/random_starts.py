"""The ends of ordinary runs from random starts: run-ups, and machines whose balls need not come to rest in the rotor.

Such are rotors with gravity in the plane and rotors that tilt or bend. An end is named by the verdict on its run.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any, Unpack

import numpy as np
import xarray as xr

from autobalancer.assembly.drive_train import unbalance_factor
from autobalancer.assembly.quantities import with_value_at
from autobalancer.assembly.resolved import is_resolved
from autobalancer.assembly.system import start_angles
from autobalancer.assembly.terms import weightless
from autobalancer.catalog.product_tables import NONE_GIVEN
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.files.machine_file import balls_in_races, machine_text, parse_race_machine
from autobalancer.machine import Machine
from autobalancer.machine.path import dimension_of_path
from autobalancer.progress import shows_progress
from autobalancer.random_numbers import generator
from autobalancer.results.answers.answer import Answer, provenance
from autobalancer.results.answers.studied import NOT_RUN
from autobalancer.results.measure_table import SWEPT, peak_deflection
from autobalancer.results.run_arrays import SETTLING_FROM, known_origin
from autobalancer.results.verdict import BALANCED, WORDS, wilson_interval
from autobalancer.simulation import MANY_RUNS, ManyRunOptions, run_duration, run_options
from autobalancer.simulation.record import Envelope
from autobalancer.simulation.run import simulate_races
from autobalancer.stability.basins import QUANTILES, REVOLUTIONS, START_ANGLE, counted_starts, quantiles, released
from autobalancer.stability.states.questions import equilibria
from autobalancer.studies.ensemble.columns import Columns
from autobalancer.studies.ensemble.ensemble import Variable, ensemble_variables
from autobalancer.studies.ensemble.layout import Plan, run_groups
from autobalancer.studies.ensemble.members import Members, without_start_angles
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
DECAYS = 10.0  # decay times after which a motion counts no longer: exp(-10)


def random_starts(
    machine: Machine,
    speed: float,
    count: int,
    *,
    seed: int = 0,
    acceleration: float | None = None,
    hold: float | None = None,
    tolerance: float = 1e-6,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Run a machine to a speed from random ball angles and count the verdicts.

    Parameters
    ----------
    machine
        Any machine with balls in races. Its unbalance is that after all schedules; the rotor starts undeflected.
    speed
        Rotor speed, rad/s.
    count, seed
        Number of starts; start i, from 0, has the ball angles of seed ``seed + i``.
    acceleration
        Of a ramp from rest, rad/s^2; None starts at ``speed``.
    hold
        Time at ``speed``, s; by default :func:`long_enough`.

    Returns
    -------
    xarray.Dataset
        As of :func:`autobalancer.basin` with random starts; its states are the words of the verdict. ``vibration``,
        ``residual_unbalance``, ``static_deflection``, ``support_force`` and ``peak_deflection`` of each run are those of
        :func:`autobalancer.sweep`; ``moving_share`` is the share of the runs at whose end a ball moves.

    Raises
    ------
    QuestionError
        Where no verdict is possible: without unbalance, or with excitations.
    """
    refuse_excitations(machine)
    hold = hold or long_enough(machine, speed)
    ramp = speed / acceleration if acceleration else 0.0
    steady = with_value_at(driven_to(machine, speed, ramp), "run", {"duration": ramp + hold})
    runs = sweep(
        steady,
        {},
        seeds=count,
        seed=seed,
        tolerance=tolerance,
        workers=workers,
        progress=progress,
    )
    refuse_no_unbalance(runs)
    result = ends_of(runs).merge(distributions(runs, ramp > 0.0))
    balls = resolve(machine)
    drawn = [start_angles(balls, generator(int(own)), given=False) for own in runs["seed"].values]
    result["start_ball_angle_in_rotor"] = (("run", "ball"), np.array(drawn), START_ANGLE)
    if ramp:
        result["peak_without_balls"] = peak_without_balls(steady, tolerance)
    rubs = any(race.friction is not None for balancer in machine.balancers for race in balancer.races)
    own: dict[str, Any] = {
        "title": f"Random starts of {machine.name}",
        "states": list(ENDS),
        "speed": speed,
        "hold": hold,
        "acceleration": acceleration or 0.0,
        "released": released((), acceleration, balls),
    }
    # where every start balances, vibrations differ by nothing that counts
    by = "peak_deflection" if ramp and (result["state"] == ENDS.index(BALANCED)).all() else "vibration"
    own |= {"worst": int(np.nan_to_num(result[by].values).argmax()), "worst_by": by}
    falling = falling_note(machine, 0.0 if acceleration else speed)
    result.attrs = {**runs.attrs, **own, "remarks": [*([] if rubs else [NONE_GIVEN]), *falling]}
    return result


def refuse_excitations(machine: Machine) -> None:
    """No verdict is possible under them."""
    if machine.excitations:
        raise QuestionError(
            "basin: the machine has excitations, so there is no verdict on its runs; leave out 'excitations', or use "
            "sweep(machine, {}, seeds=100) for the vibration alone"
        )


def refuse_no_unbalance(runs: xr.Dataset) -> None:
    """Nor without anything to balance."""
    if (runs["vibration_without_balls"] == 0.0).all():
        raise QuestionError("basin: the rotor has no unbalance, so there is nothing to balance; add one")


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


def distributions(runs: xr.Dataset, run_up: bool) -> xr.Dataset:
    """What each run leaves, and its quantiles over the runs that reached their end, balanced or not."""
    dataset = xr.Dataset({name: ("run", runs[name].values, runs[name].attrs) for name in STORED_MEASURES})
    dataset = dataset.assign_coords(quantile=list(QUANTILES))
    finished = runs["outcome"].values == "finished"
    peaks = (("peak", "peak_deflection"),) if run_up else ()
    for name, values in (("vibration", "vibration"), ("residual", "residual_unbalance"), *peaks):
        dataset[f"{name}_quantile"] = ("quantile", quantiles(runs[values].values[finished]), runs[values].attrs)
    dataset["quantile_starts"] = counted_starts(int(finished.sum()), finished.size, "starts whose runs finish")
    moves, alone = np.isnan(runs["settling_time"].values[finished]), runs["vibration_without_balls"]
    whole = float((runs["residual_unbalance"] / runs["residual_share"]).median())
    about = {"long_name": "share of the runs at whose end a ball moves", "units": "1"}
    dataset["moving_share"] = ((), float(moves.mean()) if moves.size else np.nan, about)
    dataset["vibration_without_balls"] = ((), float(alone.max()), alone.attrs)
    dataset["unbalance"] = ((), whole, {"long_name": "unbalance without balls", "units": "kg m"})
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
        :func:`autobalancer.settling_time`.
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
    for i, balancer in enumerate(machine.balancers, start=1):
        for j, race in enumerate(balancer.races, start=1):
            groups = []
            for group in race.balls:
                own, angles = angles[: group.count], angles[group.count :]
                groups.append(group.model_copy(update={"start_angles": tuple(own)}))
            machine = with_value_at(machine, f"balancers[{i}].races[{j}].balls", tuple(groups))
    text = f"Start {number + 1} of {found.sizes['run']} random starts, the worst"
    return with_value_at(with_value_at(machine, "description", text), "run", {"duration": ramp + float(about["hold"])})
