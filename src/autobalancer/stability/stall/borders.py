"""Release and capture speed of a machine: balls with any drag law and rolling resistance, on any rotor.

Equal balls on a planar rotor have the curve of :mod:`autobalancer.laws.stall`; with linear drag and no friction the release
speed has a closed form, :mod:`autobalancer.stability.stall.borders`. Others are balanced jointly: unequal balls, several
planes, rotors that tilt or bend, :mod:`autobalancer.stability.stall.borders`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autobalancer.arrays import Complexes, Floats
from autobalancer.assembly.drive_train import highest_prescribed
from autobalancer.assembly.rotors import balancer_rows, lateral_model, with_ball_mass
from autobalancer.assembly.rotors.critical import critical_speeds, natural_frequencies
from autobalancer.assembly.rotors.equivalent_stiffness import Softened, Steady, softened
from autobalancer.assembly.terms import weightless
from autobalancer.errors import QuestionError
from autobalancer.laws.stall import Receptance, StalledBall, StallRange, planar_receptance, stall_ranges
from autobalancer.machine import Machine
from autobalancer.progress import check_deadline
from autobalancer.stability.border import Border
from autobalancer.stability.host.reduction import reduced
from autobalancer.stability.host.stations import Plane, Stations, stations
from autobalancer.stability.stall.branch import BELOW as RANGES_BELOW
from autobalancer.stability.stall.branch import (
    FAR,
    LOST,
    HangingRange,
    followed,
    furthest_speed,
    hanging_ranges,
    of_set,
    reached,
    sets,
)
from autobalancer.stability.stall.capture import (
    CAPTURE,
    DRAGLESS,
    EARLIER_PLANE,
    EXACTLY,
    GRADUAL,
    HOW,
    LEAVE,
    PASS,
    RELEASE,
    RUN,
    RUN_DOWN,
    WORTH,
    SlowRuns,
    beyond,
    capture_border,
    captured,
    caught,
    hanging_balls_text,
    never,
    others,
    parted,
    unsought,
)
from autobalancer.stability.stall.states import AllModes, Balance, Loads, StalledGroup, States, Whirling, stalled_groups
from autobalancer.stability.states.rest_states import Described

CARRIED = "balls between partitions are carried along and never stall"


def release_of(
    machine: Machine, p: Described, *, capture: bool = True, up_to: float | None = None
) -> tuple[Border, ...]:
    """*release speed* and, if wanted and where balls stall and are released, *capture speed*.

    On rotors that tilt or bend, of the resonances that a run-up to ``up_to`` (rad/s) meets; by default to the highest
    speed that the drive prescribes, else all.
    """
    machine = weightless(machine)
    groups = stalled_groups(machine, p.station.tolist())
    if not groups:
        return (Border(RELEASE, math.nan, CARRIED),)
    left_out = sum(group.count for group in groups) < p.moment.size
    loads = Loads(groups)
    top = p.highest_searched
    highest = highest_prescribed(machine)
    limit = highest if highest is not None and highest > p.scale_speed else math.inf
    limit = limit if up_to is None else up_to
    runs = None
    soft = rubber_under_balls(machine)
    if soft is not None:
        limit = math.inf if p.planar else limit
        if len(groups) > 1:
            result = several_on_rubber(machine, soft, loads, capture, limit)
        else:
            result = on_rubber(machine, soft, groups, capture, limit)
    elif isinstance(p, Plane) and len(groups) == 1 and not left_out:
        result = _in_one_plane(p, groups[0], capture)
    else:
        plain = not left_out and all(group.plain for group in groups)
        closed = release_border(p) if plain and isinstance(p, Plane) and p.isotropic else None
        runs = None if left_out or closed else _slow_runs(machine, loads)
        limit = math.inf if p.planar else limit
        result = joint_borders(p.as_station, loads, top, limit, capture, closed, runs)
    planes = len(set(loads.station.tolist()))
    if planes > 2 or (planes == 2 and runs is None):
        result = tuple(
            replace(one, note=f"{one.note}; {EARLIER_PLANE}")
            if one.name == CAPTURE and one.known and not one.note.startswith(RUN_DOWN)
            else one
            for one in result
        )
    if left_out:
        result = tuple(replace(one, note=f"{one.note}; {CARRIED}") for one in result)
    return result


def _slow_runs(machine: Machine, loads: Loads) -> SlowRuns | None:
    """Runs of a machine whose balls may stall at several speeds; none for one group, with friction, or if they take long."""
    if len(loads.groups) < 2 or any(group.rolling > 0.0 for group in loads.groups):
        return None
    runs = SlowRuns(machine, loads)
    return runs if runs.possible else None


def _at_most(capture: Border, released: float) -> Border:
    """A capture speed that is not above the highest ``released`` speed, beyond which balls exactly in line do not stay so."""
    if not released < capture.speed or capture.note.startswith(RUN_DOWN):
        return capture
    return replace(capture, speed=released, note=f"{capture.note}; {LEAVE.format(capture.speed)}")


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
    return (released, _at_most(caught(folds, released), released.speed)) if capture else (released,)


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
    # the rotor with the modes that matter up to the limit
    if math.isfinite(limit):
        st = reduced(st, 2.0 * limit)
    rotor = Whirling(st)
    # is there a drag that frees the balls at all?
    why = _unbounded(rotor, loads, limit)
    if why:
        return never(why, capture)
    if closed is not None:
        return closed, *(
            [_at_most(_captured(rotor, loads, closed.speed, top, limit, runs), closed.speed)] if capture else []
        )
    # ranges of speed in which balls hang at a resonance, and which of them a run-up meets
    ranges = hanging_ranges(rotor, loads, top, limit)
    known = reached(ranges, st.critical_speeds)
    met = [one for one in known if one.begin <= limit]
    notes = []
    if unmet := min((one for one in ranges if one not in known), key=lambda one: one.begin, default=None):
        to = "" if math.isinf(unmet.end) else f" to {unmet.end:.4g}"
        again = "balls can stall again, at a resonance that rises with the speed, never passed"
        notes.append(f"from {unmet.begin:.4g}{to} rad/s on {again}")
    if len(met) < len(known):
        notes.append(f"resonances above {limit:.4g} rad/s left out")
    if not met:
        release = Border(RELEASE, math.nan, "; ".join([PASS, *notes]))
        return release, *([Border(CAPTURE, math.nan, PASS)] if capture else [])
    # the last of these ends releases the balls
    if runs is not None:
        # those near the highest end to where the last ball leaves in a slow run, if that is elsewhere
        ends = np.array([one.end for one in met])
        highest = float(ends.max())
        for k, one in enumerate(met):
            run = runs.released(one) if UPPER * highest < one.end < math.inf else None
            if run is not None and (np.abs(run.speed / ends - 1.0) > DIFFERS).all():
                slips, cause = tuple(run.slip.tolist()), GRADUAL if run.gradual else RUN
                met[k] = replace(one, end=run.speed, whirl=run.speed - max(slips), cause=cause, slips=slips)
    last = max(met, key=lambda one: one.end)
    if math.isinf(last.end):
        first = f"at {furthest_speed(rotor, top):.4g} rad/s balls are still stalled at the resonance near {last.whirl:.4g} rad/s"
    else:
        first = beyond(st, loads, last) if last.slips else f"{HOW} at the resonance of {last.whirl:.4g} rad/s"
        notes += _supports(st, loads, last, top)
        # to where balls hang that lie exactly on each other, as they cannot part
        if last.cause == "parting":
            further = followed(Balance(rotor, loads.some(last.groups)), last.state, top, ("fold", "swinging"))
            if further.cause and further.speed >= (1.0 + WORTH) * last.end:
                notes.insert(0, EXACTLY.format(further.speed))
    first += hanging_balls_text(st, loads, last) + (UNFOLLOWED if last.cause == LOST else "")
    notes += unsought(loads, runs is not None)
    result = [Border(RELEASE, last.end, "; ".join([first, *others(st, loads, met, last), *notes]))]
    if capture:
        highest = max(last.end, *(one.end for one in ranges))  # also of those that a run-up does not meet
        result.append(_at_most(_captured(rotor, loads, last.end, top, limit, runs), highest))
    return tuple(result)


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
    border = captured(rotor, loads, released, top, limit, runs)
    notes = [] if math.isnan(border.step) else [f"the planes turn in step only below {border.step:.4g} rad/s"]
    if (later := border.later) is not None:
        notes.append(later.reason or f"in step all fall back at {later.speed:.4g} rad/s")
    if math.isnan(border.speed):
        return Border(CAPTURE, math.nan, "; ".join([border.reason, *notes]))
    if border.reason:
        notes.insert(0, f"above it {border.reason}")
    elif border.lost > border.speed:
        notes.insert(0, f"the planes lose synchronism at {border.lost:.4g} rad/s")
    if border.cause not in ("fold", "run"):
        notes.insert(0, "there they begin to swing against each other")
    if not math.isnan(border.least):
        other = f"only at {border.least:.4g} rad/s" if border.least else "not at once"
        notes.insert(0, f"it depends on how the planes stand to each other before: from other angles {other}")
    balls = "" if border.station is None else f" of {rotor.st.names[border.station]} alone"
    how = RUN_DOWN if border.cause == "run" else HOW
    return capture_border(border.speed, "; ".join([f" of {border.whirl:.4g} rad/s", *notes]), balls, how)


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
# :mod:`autobalancer.stability.stall.borders`. Their balances are followed as on springs,
# :mod:`autobalancer.stability.stall.branch`: each set of groups from where it can hang to where it leaves. The
# unbalance is left out, as for equal balls of one plane.


UNEVEN = (
    "not computed on softening rubber where x and y differ: the whirl of stalled balls is an ellipse, whose torque pulsates; "
    "simulate a slow run-up, or make supports and rubber alike along x and y, see the page on rubber"
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
        slowest, quickest = whole.frozen[0], whole.frozen[-1]
        own = [w for rotor in (slowest, quickest) for w in rotor.st.critical_speeds]
        own = own or [rotor.modes(0.0).frequency[0] for rotor in whole.frozen]
        low, high = RANGES_BELOW * min(own), min(FAR * max(own), whole.rotor.st.model.top_speed)
        speeds = np.geomspace(low, high, max(round(np.log(high / low) / np.log(FINE)), 2))
        chosen = sets(slowest, loads)
        ranges = [one for groups in chosen for one in of_set(whole.of(groups), groups, speeds, limit)]
    except QuestionError as refused:
        return Border(RELEASE, math.nan, str(refused), False), *caught
    met = [one for one in reached(ranges, critical) if one.begin <= limit]
    if not met:
        return Border(RELEASE, math.nan, PASS), *caught
    return _released(whole, met), *caught


def _released(whole: Softening, met: list[HangingRange]) -> Border:
    st, loads = whole.rotor.st, whole.loads
    last = max(met, key=lambda one: one.end)
    if math.isinf(last.end):
        return Border(RELEASE, math.inf, f"{STAY.format(last.whirl)}{hanging_balls_text(st, loads, last)}")
    first = f"{ON_RUBBER}, at a whirl of {last.whirl:.4g} rad/s{hanging_balls_text(st, loads, last)}"
    first += UNFOLLOWED if last.cause == LOST else ""
    notes = [first, *_first(whole, met, last), *others(st, loads, met, last)]
    some = whole.of(last.groups)
    sizes = zip(some.stretches(last.state)[0].tolist(), whole.soft.laws, strict=True)
    if beyond_range := [size for size, law in sizes if size > law.largest_amplitude]:
        notes.append(BEYOND.format(1e3 * max(beyond_range)))
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


# Release and capture on rubber that softens with the amplitude: the whirl that stalled balls make decides how stiff it
# is.
#
# N balls in line at the speed v load the rotor with the circle v^2 S, S = N m eps, whatever their phase. So the
# deflection that suits the stiffness is a function of v alone, and the torque balance of
# :mod:`autobalancer.laws.stall` holds with
#
#     H(v) = z(v) / (v^2 S),    K(|z|, v).
#
# The unbalance of the rotor whirls at another speed and is left out, as it is on linear supports. On rubber it changes
# what the balls feel, too, which only a run knows. Gyroscopic terms are taken with the speed of the rotor at release.
#
# Balls of several planes or kinds: :mod:`autobalancer.stability.stall.borders`.
#
# Where x and y differ the rotor would move in an ellipse; that is refused.


ON_RUBBER = f"{HOW}, rubber as stiff as at the deflection that they make"
BEYOND = "they move the rubber {0:.3g} mm, beyond its largest breakaway amplitude"
NONE_MET = "no resonance is met"
MOVED = 1e-3  # relative change of a resonance of the rubber, from small to large motions
FARTHEST = 3.0  # whirl over the highest of these resonances
PASSES = 2  # the second with the rotor as fast as the first says


def rubber_under_balls(machine: Machine) -> Softened | None:
    """The softening rubber of a machine with the masses of its balls; none without any."""
    bare = lateral_model(machine)
    return softened(machine, bare, with_ball_mass(machine, bare))


def on_rubber(
    machine: Machine, soft: Softened, groups: tuple[StalledGroup, ...], capture: bool, limit: float
) -> tuple[Border, ...]:
    """*release speed* and *capture speed* of equal balls of one plane, at resonances up to ``limit``, rad/s."""
    # one ball that stands for all of its plane
    group = groups[0]
    if not group.carries:
        return never(DRAGLESS, capture)
    total = group.count * group.moment
    row = balancer_rows(machine, lateral_model(machine))[group.ball.balancer].deflection
    ball = StalledBall(group.moment, total, group.ball.orbit_radius, group.drag, group.rolling)
    # resonances of the rubber as it is soft and as it is stiff
    resonances = [speed for speed in _resonances(soft) if speed <= limit]
    limit = min(limit, FARTHEST * max(resonances, default=0.0))
    if not resonances:
        borders = (Border(RELEASE, math.nan, NONE_MET), Border(CAPTURE, math.nan, NONE_MET))
        return borders if capture else borders[:1]
    # gyroscopic forces depend on the rotor's speed over the whirl, which follows from the answer: repeated
    over = 1.0
    folds: tuple[StallRange, ...] = ()
    for _ in range(PASSES):
        check_deadline()
        try:
            receptance = whirl_receptance(soft, row, total, over)
            folds = tuple(fold for fold in stall_ranges(ball, receptance, resonances) if not fold.release_whirl > limit)
        except QuestionError as refused:
            borders = (Border(RELEASE, math.nan, str(refused), False), Border(CAPTURE, math.nan, str(refused), False))
            return borders if capture else borders[:1]
        if not folds or math.isinf(folds[-1].release) or not soft.sliding.gyroscopic.any():
            break
        over = folds[-1].release / folds[-1].release_whirl
    if folds and math.isinf(folds[-1].release):
        return never("no drag is enough at a resonance", capture)
    how = ON_RUBBER
    if folds:
        size = _circles(soft, row, total, np.array([folds[-1].release_whirl]), over).amplitude[0]
        sizes = [float(one) for one, law in zip(size, soft.laws, strict=True) if one > law.largest_amplitude]
        how += f"; {BEYOND.format(1e3 * max(sizes))}" if sizes else ""
    # the last fold releases the balls; in a run-down they are caught again
    released = parted(ball, receptance, resonances, folds, group.count, how)
    if not capture:
        return (released,)
    return released, _at_most(caught(folds, released), released.speed)


def whirl_receptance(soft: Softened, row: Floats, total: float, over: float = 1.0) -> Receptance:
    """Deflection over force at the place with this ``row`` under the load v^2 ``total`` (kg m) there, m/N over rad/s."""

    def receptance(whirl: Floats) -> Complexes:
        v = np.atleast_1d(np.asarray(whirl, dtype=float))
        return np.asarray(_circles(soft, row, total, v, over).motion @ row / (total * v**2))

    return receptance


def _circles(soft: Softened, row: Floats, total: float, v: Floats, over: float) -> Steady:
    """Motion and amplitudes of the rubber under that load.

    Raises
    ------
    QuestionError
        Where x and y differ.
    """
    circles = soft.circles(v, np.outer(total * v**2, row).astype(np.complex128), over=over)
    if circles is None:
        raise QuestionError(UNEVEN)
    return circles


def _resonances(soft: Softened) -> list[float]:
    """Critical speeds of small and of large motions, rad/s, of those that the rubber moves."""
    sizes = sorted({limit for law in soft.laws for _, limit in law.friction})
    tried = [0.5 * sizes[0], 2.0 * sizes[-1]] if sizes else [1e-6]
    first = float(natural_frequencies(soft.sliding)[0])
    every = [critical_speeds(soft.at_amplitude(size, first)) for size in tried]
    still = set(every[0]) if len(every) == 1 else set()
    moved = {
        speed for one, other in pairwise(every) for speed in one if all(abs(speed - w) > MOVED * speed for w in other)
    }
    moved |= {speed for speed in every[-1] if all(abs(speed - w) > MOVED * speed for w in every[0])}
    return sorted(moved | still) or list(every[0])


# Balances of stalled balls on rubber that softens: the whirl that they make decides how stiff it is, and this the
# whirl.
#
# At given phases the balls load the rotor with a circle at v, so that its steady motion is known, with all stiffness
# that suits it. The balances and their slopes, by differences, are those
# of :mod:`autobalancer.stability.stall.states`. They are sought from those of linear rotors, as stiff as at several
# amplitudes.
#
# Small motions about such a state change the stiffness, too. The forces of the elements are taken to follow the size
# and the phase of the whirl at once, with the slopes of their first harmonic; a friction element forgets within a
# small part of a turn.
#
# The loss of an elastoplastic element begins with the root of the amplitude beyond that at which it slides. There a
# branch has a corner, which is stepped over; where no state is found beyond it the branch turns back there, as in a
# fold.


DIFFERENCE = 1e-6  # of log (slip over whirl), of phases and, relative, of amplitudes
SHORT = 1e-4  # step along a branch below which it is given up
CORNER = 5e-3  # relative distance of an amplitude from a breakaway amplitude, where a branch turns back in a corner
SOFTENING_BEYOND, SOFTENING_NEAR = (
    (1e-4, 3e-4, 1e-3),
    0.1,
)  # how much faster the rotor is beyond a corner, and how far the state may move
RATIO = 2.5  # of neighboring amplitudes from whose stiffness balances are sought
WIDE = 2.0  # how far they go beyond the breakaway amplitudes


@dataclass(frozen=True)
class Softening(Balance):
    """A set of groups on softening rubber; ``rotor`` is that whose elements all slide.

    ``frozen`` are linear rotors as stiff as at some amplitudes, from the softest to the stiffest.
    """

    soft: Softened
    frozen: tuple[Whirling, ...]
    numbers = None
    shortest = SHORT

    def of(self, groups: tuple[int, ...]) -> Softening:
        """Some of the groups."""
        return replace(self, loads=self.loads.some(groups))

    def modes_of(self, speeds: Floats) -> AllModes | None:
        """None, since they depend on the amplitude."""
        return None

    def resonant(self, states: States) -> NDArray[np.bool_]:
        """As on the softest or on the stiffest rubber."""
        both = (rotor.hang(states.speed, states.whirl) for rotor in (self.frozen[0], self.frozen[-1]))
        return np.asarray(np.logical_or(*both))

    def found(self, speeds: Floats) -> list[States]:
        """All balances that are near one of a linear rotor, at each rotor speed."""
        begun = [one for rotor in self.frozen for one in Balance(rotor, self.loads).found(speeds)]
        return self.sorted(
            States(np.concatenate([one.speed for one in begun]), np.vstack([one.y for one in begun])), speeds
        )

    def turns(self, states: States) -> bool:
        """Whether an element is about to slide, where a branch has a corner."""
        stretch = self.stretches(states)[-1]
        limits = [np.array([limit for _, limit in law.friction]) for law in self.soft.laws]
        return any(bool((np.abs(a / limit - 1.0) < CORNER).any()) for a, limit in zip(stretch, limits, strict=True))

    def ahead(self, state: States) -> States | None:
        """The state beyond the corner, at a slightly higher speed; none if the branch turns back there."""
        for more in SOFTENING_BEYOND:
            corrected = self.corrected(States(state.speed * (1.0 + more), state.y))
            if corrected.speed.size and np.abs(corrected.y - state.y).max() < SOFTENING_NEAR:
                return corrected
        return None

    def stretches(self, states: States) -> Floats:
        """Amplitude of each piece of rubber, (n, M) m."""
        return np.abs(self.motion(states) @ self.soft.rows.T)

    def motion(self, states: States) -> Complexes:
        """Of the coordinates, which circle, (n, pairs); nan where none is found."""
        v, rows = states.whirl, self.rotor.st.rows[self.loads.station]
        load = v[:, None] ** 2 * ((self.loads.count * self.loads.moment * np.exp(1j * states.phases)) @ rows)
        over = states.speed / v
        known = np.isfinite(states.y).all(axis=1)
        result = np.full((v.size, self.rotor.load.shape[0]), np.nan, np.complex128)
        if not known.any():
            return result
        v, over, load = v[known], over[known], load[known]
        circles = self.soft.circles(v, load, over=over, attempted=True)
        assert circles is not None
        result[known] = circles.motion
        return result

    def deflections(self, states: States) -> Complexes:
        """q h of each group, (n, G), m."""
        place = self.motion(states) @ self.rotor.st.rows[self.loads.station].T
        return np.asarray((1.0 + 1j * self.rolling) * place * np.exp(-1j * states.phases))

    def misfit(self, states: States, modes: AllModes | None = None) -> tuple[Floats, Floats]:
        """Brake over need less one, (n, G), and its slopes over y, (n, G, G)."""
        n, groups = states.y.shape
        moved = np.concatenate([np.zeros((1, groups)), DIFFERENCE * np.eye(groups)])
        y = (states.y + moved[:, None, :]).reshape(-1, groups)
        every = States(np.tile(states.speed, groups + 1), y)
        v = every.whirl
        brake = -self.loads.moment * v[:, None] ** 2 * self.deflections(every).imag
        miss = (brake / self.needed(every.slip, v) - 1.0).reshape(groups + 1, n, groups)
        return miss[0], np.moveaxis((miss[1:] - miss[0]) / DIFFERENCE, 0, 2)

    def softening(self, states: States) -> Floats:
        """Accelerations of the rotor by what the elements add, over the real and imaginary parts of its deflections."""
        motion, rows, share = self.motion(states), self.soft.rows, self.soft.shares
        stretch = motion @ rows.T
        size = np.abs(stretch)
        here, more = (self.soft.added(size * (1.0 + step), states.whirl) for step in (0.0, DIFFERENCE))
        ahead = stretch / np.where(size > 0.0, size, 1.0)
        seen = np.stack([_real(row[None]) for row in rows])  # (M, 2, 2 n)
        result = np.zeros((len(motion), *2 * (2 * rows.shape[1],)))
        for m, rows_of_one in enumerate(seen):
            steeper = (more[:, m] - here[:, m]) / DIFFERENCE * ahead[:, m]  # over the change of size
            inward = np.stack([ahead[:, m].real, ahead[:, m].imag], axis=-1)
            outward = np.stack([steeper.real, steeper.imag], axis=-1)
            slope = np.array([_real(np.array([[one]])) for one in here[:, m]])
            slope = slope + outward[:, :, None] * inward[:, None, :]
            result += share[m] * rows_of_one.T @ slope @ rows_of_one
        return np.asarray(-_real(self.rotor.lightness) @ result)


def softening(soft: Softened, st: Stations, loads: Loads) -> Softening:
    """The balances of groups on the rubber of a machine with these stations."""
    sizes = [limit for law in soft.laws for _, limit in law.friction] or [1.0]
    low, high = min(sizes) / WIDE, max(sizes) * WIDE
    amplitudes = np.geomspace(high, low, 2 + round(np.log(high / low) / np.log(RATIO)))
    speed = float(natural_frequencies(soft.sliding)[0])
    frozen = tuple(Whirling(replace(st, model=soft.at_amplitude(size, speed))) for size in amplitudes)
    load = np.asarray(speed**2 * (loads.count * loads.moment) @ st.rows[loads.station], np.complex128)
    probe = soft.circles(np.array([speed]), load[None])
    return Softening(Whirling(replace(st, model=soft.sliding), apart=probe is None), loads, soft, frozen)


def _real(matrix: Any) -> Any:
    """A complex linear map as one of real and imaginary parts."""
    return np.block([[matrix.real, -matrix.imag], [matrix.imag, matrix.real]])
