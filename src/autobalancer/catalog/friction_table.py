"""Published coefficients of friction between a ball and its race: what they were found on, and where."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

from autobalancer.catalog.tables import rows

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


@cache
def friction() -> tuple[FrictionCoefficients, ...]:
    """All coefficients of the catalog, from the smoothest pair to the roughest. They span more than three orders of magnitude."""
    return tuple(
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
