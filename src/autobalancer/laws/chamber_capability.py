"""Capability of a deep chamber: balls side by side on its wall, in straight rows along the axis.

The sum of Spannan (2021), (2.3), with as many balls at each angle as the depth takes.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence

_ROUNDING = 1e-9


def chamber_capability(radius: float, depth: float, balls: Sequence[tuple[int, float, float]]) -> float:
    """Largest unbalance that the balls of a cylindrical chamber can balance [kg m].

    Parameters
    ----------
    radius, depth
        Of the chamber [m].
    balls
        Number, radius [m] and mass [kg] of equal balls, for each size.

    Notes
    -----
    Balls that do not fit on the wall lie in the hollows of the full layer before them, which balances nothing. The balls
    of one angle lie beside each other over the depth; staggered rows may reach a little more.
    """
    left = [(count, size, mass) for count, size, mass in balls if count]
    inward = 0.0
    while True:
        columns = _columns(radius - inward, depth, left)
        taken = sum(half for _, half in columns)
        if taken <= math.pi * (1.0 + _ROUNDING):
            return _resultant(columns)
        # a full ring has no resultant: what it takes is gone, first the balls that come first
        share = math.pi / taken
        left = [(count - math.floor(count * share), size, mass) for count, size, mass in left]
        inward += math.sqrt(3.0) * max(size for _, size, _ in left)


def _columns(radius: float, depth: float, balls: Sequence[tuple[int, float, float]]) -> list[tuple[float, float]]:
    """Moment and half of the sector of the balls at each angle, one after the other."""
    found: list[tuple[float, float]] = []
    for count, size, mass in balls:
        orbit = max(radius - size, size)
        deep = max(math.floor(0.5 * depth / size * (1.0 + _ROUNDING)), 1)
        numbers = [deep] * (count // deep) + ([count % deep] if count % deep else [])
        found += [(number * mass * orbit, math.asin(size / orbit)) for number in numbers]
    return found


def _resultant(columns: Sequence[tuple[float, float]]) -> float:
    angle, total = 0.0, 0j
    for number, (moment, half) in enumerate(columns):
        angle += half + (columns[number - 1][1] if number else 0.0)
        total += cmath.rect(moment, angle)
    return abs(total)
