"""Published coefficients of friction between a ball and its race: what they were found on, and where."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

from autobalancer.catalog.tables import rows
from autobalancer.shown import Table

NONE_GIVEN = (
    "no friction given: residuals are those of ideal balls; typical coefficients: autobalancer catalog friction"
)
"""What every answer about a machine without friction says."""


@dataclass(frozen=True)
class FrictionCoefficients:
    """Rolling resistance and adherence of one pair, as in ``friction`` of a race; nan where the source has none.

    ``kind`` says how they were found: measured, fitted, inferred, or an order of magnitude only; ``conditions`` on what.
    """

    name: str
    rolling_resistance: float
    adherence: float
    kind: str
    conditions: str
    source: str
    remark: str = ""


class Frictions(Table[FrictionCoefficients]):
    """Coefficients of friction of the catalog, a tuple."""

    head = ("pair", "rolling resistance", "adherence", "found")

    def row(self, entry: FrictionCoefficients) -> tuple[str, ...]:
        """Name, coefficients, and how they were found."""
        values = (entry.rolling_resistance, entry.adherence)
        return (entry.name, *("-" if math.isnan(value) else f"{value:g}" for value in values), entry.kind)


@cache
def friction() -> Frictions:
    """All coefficients of the catalog, from the smoothest pair to the roughest. They span more than three orders of magnitude."""
    return Frictions(
        FrictionCoefficients(
            name=row["name"],
            rolling_resistance=_number(row["rolling_resistance"]),
            adherence=_number(row["adherence"]),
            kind=row["kind"],
            conditions=row["conditions"],
            source=row["source"],
            remark=row["remark"],
        )
        for row in rows("friction.csv")
    )


def _number(text: str) -> float:
    return float(text) if text else math.nan
