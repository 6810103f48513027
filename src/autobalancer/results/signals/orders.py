"""Orders of measured signals show the greatest amplitude of each, and where it is."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from autobalancer.results.answers.answer import Answer
from autobalancer.results.display_units import AxisUnit, speed_axis, vibration_axis
from autobalancer.shown import Column


class Orders(Answer):
    """One row for each order of each channel."""

    __slots__ = ()
    drawn_by = "orders"
    needed: ClassVar[tuple[str, ...]] = ("amplitude", "phase", "amplitude_deviation", "phase_deviation")
    row_of: ClassVar[str] = "order"
    most = 60

    def facts(self) -> list[tuple[str, str]]:
        """Where they come from, speeds, and how they were found."""
        time, speed = self["time"].values, self["speed"].values
        rpm = 30.0 / np.pi
        rows = [
            ("time", f"{time[0]:.5g} s to {time[-1]:.5g} s, {time.size} points"),
            ("speed", f"{speed.min() * rpm:.5g} to {speed.max() * rpm:.5g} rpm"),
            ("method", str(self.attrs.get("method", ""))),
        ]
        if self.attrs.get("runout"):
            rows.append(("runout", str(self.attrs["runout"])))
        return rows

    def columns(self, unit: str = "") -> list[Column]:
        """Greatest amplitude with its deviation, phase and speed there."""
        shown = speed_axis(unit or self.shown_in)
        pairs = [(c, o) for c in range(self.sizes["channel"]) for o in range(self.sizes["order"])]
        peaks = [int(np.argmax(self["amplitude"].values[o, c])) for c, o in pairs]
        units = [self.amplitude_unit(c) for c, _ in pairs]

        def picked(name: str) -> list[float]:
            return [float(self[name].values[o, c, k]) for (c, o), k in zip(pairs, peaks, strict=True)]

        def scaled(name: str) -> list[float]:
            return [u.factor * value for u, value in zip(units, picked(name), strict=True)]

        return [
            Column("channel", [str(self["channel"].values[c]) for c, _ in pairs]),
            Column("order", [float(self["order"].values[o]) for _, o in pairs], form="g"),
            Column("peak", scaled("amplitude"), form=".5g"),
            Column("+-", scaled("amplitude_deviation"), form=".2g"),
            *([Column("bias", scaled("bias"), form=".2g")] if "bias" in self else []),
            Column("unit", [u.sign for u in units]),
            Column("at", [float(self["speed"].values[k]) * shown.factor for k in peaks], shown.sign, ".5g"),
            Column("phase there", np.rad2deg(picked("phase")), "deg", ".1f"),
            Column("+-", np.rad2deg(picked("phase_deviation")), "deg", ".2g"),
        ]

    def amplitude_unit(self, channel: int) -> AxisUnit:
        """In which unit amplitudes of a channel are shown."""
        greatest = float(np.nanmax(self["amplitude"].values[:, channel]))
        return vibration_axis(str(self["units"].values[channel]), greatest)

    def complex_amplitude(self, channel: str, order: float = 1.0) -> np.ndarray:
        """The amplitude times e^(i phase), SI; (time,)."""
        one = self.sel(channel=channel, order=order)
        return np.asarray(one["amplitude"].values * np.exp(1j * one["phase"].values))

    def remarks(self) -> list[str]:
        """What was doubtful."""
        return [line for line in str(self.attrs.get("warnings", "")).split("\n") if line]
