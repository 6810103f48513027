"""Balancing without phase as a table: the correction that each sensor gives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from autobalancer.measurement.balancing.answer import shown_unit
from autobalancer.results.answers.answer import Answer
from autobalancer.shown import Column


class FourRun(Answer):
    """Correction from amplitudes alone."""

    __slots__ = ()
    drawn_by = "four_run"
    row_of = "channel"
    needed: ClassVar[tuple[str, ...]] = ("correction", "correction_angle")

    def columns(self, unit: str = "") -> list[Column]:
        """Mass and angle for each sensor and speed; two rows where the runs do not decide."""
        sign, factor = shown_unit(self["correction"].attrs["units"])
        rows = [(c, s) for c in range(self.sizes["channel"]) for s in range(self.sizes["solution"])]
        rows = [at for at in rows if np.isfinite(self["correction"].values[at])]

        def values(name: str, times: float = 1.0) -> list[float]:
            return [times * float(self[name].values[at]) for at in rows]

        turn = 180.0 / np.pi
        columns = [Column("sensor", [str(self["sensor"].values[c]) for c, _ in rows])]
        if np.isfinite(self["speed"].values).all():
            columns.append(Column("speed", [float(self["speed"].values[c]) * 30.0 / np.pi for c, _ in rows], "rpm"))
        return [
            *columns,
            Column("mass" if sign == "g" else "correction", values("correction", factor), sign, ".4g"),
            Column("+-", values("correction_deviation", factor), sign, ".2g"),
            Column("angle", [value % 360.0 for value in values("correction_angle", turn)], "deg", ".1f"),
            Column("+-", values("correction_angle_deviation", turn), "deg", ".2g"),
            Column("misfit", values("misfit"), "", ".2g"),
        ]

    def remarks(self) -> Sequence[str]:
        """What to be careful about."""
        return [line for line in str(self.attrs.get("warnings", "")).split("\n") if line]
