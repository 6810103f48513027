"""Points of a branch of stalled states and its direction there, by Newton's method.

Balls with linear drag on supports whose matrices do not change with the speed have compiled equations with exact slopes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from autobalancer.patience import still_time
from autobalancer.stability.host.planar import Floats
from autobalancer.stability.stall.states import Balance, States

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
