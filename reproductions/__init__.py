"""Published results, done again.

A module ``reproductions/<source>/<name>.py`` has a function ``reproduce(out: Path) -> list[dict]`` that puts
its pictures into ``out`` and returns rows, best made by :func:`compared`.
"""

from __future__ import annotations

from typing import Any


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
