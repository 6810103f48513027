"""Slipstream: a ball behind another one feels less drag (Spannan 2021, section 5.2.4).

The polynomial is a fit to free spheres in line, for Re from 0 to 300 and center distances from 1 to 20 diameters. It runs
away outside: at 25 diameters it is 1.32, at 30 it is 3.3. So arguments are clamped to the range, the factor is 1 beyond
20 diameters and never above 1. Walls and the curvature of a race are not in it, and no machine uses it by itself.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from autobalancer.errors import QuestionError

Floats = NDArray[np.float64]
REYNOLDS = (0.0, 300.0)
DISTANCE = (1.0, 20.0)

# rows powers of Re, columns powers of l/d
_FIT = 1e-6 * np.array(
    [
        [452100.0, 164000.0, -29690.0, 2731.0, -116.9, 1.876],
        [-2937.0, 321.9, -55.15, 4.918, -0.1302, 0.0],
        [4.95, 0.8646, -0.1306, 0.003754, 0.0, 0.0],
    ]
)


def slipstream_factor(reynolds: ArrayLike, distance: ArrayLike) -> Floats:
    """Drag of the ball behind over that of a single ball.

    Parameters
    ----------
    reynolds
        Reynolds number of the ball; clamped to 0 ... 300.
    distance
        Between the centers, in diameters: 1 is contact; below it counts as 1, beyond 20 the factor is 1.
        The source leaves open whether it means centers or gaps; its fit begins at 1, so centers.

    Returns
    -------
    ndarray
        Between 0.27 and 1, of the common shape of both.
    """
    re = np.clip(np.abs(np.asarray(reynolds, dtype=float)), *REYNOLDS)
    apart = np.asarray(distance, dtype=float)
    powers = np.stack([np.ones_like(re), re, re**2], axis=-1) @ _FIT
    ratio = np.clip(apart, *DISTANCE)[..., None] ** np.arange(_FIT.shape[1])
    return np.where(apart >= DISTANCE[1], 1.0, np.minimum((powers * ratio).sum(axis=-1), 1.0))


def race_factors(
    angles: ArrayLike, velocities: ArrayLike, orbit_radius: float, diameter: float, viscosity: float
) -> Floats:
    """Slipstream factor of every ball of a race: the next ball ahead shields it, in the direction in which it moves.

    Parameters
    ----------
    angles, velocities
        Ball angles (rad) and velocities relative to the fluid (m/s, positive towards greater angles), shape (n,).
    orbit_radius, diameter, viscosity
        m, m, m^2/s; the distance is that of the centers, straight.

    Raises
    ------
    QuestionError
        If there are not as many velocities as angles.
    """
    phi, u = np.asarray(angles, dtype=float), np.asarray(velocities, dtype=float)
    if phi.shape != u.shape or phi.ndim != 1:
        raise QuestionError(
            f"slipstream: given {phi.size} angles and {u.size} velocities; give one of each for each ball"
        )
    if phi.size < 2:
        return np.ones_like(phi)
    ahead = np.sign(u)[:, None] * (phi[None, :] - phi[:, None]) % (2.0 * math.pi)
    np.fill_diagonal(ahead, 2.0 * math.pi)
    nearest = ahead.min(axis=1)
    chord = 2.0 * orbit_radius * np.sin(np.minimum(0.5 * nearest, 0.5 * math.pi))
    factor = slipstream_factor(u * diameter / viscosity, chord / diameter)
    return np.where(u == 0.0, 1.0, factor)
