"""Roots and least values of functions of one variable, with the steps and the bits of ``brentq`` and ``fminbound`` of SciPy.

Its package of optimizers takes a fifth of the time of a ``check`` to load; it is left to fits and systems of equations.
"""

from __future__ import annotations

import math
from collections.abc import Callable

GOLDEN = 0.5 * (3.0 - math.sqrt(5.0))
STEPS = 500


def root(
    function: Callable[[float], float], low: float, high: float, *, xtol: float = 2e-12, rtol: float = 2.0**-50
) -> float:
    """Where a function is zero that has opposite signs at two ends.

    Parameters
    ----------
    function
        Of one number.
    low, high
        The ends.
    xtol, rtol
        How near the root is, absolutely and as a share of it.

    Raises
    ------
    ValueError
        If the signs at the ends are equal, or the function has no value somewhere.

    Notes
    -----
    Brent (1973), Algorithms for Minimization without Derivatives, chapter 4.
    """

    def value(at: float) -> float:
        found = float(function(at))
        if math.isnan(found):
            raise ValueError(f"the function has no value at {at!r}")
        return found

    # both ends, which must have opposite signs
    before, x = float(low), float(high)
    f_before, f = value(before), value(x)
    if f_before == 0.0 or f == 0.0:
        return before if f_before == 0.0 else x
    if (f_before < 0.0) == (f < 0.0):
        raise ValueError(f"the function has one sign at {low!r} and {high!r}")
    other, f_other, last, step = before, f_before, x - before, x - before
    for _ in range(STEPS):
        # keep the root between the best point x and another one of opposite sign
        if f_before != 0.0 and f != 0.0 and (f_before < 0.0) != (f < 0.0):
            other, f_other = before, f_before
            last = step = x - before
        if abs(f_other) < abs(f):
            before, x, other, f_before, f, f_other = x, other, x, f, f_other, f
        # how near is near enough
        near, half = 0.5 * (xtol + rtol * abs(x)), 0.5 * (other - x)
        if f == 0.0 or abs(half) < near:
            break
        # secant through two points, or inverse parabola through three, where they promise more than halving
        tried = math.inf
        if abs(last) > near and abs(f) < abs(f_before):
            if before == other:
                tried = -f * (x - before) / (f - f_before)
            else:
                slope, far = (f_before - f) / (before - x), (f_other - f) / (other - x)
                tried = -f * (f_other * far - f_before * slope) / (far * slope * (f_other - f_before))
        # accepted only inside and if steps shrink fast enough, else bisection
        good = 2.0 * abs(tried) < min(abs(last), 3.0 * abs(half) - near)
        last, step = (step, tried) if good else (half, half)
        before, f_before = x, f
        x += step if abs(step) > near else math.copysign(near, half)
        f = value(x)
    return x


def least(function: Callable[[float], float], low: float, high: float, *, xtol: float = 1e-5) -> tuple[float, float]:
    """Where a function that falls and then rises between two ends is least, and its value there.

    Parameters
    ----------
    function
        Of one number.
    low, high
        The ends.
    xtol
        How near the place is.

    Notes
    -----
    Brent (1973), Algorithms for Minimization without Derivatives, chapter 5.
    """
    a, b = float(low), float(high)
    x = second = third = a + GOLDEN * (b - a)
    f = f_second = f_third = float(function(x))
    step = last = 0.0
    for _ in range(STEPS):
        middle, near = 0.5 * (a + b), math.sqrt(2.2e-16) * abs(x) + xtol / 3.0
        if not abs(x - middle) > 2.0 * near - 0.5 * (b - a):
            break
        r, q = (x - second) * (f - f_third), (x - third) * (f - f_second)
        p, q = (x - third) * q - (x - second) * r, 2.0 * (q - r)
        p, q = (-p if q > 0.0 else p), abs(q)
        if abs(last) > near and abs(p) < abs(0.5 * q * last) and q * (a - x) < p < q * (b - x):
            last, step = step, p / q
            if x + step - a < 2.0 * near or b - (x + step) < 2.0 * near:
                step = near if middle >= x else -near
        else:
            last = a - x if x >= middle else b - x
            step = GOLDEN * last
        at = x + math.copysign(max(abs(step), near), step if step else 1.0)
        value = float(function(at))
        if value <= f:
            a, b = (x, b) if at >= x else (a, x)
            x, second, third, f, f_second, f_third = at, x, second, value, f, f_second
        else:
            a, b = (at, b) if at < x else (a, at)
            if value <= f_second or second == x:
                second, third, f_second, f_third = at, second, value, f_second
            elif value <= f_third or third in (x, second):
                third, f_third = at, value
    return x, f
