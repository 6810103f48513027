"""When a study knows enough: the interval of a named quantity, looked at after fixed numbers of draws."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import bdtr

from autobalancer.results.shares import Z, wilson_interval

FIRST, GROWTH = 100, 1.25  # draws at the first look, and how many more at each further one


@dataclass(frozen=True)
class Stop:
    """Stop as soon as the 95 % interval of ``of`` has at most this half width, at every point of the grid.

    ``statistic`` is ``share`` (of a quantity that is true or false), ``mean``, or ``quantile`` with its level ``at``.
    ``relative`` is the half width over the value.
    """

    of: str
    statistic: str
    half_width: float = math.inf
    relative: float = math.inf
    at: float = 0.5

    def reached(self, values: Any) -> bool:
        """Whether the draws of one point are enough."""
        value, low, high = interval(self.statistic, values, self.at)
        half = 0.5 * (high - low)
        return bool(half <= self.half_width and half <= self.relative * abs(value))


def looks(most: int) -> list[int]:
    """Numbers of draws after which is looked, the last of them all draws."""
    found, draws = [], float(FIRST)
    while draws < most:
        found.append(int(draws))
        draws *= GROWTH
    return [*found, most]


def interval(statistic: str, values: NDArray[Any], at: float = 0.5) -> tuple[float, float, float]:
    """A statistic of independent draws with its 95 % interval.

    Parameters
    ----------
    statistic
        ``"share"`` (Wilson 1927), ``"mean"`` (normal), or ``"quantile"`` (order statistics, for any distribution).
    values
        One for each draw; those without a number do not count.
    at
        Level of the quantile.

    Returns
    -------
    value, low, high
        Infinite bounds where there are too few draws.
    """
    known = np.asarray(values, np.float64)
    known = np.sort(known[np.isfinite(known)])
    count = known.size
    if count == 0:
        return math.nan, -math.inf, math.inf
    if statistic == "share":
        low, high = wilson_interval(np.array([known.sum()]), count)
        return float(known.mean()), float(low[0]), float(high[0])
    if statistic == "mean":
        half = Z * float(known.std(ddof=1)) / math.sqrt(count) if count > 1 else math.inf
        return float(known.mean()), float(known.mean()) - half, float(known.mean()) + half
    below = np.arange(count + 1)
    reach = bdtr(below, count, at)  # that at most so many lie below the quantile
    low_rank, high_rank = int(np.searchsorted(reach, 0.025)), int(np.searchsorted(reach, 0.975)) + 1
    low_value = float(known[low_rank - 1]) if low_rank >= 1 else -math.inf
    return float(np.quantile(known, at)), low_value, float(known[high_rank - 1]) if high_rank <= count else math.inf
