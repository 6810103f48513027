"""Several machines, one run each: what counts of each in one table."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError, RangeWarning, unwarned, warn
from autobalancer.files.machine_file import any_machine, balls_in_races, machine_text
from autobalancer.machine import Machine
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.machine.part import Part
from autobalancer.machine_kinds import machine_kind
from autobalancer.progress import shows_progress
from autobalancer.results.answers.answer import Answer, provenance
from autobalancer.results.chamber_measures import chamber_measures
from autobalancer.results.labels import labeled
from autobalancer.results.measure_table import SWEPT, numbers
from autobalancer.results.run_arrays import recorded_of
from autobalancer.results.verdict import NO_VERDICT, Verdict, verdict
from autobalancer.simulation import ONE_RUN, held_run, simulated
from autobalancer.simulation.chamber.chamber_verdict import chamber_verdict, middle_deflection
from autobalancer.simulation.record import Envelope, LastRevolutions
from autobalancer.stability.maps.exact import borders
from autobalancer.studies.variations import in_threads
from autobalancer.units import list_argument, optional_argument

AnyMachine = Machine | ChamberMachine
MachineArgument = AnyMachine | str | Path


@shows_progress
def compare(
    machines: Mapping[str, MachineArgument] | Sequence[MachineArgument],
    *,
    at: Sequence[float | str] | float | str = (),
    duration: float | str | None = None,
    tolerance: float = ONE_RUN["tolerance"],
    bins: int = 500,
    seed: int = 0,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Answer:
    """Run several machines, each with its own drive, and put side by side what each run left.

    Parameters
    ----------
    machines
        Machines, or the paths of their files, in the order of the table; a mapping gives them names of its own, else each has
        the name in its file. Balls run in races or in deep chambers.
    at
        Rotor speeds, rad/s or texts with units or a range, at which the deflection is wanted too, such as one below the
        critical speed.
    duration, tolerance, seed
        As for :func:`autobalancer.simulate`; a deep chamber has steps in place of a tolerance.
    bins
        Resolution in time of the deflection.
    workers
        Threads; by default one for each core.
    progress
        Called with (machines done, machines in all).

    Returns
    -------
    Answer
        A dataset over ``machine``: ``peak_deflection`` (m) at ``peak_speed`` (rad/s), ``peak_without_balls`` (m, with held
        balls), ``vibration`` (m) at the end and
        ``vibration_without_balls``, ``settling_time`` (s) of the last ball, ``verdict``, ``stalled_balls`` at the
        end; ``deflection_at`` (m) over ``speed``, the greatest in the second half of the time at this speed
        (within 1 %); ``exact_border`` (rad/s), above which the balanced state is stable at all positions of the balls, with
        ``border_note``, and ``exact_border_best_case`` at the
        best ones; ``support_force`` (N), how far the force of the hardest loaded support gets from its
        mean at the end; and the greatest ``deflection`` (m) with the rotor speed over ``time_in_run``.

    Raises
    ------
    QuestionError
        For no machine, two of one name, or a speed that is not finite.
    UnitError
        If a speed or the duration is no such quantity.
    """
    named = _named_machines(machines)
    duration = optional_argument("duration", duration, "s")
    speeds = list_argument("at", at, "rad/s")
    if not np.isfinite(speeds).all():
        raise QuestionError(f"at: given {', '.join(f'{speed:g}' for speed in speeds)} rad/s; must be finite speeds")

    def one(machine: AnyMachine) -> dict[str, Any]:
        with unwarned(RangeWarning):  # which does not say of which machine
            wished = {"tolerance": tolerance, "seed": seed, "save": [Envelope(bins), LastRevolutions()]}
            run = simulated(machine, wished | {"duration": duration})
            row, judged, course = machine_kind(machine)["row"](machine, run, held_run(machine, run, wished), bins)
            return _row(row, judged, course, speeds)

    rows = in_threads(one, list(named.values()), workers, progress)
    for name, row in zip(named, rows, strict=True):
        for text in row["beyond"]:
            warn(f"{name}: {text}", RangeWarning)
    return _dataset(named, rows, speeds).assign_attrs(tolerance=tolerance, seed=seed)


def _read(argument: MachineArgument) -> AnyMachine:
    machine = any_machine(argument)
    return balls_in_races(machine) if isinstance(machine, Machine) else machine


def _named_machines(machines: Mapping[str, MachineArgument] | Sequence[MachineArgument]) -> dict[str, AnyMachine]:
    if isinstance(machines, Mapping):
        named = {str(name): _read(machine) for name, machine in machines.items()}
    else:
        given = [machines] if isinstance(machines, str | Path | Part) else list(machines)
        read = [_read(machine) for machine in given]
        names = [machine.name for machine in read]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise QuestionError(
                f"machines: {len(read)} machines, of which several are called {twice[0]!r}; give them names of their own"
            )
        named = dict(zip(names, read, strict=True))
    if not named:
        raise QuestionError("machines: given none; give at least one machine to be compared")
    return named


def _dataset(named: Mapping[str, AnyMachine], rows: Sequence[dict[str, Any]], speeds: Sequence[float]) -> Answer:
    def column(name: str) -> list[Any]:
        return [row[name] for row in rows]

    longest = max(row["course"][0].size for row in rows)
    time, deflection, speed = (
        np.array([np.pad(one, (0, longest - one.size), constant_values=np.nan) for one in courses])
        for courses in zip(*column("course"), strict=True)
    )
    about = {entry.name: (entry.text, entry.unit) for entry in SWEPT} | TEXTS
    late = "greatest deflection in the second half of the time at this speed"
    dataset = labeled(
        {
            **{name: ("machine", np.array(column(name), np.float64), *about[name]) for name in MEASURES},
            "deflection_at": (("machine", "speed"), np.reshape(column("deflection_at"), (len(rows), -1)), late, "m"),
            **{name: ("machine", column(name), *TEXTS[name]) for name in (*BORDERS, "support_force", "stalled_balls")},
            **{name: ("machine", np.array(column(name), dtype=object)) for name in ("verdict", "border_note")},
            "time_in_run": (("machine", "bin"), time, "time", "s"),
            "deflection": (("machine", "bin"), deflection, "greatest deflection", "m"),
            "speed_in_run": (("machine", "bin"), speed, "rotor speed", "rad/s"),
        },
        {"machine": ("machine", list(named)), "speed": ("speed", list(speeds), "rotor speed", "rad/s")},
        {"title": "Comparison of machines", **provenance(), "machines": [machine_text(m) for m in named.values()]},
    )
    return Answer.of(dataset, "Comparison")


# What a comparison of machines keeps of one run, of balls in races or in deep chambers.


NEAR = 0.01  # of a speed: the rotor counts as running at it
LATE = 0.5  # of the time at a speed: the balls have had the rest of it to settle
BORDER, BORDERS = "exact border", ("exact_border", "exact_border_best_case")
TEXTS = {
    "peak_without_balls": ("greatest deflection with held balls", "m"),
    "exact_border": (BORDER, "rad/s"),
    "exact_border_best_case": ("exact border at the best positions of the balls", "rad/s"),
    "support_force": ("greatest vibrating force of a support at the end", "N"),
    "stalled_balls": ("balls that are stalled at the end", ""),
}
MEASURES = (
    "peak_deflection",
    "peak_speed",
    "vibration",
    "peak_without_balls",
    "vibration_without_balls",
    "settling_time",
    "break_away_speed",
)


Course = tuple[
    np.ndarray, np.ndarray, np.ndarray
]  # time (s), greatest deflection since then (m), speed (rad/s), (B,) each


def race_row(
    machine: Machine, run: xr.Dataset, held: xr.Dataset | None, bins: int
) -> tuple[dict[str, Any], Verdict | None, Course]:
    """Measures of a ``run`` with its envelope, in ``bins`` parts, and last revolutions; its verdict, and its course.

    The peak without balls is of the run with ``held`` balls.
    """
    recorded = recorded_of(run)
    row = {name: value for name, value in numbers(recorded).items() if name in MEASURES}
    row["beyond"] = [run.attrs[key] for key in ("drag_warning", "slipstream_warning") if run.attrs.get(key)]
    row |= zip((*BORDERS, "border_note"), _border(machine), strict=True)
    judged: Verdict | None = None
    with suppress(QuestionError):
        judged = verdict(run, held)
    return row, judged, (recorded.bins.time, recorded.bins.high, recorded.bins.speed)


def chamber_row(
    machine: ChamberMachine, run: xr.Dataset, held: xr.Dataset | None, bins: int
) -> tuple[dict[str, Any], Verdict | None, Course]:
    """The same of a ``machine`` with deep chambers."""
    judged, row = chamber_verdict(run, held=held), {"settling_time": float(chamber_measures(run)["settling_time"])}
    if judged.peak is not None:
        row |= {"peak_deflection": judged.peak.deflection, "peak_speed": judged.peak.speed}
    for place in judged.places:
        row |= {"vibration": place.vibration, "vibration_without_balls": place.without_balls}
    away, time, speed = np.abs(middle_deflection(run)), run["time"].values, run["speed"].values
    starts = np.linspace(0, time.size, min(bins, time.size), endpoint=False).astype(int)
    ends = np.append(starts[1:], time.size) - 1
    return row, judged, (0.5 * (time[starts] + time[ends]), np.maximum.reduceat(away, starts), speed[ends])


def _row(row: Mapping[str, Any], judged: Verdict | None, course: Course, speeds: Sequence[float]) -> dict[str, Any]:
    """All that a comparison keeps of a run: its measures, verdict and course, and the deflection at ``speeds`` (rad/s)."""
    unknown: dict[str, Any] = dict.fromkeys((*MEASURES, "support_force", *BORDERS), math.nan)
    whole = unknown | {"stalled_balls": 0, "beyond": [], "border_note": "", "verdict": NO_VERDICT, **row}
    if judged is not None:
        whole["stalled_balls"] = len(judged.stall.balls) if judged.stall is not None else 0
        forces = [support.vibrating for support in judged.supports]
        whole |= {"verdict": judged.word, "support_force": max(forces, default=math.nan)}
        if judged.peak_without_balls is not None:
            whole["peak_without_balls"] = judged.peak_without_balls.deflection
    _, high, speed = course
    return whole | {"course": course, "deflection_at": [_at(speed, high, wanted) for wanted in speeds]}


def _at(speed: np.ndarray, high: np.ndarray, wanted: float) -> float:
    """Greatest deflection in the later part of the first stay at this speed; nan if the rotor never has it."""
    near = np.flatnonzero(np.abs(speed - wanted) <= NEAR * abs(wanted))
    if not near.size:
        return math.nan
    stay = near[: np.argmax(np.diff(near, append=speed.size + 1) > 1) + 1]
    return float(high[stay[int(LATE * stay.size) :]].max())


def _border(machine: Machine) -> tuple[float, float, str]:
    """Speed of the exact border, that at the best positions of the balls, and its note."""
    try:
        border = borders(machine, only=(BORDER,))
    except QuestionError as refused:
        return math.nan, math.nan, f"border not known, {refused}"
    return (border[0].speed, border[0].best, border[0].note) if border else (math.nan, math.nan, "")
