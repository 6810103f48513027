"""How far a machine goes on its way up, and down again: the envelopes of many members as percentiles over the time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, cast

import numpy as np
import xarray as xr

from autobalancer.assembly.profile import corners
from autobalancer.assembly.quantities import with_value_at
from autobalancer.errors import AutobalancerError, QuestionError, unwarned
from autobalancer.files.text import read_toml
from autobalancer.machine import Hill, Machine, PrescribedSpeed
from autobalancer.progress import shows_progress
from autobalancer.results.answers.answer import Labeled
from autobalancer.results.provenance import provenance
from autobalancer.simulation.record import Envelope
from autobalancer.simulation.run import simulate_races
from autobalancer.studies.ensemble.members import Members, without_start_angles
from autobalancer.studies.in_threads import in_threads
from autobalancer.studies.study.reading import read_study
from autobalancer.studies.study.spec import Study

LEVEL = "below_"
PERCENT = (5.0, 25.0, 50.0, 75.0, 95.0, 100.0)


@shows_progress
def envelopes(
    given: str | Path | Mapping[str, Any] | Machine,
    *,
    members: int = 100,
    point: int = 1,
    coast_down: bool = False,
    bins: int = 400,
    seed: int = 0,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Labeled:
    """Percentiles of the deflection over the time of many runs of one machine.

    Parameters
    ----------
    given
        A study, as for :func:`autobalancer.study`, of which the first draws count; or a machine, which runs from random starts.
    members
        How many runs.
    point
        Of the grid of a study.
    coast_down
        Whether the rotor comes down again after its run, as fast as it went up.
    bins
        Intervals of time.
    seed
        For the starts of a machine; a study has its own.
    workers
        Threads; the result does not depend on it.
    progress
        Called with (runs done, runs in all).

    Returns
    -------
    xarray.Dataset
        Over ``time``: ``below_5`` to ``below_100``, deflection in each interval of time below which so many percent are;
        ``speed`` of the rotor.

    Raises
    ------
    QuestionError
        If there is no such point; if an unbalance appears; for ``coast_down`` of a drive by a torque or along an S-shaped run-up.
    """
    study = read_study({"machine": given, "seed": seed} if _is_machine(given) else cast(Any, given))
    if study.sudden is not None:
        raise QuestionError("envelopes: an unbalance that appears joins two runs; give a study of whole runs")
    if not 1 <= point <= len(study.points):
        raise QuestionError(f"envelopes: point: given {point}; the grid has 1 to {len(study.points)}")
    count = min(members, study.draws)
    if count < 2:
        raise QuestionError(f"envelopes: members: given {members}; give at least 2")
    jobs, duration = _members(study, count, point - 1, coast_down)
    runs = in_threads(lambda job: _envelope(*job, duration, study.tolerance, bins), jobs, workers, progress)
    high = np.array([run[0] for run in runs if run is not None])
    if high.shape[0] < 2:
        raise QuestionError("envelopes: fewer than two of the members can run")
    _, time, speed = next(run for run in runs if run is not None)
    found = xr.Dataset(
        {
            **{
                f"{LEVEL}{percent:g}": (
                    "time",
                    values,
                    {"units": "m", "long_name": f"deflection of {percent:g} % of the runs"},
                )
                for percent, values in zip(PERCENT, np.nanpercentile(high, PERCENT, axis=0), strict=True)
            },
            "speed": ("time", speed, {"units": "rad/s", "long_name": "rotor speed"}),
        },
        {"time": ("time", time, {"units": "s", "long_name": "time"})},
        {
            "title": f"Envelopes of {high.shape[0]} runs of {study.machine.name}",
            **provenance(),
            "machine_name": study.machine.name,
            "members": high.shape[0],
            "greatest": float(np.nanmax(high)),
        },
    )
    return Labeled.of(found)


def _is_machine(given: Any) -> bool:
    """Whether it is a machine, or the path of its file: that has a rotor, a study has none."""
    if not isinstance(given, (str, Path)):
        return isinstance(given, Machine)
    try:
        return "rotor" in read_toml(Path(given))
    except QuestionError:
        return False  # whoever reads it says what is wrong


def _members(study: Study, count: int, point: int, coast_down: bool) -> tuple[list[tuple[Machine, int]], float]:
    """Machines with their seeds, and how long they run."""
    machine = without_start_angles(study.machine) if study.random_starts else study.machine
    columns = study.columns(0, count * len(study.points), {})
    members = Members(machine, columns, None, study.seed, "")
    found, duration = [], study.duration
    for draw in range(count):
        number = draw * len(study.points) + point
        try:
            one = members.machine_of(number)
            if coast_down:
                one, duration = _there_and_back(one, study.duration)
        except QuestionError:
            raise
        except AutobalancerError:
            continue
        found.append((one, int(members.seeds[number])))
    return found, duration


def _there_and_back(machine: Machine, duration: float) -> tuple[Machine, float]:
    """The machine whose speed follows its profile, and then the same backwards."""
    drive = machine.drive
    if not isinstance(drive, PrescribedSpeed) or isinstance(drive.profile, Hill):
        raise QuestionError("envelopes: coast_down: the drive must prescribe the speed, by straight pieces")
    up = [(time, speed) for time, speed in corners(drive.profile) if time < duration]
    up = [*([(0.0, up[0][1])] if up[0][0] > 0.0 else []), *up, (duration, up[-1][1])]
    whole = [*up, *((2.0 * duration - time, speed) for time, speed in up[-2::-1])]
    table = {"kind": "table", "time": [time for time, _ in whole], "speed": [speed for _, speed in whole]}
    return with_value_at(machine, "drive.profile", table), 2.0 * duration


def _envelope(machine: Machine, seed: int, duration: float, tolerance: float, bins: int) -> tuple[Any, Any, Any] | None:
    try:
        with unwarned():  # of each run the same
            run = simulate_races(machine, duration=duration, seed=seed, tolerance=tolerance, save=[Envelope(bins)])
    except AutobalancerError:
        return None
    high = np.full(bins, np.nan)
    high[: run.sizes["bin"]] = run["envelope_high"].values
    if run.sizes["bin"] < bins:
        return None
    return high, run["envelope_time"].values, run["envelope_speed"].values
