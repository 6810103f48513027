"""The runs of a sweep as a table: one row for each."""

from __future__ import annotations

from typing import ClassVar

from autobalancer.results.answers.answer import Answer
from autobalancer.results.display_units import axis_unit, length_axis
from autobalancer.shown import Column

EXTRA = ("seed",)  # a dimension that is no parameter of the machine


class Swept(Answer):
    """The parameters of each run and what it left."""

    __slots__ = ()
    needed: ClassVar[tuple[str, ...]] = ("verdict", "outcome", "peak_deflection", "vibration", "residual_share")

    def columns(self, unit: str = "") -> list[Column]:
        """Parameters, greatest deflection and its speed, what is left, and the verdict."""
        runs = self["verdict"].dims
        flat = self.stack(one_run=runs) if len(runs) > 1 else self
        length = length_axis("um", 1.0)
        columns = []
        for name, values in flat.coords.items():
            if values.dims not in ((runs[0],), ("one_run",)) or name == "one_run":
                continue
            if values.dtype.kind in "fi" and name not in EXTRA:
                shown = axis_unit(self.coords[name], unit or self.shown_in)
                head = str(self.coords[name].attrs.get("long_name", name))
                columns.append(Column(head, shown.shown(values.values), shown.sign))
            else:
                columns.append(Column(str(name), [str(value) for value in values.values]))
        return [
            *columns,
            Column("peak", flat["peak_deflection"].values * length.factor, length.sign, ".4g"),
            Swept.of(flat).scaled("peak_speed", "peak at", unit, ".4g"),
            Column("vibration left", flat["vibration"].values * length.factor, length.sign, ".3g"),
            Column("unbalance left", 100.0 * flat["residual_share"].values, "%", ".2f"),
            Column("verdict", [str(word) for word in flat["verdict"].values]),
        ]

    def has_table(self) -> bool:
        """All measures must be there, over the runs."""
        return all(name in self for name in self.needed) and bool(self["verdict"].dims)
