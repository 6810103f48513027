"""Runs of deep chambers that are kept in an archive while they are computed, and go on after a stop."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.files.given import balls_in_chambers
from autobalancer.files.machine_file import machine_text
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.results.archive.folder import Archive
from autobalancer.results.archive.run import RunFolder
from autobalancer.results.chamber.measures import catalog_numbers, chamber_measures
from autobalancer.results.chamber.recorded import READ
from autobalancer.simulation.chamber import simulate_chamber
from autobalancer.units import argument, optional_argument

PART = 1000  # samples
LAST = "measured_last"  # entry of a note: the window of its measures, s


def archived_run(
    archive: Archive,
    name: str,
    machine: ChamberMachine | str | Path,
    *,
    duration: float | str,
    parameters: Mapping[str, Any] | None = None,
    step: float | str | None = None,
    sample: float | str = 1e-3,
    method: str = "verlet",
    seed: int = 0,
    last: float | str | None = None,
    part: int = PART,
    progress: Callable[[float, float], Any] | None = None,
) -> RunFolder:
    """Run a machine into an archive. The same call after a stop, a crash or a full disk continues where the archive ends.

    Samples are written to disk in parts, so memory use does not grow with the length of the run. A finished run
    is not computed again.

    Parameters
    ----------
    archive, name
        The archive in which the run is stored, and its name.
    machine
        With chambers.
    duration, step, sample, method, seed
        As for ``simulate_chamber``, in s.
    parameters
        Names and values by which the run is found in the catalogue; number of balls, friction, restitution and seed are
        always included.
    last
        Seconds at the end that count as steady state in the measures. If it changes, a finished run is measured again.
    part
        Samples in a part, which is also how much is computed again after a stop.
    progress
        Called with (time, duration).

    Returns
    -------
    RunFolder
        With ``samples()``.

    Raises
    ------
    QuestionError
        If the archive has a run of this name with other settings, or the run is too short for its measures.
    ResultError
        If the disk is full; what was written is kept. If another process writes the run; the message names it.
    """
    duration = argument("duration", duration, "s")
    step = optional_argument("step", step, "s")
    sample = argument("sample", sample, "s")
    last = optional_argument("last", last, "s")
    machine = balls_in_chambers(machine)
    refuse_unmeasurable(duration, sample, last)
    told = {**standard_parameters(machine), "seed": seed, **(parameters or {})}
    question = {"duration": duration, "step": step, "sample": sample, "method": method, "seed": seed, "part": part}
    run = archive.start(name, machine_text(machine), told, question)
    if run.state == "finished" and run.note.get(LAST, "") == last:
        return run
    with run.writing():
        if run.state != "finished":  # another process may have ended it by now
            _go_on(run, machine, question, last, progress)
        elif run.note.get(LAST, "") != last:  # measured over another time, or by a version that did not note it
            _measured(run, last)
    return run


def refuse_unmeasurable(duration: float, sample: float, last: float | None) -> None:
    """Refuse, before it begins, a run that is too short for its measures.

    Raises
    ------
    QuestionError
        If it has fewer than two samples, or ``last`` is not within it.
    """
    if not duration >= sample * (1.0 - 1e-9):
        raise QuestionError(
            f"duration: given {duration:g} s; a run to measure must be {sample:g} s or longer, one sample"
        )
    if last is not None and not 0.0 < last <= duration * (1.0 + 1e-9):
        raise QuestionError(f"last: given {last:g} s; must be above zero and within the {duration:g} s of a run")


def measured_run(
    archive: Archive | None,
    name: str,
    machine: ChamberMachine,
    parameters: Mapping[str, Any],
    *,
    last: float | None,
    progress: Callable[[float, float], Any] | None = None,
    **question: Any,
) -> dict[str, Any]:
    """Outcome and measures of a run by name, as single numbers, from the archive if there is one.

    ``question`` has duration, step, sample and seed, as for :func:`archived_run`. A run that did not finish has no measures.
    """
    if archive is not None:
        run = archived_run(archive, name, machine, parameters=parameters, last=last, progress=progress, **question)
        return {"outcome": run.note.get("outcome", {}).get("outcome", run.state), **run.note.get("measures", {})}
    ended = simulate_chamber(machine, progress=progress, **question)
    outcome = str(ended.attrs["outcome"])
    if outcome != "finished":
        return {"outcome": outcome}
    return {"outcome": outcome, **catalog_numbers(chamber_measures(ended, last=last))}


def _go_on(
    run: RunFolder,
    machine: ChamberMachine,
    question: Mapping[str, Any],
    last: float | None,
    progress: Callable[[float, float], Any] | None,
) -> None:
    checkpoint = run.checkpoint()
    run.end("running")
    asked = {key: value for key, value in question.items() if key != "part"}
    try:
        ended = simulate_chamber(
            machine,
            **asked,
            resume=checkpoint,
            on_chunk=run.append,
            keep=False,
            chunk=question["part"],
            progress=progress,
        )
    except KeyboardInterrupt:
        run.end("interrupted")
        raise
    except AutobalancerError as reason:
        _note_failure(run, reason)
        raise
    outcome = {key: ended.attrs[key] for key in ("outcome", "outcome_text") if key in ended.attrs}
    state = "finished" if outcome.get("outcome") == "finished" else "failed"
    if state == "finished":
        _measured(run, last, outcome)
    else:
        run.end(state, outcome, {})


def _measured(run: RunFolder, last: float | None, outcome: Mapping[str, Any] | None = None) -> None:
    found = catalog_numbers(chamber_measures(run.samples(READ), last=last))
    run.note[LAST] = last
    run.end("finished", outcome, found)


def standard_parameters(machine: ChamberMachine) -> dict[str, Any]:
    """What is always in the catalogue."""
    groups = [balls for chamber in machine.chambers for balls in chamber.balls]
    return {
        "machine_name": machine.name,
        "balls": sum(group.count for group in groups),
        "ball_mass_total": sum(group.count * group.ball_mass for group in groups),
        "body": groups[0].body,
        "ball_diameter": 2.0 * groups[0].radius,
        "depth": machine.chambers[0].inner_depth,
        "friction": float(machine.contact.friction),
        "restitution": float(machine.contact.restitution),
        "freedom": machine.body.freedom,
    }


def _note_failure(run: RunFolder, reason: AutobalancerError) -> None:
    """On a full disk even the note may fail; the error that is raised says it all."""
    try:
        run.end("failed", {"outcome": "failed", "outcome_text": str(reason)})
    except AutobalancerError:
        return
