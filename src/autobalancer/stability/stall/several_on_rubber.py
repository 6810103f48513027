"""Release speed of balls of several planes or kinds on rubber that softens with the amplitude.

All that hang together make one whirl, which decides how stiff the rubber is, :mod:`autobalancer.stability.stall.softening`. Their
balances are followed as on springs, :mod:`autobalancer.stability.stall.ranges`: each set of groups from where it can hang to
where it leaves. The unbalance is left out, as for equal balls of one plane.
"""

from __future__ import annotations

import math

import numpy as np

from autobalancer.assembly.rotors.softened import Softened
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.stability.border import Border
from autobalancer.stability.host.planar import Floats
from autobalancer.stability.host.stations import stations
from autobalancer.stability.stall.branch import LOST
from autobalancer.stability.stall.groups import Loads
from autobalancer.stability.stall.notes import CAPTURE, DRAGLESS, PASS, RELEASE, never, others, unsought, which
from autobalancer.stability.stall.on_rubber import BEYOND, ON_RUBBER
from autobalancer.stability.stall.ranges import BELOW, FAR, HangingRange, of_set, reached, sets
from autobalancer.stability.stall.softening import Softening, softening

UNEVEN = (
    "not computed on softening rubber for balls of several planes or kinds where x and y differ: their angles to each other, the "
    "stiffness and the ellipse depend on each other; simulate a slow run-up, see the page on rubber"
)
NO_CAPTURE = "not computed for balls of several planes or kinds on softening rubber; simulate a slow run-down"
UNFOLLOWED = "; its branch could not be followed further, so it may lie a little higher"
FIRST = "of all together the balls of {0} part first, at {1:.4g} rad/s"
TOGETHER = "all of them leave at {0:.4g} rad/s"
STAY = "balls stay at the resonance near {0:.4g} rad/s"
FINE = 1.03  # ratio of neighboring speeds at which balances are sought


def several_on_rubber(
    machine: Machine, soft: Softened, loads: Loads, capture: bool, limit: float
) -> tuple[Border, ...]:
    """*release speed* and, if wanted, why there is no *capture speed*; at resonances up to ``limit``, rad/s."""
    caught = (Border(CAPTURE, math.nan, NO_CAPTURE, False),) if capture else ()
    if not all(group.carries for group in loads.groups):
        return never(DRAGLESS, capture)
    st = stations(machine, largest=True)
    whole = softening(soft, st, loads)
    if not whole.rotor.isotropic:
        return Border(RELEASE, math.nan, UNEVEN, False), *caught
    critical = tuple(w for rotor in whole.frozen for w in rotor.st.critical_speeds)
    try:
        ranges = _ranges(whole, limit)
    except QuestionError as refused:
        return Border(RELEASE, math.nan, str(refused), False), *caught
    met = [one for one in reached(ranges, critical) if one.begin <= limit]
    if not met:
        return Border(RELEASE, math.nan, PASS), *caught
    return _released(whole, met), *caught


def _ranges(whole: Softening, limit: float) -> list[HangingRange]:
    """All ranges, set by set."""
    found: list[HangingRange] = []
    for chosen in sets(whole.frozen[0], whole.loads):
        found += of_set(whole.of(chosen), chosen, _speeds(whole), limit)
    return found


def _speeds(whole: Softening) -> Floats:
    """Of the rotor, at which balances are sought, rad/s."""
    critical = [w for rotor in (whole.frozen[0], whole.frozen[-1]) for w in rotor.st.critical_speeds]
    critical = critical or [rotor.modes(0.0).frequency[0] for rotor in whole.frozen]
    low, high = BELOW * min(critical), min(FAR * max(critical), whole.rotor.st.model.top_speed)
    return np.geomspace(low, high, max(round(np.log(high / low) / np.log(FINE)), 2))


def _released(whole: Softening, met: list[HangingRange]) -> Border:
    st, loads = whole.rotor.st, whole.loads
    last = max(met, key=lambda one: one.end)
    if math.isinf(last.end):
        return Border(RELEASE, math.inf, f"{STAY.format(last.whirl)}{which(st, loads, last)}")
    first = f"{ON_RUBBER}, at a whirl of {last.whirl:.4g} rad/s{which(st, loads, last)}"
    first += UNFOLLOWED if last.cause == LOST else ""
    notes = [first, *_first(whole, met, last), *others(st, loads, met, last), *_beyond(whole, last)]
    return Border(RELEASE, last.end, "; ".join([*notes, *unsought(loads, runs=False)]))


def _first(whole: Softening, met: list[HangingRange], last: HangingRange) -> list[str]:
    """Which balls leave first where not all leave at once."""
    loads, st = whole.loads, whole.rotor.st
    every = [one for one in met if len(one.groups) == len(loads.groups)]
    if not every:
        return []
    one = max(every, key=lambda one: one.end)
    if one.cause != "parting":
        return [TOGETHER.format(one.end)] if one is not last else []
    drawn = np.where(loads.count > 1.0, whole.deflections(one.state)[0].real / whole.orbit, np.inf)
    group = loads.groups[int(np.argmin(drawn))]
    several = len({other.station for other in loads.groups}) > 1
    name = st.names[group.station] if several else f"{1e3 * group.moment / group.ball.orbit_radius:.3g} g"
    return [FIRST.format(name, one.end)]


def _beyond(whole: Softening, last: HangingRange) -> list[str]:
    some = whole.of(last.groups)
    size = [
        float(one)
        for one, law in zip(some.stretches(last.state)[0], whole.soft.laws, strict=True)
        if one > law.largest_amplitude
    ]
    return [BEYOND.format(1e3 * max(size))] if size else []
