"""Coefficients of implicit-explicit backward differentiation with variable steps (Ascher, Ruuth and Wetton 1995)."""

from __future__ import annotations

import numpy as np

from autobalancer.flow.annulus import Floats


def backward_differentiation(times: Floats) -> Floats:
    """Weights (1/s) of the values at ``times`` (newest first) in the derivative at the newest."""
    count = times.size
    away = times[0] - times[1:]
    weights = np.empty(count)
    for j in range(1, count):
        others = np.delete(away, j - 1)
        weights[j] = -np.prod(others / (others - away[j - 1])) / away[j - 1]
    weights[0] = -weights[1:].sum()
    return weights


def extrapolation(times: Floats, now: float) -> Floats:
    """Weights of the values at ``times`` in the polynomial through them at ``now``."""
    weights = np.empty(times.size)
    for j in range(times.size):
        others = np.delete(times, j)
        weights[j] = np.prod((now - others) / (times[j] - others))
    return weights
