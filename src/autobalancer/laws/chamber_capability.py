"""Capability of a deep chamber: balls side by side on its wall, in straight rows along the axis.

The sum of Spannan (2021), (2.3), with as many balls at each angle as the depth takes.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence

_ROUNDING = 1e-9
Sized = tuple[int, float, float, float]  # number, radius, mass, half of what one takes along the axis


def chamber_capability(radius: float, depth: float, balls: Sequence[tuple[int, float, float] | Sized]) -> float:
    """Largest unbalance that the balls of a cylindrical chamber can balance [kg m].

    Parameters
    ----------
    radius, depth
        Of the chamber [m].
    balls
        Number, radius [m] and mass [kg] of equal balls, for each size; of cylinders half their length [m] too.

    Notes
    -----
    Balls that do not fit on the wall lie in the hollows of the full layer before them, which balances nothing. The balls
    of one angle lie beside each other over the depth; staggered rows may reach a little more.
    """
    merged: dict[tuple[float, float, float], int] = {}
    for count, size, mass, *halves in balls:
        kind = size, mass, halves[0] if halves else size
        merged[kind] = merged.get(kind, 0) + count
    left = [(count, *kind) for kind, count in merged.items() if count]
    inward = 0.0
    while True:
        columns = _columns(radius - inward, depth, left)
        taken = sum(half for _, half in columns)
        if taken <= math.pi * (1.0 + _ROUNDING):
            return _resultant(columns)
        # a full ring has no resultant: what it takes is gone
        ring = _ring(radius - inward, depth, left, math.pi / taken)
        inward += math.sqrt(3.0) * max(size for _, size, _, _ in left)
        left = [(of[0] - gone, *of[1:]) for of, gone in zip(left, ring, strict=True) if of[0] > gone]


def _ring(radius: float, depth: float, balls: Sequence[Sized], share: float) -> list[int]:
    """How many of each size fill one ring: ``share`` of each, then more while there is room, at least one ball."""
    ring = [math.floor(of[0] * share) for of in balls]
    for i, (count, *_) in enumerate(balls):
        while ring[i] < count:
            ring[i] += 1
            tried = [(number, *of[1:]) for number, of in zip(ring, balls, strict=True)]
            if sum(half for _, half in _columns(radius, depth, tried)) > math.pi * (1.0 + _ROUNDING):
                ring[i] -= 1
                break
    return ring


def _columns(radius: float, depth: float, balls: Sequence[Sized]) -> list[tuple[float, float]]:
    """Moment and half of the sector of the balls at each angle, one after the other."""
    found: list[tuple[float, float]] = []
    for count, size, mass, half in balls:
        orbit = max(radius - size, size)
        deep = max(math.floor(0.5 * depth / half * (1.0 + _ROUNDING)), 1)
        numbers = [deep] * (count // deep) + ([count % deep] if count % deep else [])
        found += [(number * mass * orbit, math.asin(size / orbit)) for number in numbers]
    return found


def _resultant(columns: Sequence[tuple[float, float]]) -> float:
    angle, total = 0.0, 0j
    for number, (moment, half) in enumerate(columns):
        angle += half + (columns[number - 1][1] if number else 0.0)
        total += cmath.rect(moment, angle)
    return abs(total)
