"""Supports of a rotor as matrices."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from autobalancer.assembly.rotors.model import Floats, Matrix, Rows
from autobalancer.machine import Support


def table_speeds(tables: Iterable[Sequence[float]]) -> Floats:
    """The common speeds of all tables, each given by its own, as far as all of them reach; [0] if there is none.

    Below its first speed a table keeps its first value.
    """
    given = [[float(w) for w in speeds] for speeds in tables]
    end = min((speeds[-1] for speeds in given), default=0.0)
    return np.array(sorted({0.0, *(w for speeds in given for w in speeds if w <= end)}))


def add_support(support: Support, place: Rows, speeds: Floats, damping: Matrix, stiffness: Matrix) -> None:
    """Add a support at a place of the rotor to C and K, both (k, N, N)."""
    n = place.deflection.size
    values = [support.values(float(w)) for w in speeds]
    k, c = np.array(values).transpose(1, 0, 2)
    across = np.outer(place.deflection, place.deflection)
    tilting = np.outer(place.slope, place.slope)
    for direction in range(2):
        block = slice(direction * n, (direction + 1) * n)
        stiffness[:, block, block] += k[:, direction, None, None] * across + float(support.tilt_stiffness) * tilting
        damping[:, block, block] += c[:, direction, None, None] * across + float(support.tilt_damping) * tilting
    if support.cross_stiffness is not None:
        stiffness[:, :n, n : 2 * n] += float(support.cross_stiffness[0]) * across
        stiffness[:, n : 2 * n, :n] += float(support.cross_stiffness[1]) * across
