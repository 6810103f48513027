"""What friction holds, as rows of a table and for a program."""

from __future__ import annotations

from autobalancer.cli.terminal.words import speed_text
from autobalancer.stability.friction.held_values import HeldByFriction


def friction_rows(held: HeldByFriction) -> list[tuple[str, str]]:
    """Names and texts: one for each plane with balls, or that there is none."""
    if not held.planes:
        return [("friction", held.note)]
    several = len(held.planes) > 1
    at = f"at {speed_text(held.speed)} "
    rows = [(f"friction, {plane.name}" if several else "friction", at + plane.sentence) for plane in held.planes]
    return [*rows, ("friction", held.note)] if held.note else rows


def settled_rows(held: HeldByFriction) -> list[tuple[str, str]]:
    """The same of balls that settle at a lower speed."""
    several = len(held.planes) > 1
    at = f"at {speed_text(held.speed)} "
    return [(f"  settled, {p.name}" if several else "  settled", at + p.settled_sentence) for p in held.planes]
