"""Places for equal balls in a cylinder or ring, in layers from the bottom (after Pakuła 2021, appendix 3)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

Array = Any
AIR = 1.002  # distance of neighbors over their diameter


def filling_sites(
    radius: float, depth: float, ball_radius: float, inner_radius: float = 0.0, half_width: float | None = None
) -> Array:
    """Places (sites, 3) for balls in a cylinder along x, from its middle, with the bottom at -z.

    Cylinders along x have another ``half_width`` there than their radius.
    Of several packings the one with most places: columns of staggered rows, staggered columns of straight rows, and around an
    inner wall circles within each other.
    """
    wide = ball_radius if half_width is None else half_width
    reach, half = radius - ball_radius, 0.5 * depth - wide
    pitch = 2.0 * ball_radius * AIR
    if half < 0.0 or reach < 0.0:
        return np.zeros((0, 3))
    along = _line(half, 2.0 * wide * AIR)
    best = np.zeros((0, 3))
    for sites in [*_rows(reach, pitch, along), *([_circles(reach, pitch, along)] if inner_radius > 0.0 else [])]:
        near = inner_radius + ball_radius if inner_radius > 0.0 else 0.0
        inside = sites[np.hypot(sites[:, 1], sites[:, 2]) >= near * (1.0 - 1e-12)]
        if len(inside) > len(best):
            best = inside
    return best


def balls_beside(depth: float, ball_radius: float) -> int:
    """How many balls lie beside each other over the depth of a chamber."""
    return _count(0.5 * depth - ball_radius, 2.0 * ball_radius * AIR)


def _count(half: float, pitch: float) -> int:
    return math.floor(2.0 * half / pitch * (1.0 + 1e-12)) + 1


def _line(half: float, pitch: float) -> Array:
    count = _count(half, pitch)
    pitch = min(pitch, 2.0 * half) if count > 1 else pitch
    return (np.arange(count) - 0.5 * (count - 1)) * pitch


def _rows(reach: float, pitch: float, along: Array) -> list[Array]:
    found = []
    for lift in (0.5 * math.sqrt(3.0) * pitch, pitch):
        for low in (0.0, 0.5):
            sites = [np.zeros((0, 3))]
            height, row = -reach * (1.0 - 1e-9) if low == 0.0 else -lift * math.floor(reach / lift), 0
            while height <= reach:
                width = math.sqrt(max(reach**2 - height**2, 0.0))
                shift = 0.5 * pitch if (row % 2 and lift < pitch) else 0.0
                count = math.floor((width - shift) / pitch)
                offsets = np.arange(-count - (1 if shift else 0), count + 1) * pitch + shift
                inside = offsets[np.abs(offsets) <= width]
                sites.append(_row(inside, np.full(inside.size, height), along))
                height += lift
                row += 1
            found.append(np.vstack(sites))
    return found


def _circles(reach: float, pitch: float, along: Array) -> Array:
    sites = [np.zeros((0, 3))]
    circle = reach
    while circle > 0.5 * pitch:
        turn = 2.0 * math.asin(0.5 * pitch / circle)
        count = math.floor(2.0 * math.pi / turn * (1.0 + 1e-12))
        angles = (np.arange(count) - count // 2) * turn
        sites.append(_row(circle * np.sin(angles), -circle * np.cos(angles), along))
        circle -= pitch
    return np.vstack(sites)


def _row(y: Array, z: Array, along: Array) -> Array:
    """A line of places along x at each (y, z)."""
    n = along.size
    return np.column_stack([np.tile(along, y.size), np.repeat(y, n), np.repeat(z, n)])
