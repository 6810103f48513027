"""The averaged border from the eigenvalue problem of the averaged equations, by root finding."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.stability.averaged.equations import Given, averaged_plane, balanced_growth_rate
from autobalancer.stability.averaged.stations import eigenvalues_at, refuse_without_drag
from autobalancer.stability.border import Border
from autobalancer.stability.host.planar import Complexes, Floats, Plane
from autobalancer.stability.host.stations import of_plane
from autobalancer.stability.states.planar import close_polygon

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


# Averaged growth rates of balanced states at many speeds at once: of balls whose races have one center.
#
# The averaged equations see the balls through g = sum s^2/beta and |g2|, g2 = sum (s^2/beta) e^(2 i phi), only: two
# balls with the same stand for all of them. The other motions of more balls are for nothing. An eccentric race
# changes only the angles at which its balls balance.


IN_LINE = (
    1e-13  # balls count as standing in line if 1 - |g2|/g is below: one root is zero by symmetry and does not count
)


def one_center(p: Plane) -> bool:
    """Whether all races have the same center."""
    return p.moment.size > 0 and bool(np.all(p.offset == p.offset[0]))


def spreads_of(p: Plane, speeds: Floats) -> Floats:
    """|g2|/g of the balls that balance at each speed; nan where they cannot."""
    center = complex(p.offset[0])
    if center == 0.0:
        return np.full(speeds.size, _spread(p, -p.fixed_load))
    return np.array([_spread(p, -center * p.dynamic_stiffness(w) / w**2 - p.fixed_load) for w in speeds.tolist()])


def _spread(p: Plane, target: complex) -> float:
    found = close_polygon(p.moment, target) if np.isfinite(target) else []
    if not found:
        return float("nan")
    weight = p.moment**2 / p.drag
    return float(abs((weight * np.exp(2j * found[0])).sum()) / weight.sum())


def growth_rates(p: Plane, speeds: Floats, spreads: Floats | float) -> Floats:
    """Greatest real part at each speed, 1/s, with these |g2|/g; nan where one is nan.

    Raises
    ------
    QuestionError
        If a ball has no drag.
    """
    refuse_without_drag(p.drag)
    spreads = np.broadcast_to(np.asarray(spreads, np.float64), speeds.shape)
    rates = np.full(speeds.size, np.nan)
    there = np.flatnonzero(np.isfinite(spreads))
    if there.size == 0:
        return rates
    values = _eigenvalues(p, speeds[there], spreads[there])
    in_line = spreads[there] > 1.0 - IN_LINE
    values[in_line, np.abs(values).argmin(axis=1)[in_line]] = -np.inf
    rates[there] = values.real.max(axis=1)
    return rates


def _eigenvalues(p: Plane, speeds: Floats, spreads: Floats) -> Complexes:
    """Of two balls at +-a, cos 2a = |g2|/g, in races that run true, (k, size)."""
    drag = float(p.drag.mean())
    two = {name: getattr(p, name)[[0, 0]] for name in ("ball_mass", "inertia", "race", "offset")}
    moment = np.full(2, np.sqrt(0.5 * drag * float((p.moment**2 / p.drag).sum())))
    pair = of_plane(replace(p, moment=moment, drag=np.full(2, drag), **two))
    angle = 0.5 * np.arccos(np.minimum(spreads, 1.0))
    true = np.zeros((speeds.size, 2), np.complex128)
    return eigenvalues_at(pair, speeds, np.stack([angle, -angle], axis=1), true)
