"""What a balancing job says, as labeled arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.measurement.balancing.answer import Balancing
from autobalancer.measurement.balancing.arrays import Angles, Complexes, Floats, Job, Phase
from autobalancer.measurement.balancing.correction import Goal
from autobalancer.measurement.balancing.influence import Influence, row_deviation
from autobalancer.measurement.balancing.uncertainty import polar_deviations
from autobalancer.results.provenance import provenance

POOR = 20.0  # condition number from which on small errors become great
FAR = 3.0  # deviations from which on a run does not fit
RULE = 0.3  # share (and about the angle in rad / 2) by which a trial mass should change a reading


@dataclass(frozen=True)
class Found:
    """All of it; ``chosen`` are the planes that are corrected."""

    job: Job
    influence: Influence
    chosen: list[int]
    masses: Complexes
    covariance: Floats
    weights: Floats
    condition: float
    goal: Goal
    phase: Phase
    angles: Angles
    estimated: bool
    limits: Floats


def dataset(found: Found) -> Balancing:
    """The answer, with remarks on what to be careful about."""
    job, known = found.job, found.influence
    turn, count = (1.0 if found.phase == "lead" else -1.0), (1.0 if found.angles == "with rotation" else -1.0)
    unit = job.units[0] if len(set(job.units)) == 1 else ""
    mass = job.mass_unit.replace("*", " ")
    sizes, angles = polar_deviations(found.masses, found.covariance)
    sizes = np.where(sizes < 1e-6 * np.abs(found.masses), 0.0, sizes)  # at a limit
    whole = np.zeros(len(job.planes), complex)
    whole[found.chosen] = found.masses
    change = found.masses - job.masses[-1][found.chosen]
    residual, sure = _residual(found, whole)
    predicted = np.column_stack([np.ones(len(job.runs)), job.masses]) @ (known.rows @ job.readings)
    spread = np.sqrt(0.5 * (job.along**2 + job.across**2))
    with np.errstate(invalid="ignore", divide="ignore"):
        misfit = np.abs(job.readings - predicted) / np.where(spread > 0.0, spread, np.nan)
    each = {
        "correction": (("plane",), np.abs(found.masses), "correction mass", mass),
        "correction_deviation": (("plane",), sizes, "its standard deviation", mass),
        "correction_angle": (("plane",), count * np.angle(found.masses), "angle of the correction mass", "rad"),
        "correction_angle_deviation": (("plane",), angles, "its standard deviation", "rad"),
        "change": (("plane",), np.abs(change), "mass to put on beside those of the last run", mass),
        "change_angle": (("plane",), count * np.angle(change), "angle of this mass", "rad"),
        "influence": (("channel", "all_planes"), np.abs(known.coefficients), "influence coefficient", f"{unit}/({mass})"),
        "influence_phase": (("channel", "all_planes"), turn * np.angle(known.coefficients), "its phase", "rad"),
        "influence_deviation": (("channel", "all_planes"), row_deviation(job, known.rows)[1:].T, "its standard deviation",
                                f"{unit}/({mass})"),
        "original": (("channel",), np.abs(known.original), "vibration without masses", unit),
        "original_phase": (("channel",), turn * np.angle(known.original), "its phase", "rad"),
        "residual": (("channel",), np.abs(residual), "predicted vibration with the corrections", unit),
        "residual_phase": (("channel",), turn * np.angle(residual), "its phase", "rad"),
        "residual_deviation": (("channel",), sure, "its standard deviation", unit),
        "reading": (("run", "channel"), np.abs(job.readings), "amplitude read", unit),
        "reading_phase": (("run", "channel"), turn * np.angle(job.readings), "phase read", "rad"),
        "run_mass": (("run", "all_planes"), np.abs(job.masses), "mass on the rotor", mass),
        "run_mass_angle": (("run", "all_planes"), count * np.angle(job.masses), "its angle", "rad"),
        "misfit": (("run", "channel"), misfit, "reading less prediction, in standard deviations", "1"),
        "covariance": (("component", "other_component"), found.covariance,
                       "covariance of the corrections, real parts of all planes first", f"({mass})^2"),
    }  # fmt: skip
    answer = xr.Dataset(
        {
            name: (dims, values, {"long_name": text, "units": units})
            for name, (dims, values, text, units) in each.items()
        },
        _coordinates(found),
    )
    answer.attrs = {
        "title": "Balancing with influence coefficients", **provenance(), "goal": found.goal, "phase": found.phase,
        "angles": found.angles, "condition": found.condition, "deviations_from": _deviations_from(found),
        "left_on": int(job.trim[-1] or bool(np.any((job.masses[-1] == job.masses[-2]) & (job.masses[-1] != 0.0)))),
        "warnings": "\n".join(_remarks(found, misfit, residual, sure)),
    }  # fmt: skip
    return Balancing.of(answer)


def _coordinates(found: Found) -> dict[str, Any]:
    job = found.job
    planes = np.array(job.planes, dtype=object)
    return {
        "plane": planes[found.chosen],
        "all_planes": planes,
        "run": np.array(job.runs, dtype=object),
        "sensor": ("channel", np.array(job.sensors, dtype=object), {"long_name": "sensor"}),
        "speed": ("channel", job.speeds, {"long_name": "rotor speed", "units": "rad/s"}),
    }


def _residual(found: Found, whole: Complexes) -> tuple[Complexes, Floats]:
    """What should be left, and its deviation for these masses; after a trim run counted from that run."""
    job, known = found.job, found.influence
    trims = np.flatnonzero(job.trim)
    rows = np.r_[1.0, whole] @ known.rows
    if trims.size:
        last = int(trims[-1])
        rows = np.r_[0.0, whole - job.masses[last]] @ known.rows
        rows[last] += 1.0
    return rows @ job.readings, row_deviation(job, rows[None])[0]


def _deviations_from(found: Found) -> str:
    if found.estimated:
        return "scatter of the runs"
    return "readings" if np.isfinite(found.job.along).all() else ""


def _remarks(found: Found, misfit: Floats, residual: Complexes, sure: Floats) -> list[str]:
    job, known, told = found.job, found.influence, []
    if not np.isfinite(sure).all():
        told.append("uncertainty is not known: give the readings deviations, or make one run more than needed")
    for p, plane in enumerate(job.planes):
        change = np.abs(known.coefficients[:, p]) * np.abs(job.masses[:, p]).max()
        size = np.abs(known.original)
        share = float((change / np.where(size > 0.0, size, np.inf)).max())
        if 0.0 < share < RULE:
            told.append(
                f"the trial mass in plane {plane!r} changes the readings by {100.0 * share:.2g} % at most; "
                "a larger one, for 30 % or more, makes the correction surer"
            )
    if found.condition > POOR:
        weak = _weakest(found)
        told.append(
            f"the planes act much alike (condition number {found.condition:.3g}): {weak} is known poorly; "
            "more speeds or sensors help"
        )
    for r in np.flatnonzero(np.nanmax(np.nan_to_num(misfit), axis=1, initial=0.0) > FAR):
        c = int(np.nanargmax(misfit[r]))
        kind = "trim run" if job.trim[r] else "run"
        told.append(
            f"{kind} {job.runs[r]!r} does not follow from the others: {job.channel(c)} is {misfit[r, c]:.3g} standard "
            "deviations off; check its masses and its speed, and whether balls in a race have moved"
        )
    at_limit = [
        job.planes[p]
        for p, m, most in zip(found.chosen, found.masses, found.limits, strict=True)
        if abs(m) > 0.999 * most
    ]
    if at_limit:
        told.append(f"the greatest mass is reached in plane {', '.join(map(repr, at_limit))}")
    return told


def _weakest(found: Found) -> str:
    """The combination of masses that is seen least: ``1 of 'left' against 0.9 of 'right'``."""
    matrix = found.weights[:, None] * found.influence.coefficients[:, found.chosen]
    sizes = np.linalg.norm(matrix, axis=0)
    vector = np.linalg.svd(matrix / sizes)[2][-1].conj() / sizes
    vector = vector / vector[int(np.argmax(np.abs(vector)))]
    parts = [
        f"{abs(v):.2g} in {found.job.planes[p]!r} at {np.degrees(np.angle(v)):.0f} deg"
        for p, v in zip(found.chosen, vector, strict=True)
        if abs(v) > 0.05
    ]
    return f"the combination {', '.join(parts)}"
