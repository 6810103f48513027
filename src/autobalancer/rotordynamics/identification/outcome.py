"""The labelled data of a fit, and its report."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from autobalancer.assembly.author_units import unit_of
from autobalancer.assembly.rotors.model import Floats
from autobalancer.files.machine_file import machine_text
from autobalancer.machine import Machine
from autobalancer.machine.path import entry_at
from autobalancer.results.answers.labeled import Labeled
from autobalancer.results.provenance import provenance
from autobalancer.rotordynamics.identification.determination import Determination
from autobalancer.rotordynamics.identification.fit import Fit
from autobalancer.rotordynamics.identification.free import Unknown
from autobalancer.rotordynamics.identification.measurements import Rows
from autobalancer.units import Given, to_si

OUTLIER = 0.5  # weight below which a value counts as one
MANY = ("run-up", "orders")  # kinds of rows that are samples of one measurement
TOO_LARGE = 2.0  # ratio of the scatter to the stated errors above which a note says so


def dataset(
    machine: Machine,
    fitted: Machine,
    sought: list[Unknown],
    values: Floats,
    at_bound: np.ndarray,
    known: Determination,
    rows: list[Rows],
    before: Floats,
    after: Floats,
    deviation: Floats,
    weight: Floats,
    fit: Fit,
) -> xr.Dataset:
    """See :class:`~autobalancer.rotordynamics.identification.identify.Identification`."""
    names = np.array([u.name for u in sought], dtype=object)
    per_row = [(r, i) for r in rows for i in range(r.measured.size)]

    def words(entries: list[str]) -> np.ndarray:
        return np.array(entries, dtype=object)

    result = xr.Dataset(
        coords={
            "parameter": ("parameter", names, {"long_name": "free parameter"}),
            "other_parameter": ("other_parameter", names, {"long_name": "free parameter"}),
        }
    )
    data: dict[str, tuple[Any, Any, str]] = {
        "value": ("parameter", values, "identified value, SI"),
        "uncertainty": ("parameter", known.uncertainty, "standard uncertainty, SI"),
        "start": ("parameter", np.array([u.start for u in sought]), "value at the start, SI"),
        "lower": ("parameter", np.array([u.lower for u in sought]), "lower bound, SI"),
        "upper": ("parameter", np.array([u.upper for u in sought]), "upper bound, SI"),
        "at_bound": ("parameter", at_bound, "whether the value lies at a bound"),
        "unit": ("parameter", words([u.unit for u in sought]), "unit of the parameter"),
        "written_unit": (
            "parameter",
            words([_written_unit(fitted, u) for u in sought]),
            "unit in which its machine file has it",
        ),
        "tie": ("parameter", words([u.tie for u in sought]), "what is free: value, factor or offset"),
        "paths": ("parameter", words([", ".join(u.paths) for u in sought]), "entries of the machine"),
        "correlation": (("parameter", "other_parameter"), known.correlation, "correlation"),
        "singular_value": ("direction", known.singular, "singular value of the weighted Jacobian"),
        "direction_part": (("direction", "parameter"), known.directions, "part of the parameter in the direction"),
        "measured": ("row", np.concatenate([r.measured for r in rows]), "measured, SI"),
        "error": ("row", np.concatenate([r.error for r in rows]), "standard deviation of the measurement, SI"),
        "before": ("row", before, "of the machine at the start, SI"),
        "after": ("row", after, "of the fitted machine, SI"),
        "deviation": ("row", deviation, "deviation after the fit in standard deviations"),
        "weight": ("row", weight, "weight in the fit, less than 1 for outliers"),
        "row_speed": ("row", np.concatenate([r.speed for r in rows]), "rotor speed, rad/s"),
        "row_label": ("row", words([r.label for r, _ in per_row]), "what was measured"),
        "row_part": ("row", words([n for r in rows for n in r.parts or [""] * r.measured.size]), "which value of it"),
        "row_kind": ("row", words([r.kind for r, _ in per_row]), "kind of measurement"),
        "row_unit": ("row", words([r.unit for r, _ in per_row]), "unit of the row"),
    }
    for key, (dims, numbers, text) in data.items():
        result[key] = (dims, numbers, {"long_name": text})
    freedom = deviation.size - known.rank - int(at_bound.sum())
    ratio = float(np.sqrt((deviation**2).sum() / freedom)) if freedom > 0 else float("nan")
    misfit = float(np.sqrt((weight * deviation**2).sum() / freedom)) if freedom > 0 else 1.0
    result["uncertainty"] = result["uncertainty"] * max(1.0, misfit)
    result["uncertainty"].attrs["long_name"] = "standard uncertainty, SI"
    notes = list(known.notes)
    if ratio > TOO_LARGE:
        notes.append(
            f"the deviations are {ratio:.1f} times the stated errors: the model does not describe the data to these errors; "
            f"the uncertainties above are enlarged {max(1.0, misfit):.1f} times"
        )
    if fit.starts > 1 and fit.agreeing == 1:
        notes.append(f"only one of {fit.starts} starts ended at the best fit; give more starts, or narrower bounds")
    if fit.outcome != "converged":
        notes.append(f"the search {fit.outcome}")
    result.attrs = {
        "title": f"Identified parameters of {machine.name}",
        **provenance(),
        "machine": machine_text(fitted),
        "machine_before": machine_text(machine),
        "machine_name": machine.name,
        "outcome": fit.outcome,
        "cost": fit.cost,
        "chi_square": float((deviation**2).sum()),
        "degrees_of_freedom": freedom,
        "scatter_ratio": ratio,
        "rank": known.rank,
        "evaluations": fit.evaluations,
        "starts": fit.starts,
        "starts_at_best": fit.agreeing,
        "notes": notes,
    }
    return Labeled.of(result)


def report_text(data: xr.Dataset) -> str:
    """Parameters, deviations and notes as plain text."""
    lines = [data.attrs["title"], ""]
    for p in range(data.sizes["parameter"]):
        one = data.isel(parameter=p)
        factor, unit = shown_parameter(one)
        value, spread, start = (factor * float(one[name]) for name in ("value", "uncertainty", "start"))
        bound = ", at its bound" if bool(one["at_bound"]) else ""
        lines.append(
            f"  {one['parameter'].item()} = {value:.8g} {with_spread(spread)} {unit}".rstrip()
            + f"   (start {start:.6g}{bound})"
        )
    lines += ["", "  measured -> before, after the fit, deviation in standard deviations"]
    for label, part in grouped(data):
        if part.sizes["row"] > 1 and str(part["row_kind"].values[0]) in MANY:
            rms, greatest = (float(f(np.abs(part["deviation"].values))) for f in (_rms, np.max))
            lines.append(f"  {label}: {part.sizes['row']} values, rms {rms:.3f}, greatest {greatest:.2f}")
            continue
        if part.sizes["row"] > 1:
            rms = float(np.sqrt(np.mean(np.log(part["after"].values / part["measured"].values) ** 2)))
            greatest = float(np.abs(part["deviation"]).max())
            few = int((part["weight"] < OUTLIER).sum())
            lines.append(
                f"  {label}: {part.sizes['row']} values, rms {100 * rms:.3g} %, greatest {greatest:.2f}, {few} of them outliers"
            )
            continue
        factor, unit = shown_unit(part)
        numbers = [factor * float(part[name][0]) for name in ("measured", "before", "after")]
        away = float(part["deviation"][0])
        lines.append(f"  {label}: {numbers[0]:.6g} -> {numbers[1]:.6g}, {numbers[2]:.6g} {unit}, {away:+.2f}")
    freedom = data.attrs["degrees_of_freedom"]
    lines += [
        "",
        f"  chi square {data.attrs['chi_square']:.4g} with {freedom} degrees of freedom, rank {data.attrs['rank']}",
    ]
    lines += [f"  note: {note}" for note in data.attrs["notes"]]
    return "\n".join(lines)


def _written_unit(fitted: Machine, sought: Unknown) -> str:
    """The unit of a free parameter in the file of the fitted machine; of a temperature that of its differences."""
    entry = entry_at(fitted, sought.paths[0])
    return unit_of(entry) if isinstance(entry, Given) and sought.unit not in ("", "K") else sought.unit


def shown_parameter(one: xr.Dataset) -> tuple[float, str]:
    """Factor and unit in which people read a free parameter: that of the machine file."""
    unit = str(one["written_unit"].item())
    return (1.0 / to_si(f"1 {unit}", str(one["unit"].item())) if unit else 1.0), unit


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def shown_unit(part: xr.Dataset) -> tuple[float, str]:
    """Factor and unit in which people read a row: speeds in rpm, frequencies in Hz, the rest in SI."""
    kind = str(part["row_kind"].values[0])
    if kind == "critical_speed":
        return 30.0 / np.pi, "rpm"
    return (0.5 / np.pi, "Hz") if kind == "frequency" else (1.0, str(part["row_unit"].values[0]))


def with_spread(spread: float) -> str:
    """An uncertainty as people write it."""
    if np.isnan(spread):
        return "(no uncertainty)"
    return "+- anything" if np.isinf(spread) else f"+- {spread:.2g}"


def grouped(data: xr.Dataset) -> list[tuple[str, xr.Dataset]]:
    """Rows with one label together: a single value, or a curve."""
    labels = data["row_label"].values
    found: list[tuple[str, xr.Dataset]] = []
    start = 0
    for end in range(1, labels.size + 1):
        same = (
            end < labels.size and labels[end] == labels[start] and data["row_kind"].values[end] in ("response", *MANY)
        )
        if not same:
            found.append((str(labels[start]), data.isel(row=slice(start, end))))
            start = end
    return found
