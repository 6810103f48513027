"""Modes followed over the speed by the likeness of their shapes, so that branches may cross."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from autobalancer.assembly.rotors.model import Complexes, Floats
from autobalancer.rotordynamics.eigenproblem import FreeMotions, correlation

ALIKE, ANY_LIKENESS = 0.9, 0.05
DEEPEST = 6  # halvings of a step in which shapes change fast


@dataclass(frozen=True)
class Branches:
    """Eigenvalues (branches, S) and vectors (branches, S, N); nan where a branch has no oscillating motion."""

    eigenvalue: Complexes
    vector: Complexes


@dataclass(frozen=True)
class _Front:
    """Where the branches are: speed, eigenvalues and vectors, the last known ones where a branch has ended."""

    speed: float
    value: Complexes
    vector: Complexes


def tracked(motions: Callable[[float], FreeMotions], speeds: Floats, mass: Floats, count: int) -> Branches:
    """Follow the ``count`` lowest modes of the first speed.

    Parameters
    ----------
    motions
        Free motions at a speed, rad/s.
    speeds
        Ascending, rad/s.
    mass
        M, the weight of the likeness.
    count
        Branches at most.
    """
    first = motions(float(speeds[0])).lowest(count)
    front = _Front(float(speeds[0]), first.eigenvalue, first.vector)
    values, vectors = [front.value], [front.vector]
    for speed in speeds[1:]:
        front = _advanced(motions, front, float(speed), mass, DEEPEST)
        values.append(front.value)
        vectors.append(np.where(np.isnan(front.value)[:, None], np.nan, front.vector))
    return Branches(np.array(values).T, np.array(vectors).swapaxes(0, 1))


def _advanced(
    motions: Callable[[float], FreeMotions], front: _Front, speed: float, mass: Floats, halvings: int
) -> _Front:
    found = motions(speed)
    likeness = correlation(front.vector, found.vector, mass)
    rows, columns = linear_sum_assignment(-likeness)
    lost = likeness[rows, columns] < ANY_LIKENESS
    clear = likeness[rows, columns][~np.isnan(front.value[rows])].min(initial=1.0) >= ALIKE
    if not clear and halvings:
        middle = _advanced(motions, front, 0.5 * (front.speed + speed), mass, halvings - 1)
        return _advanced(motions, middle, speed, mass, halvings - 1)
    rows, columns = rows[~lost], columns[~lost]
    value, vector = np.full(front.value.size, np.nan + 0j), front.vector.copy()
    value[rows], vector[rows] = found.eigenvalue[columns], found.vector[columns]
    return _Front(speed, value, vector)
