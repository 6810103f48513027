"""Balancing without phase: one run without a trial mass and three with it at different places."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.measurement.balancing.arrays import Angles, Job, job_of
from autobalancer.measurement.balancing.circles import Meeting, meetings, on_a_line, refuse_places
from autobalancer.measurement.balancing.file import given_runs
from autobalancer.measurement.balancing.four_run_answer import FourRun
from autobalancer.measurement.balancing.runs import BalanceRun
from autobalancer.measurement.balancing.uncertainty import polar_deviations
from autobalancer.results.provenance import provenance
from autobalancer.shown import whole_degrees
from autobalancer.units import optional_argument

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
) -> FourRun:
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

    Returns
    -------
    FourRun
        Over ``channel`` and ``solution`` (the best first): ``correction`` (kg or kg m), ``correction_angle`` (rad),
        ``sensitivity`` (amplitude for a unit of mass), each with its standard ``_deviation``, and ``misfit``, the root mean
        square of what does not fit, in standard deviations; the masses, amplitudes and ``missed`` over ``run``.

    Raises
    ------
    QuestionError
        If two runs have one mass at one place, circles do not meet, no amplitude changes, or two points do equally well; it names
        the runs.

    Source: Rodrigues et al. (2011), section 4, who name the method; circles as in Shreve, Balancing without phase.
    """
    listed, written = given_runs(runs)
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
    found = [_solved(job, c, both) for c in range(len(job.sensors))]
    return _dataset(job, found, counted, share)


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


def _dataset(job: Job, found: list[list[Meeting]], angles: Angles, share: float | None) -> FourRun:
    count = 1.0 if angles == "with rotation" else -1.0
    most = max(map(len, found))
    mass, unit = job.mass_unit.replace("*", " "), job.units[0] if len(set(job.units)) == 1 else ""
    names = ("correction", "correction_deviation", "correction_angle", "correction_angle_deviation", "sensitivity",
             "sensitivity_deviation", "misfit")  # fmt: skip
    values = {name: np.full((len(found), most), np.nan) for name in names}
    missed = np.full((len(job.runs), len(found)), np.nan)
    spare = max(1, len(job.runs) - 3)
    for c, points in enumerate(found):
        missed[:, c] = points[0].missed
        for s, one in enumerate(points):
            more = one.misfit / spare if one.misfit / spare > ODD else 1.0
            sizes, turned = polar_deviations(np.array([one.correction]), more * one.covariance[:2, :2])
            row = (abs(one.correction), sizes[0], count * np.angle(one.correction), turned[0], one.sensitivity,
                   np.sqrt(more * one.covariance[2, 2]), np.sqrt(one.misfit / spare))  # fmt: skip
            for name, value in zip(names, row, strict=True):
                values[name][c, s] = value
    texts = ("correction mass", "its standard deviation", "angle of the correction mass", "its standard deviation",
             "amplitude for a unit of mass", "its standard deviation", "misfit in standard deviations")  # fmt: skip
    units = (mass, mass, "rad", "rad", f"{unit}/({mass})", f"{unit}/({mass})", "1")
    data = {
        name: (("channel", "solution"), values[name], {"long_name": text, "units": si})
        for name, text, si in zip(names, texts, units, strict=True)
    }
    answer = xr.Dataset(
        {
            **data,
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
            "speed": ("channel", job.speeds, {"long_name": "rotor speed", "units": "rad/s"}),
        },
    )
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
        "plane": job.planes[0], "warnings": "\n".join(warnings),
    }  # fmt: skip
    return FourRun.of(answer)
