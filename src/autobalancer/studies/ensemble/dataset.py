"""The members of an ensemble and what they left, as a labeled dataset."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.files.machine_file import machine_text
from autobalancer.kernels.measures.columns import STATUS, VERDICT, WIDTH
from autobalancer.kernels.measures.limits import NO_VERDICT
from autobalancer.machine.plain_names import dimension_of
from autobalancer.results.answers.ensemble import IMPOSSIBLE, NOT_RUN
from autobalancer.results.measure_table import SWEPT, in_row, label_of
from autobalancer.results.provenance import provenance
from autobalancer.results.verdict.rule import BALANCED, WORDS
from autobalancer.simulation.outcome import outcome
from autobalancer.stability.basins.starts import START_ANGLE, axis_name
from autobalancer.studies.ensemble.columns import STARTS, ball_count, ball_of
from autobalancer.studies.ensemble.execute import Ran
from autobalancer.studies.ensemble.integration import ASKABLE, Plan
from autobalancer.studies.ensemble.members import Members
from autobalancer.studies.variations import coordinate

Variable = tuple[Any, Any, Any]  # dimensions, values, label


def ensemble_dataset(members: Members, ran: list[Ran], reasons: dict[int, str], plan: Plan) -> xr.Dataset:
    """The dataset; a member that did not run has no numbers."""
    found = xr.Dataset(
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
    found = found.assign_coords(_coordinates(members))
    ran_steps = found["steps"].values[found["steps"].values > 0]
    found.attrs["steps_per_member"] = float(ran_steps.mean()) if ran_steps.size else 0.0
    return found


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
        outcomes[number] = _outcome(int(numbers[number, STATUS]))
    found: dict[str, Variable] = {}
    words = np.where(np.isfinite(numbers[:, VERDICT]), numbers[:, VERDICT], NO_VERDICT).astype(int)
    for measure, values in zip(SWEPT, in_row(numbers, settling_from).values(), strict=True):
        if measure.name in measures:
            dims = ("member", "ball") if measure.per_ball else ("member",)
            found[measure.name] = (dims, values, label_of(measure, settling_from))
    verdicts = np.array(WORDS, dtype=object)[words]
    found["outcome"] = ("member", outcomes, {})
    if "verdict" in measures:
        found["verdict"] = ("member", verdicts, {})
        found["balanced"] = ("member", verdicts == BALANCED, {"long_name": "whether the verdict is 'balanced'"})
    if reasons:
        texts = np.full(count, "", dtype=object)
        texts[list(reasons)] = list(reasons.values())
        found["reason"] = ("member", texts, {"long_name": "why the member is impossible"})
    found["steps"] = ("member", steps, {"long_name": "accepted steps"})
    if balls:
        found["start_ball_angle_in_rotor"] = (("member", "ball"), starts, START_ANGLE)
    if states.size:
        found["final_state"] = (("member", "component"), states, {"long_name": "state at the end"})
    return found


@cache
def _outcome(status: int) -> str:
    """How a run ended, by the stepper's word."""
    return outcome(status, 0.0, 0.0, interrupted=False, steps=0).name


def _coordinates(members: Members) -> dict[str, Any]:
    rows = np.array([members.row(number) for number in range(members.count)], np.int64)
    found: dict[str, Any] = {}
    for name, values in members.columns.parameters.items():
        distinct, label = coordinate(members.machine, name, values)
        found[dimension_of(name)] = ("member", np.asarray(distinct)[rows], label)
    for name, starts in members.columns.starts.items():
        unit = STARTS[ball_of(name)[0]]
        found[dimension_of(name)] = ("member", starts[rows], {"long_name": axis_name(name), "units": unit})
    found["seed"] = ("member", members.seeds, {"long_name": "seed of the start"})
    return found
