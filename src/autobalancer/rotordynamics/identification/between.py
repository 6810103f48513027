"""Response curves of the machine before and after a fit, also between the measured speeds, where a peak may lie."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from autobalancer.assembly.rotors.model import Floats
from autobalancer.rotordynamics.identification.measurements import MeasuredResponse, Measurement
from autobalancer.rotordynamics.identification.trial import Trial

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
