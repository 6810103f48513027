"""Studies of deep chambers as a table: the vertical amplitude over balls and friction."""

from __future__ import annotations

from itertools import product

import numpy as np

from autobalancer.results.answers.answer import Answer
from autobalancer.results.display_units import length_axis
from autobalancer.shown import Column

SHOWN = "vertical_amplitude"


class ChamberStudy(Answer):
    """Measures of many runs over chambers, friction, and numbers of balls."""

    __slots__ = ()

    def columns(self, unit: str = "") -> list[Column]:
        """A row for each chamber and friction, a column for each number of balls; seeds are averaged."""
        values = self[SHOWN].mean("seed", skipna=True) if "seed" in self[SHOWN].dims else self[SHOWN]
        values = values.transpose("layers", "friction", ...)
        length = length_axis(None, float(np.nanmax(values.values, initial=0.0)))
        rows = list(product(self["layers"].values, self["friction"].values))
        table = values.values.reshape(len(rows), -1) * length.factor
        heads = [f"{count} balls" for count in self["balls"].values] if "balls" in values.dims else ["mean amplitude"]
        return [
            Column("chamber", [str(layer) for layer, _ in rows]),
            Column("friction", [float(friction) for _, friction in rows], form="g"),
            *(Column(head, table[:, k], length.sign, ".4g") for k, head in enumerate(heads)),
        ]

    def remarks(self) -> list[str]:
        """What the table has, and over what it is a mean."""
        over = f", mean over {self.sizes['seed']} seeds" if self.sizes.get("seed", 1) > 1 else ""
        return [f"the table has {SHOWN}{over}"]

    def has_table(self) -> bool:
        """The amplitude over chambers and friction must be there."""
        return SHOWN in self and {"layers", "friction"} <= set(self[SHOWN].dims) <= {
            "layers",
            "friction",
            "balls",
            "seed",
        }
