"""Where the balance of a second group changes its sign along the arcs on which that of the first one holds."""

from __future__ import annotations

import numpy as np

from autobalancer.stability.host.planar import Floats

Starts = tuple[Floats, Floats]


def crossings(speeds: Floats, lag: Floats, rest: Floats, phase: Floats) -> Starts:
    """Where a balance changes its sign between two whirl speeds."""
    at, k = np.nonzero(rest[:, 1:] * rest[:, :-1] <= 0.0)
    share = rest[at, k] / (rest[at, k] - rest[at, k + 1] + 1e-300)
    turn = np.angle(np.exp(1j * (phase[at, k + 1] - phase[at, k])))
    first = lag[at, k] + share * (lag[at, k + 1] - lag[at, k])
    return speeds[at], np.column_stack([first, phase[at, k] + share * turn])


def joints(speeds: Floats, lag: Floats, arcs: list[tuple[Floats, Floats]]) -> list[Starts]:
    """Where it changes its sign from one arc to the other, at an end at which both meet between two whirl speeds."""
    (one, phase), (other, far) = arcs
    known = np.isfinite(one) & np.isfinite(other)
    turn = np.angle(np.exp(1j * (far - phase)))
    found = []
    for here, beyond in ((slice(None, -1), slice(1, None)), (slice(1, None), slice(None, -1))):
        at, k = np.nonzero(known[:, here] & ~known[:, beyond] & (one[:, here] * other[:, here] <= 0.0))
        k = k if here.stop == -1 else k + 1
        y = np.column_stack([lag[at, k], phase[at, k] + 0.5 * turn[at, k]])
        found.append((speeds[at], y))
    return found
