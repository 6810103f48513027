"""How far balls go in a long step before a contact changes: between neighbors of a race, or with a partition."""

from __future__ import annotations

from typing import Any

from numba import njit

from autobalancer.kernels.balls.at_nodes.gap import DIP, open_until
from autobalancer.kernels.balls.planar_nodes import EACH, LEAN_X, LEAN_Y, ROW, SPIN
from autobalancer.kernels.balls.rigid.clusters import leads
from autobalancer.kernels.balls.rigid.torques import FAR, LEAST, PULL
from autobalancer.kernels.flags import COMPILED, MERGED
from autobalancer.kernels.integrators.collocation.amplitudes import SWITCHES, amplitudes_at
from autobalancer.kernels.pointers import behind, data
from autobalancer.kernels.system import BALLS, system_at
from autobalancer.kernels.wide import NODES, all_lanes, amount, greater, greatest, load


@njit(**MERGED)
def _may_close(gap: Any, bend: Any, step: float) -> bool:
    """Whether a gap may close in the step, at a node or between two."""
    return greatest(-gap) > -DIP * step * step * greatest(amount(bend))


@njit(**MERGED)
def _least_torque(p: Any, a: Any) -> float:
    """The least torque of all rigid contacts that are closed, at the nodes; FAR without any."""
    forces, work, size, count = data(a.forces), data(a.balls_work), 2 * a.modes, a.balls
    ax, ay, turn = load(work, EACH * count), load(work, EACH * count + NODES), load(forces, size * NODES)
    least = all_lanes(FAR)
    for head in range(count):
        if not leads(p, head):
            continue
        rate, low = load(forces, (size + 1 + head) * NODES), p.ties[head].low != 0
        whole = all_lanes(0.0)
        if low:  # the partition behind carries what the balls ahead do not
            k, more = head, True
            while more:
                place, more = EACH * k, p.ties[k].joined == 1
                whole += load(work, place + ROW) - load(work, place + SPIN) * turn
                whole -= load(work, place + LEAN_X) * ax + load(work, place + LEAN_Y) * ay
                k = p.contacts[k].next
            least = -greater(-least, whole)
        carried = -whole
        k, more = head, True
        while more:
            its, place = p.ties[k], EACH * k
            carried += load(work, place + ROW) - load(work, place + SPIN) * turn - rate * p.balls[k].inertia
            carried -= load(work, place + LEAN_X) * ax + load(work, place + LEAN_Y) * ay
            more = its.joined == 1
            if more or its.high != 0:
                least = -greater(-least, -carried)
            k = p.contacts[k].next
    return -greatest(-least)


@njit(**COMPILED)
def contacts_in_steps(step: float, system: Any, amplitudes: Any) -> float:
    """The fraction of a long step up to which all soft contacts stay open; SWITCHES if a rigid one may close or open.

    0 also where balls rub on each other or have no play: their torques take more than the balls' own rows.
    """
    p, a = behind(system_at(system)), behind(amplitudes_at(amplitudes))
    values, forces, start = data(a.values), data(a.forces), data(a.origin)
    angles, own, until, closing = 2 * a.modes + 2, 2 * a.modes + 1, 1.0, False
    for i in range(a.balls):
        pair = p.contacts[i]
        if pair.hard == 0.0 and pair.wall_hard == 0.0 and pair.rigid == 0 and pair.wall_rigid == 0:
            continue
        angle, bend = load(values, (angles + i) * NODES), load(forces, (own + i) * NODES)
        if pair.hard > 0.0 or pair.rigid > 0:
            other = pair.next
            ahead = pair.wrap - pair.touch
            gap = load(values, (angles + other) * NODES) - angle + ahead
            turned = load(forces, (own + other) * NODES) - bend
            if pair.hard > 0.0:
                now = start[BALLS + other] - start[BALLS + i] + ahead
                until = min(until, open_until(now, gap, turned, step, a))
            elif p.ties[i].joined == 0:
                closing = closing or _may_close(gap, turned, step)
            elif p.ties[i].joined == 2 or pair.rub > 0.0:
                return 0.0
        if pair.wall_hard > 0.0:
            now = start[BALLS + i]
            until = min(until, open_until(now - pair.wall_low, angle - pair.wall_low, bend, step, a))
            until = min(until, open_until(pair.wall_high - now, pair.wall_high - angle, bend, step, a))
        elif pair.wall_rigid > 0:
            its = p.ties[i]
            if its.low != 0 and its.high != 0:
                return 0.0
            if its.low == 0:
                closing = closing or _may_close(angle - pair.wall_low, bend, step)
            if its.high == 0:
                closing = closing or _may_close(pair.wall_high - angle, bend, step)
    if p.rigid.bound[0] > 0:
        p.rigid.margin[LEAST] = _least_torque(p, a)
        closing = closing or not p.rigid.margin[LEAST] >= -2.0 * p.rigid.margin[PULL]
    return SWITCHES if closing and until == 1.0 else until
