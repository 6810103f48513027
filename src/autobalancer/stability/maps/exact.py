"""Exact borders: of one state, of all positions of the balls, and the worst case over all unbalances."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from autobalancer.machine import Machine
from autobalancer.results.number_text import moment_text
from autobalancer.stability.border import Border
from autobalancer.stability.host.planar import Floats, Plane
from autobalancer.stability.host.stations import Stations
from autobalancer.stability.maps.balanced import (
    Balanced,
    EqualBalls,
    EqualBallsAtRest,
    alike,
    balanced_states,
    planar_balancer_of,
)
from autobalancer.stability.maps.balanced_forces import ForcedBalls
from autobalancer.stability.maps.balanced_stations import EqualAtOneStation, equal_at_one_station
from autobalancer.stability.maps.characteristic import PlanarBalancer, growth_rates, worst_case_border
from autobalancer.stability.maps.windows import windows_of
from autobalancer.stability.states.described import (
    SEARCHED,
    Described,
    highest_searched,
    lower_critical_speed,
)
from autobalancer.stability.states.why_never import why_never

SPREADS = (0.0, 0.01, 0.05, 0.2, 0.5, 0.8, 0.95, 1.0)  # |S2|/N at which the worst case is looked for


def exact_borders(machine: Machine, p: Described) -> list[Border]:
    """*exact border*, and *exact border, best case* where the positions of the balls are a continuum."""
    members = balanced_states(p)
    found = [border_of(member, p) for member in members]
    if any(not math.isnan(speed) for speed, _ in found):  # positions that exist only at some speeds do not count
        found = [one for one in found if not math.isnan(one[0])]
    if isinstance(p, Stations) and p.forces is None and all(math.isinf(speed) for speed, _ in found):
        because = why_never(machine, p, highest_searched(p))
        found = [(speed, "; ".join(filter(None, (because, note)))) for speed, note in found]
    elif isinstance(p, Plane) and abs(p.unbalance) > p.capability * (1.0 + 1e-9):
        short = (
            f"side by side the balls can balance {moment_text(p.capability, 4)} only: here they would have to overlap"
        )
        found = [
            (speed, "; ".join(filter(None, (short, note)))) for speed, note in found if not math.isnan(speed)
        ] or found
    if isinstance(members[0], ForcedBalls):
        found = [(speed, "; ".join(filter(None, (members[0].left_at(speed), note)))) for speed, note in found]
    low, high = min(found, key=_rank), max(found, key=_rank)
    if len(members) == 1:
        return [Border("exact border", *found[0])]
    if math.isnan(high[0]):  # nowhere is there any of them
        return [Border("exact border", *high), Border("exact border, best case", *high)]
    which = f"worst of {len(found)} positions of the balls, {_range(members)}best {_say(low[0])}"
    return [
        Border("exact border", high[0], "; ".join(filter(None, (which, high[1])))),
        Border("exact border, best case", low[0], "; ".join(filter(None, ("best of these positions", low[1])))),
    ]


def border_of(
    state: Balanced, p: Described, highest: float | None = None, lowest: float | None = None
) -> tuple[float, str]:
    """Lowest speed from which on a state is stable up to the highest one that is searched, and a note.

    By default from the lower critical speed to :func:`highest_searched`.
    """
    critical = lower_critical_speed(p) if lowest is None else lowest
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

    Over these unbalances |S2| takes all values from 0 to N. Zero, where the two ball modes have one frequency, is the worst for a
    well damped rotor and has an explicit border on isotropic supports; where the rotor is damped lightly balls in line may be.
    """
    name = "exact border, worst case"
    if not alike(p):
        return Border(name, math.nan, "computed for equal balls only; see the exact border", False)
    if np.any(p.offset != 0.0):
        return Border(name, math.nan, "computed for races on the axis only; see the exact border", False)
    balancer = planar_balancer_of(p)
    if not p.isotropic:
        return _worst_spread([EqualBallsAtRest(p, spread=share * balancer.count) for share in SPREADS], p)
    if balancer.damping == 0.0 or balancer.drag == 0.0:
        return Border(name, math.inf, "the rotor or its balls are undamped")
    speed, spread = worst_case_border(balancer), 0.0
    if math.isinf(speed):
        return Border(name, speed, "of balls at right angles (|S2| = 0)")
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
        which = "equal balls at one station only, races on the axis, isotropic supports"
        if equal_at_one_station(replace(st, slopes=None, forces=None)):
            which = (
                "balls that feel the deflection of their race only"
                if st.forces is None
                else "balls without forces only"
            )
        return Border(name, math.nan, f"computed for {which}; see the exact border", False)
    return _worst_spread([EqualAtOneStation(st, spread=share * st.moment.size) for share in SPREADS], st)


def _worst_spread(members: Sequence[Balanced], p: Described) -> Border:
    """The worst of members for each of ``SPREADS``."""
    found = [(*border_of(member, p), share) for member, share in zip(members, SPREADS, strict=True)]
    speed, note, share = max(found, key=lambda one: one[0])
    where = f"for |S2|/N = {share:g}, of {len(SPREADS)} that were tried"
    return Border(
        "exact border, worst case", speed, "; ".join(filter(None, (where, note if math.isinf(speed) else "")))
    )


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
