"""Shares of many runs, and how certain they are."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Z = 1.959964  # of a normal distribution, for 95 %


def wilson_interval(counts: NDArray[Any], total: int | NDArray[Any]) -> tuple[Floats, Floats]:
    """95 % interval of shares (Wilson 1927): of ``counts`` in ``total``."""
    share = counts / total
    middle = (share + Z * Z / (2 * total)) / (1 + Z * Z / total)
    half = Z / (1 + Z * Z / total) * np.sqrt(share * (1 - share) / total + Z * Z / (4 * total**2))
    return np.maximum(middle - half, 0.0), np.minimum(middle + half, 1.0)
