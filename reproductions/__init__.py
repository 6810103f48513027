"""Published results, done again.

A module ``reproductions/<source>/<name>.py`` has a function ``reproduce(out: Path) -> list[dict]`` that puts
its pictures into ``out`` and returns rows, made by :func:`compared_all`.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

Found = tuple[str, str, float, float, float] | tuple[str, str, str, float, float, float]


def compared(
    *, source: str, figure: str, quantity: str, unit: str, target: float, obtained: float, tolerance: float
) -> dict[str, Any]:
    """One row. Target, obtained, deviation (obtained less target) and tolerance are all in ``unit``."""
    deviation = obtained - target
    return {
        "source": source,
        "figure": figure,
        "quantity": quantity,
        "unit": unit,
        "target": target,
        "obtained": obtained,
        "deviation": deviation,
        "tolerance": tolerance,
        "verdict": "hit" if abs(deviation) <= tolerance else "missed",
    }


def compared_all(source: str, figure: str | None, found: Iterable[Found]) -> list[dict[str, Any]]:
    """Rows of tuples (quantity, unit, target, obtained, tolerance); without a ``figure`` each tuple begins with its own."""
    rows = []
    for entry in found:
        where, (quantity, unit, target, obtained, tolerance) = (figure, entry) if figure else (entry[0], entry[1:])
        rows.append(
            compared(
                source=source,
                figure=str(where),
                quantity=quantity,
                unit=unit,
                target=target,
                obtained=obtained,
                tolerance=tolerance,
            )
        )
    return rows
