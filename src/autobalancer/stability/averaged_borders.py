"""Averaged borders, from the eigenvalue problem and in closed form, and the release speed.

On isotropic supports and for races on the axis the averaged equations see the balls only through g = sum s^2/beta and
|g2|, g2 = sum (s^2/beta) e^(2 i phi), s = m eps. For g2 = 0, the worst case, they are stable if and only if

    (w_c^2 g / (2 b)) (W^2 + w_c^2) < W^2 - w_c^2,

which is (4.74) of Spannan (2021) for two equal balls (g = 2 (m eps)^2/beta) and (A.7) for one ball, for which it is
sufficient only. N equal balls: g = N (m eps)^2/beta, so the greatest admissible S = (m eps w_c)^2/(b beta) is 2/N.

For balls without inertia the exact equations give W > w_c (1 + w_c^2 g/(2 b)), the same to first order; so the *never* of
the averaged border is a property of the averaging, not of the balancer.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from autobalancer.errors import QuestionError
from autobalancer.stability.averaged import (
    Given,
    averaged_growth_rate,
    averaged_plane,
    balanced_growth_rate,
)
from autobalancer.stability.borders import Border
from autobalancer.stability.equilibria import Equilibrium
from autobalancer.stability.lateral import Plane
from autobalancer.stability.polygon import directions

SEARCHED = 40.0  # borders are sought up to so many times the critical speed
POINTS = 400


def averaged_border(
    machine: Given,
    unbalance: complex | float | None = None,
    *,
    worst_case: bool = False,
    searched: tuple[float, float] | None = None,
) -> Border:
    """Averaged border from the eigenvalue problem (4.69) by root finding.

    Parameters
    ----------
    machine
        A machine, the path of its file, or its :class:`~autobalancer.stability.lateral.Plane`.
    unbalance
        kg m; by default that of the machine.
    worst_case
        Take the ball positions with the highest border instead of those that balance the unbalance. Needs races on the
        axis of the rotor.
    searched
        Speeds, rad/s: the border is the lowest speed in this range from which on the state is stable up to its end. By
        default from the (higher) critical speed to 40 times it.

    Returns
    -------
    Border
        Infinite if the state is unstable at the end of the range, nan if there is no balanced state.

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
    found = [_search(lambda w, s=s: averaged_growth_rate(p, w, s), low, high) for s in _worst_states(p)]
    speed, note = max(found, key=lambda pair: pair[0])
    return Border("averaged border, worst case", speed, note)


def _search(rate: object, low: float, high: float) -> tuple[float, str]:
    assert callable(rate)
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


def _worst_states(p: Plane) -> list[Equilibrium]:
    """Isotropic: the ball positions of least |g2|. Orthotropic: positions from there to all balls in line."""
    weight = p.moment**2 / p.drag
    g = float(weight.sum())
    least = max(0.0, 2.0 * float(weight.max()) - g)
    levels = [least] if p.isotropic else list(np.linspace(least, g, 19))
    doubled = [directions(weight, complex(level)) for level in levels]
    freedom = max(weight.size - 2, 0)
    return [Equilibrium("balanced", 0.5 * angles, 0j, freedom, 0) for angles in doubled if angles is not None]


def damping_share(machine: Given, unbalance: complex | float | None = None) -> float:
    """w_c^2 g / (2 b), S N/2 for N equal balls: the averaged balanced state is stable at high speed if it is below 1.

    Raises
    ------
    QuestionError
        If the supports are not isotropic, a race is off the axis, or rotor or balls are undamped.
    """
    p = averaged_plane(machine, unbalance)
    _closed_form(p)
    return float(p.stiffness[0] / p.mass * (p.moment**2 / p.drag).sum() / (2.0 * p.damping[0]))


def explicit_averaged_border(machine: Given) -> Border:
    """Averaged border in closed form, worst case over the unbalance: (4.74) and (A.7) for any balls on the axis.

    Raises
    ------
    QuestionError
        As :func:`damping_share`.
    """
    p = averaged_plane(machine)
    share = damping_share(p)
    if share >= 1.0:
        return Border("averaged border, worst case", math.inf, "never: S reaches its limit (Spannan 2021, 4.75)")
    speed = math.sqrt(p.stiffness[0] / p.mass * (1.0 + share) / (1.0 - share))
    return Border("averaged border, worst case", speed, "sufficient only" if p.moment.size == 1 else "")


def minimum_drag(machine: Given, speed: float = math.inf) -> float:
    """Drag beta that every ball needs for an averaged border at ``speed``, N m s; (4.74) solved for beta.

    At infinite speed this is (4.75): N/2 times (m eps w_c)^2 / b for N equal balls.

    Raises
    ------
    QuestionError
        As :func:`damping_share`, or if the speed is not above the critical one.
    """
    p = averaged_plane(machine)
    _closed_form(replace(p, drag=np.ones_like(p.drag)))
    square = p.stiffness[0] / p.mass
    if not speed**2 > square:
        raise QuestionError(
            f"minimum drag: given a speed of {speed:.6g} rad/s; must be above the critical {math.sqrt(square):.6g} rad/s"
        )
    factor = (1.0 + square / speed**2) / (1.0 - square / speed**2)
    return float(square * (p.moment**2).sum() / (2.0 * p.damping[0]) * factor)


def linear_release_speed(machine: Given) -> Border:
    """Release speed (4.73) for N equal balls with linear drag and without friction, w_c (1 + N S).

    A torque balance: N balls that stall at the critical speed bend the rotor by N m eps w_c/b, which pulls each of them
    along with (m eps)^2 N w_c^3/b at most; the drag beta (W - w_c) outgrows this at the release speed.

    Raises
    ------
    QuestionError
        As :func:`damping_share`, or if the balls are not equal.
    """
    p = averaged_plane(machine)
    share = damping_share(p)
    if np.ptp(p.moment) > 0.0 or np.ptp(p.drag) > 0.0:
        raise QuestionError("release speed: the closed form (4.73) is for equal balls; simulate the run-up instead")
    critical = math.sqrt(p.stiffness[0] / p.mass)
    return Border("release speed", critical * (1.0 + 2.0 * share), "for a drag that is linear and no friction")


def _closed_form(p: Plane) -> None:
    reasons = {
        "it has no balls": p.moment.size == 0,
        "its supports are not isotropic": not p.isotropic,
        "a race is off the axis": bool(np.any(p.offset != 0.0)),
        "its rotor or its balls are undamped": p.damping[0] <= 0.0 or not (p.drag > 0.0).all(),
    }
    for reason, true in reasons.items():
        if true:
            raise QuestionError(f"averaged border: no closed form for this machine: {reason}")
