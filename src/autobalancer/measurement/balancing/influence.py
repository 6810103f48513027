"""Influence coefficients: what a mass in each plane does at each sensor and speed, by least squares over all runs.

A reading is V = V0 + sum over planes of a W with complex masses W, whether trial masses were taken off again or left on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.measurement.balancing.arrays import Complexes, Floats, Job

SURE = 3.0  # standard deviations by which a trial mass must change a reading
LEAST = 0.01  # share of the readings, where no deviations are known


@dataclass(frozen=True)
class Influence:
    """``original`` (C,), ``coefficients`` (C, P) and the rows that make both of the readings, (1 + P, R)."""

    original: Complexes
    coefficients: Complexes
    rows: Complexes
    used: np.ndarray  # (R,), runs from which they come


def influence(job: Job, readings: Complexes | None = None) -> Influence:
    """From the readings of the job, or others of the same shape; runs that only trim are left out."""
    readings = job.readings if readings is None else readings
    used = ~np.array(job.trim)
    rows = np.zeros((1 + len(job.planes), len(job.runs)), complex)
    rows[:, used] = np.linalg.pinv(_design(job)[used])
    found = rows @ readings
    return Influence(found[0], found[1:].T, rows, used)


def _design(job: Job) -> Complexes:
    return np.column_stack([np.ones(len(job.runs)), job.masses])


def refuse_undetermined(job: Job, owner: str) -> None:
    """Refuse trial masses from which no coefficients follow.

    Raises
    ------
    QuestionError
        It names planes and runs.
    """
    used = np.flatnonzero(~np.array(job.trim))
    if not job.planes:
        raise QuestionError(f"{owner}: no run has a trial mass; put one on in each plane, in a run of its own")
    masses = job.masses[used]
    for p, plane in enumerate(job.planes):
        if np.ptp(masses[:, p].real) == 0.0 and np.ptp(masses[:, p].imag) == 0.0:
            raise QuestionError(
                f"{owner}: plane {plane!r} carries the same masses in all runs; make a run with another mass there"
            )
    design = _design(job)[used] / np.r_[1.0, np.abs(masses).max(axis=0)]
    if np.linalg.matrix_rank(design, tol=1e-6 * np.abs(design).max()) > len(job.planes):
        return
    for i, r in enumerate(used):
        for s in used[:i]:
            if np.allclose(job.masses[r], job.masses[s], rtol=1e-6, atol=0.0):
                raise QuestionError(
                    f"{owner}: runs {job.runs[s]!r} and {job.runs[r]!r} carry the same masses at the same places, so that "
                    f"{len(job.planes)} planes cannot be told apart; move one of them to another plane"
                )
    planes = ", ".join(map(repr, job.planes))
    raise QuestionError(
        f"{owner}: the masses of planes {planes} always change together; put on one trial mass at a time"
    )


def refuse_silent(job: Job, found: Influence, owner: str) -> None:
    """Refuse a trial mass that changes no reading.

    Raises
    ------
    QuestionError
        It names the run.
    """
    sure = row_deviation(job, found.rows)
    for p, plane in enumerate(job.planes):
        moved = np.abs(job.masses[found.used, p] - job.masses[found.used, p][0])
        run = job.runs[int(np.flatnonzero(found.used)[int(np.argmax(moved))])]
        change = np.abs(found.coefficients[:, p]) * np.abs(job.masses[found.used, p]).max()
        size = np.abs(job.readings[found.used]).max(axis=0)
        known = np.isfinite(sure[1 + p])
        clear = np.where(
            known, np.abs(found.coefficients[:, p]) > SURE * np.nan_to_num(sure[1 + p]), change > LEAST * size
        )
        if not clear.any():
            share = float((change / np.where(size > 0.0, size, 1.0)).max())
            raise QuestionError(
                f"{owner}: run {run!r}: the trial mass in plane {plane!r} changes the readings by {100.0 * share:.2g} % at most, "
                "which is no more than their uncertainty; take a larger one, or check that it was on the rotor"
            )


def row_deviation(job: Job, rows: Complexes) -> Floats:
    """Standard deviation (along any direction, root mean square of both) of ``rows @ readings``, (rows, C)."""
    square = np.nan_to_num(0.5 * (job.along**2 + job.across**2), nan=np.inf)
    with np.errstate(invalid="ignore"):
        weighted = np.where(np.abs(rows)[:, :, None] > 0.0, np.abs(rows)[:, :, None] ** 2 * square[None], 0.0)
    found = np.sqrt(weighted.sum(axis=1))
    return np.where(np.isinf(found), np.nan, found)
