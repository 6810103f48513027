"""Measurement files with all that a machine can be fitted to: also orders, signals and films, which they name."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.measurement.comparison.measured_orders import MeasuredOrders
from autobalancer.measurement.comparison.opened import load_measured
from autobalancer.measurement.comparison.run_up import MeasuredRunUp
from autobalancer.measurement.comparison.stated import is_film
from autobalancer.results.signals.signals import Signals
from autobalancer.rotordynamics.identification.free import FreeParameter
from autobalancer.rotordynamics.identification.measurement_file import Kind, read_measurements
from autobalancer.rotordynamics.identification.measurements import Measurement
from autobalancer.units import argument


def load_measurements(path: str | Path) -> tuple[list[FreeParameter], list[Measurement]]:
    """Read a measurement file.

    Parameters
    ----------
    path
        A TOML file with the lists ``parameters``, ``modes``, ``critical_speeds``, ``stiffnesses``, ``known``, ``responses``,
        ``orders`` and ``run_ups``; their keys are those of
        :class:`~autobalancer.rotordynamics.identification.free.FreeParameter`, of the classes in
        :mod:`autobalancer.rotordynamics.identification.measurements`, of ``MeasuredOrders`` and of ``MeasuredRunUp``. An
        ``error`` is a quantity or a text in percent of the value. A ``file`` is beside the TOML file: the table of a response;
        orders as table or result (.nc); signals, or the ball angles of a film (.nc), of a run-up.

    Returns
    -------
    list, list
        Free parameters and measurements, for :func:`~autobalancer.rotordynamics.identification.identify.identify`.

    Raises
    ------
    QuestionError
        If the file or an entry cannot be read; the message names the key.
    ResultError
        If a table or a result cannot be read.
    """
    free, found = read_measurements(path, MORE)
    return free, _sharing(found)


def _sharing(found: list[Measurement]) -> list[Measurement]:
    """Run-ups with the same seed are one run, sampled for all of them."""
    times = {one.seed: np.zeros(0) for one in found if isinstance(one, MeasuredRunUp)}
    for one in found:
        if isinstance(one, MeasuredRunUp):
            times[one.seed] = np.union1d(times[one.seed], one.measured["time"].values)
    return [replace(one, times=times[one.seed].tolist()) if isinstance(one, MeasuredRunUp) else one for one in found]


def _orders(entry: dict[str, Any], folder: Path) -> Measurement:
    asked = {"label": str(entry["file"]), **entry, "orders": folder / str(entry["file"])}
    del asked["file"]
    measured = MeasuredOrders(**asked)
    measured.rows()
    return measured


def _run_up(entry: dict[str, Any], folder: Path) -> Measurement:
    path = folder / str(entry["file"])
    given = load_measured(path)
    if not (is_film(given) or isinstance(given, Signals)):
        raise QuestionError(
            f"{path.name}: has neither signals nor ball angles of a film; orders stand under [[orders]], other results are no "
            "measurement of a run-up"
        )
    time = given["time"].values
    low, high = (
        float(argument(key, entry[key], "s") if key in entry else end)
        for key, end in (("start", time[0]), ("end", time[-1]))
    )
    part = _part(given, low, high, path.name)
    return MeasuredRunUp(part, entry.get("seed", 0), str(entry.get("label", entry["file"])))


def _part(given: xr.Dataset, low: float, high: float, name: str) -> xr.Dataset:
    time = given["time"].values
    found = given.isel(time=(time >= low) & (time <= high))
    if found.sizes["time"] < 2:
        raise QuestionError(f"{name}: nothing from {low:g} s to {high:g} s; it has {time[0]:g} s to {time[-1]:g} s")
    return found


MORE = {
    "orders": Kind(
        ("file", "error", "balls", "ball_angles", "lowest", "highest", "steady", "label"), ("file",), _orders
    ),
    "run_ups": Kind(("file", "start", "end", "seed", "label"), ("file",), _run_up),
}
