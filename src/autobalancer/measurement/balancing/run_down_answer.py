"""Unbalances of all planes as a table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from autobalancer.results.answers.answer import Answer
from autobalancer.results.number_text import moment_text, share_text
from autobalancer.shown import Column


class PlaneUnbalances(Answer):
    """Unbalance vectors of several planes, from one run-down."""

    __slots__ = ()
    drawn_by = "run_down"
    row_of = "plane"
    needed: ClassVar[tuple[str, ...]] = ("unbalance", "unbalance_angle")

    def columns(self, unit: str = "") -> list[Column]:
        """Size and angle in each plane with their standard deviations."""
        turn = 180.0 / np.pi
        return [
            Column("plane", [str(name) for name in self["plane"].values]),
            Column("unbalance", 1e6 * self["unbalance"].values, "g mm", ".4g"),
            Column("+-", 1e6 * self["unbalance_deviation"].values, "g mm", ".2g"),
            Column("angle", np.mod(turn * self["unbalance_angle"].values, 360.0), "deg", ".1f"),
            Column("+-", turn * self["unbalance_angle_deviation"].values, "deg", ".2g"),
        ]

    def facts(self) -> list[tuple[str, str]]:
        """How well the model explains the readings, and what is known worst."""
        told = [
            ("of the readings not explained", share_text(float(self.attrs["left_over"]))),
            ("condition number", f"{self.attrs['condition']:.3g}"),
        ]
        if self.sizes["plane"] > 1:
            worst = self.isel(combination=0)
            parts = [
                f"{float(weight):.2g} {name} at {np.degrees(float(way)):.0f} deg"
                for weight, way, name in zip(
                    worst["weight"].values, worst["weight_phase"].values, self["plane"].values, strict=True
                )
            ]
            told.append(("known worst", f"{', '.join(parts)}: +- {moment_text(float(worst['combination_deviation']))}"))
        return told

    def has_table(self) -> bool:
        """Its numbers must be there, too."""
        return super().has_table() and {"left_over", "condition"} <= set(self.attrs)

    def remarks(self) -> Sequence[str]:
        """What to be careful about."""
        return [line for line in str(self.attrs.get("warnings", "")).split("\n") if line]
