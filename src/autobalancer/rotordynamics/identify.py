"""Fit parameters of a machine to measurements."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from html import escape
from pathlib import Path
from typing import Any, get_args

import numpy as np
import xarray as xr

from autobalancer.arrays import Floats
from autobalancer.assembly.quantities import in_author_units, unit_of
from autobalancer.errors import MachineError, QuestionError, one_of
from autobalancer.files.machine_file import balls_in_races, machine_text
from autobalancer.machine import Machine
from autobalancer.machine.path import entry_at
from autobalancer.notebook import picture_html
from autobalancer.results.answers.answer import Labeled, provenance
from autobalancer.results.labels import labeled
from autobalancer.rotordynamics.parameter_fit import (
    EXACT,
    Bounds,
    Fit,
    FreeParameter,
    Loss,
    MeasuredResponse,
    Measurement,
    Rows,
    Search,
    Trial,
    Unknown,
    best_fit,
    unknowns,
    weights,
)
from autobalancer.units import WrittenFloat, to_si

MOST_STARTS = 10_000  # fits of one question


@dataclass(frozen=True)
class Identification:
    """What a fit found.

    ``machine`` has the fitted values, and its description says that they are identified. ``data`` has, over
    ``parameter``: ``value``, ``uncertainty`` (one standard deviation; inf where the data say nothing, nan at a bound),
    ``start``, ``lower``, ``upper``, ``at_bound``, ``unit``, ``paths``; ``correlation`` over ``parameter`` and
    ``other_parameter``; over ``row``: ``measured``, ``error``, ``before``, ``after``, ``deviation`` (of the fitted
    machine, in standard deviations), ``weight`` (1, less for outliers), ``row_speed``, ``row_label``, ``row_kind``,
    ``row_unit``; over ``direction``: ``singular_value`` and ``direction_part`` (over ``parameter``, too). Where response
    curves were measured, over ``point``: ``curve_speed``, ``curve_label``, ``curve_before`` and ``curve_after``, the
    curves of the machine between the measured speeds.
    """

    machine: Machine
    data: xr.Dataset

    def report(self) -> str:
        """Everything as text."""
        return report_text(self.data)

    def __repr__(self) -> str:
        return self.report()

    def _repr_html_(self) -> str:
        about = f"measured and fitted: {self.machine.name}"
        return f"<pre>{escape(self.report())}</pre>{picture_html(self.data, about)}"


def identify(
    machine: Machine | str | Path,
    free: Sequence[FreeParameter] | Mapping[str, Bounds],
    measurements: Sequence[Measurement],
    *,
    loss: Loss = "linear",
    loss_scale: float = 2.0,
    starts: int = 1,
    seed: int = 0,
    search: Search | None = None,
) -> Identification:
    """Fit free parameters to measured modes, critical speeds, response curves, stiffness and known values.

    Parameters
    ----------
    machine
        A machine, or the path of a machine file, where the fit begins.
    free
        :class:`~autobalancer.rotordynamics.parameter_fit.FreeParameter` entries, or a mapping from paths to
        (lower, upper) in SI or as texts with a unit.
    measurements
        Entries of :mod:`autobalancer.rotordynamics.parameter_fit`, each weighted by its standard deviation.
    loss
        ``linear`` (least squares), or ``soft_l1``, ``huber``, ``cauchy``, which are robust against outliers.
    loss_scale
        Number of standard deviations above which a deviation is treated as an outlier; not used by ``linear``.
    starts
        Number of searches: from the machine, and from points spread over the bounds.
    seed
        Of these points.
    search
        How differences are taken, and when the search ends; by default as exactly as the measurements allow.

    Returns
    -------
    Identification
        The fitted machine and the labelled data.

    Raises
    ------
    QuestionError
        If there are no free parameters or measurements, an entry is not possible, no start has everything that was measured, or
        a unit is probably wrong.
    MachineError
        If the rotor is not possible as described.
    """
    machine = balls_in_races(machine)
    sought = unknowns(machine, free)
    if not measurements:
        raise QuestionError("identify: measurements: given none; give at least one")
    one_of("identify: loss", loss, *get_args(Loss))
    if not (math.isfinite(loss_scale) and loss_scale > 0.0):
        raise QuestionError(f"identify: loss_scale: given {loss_scale!r}; must be greater than zero")
    if isinstance(starts, bool) or not isinstance(starts, int) or starts < 1:
        raise QuestionError(f"identify: starts: given {starts!r}; must be a whole number from 1")
    if starts > MOST_STARTS:
        raise QuestionError(
            f"identify: starts: given {starts}; each is a fit of its own, at most {MOST_STARTS} are possible"
        )
    # a search as fine as the coarsest measurement needs
    search = search or max(
        (getattr(measurement, "search", EXACT) for measurement in measurements), key=lambda one: one.error
    )
    units = {u.name: u.unit for u in sought}
    rows = [measurement.rows() for measurement in measurements]
    rows = [replace(r, unit=units.get(r.label.removeprefix("known "), r.unit)) for r in rows]
    # the machine at the start answers first: what cannot be asked of it, or is far away, is refused
    begin = np.array([u.inner(u.start) for u in sought])
    first = _trial(machine, sought, begin)
    before = _predictions(first, measurements)  # a wrong question is refused here
    for measurement in measurements:
        for doubt in getattr(measurement, "doubts", lambda _: [])(first):
            raise QuestionError(f"identify: {doubt} Otherwise begin with a machine that is closer")

    # the search asks for the same point several times in a row
    last: dict[bytes, Floats] = {}

    def residuals(point: Floats) -> Floats:
        key = point.tobytes()
        if key not in last:
            value = away(point)
            last.clear()
            last[key] = value
        return last[key]

    def away(point: Floats) -> Floats:
        try:
            predicted = _predictions(_trial(machine, sought, point), measurements)
        except MachineError:
            return np.full(sum(r.measured.size for r in rows), np.nan)
        return np.concatenate([m.residual(p) for m, p in zip(measurements, predicted, strict=True)])

    low, high = np.array([u.inner_bounds for u in sought]).T
    fit = best_fit(residuals, begin, low, high, loss, loss_scale, starts, seed, search)
    values = np.array([u.outer(v) for u, v in zip(sought, fit.variables, strict=True)])
    # how well the numbers are known: from the derivatives at the fit, without outliers
    deviation = residuals(fit.variables)
    weight = weights(deviation, loss, loss_scale)
    at_bound = (fit.variables == low) | (fit.variables == high)
    known = determination(sought, values, np.sqrt(weight)[:, None] * fit.jacobian, at_bound, search.error)
    at_end = _trial(machine, sought, fit.variables)
    after = np.concatenate(_predictions(at_end, measurements))
    fitted = _applied(machine, sought, values)
    names = ", ".join(u.name for u in sought)
    note = f"Identified from {deviation.size} measured values: {names}."
    fitted = fitted.model_copy(update={"description": f"{machine.description} {note}".strip()})
    fitted = Machine(**{key: getattr(fitted, key) for key in fitted.model_fields_set | {"description"}})
    fitted = in_author_units(fitted, machine)
    data = dataset(
        machine, fitted, sought, values, at_bound, known, rows, np.concatenate(before), after, deviation, weight, fit
    )
    for measurement in measurements:
        data.attrs["notes"] += getattr(measurement, "notes", lambda _: [])(at_end)
    data.attrs |= {"loss": loss, "loss_scale": loss_scale}
    return Identification(fitted, with_curves(data, measurements, _trial(machine, sought, begin), at_end))


def _applied(machine: Machine, sought: list[Unknown], values: Floats) -> Machine:
    for unknown, value in zip(sought, values, strict=True):
        machine = unknown.applied(machine, float(value))
    return machine


def _trial(machine: Machine, sought: list[Unknown], point: Floats) -> Trial:
    values = np.array([u.outer(float(v)) for u, v in zip(sought, point, strict=True)])
    names = {u.name: float(value) for u, value in zip(sought, values, strict=True)}
    return Trial(_applied(machine, sought, values), names)


def _predictions(trial: Trial, measurements: Sequence[Measurement]) -> list[Floats]:
    return [measurement.predict(trial) for measurement in measurements]


# Response curves of the machine before and after a fit, also between the measured speeds, where a peak may lie.


EVEN, CLOSE = 300, 40  # speeds over the whole curve, and about each peak of it


def with_curves(data: xr.Dataset, measurements: Sequence[Measurement], before: Trial, after: Trial) -> xr.Dataset:
    """``data`` with ``curve_speed``, ``curve_label``, ``curve_before`` and ``curve_after`` along ``point``."""
    responses = [measurement for measurement in measurements if isinstance(measurement, MeasuredResponse)]
    parts = [_curves(response, before, after) for response in responses]
    if not parts:
        return data
    speed, first, last = np.concatenate(parts, axis=1)
    labels = [response.label for response, part in zip(responses, parts, strict=True) for _ in range(part.shape[1])]
    meanings = {
        "curve_speed": (speed, "rotor speed of the drawn curve, rad/s"),
        "curve_label": (np.array(labels, dtype=object), "which curve"),
        "curve_before": (first, "of the machine at the start, SI"),
        "curve_after": (last, "of the fitted machine, SI"),
    }
    for name, (values, text) in meanings.items():
        data[name] = ("point", values, {"long_name": text})
    return data


def _curves(measured: MeasuredResponse, before: Trial, after: Trial) -> Floats:
    """Rows: speed, before, after; the measured speeds are among them, and many about the peaks of both."""
    given = np.asarray(measured.speeds, np.float64)
    speeds = np.unique(np.concatenate([given, np.linspace(given.min(), given.max(), EVEN)]))
    first, last = (_response(measured, trial, speeds) for trial in (before, after))
    close = [speeds]
    for values in (first, last):
        for i in np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] > values[2:])) + 1:
            close.append(np.linspace(speeds[i - 1], speeds[i + 1], CLOSE))
    speeds = np.unique(np.concatenate(close))
    return np.array([speeds, *(_response(measured, trial, speeds) for trial in (before, after))])


def _response(measured: MeasuredResponse, trial: Trial, speeds: Floats) -> Floats:
    return replace(measured, speeds=speeds).predict(trial)


# The labelled data of a fit, and its report.


OUTLIER = 0.5  # weight below which a value counts as one
MANY = ("run-up", "orders")  # kinds of rows that are samples of one measurement
TOO_LARGE = 2.0  # ratio of the scatter to the stated errors above which a note says so
TOO_SMALL, COMPUTED, ENOUGH = (
    0.8,
    0.01,
    50,
)  # the same below which one does, but of computed values; so many are needed to tell


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
    """See :class:`~autobalancer.rotordynamics.identify.Identification`."""
    names = np.array([u.name for u in sought], dtype=object)
    per_row = [(r, i) for r in rows for i in range(r.measured.size)]

    def words(entries: list[str]) -> np.ndarray:
        return np.array(entries, dtype=object)

    coordinates = {name: (name, names, "free parameter") for name in ("parameter", "other_parameter")}
    # the free parameters, how they hang together, and each measured row before and after the fit
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
    result = labeled(data, coordinates)
    # how well the fit explains the scatter: errors that were given too small enlarge all uncertainties
    freedom = deviation.size - known.rank - int(at_bound.sum())
    ratio = float(np.sqrt((deviation**2).sum() / freedom)) if freedom > 0 else float("nan")
    misfit = float(np.sqrt((weight * deviation**2).sum() / freedom)) if freedom > 0 else 1.0
    result["uncertainty"] = result["uncertainty"] * max(1.0, misfit)
    result["uncertainty"].attrs["long_name"] = "standard uncertainty, SI"
    # what a reader has to know before the numbers are used
    notes = list(known.notes)
    if ratio > TOO_LARGE:
        notes.append(
            f"the deviations are {ratio:.1f} times the stated errors: the model does not describe the data to these errors; "
            f"the uncertainties above are enlarged {max(1.0, misfit):.1f} times"
        )
    elif freedom >= ENOUGH and COMPUTED < ratio < TOO_SMALL:
        notes.append(
            f"the deviations are {ratio:.2g} of the stated errors: these are too large, and so probably are the uncertainties"
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
            away = np.abs(part["deviation"].values)
            rms, greatest = float(np.sqrt(np.mean(away**2))), float(away.max())
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
        last = f"{numbers[2]:.6g} {unit}, {float(part['deviation'][0]):+.2f}"
        lines.append(f"  {label}: {numbers[0]:.6g} -> {numbers[1]:.6g}, {last}")
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
    return unit_of(entry) if isinstance(entry, WrittenFloat) and sought.unit not in ("", "K") else sought.unit


def shown_parameter(dataset: xr.Dataset) -> tuple[float, str]:
    """Factor and unit in which people read a free parameter: that of the machine file."""
    unit = str(dataset["written_unit"].item())
    return (1.0 / to_si(f"1 {unit}", str(dataset["unit"].item())) if unit else 1.0), unit


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
    groups: list[tuple[str, xr.Dataset]] = []
    start = 0
    for end in range(1, labels.size + 1):
        same = (
            end < labels.size and labels[end] == labels[start] and data["row_kind"].values[end] in ("response", *MANY)
        )
        if not same:
            groups.append((str(labels[start]), data.isel(row=slice(start, end))))
            start = end
    return groups


# How well measurements determine parameters: singular values, standard uncertainties, correlation.


WEAK = 0.5  # standard uncertainty of a combination, relative to the values, above which a note says so
LIKE = 0.98  # correlation above which two parameters are hardly told apart
PART = 0.1  # of a direction: smaller parts are not named


@dataclass(frozen=True)
class Determination:
    """Standard uncertainties (inf where undetermined, nan at a bound), correlation and the directions of the data."""

    uncertainty: Floats
    correlation: Floats
    singular: Floats  # (p,) of the weighted Jacobian over relative changes, descending
    directions: Floats  # (p, p) one per row
    rank: int
    notes: list[str]


def determination(
    unknowns: list[Unknown], values: Floats, jacobian: Floats, at_bound: np.ndarray, no_effect: float = 1e-7
) -> Determination:
    """From the weighted Jacobian of the residuals (rows, p) over the search variables.

    Singular values below ``no_effect`` of the greatest one are errors of its differences.
    """
    count = len(unknowns)
    free = np.flatnonzero(~at_bound)
    singular, directions = np.zeros(count), np.zeros((count, count))
    uncertainty, correlation = np.full(count, np.nan), np.full((count, count), np.nan)
    notes = [
        f"{unknowns[i].name} lies at its bound, {values[i]:.6g} {unknowns[i].unit}" for i in np.flatnonzero(at_bound)
    ]
    if free.size == 0:
        return Determination(uncertainty, correlation, singular, directions, 0, notes)
    padded = np.vstack([jacobian[:, free], np.zeros((max(0, free.size - jacobian.shape[0]), free.size))])
    _, result, rows = np.linalg.svd(padded, full_matrices=False)
    singular[: free.size], directions[: free.size, free] = result, rows
    rank = int(np.sum(result > no_effect * max(result[0], 1e-300)))
    names = [unknowns[i].name for i in free]
    lost = np.abs(rows[rank:]).max(axis=0, initial=0.0) > 1e-3
    inverse = rows[:rank].T / result[:rank]
    covariance = inverse @ inverse.T
    deviation = np.sqrt(np.diag(covariance))
    slopes = np.array([abs(unknowns[i].slope(values[i])) for i in free])
    uncertainty[free] = np.where(lost, np.inf, deviation * slopes)
    with np.errstate(divide="ignore", invalid="ignore"):
        related = covariance / np.outer(deviation, deviation)
    related[lost, :] = related[:, lost] = np.nan
    correlation[np.ix_(free, free)] = related * np.outer(*[np.sign([unknowns[i].slope(values[i]) for i in free])] * 2)
    for row in rows[rank:]:
        notes.append(f"the data do not determine {_combination(row, names)}; fix one of them, or measure more")
    for size, row in zip(result[:rank], rows[:rank], strict=True):
        if 1.0 / size > WEAK:
            notes.append(f"hardly determined, within {100.0 / size:.0f} %: {_combination(row, names)}")
    pairs = [(a, b) for a in range(free.size) for b in range(a) if abs(related[a, b]) > LIKE]
    notes += [
        f"{names[b]} and {names[a]} can hardly be distinguished: correlation {related[a, b]:.4f}" for a, b in pairs
    ]
    return Determination(uncertainty, correlation, singular, directions, rank, notes)


def _combination(direction: Floats, names: list[str]) -> str:
    turned = direction * np.sign(direction[np.argmax(np.abs(direction))])
    parts = [(part, name) for part, name in zip(turned, names, strict=True) if abs(part) > PART]
    if len(parts) == 1:
        return parts[0][1]
    text = " ".join(f"{'+' if part > 0 else '-'} {abs(part):.2f} {name}" for part, name in parts)
    return f"the joint relative change {text.removeprefix('+ ')}"
