"""Measured signals as a block of bytes whose waveforms the browser draws and zooms."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from autobalancer.app.view.packed import Packer
from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.style import INK, ball_color
from autobalancer.results.display_units import axis_unit, length_axis

WHOLE = 60_000  # samples of a channel that are sent as they are
BINS = 20_000  # of more samples least and greatest value are sent in so many bins
PANELS = 8


def wave_block(signals: xr.Dataset) -> bytes:
    """The channels of signals over time, those of one quantity in one panel.

    Raises
    ------
    QuestionError
        If there are no samples over time.
    """
    if "time" not in signals.dims:
        raise QuestionError("these are no signals over time")
    time = np.asarray(signals["time"].values, np.float64)
    out = Packer({"kind": "signals", "panels": []})
    out.add("time", time[[0, -1]], "float64")
    binned = time.size > WHOLE
    edges = np.unique(np.linspace(0, time.size, BINS + 1).astype(int))
    at = 0.5 * (time[edges[:-1]] + time[edges[1:] - 1]) if binned else time
    out.add("t", at, "float64")
    groups: dict[tuple[str, str], list[str]] = {}
    for name, one in signals.data_vars.items():
        if one.dims == ("time",):
            groups.setdefault((str(one.attrs.get("quantity", name)), str(one.attrs.get("units", ""))), []).append(
                str(name)
            )
    for (title, _), names in list(groups.items())[:PANELS]:
        most = max(float(np.abs(signals[name].values).max()) for name in names)
        lines: list[dict[str, Any]] = []
        for k, name in enumerate(names):
            one = signals[name]
            unit = length_axis(None, most or 1.0) if one.attrs.get("units") == "m" else axis_unit(one, "rpm")
            values = np.asarray(unit.shown(one.values), np.float64)
            line = {"name": name, "color": ball_color(k) if len(names) > 1 else INK, "t": "t"}
            cuts = {"high": np.maximum, "low": np.minimum} if binned else {"high": None}
            for key, cut in cuts.items():
                out.add(f"{key} {name}", values if cut is None else cut.reduceat(values, edges[:-1]))
                line[key] = f"{key} {name}"
            lines.append(line)
        out.head["panels"].append({"title": title, "unit": unit.sign, "lines": lines, "limits": None})
    return out.bytes
