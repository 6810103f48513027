"""Release and capture speed of a machine: balls with any drag law and rolling resistance, on any rotor.

Equal balls on a planar rotor have the curve of :mod:`autobalancer.laws.stall`; with linear drag and no friction the release
speed has a closed form, :mod:`autobalancer.stability.stall.borders`. Others are balanced jointly: unequal balls, several
planes, rotors that tilt or bend, :mod:`autobalancer.stability.stall.borders`.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from autobalancer.assembly.profile import highest_prescribed
from autobalancer.assembly.rotors.softened import Softened
from autobalancer.assembly.terms import weightless
from autobalancer.errors import QuestionError
from autobalancer.laws.stall import StalledBall, planar_receptance, stall_ranges
from autobalancer.machine import Machine
from autobalancer.stability.border import Border
from autobalancer.stability.host.planar import Floats, Plane
from autobalancer.stability.host.reduction import reduced
from autobalancer.stability.host.stations import Stations, stations
from autobalancer.stability.stall.branch import LOST, followed
from autobalancer.stability.stall.capture import captured
from autobalancer.stability.stall.groups import Loads, StalledGroup, stalled_groups
from autobalancer.stability.stall.notes import (
    CAPTURE,
    DRAGLESS,
    EARLIER_PLANE,
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
from autobalancer.stability.stall.on_rubber import BEYOND, ON_RUBBER, on_rubber, rubber_under_balls
from autobalancer.stability.stall.one_plane import caught, parted
from autobalancer.stability.stall.ranges import (
    BELOW,
    FAR,
    HangingRange,
    furthest_speed,
    hanging_ranges,
    of_set,
    reached,
    sets,
)
from autobalancer.stability.stall.slow_runs import SlowRuns, slow_runs
from autobalancer.stability.stall.softening import Softening, softening
from autobalancer.stability.stall.states import Balance
from autobalancer.stability.stall.whirling import Whirling
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


# The release speed in closed form: from which rotor speed on no ball can stall, linear drag and isotropic supports.
#
# A ball that circles in space at a speed v drives the rotor, with all others that stall, at the frequency v. The
# rotor answers with a whirl that brakes the ball; averaged over a turn the torque on N equal balls in line is
#
#     N s^2 v^4 L(v),    L(v) = b v / ((k - M v^2)^2 + (b v)^2),    s = m eps,
#
# and the fluid drags it with beta (W - v). Balls that lag behind the whirl by a right angle are at their limit, which
# is at v = w_c. Unequal balls take angles to each other at which each is in balance; with the power that all of them
# put into the whirl a set of them stalls together as long as for each
#
#     beta^2 (W - v) <= s^2 v^4 L(v) sum beta.


UNDAMPED = "without damping of the rotor its whirl at a critical speed has no bound"


def release_border(p: Plane) -> Border:
    """The release speed of isotropic supports, linear drag and no friction; closed form (4.73) of Spannan (2021).

    That is the torque balance at v = w_c, W = w_c (1 + N S) for N equal balls. Of balls that are not equal sets stall
    together, from the strongest on; the set that holds longest counts.
    """
    critical = math.sqrt(p.stiffness[0] / p.mass)
    released, together = 0.0, 0.0
    ratio = p.moment / p.drag
    for i in np.argsort(-ratio, kind="stable"):  # the strongest holds longest; the weakest of a set leaves first
        together += float(p.drag[i])
        released = max(released, critical + float(ratio[i]) ** 2 * together * critical**3 / p.damping[0])
    return Border("release speed", released, "for a drag that is linear and no friction")


# Release and capture speed of groups of balls that stall together at the resonances of any rotor.


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


# Release speed of balls of several planes or kinds on rubber that softens with the amplitude.
#
# All that hang together make one whirl, which decides how stiff the rubber is,
# :mod:`autobalancer.stability.stall.softening`. Their balances are followed as on springs,
# :mod:`autobalancer.stability.stall.ranges`: each set of groups from where it can hang to where it leaves. The
# unbalance is left out, as for equal balls of one plane.


UNEVEN = (
    "not computed on softening rubber for balls of several planes or kinds where x and y differ: their angles to each other, the "
    "stiffness and the ellipse depend on each other; simulate a slow run-up, see the page on rubber"
)
NO_CAPTURE = "not computed for balls of several planes or kinds on softening rubber; simulate a slow run-down"
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
