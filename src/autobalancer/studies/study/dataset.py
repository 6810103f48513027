"""The members of a study and what they left, as a labeled dataset."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.files.machine_file import machine_text
from autobalancer.machine.plain_names import dimension_of
from autobalancer.results.measure_table import SWEPT, label_of
from autobalancer.results.provenance import provenance
from autobalancer.results.verdict.rule import BALANCED
from autobalancer.stability.basins.starts import START_ANGLE, axis_name
from autobalancer.studies.ensemble.columns import STARTS, ball_of, is_start
from autobalancer.studies.study.chunk import ABOUT, SECONDS, Arrays
from autobalancer.studies.study.outputs import RUN, STALLED, STANDING, attributes_of
from autobalancer.studies.study.run_up import SHAPES
from autobalancer.studies.study.spec import Study
from autobalancer.studies.study.sudden import BALANCED_BEFORE, HELD_SPEED
from autobalancer.studies.variations import coordinate

COUNTED = {
    "steps": "accepted steps",
    STALLED: "whether a ball stalled and has not come to rest in the rotor by the end",
    BALANCED_BEFORE: "whether the run was balanced before the unbalance appeared",
    "drawn_again": "how often the draw was taken again because no machine can be like that",
    "reason": "why the member is impossible, or has no number",
}


def study_dataset(study: Study, chunks: Mapping[tuple[int, int], Arrays], count: int) -> xr.Dataset:
    """Over ``member``: coordinates are what varied, ``draw``, ``point`` and ``seed``; variables what each member left.

    Parameters
    ----------
    study
        What was asked.
    chunks
        Finished chunks by their first and after their last member.
    count
        Members after which the study stopped; what was run beyond does not count.
    """
    spans = sorted(span for span in chunks if span[0] < count)
    number = np.concatenate([np.arange(*span) for span in spans] or [np.zeros(0, np.int64)]).astype(np.int64)
    kept = number < count
    found = xr.Dataset(attrs=_attributes(study))
    arrays = {name: _joined([chunks[span].get(name) for span in spans])[kept] for name in _names(chunks, spans)}
    number = number[kept]
    draw, point = np.divmod(number, len(study.points))
    found = found.assign_coords(
        member=("member", number + 1, {"long_name": "number of the member"}),
        draw=("member", draw + 1, {"long_name": "number of the draw"}),
        point=("member", point + 1, {"long_name": "number of the point of the grid"}),
        **_varied(study, arrays, point),
    )
    for name, values in arrays.items():
        if not name.startswith("vary:") and name != "seed":
            dims = ("member", "ball") if values.ndim == 2 else ("member",)
            found[name] = (
                dims,
                values.astype(object) if values.dtype.kind == "U" else values,
                _label(name, study.settling_from),
            )
    seconds = sum(float(chunks[span][SECONDS][0]) for span in spans)
    if RUN in study.results and kept.any():
        found.attrs["run_time_per_member"] = seconds / int(kept.size)
        found.attrs["steps_per_member"] = float(found["steps"].values.mean())
    return found


def _attributes(study: Study) -> dict[str, Any]:
    return {
        "title": f"Study {study.name} of {study.machine.name}",
        **provenance(),
        "machine": machine_text(study.machine),
        **({} if study.base is None else {"base_machine": machine_text(study.base)}),
        "machine_name": study.machine.name,
        "study": json.dumps(study.identity()),
        "study_name": study.name,
        "plan": study.plan,
        "inputs": study.inputs,
        "grid": list(study.grid),
        "parameters": [*study.grid, *study.scatter],
        "duration": study.duration,
        **({"show": list(study.show)} if study.show else {}),
        **({} if study.sudden is None else {"sudden_unbalance": study.sudden.place, "before": study.sudden.before}),
        "tolerance": study.tolerance,
        "bins": study.bins,
        "settling_from": study.settling_from,
        "starts": "random" if study.random_starts else "machine",
    }


def _names(chunks: Mapping[tuple[int, int], Arrays], spans: list[tuple[int, int]]) -> list[str]:
    return [name for name in dict.fromkeys(name for span in spans for name in chunks[span]) if name not in ABOUT]


def _joined(parts: list[Any]) -> Any:
    """Arrays one behind the other; those over balls get as many columns as the widest has."""
    width = max((part.shape[1] for part in parts if part.ndim == 2), default=0)
    if width:
        parts = [np.pad(part, ((0, 0), (0, width - part.shape[1])), constant_values=np.nan) for part in parts]
    return np.concatenate(parts)


def _varied(study: Study, arrays: Arrays, point: Any) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for place, name in enumerate(study.grid):
        values, label = _labeled(study, name, [one[place] for one in study.points])
        found[dimension_of(name)] = ("member", np.asarray(values)[point], label)
    for name in study.scatter:
        values, label = _labeled(study, name, arrays[f"vary:{name}"].tolist())
        found[dimension_of(name)] = ("member", np.asarray(values), label)
    if "seed" in arrays:
        found["seed"] = ("member", arrays["seed"], {"long_name": "seed of the start"})
    return found


def _labeled(study: Study, name: str, values: list[Any]) -> tuple[Any, dict[str, str]]:
    if is_start(name):
        return values, {"long_name": axis_name(name), "units": STARTS[ball_of(name)[0]]}
    found, label = coordinate(study.machine, name, values)
    if study.sudden is not None and name == HELD_SPEED:
        label["long_name"] = "rotor speed"
    elif name in SHAPES and getattr(getattr(study.machine.drive, "profile", None), "kind", "") == "reduction":
        label["long_name"] = SHAPES[name]
    return found, label


def _label(name: str, settling_from: str) -> dict[str, Any]:
    if name in {one.name for one in STANDING.values()}:
        return attributes_of(name)
    measure = next((one for one in SWEPT if one.name == name), None)
    if measure is not None:
        return label_of(measure, settling_from)
    if name == BALANCED:
        return {"long_name": "whether the verdict is 'balanced'"}
    if name == "start_ball_angle_in_rotor":
        return dict(START_ANGLE)
    return {"long_name": COUNTED[name]} if name in COUNTED else {}
