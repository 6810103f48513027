"""Coefficients of implicit-explicit backward differentiation with variable steps (Ascher, Ruuth and Wetton 1995)."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from autobalancer.flow.annulus import Floats


@lru_cache(maxsize=64)
def weights_of_step(lengths: tuple[float, ...], order: int) -> tuple[Floats, Floats, Floats]:
    """Weights of one step of ``order``; ``lengths`` are this step and those before it, newest first, s.

    Returns
    -------
    tuple
        Derivative at the new instant (new value first, 1/s); extrapolation of the explicit terms to it from ``order``
        instants; extrapolation of the values to it from all instants that ``lengths`` know.
    """
    ago = np.cumsum(lengths)
    return backward_differentiation(ago[:order]), extrapolation(ago[:order]), extrapolation(ago)


def backward_differentiation(ago: Floats) -> Floats:
    """Weights (1/s) of the values now and ``ago`` in the derivative now."""
    slopes = [-np.prod(others / (others - a)) / a for a, others in _with_others(ago)]
    return np.array([-sum(slopes), *slopes])


def extrapolation(ago: Floats) -> Floats:
    """Weights of the values ``ago`` in the polynomial through them, now."""
    return np.array([np.prod(others / (others - a)) for a, others in _with_others(ago)])


def _with_others(ago: Floats) -> list[tuple[float, Floats]]:
    return [(float(a), np.delete(ago, j)) for j, a in enumerate(ago)]
