"""Bearings that become stiffer as they deflect: a force towards the middle of each, (k r^2 + (K max(r - g, 0) + T(r))/r) d.

T is the force of a table in cubic pieces, the first of which begins at r = 0 without a force. d is the way of the rotor from the
middle, r its length. Deflections count from where the rotor rests, so the force there is taken off. In axes that turn with the
rotor the middles are where it rests, and nothing turns.
"""

from __future__ import annotations

import math
from typing import Any

from autobalancer.kernels.flags import INLINE, njit
from autobalancer.kernels.host.linear import Motion, dot
from autobalancer.kernels.pointers import data, row
from autobalancer.kernels.system import System


@njit(**INLINE)
def tabled(one: Any, tables: Any, distance: float) -> float:
    """Force of the table of a bearing over the distance from its middle, N/m."""
    at = 5 * (one.first + one.pieces - 1)
    while at > 5 * one.first and tables[at] > distance:
        at -= 5
    way = distance - tables[at]
    rising = (tables[at + 1] * way + tables[at + 2]) * way + tables[at + 3]
    if at == 5 * one.first:
        return rising
    return (rising * way + tables[at + 4]) / distance


@njit(**INLINE)
def central(one: Any, tables: Any, x: float, y: float) -> tuple[float, float]:
    """Force of the rotor on a bearing at a deflection, N, less that at rest."""
    x -= one.center_x
    y -= one.center_y
    square = x * x + y * y
    rate, distance = one.cubic * square, math.sqrt(square)
    if distance > one.clearance:
        rate += one.contact * (1.0 - one.clearance / distance)
    if one.pieces > 0:
        rate += tabled(one, tables, distance)
    return rate * x - one.rest_x, rate * y - one.rest_y


@njit(**INLINE)
def hardened(p: System, motion: Motion) -> Motion:
    """Add the accelerations by all such bearings to f; returns the motion as it is."""
    size, width, q, f = p.host.size, p.host.width, data(p.work.q), data(p.work.f)
    rows, reach, tables = data(p.bearings.rows), data(p.bearings.reach), data(p.bearings.tables)
    for b in range(p.bearings.springs.shape[0]):
        at = 2 * b * width
        x, y = dot(rows, at, q, 0, size), dot(rows, at + width, q, 0, size)
        push_x, push_y = central(row(p.bearings.springs, b), tables, x, y)
        for i in range(size):
            f[i] -= reach[at + i] * push_x + reach[at + width + i] * push_y
    return motion
