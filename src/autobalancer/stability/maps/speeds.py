"""The border speeds, each under its own name.

*averaged border*: where the averaged equations become stable (Spannan 2021, 4.74). *Exact border*: where the balanced
state of the full equations really does. *Release speed*: where balls that stall at the critical speed during a slow
run-up break away (Ryzhik et al. 2001; Spannan 2021, 4.73), and *capture speed*, the other end of its torque balance.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path

from autobalancer.assembly.terms import Theory, weightless
from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_races
from autobalancer.machine import Machine
from autobalancer.patience import OutOfTime, question
from autobalancer.stability.border import Border, Borders, ignoring
from autobalancer.stability.maps.averaged import AVERAGED, averaged_of
from autobalancer.stability.maps.exact import exact_borders, worst_case_of
from autobalancer.stability.stall.borders import release_of
from autobalancer.stability.stall.notes import CAPTURE, RELEASE
from autobalancer.stability.states.described import (
    Described,
    described,
)
from autobalancer.units import to_si, unbalance_argument

__all__ = ["Border", "borders", "borders_of"]


BUDGET = 10.0  # s of computing for each question where nobody asked for it
NOT_FOUND = "not found in {:g} s of computing; {} looks as long as it takes"
WORST_CASE = "exact border, worst case"
NAMES = (
    AVERAGED,
    WORST_CASE,
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
    machine: Machine,
    p: Described,
    only: Sequence[str] = (),
    up_to: float | None = None,
    seconds: float = math.inf,
    say: Callable[[str], None] | None = None,
) -> tuple[Border, ...]:
    """The border speeds of a machine with its numbers, whose unbalance counts; all, or ``only`` some by their names.

    Those that take more than some ``seconds`` of computing are left out, and say so; ``say`` is told what takes over one.
    """
    unknown = [name for name in only if name not in NAMES]
    if unknown:
        raise QuestionError(f"only: given {unknown[0]!r}; must be among {', '.join(repr(name) for name in NAMES)}")
    if p.moment.size == 0:
        raise QuestionError("border speeds: the machine has no balls")
    wanted = set(only or NAMES)
    asked: list[tuple[set[str], Callable[[], Sequence[Border]]]] = [
        ({AVERAGED}, lambda: [averaged_of(p)]),
        ({WORST_CASE}, lambda: [worst_case_of(p)]),
        ({"exact border", "exact border, best case"}, lambda: exact_borders(machine, p)),
        ({RELEASE, CAPTURE}, lambda: release_of(machine, p, capture=CAPTURE in wanted, up_to=up_to)),
    ]
    found: list[Border] = []
    for names, answer in asked:
        which = sorted(names & wanted, key=NAMES.index)
        if not which:
            continue
        try:
            with question(f"the {' and '.join(which)}", seconds, say):
                found += answer()
        except OutOfTime:
            note = NOT_FOUND.format(seconds, "'autobalancer borders FILE' (ab.stability.borders)")
            found += [Border(name, math.nan, note, False) for name in which]
    return saying_what_is_ignored(machine, [border for border in found if border.name in wanted])


def theory_of(border: str) -> Theory:
    """Which theory a border is of, by its name."""
    return {RELEASE: Theory.STALLED, CAPTURE: Theory.STALLED, AVERAGED: Theory.AVERAGED}.get(border, Theory.AT_REST)


def saying_what_is_ignored(machine: Machine, borders: Sequence[Border]) -> tuple[Border, ...]:
    """Borders whose notes name what the theory of each leaves out of this machine."""
    return tuple(ignoring(machine, border, theory_of(border.name)) for border in borders)
