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
from autobalancer.stability.stall.groups import Loads
from autobalancer.stability.stall.notes import (
    CAPTURE,
    DRAGLESS,
    EXACTLY,
    GRADUAL,
    HOW,
    PASS,
    RELEASE,
    RUN,
    RUN_DOWN,
    WORTH,
    again,
    beyond,
    capture_border,
    never,
    others,
    unsought,
    which,
)
from autobalancer.stability.stall.ranges import HangingRange, furthest_speed, hanging_ranges, reached
from autobalancer.stability.stall.slow_runs import SlowRuns
from autobalancer.stability.stall.states import Balance
from autobalancer.stability.stall.whirling import Whirling

UNFOLLOWED = "; its branch could not be followed further, so it may lie a little higher"
DIFFERS = 0.004  # of the speed by which the end of a slow run must differ from that of a balance
UPPER = 0.85  # of the highest end of a balance, from where on ends are followed in slow runs


def joint_borders(
    st: Stations,
    loads: Loads,
    top: float,
    limit: float,
    capture: bool,
    closed: Border | None = None,
    runs: SlowRuns | None = None,
) -> tuple[Border, ...]:
    """Groups of balls that stall at the resonances of any rotor; ``closed``: the release speed, if known.

    ``runs`` of the machine follow them beyond the ends of their balances.
    """
    if math.isfinite(limit):
        st = reduced(st, 2.0 * limit)
    rotor = Whirling(st)
    why = _unbounded(rotor, loads, limit)
    if why:
        return never(why, capture)
    if closed is not None:
        return closed, *([_captured(rotor, loads, closed.speed, top, limit, runs)] if capture else [])
    ranges = hanging_ranges(rotor, loads, top, limit)
    known = reached(ranges, st.critical_speeds)
    met = [one for one in known if one.begin <= limit]
    notes = [again(one) for one in sorted(ranges, key=lambda one: one.begin) if one not in known][:1]
    if len(met) < len(known):
        notes.append(f"resonances above {limit:.4g} rad/s left out")
    if not met:
        release = Border(RELEASE, math.nan, "; ".join([PASS, *notes]))
        return release, *([Border(CAPTURE, math.nan, PASS)] if capture else [])
    met = _followed(runs, loads, met)
    last = max(met, key=lambda one: one.end)
    if math.isinf(last.end):
        first = f"at {furthest_speed(rotor, top):.4g} rad/s balls are still stalled at the resonance near {last.whirl:.4g} rad/s"
    else:
        first = beyond(st, loads, last) if last.slips else f"{HOW} at the resonance of {last.whirl:.4g} rad/s"
        notes = [*_exactly(rotor, loads, last, top), *notes, *_supports(st, loads, last, top)]
    first += which(st, loads, last) + (UNFOLLOWED if last.cause == LOST else "")
    notes += unsought(loads, runs is not None)
    found = [Border(RELEASE, last.end, "; ".join([first, *others(st, loads, met, last), *notes]))]
    if capture:
        found.append(_captured(rotor, loads, last.end, top, limit, runs))
    return tuple(found)


def _followed(runs: SlowRuns | None, loads: Loads, met: list[HangingRange]) -> list[HangingRange]:
    """Ranges near the highest end to where the last ball leaves in a slow run, if that is elsewhere."""
    if runs is None:
        return met
    ends = np.array([one.end for one in met])
    highest, found = float(ends.max()), []
    for one in met:
        last = runs.released(one) if UPPER * highest < one.end < math.inf else None
        if last is not None and (np.abs(last.speed / ends - 1.0) > DIFFERS).all():
            slips, cause = tuple(last.slip.tolist()), GRADUAL if last.gradual else RUN
            one = replace(one, end=last.speed, whirl=last.speed - max(slips), cause=cause, slips=slips)
        found.append(one)
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


def _captured(
    rotor: Whirling, loads: Loads, released: float, top: float, limit: float, runs: SlowRuns | None
) -> Border:
    found = captured(rotor, loads, released, top, limit, runs)
    notes = [] if math.isnan(found.step) else [f"the planes turn in step only below {found.step:.4g} rad/s"]
    if (later := found.later) is not None:
        notes.append(later.reason or f"in step all fall back at {later.speed:.4g} rad/s")
    if math.isnan(found.speed):
        return Border(CAPTURE, math.nan, "; ".join([found.reason, *notes]))
    if found.reason:
        notes.insert(0, f"above it {found.reason}")
    elif found.lost > found.speed:
        notes.insert(0, f"the planes lose synchronism at {found.lost:.4g} rad/s")
    if found.cause not in ("fold", "run"):
        notes.insert(0, "there they begin to swing against each other")
    balls = "" if found.station is None else f" of {rotor.st.names[found.station]} alone"
    how = RUN_DOWN if found.cause == "run" else HOW
    return capture_border(found.speed, "; ".join([f" of {found.whirl:.4g} rad/s", *notes]), balls, how)


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
