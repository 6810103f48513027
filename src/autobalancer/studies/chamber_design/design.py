"""The designs of a deep chamber that balance best within limits (Pakuła 2021, section 5, asks for them)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_chambers
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.patience import shows_progress
from autobalancer.results.archive.folder import Archive
from autobalancer.studies.chamber_design.candidate import candidates as all_candidates
from autobalancer.studies.chamber_design.dataset import designs_dataset
from autobalancer.studies.chamber_design.limits import read_limits
from autobalancer.studies.chamber_design.screening import Question, bounded, screened
from autobalancer.units import argument, optional_argument
from autobalancer.units.arguments import list_argument
from autobalancer.units.ranges import listed


@shows_progress
def design(
    machine: ChamberMachine | str | Path,
    candidates: Mapping[str, Any],
    limits: Mapping[str, Any] | None = None,
    *,
    duration: float | str,
    short: float | str | None = None,
    last: float | str | None = None,
    unbalances: Sequence[float | str] | str | None = None,
    fillings: int = 5,
    finalists: int = 4,
    archive: Archive | str | Path | None = None,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Find the balls, the friction and the fluid with which a deep chamber balances best.

    Three stages. Closed forms rule out what cannot be good (:func:`bounds`). Short runs, of one filling at first, halve what is
    left again and again and double the fillings. Full runs with all fillings judge the few best.

    Parameters
    ----------
    machine
        With one deep chamber and one group of balls. Chamber, rotor, body and drive stay as they are.
    candidates
        What there is to choose from, all combinations of it: ``balls`` (numbers), ``diameter`` or ``total_mass``, ``density``,
        ``friction``, ``ball_friction`` (of balls on balls), ``viscosity`` (dynamic, 0 for a dry chamber) with
        ``fluid_density`` and ``fill`` (share of the chamber). What is missing stays as in the machine.
    limits
        Most values that any filling may reach, of ``vibration``, ``synchronous`` (what of it turns with the rotor),
        ``residual_unbalance``, ``settling_time``, ``run_up_peak``, ``bearing_force``, ``contact_force`` and
        ``contact_pressure``; and ``pick_up``, the least share of the runs in which all balls go around.
    duration, short
        Of the full and of the short runs, s; short ones by default half as long. Balls may be carried up late.
    last
        Seconds at the end that are the steady state; by default a tenth of ``duration``.
    unbalances
        Sizes for which a design must work, kg m; by default that of the machine. The worst one counts.
    fillings
        Of each full run: seeds 0, 1, ...
    finalists
        Designs that get full runs.
    archive
        Folder that keeps all runs. With it a search that was stopped goes on, and finished runs are not repeated.
    workers
        Threads; the answer does not depend on it.
    progress
        Called with (runs done, runs in all).

    Returns
    -------
    xarray.Dataset
        Over ``design``: what it is, its bounds, ``stage`` and ``reason``, means, intervals and worst values of the full runs,
        whether it ``meets`` the limits, and its place; over ``design``, ``unbalance`` and ``seed`` the numbers of every full run.

    Raises
    ------
    QuestionError
        For names, numbers or ranges that make no sense, or if closed forms rule out every design; the message says why.
    """
    machine, duration = balls_in_chambers(machine), argument("duration", duration, "s")
    short = optional_argument("short", short, "s")
    last = optional_argument("last", last, "s")
    for name, value in (("duration", duration), ("short", short), ("last", last)):
        if value is not None and not value > 0.0:
            raise QuestionError(f"{name}: given {value:g} s; must be above zero")
    short, last = 0.5 * duration if short is None else short, 0.1 * duration if last is None else last
    if short > duration or last > duration:
        raise QuestionError(f"short, last: given {short:g} s and {last:g} s; a full run lasts {duration:g} s only")
    for name, count in (("fillings", fillings), ("finalists", finalists)):
        if count < 1:
            raise QuestionError(f"{name}: given {count}; must be at least 1")
    if machine.body.freedom == "fixed":
        raise QuestionError("machine: its body is fixed, so the balls do not feel the unbalance; free it")
    sizes = _unbalances(machine, unbalances)
    kept = archive if isinstance(archive, Archive) or archive is None else Archive(archive)
    asked = Question(sizes, duration, short, last, fillings, finalists, kept, workers, progress)
    told = read_limits(limits)
    if "contact_pressure" in told and machine.contact.youngs_modulus is None:
        raise QuestionError("limits: contact_pressure: needs the material of the balls; give contact.youngs_modulus")
    designs = bounded(machine, all_candidates(machine, candidates), told, asked)
    if all(one.reason for one in designs):
        raise QuestionError(_none_left(designs))
    screened(designs, asked)
    return designs_dataset(machine, designs, told, asked)


def _unbalances(machine: ChamberMachine, given: Sequence[float | str] | str | None) -> tuple[float, ...]:
    own = float(abs(sum(part.vector for part in machine.unbalances)))
    if not own > 0.0:
        raise QuestionError(
            "machine: its rotor has no unbalance to balance; give unbalances, with their sizes here if you like"
        )
    if given is None:
        return (own,)
    listing = isinstance(given, str) and "," in given
    sizes = listed("unbalances", str(given), "kg*m") if listing else list_argument("unbalances", given, "kg*m")
    if not sizes or any(not size > 0.0 for size in sizes):
        raise QuestionError(f"unbalances: given {given!r}; must be above zero")
    return tuple(sorted(set(sizes)))


def _none_left(designs: Sequence[Any]) -> str:
    """How many designs each reason rules out; texts that differ in their numbers only count as one."""
    counts: dict[str, list[str]] = {}
    for one in designs:
        for reason in one.reason.split("; "):
            kind = " ".join(word for word in reason.split() if not any(sign.isdigit() for sign in word))
            counts.setdefault(kind, []).append(f"{one.candidate.label}: {reason}")
    lines = [f"{len(texts)} of {len(designs)}, such as {texts[0]}" for texts in counts.values()]
    return f"candidates: closed forms rule out every design. {'. '.join(lines)}. Take other candidates, or wider limits"
