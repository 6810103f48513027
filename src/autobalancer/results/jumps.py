"""Jumps of the unbalance in a run, and the parts of the run between them."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import xarray as xr


def jump_times(run: xr.Dataset) -> list[float]:
    """Times (s) at which the unbalance jumped, in order; a file keeps a list of one as a number."""
    return [float(time) for time in np.atleast_1d(run.attrs.get("unbalance_jumps", []))]


def parts_between_jumps(run: xr.Dataset) -> list[tuple[float, float, xr.Dataset]]:
    """Begin, end (s) and data over time and bins of each part; one part without jumps.

    A part without any data, such as one that an early end of the run cut off, is left out.
    """
    end = float(run.attrs["end_time"])
    edges = [0.0, *(time for time in jump_times(run) if time < end), end]
    found = []
    for begin, until in itertools.pairwise(edges):
        inside: dict[str, Any] = {
            dimension: _within(run[name].values, begin, until, until == end)
            for dimension, name in (("time", "time"), ("bin", "envelope_time"))
            if name in run
        }
        empty = [dimension for dimension, mask in inside.items() if not mask.any()]
        if len(empty) < len(inside):
            rows = {name: np.flatnonzero(mask) for name, mask in inside.items() if name not in empty}
            found.append((begin, until, run.drop_dims(empty).isel(rows)))
    return found


def _within(time: Any, begin: float, until: float, last: bool) -> Any:
    return (time >= begin) & ((time <= until) if last else (time < until))
