"""Directions of vectors of given lengths that add up to a given sum."""

from __future__ import annotations

import cmath
import math

import numpy as np

from autobalancer.stability.host.planar import Floats


def directions(lengths: Floats, target: complex) -> Floats | None:
    """Angles (rad) with sum lengths e^(i angle) = target; none if there are no such.

    The vectors and the target are the sides of a polygon. Cut where half of its perimeter is passed: the sides before,
    the one that passes it, and those after form a triangle, which exists if no side is longer than all others together.
    The other solutions of two vectors are the mirror image in the target; for more vectors there is a continuum.
    """
    sides = np.append(lengths, abs(target))
    half = 0.5 * float(sides.sum())
    if lengths.size == 0 or sides.max() > half * (1.0 + 1e-12):
        return None
    cut = min(int(np.searchsorted(np.cumsum(sides), half, side="right")), lengths.size)
    a, b, c = float(sides[:cut].sum()), float(sides[cut]), float(sides[cut + 1 :].sum())
    full = np.empty(sides.size)  # a along 0, then b, then c back to the start
    first, second = _triangle(a, b, c)
    full[:cut], full[cut], full[cut + 1 :] = 0.0, first, second
    return np.asarray(full[:-1] - full[-1] + math.pi + cmath.phase(target))


def _triangle(a: float, b: float, c: float) -> tuple[float, float]:
    """Directions of the second and third side when the first points along zero and the third leads back."""
    if a == 0.0 or b == 0.0:
        return 0.0, math.pi
    cosine = (a * a + b * b - c * c) / (2.0 * a * b)
    turn = math.pi - math.acos(min(max(cosine, -1.0), 1.0))
    return turn, cmath.phase(-a - b * cmath.exp(1j * turn))
