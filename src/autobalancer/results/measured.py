"""The measures of a run as a table: one row for each number."""

from __future__ import annotations

import numpy as np

from autobalancer.results.answer import Answer
from autobalancer.results.display_units import measure_unit, speed_axis
from autobalancer.shown import Column


class Measured(Answer):
    """The measures of a run; several numbers of one measure, such as those of balls, are rows of their own."""

    __slots__ = ()

    def columns(self, unit: str = "") -> list[Column]:
        """Meaning, number from 1 where there are several, value and unit."""
        rows = []
        for entry in self.data_vars.values():
            speed = speed_axis(unit or self.shown_in)
            sign, factor = measure_unit(entry.attrs["units"])
            sign, factor = (speed.sign, speed.factor) if entry.attrs["units"] == "rad/s" else (sign, factor)
            numbers = np.atleast_1d(entry.values)
            rows += [
                (entry.attrs["long_name"], i, float(value) * factor, sign) for i, value in enumerate(numbers.flat, 1)
            ]
        heads = ("measure", "number", "value", "unit")
        return [Column(head, [row[k] for row in rows]) for k, head in enumerate(heads)]

    def heading(self) -> str:
        """Which run."""
        return f"{self.attrs.get('machine_name', 'run')}: {self.attrs.get('outcome_text', 'measures')}"

    def has_table(self) -> bool:
        """Numbers with a unit and a meaning must be there."""
        return bool(self.data_vars) and all({"units", "long_name"} <= set(v.attrs) for v in self.data_vars.values())
