"""The members of an ensemble and what they left, as a labeled dataset."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from autobalancer.files.machine_file import machine_text
from autobalancer.kernels.system import BALLS
from autobalancer.machine.plain_names import dimension_of
from autobalancer.results.answers.ensemble import NOT_RUN
from autobalancer.results.measure_table import SWEPT
from autobalancer.results.provenance import provenance
from autobalancer.results.verdict.rule import BALANCED, NO_VERDICT
from autobalancer.stability.basins.starts import START_ANGLE, axis_name
from autobalancer.studies.ensemble.columns import STARTS, ball_count, ball_of
from autobalancer.studies.ensemble.members import Members
from autobalancer.studies.ensemble.one import Plan
from autobalancer.studies.variations import coordinate

Row = dict[str, Any]


def ensemble_dataset(members: Members, rows: list[Row], plan: Plan) -> xr.Dataset:
    """The dataset; a member that did not run has no numbers."""
    count, balls = members.count, ball_count(members.machine)
    found = xr.Dataset(
        coords={"member": ("member", np.arange(1, count + 1), {"long_name": "number of the member"})},
        attrs={
            "title": f"Ensemble of {members.machine.name}",
            **provenance(),
            "machine": machine_text(members.machine),
            "machine_name": members.machine.name,
            "parameters": [*members.columns.parameters, *members.columns.starts],
            "duration": plan.end,
            "tolerance": plan.tolerance,
            "bins": plan.bins,
        },
    )
    found = found.assign_coords(_coordinates(members))
    for measure in SWEPT:
        label = {"long_name": measure.text, "units": measure.unit}
        if measure.per_ball:
            values = np.array([row.get(measure.name, np.full(balls, np.nan)) for row in rows])
            found[measure.name] = (("member", "ball"), values.reshape(count, balls), label)
        else:
            numbers = [float(row.get(measure.name, np.nan)) for row in rows]
            found[measure.name] = ("member", np.array(numbers), label)
    found["outcome"] = ("member", _texts(rows, "outcome", NOT_RUN))
    found["verdict"] = ("member", _texts(rows, "verdict", NO_VERDICT))
    balanced = found["verdict"].values == BALANCED
    found["balanced"] = ("member", balanced.astype(bool), {"long_name": "whether the verdict is 'balanced'"})
    if any("text" in row and row["text"] for row in rows):
        found["reason"] = ("member", _texts(rows, "text", ""), {"long_name": "why the member is impossible"})
    steps = np.array([row.get("steps", 0) for row in rows], np.int64)
    found["steps"] = ("member", steps, {"long_name": "accepted steps"})
    if balls:
        starts = [row["start"][BALLS : BALLS + balls] if "start" in row else np.full(balls, np.nan) for row in rows]
        found["start_ball_angle_in_rotor"] = (("member", "ball"), np.array(starts), START_ANGLE)
    if any("state" in row for row in rows):
        found["final_state"] = (("member", "component"), _states(rows), {"long_name": "state at the end"})
    ran = steps[steps > 0]
    found.attrs["steps_per_member"] = float(ran.mean()) if ran.size else 0.0
    return found


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


def _texts(rows: list[Row], name: str, other: str) -> Any:
    return np.array([row.get(name, other) for row in rows], dtype=object)


def _states(rows: list[Row]) -> Any:
    size = max(row["state"].size for row in rows if "state" in row)
    found = np.full((len(rows), size), np.nan)
    for number, row in enumerate(rows):
        if "state" in row:
            found[number, : row["state"].size] = row["state"]
    return found
