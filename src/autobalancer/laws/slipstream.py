"""Slipstream: a ball behind another one feels less drag (Spannan 2021, section 5.2.4).

The polynomial is a fit to free spheres in line, for Re from 0 to 300 and center distances from 1 to 20 diameters. It runs
away outside: at 25 diameters it is 1.32, at 30 it is 3.3. So arguments are clamped to the range and the factor is never above
1; over the last diameter what is left of the shielding, 0.8 % at most, fades, so that the factor is 1 from 20 diameters on
without a jump. The walls of a race are not in it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from autobalancer.errors import QuestionError, RangeWarning, warn
from autobalancer.units import argument, texts_argument

Floats = NDArray[np.float64]
REYNOLDS = (0.0, 300.0)
DISTANCE = (1.0, 20.0)

# rows powers of Re, columns powers of l/d
FIT = 1e-6 * np.array(
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
        Between the centers, in diameters: 1 is contact; smaller values are read as 1, beyond 20 the factor is 1.
        The source does not say whether it means centers or gaps; its fit begins at 1, so centers are assumed.

    Returns
    -------
    ndarray
        Between 0.27 and 1, of the common shape of both.
    """
    re = np.clip(np.abs(np.asarray(reynolds, dtype=float)), *REYNOLDS)
    apart = np.asarray(distance, dtype=float)
    powers = np.stack([np.ones_like(re), re, re**2], axis=-1) @ FIT
    ratio = np.clip(apart, *DISTANCE)[..., None] ** np.arange(FIT.shape[1])
    fade = np.clip(DISTANCE[1] - apart, 0.0, 1.0)
    return np.asarray(1.0 - fade * np.maximum(1.0 - (powers * ratio).sum(axis=-1), 0.0))


def slipstream_factors(
    angles: ArrayLike,
    velocities: ArrayLike,
    orbit_radius: float | str,
    diameter: float | str,
    viscosity: float | str,
) -> Floats:
    """Slipstream factor of every ball of a race: the next ball ahead shields it, in the direction in which it moves.

    The distance is that of the centers along the orbit, as the fluid goes round with the race. Balls that pass through each
    other hand over what they do to each other within half a diameter, so that the factor is continuous in the angles. It jumps
    where a velocity changes its sign, but there is no drag then.

    Parameters
    ----------
    angles, velocities
        Ball angles (rad) and velocities relative to the fluid (m/s, positive towards greater angles), shape (n,).
    orbit_radius, diameter, viscosity
        m, m, m^2/s.

    Raises
    ------
    QuestionError
        If there are not as many velocities as angles.
    """
    angles = texts_argument("angles", angles, "rad")
    velocities = texts_argument("velocities", velocities, "m/s")
    orbit_radius = argument("orbit_radius", orbit_radius, "m")
    diameter = argument("diameter", diameter, "m")
    viscosity = argument("viscosity", viscosity, "m^2/s")
    phi, u = np.asarray(angles, dtype=float), np.asarray(velocities, dtype=float)
    if phi.shape != u.shape or phi.ndim != 1:
        raise QuestionError(
            f"slipstream: given {phi.size} angles and {u.size} velocities; give one of each for each ball"
        )
    if phi.size < 2:
        return np.ones_like(phi)
    ahead = np.sign(u)[:, None] * (phi[None, :] - phi[:, None]) % (2.0 * math.pi) * orbit_radius / diameter
    around = 2.0 * math.pi * orbit_radius / diameter
    np.fill_diagonal(ahead, around)
    reynolds = u * diameter / viscosity
    passing = 2.0 * np.where(ahead < 0.5, ahead, 0.0).max(axis=1)
    share = passing**2 * (3.0 - 2.0 * passing)
    factor = slipstream_factor(reynolds, np.where(ahead < 0.5, around, ahead).min(axis=1))
    factor += share * (slipstream_factor(reynolds, 1.0) - factor)
    return np.where(u == 0.0, 1.0, factor)


def range_record(reynolds: float) -> dict[str, Any]:
    """What to keep with a result in which the greatest Reynolds number of a ball was ``reynolds``.

    That number, the last of the fit, and a sentence in ``slipstream_warning`` if it was exceeded, which is then also given as a
    ``RangeWarning``.
    """
    text = ""
    if reynolds > REYNOLDS[1]:
        text = (
            f"slipstream: the Reynolds number reached {reynolds:.3g}; the factor is a fit up to {REYNOLDS[1]:g} "
            "(Spannan 2021, section 5.2.4), beyond this range its value at the limit is used"
        )
        warn(text, RangeWarning)
    return {"slipstream_reynolds": reynolds, "slipstream_reynolds_limit": REYNOLDS[1], "slipstream_warning": text}
