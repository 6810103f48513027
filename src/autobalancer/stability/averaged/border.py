"""The averaged border from the eigenvalue problem of the averaged equations, by root finding."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.stability.averaged.equations import (
    Given,
    averaged_plane,
    balanced_growth_rate,
)
from autobalancer.stability.averaged.rates import growth_rates, one_center, spreads_of
from autobalancer.stability.border import Border
from autobalancer.stability.host.planar import Floats, Plane

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
        return Border("averaged border", *_search(partial(balanced_growth_rates, p), low, high))
    if np.any(p.offset != 0.0):
        raise QuestionError("averaged border: the worst case over the unbalance needs races on the axis of the rotor")
    found = [_search(partial(growth_rates, p, spreads=one), low, high) for one in worst_spreads(p)]
    speed, note = max(found, key=lambda pair: pair[0])
    return Border("averaged border, worst case", speed, note)


def balanced_growth_rates(p: Plane, speeds: Floats) -> Floats:
    """Averaged growth rates of the most stable balanced state, 1/s; nan where there is none.

    Raises
    ------
    QuestionError
        If a ball has no drag.
    """
    if one_center(p):
        return growth_rates(p, speeds, spreads_of(p, speeds))
    return np.array([balanced_growth_rate(p, speed) for speed in speeds.tolist()])


def _search(rates_at: Callable[[Floats], Floats], low: float, high: float) -> tuple[float, str]:
    from scipy.optimize import brentq

    def rate(speed: float) -> float:
        return float(rates_at(np.array([speed]))[0])

    speeds = low + np.geomspace(1e-7 * low, high - low, POINTS)
    rates = rates_at(speeds)
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
    if rate(speeds[last]) < 0.0:  # so near to zero that one speed alone rounds to the other sign
        return float(speeds[last]), ""
    return float(brentq(rate, speeds[last], speeds[last + 1], xtol=1e-12 * high, rtol=1e-13)), ""


def worst_spreads(p: Plane) -> list[float]:
    """|g2|/g. Isotropic: the least that the balls can make. Orthotropic: from there to one, all balls in line."""
    weight = p.moment**2 / p.drag
    least = max(0.0, 2.0 * float(weight.max() / weight.sum()) - 1.0)
    return [least] if p.isotropic else [float(spread) for spread in np.linspace(least, 1.0, 19)]
