"""What friction holds, as rows of a table and for a program."""

from __future__ import annotations

import math

from autobalancer.stability.held import HeldByFriction


def friction_rows(held: HeldByFriction) -> list[tuple[str, str]]:
    """Names and texts: one for each plane with balls, or that there is none."""
    if not held.planes:
        return [("friction", held.note)]
    several = len(held.planes) > 1
    at = f"at {held.speed:.5g} rad/s = {held.speed * 30.0 / math.pi:.5g} rpm "
    rows = [(f"friction, {plane.name}" if several else "friction", at + plane.sentence) for plane in held.planes]
    return [*rows, ("friction", held.note)] if held.note else rows
