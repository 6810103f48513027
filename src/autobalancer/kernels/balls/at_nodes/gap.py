"""How far a long step goes before a gap closes, and whether it may close at all."""

from __future__ import annotations

from typing import Any

from autobalancer.kernels.flags import MERGED, njit
from autobalancer.kernels.pointers import data
from autobalancer.kernels.wide import NODES, amount, greatest, store

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


@njit(**MERGED)
def may_close(gap: Any, bend: Any, step: float) -> bool:
    """Whether a gap may close in the step, at a node or between two."""
    return greatest(-gap) > -DIP * step * step * greatest(amount(bend))
