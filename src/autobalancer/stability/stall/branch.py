"""A branch of stalled states over the speed of the rotor, from a state on it to where balls leave it.

The balances of G groups in log (slip over whirl), G - 1 phases and log speed are a curve; it is followed along its length,
because the speed of the rotor may turn back on it. Balls leave at the first of: a *fold*, beyond which there is no balance near;
*swinging*, where a pair of eigenvalues becomes unstable; *parting*, where balls of one group no longer stay together;
*passing*, where balls beyond a resonance come back to it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from autobalancer.patience import still_time
from autobalancer.stability.host.planar import Floats
from autobalancer.stability.stall.linear import growth, past, together
from autobalancer.stability.stall.states import Balance, States

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
    here = corrected(balance, np.append(state.y[0], SPEED_SCALE * math.log(float(state.speed[0]))), ahead)
    if here is None:
        return Leaving(state, LOST)
    here = here if sign * here.along[-1] > 0.0 else Point(here.x, -here.along)
    goal, step, path = SPEED_SCALE * math.log(until), FIRST, [here]
    for _ in range(STEPS):
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
        path.append(there)
        folded = "fold" in causes and not sign * there.along[-1] > 0.0
        if folded or last or len(path) > AT_ONCE:
            leaving = _left(balance, path, sign, causes)
            if leaving is not None or last:
                return Leaving(state_at(there.x), "") if leaving is None else leaving
            path = [there]
        here, step = there, min(1.6 * step, LONGEST)
    leaving = _left(balance, path, sign, causes) if len(path) > 1 else None
    if leaving is not None:
        return leaving
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


def _left(balance: Balance, path: list[Point], sign: float, causes: tuple[str, ...]) -> Leaving | None:
    """Where balls leave first between neighboring points of a path, none if they stay; all points are tested at once."""
    stays = np.array([_tests(balance, path[1:], sign, cause) > 0.0 for cause in causes])
    if stays.all():
        return None
    k = int(np.flatnonzero(~stays.all(axis=0))[0])
    here, there = path[k], path[k + 1]
    shares = {cause: _share(balance, here, there, sign, cause) for i, cause in enumerate(causes) if not stays[i, k]}
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


def _share(balance: Balance, here: Point, there: Point, sign: float, cause: str) -> float:
    """Of the way from one point to the next at which balls leave."""
    from scipy.optimize import brentq

    def value(share: float) -> float:
        return float(_tests(balance, [_between(balance, here, there, share)], sign, cause)[0])

    try:
        return float(brentq(value, 0.0, 1.0, xtol=SHARP if cause == "fold" else SHARP**2))
    except ValueError:
        return 0.0


def _between(balance: Balance, here: Point, there: Point, share: float) -> Point:
    if share in (0.0, 1.0):
        return there if share else here
    found = corrected(balance, here.x + share * (there.x - here.x), here.along)
    return here if found is None else found


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
    still_time()
    if balance.numbers is not None:
        from autobalancer.kernels.stalled import branch_point

        here, along = x.copy(), like.copy()
        rotor, push, seen, groups, *room = balance.numbers
        if not branch_point(rotor, push, seen, groups, here, along, SPEED_SCALE, int(same_speed), *room):
            return None
        return Point(here, along) if np.isfinite(along).all() else None
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
