"""Release and capture speed of groups of balls that stall together at the resonances of any rotor."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from autobalancer.stability.border import Border
from autobalancer.stability.host.reduction import reduced
from autobalancer.stability.host.stations import Stations
from autobalancer.stability.stall.branch import LOST, followed
from autobalancer.stability.stall.capture import captured
from autobalancer.stability.stall.freed import freed
from autobalancer.stability.stall.groups import Loads
from autobalancer.stability.stall.notes import (
    CAPTURE,
    DRAGLESS,
    EXACTLY,
    FREE,
    HOW,
    PASS,
    RELEASE,
    WORTH,
    again,
    capture_border,
    never,
    others,
    which,
)
from autobalancer.stability.stall.ranges import HangingRange, furthest_speed, hanging_ranges, reached
from autobalancer.stability.stall.states import Balance
from autobalancer.stability.stall.whirling import Whirling

UNFOLLOWED = "; its branch could not be followed further, so it may lie a little higher"
UPPER = 0.85  # of the highest release speed, from where on free balls of other planes are counted


def joint_borders(
    st: Stations, loads: Loads, top: float, limit: float, capture: bool, closed: Border | None = None
) -> tuple[Border, ...]:
    """Groups of balls that stall together at the resonances of any rotor; ``closed``: the release speed, if known."""
    if math.isfinite(limit):
        st = reduced(st, 2.0 * limit)
    rotor = Whirling(st)
    why = _unbounded(rotor, loads, limit)
    if why:
        return never(why, capture)
    if closed is not None:
        return closed, *([_captured(rotor, loads, closed.speed, top, limit)] if capture else [])
    ranges = hanging_ranges(rotor, loads, top, limit)
    known = reached(ranges, st.critical_speeds)
    met = [one for one in known if one.begin <= limit]
    notes = [again(one) for one in sorted(ranges, key=lambda one: one.begin) if one not in known][:1]
    if len(met) < len(known):
        notes.append(f"resonances above {limit:.4g} rad/s left out")
    if not met:
        release = Border(RELEASE, math.nan, "; ".join([PASS, *notes]))
        return release, *([Border(CAPTURE, math.nan, PASS)] if capture else [])
    met = _with_free_balls(rotor, loads, met)
    last = max(met, key=lambda one: one.end)
    if math.isinf(last.end):
        first = f"at {furthest_speed(rotor, top):.4g} rad/s balls are still stalled at the resonance near {last.whirl:.4g} rad/s"
    else:
        first = f"{HOW} at the resonance of {last.whirl:.4g} rad/s"
        notes = [*_exactly(rotor, loads, last, top), *notes, *_supports(st, loads, last, top)]
    first += which(st, loads, last) + (UNFOLLOWED if last.cause == LOST else "")
    found = [Border(RELEASE, last.end, "; ".join([first, *others(st, loads, met, last), *notes]))]
    if capture:
        found.append(_captured(rotor, loads, last.end, top, limit))
    return tuple(found)


def _with_free_balls(rotor: Whirling, loads: Loads, met: list[HangingRange]) -> list[HangingRange]:
    """Where balls of some planes part, with those of the others that run freely; of the ends near the highest one."""
    highest = max(one.end for one in met)
    places = {group.station for group in loads.groups}
    found = []
    for one in met:
        some = len({loads.groups[g].station for g in one.groups}) < len(places)
        end = None
        if some and one.cause == "parting" and one.end > UPPER * highest:
            end = freed(Balance(rotor, loads), one.groups, one.state)
        found.append(one if end is None else replace(one, end=end.speed, whirl=end.whirl, cause=FREE))
    return found


def _unbounded(rotor: Whirling, loads: Loads, limit: float) -> str:
    """Why balls are never released: no damping of a resonance, or no drag."""
    if any(not group.carries for group in loads.groups):
        return DRAGLESS
    for w in rotor.st.critical_speeds:
        modes = rotor.modes(w)
        near = int(np.argmin(np.abs(modes.frequency - w))) if modes.frequency.size else 0
        if w <= limit and modes.frequency.size and modes.decay[near] <= 1e-12 * w:
            return f"at {w:.4g} rad/s the rotor is undamped, and its whirl has no bound"
    return ""


def _captured(rotor: Whirling, loads: Loads, released: float, top: float, limit: float) -> Border:
    found = captured(rotor, loads, released, top, limit)
    if math.isnan(found.speed):
        return Border(CAPTURE, math.nan, found.reason)
    how = "" if found.cause == "fold" else "; there they begin to swing against each other"
    if found.lost > found.speed:
        how += f"; the planes lose synchronism at {found.lost:.4g} rad/s"
    return capture_border(found.speed, f" of {found.whirl:.4g} rad/s{how}")


def _exactly(rotor: Whirling, loads: Loads, last: HangingRange, top: float) -> list[str]:
    """To where balls hang that lie exactly on each other, as they cannot part."""
    if last.cause != "parting":
        return []
    further = followed(Balance(rotor, loads.some(last.groups)), last.state, top, ("fold", "swinging"))
    if not further.cause or further.speed < (1.0 + WORTH) * last.end:
        return []
    return [EXACTLY.format(further.speed)]


def _supports(st: Stations, loads: Loads, last: HangingRange, top: float) -> list[str]:
    """What the release speed is with supports as the load of the balls meets them, whose frequency is the whirl speed."""
    if st.model.speeds.size == 1:
        return []
    held = replace(
        st.model,
        speeds=np.zeros(1),
        damping=st.model.damping_at(last.whirl)[None],
        stiffness=st.model.stiffness_at(last.whirl)[None],
    )
    fixed = replace(st, model=held)
    met = reached(hanging_ranges(Whirling(fixed), loads, top, last.end), fixed.critical_speeds)
    ends = [one.end for one in met if one.groups == last.groups and math.isfinite(one.end)]
    text = "supports as at the speed of the rotor"
    return [f"{text}; with those at the whirl speed {max(ends):.4g} rad/s" if ends else text]
