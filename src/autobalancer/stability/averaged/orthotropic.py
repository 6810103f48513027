"""The averaged border on orthotropic supports in closed form: (4.74) of Spannan (2021) where x and y differ.

Balls whose races run true are seen through g = sum s^2/beta and g2 = sum (s^2/beta) e^(2 i phi) only, as on isotropic
supports, because the averaged torque knows nothing but the forward whirl. For g2 = 0 the equation for an eigenvalue q
splits into a cubic and its conjugate,

    q R_x R_y = (g W^2/2) (W - iq) (W - 2iq) (R_x + R_y)/2,    R = k - M W^2 + i b W + 2 i M W q  of x and y.

With k, b the means over both directions and D, d half the differences (y less x), it has an imaginary root if and only if

    K^3 + [(b^2 + d^2) W^2 - D^2] K = 2 b d D W^2    for a real K, with c = (k - K)/M, and
    g = 2/(b c W^2) (W^2 - c)/(W^2 + c) [D^2 - K^2 + (b^2 - d^2) W^2].

So the limit of g, hence of the drag, is explicit at each speed: one cubic, of which K = 0 is a root where stiffness or damping
are alike in x and y. On isotropic supports K = 0 and c = w_c^2, which is (4.74). The border speeds for a given g are not
explicit. But both lines are linear in W^2 once the bracket is replaced by means of the first; without K they leave a
polynomial of degree five in W^2, whose roots are all border speeds at once. At high speed the limit is

    g = 4 M b_x b_y / ((b_x + b_y) k'),    k' = (k_x b_y^2 + k_y b_x^2)/(b_x^2 + b_y^2),

(4.75) for supports that differ. That g2 = 0 is the worst case over the unbalance is proved on isotropic supports only; elsewhere
it was so for all of 65 000 random machines and speeds at which the forward whirl lags and g is below every limit.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.polynomial import Polynomial

from autobalancer.stability.host.planar import Plane

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
