"""Which ball is which: balls in one race cannot pass each other, so their order around it stays.

The balls that are seen are matched with where they are expected, in the same order around the race; of all such matches the one
with the least sum of squares is taken, by dynamic programming. How much worse the second best would be says how sure it is.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
MISSING = 16.0  # what a ball that is seen, but not matched, costs, in the units of squares of deviations


class Match(NamedTuple):
    """Number of the find of each ball, -1 if it is not seen, and what the second best match would cost more."""

    find: NDArray[np.intp]
    margin: float


def wrapped(angle: Floats) -> Floats:
    """Within -pi to pi."""
    return np.asarray((angle + np.pi) % (2.0 * np.pi) - np.pi)


def matched(expected: Floats, seen: Floats, spread: float) -> Match:
    """Finds for balls.

    Parameters
    ----------
    expected
        Angles of the balls in the order around the race, increasing by less than a turn in all, rad.
    seen
        Angles of the finds in increasing order, rad.
    spread
        Standard deviation of what is expected, rad.
    """
    n, m = expected.size, seen.size
    if m == 0:
        return Match(np.full(n, -1, np.intp), 0.0)
    cost = np.minimum((wrapped(seen[None, :] - expected[:, None]) / spread) ** 2, 1e6)
    options: dict[tuple[int, ...], float] = {}
    for first in range(m):  # the find with which the count begins
        order = (first + np.arange(m)) % m
        total, find = _aligned(cost[:, order])
        chosen = np.where(find >= 0, order[np.maximum(find, 0)], -1)
        key = tuple(chosen.tolist())
        options[key] = min(options.get(key, np.inf), total)
    ranked = sorted(options.items(), key=lambda item: item[1])
    best = np.array(ranked[0][0], np.intp)
    other = next((value for key, value in ranked[1:] if _differs(key, ranked[0][0])), np.inf)
    return Match(best, float(min(other - ranked[0][1], 1e6)))


def _differs(one: tuple[int, ...], other: tuple[int, ...]) -> bool:
    """Whether a ball has another find, not just none."""
    return any(a != b and a >= 0 and b >= 0 for a, b in zip(one, other, strict=True))


def _aligned(cost: Floats) -> tuple[float, NDArray[np.intp]]:
    """Cheapest match in order, (balls, finds); finds and balls may be left out."""
    n, m = cost.shape
    best = np.full((n + 1, m + 1), np.inf)
    best[0, :] = MISSING * np.arange(m + 1)
    best[:, 0] = MISSING * np.arange(n + 1)
    for i in range(1, n + 1):
        for j in range(1, m + 1):
            best[i, j] = min(
                best[i - 1, j - 1] + cost[i - 1, j - 1], best[i - 1, j] + MISSING, best[i, j - 1] + MISSING
            )
    find, i, j = np.full(n, -1, np.intp), n, m
    while i and j:
        if best[i, j] == best[i - 1, j - 1] + cost[i - 1, j - 1]:
            i, j = i - 1, j - 1
            find[i] = j
        elif best[i, j] == best[i - 1, j] + MISSING:
            i -= 1
        else:
            j -= 1
    return float(best[n, m]), find
