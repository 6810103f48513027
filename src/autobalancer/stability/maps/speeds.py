"""The border speeds, each under its own name.

*averaged border*: where the averaged equations become stable (Spannan 2021, 4.74). *Exact border*: where the balanced
state of the full equations really does. *Release speed*: where balls that stall at the critical speed during a slow
run-up break away (Ryzhik et al. 2001; Spannan 2021, 4.73), and *capture speed*, the other end of its torque balance.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from autobalancer.assembly.terms import Theory, weightless
from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_races
from autobalancer.machine import Machine
from autobalancer.stability.averaged.border import POINTS
from autobalancer.stability.border import Border, Borders, ignoring
from autobalancer.stability.host.stations import Stations
from autobalancer.stability.maps.averaged import AVERAGED, averaged_of
from autobalancer.stability.maps.balanced_stations import equal_at_one_station
from autobalancer.stability.maps.exact import exact_borders, worst_case_of
from autobalancer.stability.stall.borders import release_of
from autobalancer.stability.stall.notes import CAPTURE, RELEASE
from autobalancer.stability.states.described import (
    Described,
    described,
)
from autobalancer.units import to_si, unbalance_argument

__all__ = ["Border", "borders", "borders_of"]


BUDGET = 150_000.0  # units of work for each border where nobody asked for it: 10 to 20 s
NOT_LOOKED_FOR = (
    "not looked for, with {} balls it takes long; 'autobalancer borders FILE' (ab.stability.borders) looks for it"
)
NAMES = (
    AVERAGED,
    "exact border, worst case",
    "exact border",
    "exact border, best case",
    "release speed",
    "capture speed",
)


def borders(
    machine: Machine | str | Path,
    unbalance: complex | float | str | None = None,
    *,
    only: Sequence[str] = (),
    up_to: float | str | None = None,
) -> Borders:
    """All border speeds of a machine.

    Parameters
    ----------
    machine
        A machine or the path of a machine file. On a horizontal axis its borders are those without gravity, as their notes say.
    unbalance
        kg m, complex for one off the zero mark; by default the largest of the machine over time.
    only
        Names of the borders that are wanted, such as ``("release speed", "capture speed")``, which are found much faster than
        the exact ones; by default all.
    up_to
        Rotor speed, rad/s or a string with a unit: release and capture speed are those of the resonances that a run-up to it
        passes. By default the highest speed that the drive prescribes if that is above a critical speed, else all count.
        Planar rotors have two resonances at most, and both count.

    Returns
    -------
    tuple of Border
        *averaged border*; *exact border, worst case* over all unbalances; *exact border* at this unbalance; for more
        than two balls also *exact border, best case*, since their positions matter and the exact border is that of the
        worst ones; *release speed* and, where balls stall and are released, *capture speed*. An empty note means that
        there is nothing to add. An infinite speed means never; for nan the note gives the reason.

    Raises
    ------
    QuestionError
        If the machine has no balls, the unbalance is no number, or a name in ``only`` is unknown.
    """
    unbalance = unbalance_argument(unbalance)
    machine = balls_in_races(machine)
    return Borders(borders_of(machine, described(weightless(machine), unbalance), only, speed_or_none(up_to)))


def speed_or_none(speed: float | str | None) -> float | None:
    """rad/s, above zero."""
    if speed is None:
        return None
    value = float(to_si(speed, "rad/s"))
    if not value > 0.0:
        raise QuestionError(f"up_to: given {speed!r}; must be greater than zero")
    return value


def borders_of(
    machine: Machine, p: Described, only: Sequence[str] = (), up_to: float | None = None, budget: float = math.inf
) -> tuple[Border, ...]:
    """The border speeds of a machine with its numbers, whose unbalance counts; all, or ``only`` some by their names.

    Those that would take more than the ``budget`` of :func:`work_of` are not looked for, and say so.
    """
    unknown = [name for name in only if name not in NAMES]
    if unknown:
        raise QuestionError(f"only: given {unknown[0]!r}; must be among {', '.join(repr(name) for name in NAMES)}")
    if p.moment.size == 0:
        raise QuestionError("border speeds: the machine has no balls")
    wanted = set(only or NAMES)
    skipped = [name for name in (AVERAGED, "exact border") if name in wanted and work_of(p, name) > budget]
    found = [Border(name, math.nan, NOT_LOOKED_FOR.format(p.moment.size), False) for name in skipped]
    wanted -= {*skipped, *(["exact border, best case"] if "exact border" in skipped else [])}
    if AVERAGED in wanted:
        found.append(averaged_of(p))
    if "exact border, worst case" in wanted:
        found.append(worst_case_of(p))
    if wanted & {"exact border", "exact border, best case"}:
        found += exact_borders(machine, p)
    if wanted & {RELEASE, CAPTURE}:
        found += release_of(machine, p, capture=CAPTURE in wanted, up_to=up_to)
    there = sorted(
        (border for border in found if border.name in wanted | {*skipped}), key=lambda one: NAMES.index(one.name)
    )
    return saying_what_is_ignored(machine, there)


def work_of(p: Described, name: str) -> float:
    """How much work a border is, in units of about a tenth of a millisecond; 0 of those that are quick."""
    count = p.moment.size
    if not isinstance(p, Stations):  # all arrangements of balls in races of several centers, at each speed
        _, balls = np.unique(p.offset, return_counts=True)
        return float(4 * POINTS * sum(2.0 ** (count - here) for here in balls)) if balls.size > 1 else 0.0
    if name == "exact border" and isinstance(p, Stations) and count > 2 and equal_at_one_station(p):
        return 40.0 * count**3  # the least and the greatest |S2| over what the balls have to add up to
    return 0.0


def theory_of(border: str) -> Theory:
    """Which theory a border is of, by its name."""
    return {RELEASE: Theory.STALLED, CAPTURE: Theory.STALLED, AVERAGED: Theory.AVERAGED}.get(border, Theory.AT_REST)


def saying_what_is_ignored(machine: Machine, borders: Sequence[Border]) -> tuple[Border, ...]:
    """Borders whose notes name what the theory of each leaves out of this machine."""
    return tuple(ignoring(machine, border, theory_of(border.name)) for border in borders)
