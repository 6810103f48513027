"""The averaged border from the eigenvalue problem of the averaged equations, by root finding."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np
from scipy.optimize import brentq

from autobalancer.errors import QuestionError
from autobalancer.stability.averaged.equations import (
    Given,
    averaged_growth_rate,
    averaged_plane,
    balanced_growth_rate,
)
from autobalancer.stability.border import Border
from autobalancer.stability.host.planar import Plane
from autobalancer.stability.states.planar import Equilibrium
from autobalancer.stability.states.polygon import directions

SEARCHED = 40.0  # borders are sought up to so many times the critical speed
POINTS = 400


def averaged_border(
    machine: Given,
    unbalance: complex | float | str | None = None,
    *,
    worst_case: bool = False,
    searched: tuple[float, float] | None = None,
) -> Border:
    """Averaged border of a planar rotor from the eigenvalue problem (4.69) by root finding.

    Arguments and answer are those of :func:`autobalancer.stability.averaged_border`.

    Raises
    ------
    QuestionError
        If a ball has no drag, or the worst case is asked of an eccentric race.
    """
    p = averaged_plane(machine, unbalance)
    critical = math.sqrt(max(p.stiffness) / p.mass)
    low, high = searched or (critical, SEARCHED * critical)
    if not worst_case:
        return Border("averaged border", *_search(lambda w: balanced_growth_rate(p, w), low, high))
    if np.any(p.offset != 0.0):
        raise QuestionError("averaged border: the worst case over the unbalance needs races on the axis of the rotor")
    found = [_search(partial(averaged_growth_rate, p, state=s), low, high) for s in worst_states(p)]
    speed, note = max(found, key=lambda pair: pair[0])
    return Border("averaged border, worst case", speed, note)


def _search(rate: Callable[[float], float], low: float, high: float) -> tuple[float, str]:
    speeds = low + np.geomspace(1e-7 * low, high - low, POINTS)
    rates = np.array([rate(speed) for speed in speeds])
    if np.isnan(rates[-1]):
        return math.nan, "there is no balanced state"
    unstable = np.flatnonzero(~(rates < 0.0))
    if unstable.size == 0:
        return low, ""
    last = int(unstable[-1])
    if last == POINTS - 1:
        return math.inf, f"none up to {high:.6g} rad/s"
    if np.isnan(rates[last]):
        return float(speeds[last + 1]), "there is no balanced state below"
    return float(brentq(rate, speeds[last], speeds[last + 1], xtol=1e-12 * high, rtol=1e-13)), ""


def worst_states(p: Plane) -> list[Equilibrium]:
    """Isotropic: the ball positions of least |g2|. Orthotropic: positions from there to all balls in line."""
    weight = p.moment**2 / p.drag
    g = float(weight.sum())
    least = max(0.0, 2.0 * float(weight.max()) - g)
    levels = [least] if p.isotropic else list(np.linspace(least, g, 19))
    doubled = [directions(weight, complex(level)) for level in levels]
    freedom = max(weight.size - 2, 0)
    return [Equilibrium("balanced", 0.5 * angles, 0j, freedom, 0) for angles in doubled if angles is not None]
