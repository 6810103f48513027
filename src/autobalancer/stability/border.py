"""One border speed, whichever it is."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Border:
    """One border speed: ``speed`` in rad/s, infinite for never, nan where it does not exist; ``note`` says why."""

    name: str
    speed: float
    note: str
