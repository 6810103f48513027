"""Balancing without phase: one run without a trial mass and three with it at different places; a trial mass beforehand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
import xarray as xr

from autobalancer.arrays import Complexes, Floats
from autobalancer.errors import QuestionError
from autobalancer.laws.capabilities import grade_argument, permissible_unbalance
from autobalancer.machine import Machine, Unbalance
from autobalancer.measurement.balancing.balance import Holes, Stock, mounted, polar_deviations
from autobalancer.measurement.balancing.runs import (
    AMPLITUDES,
    Angles,
    BalanceRun,
    Job,
    balance_runs,
    job_of,
    quantity_of_units,
)
from autobalancer.results.answers.answer import Answer, provenance
from autobalancer.rotordynamics.response import response
from autobalancer.tables import whole_degrees
from autobalancer.units import argument, optional_argument

OWNER = "four-run"
READING = 0.02  # share by which amplitudes are taken to be uncertain where nothing is given
CLEAR = 9.0  # by how much the misfit of another point must be greater to be ruled out: three standard deviations
ODD, IMPOSSIBLE = 9.0, 25.0  # misfit for each run beyond three that is remarked and refused
SILENT = 3.0  # deviations by which a trial mass must change some amplitude


def four_run(
    runs: Sequence[BalanceRun] | str | Path,
    *,
    angles: Angles | None = None,
    deviation: float | str | None = None,
    both: bool = False,
    holes: Holes = None,
    stock: Stock = None,
) -> Answer:
    """Correction in one plane from amplitudes alone.

    With a trial mass w the amplitude is ``A = h |w - c|``: circles of radius A / h around each w meet at the correction c. Four
    runs give c and h in closed form; the weighted least squares of all runs follow from it and from starts all around.

    Parameters
    ----------
    runs
        One without trial mass, and three or more with it at different places of one plane, or a file of them, see
        :func:`~autobalancer.measure.load_balance_runs`. Phases are not used. Each sensor and speed is evaluated by itself.
    angles
        ``"with rotation"`` (the default) or ``"against rotation"``.
    deviation
        Standard deviation of an amplitude as its share, where readings have none; 2 % by default.
    both
        Whether two answers are given where the runs cannot decide, as with two trial runs or places on one line.
    holes
        Over which each correction is split, as in :func:`~autobalancer.measure.split_mass`: their number, the angle of each, or
        its options, such as ``{"holes": 12, "masses": ["1 g"], "most": 4}``.
    stock
        Masses that there are for the holes; by default any size.

    Returns
    -------
    Answer
        Over ``channel`` and ``solution`` (the best first): ``correction`` (kg or kg m), ``correction_angle`` (rad),
        ``sensitivity`` (amplitude for a unit of mass), ``residual`` (amplitude with the masses that are put on), each with its
        standard ``_deviation``, and ``misfit``, the root mean square of what does not fit, in standard deviations; the masses,
        amplitudes and ``missed`` over ``run``. With holes over ``part``: ``part_mass``, ``part_angle``, ``part_of`` and
        ``part_left``, what the parts lack.

    Raises
    ------
    QuestionError
        If two runs have one mass at one place, circles do not meet, no amplitude changes, or two points do equally well; it names
        the runs.

    Source: Rodrigues et al. (2011), section 4, who name the method; circles as in Shreve, Balancing without phase.
    """
    listed, written = balance_runs(runs)
    for name in {"runout", "influence"} & set(written):
        raise QuestionError(f"{OWNER}: {name}: given, but vectors need phases, which are not used here; leave it out")
    share = optional_argument("deviation", written.get("deviation", READING) if deviation is None else deviation, "")
    counted = angles or written.get("angles", "with rotation")
    job = job_of(listed, "lead", counted, share, phases=False, owner=OWNER)
    if len(job.planes) != 1:
        names = ", ".join(map(repr, job.planes)) or "none"
        raise QuestionError(f"{OWNER}: without phases there is one plane with trial masses; given {names}")
    masses = job.masses[:, 0]
    refuse_places(masses, job.runs, OWNER)
    line = on_a_line(masses)
    if (line or masses.size < 4) and not both:
        why = "all masses lie on one line" if line else "there are two trial runs"
        raise QuestionError(
            f"{OWNER}: {why} ({', '.join(map(repr, job.runs))}), so that two places do equally well; "
            "make one more run with the mass at another place off this line, or ask for both answers"
        )
    four_run = [_solved(job, c, both) for c in range(len(job.sensors))]
    return _dataset(job, four_run, counted, share, holes, stock)


def _solved(job: Job, c: int, both: bool) -> list[Meeting]:
    """The points in which the circles of a channel meet, the best one first."""
    amplitudes, masses = job.readings[:, c].real, job.masses[:, 0]
    sure = np.where(job.along[:, c] > 0.0, job.along[:, c], np.inf)
    sure = np.where(np.isfinite(sure), sure, np.min(sure))
    where = f"{OWNER}: {job.channel(c)}"
    if not np.any(amplitudes > 0.0):
        raise QuestionError(f"{where}: all amplitudes are zero; check the sensor")
    if np.abs(amplitudes - amplitudes.mean()).max() < SILENT * sure.max():
        r = int(np.argmax(np.abs(masses)))
        raise QuestionError(
            f"{where}: run {job.runs[r]!r}: the trial mass changes the amplitude by no more than its uncertainty "
            f"({100.0 * np.ptp(amplitudes) / amplitudes.mean():.2g} % over all runs); take a larger one"
        )
    all_found = meetings(amplitudes, masses, sure)
    if not all_found:
        raise QuestionError(f"{where}: the circles meet nowhere; check the amplitudes of all runs")
    best, spare = all_found[0], max(1, masses.size - 3)
    if best.misfit / spare > IMPOSSIBLE:
        r = int(np.argmax(np.abs(best.missed)))
        raise QuestionError(
            f"{where}: the circles do not meet: run {job.runs[r]!r} is {abs(best.missed[r]):.2g} standard deviations off "
            "the best point. Check amplitude, mass and place of each run, and the speed; balls in a race that have moved between "
            "runs do this: hold them or take them out"
        )
    others = [one for one in all_found[1:] if one.misfit - best.misfit < CLEAR]
    if others and not both:
        texts = ", ".join(_text(one, job.mass_unit) for one in (best, *others[:2]))
        raise QuestionError(
            f"{where}: the runs cannot decide between {texts}; measure more precisely, take a larger trial mass, "
            "or make one more run"
        )
    return [best, *others][:2] if both else [best]


def _text(one: Meeting, unit: str) -> str:
    sign, factor = ("g", 1e3) if unit == "kg" else ("g mm", 1e6)
    return f"{factor * abs(one.correction):.3g} {sign} at {whole_degrees(np.angle(one.correction))} deg"


def _dataset(
    job: Job, found: list[list[Meeting]], angles: Angles, share: float | None, holes: Holes, stock: Stock
) -> Answer:
    count = 1.0 if angles == "with rotation" else -1.0
    most = max(map(len, found))
    mass, unit = job.mass_unit.replace("*", " "), job.units[0] if len(set(job.units)) == 1 else ""
    names = ("correction", "correction_deviation", "correction_angle", "correction_angle_deviation", "sensitivity",
             "sensitivity_deviation", "misfit", "residual", "residual_deviation")  # fmt: skip
    values = {name: np.full((len(found), most), np.nan) for name in names}
    missed = np.full((len(job.runs), len(found)), np.nan)
    spare = max(1, len(job.runs) - 3)
    wanted = {
        f"correction {s + 1} by {job.channel(c)}" if len(found) > 1 or most > 1 else "correction": point.correction
        for c, points in enumerate(found)
        for s, point in enumerate(points)
    }
    put_on, parts = mounted(wanted, mass, count, holes, stock)
    on = iter(put_on)
    for c, points in enumerate(found):
        missed[:, c] = points[0].missed
        for s, point in enumerate(points):
            more = point.misfit / spare if point.misfit / spare > ODD else 1.0
            sizes, turned = polar_deviations(np.array([point.correction]), more * point.covariance[:2, :2])
            lacking = next(on) - point.correction
            slope = np.array([[-point.sensitivity, 0.0, lacking.real], [0.0, -point.sensitivity, lacking.imag]])
            left = np.sqrt(0.5 * more * np.trace(slope @ point.covariance @ slope.T))  # along any direction
            row = (abs(point.correction), sizes[0], count * np.angle(point.correction), turned[0], point.sensitivity,
                   np.sqrt(more * point.covariance[2, 2]), np.sqrt(point.misfit / spare),
                   point.sensitivity * abs(lacking), left)  # fmt: skip
            for name, value in zip(names, row, strict=True):
                values[name][c, s] = value
    texts = ("correction mass", "its standard deviation", "angle of the correction mass", "its standard deviation",
             "amplitude for a unit of mass", "its standard deviation", "misfit in standard deviations",
             "predicted amplitude with the masses that are put on", "its standard deviation")  # fmt: skip
    units = (mass, mass, "rad", "rad", f"{unit}/({mass})", f"{unit}/({mass})", "1", unit, unit)
    # how far the circles are from one point, beside what the trial mass does
    apart = missed * np.where(np.isfinite(job.along), job.along, 0.0)
    effect = values["sensitivity"][:, 0] * np.abs(job.masses[:, 0]).max()
    miss = np.sqrt((apart**2).sum(axis=0) / spare) / effect
    data = {
        name: (("channel", "solution"), values[name], {"long_name": text, "units": si})
        for name, text, si in zip(names, texts, units, strict=True)
    }
    answer = xr.Dataset(
        {
            **data,
            "miss": ("channel", miss, {"long_name": "misfit over the effect of the trial mass", "units": "1"}),
            "amplitude": (("run", "channel"), job.readings.real, {"long_name": "amplitude read", "units": unit}),
            "missed": (
                ("run", "channel"),
                missed,
                {"long_name": "prediction less reading in standard deviations", "units": "1"},
            ),
            "trial_mass": ("run", np.abs(job.masses[:, 0]), {"long_name": "trial mass", "units": mass}),
            "trial_angle": ("run", count * np.angle(job.masses[:, 0]), {"long_name": "its angle", "units": "rad"}),
        },
        {
            "run": np.array(job.runs, dtype=object),
            "sensor": ("channel", np.array(job.sensors, dtype=object), {"long_name": "sensor"}),
            "unit": ("channel", np.array(job.units, dtype=object), {"long_name": "unit of its readings"}),
            "written_unit": ("channel", np.array(job.written, dtype=object), {"long_name": "as they were written"}),
            "speed": ("channel", job.speeds, {"long_name": "rotor speed", "units": "rad/s"}),
        },
    ).assign(parts)
    warnings = [
        f"{job.channel(c)}: the circles meet poorly, by {np.sqrt(points[0].misfit / spare):.2g} standard "
        "deviations: a run was disturbed, or balls in a race have moved between runs; the uncertainty contains it"
        for c, points in enumerate(found)
        if points[0].misfit / spare > ODD
    ]
    warnings += [
        f"{job.channel(c)}: two places do equally well; one more run decides"
        for c, points in enumerate(found)
        if len(points) > 1
    ]
    answer.attrs = {
        "title": "Balancing without phase", **provenance(), "angles": angles, "deviation": float(share or np.nan),
        "plane": job.planes[0], "noise_up_to": ODD**0.5, "none_beyond": IMPOSSIBLE**0.5, "warnings": "\n".join(warnings),
    }  # fmt: skip
    return Answer.of(answer, "FourRun")


# Runs without phase as circles in the plane of masses.
#
# With a mass w on the rotor the amplitude is A = h |w - c|, c being the correction that brings the rotor to rest and
# h what a unit of mass does. So c lies on a circle of radius A / h around each w, the run without trial mass among
# them (w = 0). Three unknowns (h and the two parts of c) need three runs, which two points satisfy; a fourth one, off
# their line, decides.


STEPS, CLOSE = 60, 1e-12
DIRECTIONS = 24  # of the starts of the search


@dataclass(frozen=True)
class Meeting:
    """A point in which circles meet: correction c, sensitivity h, covariance (3, 3) of h and both parts of c, and the misfit, the
    sum of squares of readings less prediction in standard deviations.
    """

    correction: complex
    sensitivity: float
    covariance: Floats
    misfit: float
    missed: Floats  # (R,), in standard deviations


def closed_form(amplitudes: Floats, masses: Complexes) -> tuple[complex, float] | None:
    """c and h from four runs or more whose masses are not on one circle or line through them: linear in h^2, h^2 c and h^2 |c|^2.

    None where the runs do not determine them, or h^2 is not above zero.
    """
    rows = np.column_stack([np.abs(masses) ** 2, -2.0 * masses.real, -2.0 * masses.imag, np.ones(masses.size)])
    size = np.abs(masses).max()
    scale = np.array([size**2, size, size, 1.0])
    result, _, rank, _ = np.linalg.lstsq(rows / scale, amplitudes**2, rcond=1e-9)
    if rank < 4:
        return None
    square, x, y, _ = result / scale
    return (complex(x, y) / square, float(np.sqrt(square))) if square > 0.0 else None


def meetings(amplitudes: Floats, masses: Complexes, sure: Floats) -> list[Meeting]:
    """All points in which the circles meet best, the best one first: minima of the weighted squares from starts all around."""
    starts: list[tuple[complex, float]] = []
    first = closed_form(amplitudes, masses)
    if first is not None:
        starts.append(first)
    step = float(np.abs(masses).max())
    for far in (0.3, 1.0, 3.0, 10.0):
        for angle in 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS:
            place = far * step * np.exp(1j * angle)
            starts.append((place, float(amplitudes.sum() / np.abs(masses - place).sum())))
    meetings: list[Meeting] = []
    for one in _minima(amplitudes, masses, sure, np.array([[s.real, s.imag, h] for s, h in starts]), step):
        apart = [abs(one.correction - other.correction) for other in meetings]
        if not apart or min(apart) > 1e-4 * max(step, abs(one.correction)):
            meetings.append(one)
    return sorted(meetings, key=lambda one: one.misfit)


def _minima(amplitudes: Floats, masses: Complexes, sure: Floats, starts: Floats, step: float) -> list[Meeting]:
    """Damped Gauss-Newton from all starts at once; those that end at a minimum."""
    scale = np.array([step, step, amplitudes.max() / step])
    u = starts / scale
    damping = np.full(len(u), 1e-3)
    missed, rows = _rows(u * scale, amplitudes, masses, sure)
    rows = rows * scale
    cost = (missed**2).sum(axis=1)
    for _ in range(STEPS):
        normal = rows.transpose(0, 2, 1) @ rows
        slope = (rows.transpose(0, 2, 1) @ missed[..., None])[..., 0]
        diagonal = np.einsum("nii->ni", normal)
        matrix = (
            normal
            + damping[:, None, None] * np.eye(3) * (diagonal + 1e-12 * diagonal.max(axis=1, keepdims=True))[:, None, :]
        )
        change = np.linalg.solve(matrix, -slope[..., None])[..., 0]
        tried = u + change
        new_missed, new_rows = _rows(tried * scale, amplitudes, masses, sure)
        new_cost = (new_missed**2).sum(axis=1)
        better = new_cost <= cost
        u = np.where(better[:, None], tried, u)
        missed = np.where(better[:, None], new_missed, missed)
        rows = np.where(better[:, None, None], new_rows * scale, rows)
        cost = np.where(better, new_cost, cost)
        damping = np.clip(np.where(better, 0.2 * damping, 8.0 * damping), 1e-12, 1e8)
        if np.abs(change).max() < CLOSE:
            break
    minima = []
    for n in range(len(u)):
        normal = rows[n].T @ rows[n]
        slope = np.abs(rows[n].T @ missed[n])
        flat = slope <= 1e-5 * (1.0 + np.linalg.norm(rows[n], axis=0) * np.sqrt(cost[n]))
        if flat.all() and u[n, 2] > 0.0:
            c = complex(*(u[n, :2] * scale[:2]))
            covariance = np.linalg.pinv(normal) * np.outer(scale, scale)
            minima.append(Meeting(c, float(u[n, 2] * scale[2]), covariance, float(cost[n]), missed[n]))
    return sorted(minima, key=lambda one: one.misfit)


def _rows(u: Floats, amplitudes: Floats, masses: Complexes, sure: Floats) -> tuple[Floats, Floats]:
    """Prediction less reading in deviations, (N, R), and its derivatives by both parts of c and h, (N, R, 3)."""
    way = u[:, 0, None] + 1j * u[:, 1, None] - masses
    far = np.maximum(np.abs(way), 1e-300)
    h = u[:, 2, None]
    rows = np.stack([h * way.real / far, h * way.imag / far, far], axis=2) / sure[:, None]
    return (h * far - amplitudes) / sure, rows


def refuse_places(masses: Complexes, runs: tuple[str, ...], owner: str) -> None:
    """Refuse runs with one mass at one place, and too few of them.

    Raises
    ------
    QuestionError
        It names the runs.
    """
    step = np.abs(masses).max()
    if step == 0.0:
        raise QuestionError(
            f"{owner}: no run has a trial mass; make one run without and three with it, at three places"
        )
    for i in range(masses.size):
        for j in range(i):
            if abs(masses[i] - masses[j]) < 1e-6 * step:
                raise QuestionError(
                    f"{owner}: runs {runs[j]!r} and {runs[i]!r} have the same mass at the same place; move it, best by 120 deg"
                )
    if masses.size < 3:
        raise QuestionError(
            f"{owner}: given {masses.size} runs; without phases at least three are needed, and four decide"
        )


def on_a_line(masses: Complexes) -> bool:
    """Whether all masses lie on one straight line, so that a point and its mirror image do equally well."""
    apart = masses[1:] - masses[0]
    way = apart[int(np.argmax(np.abs(apart)))]
    return bool(np.abs((apart * np.conj(way)).imag).max() < 1e-6 * abs(way) ** 2)


# The trial mass for a balancing job: how large, where, and whether it will be seen.


GRAVITY = 9.80665
SHARE = 0.1  # of the weight that a trial mass may pull with, rule of practice
GRADE_TIMES = 5.0  # permissible unbalances that a trial mass makes
SEEN = 0.3  # share of the reading by which it should change it
Running = Literal["below", "above"]
QUANTITIES = {"m": "displacement", "m/s": "velocity", "m/s^2": "acceleration"}


@dataclass(frozen=True)
class TrialPlan:
    """A trial mass (kg) at ``radius`` (m), its unbalance (kg m), force (N), and angle (rad, nan where nothing says where).

    ``change`` is the share by which it changes the reading, nan where no model says so; ``remarks`` say what to be careful about.
    """

    mass: float
    unbalance: float
    radius: float
    angle: float
    force: float
    change: float
    rule: str
    remarks: tuple[str, ...]


def trial_mass(
    *,
    radius: float | str,
    speed: float | str,
    rotor_mass: float | str | None = None,
    grade: float | str | None = None,
    machine: Machine | str | Path | None = None,
    station: str | float | None = None,
    plane: str | float | None = None,
    direction: Literal["x", "y"] = "x",
    reading: float | str | None = None,
    phase: float | str | None = None,
    running: Running | None = None,
) -> TrialPlan:
    """Plan a trial mass.

    Its size comes from the model if there is one (it changes the ``reading`` by 30 %), else from the ``grade`` (five times what
    the grade allows), else it pulls with a tenth of the weight of the rotor. Its place takes unbalance away rather than adding
    to it.

    Parameters
    ----------
    radius
        At which it will be, m.
    speed
        At which it will run, rad/s.
    rotor_mass
        kg; not needed with a machine of one mass.
    grade
        Balance quality grade in mm/s, such as 6.3 or ``"G 6.3"``.
    machine, station, plane, direction
        Model, where it is read and where the mass will be (by default the plane of the first balancer), and along what.
    reading, phase
        Of the run without trial mass, amplitude (peak) with unit, and lead against the mark, rad.
    running
        Without a model: ``"below"`` the critical speed, where the rotor moves towards its heavy side, or ``"above"``, where it
        moves away from it.

    Raises
    ------
    QuestionError
        If neither of the three ways is possible.

    Source: ISO 21940-11:2016 for grades; the tenth of the weight is a rule of practice.
    """
    arm, w = argument("radius", radius, "m"), argument("speed", speed, "rad/s")
    heavy = optional_argument("rotor_mass", rotor_mass, "kg")
    lead = optional_argument("phase", phase, "rad")
    for name, value in (("radius", arm), ("speed", w)):
        if not value > 0.0:
            raise QuestionError(f"trial_mass: {name}: given {value:g}; must be above zero")
    amplitude, unit = (
        (None, "m") if reading is None else quantity_of_units("reading", reading, AMPLITUDES, amplitude=True)
    )
    remarks: list[str] = []
    gain = None  # complex amplitude at the station for a unit unbalance in the plane
    if machine is not None:
        if unit not in QUANTITIES:
            raise QuestionError(
                f"trial_mass: reading: with a model a displacement, velocity or acceleration is needed, not {unit}"
            )
        load: Any = 1.0 if plane is None else (Unbalance(moment=1.0, station=plane),)
        quantity: Any = QUANTITIES[unit]
        found = response(machine, [w], None if station is None else [station], load, quantity=quantity)
        one = found.isel(speed=0, station=0)
        gain = complex(float(one[f"{direction}_real"]), float(one[f"{direction}_imag"]))
    # the better something is known, the earlier it counts: the model, the grade, the weight
    if gain is not None and amplitude is not None:
        unbalance, rule = SEEN * amplitude / abs(gain), "30 % of the reading, by the model"
    elif heavy is not None and grade is not None:
        unbalance, rule = (
            GRADE_TIMES * permissible_unbalance(grade, heavy, w),
            f"five times what G {grade_argument(grade):g} allows",
        )
    elif heavy is not None:
        unbalance, rule = SHARE * heavy * GRAVITY / w**2, "a tenth of the weight"
    else:
        raise QuestionError("trial_mass: give a machine and a reading, or the 'rotor_mass', with or without a 'grade'")
    force = unbalance * w**2
    if heavy is not None and force > SHARE * heavy * GRAVITY * (1.0 + 1e-9):
        remarks.append(
            f"it pulls with {force / (heavy * GRAVITY):.2g} of the weight of the rotor, more than a tenth; start at a lower speed"
        )
    # what the reading will do, so that a trial that changes nothing is seen beforehand
    change = float("nan") if gain is None or amplitude is None else abs(gain) * unbalance / amplitude
    return TrialPlan(
        unbalance / arm, unbalance, arm, _place(lead, gain, running, remarks), force, change, rule, tuple(remarks)
    )


def _place(lead: float | None, gain: complex | None, running: Running | None, remarks: list[str]) -> float:
    """Opposite to where the unbalance is, as far as anything says."""
    if lead is None:
        remarks.append(
            "without a phase nothing says where; start anywhere, and move it by 120 deg if the vibration grows much"
        )
        return float("nan")
    if gain is not None:
        heavy_side = lead - float(np.angle(gain))
    elif running is None:
        remarks.append(
            "say whether the rotor runs below or above its critical speed, or give a model, to know where it goes"
        )
        return float("nan")
    else:
        heavy_side = lead - (0.0 if running == "below" else np.pi)
    return float(np.mod(heavy_side + np.pi, 2.0 * np.pi))
