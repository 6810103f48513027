"""Lines of which symbols of forces are made, for pictures of a race; points are complex numbers in m, from its center."""

from __future__ import annotations

import cmath
import math

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


def box(middle: complex, width: float, height: float) -> Line:
    """A rectangle with its ``height`` along the radius."""
    out = middle / (abs(middle) or 1.0)
    corners = ((-1, -1), (-1, 1), (1, 1), (1, -1), (-1, -1))
    return [middle + 0.5 * out * complex(x * height, y * width) for x, y in corners]


def stroke(angle: float, begin: float, end: float) -> Line:
    """A line along the radius, between two distances from the center."""
    return [cmath.rect(begin, angle), cmath.rect(end, angle)]


def _zigzag(points: Line, across: Line, width: float) -> Line:
    return [p + 0.5 * width * (1 - 2 * (k % 2)) * way for k, (p, way) in enumerate(zip(points, across, strict=True))]
