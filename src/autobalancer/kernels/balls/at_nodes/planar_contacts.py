"""How far balls on a planar rotor go in a long step before a contact changes."""

from __future__ import annotations

from typing import Any

from autobalancer.kernels.balls.at_nodes.contacts import contacts_until
from autobalancer.kernels.balls.planar_nodes import EACH, LEAN_X, LEAN_Y, PUSH, ROW, SHARE_X, SHARE_Y, SPIN, TWIST
from autobalancer.kernels.flags import ADDRESSED, MERGED, njit
from autobalancer.kernels.integrators.collocation.amplitudes import amplitudes_at
from autobalancer.kernels.pointers import behind, data
from autobalancer.kernels.system import system_at
from autobalancer.kernels.wide import NODES, load


@njit(**MERGED)
def _rest(k: int, p: Any, a: Any) -> Any:
    """What the contacts must add to ball k, negative: its row less its inertia times its acceleration."""
    forces, work, size, place = data(a.forces), data(a.balls_work), 2 * a.modes, EACH * k
    ax, ay = load(work, EACH * a.balls), load(work, EACH * a.balls + NODES)
    acceleration = load(forces, size * NODES)
    free = load(work, place + ROW) - load(work, place + SPIN) * acceleration
    free -= load(work, place + LEAN_X) * ax + load(work, place + LEAN_Y) * ay
    rate = load(work, place + PUSH) - load(work, place + TWIST) * acceleration
    rate -= load(work, place + SHARE_X) * ax + load(work, place + SHARE_Y) * ay
    return free - rate * p.balls[k].inertia


@njit(**ADDRESSED)
def contacts_in_steps(step: float, system: Any, amplitudes: Any) -> float:
    """:func:`contacts_until` of balls on a planar rotor."""
    p, a = behind(system_at(system)), behind(amplitudes_at(amplitudes))
    return float(contacts_until(_rest, step, p, a))
