"""Measured signals show their channels, not their samples."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from autobalancer.results.answers.answer import Answer
from autobalancer.results.display_units import axis_unit, length_axis
from autobalancer.shown import Column


class Signals(Answer):
    """One row for each channel: what it is, where, and how large."""

    __slots__ = ()
    most = 60

    def facts(self) -> list[tuple[str, str]]:
        """Length, rate, and where they come from."""
        time = self["time"].values
        step = 1.0 / float(self.attrs["sampling_rate"])
        length = f"{time[0]:.6g} s to {time[-1]:.6g} s, {time.size} samples, one each {1e3 * step:.5g} ms"
        origin = str(self.attrs.get("origin", ""))
        return [("time", length), ("sampling rate", f"{1.0 / step:.6g} Hz"), *([("from", origin)] if origin else [])]

    def columns(self, unit: str = "") -> list[Column]:
        """Quantity, place with direction, mean, least, greatest and standard deviation."""
        shown = [_shown(entry, unit or self.shown_in) for entry in self.data_vars.values()]
        attrs = [entry.attrs for entry in self.data_vars.values()]
        return [
            Column("channel", [str(name) for name in self.data_vars]),
            Column("quantity", [str(a.get("quantity", "")) for a in attrs]),
            Column("place", [_place(a) for a in attrs]),
            Column("unit", [row[0] for row in shown]),
            *(
                Column(head, [row[1][k] for row in shown], form=".4g")
                for k, head in enumerate(("mean", "least", "greatest", "deviation"))
            ),
        ]

    def has_table(self) -> bool:
        """Every variable must be a channel."""
        return "sampling_rate" in self.attrs and "time" in self.coords and all(
            entry.dims == ("time",) for entry in self.data_vars.values()
        )  # fmt: skip

    def remarks(self) -> list[str]:
        """What was found and mended when they were read."""
        return [line for line in str(self.attrs.get("warnings", "")).split("\n") if line]


def _shown(entry: xr.DataArray, speed: str) -> tuple[str, list[float]]:
    size = float(np.abs(entry.values).max())
    unit = length_axis(None, size or 1.0) if entry.attrs.get("units") == "m" else axis_unit(entry, speed)
    v = np.asarray(unit.shown(entry.values), np.float64)
    return unit.sign, [float(v.mean()), float(v.min()), float(v.max()), float(v.std())]


def _place(attrs: dict[str, Any]) -> str:
    """Station and direction."""
    direction = attrs.get("direction", "")
    text = direction if isinstance(direction, str) else f"{float(direction):g}°"
    return f"{attrs.get('place', '')} {text}".strip()
