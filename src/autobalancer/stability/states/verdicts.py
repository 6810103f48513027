"""When a state is stable."""

from __future__ import annotations

from autobalancer.stability.host.planar import Complexes
from autobalancer.stability.states.linear import kept

MARGIN = 1e-9  # growth rates up to this share of the speed count as zero


def growth(values: Complexes, freedom: int) -> float:
    """Greatest real part that counts: without the zeros of a continuum, 1/s."""
    return float(kept(values, freedom).real.max())


def verdict(rate: float, speed: float) -> str:
    """stable, marginal or unstable."""
    if abs(rate) <= MARGIN * speed:
        return "marginal"
    return "unstable" if rate > 0.0 else "stable"
