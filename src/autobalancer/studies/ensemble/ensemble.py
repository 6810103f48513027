"""Thousands of run-ups of one machine, each with its own numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, Unpack

import numpy as np
import xarray as xr

from autobalancer.assembly.system import reference_station
from autobalancer.errors import QuestionError, one_of
from autobalancer.files.machine_file import balls_in_races, machine_text
from autobalancer.kernels.compiler.simd import NODES
from autobalancer.kernels.measures.record_series import COLUMN, WIDTH
from autobalancer.kernels.measures.thresholds import NO_VERDICT
from autobalancer.machine import Machine
from autobalancer.machine.path import dimension_of
from autobalancer.memory import refuse_beyond_memory
from autobalancer.progress import shows_progress
from autobalancer.results.answers.answer import provenance
from autobalancer.results.answers.studied import IMPOSSIBLE, NOT_RUN, Ensemble
from autobalancer.results.measure_table import SWEPT, in_row, label_of
from autobalancer.results.run_arrays import SETTLING_FROM, known_origin
from autobalancer.results.verdict import BALANCED, WORDS
from autobalancer.simulation import MANY_RUNS, ManyRunOptions, refuse_no_counts, run_duration, run_options
from autobalancer.simulation.run import outcome
from autobalancer.stability.basins import START_ANGLE, axis_name
from autobalancer.studies.ensemble.columns import STARTS, ball_count, ball_of, columns_of
from autobalancer.studies.ensemble.layout import ASKABLE, Plan, Ran, run_groups
from autobalancer.studies.ensemble.members import Impossible, Members, without_start_angles
from autobalancer.studies.variations import coordinate

TEXTS = 400.0  # bytes of a member: outcome, verdict, seed and what its row is made of


@shows_progress
def ensemble(
    machine: Machine | str | Path,
    columns: Mapping[str, Any] | str | Path | None = None,
    *,
    seeds: int | None = None,
    duration: float | str | None = None,
    bins: int = 500,
    measures: Sequence[str] | None = None,
    impossible: Impossible = "refuse",
    keep_states: bool = False,
    settling_from: str = SETTLING_FROM[0],
    **options: Unpack[ManyRunOptions],
) -> Ensemble:
    """Run thousands of members of one machine, and keep measures of each.

    Parameters
    ----------
    machine
        A machine or the path of a machine file.
    columns
        Path of a parameter or a plain name, as for :func:`autobalancer.sweep`, to its values, one for each member: SI, or texts
        with units; a single value holds for all. Besides them, at the start and in the rotor, ``ball_angle[i]`` (rad),
        ``ball_speed[i]`` or ``ball_speed`` of all balls (rad/s), and ``seed``. Or the path of a table (CSV) whose first line
        names them with units, such as ``viscosity [mm^2/s], ball_angle[1] [deg]``.
    seeds
        Number of random starts with which every row of the columns is run, from ``seed`` on. Start angles of the machine do
        not count then, nor with a column ``seed``.
    duration
        As for :func:`autobalancer.simulate`.
    bins
        Resolution in time of the measures; settling times are interpolated within a bin.
    measures
        What to find of each member: names of the measures of :func:`autobalancer.sweep`, and ``"verdict"``; by default all.
        With ``[]`` only how and where it ends. Less takes less time, as far as the envelope over the run or the last
        revolutions are not needed.
    impossible
        What to do with members that no machine can be: ``"refuse"`` raises an error that names the first one, ``"record"`` gives
        them the outcome ``impossible`` and runs the others. Either way that is known before anything runs.
    keep_states
        Whether to keep the state at the end of every member.
    settling_from
        From where settling times count: the end of the ``"run-up"``, or the last ``"release"`` of a stalled ball, see
        :func:`autobalancer.run_measures`.
    **options
        ``tolerance`` (1e-7), ``method``, ``max_steps``, ``seed``, ``workers``, ``progress`` and ``keep_on_interrupt``, see
        :class:`~autobalancer.simulation.ManyRunOptions`. Members that Ctrl-C kept from running have the outcome ``not run``.
        While members are still made ready it ends that, and those that are ready are run, until it is pressed again.

    Returns
    -------
    xarray.Dataset
        Over ``member``, from 1: the columns and ``seed`` as coordinates, the measures of :func:`autobalancer.sweep`, ``outcome``,
        ``verdict`` and with it ``balanced``, ``steps``, and ``start_ball_angle_in_rotor``. ``attrs`` say how long a member took.
        A member has the same bits as :func:`autobalancer.simulate` of its machine with the same seed and tolerance. On rotors
        that tilt or bend, with more than 55 members whose own numbers are smooth functions of the columns, these numbers are
        interpolated between assembled members, so far as others are met within the tolerance and rounding:
        ``attrs["interpolated_members"]`` says for how many, and ``attrs["interpolation_error"]`` how well.

    Raises
    ------
    QuestionError
        For unknown columns or measures, unequal lengths, neither columns nor seeds, a missing duration, too little memory.
    MachineError
        If a member is impossible; the message names it. Nothing has run by then.
    """
    machine = balls_in_races(machine)
    how = run_options("ensemble", options, MANY_RUNS)
    refuse_no_counts(seeds=seeds, bins=bins)
    seed, keep_on_interrupt = how["seed"], how["keep_on_interrupt"]
    given = columns_of(machine, columns)
    if columns is None and seeds is None:
        raise QuestionError("ensemble: give columns of numbers, or a number of random starts, such as seeds=1000")
    if seeds is not None and given.seeds is not None:
        raise QuestionError(f"seeds: given {seeds}; stands in place of a column 'seed'")
    one_of("impossible", impossible, "refuse", "record")
    requested = ASKABLE if measures is None else known_measures(measures)
    end, _ = run_duration(machine, duration), known_origin(settling_from)
    refuse_beyond_memory(
        "ensemble",
        given.count * (seeds or 1),
        "members",
        bytes_of_a_member(machine, keep_states),
        f"{', more without keep_states' if keep_states else ''}; split the ensemble",
    )
    drawn = None if seeds is None else np.arange(seed, seed + seeds, dtype=np.int64)
    if drawn is not None or given.seeds is not None:
        machine = without_start_angles(machine)
    members = Members(machine, given, drawn, seed, "member")
    plan = Plan(end, how["tolerance"], bins, how["max_steps"], how["method"], settling_from, requested)
    groups, reasons = members.sorted(plan, impossible, interpolate=True, keep_on_interrupt=keep_on_interrupt)
    ran, seconds, interrupted = run_groups(groups, how["workers"], how["progress"] or None, keep_states)
    if interrupted and not keep_on_interrupt:
        raise KeyboardInterrupt
    dataset = ensemble_dataset(members, ran, reasons, plan)
    done = int((dataset["steps"].values > 0).sum())
    dataset.attrs |= {
        "run_time_per_member": seconds / done if done else math.nan,
        "method": ", ".join(sorted({one.group.stepper.method for one in ran})),
        "lanes": max((NODES if one.group.stepper.long is not None else 1 for one in ran), default=1),
        "interpolated_members": groups.interpolated,
        "interpolation_error": groups.error,
        "outcome": "interrupted" if interrupted else "finished",
    }
    return Ensemble.of(dataset)


def known_measures(names: Sequence[str]) -> tuple[str, ...]:
    """The names of measures of a member that a user gave.

    Raises
    ------
    QuestionError
        For a name that is none.
    """
    for name in [names] if isinstance(names, str) else names:
        if name not in ASKABLE:
            raise QuestionError(f"measures: given {name!r}; must be a list of {', '.join(ASKABLE)}")
    return (names,) if isinstance(names, str) else tuple(names)


def bytes_of_a_member(machine: Machine, states: bool) -> float:
    """What a member takes while an ensemble runs and in its result."""
    balls = ball_count(machine)
    kept = len(SWEPT) + 4 * balls + 8
    return TEXTS + 16.0 * (kept + (16 + 4 * balls if states else 0))


# The members of an ensemble and what they left, as a labeled dataset.


Variable = tuple[Any, Any, Any]  # dimensions, values, label


def ensemble_dataset(members: Members, ran: list[Ran], reasons: dict[int, str], plan: Plan) -> xr.Dataset:
    """The dataset; a member that did not run has no numbers."""
    dataset = xr.Dataset(
        ensemble_variables(members, ran, reasons, plan.settling_from, plan.measures),
        coords={"member": ("member", np.arange(1, members.count + 1), {"long_name": "number of the member"})},
        attrs={
            "title": f"Ensemble of {members.machine.name}",
            **provenance(),
            "machine": machine_text(members.machine),
            "machine_name": members.machine.name,
            "parameters": [*members.columns.parameters, *members.columns.starts],
            "duration": plan.end,
            "tolerance": plan.tolerance,
            "bins": plan.bins,
            "settling_from": plan.settling_from,
        },
    )
    dataset = dataset.assign_coords(_coordinates(members))
    ran_steps = dataset["steps"].values[dataset["steps"].values > 0]
    dataset.attrs["steps_per_member"] = float(ran_steps.mean()) if ran_steps.size else 0.0
    return dataset


def ensemble_variables(
    members: Members, ran: list[Ran], reasons: dict[int, str], settling_from: str, measures: Sequence[str] = ASKABLE
) -> dict[str, Variable]:
    """The variables of the dataset by name, each with its dimensions, values and label."""
    count, balls = members.count, max((one.group.balls for one in ran), default=ball_count(members.machine))
    numbers, starts = np.full((count, WIDTH + balls), np.nan), np.full((count, balls), np.nan)
    steps, outcomes = np.zeros(count, np.int64), np.full(count, NOT_RUN, dtype=object)
    states = np.full((count, max((one.found.states.shape[1] for one in ran), default=0)), np.nan)
    for one in ran:
        where = np.array(one.group.numbers, np.int64)
        numbers[where, : one.found.rows.shape[1]], starts[where, : one.starts.shape[1]] = one.found.rows, one.starts
        steps[where] = one.found.counts[:, 0]
        if one.found.states.size:
            states[where, : one.found.states.shape[1]] = one.found.states
    outcomes[list(reasons)] = IMPOSSIBLE
    for number in np.flatnonzero(steps):
        outcomes[number] = _outcome(int(numbers[number, COLUMN.status]))
    result: dict[str, Variable] = {}
    words = np.where(np.isfinite(numbers[:, COLUMN.verdict]), numbers[:, COLUMN.verdict], NO_VERDICT).astype(int)
    station = reference_station(members.machine_of(ran[0].group.numbers[0])) if ran else ""
    for measure, values in zip(SWEPT, in_row(numbers, settling_from).values(), strict=True):
        if measure.name in measures:
            dims = ("member", "ball") if measure.per_ball else ("member",)
            result[measure.name] = (dims, values, label_of(measure, settling_from, station))
    verdicts = np.array(WORDS, dtype=object)[words]
    result["outcome"] = ("member", outcomes, {})
    if "verdict" in measures:
        result["verdict"] = ("member", verdicts, {})
        result["balanced"] = ("member", verdicts == BALANCED, {"long_name": "whether the verdict is 'balanced'"})
    if reasons:
        texts = np.full(count, "", dtype=object)
        texts[list(reasons)] = list(reasons.values())
        result["reason"] = ("member", texts, {"long_name": "why the member is impossible"})
    result["steps"] = ("member", steps, {"long_name": "accepted steps"})
    if balls:
        result["start_ball_angle_in_rotor"] = (("member", "ball"), starts, START_ANGLE)
    if states.size:
        result["final_state"] = (("member", "component"), states, {"long_name": "state at the end"})
    return result


@cache
def _outcome(status: int) -> str:
    """How a run ended, by the stepper's word."""
    return outcome(status, 0.0, 0.0, interrupted=False, steps=0).name


def _coordinates(members: Members) -> dict[str, Any]:
    rows = np.array([members.row(number) for number in range(members.count)], np.int64)
    coordinates: dict[str, Any] = {}
    for name, values in members.columns.parameters.items():
        distinct, label = coordinate(members.machine, name, values)
        coordinates[dimension_of(name)] = ("member", np.asarray(distinct)[rows], label)
    for name, starts in members.columns.starts.items():
        unit = STARTS[ball_of(name)[0]]
        coordinates[dimension_of(name)] = ("member", starts[rows], {"long_name": axis_name(name), "units": unit})
    coordinates["seed"] = ("member", members.seeds, {"long_name": "seed of the start"})
    return coordinates
