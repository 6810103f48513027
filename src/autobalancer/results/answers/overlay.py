"""A run beside a measurement shows the measures of both."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from autobalancer.results.answers.answer import Answer
from autobalancer.results.display_units import AxisUnit, measure_unit, speed_axis, vibration_axis
from autobalancer.shown import Column


class Overlay(Answer):
    """One row for each channel and each measure: measured, of the run, and their difference with its standard deviation."""

    __slots__ = ()
    drawn_by = "overlay"
    most = 200
    needed: ClassVar[tuple[str, ...]] = ("measured_value", "simulated_value", "value_deviation")
    row_of: ClassVar[str] = "measure"

    def heading(self) -> str:
        """Of which machine."""
        return str(self.attrs.get("title", "run and measurement"))

    def facts(self) -> list[tuple[str, str]]:
        """How far each channel is from the run, beside what its noise explains."""
        rows = []
        places = self["place"].values if "place" in self else [""] * self.sizes["channel"]
        keys = ("channel", "units", "rms_measured", "rms_away", "rms_expected")
        for name, unit, size, away, noise, place in zip(*(self[key].values for key in keys), places, strict=True):
            shown = AxisUnit(*measure_unit("rad")) if unit == "rad" else vibration_axis(str(unit), float(size))
            factor, sign = shown.factor, shown.sign
            beside = f", its noise {noise * factor:.3g} {sign}" if np.isfinite(noise) else ", its noise is not known"
            rows.append(
                (
                    f"{name}, {place} of the run" if place else str(name),
                    f"rms of the difference {away * factor:.3g} {sign}{beside}",
                )
            )
        return rows

    def columns(self, unit: str = "") -> list[Column]:
        """Measures of both."""
        speed = speed_axis(unit or self.shown_in)
        units = [str(entry) for entry in self["measure_unit"].values]
        shown = [(speed.sign, speed.factor) if entry == "rad/s" else measure_unit(entry) for entry in units]
        factors = np.array([factor for _, factor in shown])
        seen, run, sure = (self[name].values * factors for name in self.needed)
        columns = [
            Column("measure", [str(name) for name in self["measure"].values]),
            Column("of", [str(name) for name in self["measure_of"].values]),
            Column("measured", seen, form=".5g"),
            Column("run", run, form=".5g"),
            Column("difference", seen - run, form=".3g"),
            Column("+-", sure, form=".2g"),
            Column("unit", [sign for sign, _ in shown]),
        ]
        return [column for column in columns if column.head != "of" or any(column.values)]

    def remarks(self) -> list[str]:
        """Which measures there cannot be, and what looks wrong."""
        return [str(note) for note in np.atleast_1d(self.attrs.get("notes", []))]
