"""Fit a machine to a measured run-up."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import xarray as xr
from scipy.stats import norm

from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.measurement.comparison.run_up import MeasuredRunUp
from autobalancer.rotordynamics.identification.fit import Loss
from autobalancer.rotordynamics.identification.free import Bounds, FreeParameter
from autobalancer.rotordynamics.identification.identify import Identification, identify

COVERED = 0.95


def fit_run_up(
    machine: Machine | str | Path,
    measured: xr.Dataset | Sequence[xr.Dataset],
    parameters: Sequence[FreeParameter] | Mapping[str, Bounds],
    *,
    loss: Loss = "linear",
    starts: int = 1,
    seed: int = 0,
) -> Identification:
    """Find parameters with which a simulated run-up is the measured one.

    Every trial is a run of the machine with its drive and its start, sampled as the logger did. The sum of the squares of all
    deviations, each over its standard deviation, becomes least; the covariance is that of the least squares.

    Parameters
    ----------
    machine
        Where the fit begins; its drive and its start are those of the test.
    measured
        Signals with the ``uncertainty`` of each channel, or ball angles with their ``ball_angle_deviation``; or several of them
        of one run-up. Times are those of the run.
    parameters
        As ``free`` of :func:`autobalancer.rotor.identify`.
    loss, starts
        As there.
    seed
        Of the runs, and of the starts.

    Returns
    -------
    Identification
        As of :func:`autobalancer.rotor.identify`; ``data`` has over ``parameter`` also ``interval_low`` and ``interval_high``,
        which enclose the true value with 95 %, if the model is right and the noise white and as stated. ``data.attrs["notes"]``
        say which parameters cannot be told apart.

    Raises
    ------
    QuestionError
        If the noise is not known, a place is not in the machine, or there are fewer samples than parameters.
    """
    given = [measured] if isinstance(measured, xr.Dataset) else list(measured)
    if not given:
        raise QuestionError("fit_run_up: measured: given none; give signals, or ball angles of a film")
    names = ["run-up"] if len(given) == 1 else [f"run-up, measurement {number}" for number in range(1, len(given) + 1)]
    times = np.unique(np.concatenate([MeasuredRunUp(one).measured["time"].values for one in given]))
    parts = [MeasuredRunUp(one, seed, name, times.tolist()) for one, name in zip(given, names, strict=True)]
    values = sum(part.rows().measured.size for part in parts)
    if values <= len(parameters):
        raise QuestionError(f"fit_run_up: {values} measured values for {len(parameters)} parameters; give more values")
    found = identify(machine, parameters, parts, loss=loss, starts=starts, seed=seed)
    wide = float(norm.ppf(0.5 + 0.5 * COVERED)) * found.data["uncertainty"]
    for name, sign, text in (("interval_low", -1.0, "lower"), ("interval_high", 1.0, "upper")):
        found.data[name] = found.data["value"] + sign * wide
        found.data[name].attrs = {"long_name": f"{text} end of the interval of 95 %, SI"}
    return found
