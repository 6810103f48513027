"""Balancing with influence coefficients: any number of planes, sensors and speeds."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import xarray as xr

from autobalancer.arrays import Complexes, Floats
from autobalancer.errors import QuestionError, one_of
from autobalancer.measurement.balancing.runs import (
    MASSES,
    Angles,
    BalanceRun,
    Job,
    Phase,
    Reading,
    balance_runs,
    job_of,
    joined,
    quantity_of_units,
    split_mass,
)
from autobalancer.results.answers.answer import Answer, provenance
from autobalancer.results.store import load_run
from autobalancer.units import optional_argument

# Correction masses for which the vibration that remains is least: in the mean square, or the greatest one.


Goal = Literal["mean", "greatest"]
Holes = int | Sequence[float | str] | Mapping[str, Any] | None  # none for masses at any place
Stock = Sequence[float | str] | None
TIGHT = 1e-13  # tolerance of the search


def least_residual(
    original: Complexes, coefficients: Complexes, weights: Floats, goal: Goal, limits: Floats
) -> Complexes:
    """Masses (P,) for which weighted ``original + coefficients @ masses`` is least, each at most its limit (inf for none).

    Both problems are convex, so what is found is the least of all.

    Source: Goodman (1964) for the least squares; Foiles, Allaire and Gunter (2000) for the least greatest residual.
    """
    a, b = weights[:, None] * coefficients, weights * original
    plain = np.asarray(-np.linalg.lstsq(a, b, rcond=None)[0], np.complex128)
    if goal == "mean" and (np.abs(plain) <= limits).all():
        return plain
    if goal == "greatest" and b.size <= plain.size and (np.abs(plain) <= limits).all():
        return plain  # nothing remains
    return _searched(a, b, plain, goal, limits)


def _searched(a: Complexes, b: Complexes, plain: Complexes, goal: Goal, limits: Floats) -> Complexes:
    from scipy.optimize import minimize

    count = plain.size
    size = np.where(np.abs(plain) > 0.0, np.abs(plain), 1.0)
    # masses over those without limits, residuals over the greatest: all numbers near one
    rows = a * size
    scale = float(np.abs(b).max()) or 1.0
    rows, rest = rows / scale, b / scale
    start = plain * np.minimum(1.0, limits / np.maximum(np.abs(plain), 1e-300)) / size
    bound = np.flatnonzero(np.isfinite(limits))

    def masses(v: Floats) -> Complexes:
        return np.asarray(v[:count] + 1j * v[count : 2 * count])

    def residual(v: Floats) -> Complexes:
        return np.asarray(rest + rows @ masses(v))

    def gradient(weighted: Complexes) -> Floats:
        """Of the half square of each residual, weighted, (..., 2 P)."""
        return np.concatenate([weighted.real, weighted.imag], axis=-1)

    held = {
        "type": "ineq",
        "fun": lambda v: (limits[bound] / size[bound]) ** 2 - np.abs(masses(v)[bound]) ** 2,
        "jac": lambda v: _limit_rows(masses(v), bound, v.size),
    }
    v = np.concatenate([start.real, start.imag])
    if goal == "mean":
        result = minimize(
            lambda v: 0.5 * float((np.abs(residual(v)) ** 2).sum()), v, method="SLSQP", constraints=[held],
            jac=lambda v: gradient(rows.conj().T @ residual(v)), options={"ftol": TIGHT, "maxiter": 500},
        )  # fmt: skip
    else:
        # the greatest residual is an unknown of its own, below which all others stay
        top = float(np.abs(residual(v)).max())
        below = {
            "type": "ineq",
            "fun": lambda v: v[-1] ** 2 - np.abs(residual(v)) ** 2,
            "jac": lambda v: np.column_stack(
                [-2.0 * gradient(rows.conj() * residual(v)[:, None]), np.full(rest.size, 2.0 * v[-1])]
            ),
        }
        result = minimize(
            lambda v: v[-1], np.append(v, top), method="SLSQP", constraints=[below, held],
            jac=lambda v: np.eye(v.size)[-1], options={"ftol": TIGHT, "maxiter": 500},
        )  # fmt: skip
    if not result.success and result.status not in (8, 9):
        raise QuestionError(f"balance: no correction was found: {result.message}")
    return masses(result.x) * size


def _limit_rows(masses: Complexes, bound: np.ndarray, size: int) -> Floats:
    rows = np.zeros((bound.size, size))
    for i, p in enumerate(bound):
        rows[i, p], rows[i, masses.size + p] = -2.0 * masses[p].real, -2.0 * masses[p].imag
    return rows


# Influence coefficients: what a mass in each plane does at each sensor and speed, by least squares over all runs.
#
# A reading is V = V0 + sum over planes of a W with complex masses W, whether trial masses were taken off again or
# left on.


SURE = 3.0  # standard deviations by which a trial mass must change a reading
LEAST = 0.01  # share of the readings, where no deviations are known


@dataclass(frozen=True)
class Influence:
    """``original`` (C,), ``coefficients`` (C, P) and the rows that make both of the readings, (1 + P, R).

    ``others`` (B - 1, R) make the other vectors that readings contain: the run-out, and the vibration before earlier jobs.
    """

    original: Complexes
    coefficients: Complexes
    rows: Complexes
    others: Complexes
    used: np.ndarray  # (R,), runs from which they come

    def missing(self, job: Job) -> Complexes:
        """The rows (R, R) that make of the readings what each has beyond the fit."""
        solution = np.concatenate([self.rows[:1], self.others, self.rows[1:]])
        return np.asarray(np.eye(self.used.size) - _design(job) @ solution)


def influence_of(job: Job) -> Influence:
    """From the readings of the job; runs that only trim are left out."""
    used = ~np.array(job.trim)
    design, count = _design(job), job.states.shape[1]
    rows = np.zeros(design.shape[::-1], complex)
    rows[:, used] = np.linalg.pinv(design[used])
    others, rows = rows[1:count], np.concatenate([rows[:1], rows[count:]])
    influence = rows @ job.readings
    return Influence(influence[0], influence[1:].T, rows, others, used)


def _design(job: Job) -> Complexes:
    return np.column_stack([job.states, job.masses])


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
    design = _design(job)[used] / np.r_[np.ones(job.states.shape[1]), np.abs(masses).max(axis=0)]
    if np.linalg.matrix_rank(design, tol=1e-6 * np.abs(design).max()) == design.shape[1]:
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


def refuse_silent(job: Job, influence: Influence, owner: str) -> None:
    """Refuse a trial mass that changes no reading.

    Raises
    ------
    QuestionError
        It names the run.
    """
    sure = row_deviation(job, influence.rows)
    for p, plane in enumerate(job.planes):
        moved = np.abs(job.masses[influence.used, p] - job.masses[influence.used, p][0])
        run = job.runs[int(np.flatnonzero(influence.used)[int(np.argmax(moved))])]
        change = np.abs(influence.coefficients[:, p]) * np.abs(job.masses[influence.used, p]).max()
        size = np.abs(job.readings[influence.used]).max(axis=0)
        known = np.isfinite(sure[1 + p])
        clear = np.where(
            known, np.abs(influence.coefficients[:, p]) > SURE * np.nan_to_num(sure[1 + p]), change > LEAST * size
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
    deviation = np.sqrt(weighted.sum(axis=1))
    return np.where(np.isinf(deviation), np.nan, deviation)


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
    influence: Answer | xr.Dataset | str | Path | None = None,
    runout: Sequence[Reading] | None = None,
    holes: Holes = None,
    stock: Stock = None,
) -> Answer:
    """Correction masses from runs without and with trial masses, or from one run and coefficients that are known.

    Readings are taken as V = V0 + sum of a W over the planes, with complex masses W. All runs together give V0 and the
    influence coefficients a by least squares, so trial masses may be taken off again or left on, and there may be more runs than
    needed. Corrections are the W for which the weighted V0 + sum of a W is least; all trial masses are off then.

    The coefficients of a rotor that runs at the same speed in the same bearings stay, while its unbalance changes. With those of
    an earlier job one run, with any masses or none, is enough.

    Parameters
    ----------
    runs
        Runs, or a file of them, see :func:`~autobalancer.measure.load_balance_runs`. A run with ``trim`` is compared with what
        the others predict and then corrected further with their coefficients; masses in planes that are not corrected are off.
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
    influence
        The answer of an earlier job, its file (``.nc``), or the file of its runs, whose influence coefficients hold still. Its
        readings stay part of the least squares with an own V0, so that their errors are in the deviations.
    runout
        What sensors show of the surface of the shaft at slow roll, in the sense of ``phase``; subtracted from all readings. One
        without a speed holds at all speeds of its sensor.
    holes
        Over which each correction is split, as in :func:`~autobalancer.measure.split_mass`: their number, the angle of each, or
        its options, such as ``{"holes": 12, "masses": ["1 g"], "most": 4}``.
        The predicted vibration is then that with the masses that are put on.
    stock
        Masses that there are for the holes; by default any size.

    Returns
    -------
    Answer
        Over ``plane``: ``correction`` (kg or kg m) and ``correction_angle`` (rad, in the sense of ``angles``) with
        ``_deviation`` each, and ``change``, ``change_angle``, what to put on in addition to the masses of the last run. Over
        ``channel`` (a sensor at a speed) and ``plane``: ``influence``, ``influence_phase`` and ``influence_deviation``. Over
        ``channel``: ``original``, ``residual`` with their phases and ``residual_deviation``, the standard deviation of what
        will be found. Over ``run``: readings, masses, and ``misfit``, in deviations. One standard deviation each. With holes
        over ``part``: ``part_mass``, ``part_angle``, ``part_of`` and ``part_left``, what the parts lack; if the masses of the
        last run may stay on, ``left_on_residual`` with its phase and deviation is what the split changes leave.

    Raises
    ------
    QuestionError
        If runs do not determine the coefficients, a trial mass changes nothing, or planes cannot be told apart; it names them.

    Source: Goodman (1964); Vaughan, Static and Dynamic Balancing, Brüel & Kjær.
    """
    listed, written = balance_runs(runs)
    phase = phase or written.get("phase", "lead")
    if phase == "lag" and any(run.recording for run in listed):
        raise QuestionError(
            f"{OWNER}: phase: given 'lag', but recordings are measured as vibrations lead; leave it out"
        )
    angles = angles or written.get("angles", "with rotation")
    share = optional_argument("deviation", written.get("deviation") if deviation is None else deviation, "")
    one_of("goal", goal, *get_args(Goal))
    coefficients = written.get("influence", ())
    if influence is not None and coefficients:
        raise QuestionError(
            f"{OWNER}: influence: given, and the file of the runs has coefficients, too; keep one of both"
        )
    single = influence is not None or bool(coefficients)
    job = job_of(
        listed, phase, angles, share, phases=True, owner=OWNER, coefficients=coefficients, least=1 if single else 2,
        runout=written.get("runout", ()) if runout is None else runout,
    )  # fmt: skip
    if influence is not None:
        job = joined(_earlier(influence), job, f"{OWNER}: influence")
    refuse_undetermined(job, OWNER)
    chosen = _chosen(job, planes)
    scales = _scales(job, weights)
    limits = _limits(job, chosen, largest)
    balance = influence_of(job)
    job, estimated = _with_scatter(job, balance)
    refuse_silent(job, balance, OWNER)
    condition = _condition(scales[:, None] * balance.coefficients[:, chosen], job, chosen)

    def corrections(readings: Complexes) -> Complexes:
        original = _rows(job, balance, np.zeros(len(job.planes), complex)) @ readings
        matrix = (balance.rows[1:] @ readings).T[:, chosen]
        return least_residual(original, matrix, scales, goal, limits)

    masses = corrections(job.readings)
    covariance = mass_covariance(job, corrections)
    return dataset(
        BalanceSolution(
            job, balance, chosen, masses, covariance, scales, condition, goal, phase, angles, estimated, limits
        ),
        holes,
        stock,
    )


def _rows(job: Job, known: Influence, masses: Complexes) -> Complexes:
    """What makes of the readings the vibration with just these masses (P,), (R,); after a trim run counted from that run."""
    trims = np.flatnonzero(job.trim)
    if not trims.size:
        return np.asarray(np.r_[1.0, masses] @ known.rows)
    last = int(trims[-1])
    rows = np.r_[0.0, masses - job.masses[last]] @ known.rows - job.states[last, 1:] @ known.others
    rows[last] += 1.0
    return np.asarray(rows)


def _earlier(influence: Answer | xr.Dataset | str | Path) -> Job:
    """The runs of an earlier job as arrays: of its file, or of what was made of them."""
    if isinstance(influence, (str, Path)) and Path(influence).suffix.lower() != ".nc":
        listed, written = balance_runs(influence)
        share = optional_argument("deviation", written.get("deviation"), "")
        return job_of(
            listed, written.get("phase", "lead"), written.get("angles", "with rotation"), share, phases=True,
            owner=f"{OWNER}: influence: {influence}", runout=written.get("runout", ()),
            coefficients=written.get("influence", ()), least=1 if "influence" in written else 2,
        )  # fmt: skip
    answer = load_run(influence) if isinstance(influence, (str, Path)) else influence
    if "influence" not in answer or "reading_deviation" not in answer:
        raise QuestionError(
            f"{OWNER}: influence: given another result; must be an answer of measure.balance, kept with --out or ab.save_run"
        )
    turn = 1.0 if answer.attrs["phase"] == "lead" else -1.0
    count = 1.0 if answer.attrs["angles"] == "with rotation" else -1.0

    def texts(name: str) -> tuple[str, ...]:
        return tuple(map(str, answer[name].values))

    return Job(
        texts("run"), tuple(answer["trim"].values > 0), texts("sensor"), answer["speed"].values, texts("unit"),
        texts("all_planes"), str(answer["run_mass"].attrs["units"]).replace(" ", "*"),
        answer["reading"].values * np.exp(1j * turn * answer["reading_phase"].values),
        answer["run_mass"].values * np.exp(1j * count * answer["run_mass_angle"].values),
        answer["reading_deviation"].values, answer["reading_deviation_across"].values, answer["states"].values,
    )  # fmt: skip


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
        one_of("weights: sensor", name, *dict.fromkeys(job.sensors))
        if not value >= 0.0:
            raise QuestionError(f"weights: {name!r}: given {value!r}; must not be below zero")
    return np.array([float(weights.get(sensor, 1.0)) for sensor in job.sensors])


def _limits(job: Job, chosen: list[int], largest: float | str | Mapping[str, float | str] | None) -> Floats:
    names = [job.planes[p] for p in chosen]
    given = dict.fromkeys(names, largest) if not isinstance(largest, Mapping) else dict(largest)
    for name in given:
        one_of("largest: corrected plane", name, *names)
    limits = np.full(len(names), np.inf)
    for i, name in enumerate(names):
        value = given.get(name)
        if value is None:
            continue
        number, unit = quantity_of_units("largest", value, MASSES)
        if isinstance(value, str) and unit != job.mass_unit:
            raise QuestionError(
                f"largest: given {value!r}, but trial masses are in {job.mass_unit}; keep to one of both"
            )
        if not number > 0.0:
            raise QuestionError(f"largest: given {value!r}; must be above zero")
        limits[i] = number
    return limits


def _with_scatter(job: Job, influence: Influence) -> tuple[Job, bool]:
    """Deviations from runs beyond those needed, where none are given."""
    spare = int(influence.used.sum()) - _design(job).shape[1]
    if spare < 1 or np.isfinite(job.along).all():
        return job, False
    missed = (influence.missing(job) @ job.readings)[influence.used]
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


# What a balancing job says, as labeled arrays.


POOR = 20.0  # condition number from which on small errors become great
UNLIKELY = 0.01  # share of correct jobs in which a run is said not to follow from the others
RULE = 0.3  # share (and about the angle in rad / 2) by which a trial mass should change a reading


@dataclass(frozen=True)
class BalanceSolution:
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


def dataset(found: BalanceSolution, holes: Holes = None, stock: Stock = None) -> Answer:
    """The answer, with remarks on what to be careful about."""
    job, known = found.job, found.influence
    turn, count = (1.0 if found.phase == "lead" else -1.0), (1.0 if found.angles == "with rotation" else -1.0)
    unit = job.units[0] if len(set(job.units)) == 1 else ""
    mass = job.mass_unit.replace("*", " ")
    sizes, angles = polar_deviations(found.masses, found.covariance)
    sizes = np.where(sizes < 1e-6 * np.abs(found.masses), 0.0, sizes)  # at a limit
    change = found.masses - job.masses[-1][found.chosen]
    wanted = {f"correction in plane {job.planes[p]}": one for p, one in zip(found.chosen, found.masses, strict=True)}
    left_on = _left_on(job, found.chosen)
    if left_on and holes is not None:
        wanted |= {f"change in plane {job.planes[p]}": one for p, one in zip(found.chosen, change, strict=True)}
    put_on, parts = mounted(wanted, mass, count, holes, stock)
    residual, sure = _residual(found, put_on[: change.size])
    misfit = misfits(job, known)
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
        **_predicted("residual", residual, sure, turn, unit),
        "reading": (("run", "channel"), np.abs(job.readings), "amplitude read", unit),
        "reading_phase": (("run", "channel"), turn * np.angle(job.readings), "phase read", "rad"),
        "reading_deviation": (("run", "channel"), job.along, "its standard deviation along its own direction", unit),
        "reading_deviation_across": (("run", "channel"), job.across, "its standard deviation across it", unit),
        "trim": (("run",), np.array(job.trim, np.int8), "whether the run only checks the correction", "1"),
        "states": (("run", "state"), job.states, "vectors in a reading: as it is now, run-out, before earlier jobs", "1"),
        "run_mass": (("run", "all_planes"), np.abs(job.masses), "mass on the rotor", mass),
        "run_mass_angle": (("run", "all_planes"), count * np.angle(job.masses), "its angle", "rad"),
        "misfit": (("run", "channel"), misfit, "reading less what the others predict, in deviations of this difference", "1"),
        "covariance": (("component", "other_component"), found.covariance,
                       "covariance of the corrections, real parts of all planes first", f"({mass})^2"),
    }  # fmt: skip
    if put_on.size > change.size:
        changed = _residual(found, job.masses[-1][found.chosen] + put_on[change.size :])
        each |= _predicted("left_on_residual", *changed, turn, unit)
    answer = xr.Dataset(
        {
            name: (dims, values, {"long_name": text, "units": units})
            for name, (dims, values, text, units) in each.items()
        },
        _coordinates(found),
    ).assign(parts)
    answer.attrs = {
        "title": "Balancing with influence coefficients", **provenance(), "goal": found.goal, "phase": found.phase,
        "angles": found.angles, "condition": found.condition, "deviations_from": _deviations_from(found),
        "left_on": int(left_on), **({} if job.now.all() else {"runout_readings": _without_runout(job)}),
        "warnings": "\n".join(_remarks(found, misfit, residual, sure)),
    }  # fmt: skip
    return Answer.of(answer, "Balancing")


def _left_on(job: Job, chosen: list[int]) -> bool:
    """Whether the last run has masses in planes that are corrected which may stay on the rotor."""
    masses = job.masses[job.now][:, chosen]
    on = masses[-1] != 0.0
    if masses.shape[0] > 1:
        on &= masses[-1] == masses[-2]
    return bool(job.trim[-1] or on.any())


def misfits(job: Job, known: Influence) -> Floats:
    """How far each reading is from what the others predict, (R, C), in deviations of this difference.

    A run that took part in the fit leaves a share of what it is off the others, with the same share of the deviation, so
    the ratio is that to a fit without it. Without others that say anything it is nan.
    """
    rows = known.missing(job)
    alone = np.linalg.norm(rows, axis=1) < 1e-6
    size = np.abs(job.readings)
    way = np.where(size > 0.0, job.readings / np.where(size > 0.0, size, 1.0), 1.0)
    parts = rows[:, :, None] * way * np.stack([job.along, 1j * job.across])[:, None]
    parts = np.where(np.abs(rows)[:, :, None] > 0.0, parts, 0.0)  # of readings that count, an unknown deviation too
    xx, yy, xy = (parts.real**2).sum((0, 2)), (parts.imag**2).sum((0, 2)), (parts.real * parts.imag).sum((0, 2))
    off = rows @ job.readings
    with np.errstate(invalid="ignore", divide="ignore"):
        square = (yy * off.real**2 - 2.0 * xy * off.real * off.imag + xx * off.imag**2) / (xx * yy - xy**2)
        return np.where(alone[:, None], np.nan, np.sqrt(square))


def _far(found: BalanceSolution, misfit: Floats) -> float:
    """The misfit that one reading of a correct job exceeds with the probability `UNLIKELY`.

    Of both parts of a vector the square follows chi-square, or F where the scatter of few runs gives the deviations.
    """
    share = UNLIKELY / max(1, np.isfinite(misfit).sum())
    if not found.estimated:
        return float(np.sqrt(-2.0 * np.log(share)))
    spare = int(found.influence.used.sum()) - _design(found.job).shape[1]
    return float(np.sqrt(2.0 * spare * (share ** (-1.0 / spare) - 1.0)))


def _without_runout(job: Job) -> int:
    """From how many readings of the rotor as it is now the run-out is subtracted."""
    if not (job.states[job.now, 1:] > 0.0).any():
        return 0
    alone = ~job.now & (job.states[:, 1] > 0.0)
    return int(job.now.sum() * np.count_nonzero(job.readings[alone]))


def _coordinates(found: BalanceSolution) -> dict[str, Any]:
    job = found.job
    planes = np.array(job.planes, dtype=object)
    return {
        "plane": planes[found.chosen],
        "all_planes": planes,
        "run": np.array(job.runs, dtype=object),
        "sensor": ("channel", np.array(job.sensors, dtype=object), {"long_name": "sensor"}),
        "unit": ("channel", np.array(job.units, dtype=object), {"long_name": "unit of its readings"}),
        "written_unit": ("channel", np.array(job.written, dtype=object), {"long_name": "as they were written"}),
        "speed": ("channel", job.speeds, {"long_name": "rotor speed", "units": "rad/s"}),
    }


def _predicted(name: str, vibration: Complexes, sure: Floats, turn: float, unit: str) -> dict[str, Any]:
    return {
        name: (("channel",), np.abs(vibration), "predicted vibration with the masses that are put on", unit),
        f"{name}_phase": (("channel",), turn * np.angle(vibration), "its phase", "rad"),
        f"{name}_deviation": (("channel",), sure, "its standard deviation", unit),
    }


def _residual(found: BalanceSolution, masses: Complexes) -> tuple[Complexes, Floats]:
    """What should be left with just these masses on the rotor, and its deviation."""
    job, known = found.job, found.influence
    whole = np.zeros(len(job.planes), complex)
    whole[found.chosen] = masses
    rows = _rows(job, known, whole)
    return rows @ job.readings, row_deviation(job, rows[None])[0]


def _deviations_from(found: BalanceSolution) -> str:
    if found.estimated:
        return "scatter of the runs"
    return "readings" if np.isfinite(found.job.along).all() else ""


def _remarks(found: BalanceSolution, misfit: Floats, residual: Complexes, sure: Floats) -> list[str]:
    job, known, told = found.job, found.influence, []
    if not np.isfinite(sure).all():
        told.append("uncertainty is not known: give the readings deviations, or make one run more than needed")
    for p, plane in enumerate(job.planes):
        change = np.abs(known.coefficients[:, p]) * np.abs(job.masses[job.now, p]).max()
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
    if len(set(job.units)) > 1 and np.array_equal(found.weights, _scales(job, None)):
        told.append(
            "sensors of different kinds: each is weighed by one over its greatest reading, not by its deviation"
        )
    for r in np.flatnonzero(np.nanmax(np.nan_to_num(misfit), axis=1, initial=0.0) > _far(found, misfit)):
        c = int(np.nanargmax(misfit[r]))
        kind = "trim run" if job.trim[r] else "run"
        told.append(
            f"{kind} {job.runs[r]!r} does not follow from the others: {job.channel(c)} is {misfit[r, c]:.3g} standard "
            "deviations of the difference off; check its masses and its speed, and whether balls in a race have moved"
        )
    if (job.states[~job.now].sum(axis=1) > 1.0).any() and not (job.states[job.now, 1:] > 0.0).any():
        told.append(
            "the job whose coefficients are used had a run-out, and these readings have none that is subtracted: "
            "if the sensors still see it, it counts as unbalance; give it as runout"
        )
    at_limit = [
        job.planes[p]
        for p, m, most in zip(found.chosen, found.masses, found.limits, strict=True)
        if abs(m) > 0.999 * most
    ]
    if at_limit:
        told.append(f"the greatest mass is reached in plane {', '.join(map(repr, at_limit))}")
    return told


def _weakest(found: BalanceSolution) -> str:
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


# Corrections as they are put on: split over holes, of masses that there are.


SPLIT = ("holes", "first", "masses", "largest", "most")  # options of split_mass


def mounted(
    wanted: Mapping[str, complex], unit: str, sense: float, holes: Holes, stock: Stock
) -> tuple[Complexes, dict[str, Any]]:
    """Masses (kg or kg m) as they are put on, and each part of them as variables where they are split over holes.

    ``sense`` is -1 where angles are counted against the rotation.
    """
    put_on = np.array(list(wanted.values()), complex)
    options = {"masses": stock, **(holes if isinstance(holes, Mapping) else {"holes": holes})}
    if not options.keys() <= set(SPLIT):
        raise QuestionError(
            f"holes: given {', '.join(options.keys() - set(SPLIT))}; must be some of {', '.join(SPLIT)}"
        )
    if options.get("holes") is None:
        if options.keys() - {"holes", "masses"} or options["masses"] is not None:
            raise QuestionError(
                "stock: given without holes, or options of them; say how many holes there are, or the angle of each"
            )
        return put_on, {}
    parts: list[tuple[str, float, float, float]] = []
    for n, (name, mass) in enumerate(wanted.items()):
        size = f"{abs(mass):.17g} {unit.replace(' ', '*')}"
        split = split_mass(size, sense * float(np.angle(mass)), **options)
        put_on[n] = np.exp(1j * sense * np.array(split.angles)) @ np.array(split.masses)
        pairs = zip(split.masses or (0.0,), split.angles or (0.0,), strict=True)
        parts += [(name, part, at, split.residual) for part, at in pairs]
    of, masses, angles, left = zip(*parts, strict=True)
    tried = {} if options["masses"] is None else {"most": int(options.get("most", 3))}
    return put_on, {
        "part_of": ("part", np.array(of, dtype=object), {"long_name": "which mass it is a part of"}),
        "part_mass": ("part", list(masses), {"long_name": "mass in a hole", "units": unit}),
        "part_angle": ("part", list(angles), {"long_name": "angle of the hole", "units": "rad"}),
        "part_left": ("part", list(left), {"long_name": "wanted mass less its parts", "units": unit, **tried}),
    }


# How sure corrections are: the deviations of all readings carried through to the masses, linearly.


STEP = 1e-3  # of a reading's deviation, by which it is changed


def mass_covariance(job: Job, corrections: Callable[[Complexes], Complexes]) -> Floats:
    """Covariance of the masses, real parts first, (2 P, 2 P); nan where a deviation is not known.

    ``corrections`` makes masses of readings of the shape of the job.
    """
    count = corrections(job.readings).size
    if not (np.isfinite(job.along).all() and np.isfinite(job.across).all()):
        return np.full((2 * count, 2 * count), np.nan)
    mass_covariance = np.zeros((2 * count, 2 * count))
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
            mass_covariance += np.outer(change, change)
    return mass_covariance


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
