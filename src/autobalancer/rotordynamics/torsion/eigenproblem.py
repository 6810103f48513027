"""Free torsional motions of a drive train."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import eig, eigh
from scipy.optimize import linear_sum_assignment

from autobalancer.assembly.torsion.model import Complexes, Floats, Torsion

OSCILLATES = 0.995  # damping ratio above which nothing swings
STILL = 1e-6  # of the highest frequency; below it the train turns as a whole
SHARED = 0.05  # least share of the greatest angle for which a part is named


class FreeTorsion(NamedTuple):
    """Modes by ascending frequency: eigenvalues, undamped frequencies of the most alike shapes, shapes (modes, parts)."""

    eigenvalue: Complexes
    undamped: Floats
    shape: Complexes  # the greatest angle is 1


def free_torsion(model: Torsion, damping: Floats) -> FreeTorsion:
    """All motions that oscillate; turning as a whole is none."""
    n, j = model.inertia.size, model.inertia[:, None]
    block = np.zeros((2 * n, 2 * n))
    block[:n, n:] = np.eye(n)
    block[n:] = np.hstack([-model.stiffness / j, -damping / j])
    values, vectors = eig(block)
    squares, plain = eigh(model.stiffness, np.diag(model.inertia))
    undamped = np.sqrt(np.maximum(squares, 0.0))
    rate = np.abs(values)
    keep = (values.imag > STILL * undamped[-1]) & (-values.real < OSCILLATES * rate)
    values, shapes = values[keep], vectors[:n, keep].T
    order = np.argsort(values.imag)
    values, shapes = values[order], shapes[order]
    likeness = np.abs((shapes.conj() * model.inertia) @ plain)
    likeness /= np.sqrt(np.sum(np.abs(shapes) ** 2 * model.inertia, axis=1))[:, None]
    rows, columns = linear_sum_assignment(-likeness)
    matched = np.full(values.size, np.nan)
    matched[rows] = undamped[columns]
    greatest = np.argmax(np.abs(shapes), axis=1)
    shapes = shapes / shapes[np.arange(values.size), greatest][:, None]
    return FreeTorsion(values, matched, shapes)


def undamped_torsion(model: Torsion) -> tuple[Floats, Floats]:
    """Frequencies without damping, rad/s ascending, and shapes (modes, parts); turning as a whole is left out."""
    squares, shapes = eigh(model.stiffness, np.diag(model.inertia))
    rate = np.sqrt(np.maximum(squares, 0.0))
    keep = rate > STILL * rate[-1]
    return rate[keep], shapes.T[keep]


def shape_name(names: tuple[str, ...], shape: Complexes | Floats) -> str:
    """The part that turns most, and against which other one."""
    most = int(np.argmax(np.abs(shape)))
    angles = (shape / shape[most]).real
    other = int(np.argmin(angles))
    return f"{names[most]} against {names[other]}" if angles[other] < -SHARED else names[most]
