"""Balancing with influence coefficients: any number of planes, sensors and speeds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.measurement.balancing.answer import Balancing
from autobalancer.measurement.balancing.arrays import Angles, Complexes, Floats, Job, Phase, job_of
from autobalancer.measurement.balancing.correction import Goal, least_residual
from autobalancer.measurement.balancing.dataset import Found, dataset
from autobalancer.measurement.balancing.file import given_runs
from autobalancer.measurement.balancing.influence import Influence, influence, refuse_silent, refuse_undetermined
from autobalancer.measurement.balancing.runs import MASSES, BalanceRun, one_of
from autobalancer.measurement.balancing.uncertainty import mass_covariance
from autobalancer.units import optional_argument

OWNER = "balance"
INSEPARABLE = 1e6  # condition number beyond which nothing can be said


def balance(
    runs: Sequence[BalanceRun] | str | Path,
    *,
    phase: Phase | None = None,
    angles: Angles | None = None,
    deviation: float | str | None = None,
    planes: Sequence[str] | None = None,
    weights: Mapping[str, float] | None = None,
    goal: Goal = "mean",
    largest: float | str | Mapping[str, float | str] | None = None,
) -> Balancing:
    """Correction masses from runs without and with trial masses.

    Readings are taken as V = V0 + sum of a W over the planes, with complex masses W. All runs together give V0 and the
    influence coefficients a by least squares, so trial masses may be taken off again or left on, and there may be more runs than
    needed. Corrections are the W for which the weighted V0 + sum of a W is least; all trial masses are off then.

    Parameters
    ----------
    runs
        Runs, or a file of them, see :func:`~autobalancer.measure.load_balance_runs`. A run with ``trim`` is compared with what
        the others predict and then corrected further with their coefficients.
    phase
        ``"lead"`` of the vibration against the mark (the default) or ``"lag"``, as the instrument shows it.
    angles
        Of masses: ``"with rotation"`` (the default) or ``"against rotation"``.
    deviation
        Standard deviation of a reading as a share of its amplitude, where a reading has none: 0.02 or ``"2 %"``. Without any,
        runs beyond those needed give it; else no uncertainty is known.
    planes
        In which corrections are wanted; by default all that had trial masses.
    weights
        Of sensors, by name; by default 1, or one over the greatest reading where sensors have different units.
    goal
        What shall be least: ``"mean"`` square or ``"greatest"`` of what remains.
    largest
        Greatest correction mass, for all planes or by plane.

    Returns
    -------
    Balancing
        Over ``plane``: ``correction`` (kg or kg m) and ``correction_angle`` (rad, in the sense of ``angles``) with
        ``_deviation`` each, and ``change``, ``change_angle``, what to put on in addition to the masses of the last run. Over
        ``channel`` (a sensor at a speed) and ``plane``: ``influence``, ``influence_phase`` and ``influence_deviation``. Over
        ``channel``: ``original``, ``residual`` with their phases and ``residual_deviation``, the standard deviation of what
        will be found. Over ``run``: readings, masses, and ``misfit``, in deviations. One standard deviation each.

    Raises
    ------
    QuestionError
        If runs do not determine the coefficients, a trial mass changes nothing, or planes cannot be told apart; it names them.

    Source: Goodman (1964); Vaughan, Static and Dynamic Balancing, Brüel & Kjær.
    """
    listed, written = given_runs(runs)
    phase = phase or written.get("phase", "lead")
    angles = angles or written.get("angles", "with rotation")
    share = optional_argument("deviation", written.get("deviation") if deviation is None else deviation, "")
    if goal not in get_args(Goal):
        raise QuestionError(f"goal: given {goal!r}; must be {' or '.join(map(repr, get_args(Goal)))}")
    job = job_of(listed, phase, angles, share, phases=True, owner=OWNER)
    refuse_undetermined(job, OWNER)
    chosen = _chosen(job, planes)
    scales = _scales(job, weights)
    limits = _limits(job, chosen, largest)
    found = influence(job)
    job, estimated = _with_scatter(job, found)
    refuse_silent(job, found, OWNER)
    condition = _condition(scales[:, None] * found.coefficients[:, chosen], job, chosen)

    def corrections(readings: Complexes) -> Complexes:
        known = influence(job, readings)
        original, before = _start(job, known, readings)
        matrix = known.coefficients[:, chosen]
        return before[chosen] + least_residual(original, matrix, scales, goal, limits)

    masses = corrections(job.readings)
    covariance = mass_covariance(job, corrections)
    return dataset(
        Found(job, found, chosen, masses, covariance, scales, condition, goal, phase, angles, estimated, limits)
    )


def _start(job: Job, known: Influence, readings: Complexes) -> tuple[Complexes, Complexes]:
    """What is to be removed, and the masses with which it was read: of the last trim run, or without any masses."""
    trims = np.flatnonzero(job.trim)
    if not trims.size:
        return known.original, np.zeros(len(job.planes), complex)
    return readings[trims[-1]], job.masses[trims[-1]]


def _chosen(job: Job, planes: Sequence[str] | None) -> list[int]:
    if planes is None:
        return list(range(len(job.planes)))
    for plane in planes:
        if plane not in job.planes:
            raise QuestionError(
                f"planes: {plane!r} is missing: no run has a trial mass there; there are {', '.join(map(repr, job.planes))}"
            )
    return [job.planes.index(plane) for plane in planes]


def _scales(job: Job, weights: Mapping[str, float] | None) -> Floats:
    if weights is None:
        if len(set(job.units)) == 1:
            return np.ones(len(job.sensors))
        size = np.abs(job.readings).max(axis=0)
        return 1.0 / np.where(size > 0.0, size, 1.0)
    for name, value in weights.items():
        if name not in job.sensors:
            raise QuestionError(
                f"weights: no sensor {name!r}; there are {', '.join(map(repr, dict.fromkeys(job.sensors)))}"
            )
        if not value >= 0.0:
            raise QuestionError(f"weights: {name!r}: given {value!r}; must not be below zero")
    return np.array([float(weights.get(sensor, 1.0)) for sensor in job.sensors])


def _limits(job: Job, chosen: list[int], largest: float | str | Mapping[str, float | str] | None) -> Floats:
    names = [job.planes[p] for p in chosen]
    given = dict.fromkeys(names, largest) if not isinstance(largest, Mapping) else dict(largest)
    for name in given:
        if name not in names:
            raise QuestionError(f"largest: no plane {name!r} is corrected; there are {', '.join(map(repr, names))}")
    found = np.full(len(names), np.inf)
    for i, name in enumerate(names):
        value = given.get(name)
        if value is None:
            continue
        number, unit = one_of("largest", value, MASSES)
        if isinstance(value, str) and unit != job.mass_unit:
            raise QuestionError(
                f"largest: given {value!r}, but trial masses are in {job.mass_unit}; keep to one of both"
            )
        if not number > 0.0:
            raise QuestionError(f"largest: given {value!r}; must be above zero")
        found[i] = number
    return found


def _with_scatter(job: Job, found: Influence) -> tuple[Job, bool]:
    """Deviations from runs beyond those needed, where none are given."""
    spare = int(found.used.sum()) - 1 - len(job.planes)
    if spare < 1 or np.isfinite(job.along).all():
        return job, False
    design = np.column_stack([np.ones(len(job.runs)), job.masses])
    missed = (job.readings - design @ (found.rows @ job.readings))[found.used]
    scatter = np.sqrt(0.5 * (np.abs(missed) ** 2).sum(axis=0) / spare)  # of each of two directions
    along = np.where(np.isfinite(job.along), job.along, scatter)
    return replace(job, along=along, across=np.where(np.isfinite(job.across), job.across, scatter)), True


def _condition(matrix: Complexes, job: Job, chosen: list[int]) -> float:
    names = ", ".join(repr(job.planes[p]) for p in chosen)
    if matrix.shape[0] < matrix.shape[1]:
        raise QuestionError(
            f"{OWNER}: {matrix.shape[1]} planes ({names}) but {matrix.shape[0]} readings in a run; "
            "use more sensors or speeds, or fewer 'planes'"
        )
    sizes = np.linalg.norm(matrix, axis=0)
    condition = float(np.linalg.cond(matrix / np.where(sizes > 0.0, sizes, 1.0)))
    if not condition < INSEPARABLE:
        raise QuestionError(
            f"{OWNER}: planes {names} act alike on all sensors at all speeds and cannot be told apart; "
            "leave one out of 'planes', or add a sensor or a speed"
        )
    return condition
