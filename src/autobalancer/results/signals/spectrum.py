"""Spectra of measured signals show their lines with their names."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from autobalancer.results.answers.answer import Answer
from autobalancer.results.display_units import AxisUnit, speed_axis, vibration_axis
from autobalancer.shown import Column


class Spectrum(Answer):
    """One row for each line that stands out of the noise."""

    __slots__ = ()
    drawn_by = "spectrum"
    row_of: ClassVar[str] = "line"
    needed: ClassVar[tuple[str, ...]] = ("line_frequency", "line_amplitude", "line_name", "line_channel")
    shown_in: ClassVar[str] = "Hz"
    most = 40

    def facts(self) -> list[tuple[str, str]]:
        """How it was made."""
        a = self.attrs
        rows = [
            ("window", f"{a['window']}, mean of {a['averages']} segment{'s' * bool(a['averages'] > 1)}"),
            ("resolution", f"{a['resolution']:.4g} Hz, noise bandwidth {a['noise_bandwidth']:.4g} Hz"),
        ]
        if np.isfinite(a.get("speed", np.nan)):
            rows.append(("speed", f"{a['speed'] * 30.0 / np.pi:.5g} rpm"))
        else:
            rows.append(("speed", "not known or not steady, so lines have no order"))
        return rows

    def columns(self, unit: str = "") -> list[Column]:
        """Channel, frequency, amplitude and name of each line."""
        shown = speed_axis(unit or self.shown_in)
        units = [self.amplitude_unit(str(name)) for name in self["line_channel"].values]
        factors = np.array([unit.factor for unit in units])
        return [
            Column("channel", [str(name) for name in self["line_channel"].values]),
            Column("frequency", self["line_frequency"].values * shown.factor, shown.sign, ".5g"),
            *self._deviation("line_frequency_deviation", shown.factor, shown.sign),
            Column("amplitude", factors * self["line_amplitude"].values, form=".4g"),
            *self._deviation("line_amplitude_deviation", factors),
            Column("unit", [u.sign for u in units]),
            self.texts("line_name", "what it is"),
        ]

    def _deviation(self, name: str, factor: float | np.ndarray, sign: str = "") -> list[Column]:
        """None in files of earlier versions."""
        return [Column("+-", factor * self[name].values, sign, ".2g")] if name in self else []

    def amplitude_unit(self, channel: str) -> AxisUnit:
        """In which unit amplitudes of a channel are shown."""
        unit = str(self["units"].sel(channel=channel).values)
        greatest = float(np.nanmax(self["amplitude"].sel(channel=channel).values))
        return vibration_axis(unit, greatest)
