"""Signals as a universal file: a time record in dataset 58 (ASCII) for each channel.

Format after the description of the Structural Dynamics Research Laboratory, University of Cincinnati. The name of a channel is
the first line of its record; in the fifth stand its quantity and direction, which the format has no place for where they are a
tacho or an angle.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from autobalancer.errors import ResultError

KINDS = {"displacement": 8, "velocity": 11, "acceleration": 12, "force": 9, "pressure": 15}
AXES = {"x": 1, "y": 2, "z": 3}
OWN = "autobalancer"  # first word of the fifth line
IN_LINE, LONGEST = 4, 10  # numbers in a line; letters of a place


def universal_text(signals: xr.Dataset) -> str:
    """All channels of signals.

    Raises
    ------
    ResultError
        If these are no signals, the name of a place is longer than the format allows, or the sampling interval needs more than
        its six digits.
    """
    if "sampling_rate" not in signals.attrs:
        raise ResultError("universal files hold signals; write other results as .nc, .csv or .json")
    time = np.asarray(signals["time"].values, np.float64)
    return "".join(
        _record(str(name), entry, time) for name, entry in signals.data_vars.items() if entry.dims == ("time",)
    )


def _record(name: str, entry: xr.DataArray, time: np.ndarray) -> str:
    place, unit = str(entry.attrs.get("place", "")), str(entry.attrs.get("units", ""))
    direction, quantity = str(entry.attrs.get("direction", "")), str(entry.attrs.get("quantity", ""))
    if len(place) > LONGEST:
        raise ResultError(f"{name}: place {place!r} has more than {LONGEST} letters, the most of a universal file")
    step = (time[-1] - time[0]) / (time.size - 1)
    if abs(float(f"{step:.5e}") - step) * time.size > 0.5 * step:
        raise ResultError(
            f"{name}: the interval {step:.9g} s has more than the six digits of a universal file; write .nc or .csv"
        )
    about = f"{'NONE':<20} {'NONE':<20}"
    lines = [
        "    -1",
        "    58",
        name[:80],
        *["NONE"] * 3,
        f"{OWN} {quantity} {direction}"[:80],
        f"{1:5d}{0:10d}{0:5d}{0:10d} {'NONE':<10}{place:>10}{AXES.get(direction, 0):4d} {'NONE':<10}{0:10d}{0:4d}",
        f"{4:10d}{time.size:10d}{1:10d}{time[0]:13.5e}{step:13.5e}{0.0:13.5e}",
        f"{17:10d}{0:5d}{0:5d}{0:5d} {'Time':<20} {'s':<20}",
        f"{KINDS.get(quantity, 0):10d}{0:5d}{0:5d}{0:5d} {quantity[:20]:<20} {unit:<20}",
        *[f"{0:10d}{0:5d}{0:5d}{0:5d} {about}"] * 2,
    ]
    values = np.asarray(entry.values, np.float64)
    lines += ["".join(f"{value:20.12e}" for value in values[i : i + IN_LINE]) for i in range(0, values.size, IN_LINE)]
    return "\n".join([*lines, "    -1", ""])
