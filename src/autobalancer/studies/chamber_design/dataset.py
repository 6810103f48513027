"""What became of each design, as one dataset."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.files.machine_file import machine_text
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.results.answers.chamber_designs import ChamberDesigns
from autobalancer.results.provenance import provenance
from autobalancer.studies.chamber_design.limits import JUDGED
from autobalancer.studies.chamber_design.screening import FULL, Design, Question, left_in_short_runs
from autobalancer.studies.chamber_design.statistics import SURE, fronts, mean_interval, share_interval, worse_than_worst

CHOSEN = {  # of a candidate
    "balls": "",
    "diameter": "m",
    "total_mass": "kg",
    "density": "kg/m^3",
    "friction": "1",
    "ball_friction": "1",
    "viscosity": "Pa s",
    "fluid_density": "kg/m^3",
    "fill": "1",
}
BOUNDED = {  # of the bounds, and which of those for several unbalances counts
    "capability": ("kg m", min),
    "swung_residual": ("kg m", max),
    "held_residual": ("kg m", max),
    "vibration_without_balls": ("m", max),
    "least_friction": ("1", max),
    "drag_ratio": ("1", min),
    "shaking": ("1", max),
    "decay_rate": ("1/s", min),
    "least_settling_time": ("s", max),
    "race_force": ("N", max),
    "race_pressure": ("Pa", max),
    "greatest_couple": ("kg m^2", max),
    "couple_bearing_force": ("N", max),
}
ALL_CARRIED = 1.0 - 1e-9


def designs_dataset(
    machine: ChamberMachine, designs: Sequence[Design], limits: dict[str, float], asked: Question
) -> ChamberDesigns:
    """Everything that is known of the designs; see :func:`~autobalancer.chamber.design`."""
    numbers = np.arange(1, len(designs) + 1)
    found = xr.Dataset(
        coords={"design": numbers, "unbalance": list(asked.unbalances), "seed": list(range(asked.fillings))}
    )
    found["unbalance"].attrs["units"] = "kg m"
    found["label"] = ("design", np.array([one.candidate.label for one in designs], object))
    for name, unit in CHOSEN.items():
        found[name] = _along([float(getattr(one.candidate, name)) for one in designs], unit, name)
    found["balls"] = found["balls"].astype(int)
    for name in ("stage", "reason"):
        found[name] = ("design", np.array([getattr(one, name) for one in designs], object))
    for name, (unit, worst) in BOUNDED.items():
        held = [[getattr(own, name) for own in one.bounds.values()] for one in designs]
        found[name] = _along([worst(values) if values else math.nan for values in held], unit, name)
    found["short_left"] = _along([left_in_short_runs(one) for one in designs], "1", "short_left")
    found["short_left"].attrs["long_name"] = (
        "vibration that turns with the rotor in the short runs, over that without balls"
    )
    for name, entry in JUDGED.items():
        values = [
            [
                [one.full.get((size, seed), {}).get(name, math.nan) for seed in range(asked.fillings)]
                for size in asked.unbalances
            ]
            for one in designs
        ]
        attrs = {"units": entry.unit, "long_name": entry.text}
        found[name] = (("design", "unbalance", "seed"), np.array(values, np.float64), attrs)
    full = np.array([one.stage == FULL for one in designs])
    _summarize(found, full)
    _judge(found, full, limits)
    found.attrs = {
        "title": f"Designs of {machine.name}",
        **provenance(),
        "machine": machine_text(machine),
        "machine_name": machine.name,
        "limits": json.dumps(limits),
        "confidence": SURE,
        "worse_than_worst": worse_than_worst(asked.fillings),
        "duration": asked.duration,
        "short": asked.short,
        "last": asked.last,
    }
    return ChamberDesigns.of(found)


def _along(values: Any, unit: str, name: str) -> Any:
    return "design", np.array(values, np.float64), {"units": unit, "long_name": name.replace("_", " ")}


def _summarize(found: xr.Dataset, full: Any) -> None:
    """Means with intervals at the unbalance at which the mean is greatest, and worst values of all runs."""
    runs = found["vibration"].values
    rows = [max((mean_interval(case) for case in one), key=lambda row: row[0]) for one in runs]
    for k, name in enumerate(("vibration_mean", "vibration_low", "vibration_high")):
        found[name] = _along([row[k] if there else math.nan for row, there in zip(rows, full, strict=True)], "m", name)
    for name, entry in JUDGED.items():
        # a run without this number, as it did not finish or never settled, is the worst of all
        found[f"worst_{name}"] = _along(
            found[name].values.reshape(full.size, -1).max(axis=1), entry.unit, f"worst {name}"
        )
    carried = found["share_carried"].values >= ALL_CARRIED
    shares = [min(share_interval(int(case.sum()), case.size) for case in one) for one in carried]
    for k, name in enumerate(("pick_up", "pick_up_low", "pick_up_high")):
        found[name] = _along(
            [row[k] if there else math.nan for row, there in zip(shares, full, strict=True)], "1", name
        )


def _judge(found: xr.Dataset, full: Any, limits: dict[str, float]) -> None:
    """Which designs meet the limits, in which order they are best, and which none of the others beats."""
    excess = np.where(full, 0.0, math.nan)
    missed: list[list[str]] = [[] for _ in full]
    for name, limit in limits.items():
        values = found["pick_up" if name == "pick_up" else f"worst_{name}"].values
        with np.errstate(divide="ignore"):
            over = limit / values - 1.0 if name == "pick_up" else values / limit - 1.0
        over = np.where(np.isnan(over), math.inf, np.maximum(over, 0.0))
        excess = excess + over
        for i in np.flatnonzero(full & (over > 0.0)):
            missed[i].append(name)
    meets = full & (excess == 0.0)
    found["meets"] = ("design", meets.astype(int), {"long_name": "meets all limits (1) or not (0)"})
    found["missed"] = ("design", np.array([", ".join(names) for names in missed], object))
    vibration, mass = found["worst_vibration"].values, found["total_mass"].values
    order = sorted(np.flatnonzero(full), key=lambda i: (excess[i], _last(float(vibration[i])), mass[i]))
    place = np.full(full.size, math.nan)
    place[order] = np.arange(1, len(order) + 1)
    found["place"] = _along(place, "", "place, 1 is the best")
    for name, other in (("pareto_mass", mass), ("pareto_settling", found["worst_settling_time"].values)):
        on = fronts(np.where(full, vibration, math.nan), other) == 0
        text = "no other one has both less worst vibration and less " + (
            "mass of balls" if name == "pareto_mass" else "settling time"
        )
        found[name] = ("design", (on & np.isfinite(other) & full).astype(int), {"long_name": text})


def _last(value: float) -> float:
    return math.inf if math.isnan(value) else value
