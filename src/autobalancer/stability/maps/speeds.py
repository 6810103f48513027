"""The border speeds, each under its own name.

*averaged border*: where the averaged equations become stable (Spannan 2021, 4.74). *Exact border*: where the balanced
state of the full equations really does. *Release speed*: where balls that stall at the critical speed during a slow
run-up break away (Ryzhik et al. 2001; Spannan 2021, 4.73), and *capture speed*, the other end of its torque balance.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from autobalancer.assembly.terms import Theory, weightless
from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import balls_in_races
from autobalancer.machine import Machine
from autobalancer.progress import OutOfTime, question
from autobalancer.stability.averaged import (
    averaged_station_growth,
    averaged_station_growths,
    explicit_averaged_border,
    refuse_without_drag,
)
from autobalancer.stability.border import Border, Borders, ignoring
from autobalancer.stability.host.stations import Floats, Plane, Stations, as_station
from autobalancer.stability.maps.balanced import Balanced, members_of
from autobalancer.stability.maps.exact import border_of, exact_borders, worst_case_of
from autobalancer.stability.stall.borders import release_of
from autobalancer.stability.stall.capture import CAPTURE, RELEASE
from autobalancer.stability.states.stations import Described, StationState, described
from autobalancer.units import to_si, unbalance_argument

# The averaged border of any machine: of planar rotors in closed form where there is one, of others over the speed.


AVERAGED = "averaged border"
AVERAGED_WORST_CASE = "averaged border, worst case"
SPREADS = (0.0, 0.5, 1.0)  # between the least and the greatest |g2| at which the worst case is looked for


def averaged_border(
    machine: Machine | str | Path,
    unbalance: complex | float | str | None = None,
    *,
    worst_case: bool = False,
    searched: tuple[float, float] | None = None,
) -> Border:
    """Averaged border from the averaged eigenvalue problem; on planar rotors Spannan (2021), (4.69), by root finding.

    Parameters
    ----------
    machine
        A machine or the path of its file; any rotor.
    unbalance
        kg m, or a text such as ``"594 g*mm"``; by default that of the machine. On rotors that tilt or bend it replaces the
        machine's unbalance if there is only one.
    worst_case
        Take the ball positions with the highest border instead of those that balance the unbalance. Needs races on the
        axis of the rotor, in one plane.
    searched
        Speeds, rad/s: the border is the lowest speed in this range from which on the state is stable up to its end. By
        default from the lowest critical speed to 40 times the critical speed, or to the end of the tables of the supports.

    Returns
    -------
    Border
        Infinite if the state is unstable at the end of the range, nan if there is no balanced state.

    Raises
    ------
    QuestionError
        If a ball has no drag or forces act on it, or the worst case is asked of an eccentric race or several planes.
    """
    machine = balls_in_races(machine)
    p = described(machine, unbalance_argument(unbalance), None if searched is None else searched[1])
    if p.forces is not None:
        raise QuestionError(
            "averaged border: the averaged theory does not know forces on the balls; ask borders for the exact border"
        )
    return ignoring(machine, averaged_border_of(p, worst_case, searched), Theory.AVERAGED)


def averaged_of(p: Described) -> Border:
    """*averaged border* as :func:`autobalancer.stability.borders` has it.

    With races on the axis in one plane that of the worst case over the unbalance: of planar rotors by the closed form, (4.74)
    generalized to any balls and to orthotropic supports, of others by root finding. Else that at this unbalance.
    """
    if p.forces is not None:
        return Border(AVERAGED, math.nan, "computed without forces on the balls only; see the exact border", False)
    if p.moment.size == 1:
        return Border(AVERAGED, math.nan, "one ball alone can balance one unbalance only")
    if not (p.drag > 0.0).all():
        return Border(AVERAGED, math.inf, "a ball has no drag")
    if max(p.damping) == 0.0:
        return Border(AVERAGED, math.inf, "the rotor has no damping")
    if isinstance(p, Plane) and not np.any(p.offset):
        return replace(explicit_averaged_border(p), name=AVERAGED)
    st = as_station(p)
    return replace(averaged_border_of(st, worst_case=_one_centric(st)), name=AVERAGED)


def averaged_border_of(p: Described, worst_case: bool, searched: tuple[float, float] | None = None) -> Border:
    """Averaged border by root finding, (4.69) of Spannan (2021) for any rotor."""
    st = as_station(p)
    refuse_without_drag(st.drag)
    if worst_case and not _one_centric(st):
        raise QuestionError(
            "averaged border: the worst case over the unbalance needs races on the axis of the rotor, in one plane; leave out "
            "worst_case for the border at the unbalance of the machine"
        )
    st = replace(st, slopes=None)
    low, high = searched or (st.scale_speed, p.highest_searched)
    members = _any_unbalance(st) if worst_case else members_of(st, averaged_station_growth)
    found = [border_of(member, st, high, low) for member in members]
    found = [one for one in found if not math.isnan(one[0])] or found[:1]
    speed, note = max(found, key=lambda one: one[0])
    where = "worst case over the unbalance" if worst_case else "at this unbalance"
    if not worst_case and len(found) > 1:
        where += f", worst of {len(found)} positions of the balls"
    text = "; ".join(filter(None, (f"{where}, from the averaged eigenvalue problem", note)))
    return Border(AVERAGED_WORST_CASE if worst_case else AVERAGED, speed, text)


def _one_centric(st: Stations) -> bool:
    return len(st.names) == 1 and not np.any(st.offset)


def _any_unbalance(st: Stations) -> list[Balanced]:
    """Two equal balls with the same g = sum s^2/beta, and |g2| from the least that the balls can make up to g."""
    weight: Floats = st.moment**2 / st.drag
    g = float(weight.sum())
    least = max(0.0, 2.0 * float(weight.max()) / g - 1.0)
    two = {name: getattr(st, name)[[0, 0]] for name in ("ball_mass", "inertia", "station", "race", "offset")}
    alike = replace(st, moment=np.full(2, math.sqrt(0.5 * g)), drag=np.ones(2), **two)
    return [_AnyUnbalance(alike, least + (1.0 - least) * share) for share in SPREADS]


@dataclass(frozen=True)
class _AnyUnbalance:
    """Two equal balls in a race on the axis with this |g2|/g."""

    stations: Stations
    share: float
    route: str = "eigenvalues"

    def rates(self, speeds: Floats) -> Floats:
        """Averaged growth rates, 1/s."""
        angle = 0.5 * math.acos(min(self.share, 1.0))
        state = StationState("balanced", np.array([angle, -angle]), np.zeros(1, np.complex128), 0, 0)
        return averaged_station_growths(self.stations, speeds, state)


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
