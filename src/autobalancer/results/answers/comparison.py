"""Several machines side by side."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import xarray as xr

from autobalancer.results.answers.answer import Answer
from autobalancer.results.display_units import length_axis, speed_axis
from autobalancer.results.verdict.text import worse_by
from autobalancer.shown import Column


class Comparison(Answer):
    """One row for each machine: what its run left, and from which speed on its balanced state is stable."""

    __slots__ = ()
    drawn_by = "comparison"
    row_of: ClassVar[str] = "machine"
    needed: ClassVar[tuple[str, ...]] = ("machine", "verdict", "peak_deflection", "vibration", "exact_border")

    def columns(self, unit: str = "") -> list[Column]:
        """Deflections in micrometers; what is left in percent of the vibration without balls.

        Deep chambers have no exact border, so that their table has the force on their bearings in its place.
        """
        shown, length = speed_axis(unit or self.shown_in), length_axis("um", 1.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            left = 100.0 * self["vibration"].values / self["vibration_without_balls"].values
        known = np.isfinite(self["exact_border"].values) | (self["border_note"].values.astype(str) != "")
        last = (
            self.scaled("exact_border", "exact border", unit, ".4g")
            if known.any() or "support_force" not in self
            else Column("bearing force", self["support_force"].values, "N", ".3g")
        )
        at = [
            Column(f"at {speed * shown.factor:.4g} {shown.sign}", values * length.factor, length.sign, ".4g")
            for speed, values in zip(self["speed"].values, self["deflection_at"].values.T, strict=True)
        ]
        return [
            self.texts("machine", "machine"),
            *at,
            Column("peak", self["peak_deflection"].values * length.factor, length.sign, ".4g"),
            self.scaled("peak_speed", "peak at", unit, ".4g"),
            Column("left", left, "%", ".2f"),
            Column("settled after", self["settling_time"].values, "s", ".3g"),
            Column("verdict", self._verdicts()),
            last,
        ]

    def _verdicts(self) -> list[str]:
        """In words, with the passage where it is worse than without balls."""
        words = [str(word) for word in self["verdict"].values]
        if "peak_without_balls" not in self:
            return words
        with np.errstate(divide="ignore", invalid="ignore"):
            ratios = self["peak_deflection"].values / self["peak_without_balls"].values
        worse = [worse_by(float(ratio)) for ratio in ratios]
        return [word + f", {much} on the way" * bool(much) for word, much in zip(words, worse, strict=True)]

    def in_si(self) -> xr.Dataset:
        """One row for each machine, with a column for each speed that was asked for."""
        rows = self.drop_dims("bin", errors="ignore")
        if not rows.sizes.get("speed"):
            return rows.drop_dims("speed", errors="ignore")
        return rows.assign_coords(speed=[f"{speed:.6g} rad/s" for speed in rows["speed"].values])

    def remarks(self) -> list[str]:
        """Why a border is not known, and what it ignores; one sentence for all machines of which it is true."""
        concerned: dict[str, list[str]] = {}
        for name, note in zip(self["machine"].values, self["border_note"].values, strict=True):
            concerned.setdefault(str(note), []).append(str(name))
        return [f"{', '.join(names)}: {note}" for note, names in concerned.items() if note]
