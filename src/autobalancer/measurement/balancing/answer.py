"""Corrections as a table: mass and angle in each plane."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from autobalancer.results.answers.answer import Answer
from autobalancer.results.number_text import significant
from autobalancer.shown import Column

SHOWN = {"kg": ("g", 1e3), "kg m": ("g mm", 1e6), "m": ("µm", 1e6), "m/s": ("mm/s", 1e3), "m/s^2": ("m/s²", 1.0)}


def shown_unit(unit: str) -> tuple[str, float]:
    """The unit in which a quantity of a balancing job is shown, and its factor."""
    return SHOWN.get(unit, (unit, 1.0))


class Balancing(Answer):
    """Correction masses, and what should remain."""

    __slots__ = ()
    drawn_by = "balancing"
    row_of = "plane"
    needed: ClassVar[tuple[str, ...]] = ("correction", "correction_angle")

    def columns(self, unit: str = "") -> list[Column]:
        """Mass and angle of each plane, each with its standard deviation."""
        sign, factor = shown_unit(self["correction"].attrs["units"])
        turn = 180.0 / np.pi
        columns = [
            Column("plane", [str(name) for name in self["plane"].values]),
            Column("mass" if sign == "g" else "correction", factor * self["correction"].values, sign, ".4g"),
            Column("+-", factor * self["correction_deviation"].values, sign, ".2g"),
            Column("angle", np.mod(turn * self["correction_angle"].values, 360.0), "deg", ".1f"),
            Column("+-", turn * self["correction_angle_deviation"].values, "deg", ".2g"),
        ]
        if self.attrs.get("left_on"):
            columns += [
                Column("change by", factor * self["change"].values, sign, ".4g"),
                Column("at", np.mod(turn * self["change_angle"].values, 360.0), "deg", ".1f"),
            ]
        return columns

    def facts(self) -> list[tuple[str, str]]:
        """What remains."""
        found = []
        for c in range(self.sizes["channel"]):
            sign, factor = shown_unit(self["original"].attrs["units"])
            speed = float(self["speed"].values[c])
            at = "" if np.isnan(speed) else f", {speed * 30.0 / np.pi:.5g} rpm"
            sure = factor * float(self["residual_deviation"].values[c])
            more = "" if np.isnan(sure) else f" +- {significant(sure, 2)}"
            before, after = (factor * float(self[name].values[c]) for name in ("original", "residual"))
            after = 0.0 if after < 1e-9 * before else after
            found.append(
                (
                    f"sensor {self['sensor'].values[c]}{at}",
                    f"{significant(before)} to {significant(after)}{more} {sign}",
                )
            )
        return found

    def remarks(self) -> Sequence[str]:
        """What to be careful about."""
        return [line for line in str(self.attrs.get("warnings", "")).split("\n") if line]
