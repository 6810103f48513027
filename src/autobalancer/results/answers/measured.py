"""The measures of a run as a table: one row for each number."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr

from autobalancer.results.answers.answer import Answer
from autobalancer.results.display_units import measure_unit, speed_axis
from autobalancer.tables import Column


class Measured(Answer):
    """The measures of a run; several numbers of one measure, such as those of the balls, are rows of their own."""

    __slots__ = ()
    most = 200

    def columns(self, unit: str = "") -> list[Column]:
        """Name, of what where there are several, value, unit and meaning, which is shown at the first number of a measure."""
        rows = [row for entry in self.data_vars.values() for row in _rows(entry, unit or self.shown_in)]
        heads = ("measure", "of", "value", "unit", "meaning")
        last = len(heads) - 1
        return [Column(head, [row[k] for row in rows], wraps=k == last, once=k == last) for k, head in enumerate(heads)]

    def heading(self) -> str:
        """Which run."""
        return f"{self.attrs.get('machine_name', 'run')}: {self.attrs.get('outcome_text', 'measures')}"

    def has_table(self) -> bool:
        """Numbers with a unit and a meaning must be there."""
        return bool(self.data_vars) and all({"units", "long_name"} <= set(v.attrs) for v in self.data_vars.values())


def _rows(entry: xr.DataArray, speed_unit: str) -> Iterator[tuple[str, str, float, str, str]]:
    speed = speed_axis(speed_unit)
    sign, factor = measure_unit(entry.attrs["units"])
    if entry.attrs["units"] == "rad/s":
        sign, factor = speed.sign, speed.factor
    dim = str(entry.dims[0]) if entry.dims else ""
    names = entry[dim].values if dim in entry.coords else range(1, entry.size + 1)
    for name, value in zip(names if dim else ("",), np.atleast_1d(entry.values), strict=True):
        of = str(name) if isinstance(name, str) else f"{dim} {name}"
        yield str(entry.name), of if dim else "", float(value) * factor, sign, entry.attrs["long_name"]
