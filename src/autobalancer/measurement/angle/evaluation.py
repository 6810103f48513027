"""What measured equilibrium angles say: drag coefficients over the Reynolds number, and the coefficient of friction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.measurement.angle.curve import angle_machine, attributes
from autobalancer.measurement.angle.file import AngleSeries
from autobalancer.measurement.angle.rolling_resistance import (
    fit_rolling_resistance,
    overlaps,
    rolling_resistance_deviation,
)
from autobalancer.measurement.angle.statics import drag_coefficients, equilibrium_angles
from autobalancer.results.answers.labeled import Labeled
from autobalancer.results.provenance import provenance

WAYS = ("left out", "included")
MEANINGS = {
    "series": ("series", ""),
    "pressure_force": ("pressure force of the turning fluid", ""),
    "speed": ("rotor speed", "rad/s"),
    "measured_angle": ("angle from the lowest point, measured", "rad"),
    "angle": ("angle from the lowest point, by the drag law of the machine", "rad"),
    "reynolds": ("Reynolds number", "1"),
    "drag_coefficient": ("drag coefficient", "1"),
    "law_coefficient": ("drag coefficient of the law of the machine", "1"),
    "rolling_resistance": ("coefficient of rolling resistance", "1"),
    "rolling_resistance_deviation": ("its standard deviation", "1"),
}


def evaluate_angles(
    machine: Machine | str | Path,
    series: Sequence[AngleSeries],
    *,
    rolling: float | None = None,
    resamples: int = 100,
    seed: int = 0,
) -> xr.Dataset:
    """Drag coefficients by (6.6) of Spannan (2021), with and without the force P that it neglects.

    Parameters
    ----------
    machine
        With the ball and the race of the experiment: one ball on a horizontal axis.
    series
        Measured speeds and angles, :func:`~autobalancer.measurement.angle.file.load_angle_series`.
    rolling
        Coefficient of rolling resistance; by default the one for which overlapping series agree, else that of the machine.
    resamples
        Number of resamples of the points of each series, for the standard deviation of a fitted coefficient.
    seed
        Of the resamples.

    Returns
    -------
    xarray.Dataset
        Over ``point``: ``series``, ``speed``, ``measured_angle``, ``reynolds``, ``law_coefficient``; over ``pressure_force``
        (left out, included), too: ``drag_coefficient`` and the ``angle`` by the law of the machine. Over ``pressure_force``:
        ``rolling_resistance`` and ``rolling_resistance_deviation``, nan where nothing was fitted. The attribute
        ``rolling_resistance_from`` says where the coefficient comes from: fitted, given or machine.

    Raises
    ------
    QuestionError
        If the machine does not fit, there is no series, or an angle is above 90 degrees.
    """
    given = angle_machine(machine)
    if not series:
        raise QuestionError("equilibrium angle: no series to evaluate")
    if rolling is not None and not 0.0 <= rolling < 1.0:
        raise QuestionError(f"rolling: given {rolling:g}; a coefficient of rolling resistance is from 0 to below 1")
    parts = [(one.race(given.race), one.speeds, one.angles) for one in series]
    source = "given" if rolling is not None else "fitted" if overlaps(parts) else "machine"
    speeds, angles = (np.concatenate([part[i] for part in parts]) for i in (1, 2))
    reynolds = np.concatenate([race.reynolds(w) for race, w, _ in parts])
    found, stands, coefficients, deviations = [], [], [], []
    for pressure in (0.0, given.pressure):
        turned = [(replace(race, pressure=pressure), w, s) for race, w, s in parts]
        value = given.rolling if rolling is None else rolling
        deviation = float("nan")
        if source == "fitted":
            value = fit_rolling_resistance(turned)
            deviation = rolling_resistance_deviation(turned, resamples=resamples, seed=seed)
        coefficients.append(value)
        deviations.append(deviation)
        found.append(np.concatenate([drag_coefficients(race, w, s, value) for race, w, s in turned]))
        stands.append(np.concatenate([equilibrium_angles(race, given.law, w, value) for race, w, _ in turned]))
    each = ("pressure_force", "point")
    data = {
        "measured_angle": ("point", angles),
        "reynolds": ("point", reynolds),
        "law_coefficient": ("point", given.law.coefficient(reynolds)),
        "drag_coefficient": (each, np.array(found)),
        "angle": (each, np.array(stands)),
        "rolling_resistance": ("pressure_force", coefficients),
        "rolling_resistance_deviation": ("pressure_force", deviations),
    }
    names = np.repeat([one.name for one in series], [np.size(one.speeds) for one in series])
    coordinates = {"series": ("point", names), "speed": ("point", speeds), "pressure_force": list(WAYS)}
    answer = xr.Dataset(data, coordinates)
    for name in answer.variables:
        answer[name].attrs = dict(zip(("long_name", "units"), MEANINGS[str(name)], strict=True))
    title = f"Drag from equilibrium angles: {given.machine.name}"
    answer.attrs = {"title": title, **provenance(), **attributes(given), "rolling_resistance_from": source}
    return Labeled.of(answer)
