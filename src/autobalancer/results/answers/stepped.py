"""Stepped responses as a table: one row for each speed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from autobalancer.results.answers.answer import Answer
from autobalancer.results.number_text import length_text
from autobalancer.shown import Column, rpm_and_si


class SteppedResponse(Answer):
    """Amplitudes speed by speed, up, down or both."""

    __slots__ = ()
    drawn_by = "stepped_response"
    row_of, most = "speed", 12

    def rows(self) -> list[tuple[str, list[float]]]:
        """Of each direction its name and the amplitudes (m) at all speeds."""
        whole = self["amplitude"] if "direction" in self.dims else self["amplitude"].expand_dims("direction")
        return [(str(name), row.tolist()) for name, row in zip(whole["direction"].values, whole.values, strict=True)]

    def columns(self, unit: str = "") -> list[Column]:
        """Speed, amplitude in each direction, and what the balls do."""
        amplitudes = [Column(f"amplitude {name}", [1e6 * value for value in row], "µm") for name, row in self.rows()]
        return [self.scaled("speed", "speed", unit, ".6g"), *amplitudes, *self._motions()]

    def heading(self) -> str:
        """Of which machine, how it was stepped, and how it ended."""
        how = f"{self.attrs['dwell']:.4g} s at each speed, measured for {self.attrs['window']:.4g} s"
        return f"{self.attrs['machine_name']}: stepped response, {how}; {self.attrs['outcome']}"

    def remarks(self) -> Sequence[str]:
        """The greatest amplitude of each direction, and what was noted."""
        said = list(self.greatest(rpm_and_si))
        return [*said, self.attrs["coincidence_text"]] if "coincidence_text" in self.attrs else said

    def greatest(self, speed_text: Callable[[float], str]) -> list[str]:
        """A sentence for each direction that was measured, with its speed as ``speed_text`` writes it."""
        said = []
        for name, row in self.rows():
            reached = [i for i, value in enumerate(row) if math.isfinite(value)]
            if reached:
                peak = max(reached, key=lambda i: row[i])
                at = speed_text(float(self["speed"].values[peak]))
                said.append(f"{name}: greatest amplitude {length_text(row[peak])} at {at}")
        return said

    def has_table(self) -> bool:
        """Amplitudes over the speed must be there."""
        known = {"machine_name", "dwell", "window", "outcome"} <= set(self.attrs)
        return known and "amplitude" in self and "speed" in self["amplitude"].dims

    def _motions(self) -> list[Column]:
        if "motion" not in self:
            return []
        words = np.array([*self["motion"].attrs["flag_meanings"], "-"], dtype=object)
        whole = self["motion"] if "direction" in self.dims else self["motion"].expand_dims("direction")
        names = [f"balls {name}" for name, _ in self.rows()]
        return [Column(name, words[row].tolist()) for name, row in zip(names, whole.values, strict=True)]
