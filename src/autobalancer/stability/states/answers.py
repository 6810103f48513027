"""What the questions about steady states answer, as tables."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.results.answers.answer import Answer, at_speed
from autobalancer.results.number_text import length_text, moment_text
from autobalancer.shown import Column

MARK = "*"
OVERLAP = (
    f"states with {MARK} are those of points: balls of this size would overlap in them, and touch side by side instead"
)


class Equilibria(Answer):
    """Steady states at one speed."""

    __slots__ = ()
    row_of, needed = (
        "state",
        ("name", "verdict", "growth_rate", "ball_angle_in_rotor", "deflection", "residual_unbalance"),
    )

    def columns(self, unit: str = "") -> list[Column]:
        """Name, verdict, ball angles, deflection and residual unbalance of each state."""
        angles = np.degrees(self["ball_angle_in_rotor"].values) % 360.0
        names = [f"{name}{MARK * bool(here)}" for name, here in zip(self["name"].values, self._overlap(), strict=True)]
        return [
            Column("state", names),
            self.texts("verdict", "verdict"),
            Column("growth rate", self["growth_rate"].values, "1/s", ".3g"),
            Column("ball angles", [", ".join(f"{angle:.4g}" for angle in row) for row in angles], "°", wraps=True),
            Column("deflection", [length_text(value) for value in self["deflection"].values]),
            Column("residual unbalance", [moment_text(value) for value in self["residual_unbalance"].values]),
        ]

    def _overlap(self) -> NDArray[Any]:
        return self["overlapping"].values if "overlapping" in self else np.zeros(self.sizes["state"], np.bool_)

    def heading(self) -> str:
        """Whose they are, and at which speed."""
        return f"{super().heading()} {at_speed(self)}"

    def remarks(self) -> Sequence[str]:
        """What is left out, and which states need balls that are points."""
        return [*super().remarks(), *([OVERLAP] if self._overlap().any() else [])]


class Ranges(Answer):
    """Ranges of speed in which a state keeps its verdict."""

    __slots__ = ()
    row_of, needed = "range", ("from_speed", "to_speed", "verdict", "growth_rate", "leading_motion")

    def columns(self, unit: str = "") -> list[Column]:
        """Both ends, the verdict, and what grows fastest."""
        return [
            self.scaled("from_speed", "from", unit, ".6g"),
            self.scaled("to_speed", "to", unit, ".6g"),
            Column("state is", self["verdict"].values.tolist()),
            Column("growth rate at most", self["growth_rate"].values, "1/s", ".4g"),
            Column("fastest growing motion", self["leading_motion"].values.tolist(), wraps=True),
        ]


class Eigenvalues(Answer):
    """Eigenvalues of a state over the speed; the table joins speeds of one verdict."""

    __slots__ = ()
    drawn_by = "eigenvalues"
    row_of, needed = "speed", ("growth_rate", "verdict", "leading_motion")

    def columns(self, unit: str = "") -> list[Column]:
        """The ranges of one verdict, between the speeds that were asked for."""
        return ranges_from(verdict_rows(self)).columns(unit)

    def remarks(self) -> Sequence[str]:
        """What is left out, and where there is no such state."""
        found, missing = super().remarks(), np.size(self.attrs.get("speeds_without_state", ()))
        return [*found, f"no such state at {missing} of the speeds"] if missing else found


def verdict_rows(found: xr.Dataset) -> list[list[Any]]:
    """Speeds in a row with one verdict: first, last, verdict, greatest growth rate, the motion there, whether a gap is before."""
    speeds, rates, verdicts, motions = (
        found[name].values for name in ("speed", "growth_rate", "verdict", "leading_motion")
    )
    missing = np.asarray(found.attrs.get("speeds_without_state", ()), np.float64)
    rows: list[list[Any]] = []
    for i, speed in enumerate(speeds):
        gap = i > 0 and bool(np.any((missing > speeds[i - 1]) & (missing < speed)))
        if not rows or gap or verdicts[i] != rows[-1][2]:
            rows.append([speed, speed, verdicts[i], rates[i], motions[i], gap])
        else:
            rows[-1][1] = speed
            if rates[i] > rows[-1][3]:
                rows[-1][3:5] = rates[i], motions[i]
    return rows


def ranges_from(rows: list[list[Any]]) -> Ranges:
    """The rows of :func:`verdict_rows` as a dataset."""
    names = ("from_speed", "to_speed", "verdict", "growth_rate", "leading_motion")
    units = ("rad/s", "rad/s", "", "1/s", "")
    columns = enumerate(zip(names, units, strict=True))
    return Ranges(
        {
            name: ("range", [row[k] for row in rows], {"long_name": name.replace("_", " "), "units": unit})
            for k, (name, unit) in columns
        }
    )
