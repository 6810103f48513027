"""The door for seeds: equal seeds, equal numbers; and how certain shares of random runs are."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError

GREATEST = 2**63 - 1  # what a result file can hold
Z = 1.959964  # of a normal distribution, for 95 %


def generator(seed: int, *more: int) -> np.random.Generator:
    """Random numbers that depend on ``seed`` (and ``more``) only.

    Raises
    ------
    QuestionError
        If the seed is not a whole number from 0 to 2^63 - 1.
    """
    if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or not 0 <= seed <= GREATEST:
        raise QuestionError(f"seed: given {seed!r}; must be a whole number from 0 to {GREATEST}")
    return np.random.default_rng((int(seed), *more) if more else int(seed))


def wilson_interval(counts: NDArray[Any], total: int | NDArray[Any]) -> tuple[Floats, Floats]:
    """95 % interval of shares (Wilson 1927): of ``counts`` in ``total``."""
    share = counts / total
    middle = (share + Z * Z / (2 * total)) / (1 + Z * Z / total)
    half = Z / (1 + Z * Z / total) * np.sqrt(share * (1 - share) / total + Z * Z / (4 * total**2))
    return np.maximum(middle - half, 0.0), np.minimum(middle + half, 1.0)
