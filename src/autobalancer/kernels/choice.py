"""A choice between two numbers that both are known: the form of a branch that also serves several lanes at once."""

from __future__ import annotations

from numba import njit

from autobalancer.kernels.flags import INLINE


@njit(**INLINE)
def where(condition: bool, one: float, other: float) -> float:
    """``one`` if the condition holds, else ``other``."""
    return one if condition else other
