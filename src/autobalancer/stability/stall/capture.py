"""The rotor speed below which balls in line fall back to a resonance, on any rotor.

Balls of one race that lie on each other turn a little slower than the rotor, beyond a resonance, with the phase between the
planes that balances. This state is followed downward from the highest speed at which it is stable to where it ends: in a
fold, or where it begins to swing. There balls fall back to the resonance if they can stall there. If nothing holds all of
them there, the planes lose step with each other; then each is followed alone. So they are above the speed up to which a
state in line is stable: there each plane lags at a speed of its own, and one of them may fall back far above.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autobalancer.arrays import Floats
from autobalancer.assembly.reduced_rotor import coordinate_places
from autobalancer.assembly.system import Assembly, assemble
from autobalancer.kernels.system import BALLS, SPEED
from autobalancer.laws.stall import Receptance, StalledBall, StallRange, parting_speeds
from autobalancer.machine import Balancer, Machine, PrescribedSpeed, Table
from autobalancer.progress import check_deadline
from autobalancer.roots import root
from autobalancer.simulation.record import Samples, record_for
from autobalancer.simulation.steppers import stepper_for
from autobalancer.stability.border import Border
from autobalancer.stability.host.stations import Stations
from autobalancer.stability.stall.branch import FAR, HangingRange, Leaving, followed, grid, growth, past
from autobalancer.stability.stall.states import Balance, Loads, States, Whirling

BESIDE = 1e-3  # of the speed below the end of a branch, where one looks for where balls go
LIKE, LITTLE = 2.0, 0.25  # slips that count as about the same; share of the speed that counts as turning with the rotor
EARLIER = 1.03  # times the speed of a balance, from which on balls that fall back in a run do so before
ABOVE = 1.3  # times the speed at which one plane falls back, where a run begins
TINY = 1e-9  # slip over speed where balls just begin to slip
TURNS = 4  # states in line through which they may go on
SINGLE = "; there is no single speed of capture"
LOST = "the planes lose synchronism at {0:.4g} rad/s and then fall back gradually" + SINGLE
AGAIN = "; they stall together from {0:.4g} rad/s down"
STEADY = "balls in line fall back gradually through the resonance" + SINGLE
HELD = "rolling resistance holds balls in line at all speeds that were tried, or not all of them slip at one"
NEVER = "the planes do not turn in step at any speed that was tried, nor does one of them fall back at once"


@dataclass(frozen=True)
class Capture:
    """Rotor speed (rad/s) and the whirl speed to which balls fall; nan with a ``reason`` where there is none, or what was before.

    ``lost`` is the speed at which planes lose step before, nan if they do not, and ``step`` that above which they do not
    turn in step, nan if they do. ``station`` is that of the balls, if they fall alone; ``later`` what happens to those of
    all planes further down. ``least`` is the lowest speed to which it goes down if the planes stand to each other otherwise when
    a run-down begins, 0 if balls do not fall back at once then, and nan where nothing else was found or tried.
    """

    speed: float
    whirl: float = math.nan
    cause: str = ""
    reason: str = ""
    lost: float = math.nan
    step: float = math.nan
    station: int | None = None
    later: Capture | None = None
    least: float = math.nan


def captured(
    rotor: Whirling, loads: Loads, released: float, top: float, limit: float, runs: SlowRuns | None = None
) -> Capture:
    """Where balls in line are caught in a slow run-down from above ``released``; of resonances below ``limit``, rad/s.

    ``runs`` decide whether planes turn in step where they can but need not, and where one falls back if not.
    """
    # rolling resistance needs runs; without it the states say where balls are caught
    speeds = every = grid(rotor, top)
    highest = min(max(limit, 0.0), FAR * max(rotor.st.critical_speeds, default=top))
    speeds = speeds[speeds <= max(highest, 1.5 * released if math.isfinite(released) else 0.0)]
    balance = Balance(rotor, loads)
    if balance.rolling.any():
        # rolling resistance holds balls at rest: from where on it no longer holds them where they all slip alike
        begun = _slipping(balance, speeds)
        if begun is None:
            return Capture(math.nan, reason=HELD)
        speed = float(begun.speed[0])
        slower = stands(balance, (1.0 - 0.1 * BESIDE) * speed)
        if slower.speed.size and slower.whirl[0] > (1.0 - 2.0 * BESIDE) * speed:
            return _down(balance, slower.some(np.array([0])), float(speeds[0]))
        below = stands(balance, (1.0 - BESIDE) * speed)
        return Capture(speed, float(below.whirl[0]) if below.speed.size else math.nan, "fold")
    # a state of all balls in step above the highest resonance, from which to come down
    begun = None
    if len(loads.groups) == 1:
        next_one = min((w for w in rotor.st.critical_speeds if w > limit), default=math.inf)
        begun = _beyond_all(balance, every[every <= limit])
        begun = _beyond_all(balance, every[every < next_one]) if begun is None else begun
    begun = _begun(balance, speeds) if begun is None else begun
    several = len(set(loads.station.tolist())) > 1
    if begun is None:
        never_in_step = (_first_plane_capture(balance, speeds) if several else None) or Capture(math.nan, reason=NEVER)
        search = runs if several else None
        return never_in_step if search is None else _first(search, balance, speeds, never_in_step, in_step=False)
    # downward in step, to where they are let go or caught for good
    result = _down(balance, begun, float(speeds[0]))
    if not math.isnan(result.lost):
        result = _joint_capture(balance, speeds[speeds < result.lost], result)
    # several planes may fall out of step, and each be caught alone
    if not several:
        return result
    ended = followed(balance, begun, float(speeds[-1]), ("fold", "swinging"))
    result = replace(result, step=ended.speed if ended.cause else math.nan)
    # planes alone, if that is at a higher speed
    alone = _first_plane_capture(balance, every[every <= max(ABOVE * limit, speeds[-1])])
    before = max(one for one in (result.speed, result.lost, 0.0) if not math.isnan(one))
    if alone is None or alone.speed <= before:
        return result if runs is None else _first(runs, balance, speeds, result)
    alone = replace(alone, step=result.step, later=result)
    if runs is None:
        return alone if alone.speed > result.step else result
    begin = max(float(speeds[-1]), ABOVE * alone.speed)
    slip = LITTLE * alone.speed if math.isnan(alone.whirl) else alone.speed - alone.whirl
    fell, least = runs.fell(begin, alone.speed, slip)
    return replace(alone, speed=fell, least=least) if fell > before else _first(runs, balance, speeds, result)


def _first_plane_capture(balance: Balance, speeds: Floats) -> Capture | None:
    """Where the first plane falls back while each turns at a speed of its own; none if no one does at these speeds."""
    capture = []
    for place in sorted(set(balance.loads.station.tolist())) if speeds.size else ():
        one = _of(balance, place)
        begun = _begun(one, speeds)
        capture += [] if begun is None else [replace(_down(one, begun, float(speeds[0])), station=place)]
    return max((one for one in capture if not math.isnan(one.speed)), key=lambda one: one.speed, default=None)


def _first(runs: SlowRuns, balance: Balance, speeds: Floats, capture: Capture, in_step: bool = True) -> Capture:
    """The same, or where balls fall back before in a slow run-down, if planes are not in step all the way."""
    known = [one for one in (capture.lost, capture.step) if not math.isnan(one)]
    if in_step and not known and not math.isnan(capture.speed):
        return capture
    begin, lowest = float(speeds[-1]), min(balance.rotor.st.critical_speeds, default=float(speeds[0])) / EARLIER
    lowest = lowest if math.isnan(capture.speed) else capture.speed
    fall = runs.falls(begin, EARLIER * max(known, default=begin), lowest)
    if fall is None or fall.speed < EARLIER * capture.speed:
        return capture
    station = min(fall.stations) if len(fall.stations) == 1 else None
    before = "" if EARLIER * fall.speed > capture.lost else capture.reason.replace(SINGLE, "")
    return replace(
        capture, speed=fall.speed, whirl=fall.whirl, cause="run", reason=before, station=station, least=fall.least
    )


def _of(balance: Balance, place: int) -> Balance:
    """Of the groups of one station."""
    return Balance(balance.rotor, balance.loads.some(tuple(np.flatnonzero(balance.loads.station == place).tolist())))


def _joint_capture(balance: Balance, speeds: Floats, capture: Capture) -> Capture:
    """Where planes lose step: from where on down all stall together, if that is before one of them falls back."""
    for speed in speeds[::-1].tolist():
        here = stands(balance, speed)
        passed = balance.rotor.modes(speed).frequency
        highest = passed[passed < speed].max(initial=0.0)
        stalled = np.flatnonzero((past(balance, here) <= 0.0) | (here.whirl < highest))
        if stalled.size:
            leaving = followed(balance, here.some(stalled[-1:]), capture.lost, ("fold", "swinging"))
            if math.isnan(capture.speed):
                return replace(capture, reason=capture.reason + AGAIN.format(leaving.speed))
            together = Capture(leaving.speed, leaving.whirl, "fold", lost=capture.lost)
            return together if leaving.speed > capture.speed else capture
    return capture


def _down(balance: Balance, begun: States, lowest: float) -> Capture:
    """Where balls fall back from a state in line."""
    for _ in range(TURNS):  # it may go on in another one
        causes = ("fold", "swinging", "passing") if past(balance, begun)[0] > 0.0 else ("fold", "swinging")
        leaving = followed(balance, begun, lowest, causes)
        if leaving.cause in ("", "passing"):
            return Capture(math.nan, reason=STEADY)
        beyond = bool(past(balance, leaving.state)[0] > 0.0)
        below = stands(balance, (1.0 - BESIDE) * leaving.speed)
        kept = np.flatnonzero(_in_line(balance, below, beyond, leaving))
        if below.speed.size == 0:
            return _apart(balance, leaving, lowest)
        fell = (
            leaving.cause == "fold" and len(balance.loads.groups) == 1
        )  # no phase in which another state could differ
        if kept.size == 0 or fell:
            return Capture(leaving.speed, float(below.whirl[0]), leaving.cause)
        begun = below.some(kept[:1])
    return Capture(leaving.speed, leaving.whirl, leaving.cause)


def _apart(balance: Balance, leaving: Leaving, lowest: float) -> Capture:
    """What the balls of each station do where those of all lose step."""
    places, speed = balance.loads.station, leaving.speed
    if len(set(places.tolist())) == 1:
        return Capture(speed, math.nan, leaving.cause)
    items, beyond = [], bool(past(balance, leaving.state)[0] > 0.0)
    for place in sorted(set(places.tolist())):
        alone = _of(balance, place)
        below = stands(alone, (1.0 - BESIDE) * speed)
        kept = np.flatnonzero(_in_line(alone, below, beyond, leaving))
        if kept.size:
            items.append(replace(_down(alone, below.some(kept[:1]), lowest), station=place))
        elif below.speed.size:
            items.append(Capture(speed, float(below.whirl[0]), leaving.cause, station=place))
    known = [item for item in items if not math.isnan(item.speed)]
    if not known:
        return Capture(math.nan, reason=LOST.format(speed), lost=speed)
    first = max(known, key=lambda one: one.speed)
    return replace(first, lost=speed)


def _in_line(balance: Balance, states: States, beyond: bool, leaving: Leaving) -> NDArray[np.bool_]:
    """Whether balls still turn nearly with the rotor: beyond the same resonance as before, else with about the slip they had.

    A state beyond a lower resonance, which they reach through a higher one, is not in line.
    """
    if not beyond:
        return np.asarray(states.speed - states.whirl < LIKE * (leaving.speed - leaving.whirl))
    passed = balance.rotor.modes(leaving.speed).frequency
    passed = passed[passed < leaving.whirl]
    highest = float(passed.max(initial=0.0))
    return np.asarray((past(balance, states) > 0.0) & (states.whirl > highest))


def stands(balance: Balance, speed: float) -> States:
    """Stable balances at one rotor speed, of groups whose balls stay together, those that lag least first."""
    (steady,) = balance.found(np.array([speed]))
    return steady.some(np.flatnonzero(growth(balance, steady) < 0.0))


def _slipping(balance: Balance, speeds: Floats) -> States | None:
    """The highest rotor speed at which all groups just begin to slip, none if there is none; of one or two groups."""
    if len(balance.loads.groups) > 2:
        return None

    def arcs(at: Floats) -> list[tuple[Floats, Floats]]:
        return balance.arcs(at, balance.rotor.all_modes(at), (at * (1.0 - TINY))[:, None])

    slips = []
    for k, (rest, _) in enumerate(arcs(speeds)):
        for i in np.flatnonzero(rest[1:, 0] * rest[:-1, 0] <= 0.0)[-1:]:

            def resting(w: float, k: int = k) -> float:
                return float(arcs(np.array([w]))[k][0][0, 0])

            speed = root(resting, speeds[i], speeds[i + 1], xtol=1e-13 * speeds[i])
            phase = float(arcs(np.array([speed]))[k][1][0, 0])
            y = [math.log(TINY), phase][: len(balance.loads.groups)]
            slips.append(States(np.array([speed]), np.array([y])))
    return max(slips, key=lambda one: float(one.speed[0]), default=None)


def _beyond_all(balance: Balance, speeds: Floats) -> States | None:
    """The state beyond all resonances that the rotor has passed, at the highest speed; it may lag far if drag is weak."""
    for speed in speeds[::-1].tolist():
        here, passed = stands(balance, speed), balance.rotor.modes(speed).frequency
        if here.speed.size and here.whirl[0] > passed[passed < speed].max(initial=0.0) and past(balance, here)[0] > 0.0:
            return here.some(np.array([0]))
    return None


def _begun(balance: Balance, speeds: Floats) -> States | None:
    """The state that lags least, at the highest speed at which one lags little."""
    for speed in speeds[::-1].tolist():
        here = stands(balance, speed)
        if here.speed.size and here.whirl[0] > (1.0 - LITTLE) * speed:
            return here.some(np.array([0]))
    return None


# Slow runs of the equations of motion, where stalled balls have no steady speed and no balance finds them.
#
# Balls of one plane that stall at v while those of another turn at v' feel each other at the frequency v - v'. To
# first order in torque over inertia that averages out, and each plane has the balance of its own speed. But v - v' is
# often only a few rad/s. Then both swing, and the second order counts: balls that go around in the whirl of others
# drive it along, which shifts the end by up to a tenth. Such motions begin where a steady one ends. They are followed
# by the equations themselves, without unbalance and in a frame in which they are slow, so that minutes take
# milliseconds.


TOLERANCE, STEPS = 1e-6, 400_000  # of a run
SPREAD = 3e-4  # of the masses of equal balls, which would never part
SETTLED = 6.0  # s in which a start settles
QUICK, SLOW = 2e-3, 2e-4  # of the speed by which it changes, 1/s
SAMPLES = 4.0  # a second
NEAR, EARLY = (
    0.97,
    (1.0, 0.9),
)  # of the end of a balance, where a run begins; of its whirl, where balls do not stall there
FURTHER, STRETCHES = 1.1, 6  # how far it goes at once, how often
STALLED, FULL = 0.5, 0.8  # of the greatest slip, from which on a ball stalls, and from which on it does fully
GRADUALLY = 0.01  # of the speed, between these two, from which on balls go over to the rotor gradually
WINDOW, SHORTEST = 8.0 * math.pi, 2.0  # over the slip, and s, over which speeds are averaged
OTHER = (
    2.0,
    -2.0,
    0.7,
)  # angles between planes, rad, from which run-downs begin; of two planes the first tells as much
ALIKE = 0.01  # share of a speed by which those from other angles may differ
AROUND, FALLEN = (
    1.05,
    0.75,
)  # speeds around a balance at which it is slow; share of the slip of balls that have fallen back
JUMP, RISE = 0.03, 1.3  # slip over speed by which balls fall back at once, and how many times the slip before
SOON = 0.012  # of the speed, in which they do
SLIP_MARGIN = 0.005  # of the last speed, before and after which slips are read


@dataclass(frozen=True)
class Motion:
    """Samples of a run: speed of the rotor (n,) and mean slip of each ball (n, balls), rad/s; the last state."""

    speed: Floats
    slip: Floats
    last: Floats
    assembly: Assembly

    def onto(self, other: Assembly) -> Floats:
        """The last state in the coordinates of another assembly, which keeps more modes where it goes to a higher speed."""
        before, after = self.assembly.reduction, other.reduction
        if before is None or after is None or np.array_equal(before.basis, after.basis):
            return self.last
        count, state = len(other.balls), other.state.copy()
        sizes = before.basis.shape[1], after.basis.shape[1]
        state[: BALLS + 2 * count] = self.last[: BALLS + 2 * count]
        for old, new in zip(*(coordinate_places(size, count) for size in sizes), strict=True):
            state[new] = np.linalg.lstsq(after.basis, before.basis @ self.last[old])[0]
        state[2 + 2 * sizes[1] + 2 * count :] = self.last[2 + 2 * sizes[0] + 2 * count :]  # rubber that remembers
        return state


@dataclass(frozen=True)
class LastStall:
    """Speed of the rotor at which the last ball leaves, and slip of each group a little before, rad/s; whether gradually."""

    speed: float
    slip: Floats
    gradual: bool


@dataclass(frozen=True)
class Fall:
    """Speed of the rotor at which balls fall back, and of their whirl after it, rad/s; the stations of those that do.

    ``least`` is the speed from other angles between the planes, 0 if they do not fall back at once, nan if it is about the same.
    """

    speed: float
    whirl: float
    stations: frozenset[int]
    least: float = math.nan


class SlowRuns:
    """Runs of a machine without unbalance and without contacts of its balls."""

    def __init__(self, machine: Machine, loads: Loads) -> None:
        self.loads = loads
        plain = {"balancers": tuple(_plain(balancer) for balancer in machine.balancers), "tilting_races": "deflection"}
        left_out = {"unbalances": (), "excitations": (), "axis": "vertical", "start": type(machine.start)()}
        self.machine = machine.model_copy(update=plain | left_out)

    @property
    def possible(self) -> bool:
        """Whether they take long steps; else they would take too long."""
        return stepper_for(self._assembled((0.0,), (1.0,), 0.0), 1.0, TOLERANCE).long is not None

    def released(self, hanging_range: HangingRange) -> LastStall | None:
        """Where the last ball leaves in a slow run-up from a balance; none if balls do not stall in it before its end."""
        # begin near the end of the range, or earlier where balls do not stall there
        slip, near = hanging_range.end - hanging_range.whirl, NEAR * hanging_range.end
        for begin in (
            near,
            *(min(max(share * hanging_range.whirl, 1.02 * hanging_range.begin), near) for share in EARLY),
        ):
            stalled_at = self._stalled(hanging_range, max(slip - (hanging_range.end - begin), 0.0))
            start: Floats | Motion = stalled_at
            path: tuple[float, ...] = (begin, near, FURTHER * near)
            result, w, slips = None, np.zeros(0), np.zeros((0, stalled_at.shape[-1]))
            # the run goes on in stretches until no ball is stalled any more
            for _ in range(STRETCHES):
                motion = self.run(path, start, slip, SPREAD)
                w, slips = np.append(w, motion.speed), np.concatenate([slips, motion.slip])
                most = slips.max(axis=1)
                greatest = np.maximum.accumulate(np.maximum(most, slip))
                stalled = np.flatnonzero((most > STALLED * greatest) & (w > near))
                if not stalled.size or stalled[0] > np.flatnonzero(w > near)[0]:
                    break
                # where the last one leaves: the greatest slip falls below a share of what it was
                last, full = (float(w[most > share * greatest[-1]].max(initial=near)) for share in (STALLED, FULL))
                before = slips[
                    np.searchsorted(w, (1.0 - SLIP_MARGIN) * last),
                    [group.members[0] for group in self.loads.groups],
                ]
                result = LastStall(last, before, last > (1.0 + GRADUALLY) * full)
                if w[-1] > (1.0 + SLIP_MARGIN) * last:
                    break
                path, start = (path[-1], FURTHER * path[-1]), motion
            if result is not None:
                return result
        return None

    @property
    def _angles(self) -> tuple[float, ...]:
        """Angles between neighboring planes from which run-downs begin; where three fall back may depend on them."""
        return OTHER[: 1 if len({group.station for group in self.loads.groups}) < 3 else None]

    def fell(self, begin: float, near: float, slip: float) -> tuple[float, float]:
        """Where a plane falls back to about a ``slip`` in a slow run-down, near a speed (rad/s); nan if none does.

        The balls of each plane are in line by themselves; they settle, in step or not, at the speed ``begin``. Of several
        run-downs the highest speed, and the ``least`` as in :class:`Fall`.
        """
        speeds = []
        for angle in self._angles:
            motion = self._down((begin, min(begin, near * AROUND), near / AROUND), slip, angle)
            fallen = np.flatnonzero(motion.slip.max(axis=1) > FALLEN * slip)
            speeds.append(float(motion.speed[fallen[0]]) if fallen.size else 0.0)
        return max(speeds) or math.nan, _least(speeds)

    def falls(self, begin: float, near: float, lowest: float) -> Fall | None:
        """The first fall of balls, in line by plane, in a run-down that is slow from ``near`` on; none if none falls at once.

        Of run-downs from several angles between the planes the highest.
        """
        falls = [self._fall(begin, near, lowest, angle) for angle in self._angles]
        first = max((fall for fall in falls if fall is not None), key=lambda fall: fall.speed, default=None)
        return first and replace(first, least=_least([fall.speed if fall else 0.0 for fall in falls]))

    def _fall(self, begin: float, near: float, lowest: float, angle: float) -> Fall | None:
        motion = self._down((begin, min(begin, near), lowest), 0.7 * JUMP * near, angle)
        most, w = motion.slip.max(axis=1), motion.speed
        after, later = (np.searchsorted(-w, -share * w) for share in (1.0 - SOON, 1.0 - 2.0 * SOON))
        known = np.flatnonzero(later < w.size)
        old, new, kept = most[known], most[after[known]], most[later[known]]
        fallen = known[(new - old > JUMP * w[known]) & (new > RISE * old) & (kept > 0.5 * (old + new))]
        if not fallen.size:
            return None
        i, end = int(fallen[0]), int(later[fallen[0]]) + 1
        k = i + int(np.argmax(most[i:end] > 0.5 * (most[i] + most[after[i]])))
        deepest = i + int(np.argmax(most[i:end]))
        firsts = [group.members[0] for group in self.loads.groups]
        rise = (motion.slip[deepest] - motion.slip[i])[firsts]
        stations = {group.station for group, own in zip(self.loads.groups, rise, strict=True) if own > 0.5 * rise.max()}
        return Fall(float(w[k]), float(w[deepest] - most[deepest]), frozenset(stations))

    def _down(self, path: tuple[float, ...], slip: float, angle: float) -> Motion:
        """A slow run-down along these speeds of balls that are in line by plane, one plane at an ``angle`` to the next."""
        angles = np.zeros(sum(len(group.members) for group in self.loads.groups))
        for group in self.loads.groups:
            angles[list(group.members)] = angle * group.station
        return self.run(path, np.stack([angles, np.zeros_like(angles)]), slip, 0.0)

    def _stalled(self, hanging_range: HangingRange, slip: float) -> Floats:
        """Angles and speeds of all balls in the rotor; those that do not stall are at rest, spread evenly over each race."""
        result = np.zeros((2, sum(len(group.members) for group in self.loads.groups)))
        for g, group in enumerate(self.loads.groups):
            members = list(group.members)
            if g in hanging_range.groups:
                result[0, members] = hanging_range.state.phases[0, hanging_range.groups.index(g)] + 1e-2 * np.arange(
                    len(members)
                )
                result[1, members] = -slip
            else:
                result[0, members] = 2.0 * math.pi * np.arange(len(members)) / len(members)
        return result

    def _assembled(self, times: Sequence[float], speeds: Sequence[float], spread: float) -> Assembly:
        drive = PrescribedSpeed(profile=Table(time=tuple(times), speed=tuple(speeds)))
        return assemble(self.machine.model_copy(update={"drive": drive}), contact=False, mass_spread=spread)

    def run(self, speeds: Sequence[float], start: Floats | Motion, slip: float, spread: float) -> Motion:
        """Along speeds of the rotor, slowly to the last, from the end of a motion or from angles and speeds of the balls."""
        check_deadline()
        # corners of a prescribed speed: settle, quick on the way, slow in the last stretch
        settling = 0.0 if isinstance(start, Motion) else SETTLED
        rates = [*[QUICK] * (len(speeds) - 2), SLOW]
        lasting = [abs(math.log(b / a)) / rate for a, b, rate in zip(speeds[:-1], speeds[1:], rates, strict=True)]
        points = [(0.0, speeds[0]), (settling, speeds[0])]
        for time, speed in zip(lasting, speeds[1:], strict=True):
            points.append((points[-1][0] + time, speed))
        points = [point for k, point in enumerate(points) if k == 0 or point[0] > points[k - 1][0]]
        times = [point[0] for point in points]
        # the machine with this drive, from the state given
        assembly = self._assembled(times, [point[1] for point in points], spread)
        count = len(assembly.balls)
        angles = slice(BALLS, BALLS + count)
        if isinstance(start, Motion):
            assembly.state[:] = start.onto(assembly)
        else:
            assembly.state[BALLS : BALLS + 2 * count] = start.ravel()
        assembly.state[SPEED] = speeds[0]
        record = record_for((Samples(round(SAMPLES * times[-1]) + 1),), (), assembly, times[-1])
        stepper = stepper_for(assembly, times[-1], TOLERANCE)
        stepper.advance(assembly.system, record, STEPS)
        # mean slip over a window of a few beats
        samples = record.samples[round(SAMPLES * settling) :]
        half = max(round(0.5 * SAMPLES * max(WINDOW / slip, SHORTEST)), 1)
        gone = samples[2 * half :, angles] - samples[: -2 * half, angles]
        return Motion(samples[half:-half, SPEED], -gone * SAMPLES / (2.0 * half), samples[-1].copy(), assembly)


def _least(speeds: Sequence[float]) -> float:
    """The lowest of the speeds, nan if all are about the same."""
    return min(speeds) if min(speeds) < (1.0 - ALIKE) * max(speeds) else math.nan


def _plain(balancer: Balancer) -> Balancer:
    """With round and concentric races in which balls feel drag and rolling resistance alone, as in the balances."""
    nothing = {"harmonics": (), "roundness": None, "eccentricity": 0.0, "slipstream": False, "resolved": None}
    passing = {"collisions": False, "contact": None, "forces": ()}
    races = tuple(race.model_copy(update=nothing | passing) for race in balancer.races)
    return balancer.model_copy(update={"races": races})


# What the borders of stalled balls say of themselves.


RELEASE, CAPTURE = "release speed", "capture speed"
HOW = "torque balance of stalled balls in line"
PASS = "the balls never stall: drag and friction carry them through"
DRAGLESS = "a ball without drag is not dragged along"
EXACTLY = "balls at exactly the same place stay stalled up to {0:.4g} rad/s"
LEAVE = "balls at exactly the same place fall back at {0:.4g} rad/s already, but part there and leave"
NO_CAPTURE = "not computed where balls are never released"
RUN, GRADUAL = "end of a slow run", "half of the slip in a slow run"
RUN_DOWN = "slow run-down"
APART = "states in which the planes stall at different speeds are not sought, and balls may be released higher"
EARLIER_PLANE = "whether one plane falls back before, far above, was not sought by a slow run-down"
UNEQUAL = "unequal balls of one race may stall in more ways than were sought, and be released higher"
OTHERS = 4  # further release speeds in a note
WORTH = 0.002  # relative difference from which on a second release speed is said


def never(why: str, capture: bool) -> tuple[Border, ...]:
    """Balls that are never released."""
    release = Border(RELEASE, math.inf, why)
    return (release, Border(CAPTURE, math.nan, NO_CAPTURE, False)) if capture else (release,)


def capture_border(speed: float, which: str, balls: str = "", how: str = HOW) -> Border:
    """Of balls in line, or of some of them."""
    return Border(CAPTURE, speed, f"{how}: below it balls in line{balls} fall back to the resonance{which}")


def beyond(st: Stations, loads: Loads, hanging_range: HangingRange) -> str:
    """Where balls leave in a slow run, and how they lag there; the end of their balance is elsewhere."""
    slips: dict[str, float] = {}
    for group, slip in zip(loads.groups, hanging_range.slips, strict=True):
        slips[st.names[group.station]] = max(slip, slips.get(st.names[group.station], 0.0))
    each = ", ".join(f"those of {name} by {slip:.3g} rad/s" for name, slip in slips.items())
    until = f"the torque balance of balls in line ends at {float(hanging_range.state.speed[0]):.4g} rad/s"
    gradually = ", to half of it gradually" if hanging_range.cause == GRADUAL else ""
    each += f" slower than the rotor{gradually}; {until}"
    return f"slow run of stalled balls at the resonance of {hanging_range.whirl:.4g} rad/s: {each}"


def hanging_balls_text(st: Stations, loads: Loads, hanging_range: HangingRange) -> str:
    """Which balls hang, if not all."""
    if len(hanging_range.groups) == len(loads.groups):
        return ""
    places = {group.station for group in loads.groups}
    held = {loads.groups[g].station for g in hanging_range.groups}
    if len(held) < len(places):
        names = ", ".join(st.names[place] for place in sorted(held))
        return f", balls of {names} alone, those of other planes are free already"
    return ", the strongest balls alone"


def unsought(loads: Loads, runs: bool) -> list[str]:
    """Why balls may be released higher than said; ``runs``: whether slow runs sought planes at different speeds."""
    planes = len({group.station for group in loads.groups})
    return [APART] * (planes > 1 and not runs) + [UNEQUAL] * (len(loads.groups) > planes)


def others(st: Stations, loads: Loads, met: list[HangingRange], last: HangingRange) -> list[str]:
    """The next lower ends, each resonance and set once."""
    rest = sorted((one for one in met if one is not last and math.isfinite(one.end)), key=lambda one: -one.end)
    texts: list[str] = []
    for one in rest:
        held = {loads.groups[g].station for g in one.groups}
        alone = (
            "" if len(one.groups) == len(loads.groups) else f" ({', '.join(st.names[p] for p in sorted(held))} alone)"
        )
        text = f"{one.end:.4g} rad/s at that of {one.whirl:.4g} rad/s{alone}"
        if text not in texts:
            texts.append(text)
    return texts[:OTHERS]


# Release and capture speed of equal balls in one plane, whatever the receptance of the rotor.


def parted(
    ball: StalledBall,
    receptance: Receptance,
    resonances: Sequence[float],
    folds: tuple[StallRange, ...],
    count: int,
    how: str = HOW,
) -> Border:
    """In a fold, or where several balls part before it; ``how`` is what it says of itself."""
    ends = [(fold.release, fold.release_whirl) for fold in folds]
    if count > 1:
        apart = parting_speeds(ball, receptance, resonances)
        ends = [end for end in ends if not any(whirl <= end[1] and whirl > 0.8 * end[1] for _, whirl in apart)]
        ends += apart
    if not ends:
        return Border(RELEASE, math.nan, PASS)
    speed, _ = max(ends)
    notes = [how]
    if folds and folds[-1].release > (1.0 + WORTH) * speed:
        notes.append(EXACTLY.format(folds[-1].release))
    return Border(RELEASE, speed, "; ".join(notes))


def caught(folds: tuple[StallRange, ...], released: Border) -> Border:
    """In the fold at the highest whirl: balls that turn nearly with the rotor are beyond all resonances, and fall there.

    Where two resonances are close the fold between them may be at a higher speed of the rotor. It is not on their way.
    """
    ends = [(fold.capture_whirl, fold.capture) for fold in folds if not math.isnan(fold.capture)]
    if not ends:
        return Border(CAPTURE, math.nan, PASS if math.isnan(released.speed) else STEADY)
    return capture_border(max(ends)[1], "")
