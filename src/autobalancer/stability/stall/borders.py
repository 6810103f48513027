"""Release and capture speed of a machine: balls with any drag law and rolling resistance, on any rotor.

Equal balls on a planar rotor have the curve of :mod:`autobalancer.laws.stall`; with linear drag and no friction the release
speed has a closed form, :mod:`autobalancer.stability.stall.closed_form`. Others are balanced jointly: unequal balls, several
planes, rotors that tilt or bend, :mod:`autobalancer.stability.stall.joint`.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from autobalancer.assembly.profile import highest_prescribed
from autobalancer.assembly.terms import weightless
from autobalancer.laws.stall import StalledBall, planar_receptance, stall_ranges
from autobalancer.machine import Machine
from autobalancer.stability.border import Border
from autobalancer.stability.host.planar import Floats, Plane
from autobalancer.stability.host.stations import Stations, stations
from autobalancer.stability.stall.closed_form import UNDAMPED, release_border
from autobalancer.stability.stall.groups import Loads, StalledGroup, stalled_groups
from autobalancer.stability.stall.joint import joint_borders
from autobalancer.stability.stall.notes import CAPTURE, DRAGLESS, EARLIER_PLANE, HOW, RELEASE, RUN_DOWN, never
from autobalancer.stability.stall.on_rubber import on_rubber, rubber_under_balls
from autobalancer.stability.stall.one_plane import caught, parted
from autobalancer.stability.stall.several_on_rubber import several_on_rubber
from autobalancer.stability.stall.slow_runs import slow_runs
from autobalancer.stability.states.described import Described, highest_searched, lower_critical_speed

CARRIED = "balls between partitions are carried along and never stall"


def release_of(
    machine: Machine, p: Described, *, capture: bool = True, up_to: float | None = None
) -> tuple[Border, ...]:
    """*release speed* and, if wanted and where balls stall and are released, *capture speed*.

    On rotors that tilt or bend, of the resonances that a run-up to ``up_to`` (rad/s) meets; by default to the highest
    speed that the drive prescribes, else all.
    """
    machine = weightless(machine)
    place = p.station if isinstance(p, Stations) else np.zeros(p.moment.size, np.int64)
    groups = stalled_groups(machine, place.tolist())
    if not groups:
        return (Border(RELEASE, math.nan, CARRIED),)
    left_out = sum(group.count for group in groups) < p.moment.size
    loads = Loads(groups)
    top = highest_searched(p)
    limit = _limit(machine, p) if up_to is None else up_to
    runs = None
    soft = rubber_under_balls(machine)
    if soft is not None:
        limit = limit if isinstance(p, Stations) else math.inf
        if len(groups) > 1:
            found = several_on_rubber(machine, soft, loads, capture, limit)
        else:
            found = on_rubber(machine, soft, groups, capture, limit)
    elif isinstance(p, Stations):
        runs = None if left_out else slow_runs(machine, loads)
        found = joint_borders(p, loads, top, limit, capture, runs=runs)
    elif len(groups) > 1 or left_out:
        closed = release_border(p) if not left_out and p.isotropic and all(group.plain for group in groups) else None
        runs = None if left_out or closed else slow_runs(machine, loads)
        found = joint_borders(stations(machine, largest=True), loads, top, math.inf, capture, closed, runs)
    else:
        found = _in_one_plane(p, groups[0], capture)
    planes = len(set(loads.station.tolist()))
    if planes > 2 or (planes == 2 and runs is None):
        found = tuple(
            replace(one, note=f"{one.note}; {EARLIER_PLANE}")
            if one.name == CAPTURE and one.known and not one.note.startswith(RUN_DOWN)
            else one
            for one in found
        )
    if left_out:
        found = tuple(replace(one, note=f"{one.note}; {CARRIED}") for one in found)
    return found


def _in_one_plane(p: Plane, group: StalledGroup, capture: bool) -> tuple[Border, ...]:
    """Equal balls on a planar rotor."""
    if not all(b > 0.0 for b in p.damping):
        return never(UNDAMPED, capture)
    if not group.carries:
        return never(DRAGLESS, capture)

    def drag(slip: Floats) -> Floats:
        return p.drag[0] * slip if group.ball.drag_curve is None else group.drag(slip)

    critical, receptance = p.critical_speeds, planar_receptance(p.mass, p.stiffness, p.damping)
    ball = StalledBall(float(p.moment[0]), float(p.moment.sum()), group.ball.orbit_radius, drag, group.rolling)
    folds = stall_ranges(ball, receptance, critical)
    if folds and math.isinf(folds[-1].release):
        return never("no drag is enough at a resonance", capture)
    how = f"{HOW}, highest of all resonances" if len(critical) > 1 else HOW
    released = (
        release_border(p)
        if group.plain and p.isotropic
        else parted(ball, receptance, critical, folds, group.count, how)
    )
    return (released, caught(folds, released)) if capture else (released,)


def _limit(machine: Machine, p: Described) -> float:
    """The highest prescribed speed; infinite without one, or if it is below all critical speeds."""
    highest = highest_prescribed(machine)
    return highest if highest is not None and highest > lower_critical_speed(p) else math.inf
