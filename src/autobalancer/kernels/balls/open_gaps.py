"""How far balls go in a long step before a contact closes: between neighbors of a race, or with a partition."""

from __future__ import annotations

from typing import Any

from numba import njit

from autobalancer.kernels.flags import COMPILED, MERGED
from autobalancer.kernels.integrators.collocation.amplitudes import amplitudes_at
from autobalancer.kernels.pointers import behind, data
from autobalancer.kernels.system import BALLS, system_at
from autobalancer.kernels.wide import NODES, amount, greatest, load, store

DIP = 0.005  # of the step squared times the relative acceleration: how far a gap can dip between two nodes, 0.2^2 / 8


@njit(**MERGED)
def open_until(start: float, gap: Any, bend: Any, step: float, a: Any) -> float:
    """The fraction of the step up to which a gap stays open, 1 if it does; 0 where it is closed at the begin."""
    nodes, work = data(a.radau.nodes), data(a.work)
    dip = DIP * step * step * greatest(amount(bend))
    if not start > dip:
        return 0.0
    store(gap, work, 0)
    for i in range(NODES):
        if not work[i] > dip:
            return nodes[i - 1] if i > 0 else 0.0
    return 1.0


@njit(**COMPILED)
def open_gaps(step: float, system: Any, amplitudes: Any) -> float:
    """The fraction of a long step up to which all contacts stay open."""
    p, a = behind(system_at(system)), behind(amplitudes_at(amplitudes))
    values, forces, start = data(a.values), data(a.forces), data(a.origin)
    angles, own, until = 2 * a.modes + 2, 2 * a.modes + 1, 1.0
    for i in range(a.balls):
        pair = p.contacts[i]
        angle, bend = load(values, (angles + i) * NODES), load(forces, (own + i) * NODES)
        if pair.hard > 0.0 or pair.rigid > 0:
            other = pair.next
            ahead = pair.wrap - pair.touch
            gap = load(values, (angles + other) * NODES) - angle + ahead
            turned = load(forces, (own + other) * NODES) - bend
            now = start[BALLS + other] - start[BALLS + i] + ahead
            until = min(until, open_until(now, gap, turned, step, a))
        if pair.wall_hard > 0.0 or pair.wall_rigid > 0:
            now = start[BALLS + i]
            until = min(until, open_until(now - pair.wall_low, angle - pair.wall_low, bend, step, a))
            until = min(until, open_until(pair.wall_high - now, pair.wall_high - angle, bend, step, a))
    return until
