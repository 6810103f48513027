"""The door for seeds: equal seeds, equal numbers."""

from __future__ import annotations

import numpy as np

from autobalancer.errors import QuestionError

GREATEST = 2**63 - 1  # what a result file can hold


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
