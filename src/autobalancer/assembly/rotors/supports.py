"""Supports of a rotor as matrices."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from autobalancer.assembly.rotors.model import Floats, Matrix, Rows
from autobalancer.machine import SpeedTable, Support


def two(value: float | tuple[float, float]) -> tuple[float, float]:
    """Values along x and y."""
    return (float(value[0]), float(value[1])) if isinstance(value, tuple) else (float(value), float(value))


def table_speeds(tables: Sequence[SpeedTable]) -> Floats:
    """The common speeds of all tables, as far as all of them reach; [0] if there is none.

    Below its first speed a table keeps its first value.
    """
    if not tables:
        return np.zeros(1)
    end = min(float(table.speed[-1]) for table in tables)
    return np.array(sorted({0.0, *(float(w) for table in tables for w in table.speed if w <= end)}))


def at_speeds(table: SpeedTable, speeds: Floats) -> tuple[Matrix, Matrix]:
    """Stiffness and damping along x and y at these speeds, each (k, 2)."""
    own = [float(w) for w in table.speed]
    values = []
    for entries in (table.stiffness, table.damping):
        columns = np.array([two(entry) for entry in entries])
        values.append(np.column_stack([np.interp(speeds, own, columns[:, i]) for i in range(2)]))
    return values[0], values[1]


def add_support(support: Support, place: Rows, speeds: Floats, damping: Matrix, stiffness: Matrix) -> None:
    """Add a support at a place of the rotor to C and K, both (k, N, N)."""
    n = place.deflection.size
    count = speeds.size
    if support.table is not None:
        k, c = at_speeds(support.table, speeds)
    else:
        k = np.tile(two(support.stiffness if support.stiffness is not None else 0.0), (count, 1))
        c = np.tile(two(support.damping), (count, 1))
    across = np.outer(place.deflection, place.deflection)
    tilting = np.outer(place.slope, place.slope)
    for direction in range(2):
        block = slice(direction * n, (direction + 1) * n)
        stiffness[:, block, block] += k[:, direction, None, None] * across + float(support.tilt_stiffness) * tilting
        damping[:, block, block] += c[:, direction, None, None] * across + float(support.tilt_damping) * tilting
    if support.cross_stiffness is not None:
        stiffness[:, :n, n : 2 * n] += float(support.cross_stiffness[0]) * across
        stiffness[:, n : 2 * n, :n] += float(support.cross_stiffness[1]) * across
