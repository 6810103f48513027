"""Natural frequencies and synchronous critical speeds of matrices, undamped."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import brentq

from autobalancer.assembly.rotors.model import Floats, LateralModel

NOT_A_SPEED = 1e-9  # share of the greatest 1/w^2 below which it counts as zero
INTERVALS = 64  # of the reach of a table, in which critical speeds are sought


def critical_speeds(model: LateralModel) -> tuple[float, ...]:
    """Speeds at which an undamped whirl has the rotor speed, rad/s, ascending; within the range of the tables.

    Tables are taken at the frequency of the whirl, which is the speed itself. On isotropic supports forward whirl only, since
    unbalance excites no other. A tilt whose polar inertia is greater than its transverse one has none, so that there may be
    fewer than pairs of coordinates.
    """
    if model.speeds.size == 1:
        return tuple(undamped_critical_speeds(model).tolist())
    last = float(model.speeds[-1])
    grid = np.union1d(np.linspace(0.0, last, INTERVALS + 1), model.speeds)
    levels = [undamped_critical_speeds(model, float(speed)) for speed in grid]
    found = []
    for index in range(min(level.size for level in levels)):

        def miss(speed: float, index: int = index) -> float:
            return speed - float(undamped_critical_speeds(model, speed)[index])

        for low, high in pairwise(range(grid.size)):
            ends = grid[low] - levels[low][index], grid[high] - levels[high][index]
            if ends[0] < 0.0 <= ends[1] or ends[1] < 0.0 <= ends[0]:
                found.append(float(brentq(miss, grid[low], grid[high], xtol=1e-12 * last)))
    return tuple(sorted(found))


def undamped_critical_speeds(model: LateralModel, speed: float = 0.0) -> Floats:
    """Speeds at which an undamped whirl has the speed of the rotor, rad/s, ascending; K taken at ``speed``.

    On isotropic supports forward whirl only, since unbalance excites no other; else all synchronous vibrations.
    K x = w^2 (M - i G) x is a Hermitian problem, whatever the sign of M - i G: where the polar inertia outweighs the
    transverse one, a critical speed is missing.
    """
    stiffness = model.stiffness_at(speed)
    stiffness = 0.5 * (stiffness + stiffness.T)
    n = model.pairs
    if model.isotropic:
        m, _, _ = model.complex_matrices(speed)
        # G over x and y is [[0, g], [-g, 0]], and a forward whirl has z' = i w z: g acts against M
        mass = m.real - model.gyroscopic[:n, n : 2 * n]
        held = stiffness[:n, :n]
    else:
        mass, held = model.mass - 1j * model.gyroscopic, stiffness
    if np.linalg.eigvalsh(held)[0] <= 1e-12 * np.abs(held).max():
        held = held + 1e-12 * np.abs(held).max() * np.eye(held.shape[0])
    inverse = eigh(mass, held, eigvals_only=True)
    return np.sort(1.0 / np.sqrt(inverse[inverse > NOT_A_SPEED * np.abs(inverse).max()]))
