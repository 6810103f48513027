"""The border speeds, each under its own name.

*averaged border*: where the averaged equations become stable (Spannan 2021, 4.74). *Exact border*: where the balanced
state of the full equations really does. *Release speed*: where balls that stall at the critical speed during a slow
run-up break away (Ryzhik et al. 2001; Spannan 2021, 4.73), and *capture speed*, the other end of its torque balance.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import load_machine
from autobalancer.machine import Machine
from autobalancer.stability.averaged.border import averaged_border
from autobalancer.stability.averaged.formulas import explicit_averaged_border
from autobalancer.stability.border import Border, Borders
from autobalancer.stability.host.planar import Floats, Plane
from autobalancer.stability.host.stations import Stations
from autobalancer.stability.ignored import ignored_at_rest, ignored_by_stalled, without
from autobalancer.stability.maps.balanced import (
    Balanced,
    EqualBalls,
    balanced_states,
    equal_balls,
    planar_balancer_of,
)
from autobalancer.stability.maps.balanced_stations import EqualAtOneStation, equal_at_one_station
from autobalancer.stability.maps.characteristic import PlanarBalancer, growth_rates, worst_case_border
from autobalancer.stability.maps.windows import windows_of
from autobalancer.stability.stall.borders import release_of
from autobalancer.stability.stall.notes import CAPTURE, RELEASE
from autobalancer.stability.states.described import (
    SEARCHED,
    Described,
    described,
    highest_searched,
    lower_critical_speed,
)
from autobalancer.stability.states.why_never import why_never
from autobalancer.units import to_si, unbalance_argument

__all__ = ["Border", "border_speeds", "borders_of"]

SPREADS = (0.0, 0.01, 0.05, 0.2, 0.5, 0.8, 0.95, 1.0)  # |S2|/N at which the worst case is looked for


NAMES = (
    "averaged border",
    "exact border, worst case",
    "exact border",
    "exact border, best case",
    "release speed",
    "capture speed",
)


def border_speeds(
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
        A machine or the path of a machine file: any machine without gravity in its plane.
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
        there is nothing to add. An infinite speed means never; for nan the note gives the reason. The averaged
        border is for planar rotors only, the others for any rotor.

    Raises
    ------
    QuestionError
        If the machine has no balls, gravity acts in its plane, the unbalance is no number, or a name in ``only`` is
        unknown.
    """
    unbalance = unbalance_argument(unbalance)
    if not isinstance(machine, Machine):
        machine = load_machine(machine)
    return Borders(borders_of(machine, described(machine, unbalance), only, speed_or_none(up_to)))


def speed_or_none(speed: float | str | None) -> float | None:
    """rad/s, above zero."""
    if speed is None:
        return None
    value = float(to_si(speed, "rad/s"))
    if not value > 0.0:
        raise QuestionError(f"up_to: given {speed!r}; must be greater than zero")
    return value


def borders_of(
    machine: Machine, p: Described, only: Sequence[str] = (), up_to: float | None = None
) -> tuple[Border, ...]:
    """The border speeds of a machine with its numbers, whose unbalance counts; all, or ``only`` some by their names."""
    unknown = [name for name in only if name not in NAMES]
    if unknown:
        raise QuestionError(f"only: given {unknown[0]!r}; must be among {', '.join(repr(name) for name in NAMES)}")
    if p.moment.size == 0:
        raise QuestionError("border speeds: the machine has no balls")
    wanted = set(only or NAMES)
    found: list[Border] = []
    if "averaged border" in wanted and not isinstance(p, Stations):
        found.append(averaged(p))
    if "exact border, worst case" in wanted:
        found.append(worst_case_of(p))
    if wanted & {"exact border", "exact border, best case"}:
        found += exact(machine, p)
    if wanted & {RELEASE, CAPTURE}:
        found += release_of(machine, p, capture=CAPTURE in wanted, up_to=up_to)
    return saying_what_is_ignored(machine, [border for border in found if border.name in wanted])


def saying_what_is_ignored(machine: Machine, borders: Sequence[Border]) -> tuple[Border, ...]:
    """Borders whose notes name what their theory leaves out of this machine; one that is not known leaves out nothing."""
    at_rest, stalled = without(ignored_at_rest(machine)), without(ignored_by_stalled(machine))
    found = []
    for border in borders:
        ignored = stalled if border.name in (RELEASE, CAPTURE) else at_rest
        says = ignored and not math.isnan(border.speed)
        found.append(replace(border, note="; ".join(filter(None, (border.note, ignored)))) if says else border)
    return tuple(found)


def averaged(p: Plane) -> Border:
    """*averaged border*: (4.74), generalized to any balls on the axis; elsewhere the averaged eigenvalue problem."""
    name = "averaged border"
    if p.moment.size == 1:
        return Border(name, math.nan, "one ball alone can balance one unbalance only")
    if not (p.drag > 0.0).all():
        return Border(name, math.inf, "never: a ball has no drag")
    if p.isotropic and p.damping[0] == 0.0:
        return Border(name, math.inf, "never: the rotor has no damping")
    if p.isotropic and np.all(p.offset == 0.0):
        found = explicit_averaged_border(p)
        return Border(name, found.speed, found.note)
    found = averaged_border(p)
    note = found.note or "at this unbalance, from the averaged eigenvalue problem (Spannan 2021, 4.69)"
    return Border(name, found.speed, note)


def exact(machine: Machine, p: Described) -> list[Border]:
    """*exact border*, and *exact border, best case* where the positions of the balls are a continuum."""
    members = balanced_states(p)
    found = [border_of(member, p) for member in members]
    if any(not math.isnan(speed) for speed, _ in found):  # positions that exist only at some speeds do not count
        found = [one for one in found if not math.isnan(one[0])]
    if isinstance(p, Stations) and all(math.isinf(speed) for speed, _ in found):
        because = why_never(machine, p, highest_searched(p))
        found = [(speed, "; ".join(filter(None, (because, note)))) for speed, note in found]
    elif isinstance(p, Plane) and abs(p.unbalance) > p.capability * (1.0 + 1e-9):
        short = (
            f"side by side the balls can balance {p.capability * 1e6:.4g} g mm only: here they would have to overlap"
        )
        found = [
            (speed, "; ".join(filter(None, (short, note)))) for speed, note in found if not math.isnan(speed)
        ] or found
    low, high = min(found, key=_rank), max(found, key=_rank)
    if len(members) == 1:
        return [Border("exact border", *found[0])]
    which = f"worst of {len(found)} positions of the balls, {_range(members)}best {_say(low[0])}"
    return [
        Border("exact border", high[0], "; ".join(filter(None, (which, high[1])))),
        Border("exact border, best case", low[0], "; ".join(filter(None, ("best of these positions", low[1])))),
    ]


def border_of(state: Balanced, p: Described, highest: float | None = None) -> tuple[float, str]:
    """Lowest speed from which on a state is stable up to the highest one that is searched, and a note."""
    critical = lower_critical_speed(p)
    high = highest_searched(p) if highest is None else highest
    windows, note = windows_of(state, critical, high, p)
    rotor = (float(np.abs(p.model.damping).max()),) if isinstance(p, Stations) else p.damping
    undamped = [name for name, values in (("rotor", rotor), ("balls", p.drag)) if not np.all(np.asarray(values) > 0.0)]
    if undamped and not windows:
        note = f"{note}; {' and '.join(undamped)} without damping"
    if not windows and note.startswith("no balanced state"):
        return math.nan, note
    if not windows or windows[-1][1] < high:
        tail = (
            f"none up to {SEARCHED:g} times the critical speed"
            if highest is None and not isinstance(p, Stations)
            else f"none up to {high:.4g} rad/s"
        )
        if windows and isinstance(p, Stations):
            tail = f"{tail}, stable {', '.join(f'{a:.4g} to {b:.4g} rad/s' for a, b in windows)}"
        return math.inf, "; ".join(filter(None, (tail, note)))
    below = f"stable also {', '.join(f'{a:.4g} to {b:.4g} rad/s' for a, b in windows[:-1])}" if windows[1:] else ""
    return windows[-1][0], "; ".join(filter(None, (below, note)))


def worst_case_of(p: Described) -> Border:
    """*exact border, worst case* of any rotor."""
    return worst_case_at_one_station(p) if isinstance(p, Stations) else worst_case(p)


def worst_case(p: Plane) -> Border:
    """*exact border, worst case*: the highest one for any unbalance from zero to capability, equal balls only.

    Over these unbalances |S2| takes all values from 0 to N. Zero, where the two ball modes have one frequency, is the
    worst for a well damped rotor and has an explicit border; where the rotor is damped lightly balls in line may be.
    """
    name = "exact border, worst case"
    if not equal_balls(p):
        return Border(
            name, math.nan, "computed for equal balls on isotropic supports only; see the exact border", False
        )
    if np.any(p.offset != 0.0):
        return Border(name, math.nan, "computed for races on the axis only; see the exact border", False)
    balancer = planar_balancer_of(p)
    if balancer.damping == 0.0 or balancer.drag == 0.0:
        return Border(name, math.inf, "never: the rotor or its balls are undamped")
    speed, spread = worst_case_border(balancer), 0.0
    if math.isinf(speed):
        return Border(name, speed, "never, for balls at right angles (|S2| = 0)")
    for share in SPREADS[1:]:
        fixed = _FixedSpread(balancer, share * balancer.count)
        other, _ = border_of(fixed, p)
        if other > speed * (1.0 + 1e-9):
            speed, spread = other, share
    where = (
        "for balls at right angles"
        if spread == 0.0
        else "for balls in line"
        if spread == 1.0
        else f"for |S2|/N = {spread:g}"
    )
    note = f"{where} (|S2| = {spread * balancer.count:g})"
    return Border(
        name, speed, f"none up to {SEARCHED:g} times the critical speed, {note}" if math.isinf(speed) else note
    )


def worst_case_at_one_station(st: Stations) -> Border:
    """*exact border, worst case* where the rotor tilts or bends: equal balls at one station, |S2| from 0 to N."""
    name = "exact border, worst case"
    if not equal_at_one_station(st):
        return Border(
            name,
            math.nan,
            "computed for equal balls at one station only, races on the axis; see the exact border",
            False,
        )
    found = []
    for share in SPREADS:
        speed, note = border_of(EqualAtOneStation(st, spread=share * st.moment.size), st)
        found.append((speed, share, note))
    speed, share, note = max(found, key=lambda one: one[0])
    where = f"for |S2|/N = {share:g}, of {len(SPREADS)} that were tried"
    return Border(name, speed, "; ".join(filter(None, (where, note if math.isinf(speed) else ""))))


class _FixedSpread:
    """Equal balls with a given |S2|."""

    route = "polynomial"

    def __init__(self, balancer: PlanarBalancer, spread: float) -> None:
        self.balancer, self.spread = balancer, spread

    def rates(self, speeds: Floats) -> Floats:
        return growth_rates(self.balancer, speeds, self.spread)[0]


def _rank(found: tuple[float, str]) -> float:
    return -math.inf if math.isnan(found[0]) else found[0]


def _say(speed: float) -> str:
    return "none" if math.isnan(speed) else "never" if math.isinf(speed) else f"{speed:.5g} rad/s"


def _range(members: list[Balanced]) -> str:
    if not isinstance(members[0], EqualBalls):
        return ""
    ends = [
        float(m.spreads(np.array([40.0 * m.balancer.critical_speed]))[0])
        for m in (members[0], members[-1])
        if isinstance(m, EqualBalls)
    ]
    return f"|S2| from {ends[0]:.3g} to {ends[1]:.3g}; "
