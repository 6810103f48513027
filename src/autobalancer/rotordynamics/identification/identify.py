"""Fit parameters of a machine to measurements."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from html import escape
from pathlib import Path
from typing import get_args

import numpy as np
import xarray as xr

from autobalancer.assembly.author_units import in_author_units
from autobalancer.assembly.rotors.model import Floats
from autobalancer.errors import MachineError, QuestionError
from autobalancer.files.given import balls_in_races
from autobalancer.machine import Machine
from autobalancer.pictured import picture_html
from autobalancer.rotordynamics.identification.determination import determination
from autobalancer.rotordynamics.identification.fit import EXACT, Loss, Search, best_fit, weights
from autobalancer.rotordynamics.identification.free import Bounds, FreeParameter, Unknown, unknowns
from autobalancer.rotordynamics.identification.measurements import MeasuredResponse, Measurement
from autobalancer.rotordynamics.identification.outcome import dataset, report_text
from autobalancer.rotordynamics.identification.trial import Trial

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
        return f"<pre>{escape(self.report())}</pre>{picture_html(self.data, 'identification', about)}"


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
        :class:`~autobalancer.rotordynamics.identification.free.FreeParameter` entries, or a mapping from paths to
        (lower, upper) in SI or as texts with a unit.
    measurements
        Entries of :mod:`autobalancer.rotordynamics.identification.measurements`, each weighted by its standard deviation.
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
    if loss not in get_args(Loss):
        raise QuestionError(f"identify: loss: given {loss!r}; must be one of {', '.join(get_args(Loss))}")
    if not (math.isfinite(loss_scale) and loss_scale > 0.0):
        raise QuestionError(f"identify: loss_scale: given {loss_scale!r}; must be greater than zero")
    if isinstance(starts, bool) or not isinstance(starts, int) or starts < 1:
        raise QuestionError(f"identify: starts: given {starts!r}; must be a whole number from 1")
    if starts > MOST_STARTS:
        raise QuestionError(
            f"identify: starts: given {starts}; each is a fit of its own, at most {MOST_STARTS} are possible"
        )
    search = search or max((getattr(one, "search", EXACT) for one in measurements), key=lambda one: one.error)
    units = {u.name: u.unit for u in sought}
    rows = [measurement.rows() for measurement in measurements]
    rows = [replace(r, unit=units.get(r.label.removeprefix("known "), r.unit)) for r in rows]
    begin = np.array([u.inner(u.start) for u in sought])
    first = _trial(machine, sought, begin)
    before = _predictions(first, measurements)  # a wrong question is refused here
    for measurement in measurements:
        for doubt in getattr(measurement, "doubts", lambda _: [])(first):
            raise QuestionError(f"identify: {doubt} Otherwise begin with a machine that is closer")

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
        return _residual(measurements, predicted)

    low, high = np.array([u.inner_bounds for u in sought]).T
    fit = best_fit(residuals, begin, low, high, loss, loss_scale, starts, seed, search)
    values = np.array([u.outer(v) for u, v in zip(sought, fit.variables, strict=True)])
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


def _residual(measurements: Sequence[Measurement], predicted: list[Floats]) -> Floats:
    return np.concatenate([m.residual(p) for m, p in zip(measurements, predicted, strict=True)])


# Response curves of the machine before and after a fit, also between the measured speeds, where a peak may lie.


EVEN, CLOSE = 300, 40  # speeds over the whole curve, and about each peak of it


def with_curves(data: xr.Dataset, measurements: Sequence[Measurement], before: Trial, after: Trial) -> xr.Dataset:
    """``data`` with ``curve_speed``, ``curve_label``, ``curve_before`` and ``curve_after`` along ``point``."""
    responses = [one for one in measurements if isinstance(one, MeasuredResponse)]
    parts = [_curves(one, before, after) for one in responses]
    if not parts:
        return data
    speed, first, last = np.concatenate(parts, axis=1)
    labels = [one.label for one, part in zip(responses, parts, strict=True) for _ in range(part.shape[1])]
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
