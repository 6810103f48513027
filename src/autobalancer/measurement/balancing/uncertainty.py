"""How sure corrections are: the deviations of all readings carried through to the masses, linearly."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from autobalancer.measurement.balancing.arrays import Complexes, Floats, Job

STEP = 1e-3  # of a reading's deviation, by which it is changed


def mass_covariance(job: Job, corrections: Callable[[Complexes], Complexes]) -> Floats:
    """Covariance of the masses, real parts first, (2 P, 2 P); nan where a deviation is not known.

    ``corrections`` makes masses of readings of the shape of the job.
    """
    count = corrections(job.readings).size
    if not (np.isfinite(job.along).all() and np.isfinite(job.across).all()):
        return np.full((2 * count, 2 * count), np.nan)
    found = np.zeros((2 * count, 2 * count))
    size = np.abs(job.readings)
    way = np.where(size > 0.0, job.readings / np.where(size > 0.0, size, 1.0), 1.0)
    for index in np.ndindex(job.readings.shape):
        for turned, sure in ((1.0, job.along[index]), (1j, job.across[index])):
            moved = []
            for sign in (1.0, -1.0):
                readings = job.readings.copy()
                readings[index] += sign * STEP * sure * turned * way[index]
                masses = corrections(readings)
                moved.append(np.concatenate([masses.real, masses.imag]))
            change = (moved[0] - moved[1]) / (2.0 * STEP)
            found += np.outer(change, change)
    return found


def polar_deviations(masses: Complexes, covariance: Floats) -> tuple[Floats, Floats]:
    """Standard deviations of size (as the masses) and angle (rad) of each, (P,)."""
    count = masses.size
    sizes, angles = np.empty(count), np.empty(count)
    for p, mass in enumerate(masses):
        block = covariance[np.ix_([p, count + p], [p, count + p])]
        way = mass / abs(mass) if mass else 1.0 + 0j
        along, across = np.array([way.real, way.imag]), np.array([-way.imag, way.real])
        sizes[p] = np.sqrt(np.maximum(along @ block @ along, 0.0))
        spread = np.sqrt(np.maximum(across @ block @ across, 0.0))
        angles[p] = spread / abs(mass) if mass else np.nan
    return sizes, angles
