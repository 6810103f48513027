"""A branch of stalled states over the speed of the rotor, from a state on it to where balls leave it.

The balances of G groups in log (slip over whirl), G - 1 phases and log speed are a curve; it is followed along its length,
because the speed of the rotor may turn back on it. Balls leave at the first of: a *fold*, beyond which there is no balance near;
*swinging*, where a pair of eigenvalues becomes unstable; *parting*, where balls of one group no longer stay together;
*passing*, where balls beyond a resonance come back to it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np

from autobalancer.arrays import Floats
from autobalancer.progress import check_deadline
from autobalancer.roots import root
from autobalancer.stability.stall.states import STEEP, Balance, Loads, States, Whirling

FIRST, LONGEST = 0.02, 0.25  # steps along the curve; one is a radian, or e of slip over whirl
STRAIGHT = 0.98  # cosine between neighboring tangents
STEPS, AT_ONCE = 400, 8  # at most; points that are tested together
LOST = "lost"  # a branch that could not be followed to its end
SHARP = 1e-5  # of a step, to which a fold is found, so that its speed has twice the digits
NEAR = 0.02  # of a step
HANGING = ("fold", "swinging", "parting")  # of which the first ends what hangs


@dataclass(frozen=True)
class Leaving:
    """Where balls leave a branch; ``cause`` is empty if they do not up to the speed that was asked for."""

    state: States  # one
    cause: str

    @property
    def speed(self) -> float:
        """Of the rotor, rad/s."""
        return float(self.state.speed[0])

    @property
    def whirl(self) -> float:
        """Of the balls, rad/s."""
        return float(self.state.whirl[0])


def followed(balance: Balance, state: States, until: float, causes: tuple[str, ...] = HANGING) -> Leaving:
    """From a stable state towards the rotor speed ``until``, upward or downward, to the first of the ``causes``."""
    sign = 1.0 if until > state.speed[0] else -1.0
    ahead = np.zeros(state.y.shape[1] + 1)
    ahead[-1] = sign
    # the given state on the curve, and the direction towards the goal
    here = corrected(balance, np.append(state.y[0], SPEED_SCALE * math.log(float(state.speed[0]))), ahead)
    if here is None:
        return Leaving(state, LOST)
    here = here if sign * here.along[-1] > 0.0 else Point(here.x, -here.along)
    goal, step, path = SPEED_SCALE * math.log(until), FIRST, [here]
    for _ in range(STEPS):
        # predictor and corrector; exactly to the goal at the end
        rest = (goal - here.x[-1]) / here.along[-1]
        last = 0.0 < rest <= step
        there = corrected(balance, here.x + min(step, rest if last else step) * here.along, here.along, last)
        if there is None or here.along @ there.along < STRAIGHT:
            step *= 0.4
            if step < balance.shortest:
                break
            continue
        if not last and sign * (there.x[-1] - goal) > 0.0:  # gone beyond it
            share = (goal - here.x[-1]) / (there.x[-1] - here.x[-1])
            last, at = True, corrected(balance, here.x + share * (there.x - here.x), here.along, same_speed=True)
            there = there if at is None else at
        # several points at once are tested for whether the balls stay there
        path.append(there)
        folded = "fold" in causes and not sign * there.along[-1] > 0.0
        if folded or last or len(path) > AT_ONCE:
            leaving = _first_leaving(balance, path, sign, causes)
            if leaving is not None or last:
                return Leaving(state_at(there.x), "") if leaving is None else leaving
            path = [there]
        here, step = there, min(1.6 * step, LONGEST)
    leaving = _first_leaving(balance, path, sign, causes) if len(path) > 1 else None
    if leaving is not None:
        return leaving
    # the curve cannot be followed: a turning point so sharp that the state beyond it is sought directly
    state = state_at(here.x)
    if sign < 0.0 or not balance.turns(state):
        return Leaving(state, LOST)
    beyond = balance.ahead(state)
    if beyond is None:
        return Leaving(state, "fold" if "fold" in causes else LOST)
    for cause in causes:
        if cause != "fold" and not _value(balance, beyond, cause)[0] > 0.0:
            return Leaving(beyond, cause)
    return followed(balance, beyond, until, causes)


def _first_leaving(balance: Balance, path: list[Point], sign: float, causes: tuple[str, ...]) -> Leaving | None:
    """Where balls leave first between neighboring points of a path, none if they stay; all points are tested at once."""
    stays = np.array([_tests(balance, path[1:], sign, cause) > 0.0 for cause in causes])
    if stays.all():
        return None
    k = int(np.flatnonzero(~stays.all(axis=0))[0])
    here, there = path[k], path[k + 1]
    shares = {}
    for cause in (cause for i, cause in enumerate(causes) if not stays[i, k]):

        def value(share: float, cause: str = cause) -> float:
            return float(_tests(balance, [_between(balance, here, there, share)], sign, cause)[0])

        try:
            shares[cause] = root(value, 0.0, 1.0, xtol=SHARP if cause == "fold" else SHARP**2)
        except ValueError:
            shares[cause] = 0.0
    # at a fold an eigenvalue is zero, too
    first = min(shares, key=lambda one: shares[one] - (NEAR if one == "fold" else 0.0))
    return Leaving(state_at(_between(balance, here, there, shares[first]).x), first)


def _tests(balance: Balance, points: list[Point], sign: float, cause: str) -> Floats:
    """Above zero at each point where balls stay."""
    if cause == "fold":
        return sign * np.array([point.along[-1] for point in points])
    return _value(balance, state_at(np.array([point.x for point in points])), cause)


def _value(balance: Balance, states: States, cause: str) -> Floats:
    if cause == "swinging":
        return -growth(balance, states)
    return (together if cause == "parting" else past)(balance, states)


def _between(balance: Balance, here: Point, there: Point, share: float) -> Point:
    if share in (0.0, 1.0):
        return there if share else here
    branches = corrected(balance, here.x + share * (there.x - here.x), here.along)
    return here if branches is None else branches


# Points of a branch of stalled states and its direction there, by Newton's method.
#
# Balls with linear drag on supports whose matrices do not change with the speed have compiled equations with exact
# slopes.


SPEED_SCALE = 4.0  # e of the rotor speed counts this many times
DIFFERENCE = 1e-6


class Point(NamedTuple):
    """A point of the curve: log of slip over whirl, phases, scaled log speed, and the direction of the curve there."""

    x: Floats
    along: Floats


def corrected(balance: Balance, x: Floats, like: Floats, same_speed: bool = False) -> Point | None:
    """The nearest point of the curve by Newton's method, its direction on the side of ``like``; none without one."""
    check_deadline()
    # compiled, where the machine allows it
    if balance.numbers is not None:
        from autobalancer.kernels.stalled import branch_point

        here, along = x.copy(), like.copy()
        rotor, push, seen, groups, *room = balance.numbers
        if not branch_point(rotor, push, seen, groups, here, along, SPEED_SCALE, int(same_speed), *room):
            return None
        return Point(here, along) if np.isfinite(along).all() else None
    # Newton's method for one equation less than unknowns: the shortest step
    over_speed = _over_speed(balance, x)  # good enough for Newton's method, not for the direction
    for _ in range(12):
        miss, jacobian = balance.misfit(state_at(x))
        whole = np.column_stack([jacobian[0], over_speed])
        if not np.isfinite(whole).all():
            return None
        if same_speed:
            change = np.append(np.linalg.lstsq(whole[:, :-1], -miss[0], rcond=None)[0], 0.0)
        else:
            change = np.linalg.lstsq(whole, -miss[0], rcond=None)[0]
        size = float(np.abs(change).max())
        if not size < 1.0:
            return None
        x = x + change
        # the direction is the null vector of the slopes
        if size < 1e-9:
            whole[:, -1] = _over_speed(balance, x)
            if not np.isfinite(whole).all():
                return None
            along = np.linalg.svd(whole)[2][-1]
            return Point(x, along if along @ like >= 0.0 else -along)
    return None


def state_at(x: Floats) -> States:
    """The state of a point (G + 1,), or those of several, (n, G + 1)."""
    x = np.atleast_2d(x)
    return States(np.exp(x[:, -1] / SPEED_SCALE), x[:, :-1])


def _over_speed(balance: Balance, x: Floats) -> Floats:
    """Slope of the balances over the scaled log of the rotor speed."""
    state = state_at(x)
    apart = States(np.exp((x[-1] + DIFFERENCE * np.array([1.0, -1.0])) / SPEED_SCALE), np.repeat(state.y, 2, axis=0))
    after, before = balance.misfit(apart)[0]
    return np.asarray((after - before) / (2.0 * DIFFERENCE))


# Whether a stalled state is stable: the equations of motion linearized in axes that turn with its whirl.
#
# There the state is at rest, so that its eigenvalues say everything (on anisotropic supports after the mean over the
# whirl). Small motions: a = (z, z') of the rotor, Da = (S - i v) a + P f, and delta of the groups,
#
#     f = n s e^(i psi) (i v^2 delta + 2 v D delta - i DD delta),    X = e^(-i psi) (R z'' of S a + B f),
#     I DD delta = - s Im(q X) - s v^2 Re(q h) delta - (dT/dW - 2 mu s eps v) D delta,
#
# B f the acceleration that loads give at once. Turning the whole picture changes nothing: one eigenvalue is zero.
# Balls of a group that part from each other leave the whirl alone, so that this motion has its own equation, I DD
# delta + dT/dW D delta + s v^2 Re(q h) delta = 0: they stay together while Re(q h) > 0. With one mode this ends
# exactly at its resonance.


def growth(balance: Balance, states: States) -> Floats:
    """Of groups that stay together: greatest real part of all eigenvalues but the one of turning, 1/s, (n,)."""
    n, loads = states.speed.size, balance.loads
    groups = loads.count.size
    if n == 0:
        return np.zeros(0)
    # modes of the rotor at this speed, and how the groups push and see them in the turning axes
    v, slip, place = states.whirl, states.slip, loads.station
    free, pushed_by, lightness = balance.rotor.free_motion(states.speed)
    turned, rolled = np.exp(1j * states.phases), 1.0 + 1j * balance.rolling
    load, back = (loads.count * loads.moment * turned)[:, None, :], (rolled / turned)[:, :, None]
    count = free.shape[1]
    felt = pushed_by[:, place] * load  # (n, K, G)
    seen = balance.rotor.read[place] @ free[:, count // 2 :] * back  # (n, G, K)
    at_once = lightness[place][:, place] * back * load  # (n, G, G)
    # drag over slip, and the push that holds a group at its phase
    slope = (balance.drag(slip * (1.0 + STEEP)) - balance.drag(slip)) / (STEEP * slip[:, None])
    slope = slope - 2.0 * balance.rolling * loads.moment * balance.orbit * v[:, None]
    held = loads.moment * v[:, None] ** 2 * balance.deflections(states).real
    inertia = np.array([group.ball.inertia for group in loads.groups])
    s, own = loads.moment[None, :, None], np.eye(groups)
    v1 = v[:, None, None]
    # the groups' own equations: inertia with what loads give at once, then slopes over all unknowns
    mass = inertia[None, :, None] * own - s * at_once.real
    by_angle = -s * (1j * v1**2 * at_once).imag - held[:, :, None] * own
    by_rate = -s * (2.0 * v1 * at_once).imag - slope[:, :, None] * own
    by_modes = np.concatenate([-s * seen.imag, -s * seen.real], axis=2)
    # rubber that softens under the whirl changes its stiffness with the deflection
    soft, c = balance.softening(states), count // 2
    if soft is not None:
        read = balance.rotor.read[place] * back
        moved = read.imag @ soft[:, :c] + read.real @ soft[:, c:]
        by_modes[:, :, :c] -= s * moved[:, :, :c]
        by_modes[:, :, count : count + c] -= s * moved[:, :, c:]
    accelerations = np.linalg.solve(mass, np.concatenate([by_modes, by_angle, by_rate], axis=2))  # (n, G, 2K + 2G)
    # one real matrix of modes (real, imaginary), angles and rates
    size = 2 * count + 2 * groups
    whole = np.zeros((n, size, size))
    turns = free - 1j * v1 * np.eye(count)
    whole[:, :count, :count] = whole[:, count : 2 * count, count : 2 * count] = turns.real
    whole[:, :count, count : 2 * count], whole[:, count : 2 * count, :count] = -turns.imag, turns.imag
    if soft is not None:
        for i, rows in enumerate((slice(c, count), slice(count + c, 2 * count))):
            for k, columns in enumerate((slice(0, c), slice(count, count + c))):
                whole[:, rows, columns] += soft[:, i * c : (i + 1) * c, k * c : (k + 1) * c]
    # what the groups' motion does to the rotor
    pushed = -1j * felt @ accelerations
    pushed[:, :, 2 * count : 2 * count + groups] += 1j * v1**2 * felt
    pushed[:, :, 2 * count + groups :] += 2.0 * v1 * felt
    whole[:, :count] += pushed.real
    whole[:, count : 2 * count] += pushed.imag
    whole[:, 2 * count : 2 * count + groups, 2 * count + groups :] = own
    whole[:, 2 * count + groups :] = accelerations
    # the eigenvalue of turning the whole picture does not count
    values = np.linalg.eigvals(whole)
    turning = np.abs(values).argmin(axis=1)
    values[np.arange(n), turning] = -np.inf
    if soft is not None:  # its stiffness is that of changes that are slow against a turn
        values[np.abs(values.imag) > v[:, None]] = -np.inf
    return np.asarray(values.real.max(axis=1))


def together(balance: Balance, states: States) -> Floats:
    """Least of Re(q h) over the orbit radius of the groups of several balls, (n,): above zero they do not part."""
    several = balance.loads.count > 1.0
    if not several.any() or not states.speed.size:
        return np.full(states.speed.size, np.inf)
    return np.asarray((balance.deflections(states).real / balance.orbit)[:, several].min(axis=1))


def past(balance: Balance, states: States) -> Floats:
    """How far balls are beyond the resonance, over the orbit radius, (n,): above zero the whirl moves against them."""
    if not states.speed.size:
        return np.zeros(0)
    weight = balance.loads.count * balance.loads.moment
    return np.asarray(-(balance.deflections(states).real / balance.orbit) @ weight / weight.sum())


# The rotor speeds at which balls can hang at the resonances of any rotor, and where they leave.
#
# Balls of all planes hang together, or those of some planes while the others turn with the rotor and have no mean
# torque on them. For every set of groups all balances are sought on a grid of rotor speeds; stable ones are joined to
# ranges, and the end of each is followed to where balls leave, :mod:`autobalancer.stability.stall.branch`.


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
    result = []
    for chosen in sets(rotor, loads):
        result += of_set(Balance(rotor, loads.some(chosen)), chosen, speeds, limit)
    return result


def furthest_speed(rotor: Whirling, top: float) -> float:
    """To which balls that still hang at ``top`` are followed, rad/s; not beyond the tables of the supports."""
    return _inside(rotor, max(top, min(FURTHEST * top, rotor.st.model.top_speed)))


def _inside(rotor: Whirling, speed: float) -> float:
    """This speed, or just below where tables of the supports end, so that differences over the speed stay within them."""
    end = rotor.st.model.top_speed
    return min(speed, INSIDE * end) if speed <= end else speed


def reached(ranges: list[HangingRange], critical: tuple[float, ...]) -> list[HangingRange]:
    """The ranges into which a slow run-up leads: from a critical speed, or out of another one that ends in it."""
    hanging_ranges = [one for one in ranges if any(one.begin <= MET[1] * w and one.end >= MET[0] * w for w in critical)]
    for hanging_range in hanging_ranges:  # grows as it is walked through
        hanging_ranges += [
            other
            for other in ranges
            if other not in hanging_ranges and other.holds(hanging_range.end) and other.whirl > hanging_range.whirl
        ]
    return hanging_ranges


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
    groups = {tuple(range(count)), *((g,) for g in range(count))}
    modes = rotor.modes(rotor.st.scale_speed)
    for reach in np.abs(modes.right * modes.left)[:, loads.station]:
        order = np.argsort(-loads.moment * np.sqrt(reach), kind="stable")
        groups |= {tuple(sorted(order[:size].tolist())) for size in range(2, count)}
    return sorted(groups, key=lambda chosen: (-len(chosen), chosen))


@dataclass
class _Open:
    """A range that goes on; ``first`` is its number in the grid, ``begin`` nan before balls hang."""

    first: int
    begin: float
    last: States


def of_set(balance: Balance, chosen: tuple[int, ...], speeds: Floats, limit: float) -> list[HangingRange]:
    """The ranges of one set of groups that begin at ``speeds`` (rad/s); none from above ``limit`` is followed further."""
    going: list[_Open] = []
    hanging_ranges: list[HangingRange] = []
    furthest = furthest_speed(balance.rotor, float(speeds[-1]))
    # from speed to speed: stable states that are near those of the speed before are the same ones
    for i, here in enumerate(stable(balance, balance.found(speeds))):
        near = STEP * (np.log(speeds[i] / speeds[i - 1]) / np.log(FINE) if i else 1.0)
        left, lasting = list(range(here.speed.size)), []
        for one in going:
            k = _nearest(one.last, here, left, near)
            if k is not None:
                left.remove(k)
                one.last = here.some(np.array([k]))
            else:
                # one that has no successor is followed to where it ends
                leaving = followed(balance, one.last, float(speeds[i]))
                if leaving.cause:
                    hanging_ranges += _range(balance, chosen, one, leaving)
                    continue
                one.last = leaving.state
                known = _nearest(one.last, here, left, ALIKE)
                if known is not None:
                    left.remove(known)
            lasting.append(one)
        going = lasting + [_Open(i, np.nan, here.some(np.array([k]))) for k in left]
        # a new state belongs to a resonance from the speed on at which it stands beside it
        for one in going:
            if np.isnan(one.begin) and balance.resonant(one.last)[0]:
                one.begin = float(speeds[i])
    # those that are left go on above the grid
    for one in going:
        further = one.begin <= limit  # false of nan
        leaving = followed(balance, one.last, furthest) if further else Leaving(one.last, "")
        hanging_ranges += _range(balance, chosen, one, leaving)
    hanging_ranges.sort(key=lambda one: one.begin)
    return [
        hanging_range
        for i, hanging_range in enumerate(hanging_ranges)
        if not any(hanging_range.same(other) for other in hanging_ranges[:i])
    ]


def stable(balance: Balance, states: list[States]) -> list[States]:
    """Those in which balls stay, their whirl steady and the balls of a group together."""
    every = States(np.concatenate([state.speed for state in states]), np.vstack([state.y for state in states]))
    stays = (growth(balance, every) < 0.0) & (together(balance, every) > 0.0)
    parts = np.split(stays, np.cumsum([state.speed.size for state in states])[:-1])
    return [state.some(np.flatnonzero(part)) for state, part in zip(states, parts, strict=True)]


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
