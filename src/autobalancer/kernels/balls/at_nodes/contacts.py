"""How far a long step goes before a soft contact closes, and whether a rigid one closes or opens in it.

Soft contacts are open all the time. Where a rigid one may change, the switch of the equations finds the instant inside the step.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from autobalancer.kernels.balls.at_nodes.clusters import least_torque, rest_at_nodes, simple
from autobalancer.kernels.balls.at_nodes.gap import may_close, open_until
from autobalancer.kernels.balls.rigid.torques import LEAST, PULL
from autobalancer.kernels.flags import ADDRESSED, MERGED, njit
from autobalancer.kernels.integrators.collocation.amplitudes import SWITCHES, amplitudes_at
from autobalancer.kernels.pointers import behind, data
from autobalancer.kernels.system import BALLS, system_at
from autobalancer.kernels.wide import NODES, load


@njit(**MERGED)
def _gaps(step: float, p: Any, a: Any) -> tuple[float, bool]:
    """The fraction of the step up to which all soft contacts stay open, and whether a rigid one may close."""
    values, forces, start = data(a.values), data(a.forces), data(a.origin)
    angles, own, until, closing = 2 * a.modes + 2, 2 * a.modes + 1, 1.0, False
    for i in range(a.balls):
        pair = p.contacts[i]
        soft, rigid = pair.hard > 0.0, pair.rigid > 0 and p.ties[i].joined == 0
        soft_wall, rigid_wall = pair.wall_hard > 0.0, pair.wall_rigid > 0
        if not (soft or rigid or soft_wall or rigid_wall):
            continue
        angle, bend, now = load(values, (angles + i) * NODES), load(forces, (own + i) * NODES), start[BALLS + i]
        if soft or rigid:
            other = pair.next
            ahead = pair.wrap - pair.touch
            gap = load(values, (angles + other) * NODES) - angle + ahead
            turned = load(forces, (own + other) * NODES) - bend
            if soft:
                until = min(until, open_until(start[BALLS + other] - now + ahead, gap, turned, step, a))
            else:
                closing = closing or may_close(gap, turned, step)
        if soft_wall:
            until = min(until, open_until(now - pair.wall_low, angle - pair.wall_low, bend, step, a))
            until = min(until, open_until(pair.wall_high - now, pair.wall_high - angle, bend, step, a))
        elif rigid_wall:
            closing = closing or (p.ties[i].low == 0 and may_close(angle - pair.wall_low, bend, step))
            closing = closing or (p.ties[i].high == 0 and may_close(pair.wall_high - angle, bend, step))
    return until, closing


@njit(**MERGED)
def contacts_until(rest: Callable[[int, Any, Any], Any], step: float, p: Any, a: Any) -> float:
    """The fraction of the step up to which all soft contacts stay open; SWITCHES if a rigid one may close or open.

    0 where balls that touch rub or fill their race: their torques take more than the balls' own rows, see ``rest`` of
    :func:`autobalancer.kernels.balls.at_nodes.clusters.least_torque`.
    """
    if p.rigid.bound[0] > 0 and not simple(p):
        return 0.0
    until, closing = _gaps(step, p, a)
    if p.rigid.bound[0] > 0:
        p.rigid.margin[LEAST] = least_torque(rest, p, a)
        closing = closing or not p.rigid.margin[LEAST] >= -2.0 * p.rigid.margin[PULL]
    return SWITCHES if closing and until == 1.0 else until


@njit(**ADDRESSED)
def contacts_at_nodes(step: float, system: Any, amplitudes: Any) -> float:
    """:func:`contacts_until` of balls at the stations of a linear rotor."""
    p, a = behind(system_at(system)), behind(amplitudes_at(amplitudes))
    return float(contacts_until(rest_at_nodes, step, p, a))
