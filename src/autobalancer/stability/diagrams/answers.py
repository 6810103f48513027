"""Branches as tables: one row for each branch, and one for each special point."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.results.answers.answer import Answer
from autobalancer.results.display_units import AxisUnit, axis_unit, speed_axis
from autobalancer.shown import Column
from autobalancer.stability.diagrams.tables import stable_ranges

SPECIAL = ("special_parameter", "special_frequency", "lyapunov_coefficient", "special_deflection_max", "special_period")


class Branches(Answer):
    """Branches of steady states and periodic motions along a parameter."""

    __slots__ = ()
    drawn_by = "branches"
    row_of, needed = "point", ("parameter", "branch", "name", "kind", "verdict")

    def branch_rows(self) -> list[dict[str, Any]]:
        """Number, kind, name, ends (SI) and stable ranges of each branch."""
        rows = []
        for number, ended in enumerate(self.attrs["branch_ends"], 1):
            part = self.isel(point=np.flatnonzero(self["branch"].values == number))
            if not part.sizes["point"]:  # cut out
                continue
            names, counts = np.unique(part["name"].values, return_counts=True)
            rows.append(
                {
                    "branch": number,
                    "kind": str(part["kind"].values[0]),
                    "name": str(names[np.argmax(counts)]),
                    "from": float(part["parameter"].values[0]),
                    "to": float(part["parameter"].values[-1]),
                    "lowest": float(part["parameter"].min()),
                    "highest": float(part["parameter"].max()),
                    "ended": ended,
                    "stable": stable_ranges(self, number),
                }
            )
        return rows

    def special_rows(self) -> list[dict[str, Any]]:
        """Type, branch, criticality and numbers (SI) of each special point; None where one is not known."""
        rows = []
        for i in range(self.sizes["special"]):
            row = {"type": str(self["special_type"].values[i]), "branch": int(self["special_branch"].values[i])}
            row["criticality"] = str(self["criticality"].values[i])
            numbers = {name.removeprefix("special_"): float(self[name].values[i]) for name in SPECIAL}
            rows.append({**row, **{key: value if math.isfinite(value) else None for key, value in numbers.items()}})
        return rows

    def columns(self, unit: str = "") -> list[Column]:
        """Motion, range of the parameter, where it is stable, and how the branch ended."""
        shown_in, rows = axis_unit(self["parameter"], unit or self.shown_in), self.branch_rows()

        def shown(value: float) -> str:
            return f"{value * shown_in.factor:.6g}"

        def span(stable: list[tuple[float, float]]) -> str:
            ends = sorted(sorted(pair) for pair in stable)
            parts = [shown(a) if shown(a) == shown(b) else f"{shown(a)} to {shown(b)}" for a, b in ends]
            return ", ".join(parts) or "nowhere"

        ends = [[row[key] * shown_in.factor for row in rows] for key in ("lowest", "highest")]
        return [
            Column("branch", [row["branch"] for row in rows]),
            Column("motion", [row["name"] for row in rows], wraps=True),
            Column("lowest", ends[0], shown_in.sign, ".6g"),
            Column("highest", ends[1], shown_in.sign, ".6g"),
            Column("stable or marginal", [span(row["stable"]) for row in rows], shown_in.sign, wraps=True),
            Column("ended", [row["ended"] for row in rows], wraps=True),
        ]

    def special_columns(self, rows: Sequence[dict[str, Any]], unit: str = "") -> list[Column]:
        """Special points, all or some of :meth:`special_rows`."""
        shown_in = axis_unit(self["parameter"], unit or self.shown_in)
        what = [f"{row['type']}, {row['criticality']}" if row["criticality"] else row["type"] for row in rows]
        return [
            Column("branch", [row["branch"] for row in rows]),
            Column("what", what),
            Column("at", [row["parameter"] * shown_in.factor for row in rows], shown_in.sign, ".6g"),
            Column("frequency", [row["frequency"] for row in rows], "rad/s"),
            Column("Lyapunov coefficient", [row["lyapunov_coefficient"] for row in rows]),
        ]

    def has_table(self) -> bool:
        """The ends of the branches must be known, too."""
        return super().has_table() and {"branch_ends", "machine_name", "ignores"} <= set(self.attrs)

    def heading(self) -> str:
        """Whose they are, along what, and what is left out."""
        ignores = f"; ignores {self.attrs['ignores']}" if self.attrs["ignores"] else ""
        return f"{self.attrs['machine_name']}: branches along {self['parameter'].attrs['long_name']}{ignores}"

    def remarks(self) -> Sequence[str]:
        """How many special points there are, and what is not followed."""
        count = self.sizes.get("special", 0)
        found = [f"{count} special points: special_rows() lists them"] if count else []
        return found + self.not_followed()

    def not_followed(self) -> list[str]:
        """Why motions are missing, if any may be."""
        why = self.attrs.get("not_followed")
        return [f"periodic motions: {why}"] if why else []


class BifurcationCurves(Answer):
    """Curves of Hopf points or folds over two parameters."""

    __slots__ = ()
    drawn_by = "bifurcation_curves"
    row_of, needed = "point", ("curve", "parameter", "second_parameter")

    def columns(self, unit: str = "") -> list[Column]:
        """The ranges of both parameters along each curve, of Hopf curves the frequencies, and the special points."""
        curves = [self.isel(point=np.flatnonzero(self["curve"].values == k)) for k in np.unique(self["curve"].values)]
        found = [Column("curve", [int(part["curve"][0]) for part in curves])]
        for name in ("parameter", "second_parameter"):
            axis = axis_unit(self[name], unit or self.shown_in)
            found.append(
                Column(str(self[name].attrs["long_name"]), [_span(part[name], axis) for part in curves], axis.sign)
            )
        if "frequency" in self:
            axis = speed_axis("Hz")
            found.append(Column("frequency", [_span(part["frequency"], axis) for part in curves], axis.sign))
            kinds = [", ".join(sorted(set(part["criticality"].values.tolist()))) for part in curves]
            found.append(Column("criticality", kinds, wraps=True))
        return [*found, Column("points", [part.sizes["point"] for part in curves])]

    def remarks(self) -> Sequence[str]:
        """The special points, and what is ignored."""
        first, second = (axis_unit(self[name], self.shown_in) for name in ("parameter", "second_parameter"))
        said = []
        for i, kind in enumerate(self["special_type"].values if "special_type" in self else ()):
            at = (float(self[f"special_{name}"].values[i]) for name in ("parameter", "second_parameter"))
            texts = (
                f"{axis.shown(value):.5g} {axis.sign}".rstrip() for axis, value in zip((first, second), at, strict=True)
            )
            said.append(f"{kind} at {', '.join(texts)}")
        return [*said, *super().remarks()]


def _span(values: xr.DataArray, axis: AxisUnit) -> str:
    low, high = (f"{axis.shown(float(end)):.5g}" for end in (values.min(), values.max()))
    return low if low == high else f"{low} to {high}"
