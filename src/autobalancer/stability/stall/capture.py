"""The rotor speed below which balls in line fall back to a resonance, on any rotor.

Balls of one race that lie on each other turn a little slower than the rotor, beyond a resonance, with the phase between the
planes that balances. This state is followed downward from the highest speed at which it is stable to where it ends: in a
fold, or where it begins to swing. There balls fall back to the resonance if they can stall there. If nothing holds all of
them there, the planes lose step with each other; then each is followed alone. So they are above the speed up to which a
state in line is stable: there each plane lags at a speed of its own, and one of them may fall back far above.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from autobalancer.stability.host.planar import Floats
from autobalancer.stability.stall.branch import Leaving, followed
from autobalancer.stability.stall.groups import Loads
from autobalancer.stability.stall.linear import growth, past
from autobalancer.stability.stall.ranges import FAR, grid
from autobalancer.stability.stall.slow_runs import SlowRuns
from autobalancer.stability.stall.states import Balance, States
from autobalancer.stability.stall.whirling import Whirling

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
    all planes further down.
    """

    speed: float
    whirl: float = math.nan
    cause: str = ""
    reason: str = ""
    lost: float = math.nan
    step: float = math.nan
    station: int | None = None
    later: Capture | None = None


def captured(
    rotor: Whirling, loads: Loads, released: float, top: float, limit: float, runs: SlowRuns | None = None
) -> Capture:
    """Where balls in line are caught in a slow run-down from above ``released``; of resonances below ``limit``, rad/s.

    ``runs`` decide whether planes turn in step where they can but need not, and where one falls back if not.
    """
    speeds = every = grid(rotor, top)
    highest = min(max(limit, 0.0), FAR * max(rotor.st.critical_speeds, default=top))
    speeds = speeds[speeds <= max(highest, 1.5 * released if math.isfinite(released) else 0.0)]
    balance = Balance(rotor, loads)
    if balance.rolling.any():
        return _let_down(balance, speeds)
    begun = None
    if len(loads.groups) == 1:
        next_one = min((w for w in rotor.st.critical_speeds if w > limit), default=math.inf)
        begun = _beyond_all(balance, every[every <= limit])
        begun = _beyond_all(balance, every[every < next_one]) if begun is None else begun
    begun = _begun(balance, speeds) if begun is None else begun
    several = len(set(loads.station.tolist())) > 1
    if begun is None:
        never_in_step = (_alone(balance, speeds) if several else None) or Capture(math.nan, reason=NEVER)
        search = runs if several else None
        return never_in_step if search is None else _first(search, balance, speeds, never_in_step, in_step=False)
    found = _down(balance, begun, float(speeds[0]))
    if not math.isnan(found.lost):
        found = _again(balance, speeds[speeds < found.lost], found)
    if not several:
        return found
    ended = followed(balance, begun, float(speeds[-1]), ("fold", "swinging"))
    found = replace(found, step=ended.speed if ended.cause else math.nan)
    alone = _alone(balance, every[every <= max(ABOVE * limit, speeds[-1])])
    before = max(one for one in (found.speed, found.lost, 0.0) if not math.isnan(one))
    if alone is None or alone.speed <= before:
        return found if runs is None else _first(runs, balance, speeds, found)
    alone = replace(alone, step=found.step, later=found)
    if runs is None:
        return alone if alone.speed > found.step else found
    begin = max(float(speeds[-1]), ABOVE * alone.speed)
    slip = LITTLE * alone.speed if math.isnan(alone.whirl) else alone.speed - alone.whirl
    fell = runs.fell(begin, alone.speed, slip)
    return replace(alone, speed=fell) if fell > before else _first(runs, balance, speeds, found)


def _alone(balance: Balance, speeds: Floats) -> Capture | None:
    """Where the first plane falls back while each turns at a speed of its own; none if no one does at these speeds."""
    found = []
    for place in sorted(set(balance.loads.station.tolist())) if speeds.size else ():
        one = _of(balance, place)
        begun = _begun(one, speeds)
        found += [] if begun is None else [replace(_down(one, begun, float(speeds[0])), station=place)]
    return max((one for one in found if not math.isnan(one.speed)), key=lambda one: one.speed, default=None)


def _first(runs: SlowRuns, balance: Balance, speeds: Floats, found: Capture, in_step: bool = True) -> Capture:
    """The same, or where balls fall back before in a slow run-down, if planes are not in step all the way."""
    known = [one for one in (found.lost, found.step) if not math.isnan(one)]
    if in_step and not known and not math.isnan(found.speed):
        return found
    begin, lowest = float(speeds[-1]), min(balance.rotor.st.critical_speeds, default=float(speeds[0])) / EARLIER
    lowest = lowest if math.isnan(found.speed) else found.speed
    fall = runs.falls(begin, EARLIER * max(known, default=begin), lowest)
    if fall is None or fall.speed < EARLIER * found.speed:
        return found
    station = min(fall.stations) if len(fall.stations) == 1 else None
    before = "" if EARLIER * fall.speed > found.lost else found.reason.replace(SINGLE, "")
    return replace(found, speed=fall.speed, whirl=fall.whirl, cause="run", reason=before, station=station)


def _of(balance: Balance, place: int) -> Balance:
    """Of the groups of one station."""
    return Balance(balance.rotor, balance.loads.some(tuple(np.flatnonzero(balance.loads.station == place).tolist())))


def _again(balance: Balance, speeds: Floats, found: Capture) -> Capture:
    """Where planes lose step: from where on down all stall together, if that is before one of them falls back."""
    for speed in speeds[::-1].tolist():
        here = stands(balance, speed)
        passed = balance.rotor.modes(speed).frequency
        highest = passed[passed < speed].max(initial=0.0)
        stalled = np.flatnonzero((past(balance, here) <= 0.0) | (here.whirl < highest))
        if stalled.size:
            leaving = followed(balance, here.some(stalled[-1:]), found.lost, ("fold", "swinging"))
            if math.isnan(found.speed):
                return replace(found, reason=found.reason + AGAIN.format(leaving.speed))
            together = Capture(leaving.speed, leaving.whirl, "fold", lost=found.lost)
            return together if leaving.speed > found.speed else found
    return found


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
    found, beyond = [], bool(past(balance, leaving.state)[0] > 0.0)
    for place in sorted(set(places.tolist())):
        alone = _of(balance, place)
        below = stands(alone, (1.0 - BESIDE) * speed)
        kept = np.flatnonzero(_in_line(alone, below, beyond, leaving))
        if kept.size:
            found.append(replace(_down(alone, below.some(kept[:1]), lowest), station=place))
        elif below.speed.size:
            found.append(Capture(speed, float(below.whirl[0]), leaving.cause, station=place))
    known = [one for one in found if not math.isnan(one.speed)]
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
    (found,) = balance.found(np.array([speed]))
    return found.some(np.flatnonzero(growth(balance, found) < 0.0))


def _let_down(balance: Balance, speeds: Floats) -> Capture:
    """The same where rolling resistance holds balls at rest: from where on it no longer holds them where they all slip alike."""
    begun = _slipping(balance, speeds)
    if begun is None:
        return Capture(math.nan, reason=HELD)
    speed = float(begun.speed[0])
    slower = stands(balance, (1.0 - 0.1 * BESIDE) * speed)
    if slower.speed.size and slower.whirl[0] > (1.0 - 2.0 * BESIDE) * speed:
        return _down(balance, slower.some(np.array([0])), float(speeds[0]))
    below = stands(balance, (1.0 - BESIDE) * speed)
    return Capture(speed, float(below.whirl[0]) if below.speed.size else math.nan, "fold")


def _slipping(balance: Balance, speeds: Floats) -> States | None:
    """The highest rotor speed at which all groups just begin to slip, none if there is none; of one or two groups."""
    from scipy.optimize import brentq

    if len(balance.loads.groups) > 2:
        return None

    def arcs(at: Floats) -> list[tuple[Floats, Floats]]:
        return balance.arcs(at, balance.rotor.all_modes(at), (at * (1.0 - TINY))[:, None])

    found = []
    for k, (rest, _) in enumerate(arcs(speeds)):
        for i in np.flatnonzero(rest[1:, 0] * rest[:-1, 0] <= 0.0)[-1:]:
            speed = float(
                brentq(
                    lambda w, k=k: float(arcs(np.array([w]))[k][0][0, 0]),
                    speeds[i],
                    speeds[i + 1],
                    xtol=1e-13 * speeds[i],
                )
            )
            phase = float(arcs(np.array([speed]))[k][1][0, 0])
            y = [math.log(TINY), phase][: len(balance.loads.groups)]
            found.append(States(np.array([speed]), np.array([y])))
    return max(found, key=lambda one: float(one.speed[0]), default=None)


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
