"""How far a long step goes before a contact closes or opens, with balls of the stations of a linear rotor.

Soft contacts are open all the time. Rigid ones that are closed stay so while they press.
"""

from __future__ import annotations

from typing import Any

from numba import njit

from autobalancer.kernels.balls.at_nodes.clusters import pressed_until, simple
from autobalancer.kernels.balls.at_nodes.gap import open_until
from autobalancer.kernels.flags import COMPILED, MERGED
from autobalancer.kernels.integrators.collocation.amplitudes import amplitudes_at
from autobalancer.kernels.pointers import behind, data
from autobalancer.kernels.system import BALLS, system_at
from autobalancer.kernels.wide import NODES, load


@njit(**MERGED)
def _gaps(step: float, p: Any, a: Any) -> float:
    """The fraction of the step up to which all contacts that are open stay so."""
    values, forces, start = data(a.values), data(a.forces), data(a.origin)
    angles, own, until = 2 * a.modes + 2, 2 * a.modes + 1, 1.0
    for i in range(a.balls):
        pair, closed, low, high = p.contacts[i], False, False, False
        if p.guided[i].bound != 0:
            its = p.ties[i]
            closed, low, high = its.joined != 0, its.low != 0, its.high != 0
        angle, bend = load(values, (angles + i) * NODES), load(forces, (own + i) * NODES)
        if (pair.hard > 0.0 or pair.rigid > 0) and not closed:
            other = pair.next
            ahead = pair.wrap - pair.touch
            gap = load(values, (angles + other) * NODES) - angle + ahead
            turned = load(forces, (own + other) * NODES) - bend
            now = start[BALLS + other] - start[BALLS + i] + ahead
            until = min(until, open_until(now, gap, turned, step, a))
        if pair.wall_hard > 0.0 or pair.wall_rigid > 0:
            now = start[BALLS + i]
            if not low:
                until = min(until, open_until(now - pair.wall_low, angle - pair.wall_low, bend, step, a))
            if not high:
                until = min(until, open_until(pair.wall_high - now, pair.wall_high - angle, bend, step, a))
    return until


@njit(**COMPILED)
def contacts_at_nodes(step: float, system: Any, amplitudes: Any) -> float:
    """The fraction of a long step up to which contacts stay open, or pressed where balls are in rigid contact."""
    p, a = behind(system_at(system)), behind(amplitudes_at(amplitudes))
    if p.rigid.bound[0] == 0:
        return float(_gaps(step, p, a))
    if not simple(p):
        return 0.0
    return float(min(_gaps(step, p, a), pressed_until(p, a)))
