"""How much each input adds to the scatter of a quantity, as a table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from autobalancer.results.answers.answer import Answer
from autobalancer.shown import Column

SHOWN = {"first": "alone", "total": "in all", "rank_correlation": "rank correlation"}


class Sensitivity(Answer):
    """Indices or rank correlations of each input, with their 95 % intervals."""

    __slots__ = ()
    drawn_by = "sensitivity"
    needed: ClassVar[tuple[str, ...]] = ()

    def heading(self) -> str:
        """What scatters."""
        return f"{self.attrs['study_name']}: what drives the scatter of {self.attrs['quantity'].replace('_', ' ')}"

    def columns(self, unit: str = "") -> list[Column]:
        """A row for each input, the strongest first."""
        flat = self if "point" not in self.dims else self.stack(row=("point", "input"))
        row = "input" if flat is self else "row"
        key = "total" if "total" in self else "rank_correlation"
        order = np.argsort(-np.abs(flat[key].values), kind="stable")
        if row == "row":  # the points of a grid one after the other
            order = order[np.argsort(flat["point"].values[order], kind="stable")]
        flat = flat.isel({row: order})
        points = "at" if "at" in flat.coords else "point"
        columns = [Column(points, flat[points].values.tolist())] if row == "row" else []
        columns.append(Column("input", [str(name).replace("_", " ") for name in flat["input"].values]))
        for name, head in SHOWN.items():
            if name in self:
                columns.append(Column(head, flat[name].values, "", ".3f"))
                columns.append(Column("95 % from", flat[f"{name}_low"].values, "", ".3f"))
                columns.append(Column("to", flat[f"{name}_high"].values, "", ".3f"))
        return columns

    def remarks(self) -> Sequence[str]:
        """What the numbers leave out."""
        return [str(text) for text in np.atleast_1d(self.attrs.get("remarks", []))]

    def has_table(self) -> bool:
        """All parts must be there."""
        return "input" in self.dims and any(name in self for name in SHOWN)
