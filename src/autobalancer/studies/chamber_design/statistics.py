"""What few runs tell: intervals of a mean and of a share, and which designs none is better than."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.stats import beta, t

SURE = 0.95  # confidence of all intervals
Floats = NDArray[np.float64]


def mean_interval(values: Sequence[float] | Floats) -> tuple[float, float, float]:
    """Mean, and the ends of its interval by Student's t; infinitely wide of one run. Values that are nan are left out."""
    known = np.asarray(values, np.float64)
    known = known[~np.isnan(known)]
    if not known.size:
        return math.nan, math.nan, math.nan
    mean = float(known.mean())
    if known.size < 2:
        return mean, -math.inf, math.inf
    half = float(t.ppf(0.5 + 0.5 * SURE, known.size - 1) * known.std(ddof=1) / math.sqrt(known.size))
    return mean, mean - half, mean + half


def share_interval(successes: int, runs: int) -> tuple[float, float, float]:
    """Share, and the ends of its exact interval (Clopper and Pearson 1934)."""
    if not runs:
        return math.nan, 0.0, 1.0
    low = float(beta.ppf(0.5 - 0.5 * SURE, successes, runs - successes + 1)) if successes else 0.0
    high = float(beta.ppf(0.5 + 0.5 * SURE, successes + 1, runs - successes)) if successes < runs else 1.0
    return successes / runs, low, high


def worse_than_worst(runs: int) -> float:
    """Share of fillings that are worse than the worst of so many runs, at most, with the confidence of the intervals.

    If the share is p, all runs are better than that with the probability (1 - p)^runs.
    """
    return 1.0 - (1.0 - SURE) ** (1.0 / runs) if runs else 1.0


def fronts(first: Floats, second: Floats) -> NDArray[np.int64]:
    """Number of the front of each point: on front 0 none is better in both; front 1 is that without front 0, and so on.

    Both are better where smaller; points with nan or infinity come last, all on one front.
    """
    found = np.full(first.size, -1, np.int64)
    known = np.isfinite(first) & np.isfinite(second)
    front = 0
    while (left := np.flatnonzero(known & (found < 0))).size:
        a, b = first[left], second[left]
        no_worse = (a[:, None] <= a[None, :]) & (b[:, None] <= b[None, :])
        better = no_worse & ((a[:, None] < a[None, :]) | (b[:, None] < b[None, :]))
        found[left[~better.any(axis=0)]] = front
        front += 1
    found[found < 0] = front
    return found
