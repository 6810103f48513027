"""Forces on the balls of a race that come from neither contact nor fluid: springs, magnets, pins, ... and yours."""

from __future__ import annotations

import cmath
import math
from typing import Any, ClassVar

from autobalancer.machine.plugins import Leaf

# Lines of which symbols of forces are made, for pictures of a race; points are complex numbers in m, from its center.


Line = list[complex]


def coil(one: complex, other: complex, width: float, *, turns: int = 7) -> Line:
    """A spring between two points."""
    along = other - one
    across = 1j * along / (abs(along) or 1.0)
    inner = [one + along * (0.15 + 0.7 * (k + 0.5) / (2 * turns)) for k in range(2 * turns)]
    return [one, one + 0.15 * along, *_zigzag(inner, [across] * len(inner), width), other - 0.15 * along, other]


def bent_coil(radius: float, begin: float, end: float, width: float, *, turns: int = 7) -> Line:
    """A spring along a circle, between two angles in rad."""
    angles = [begin + (end - begin) * (0.15 + 0.7 * (k + 0.5) / (2 * turns)) for k in range(2 * turns)]
    rays = [cmath.rect(1.0, angle) for angle in angles]
    edge = 0.15 * (end - begin)
    return [
        *arc(radius, begin, begin + edge),
        *_zigzag([radius * ray for ray in rays], rays, width),
        *arc(radius, end - edge, end),
    ]


def arc(radius: float, begin: float = 0.0, end: float = 2.0 * math.pi) -> Line:
    """Part of a circle around the center of the race; all of it by default."""
    count = max(2, math.ceil(abs(end - begin) / 0.05))
    return [cmath.rect(radius, begin + (end - begin) * k / count) for k in range(count + 1)]


def stroke(angle: float, begin: float, end: float) -> Line:
    """A line along the radius, between two distances from the center."""
    return [cmath.rect(begin, angle), cmath.rect(end, angle)]


def _zigzag(points: Line, across: Line, width: float) -> Line:
    return [p + 0.5 * width * (1 - 2 * (k % 2)) * way for k, (p, way) in enumerate(zip(points, across, strict=True))]


class Force(Leaf):
    """A force on each ball of a race by itself.

    A leaf of this family is one class with these static methods, which are compiled when they are first used; ``at`` is the place
    of the ball (fields of ``PLACE`` in kernels/records.py), ``own`` has the keys of the leaf that are numbers.

    ``force(at, own) -> (fx, fy)``
        Force on the ball in N, in the axes of its race, which turn with the rotor.
    ``energy(at, own) -> float``
        Its potential energy in J; only a conservative force has one, and that is checked.

    What the ball gets the race gives: the opposite force acts on it at the place of the ball.
    """

    family: ClassVar[str] = "forces"
    one: ClassVar[str] = "force"
    current: ClassVar[int] = 1
    pairs: ClassVar[str] = ""  # of a PairForce: "neighbors" or "all"

    @classmethod
    def conservative(cls) -> bool:
        """Whether it says so itself, by having an energy."""
        return hasattr(cls, "energy")

    def impossible(self, race: Any, axis: str) -> str:
        """Why it cannot act in this race of a machine with this axis (``"vertical"`` or ``"horizontal"``); empty if it can."""
        return ""

    def drawn(self, orbit: float, balls: list[complex], speed: float) -> list[Line]:
        """Lines for pictures of a race with this orbit radius and balls at these places, m, at this speed of the rotor, rad/s."""
        return []


class PairForce(Force):
    """A force between two balls of a race.

    With ``pairs = "neighbors"`` it acts between each ball and the next of its race around the whole ring, with ``"all"`` between
    every two balls, once. ``next.ahead`` is the angle by which the next ball is ahead.

    ``force(at, next, own) -> (fx, fy, fx_next, fy_next)``
        Forces on both; what they do not cancel the race carries.
    ``energy(at, next, own) -> float``
        Potential energy of both in J; only a conservative force has one, and that is checked.
    """

    pairs: ClassVar[str] = "neighbors"
