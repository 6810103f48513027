"""Amplitude and phase over the speed: from a table, or from a dataset of orders."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.errors import QuestionError, ResultError
from autobalancer.files.table import Table, read_table
from autobalancer.measurement.balancing.channels import Orders
from autobalancer.measurement.noise_density import independent
from autobalancer.measurement.orders.fitted import window_of_fit
from autobalancer.measurement.orders.vold_kalman import passed_at
from autobalancer.measurement.signals.unit_words import quantity_of
from autobalancer.safe_file import as_path

EXAMPLE = "speed [rpm], place, direction, amplitude [um], phase [deg], amplitude deviation [um]"
Floats = NDArray[np.float64]
UNITS = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2"}
SAME = 1e-6  # relative difference of speeds that are one


def load_orders(path: str | Path) -> xr.Dataset:
    """Read amplitude and phase of the first order over the speed.

    Parameters
    ----------
    path
        A table with the columns ``speed``, ``place`` (a station, or a position in m), ``direction`` (x, y, or degrees from x),
        ``amplitude`` (of a displacement, velocity or acceleration), ``phase`` (lead of the vibration over the mark) and perhaps
        ``amplitude deviation``; one line for each speed and sensor.

    Returns
    -------
    xarray.Dataset
        ``amplitude``, ``phase``, ``amplitude_deviation`` over ``speed`` and ``channel``, SI; ``place``, ``direction`` and
        ``quantity`` of each channel.

    Raises
    ------
    ResultError
        If the file, a column, a unit or a number is missing or cannot be read.
    QuestionError
        If a sensor has no line at some speed; it names both.
    """
    table = read_table(as_path(path), EXAMPLE)
    quantity = _quantity(table)
    speed, amplitude = table.numbers("speed", "rad/s"), table.numbers("amplitude", UNITS[quantity])
    phase = table.numbers("phase", "rad")
    spread = np.full(speed.size, np.nan)
    if "amplitude deviation" in table.heads:
        spread = table.numbers("amplitude deviation", UNITS[quantity])
    channels = list(zip(table.texts("place"), table.texts("direction"), strict=True))
    names = list(dict.fromkeys(channels))
    speeds = np.unique(speed)
    speeds = speeds[np.r_[True, np.diff(speeds) > SAME * speeds[1:]]]
    data = np.full((3, speeds.size, len(names)), np.nan)
    for n, channel in enumerate(channels):
        at = int(np.argmin(np.abs(speeds - speed[n]))), names.index(channel)
        if not np.isnan(data[(0, *at)]):
            line = table.lines[n][0]
            raise QuestionError(
                f"{table.place}, line {line}: {' '.join(channel)} has two lines at this speed; keep one"
            )
        data[(slice(None), *at)] = amplitude[n], phase[n], spread[n]
    missing = np.argwhere(np.isnan(data[0]))
    if missing.size:
        s, c = missing[0]
        raise QuestionError(
            f"{table.place}: {' '.join(names[c])} has no line at {speeds[s] * 30.0 / np.pi:.5g} rpm; all sensors need all speeds"
        )
    both = ("speed", "channel")
    return xr.Dataset(
        {
            "amplitude": (both, data[0], {"units": UNITS[quantity], "long_name": "amplitude"}),
            "phase": (both, data[1], {"units": "rad", "long_name": "lead of the vibration over the mark"}),
            "amplitude_deviation": (both, data[2], {"units": UNITS[quantity], "long_name": "standard deviation"}),
        },
        {
            "speed": ("speed", speeds, {"units": "rad/s", "long_name": "rotor speed"}),
            "place": ("channel", np.array([name[0] for name in names], dtype=object)),
            "direction": ("channel", np.array([name[1] for name in names], dtype=object)),
            "quantity": ("channel", np.array([quantity] * len(names), dtype=object)),
        },
        {"source": str(path)},
    )


def _quantity(table: Table) -> str:
    if "amplitude" not in table.heads:
        raise ResultError(
            f"{table.place}: no column 'amplitude' with a unit; the first line must name the columns, such as: {EXAMPLE}"
        )
    written = table.heads["amplitude"][1]
    found = quantity_of("", written)
    if found in UNITS:
        return found
    raise ResultError(f"{table.place}: amplitude in {written!r}; must be a displacement, a velocity or an acceleration")


def given_orders(orders: xr.Dataset | str | Path, owner: str = "run-down", biased: bool = True) -> Orders:
    """First orders of a dataset, of its file or of a table, as arrays; of tracked ones those whose noise is independent.

    What the window or the filter probably takes away is part of the deviations, if what they are compared with is without it.

    Raises
    ------
    QuestionError
        If a variable, a place or a direction is missing.
    """
    from autobalancer.results.store import load_run

    if not isinstance(orders, xr.Dataset):
        orders = load_run(orders) if Path(orders).suffix.lower() == ".nc" else load_orders(orders)
    course = passed = None
    tracked = {"window_revolutions", "bandwidth"} & set(orders.attrs)  # and not measured at one speed after the other
    if tracked and "time" in orders.dims and "speed" in orders.variables and orders.sizes["time"] > 3:
        course = np.asarray(orders["time"].values, float), np.asarray(orders["speed"].values, float)
        if not ((np.diff(course[0]) > 0.0).all() and (course[1] > 0.0).all()):
            course = None
    about = orders.attrs
    orders = independent(orders)
    times = (
        np.asarray(orders["time"].values, float)
        if "time" in orders.dims
        else np.full(orders.sizes.get("speed", 0), np.nan)
    )
    if course is not None:
        passed = _passed(*course, np.searchsorted(course[0], times), about)
    if "order" in orders.dims:
        if 1.0 not in orders["order"].values:
            raise QuestionError(f"{owner}: the orders have no order 1, which is that of unbalance; track it, too")
        orders = orders.sel(order=1.0)
    if "time" in orders.dims and "speed" in orders.variables:
        orders = orders.reset_coords(drop=False).set_coords(["place", "direction", "quantity"]).swap_dims(time="speed")
    for name in ("amplitude", "phase", "speed", "place", "direction"):
        if name not in orders.variables:
            raise QuestionError(
                f"{owner}: the orders have no {name!r}; it must be there over speed and channel, or of each channel"
            )
    found = orders.transpose("speed", "channel", ...)
    amplitude, phase = found["amplitude"].values, found["phase"].values
    if not (np.isfinite(amplitude).all() and np.isfinite(phase).all()):
        s = int(np.argwhere(~np.isfinite(amplitude * phase))[0][0])
        raise QuestionError(
            f"{owner}: no amplitude and phase at {float(found['speed'][s]) * 30.0 / np.pi:.5g} rpm; leave this speed out"
        )
    spread = found["amplitude_deviation"].values if "amplitude_deviation" in found else np.full(amplitude.shape, np.nan)
    if biased and "bias" in found:
        spread = np.hypot(spread, found["bias"].values)
    across = spread
    if "phase_deviation" in found:
        across = np.fmax(spread, amplitude * found["phase_deviation"].values)
    quantities = found["quantity"].values if "quantity" in found.variables else ["displacement"] * amplitude.shape[1]
    for quantity in quantities:
        if quantity not in UNITS:
            raise QuestionError(f"{owner}: quantity {str(quantity)!r}; must be one of {', '.join(UNITS)}")
    return Orders(
        times,
        np.asarray(found["speed"].values, float),
        amplitude * np.exp(1j * phase),
        np.asarray(spread, float),
        np.asarray(across, float),
        tuple(map(_place, found["place"].values)),
        tuple(_direction(way, owner) for way in found["direction"].values),
        tuple(map(str, quantities)),
        np.asarray(found["runout_deviation"].values if "runout_deviation" in found else np.zeros(amplitude.shape[1])),
        course,
        passed,
    )


def _passed(time: Floats, speed: Floats, rows: NDArray[np.intp], about: dict[str, Any]) -> Floats:
    """What the tracking makes of amplitudes over the time at some of its instants, (row, time)."""
    if "bandwidth" in about:
        return passed_at(rows, time.size, float(about["bandwidth"]) * float(time[-1] - time[0]) / (time.size - 1))
    angle = np.r_[0.0, np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(time))]
    return window_of_fit(angle, rows, float(about["window_revolutions"]))


def _place(place: Any) -> str | float:
    try:
        return float(place)
    except ValueError:
        return str(place)


def _direction(direction: Any, owner: str) -> float:
    """Angle from x, rad."""
    text = str(direction).strip()
    if text in ("x", "y"):
        return 0.0 if text == "x" else 0.5 * np.pi
    try:
        return float(np.radians(float(text)))
    except ValueError:
        raise QuestionError(f"{owner}: direction {text!r}; must be x, y, or an angle from x in degrees") from None
