"""Release and capture speed of a machine: balls with any drag law and rolling resistance, on any rotor.

Equal balls on a planar rotor have the curve of :mod:`autobalancer.laws.stall`; with linear drag and no friction the release
speed has a closed form, :mod:`autobalancer.stability.release`. Others are balanced jointly: unequal balls, several planes,
rotors that tilt or bend, :mod:`autobalancer.stability.stall_release`.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from autobalancer.assembly.profile import highest_prescribed
from autobalancer.laws.stall import (
    Receptance,
    StalledBall,
    StallRange,
    parting_speeds,
    planar_receptance,
    stall_ranges,
)
from autobalancer.machine import Machine
from autobalancer.stability.border import Border
from autobalancer.stability.lateral import Floats, Plane
from autobalancer.stability.planes import Described, highest_searched, lower_critical_speed
from autobalancer.stability.release import UNDAMPED, release_border
from autobalancer.stability.stall_branch import LOST, followed
from autobalancer.stability.stall_capture import STEADY, captured
from autobalancer.stability.stall_freed import freed
from autobalancer.stability.stall_release import HangingRange, hanging_ranges, reached
from autobalancer.stability.stall_states import Balance
from autobalancer.stability.stalled_groups import Loads, StalledGroup, stalled_groups
from autobalancer.stability.station_reduction import reduced
from autobalancer.stability.stations import Stations, stations
from autobalancer.stability.whirling import Whirling

RELEASE, CAPTURE = "release speed", "capture speed"
HOW = "torque balance of stalled balls in line"
PASS = "the balls never stall: drag and friction carry them through"
DRAGLESS = "never: a ball without drag is not dragged along"
EXACTLY = "balls at exactly the same place stay stalled up to {0:.4g} rad/s"
NO_CAPTURE = "not known where balls are never released"
UNFOLLOWED = "; its branch could not be followed further, so it may lie a little higher"
UPPER = 0.85  # of the highest release speed, from where on free balls of other planes are counted
FREE = "parting, others free"
OTHERS = 4  # further release speeds in a note
WORTH = 0.002  # relative difference from which on a second release speed is said
CARRIED = "balls between partitions are carried along and never stall"


def release_of(
    machine: Machine, p: Described, *, capture: bool = True, up_to: float | None = None
) -> tuple[Border, ...]:
    """*release speed* and, if wanted and where balls stall and are released, *capture speed*.

    On rotors that tilt or bend, of the resonances that a run-up to ``up_to`` (rad/s) meets; by default to the highest
    speed that the drive prescribes, else all.
    """
    place = p.station if isinstance(p, Stations) else np.zeros(p.moment.size, np.int64)
    groups = stalled_groups(machine, place.tolist())
    if not groups:
        return (Border(RELEASE, math.nan, CARRIED),)
    left_out = sum(group.count for group in groups) < p.moment.size
    top = highest_searched(p)
    limit = _limit(machine, p) if up_to is None else up_to
    if isinstance(p, Stations):
        found = _joint(p, Loads(groups), top, limit, capture)
    elif len(groups) > 1 or left_out:
        closed = release_border(p) if not left_out and p.isotropic and all(group.plain for group in groups) else None
        found = _joint(stations(machine, largest=True), Loads(groups), top, math.inf, capture, closed)
    else:
        found = _in_one_plane(p, groups[0], capture)
    if left_out:
        found = tuple(replace(one, note=f"{one.note}; {CARRIED}") for one in found)
    return found


def _in_one_plane(p: Plane, group: StalledGroup, capture: bool) -> tuple[Border, ...]:
    """Equal balls on a planar rotor."""
    if not all(b > 0.0 for b in p.damping):
        return _never(UNDAMPED, capture)
    if not group.carries:
        return _never(DRAGLESS, capture)

    def drag(slip: Floats) -> Floats:
        return p.drag[0] * slip if group.ball.drag_curve is None else group.drag(slip)

    critical, receptance = p.critical_speeds, planar_receptance(p.mass, p.stiffness, p.damping)
    ball = StalledBall(float(p.moment[0]), float(p.moment.sum()), group.ball.orbit_radius, drag, group.rolling)
    folds = stall_ranges(ball, receptance, critical)
    if folds and math.isinf(folds[-1].release):
        return _never("never: no drag is enough at a resonance", capture)
    released = release_border(p) if group.plain and p.isotropic else _released(ball, receptance, p, folds, group.count)
    if not capture:
        return (released,)
    caught = [fold.capture for fold in folds if not math.isnan(fold.capture)]
    reason = PASS if math.isnan(released.speed) else STEADY
    return released, _capture(max(caught), "") if caught else Border(CAPTURE, math.nan, reason)


def _released(ball: StalledBall, receptance: Receptance, p: Plane, folds: tuple[StallRange, ...], count: int) -> Border:
    """In a fold, or where several balls part before it."""
    ends = [(fold.release, fold.release_whirl) for fold in folds]
    if count > 1:
        parted = parting_speeds(ball, receptance, p.critical_speeds)
        ends = [end for end in ends if not any(whirl <= end[1] and whirl > 0.8 * end[1] for _, whirl in parted)]
        ends += parted
    if not ends:
        return Border(RELEASE, math.nan, PASS)
    speed, _ = max(ends)
    notes = [f"{HOW}, highest of all resonances" if len(p.critical_speeds) > 1 else HOW]
    if folds and folds[-1].release > (1.0 + WORTH) * speed:
        notes.append(EXACTLY.format(folds[-1].release))
    return Border(RELEASE, speed, "; ".join(notes))


def _never(why: str, capture: bool) -> tuple[Border, ...]:
    never = Border(RELEASE, math.inf, why)
    return (never, Border(CAPTURE, math.nan, NO_CAPTURE)) if capture else (never,)


def _limit(machine: Machine, p: Described) -> float:
    """The highest prescribed speed; infinite without one, or if it is below all critical speeds."""
    highest = highest_prescribed(machine)
    return highest if highest is not None and highest > lower_critical_speed(p) else math.inf


def _joint(
    st: Stations, loads: Loads, top: float, limit: float, capture: bool, closed: Border | None = None
) -> tuple[Border, ...]:
    """Groups of balls that stall together at the resonances of any rotor; ``closed``: the release speed, if known."""
    if math.isfinite(limit):
        st = reduced(st, 2.0 * limit)
    rotor = Whirling(st)
    never = _unbounded(rotor, loads, limit)
    if never:
        return _never(never, capture)
    if closed is not None:
        return closed, *([_captured(rotor, loads, closed.speed, top, limit)] if capture else [])
    ranges = hanging_ranges(rotor, loads, top, limit)
    known = reached(ranges, st.critical_speeds)
    met = [one for one in known if one.begin <= limit]
    notes = [_again(one) for one in sorted(ranges, key=lambda one: one.begin) if one not in known][:1]
    if len(met) < len(known):
        notes.append(f"resonances above {limit:.4g} rad/s left out")
    if not met:
        release = Border(RELEASE, math.nan, "; ".join([PASS, *notes]))
        return release, *([Border(CAPTURE, math.nan, PASS)] if capture else [])
    met = _with_free_balls(rotor, loads, met)
    last = max(met, key=lambda one: one.end)
    if math.isinf(last.end):
        first = f"never: at {top:.4g} rad/s balls are still stalled at the resonance near {last.whirl:.4g} rad/s"
    else:
        first = f"{HOW} at the resonance of {last.whirl:.4g} rad/s"
        notes = [*_exactly(rotor, loads, last, top), *notes, *_supports(st, loads, last, top)]
    first += _which(st, loads, last) + (UNFOLLOWED if last.cause == LOST else "")
    found = [Border(RELEASE, last.end, "; ".join([first, *_others(st, loads, met, last), *notes]))]
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
            return f"never: at {w:.4g} rad/s the rotor is undamped, and its whirl has no bound"
    return ""


def _captured(rotor: Whirling, loads: Loads, released: float, top: float, limit: float) -> Border:
    found = captured(rotor, loads, released, top, limit)
    if math.isnan(found.speed):
        return Border(CAPTURE, math.nan, found.reason)
    how = "" if found.cause == "fold" else "; there they begin to swing against each other"
    if found.lost > found.speed:
        how += f"; the planes lose synchronism at {found.lost:.4g} rad/s"
    return _capture(found.speed, f" of {found.whirl:.4g} rad/s{how}")


def _capture(speed: float, which: str) -> Border:
    return Border(CAPTURE, speed, f"{HOW}: below it balls in line fall back to the resonance{which}")


def _which(st: Stations, loads: Loads, one: HangingRange) -> str:
    """Which balls hang, if not all."""
    if len(one.groups) == len(loads.groups):
        return ""
    places = {group.station for group in loads.groups}
    held = {loads.groups[g].station for g in one.groups}
    if len(held) < len(places):
        names = ", ".join(st.names[place] for place in sorted(held))
        shift = (
            "" if one.cause == FREE or math.isinf(one.end) else "; those of other planes may shift it by some percent"
        )
        return f", balls of {names} alone, those of other planes are free already{shift}"
    return ", the strongest balls alone"


def _others(st: Stations, loads: Loads, met: list[HangingRange], last: HangingRange) -> list[str]:
    """The next lower ends, each resonance and set once."""
    rest = sorted((one for one in met if one is not last and math.isfinite(one.end)), key=lambda one: -one.end)
    found: list[str] = []
    for one in rest:
        held = {loads.groups[g].station for g in one.groups}
        alone = (
            "" if len(one.groups) == len(loads.groups) else f" ({', '.join(st.names[p] for p in sorted(held))} alone)"
        )
        text = f"{one.end:.4g} rad/s at that of {one.whirl:.4g} rad/s{alone}"
        if text not in found:
            found.append(text)
    return found[:OTHERS]


def _exactly(rotor: Whirling, loads: Loads, last: HangingRange, top: float) -> list[str]:
    """To where balls hang that lie exactly on each other, as they cannot part."""
    if last.cause != "parting":
        return []
    further = followed(Balance(rotor, loads.some(last.groups)), last.state, top, ("fold", "swinging"))
    if not further.cause or further.speed < (1.0 + WORTH) * last.end:
        return []
    return [EXACTLY.format(further.speed)]


def _again(one: HangingRange) -> str:
    to = "" if math.isinf(one.end) else f" to {one.end:.4g}"
    return f"from {one.begin:.4g}{to} rad/s on balls can stall again, at a resonance that rises with the speed, never passed"


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
