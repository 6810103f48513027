"""The rotor speeds at which balls can hang at the resonances of any rotor, and where they leave.

Balls of all planes hang together, or those of some planes while the others turn with the rotor and have no mean torque on them.
For every set of groups all balances are sought on a grid of rotor speeds; stable ones are joined to ranges, and the end of
each is followed to where balls leave, :mod:`autobalancer.stability.stall.branch`.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from autobalancer.stability.host.planar import Floats
from autobalancer.stability.stall.branch import Leaving, followed
from autobalancer.stability.stall.groups import Loads
from autobalancer.stability.stall.linear import growth, together
from autobalancer.stability.stall.states import Balance, States
from autobalancer.stability.stall.whirling import Whirling

FINE, COARSE = 1.02, 1.1  # ratios of neighboring speeds
INSIDE = 1.0 - 1e-6  # of the highest speed in tables of the supports
FURTHEST = 100.0  # speeds, in highest ones of the grid, to which balls that still hang there are followed
FAR = 2.5  # critical speeds above the highest from which the grid is coarse
BELOW = 0.8  # of the lowest critical speed, where the grid begins
SETS = 3  # groups of which all sets are tried
MET = (0.85, 1.16)  # a run-up meets a range that begins below, and ends above, so many critical speeds
ALIKE = 1e-4
STEP = 0.3  # change of log (slip over whirl), or of a phase, between speeds of the fine grid; of log whirl, of any grid


@dataclass(frozen=True)
class HangingRange:
    """Rotor speeds between which balls can hang at one resonance, rad/s, and their ``whirl`` speed at the end.

    ``end`` is infinite if they still do at the highest speed that was asked for; ``cause`` says why they leave, as in
    :mod:`autobalancer.stability.stall.branch`.
    """

    groups: tuple[int, ...]  # that hang, by their numbers
    begin: float
    end: float
    whirl: float
    cause: str
    state: States  # the last
    slips: tuple[float, ...] = ()  # of all groups a little before the end of a slow run, if that has another end, rad/s

    def same(self, other: HangingRange) -> bool:
        """Whether both end in one place, where one was begun twice."""
        ends = abs(self.end - other.end) <= ALIKE * self.end if np.isfinite(self.end) else self.end == other.end
        return bool(ends and abs(self.whirl - other.whirl) <= ALIKE * self.whirl)

    def holds(self, speed: float) -> bool:
        """Whether a rotor speed is in the range."""
        return self.begin <= speed <= self.end


def hanging_ranges(rotor: Whirling, loads: Loads, top: float, limit: float = np.inf) -> list[HangingRange]:
    """All ranges that begin below the rotor speed ``top`` (rad/s), set by set; none from above ``limit`` is followed further."""
    speeds = grid(rotor, _inside(rotor, top))
    found = []
    for chosen in sets(rotor, loads):
        found += of_set(Balance(rotor, loads.some(chosen)), chosen, speeds, limit)
    return found


def furthest_speed(rotor: Whirling, top: float) -> float:
    """To which balls that still hang at ``top`` are followed, rad/s; not beyond the tables of the supports."""
    return _inside(rotor, max(top, min(FURTHEST * top, rotor.st.model.top_speed)))


def _inside(rotor: Whirling, speed: float) -> float:
    """This speed, or just below where tables of the supports end, so that differences over the speed stay within them."""
    end = rotor.st.model.top_speed
    return min(speed, INSIDE * end) if speed <= end else speed


def reached(ranges: list[HangingRange], critical: tuple[float, ...]) -> list[HangingRange]:
    """The ranges into which a slow run-up leads: from a critical speed, or out of another one that ends in it."""
    found = [one for one in ranges if any(one.begin <= MET[1] * w and one.end >= MET[0] * w for w in critical)]
    for one in found:  # grows as it is walked through
        found += [other for other in ranges if other not in found and other.holds(one.end) and other.whirl > one.whirl]
    return found


def grid(rotor: Whirling, top: float) -> Floats:
    """Rotor speeds at which states are sought, ascending."""
    critical = [w for w in rotor.st.critical_speeds if w < top]
    start = BELOW * min([*critical, *rotor.modes(0.0).frequency[:1], top])
    fine = min(FAR * max([*critical, *rotor.modes(0.0).frequency[:1]]), top)
    parts = [np.geomspace(start, fine, max(round(np.log(fine / start) / np.log(FINE)), 2))]
    if fine < top:
        parts.append(np.geomspace(fine, top, max(round(np.log(top / fine) / np.log(COARSE)), 1) + 1)[1:])
    return np.concatenate(parts)


def sets(rotor: Whirling, loads: Loads) -> list[tuple[int, ...]]:
    """Groups that may hang together: all sets of a few groups, else each alone, all, and the strongest ones of each mode."""
    count = len(loads.groups)
    if count <= SETS:
        return [chosen for size in range(count, 0, -1) for chosen in combinations(range(count), size)]
    found = {tuple(range(count)), *((g,) for g in range(count))}
    modes = rotor.modes(rotor.st.scale_speed)
    for reach in np.abs(modes.right * modes.left)[:, loads.station]:
        order = np.argsort(-loads.moment * np.sqrt(reach), kind="stable")
        found |= {tuple(sorted(order[:size].tolist())) for size in range(2, count)}
    return sorted(found, key=lambda chosen: (-len(chosen), chosen))


@dataclass
class _Open:
    """A range that goes on; ``first`` is its number in the grid, ``begin`` nan before balls hang."""

    first: int
    begin: float
    last: States


def of_set(balance: Balance, chosen: tuple[int, ...], speeds: Floats, limit: float) -> list[HangingRange]:
    """The ranges of one set of groups that begin at ``speeds`` (rad/s); none from above ``limit`` is followed further."""
    going: list[_Open] = []
    found: list[HangingRange] = []
    furthest = furthest_speed(balance.rotor, float(speeds[-1]))
    for i, here in enumerate(stable(balance, balance.found(speeds))):
        near = STEP * (np.log(speeds[i] / speeds[i - 1]) / np.log(FINE) if i else 1.0)
        left, lasting = list(range(here.speed.size)), []
        for one in going:
            k = _nearest(one.last, here, left, near)
            if k is not None:
                left.remove(k)
                one.last = here.some(np.array([k]))
            else:
                leaving = followed(balance, one.last, float(speeds[i]))
                if leaving.cause:
                    found += _range(balance, chosen, one, leaving)
                    continue
                one.last = leaving.state
                known = _nearest(one.last, here, left, ALIKE)
                if known is not None:
                    left.remove(known)
            lasting.append(one)
        going = lasting + [_Open(i, np.nan, here.some(np.array([k]))) for k in left]
        for one in going:
            if np.isnan(one.begin) and balance.resonant(one.last)[0]:
                one.begin = float(speeds[i])
    for one in going:
        further = one.begin <= limit  # false of nan
        leaving = followed(balance, one.last, furthest) if further else Leaving(one.last, "")
        found += _range(balance, chosen, one, leaving)
    found.sort(key=lambda one: one.begin)
    return [one for i, one in enumerate(found) if not any(one.same(other) for other in found[:i])]


def stable(balance: Balance, found: list[States]) -> list[States]:
    """Those in which balls stay, their whirl steady and the balls of a group together."""
    every = States(np.concatenate([one.speed for one in found]), np.vstack([one.y for one in found]))
    stays = (growth(balance, every) < 0.0) & (together(balance, every) > 0.0)
    parts = np.split(stays, np.cumsum([one.speed.size for one in found])[:-1])
    return [one.some(np.flatnonzero(part)) for one, part in zip(found, parts, strict=True)]


def _nearest(last: States, here: States, left: list[int], near: float) -> int | None:
    whirl = np.abs(np.log(here.whirl / last.whirl))

    def apart(k: int) -> float:
        turned = np.abs(np.angle(np.exp(1j * (here.y[k, 1:] - last.y[0, 1:])))).max(initial=0.0)
        return max(abs(float(here.y[k, 0] - last.y[0, 0])), float(turned))

    best = min((k for k in left if whirl[k] < STEP), key=apart, default=None)
    return best if best is not None and apart(best) < near else None


def _range(balance: Balance, chosen: tuple[int, ...], one: _Open, leaving: Leaving) -> list[HangingRange]:
    """A range that ended; none if balls do not hang at its end."""
    if not balance.resonant(leaving.state)[0]:
        return []
    begin = one.begin if one.begin <= leaving.speed else leaving.speed
    end = leaving.speed if leaving.cause else np.inf
    return [HangingRange(chosen, begin, end, leaving.whirl, leaving.cause, leaving.state)]
