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
from autobalancer.laws.stall import StalledBall, planar_receptance, stall_ranges
from autobalancer.machine import Machine
from autobalancer.stability.border import Border
from autobalancer.stability.lateral import Floats, Plane
from autobalancer.stability.planes import Described, highest_searched, lower_critical_speed
from autobalancer.stability.release import UNDAMPED, release_border
from autobalancer.stability.stall_capture import capture_speed
from autobalancer.stability.stall_release import HangingRange, hanging_ranges, reached
from autobalancer.stability.stalled_groups import Loads, StalledGroup, stalled_groups
from autobalancer.stability.station_reduction import reduced
from autobalancer.stability.stations import Stations, stations
from autobalancer.stability.whirling import Whirling

RELEASE, CAPTURE = "release speed", "capture speed"
HOW = "torque balance of stalled balls in line"
PASS = "the balls never stall: drag and friction carry them through"
CARRIED = "balls between partitions are carried along and never stall"


def release_of(
    machine: Machine, p: Described, *, capture: bool = True, up_to: float | None = None
) -> tuple[Border, ...]:
    """*release speed* and, if wanted and where balls stall and are let go, *capture speed*.

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
    else:
        closed = release_border(p) if not left_out and all(group.plain for group in groups) else None
        if closed is not None and (math.isinf(closed.speed) or not capture):
            return (closed,)
        several = len(groups) > 1 or left_out
        if several:
            found = _joint(stations(machine, largest=True), Loads(groups), top, math.inf, capture)
        else:
            found = _in_one_plane(p, groups[0])
        if closed is not None:
            found = (closed, *(one for one in found if one.name == CAPTURE))
    if left_out:
        found = tuple(replace(one, note=f"{one.note}; {CARRIED}") for one in found)
    return found


def _in_one_plane(p: Plane, group: StalledGroup) -> tuple[Border, ...]:
    """Equal balls on a planar rotor."""
    critical = p.critical_speeds
    if not all(b > 0.0 for b in p.damping):
        return (Border(RELEASE, math.inf, UNDAMPED),)

    def drag(slip: Floats) -> Floats:
        return p.drag[0] * slip if group.ball.drag_curve is None else group.drag(slip)

    ball = StalledBall(float(p.moment[0]), float(p.moment.sum()), group.ball.orbit_radius, drag, group.rolling)
    folds = stall_ranges(ball, planar_receptance(p.mass, p.stiffness, p.damping), critical)
    if not folds:
        return (Border(RELEASE, math.nan, PASS),)
    if math.isinf(folds[-1].release):
        return (Border(RELEASE, math.inf, "never: no drag is enough at a resonance"),)
    note = f"{HOW}, highest of all resonances" if len(critical) > 1 else HOW
    release = Border(RELEASE, folds[-1].release, note)
    caught = [fold.capture for fold in folds if not math.isnan(fold.capture)]
    return (release, _capture(max(caught), "")) if caught else (release,)


def _limit(machine: Machine, p: Described) -> float:
    """The highest prescribed speed; infinite without one, or if it is below all critical speeds."""
    highest = highest_prescribed(machine)
    return highest if highest is not None and highest > lower_critical_speed(p) else math.inf


def _joint(st: Stations, loads: Loads, top: float, limit: float, capture: bool) -> tuple[Border, ...]:
    """Groups of balls that stall together at the resonances of any rotor."""
    if math.isfinite(limit):
        st = reduced(st, 2.0 * limit)
    rotor = Whirling(st)
    ranges = [one for one in hanging_ranges(rotor, loads, top, limit) if one.closed]
    known = reached(ranges, st.critical_speeds)
    met = [one for one in known if one.begin <= limit]
    notes = [_again(one) for one in ranges if one not in known][:1]
    if len(met) < len(known):
        notes.append(f"resonances above {limit:.4g} rad/s left out")
    if not met:
        return (Border(RELEASE, math.nan, "; ".join([PASS, *notes])),)
    last = max(met, key=lambda one: one.end)
    captures = [(capture_speed(rotor, loads, one, met, top), one) for one in met if capture]
    caught = [
        _capture(speed, f" of {rotor.modes(speed).frequency[one.mode]:.4g} rad/s")
        for speed, one in captures
        if not math.isnan(speed)
    ]
    highest = sorted(caught, key=lambda border: border.speed)[-1:]
    if math.isinf(last.end):
        at = (
            "of an undamped rotor"
            if rotor.modes(top).decay[last.mode] <= 1e-12 * top
            else f"near {last.whirl:.4g} rad/s"
        )
        first = f"never: at {top:.4g} rad/s balls still hang at the resonance {at}"
    else:
        alone = "" if last.refined else ", of its mode alone"
        first = f"{HOW} at the resonance of {last.whirl:.4g} rad/s{alone}"
        notes += _supports(st, loads, last, top)
    others = [f"{one.end:.4g} rad/s at that of {one.whirl:.4g} rad/s" for one in met if one is not last]
    return Border(RELEASE, last.end, "; ".join([first, *others, *notes])), *highest


def _capture(speed: float, which: str) -> Border:
    return Border(CAPTURE, speed, f"{HOW}: below it balls in line fall back to the resonance{which}")


def _again(one: HangingRange) -> str:
    to = "" if math.isinf(one.end) else f" to {one.end:.4g}"
    return f"from {one.begin:.4g}{to} rad/s on balls can hang again, at a resonance that rises with the speed and no run-up meets"


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
    ends = [one.end for one in met if one.closed and one.mode == last.mode]
    text = "supports as at the speed of the rotor"
    return [f"{text}; with those at the whirl speed {max(ends):.4g} rad/s" if ends else text]
