"""The averaged border in closed form, and the exact border of balls without inertia.

On isotropic supports and for races on the axis the averaged equations see the balls only through g = sum s^2/beta and
|g2|, g2 = sum (s^2/beta) e^(2 i phi), s = m eps. For g2 = 0, the worst case, they are stable if and only if

    (w_c^2 g / (2 b)) (W^2 + w_c^2) < W^2 - w_c^2,

which is (4.74) of Spannan (2021) for two equal balls (g = 2 (m eps)^2/beta) and (A.7) for one ball, for which it is
sufficient only. N equal balls: g = N (m eps)^2/beta, so the greatest admissible S = (m eps w_c)^2/(b beta) is 2/N. What takes
its place on orthotropic supports is derived in :mod:`~autobalancer.stability.averaged.orthotropic`.

For balls without inertia the exact equations give W > w_c (1 + w_c^2 g/(2 b)), the same to first order; so the *never*
of the averaged border belongs to the averaging, not to the balancer. Where beta/I is not large against b/(2M) and
(N S/2) w_c neither this limit nor (4.74) stands in for the exact border.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from autobalancer.assembly.terms import Theory
from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_races
from autobalancer.stability.averaged.border import SEARCHED
from autobalancer.stability.averaged.equations import Given, averaged_plane
from autobalancer.stability.averaged.orthotropic import greatest_g, stable_ranges
from autobalancer.stability.border import Border, ignoring
from autobalancer.stability.host.planar import Plane

WORST = "averaged border, worst case"


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
    """Averaged border in closed form, worst case over the unbalance of ``machine``, for any balls in races on the axis.

    On isotropic supports (4.74) and (A.7); on orthotropic ones the highest root of a polynomial of degree five in W^2, above
    which the state stays stable, at least up to 40 times the higher critical speed.

    Raises
    ------
    QuestionError
        If a race is off the axis, or rotor or balls are undamped.
    """
    if not isinstance(machine, Plane):
        machine = balls_in_races(machine)
        return ignoring(machine, explicit_averaged_border(averaged_plane(machine)), Theory.AVERAGED)
    p = machine
    if not p.isotropic:
        return _orthotropic(p)
    share = damping_share(p)
    if share >= 1.0:
        return Border(
            WORST,
            math.inf,
            "drag or damping is too small (Spannan 2021, 4.75)",
        )
    speed = math.sqrt(p.stiffness[0] / p.mass * (1.0 + share) / (1.0 - share))
    return Border(WORST, speed, "sufficient only" if p.moment.size == 1 else "")


def _orthotropic(p: Plane) -> Border:
    _closed_form(p, isotropic=False)
    searched = SEARCHED * p.critical_speeds[-1]
    ranges = stable_ranges(p)
    last = next((one for one in ranges if one[0] < searched <= one[1]), None)
    others = [f"{low:.6g} to {high:.6g} rad/s" for low, high in ranges if (low, high) != last]
    notes = [f"stable also {', '.join(others)}"] if last and others else []
    if last is None:
        stable = f"; stable {', '.join(others)}" if others else ""
        return Border(WORST, math.inf, f"drag or damping is too small{stable}")
    if p.moment.size == 1:
        notes.insert(0, "sufficient only")
    if math.isfinite(last[1]):
        notes.append(f"up to {last[1]:.6g} rad/s")
    return Border(WORST, last[0], "; ".join(notes))


def heavily_damped_border(machine: Given) -> Border:
    """Exact border, worst case over the unbalance, in the limit of balls without inertia: w_c (1 + w_c^2 g/(2 b)).

    From one factor of the exact equation with I = 0: beta s = (N/2) (m eps)^2 (s + iW)^4 H(s + iW) has the imaginary
    root s = i (w_c - W) at this speed. Always finite, where (4.74) may say never.

    Raises
    ------
    QuestionError
        As :func:`damping_share`.
    """
    p = averaged_plane(machine)
    critical = math.sqrt(p.stiffness[0] / p.mass)
    return Border("exact border, worst case", critical * (1.0 + damping_share(p)), "limit of balls without inertia")


def minimum_drag(machine: Given, speed: float = math.inf) -> float:
    """Drag beta that every ball needs to be stable at ``speed`` by the averaged equations, N m s, whatever the unbalance.

    (4.74) solved for beta, and what takes its place on orthotropic supports. At infinite speed this is (4.75): N/2 times
    (m eps w_c)^2 / b for N equal balls on isotropic supports.

    Raises
    ------
    QuestionError
        As :func:`explicit_averaged_border`, or if the forward whirl does not lag by more than a quarter turn at the speed; on
        isotropic supports it does above the critical speed.
    """
    p = averaged_plane(machine)
    _closed_form(replace(p, drag=np.ones_like(p.drag)), isotropic=False)
    most = greatest_g(p, speed)
    if not most > 0.0:
        must = (
            f"above the critical speed of {p.critical_speeds[0]:.6g} rad/s"
            if p.isotropic
            else "in one of speed_windows"
        )
        raise QuestionError(f"minimum drag: given {speed:.6g} rad/s, where no drag is enough; must be {must}")
    return float((p.moment**2).sum()) / most


def _closed_form(p: Plane, *, isotropic: bool = True) -> None:
    reasons = {
        "it has no balls": p.moment.size == 0,
        "its supports are not isotropic": isotropic and not p.isotropic,
        "a race is off the axis": bool(np.any(p.offset != 0.0)),
        "its rotor or its balls are undamped": max(p.damping) <= 0.0 or not (p.drag > 0.0).all(),
    }
    for reason, true in reasons.items():
        if true:
            raise QuestionError(f"averaged border: no closed form for this machine: {reason}")
