"""The averaged border in closed form, and the exact border of balls without inertia.

On isotropic supports and for races on the axis the averaged equations see the balls only through g = sum s^2/beta and
|g2|, g2 = sum (s^2/beta) e^(2 i phi), s = m eps. For g2 = 0, the worst case, they are stable if and only if

    (w_c^2 g / (2 b)) (W^2 + w_c^2) < W^2 - w_c^2,

which is (4.74) of Spannan (2021) for two equal balls (g = 2 (m eps)^2/beta) and (A.7) for one ball, for which it is
sufficient only. N equal balls: g = N (m eps)^2/beta, so the greatest admissible S = (m eps w_c)^2/(b beta) is 2/N. What takes
its place on orthotropic supports is derived in :mod:`~autobalancer.stability.averaged.formulas`.

For balls without inertia the exact equations give W > w_c (1 + w_c^2 g/(2 b)), the same to first order; so the *never*
of the averaged border belongs to the averaging, not to the balancer. Where beta/I is not large against b/(2M) and
(N S/2) w_c neither this limit nor (4.74) stands in for the exact border.
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.polynomial import Polynomial

from autobalancer.assembly.terms import Theory
from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_races
from autobalancer.stability.averaged.border import SEARCHED
from autobalancer.stability.averaged.equations import Given, averaged_plane
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


# The averaged border on orthotropic supports in closed form: (4.74) of Spannan (2021) where x and y differ.
#
# Balls whose races run true are seen through g = sum s^2/beta and g2 = sum (s^2/beta) e^(2 i phi) only, as on
# isotropic supports, because the averaged torque knows nothing but the forward whirl. For g2 = 0 the equation for an
# eigenvalue q splits into a cubic and its conjugate,
#
#     q R_x R_y = (g W^2/2) (W - iq) (W - 2iq) (R_x + R_y)/2,    R = k - M W^2 + i b W + 2 i M W q  of x and y.
#
# With k, b the means over both directions and D, d half the differences (y less x), it has an imaginary root if and
# only if
#
#     K^3 + [(b^2 + d^2) W^2 - D^2] K = 2 b d D W^2    for a real K, with c = (k - K)/M, and
#     g = 2/(b c W^2) (W^2 - c)/(W^2 + c) [D^2 - K^2 + (b^2 - d^2) W^2].
#
# So the limit of g, hence of the drag, is explicit at each speed: one cubic, of which K = 0 is a root where stiffness
# or damping are alike in x and y. On isotropic supports K = 0 and c = w_c^2, which is (4.74). The border speeds for a
# given g are not explicit. But both lines are linear in W^2 once the bracket is replaced by means of the first;
# without K they leave a polynomial of degree five in W^2, whose roots are all border speeds at once. At high speed
# the limit is
#
#     g = 4 M b_x b_y / ((b_x + b_y) k'),    k' = (k_x b_y^2 + k_y b_x^2)/(b_x^2 + b_y^2),
#
# (4.75) for supports that differ. That g2 = 0 is the worst case over the unbalance is proved on isotropic supports
# only; elsewhere it was so for all of 65 000 random machines and speeds at which the forward whirl lags and g is
# below every limit.


DOUBLE = 1e-6  # share of an imaginary part below which roots may be a double real one
Range = tuple[float, float]


def greatest_g(p: Plane, speed: float) -> float:
    """The greatest g = sum s^2/beta, kg s, with which the balanced state is stable at a speed, which may be infinite.

    Zero where the forward whirl does not lag by more than a quarter turn, as below the lower critical speed.
    """
    (kx, ky), (bx, by) = p.stiffness, p.damping
    if not bx + by > 0.0:
        return 0.0
    if math.isinf(speed):
        return 4.0 * p.mass * bx * by * (bx * bx + by * by) / ((bx + by) * (kx * by * by + ky * bx * bx))
    if not p.dynamic_stiffness(speed).real < 0.0:
        return 0.0
    unit, diff, b, d = _scaled(p)
    y = (speed / unit) ** 2
    cubic = Polynomial([-2.0 * b * d * diff * y, (b * b + d * d) * y - diff * diff, 0.0, 1.0])
    limits = []
    for left in _real(cubic):
        c = 1.0 - left
        limits.append(2.0 / (b * c * y) * (y - c) / (y + c) * (diff * diff - left * left + (b * b - d * d) * y))
    return p.mass / unit * min((g for g in limits if g > 0.0), default=math.inf)


def stable_ranges(p: Plane) -> list[Range]:
    """All speeds at which the balanced state of these balls with g2 = 0 is stable, rad/s; the last may end at infinity."""
    unit = _scaled(p)[0]
    edges = [0.0, *_crossings(p), math.inf]
    found: list[Range] = []
    for low, high in pairwise(edges):
        middle = (2.0 * low or 1.0) if math.isinf(high) else 0.5 * high if low == 0.0 else math.sqrt(low * high)
        if not _stable(p, middle):
            continue
        start = found.pop()[0] if found and found[-1][1] == low * unit else low * unit
        found.append((start, high * unit))
    return found


def _scaled(p: Plane) -> tuple[float, float, float, float]:
    """A unit of speed, sqrt(k/M), and in units of k and M D, b, d: means and half the differences."""
    (kx, ky), (bx, by) = p.stiffness, p.damping
    k = 0.5 * (kx + ky)
    unit = math.sqrt(k / p.mass)
    damping = p.mass * unit
    return unit, 0.5 * (ky - kx) / k, 0.5 * (bx + by) / damping, 0.5 * (by - bx) / damping


def _crossings(p: Plane) -> list[float]:
    """Speeds at which a root crosses the imaginary axis, in units, ascending; a double one may be none.

    W^2 is linear in both conditions, and the second one, with the first, is quadratic in K: this is their resultant.
    """
    unit, diff, b, d = _scaled(p)
    g = float((p.moment**2 / p.drag).sum()) * unit / p.mass
    h = d * diff
    y = Polynomial([0.0, 1.0])  # W^2
    first, rest = (b * b + d * d) * y - diff * diff, -2.0 * b * y  # K^3 + first K + h rest = 0
    two, one = -g * (y + 2.0) - 4.0 * b, g * (y + 1.0 - first) - 4.0 * (b * (y - 1.0) - h)
    none = 2.0 * b * g * y + 4.0 * (y - 1.0)  # two K^2 + one K + h none = 0
    resultant = (first * none - rest * one) * (one**2 + first * two**2) + h * (
        two * rest * (two**2 * rest + 3.0 * one * none) - 2.0 * two * first * none**2 + h * none**3
    )
    return sorted(math.sqrt(square) for square in _real(resultant) if square > 0.0)


def _stable(p: Plane, speed: float) -> bool:
    """Whether the three roots decay, at a speed in units."""
    unit, diff, b, d = _scaled(p)
    w = speed
    q = Polynomial([0.0, 1.0])
    x, y = (1.0 + s * diff - w * w + 1j * (b + s * d) * w + 2j * w * q for s in (-1.0, 1.0))
    g = float((p.moment**2 / p.drag).sum()) * unit / p.mass
    cubic = q * x * y - 0.25 * g * w * w * (w - 1j * q) * (w - 2j * q) * (x + y)
    return bool(cubic.roots().real.max() < 0.0)


def _real(whole: Polynomial) -> list[float]:
    """Real roots, each improved by two steps of Newton's method."""
    slope, found = whole.deriv(), []
    for root in np.atleast_1d(whole.trim().roots()):
        if abs(root.imag) > DOUBLE * abs(root):
            continue
        x = float(root.real)
        for _ in range(2):
            step = float(slope(x))
            x = x - float(whole(x)) / step if step != 0.0 else x
        found.append(x)
    return found
