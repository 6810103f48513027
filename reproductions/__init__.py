"""Published results, done again.

A module ``reproductions/<source>/<name>.py`` has a function ``reproduce(out: Path) -> list[dict]`` that puts
its pictures into ``out`` and returns rows, made by :func:`compared_all`. Every row has a kind, one of :data:`KINDS`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal, get_args

Kind = Literal["printed", "misprint", "closed form", "words", "external", "excluded model", "fitted", "internal"]
KINDS: dict[Kind, str] = {
    "printed": "a number or a curve that the source prints; nothing was fitted to it",
    "misprint": "what is right where the source prints something else, which the note gives",
    "closed form": "a formula of the source against an independent computation, such as a simulation",
    "words": "a statement of the source in words: yes or no, an order, or a wide range",
    "external": "the result of other software for the same machine",
    "excluded model": "a number of the source that a model held to be wrong must miss: a hit is that it stays away",
    "fitted": "parameters, or the range that is compared, were chosen to meet this target or after seeing it",
    "internal": "this software against itself or against its own closed form; a check, not a reproduction",
}
assert set(KINDS) == set(get_args(Kind))


@dataclass(frozen=True)
class Found:
    """One comparison. Target, obtained and tolerance are in ``unit``; a ``note`` says why a target is missed.

    An excluded model hits where it has a number, and this stays away from the target by more than the tolerance.
    ``figure`` is where the source has the target, if it is not that of :func:`compared_all`.
    """

    kind: Kind
    quantity: str
    unit: str
    target: float
    obtained: float
    tolerance: float
    note: str = ""
    figure: str = ""


def said(quantity: str, true: bool, note: str = "", figure: str = "") -> Found:
    """A statement in words that is true here or not."""
    return Found("words", f"{quantity} (1 = true)", "1", 1.0, float(true), 0.0, note, figure)


def compared_all(source: str, figure: str, found: Iterable[Found]) -> list[dict[str, Any]]:
    """Rows as they are kept; the deviation is obtained less target."""
    rows = []
    for entry in found:
        if entry.kind not in KINDS:
            raise ValueError(f"{entry.quantity}: kind {entry.kind!r}; must be one of {', '.join(KINDS)}")
        deviation = float(entry.obtained) - float(entry.target)
        size = abs(deviation)  # no number, no hit: each comparison with nan is false
        hit = size > entry.tolerance if entry.kind == "excluded model" else size <= entry.tolerance
        row = {
            "source": source,
            "figure": entry.figure or figure,
            "kind": entry.kind,
            "quantity": entry.quantity,
            "unit": entry.unit,
            "target": float(entry.target),
            "obtained": float(entry.obtained),
            "deviation": deviation,
            "tolerance": float(entry.tolerance),
            "verdict": "hit" if hit else "missed",
        }
        rows.append(row | ({"note": entry.note} if entry.note else {}))
    return rows
