"""Roots of the characteristic polynomial of a balanced planar rotor with equal balls, for many machines at once.

Everything is scaled by the critical speed w_c: x = s/w_c is an eigenvalue in the frame of the rotor, W its speed,
2D the damping b/(M w_c), d the drag beta/(I w_c), h = N (m eps)^2/(2 I M) the coupling, q = |S2|/N the spread::

    A+ A- = [h q (x^2 + W^2)^2]^2,    A+- = (x^2 + d x) (y^2 + 2D y + 1) - h y^4,    y = x +- i W

The eight roots are found together by the iteration of Aberth (1973) on this factored form, which keeps the digits that
expanded coefficients lose; the roots of the neighboring point are the start.
"""

from __future__ import annotations

import math

from numba import void

from autobalancer.kernels.compiler.flags import EXACT, INLINE, njit
from autobalancer.kernels.system import Floats, Matrix, matrix_type, vector_type

SPEED, DAMPING, DRAG, COUPLING, SPREAD, COLUMNS = range(6)  # columns of a point
ROOTS = 8
MOST = 60  # iterations
NEAR = 1e-12  # a root is found when the steps of Aberth and of Newton are both below
IN_LINE = 1e-9  # balls count as standing in line if 1 - q is below


@njit(**INLINE)
def _newton(x: float, y: float, w: float, g: float, d: float, h: float, q: float) -> tuple[float, float]:
    """f'/f at x + i y, the inverse of the step of Newton; the largest float where f is zero."""
    z = complex(x, y)
    up, down = complex(x, y + w), complex(x, y - w)
    ball, ball1 = z * (z + d), 2.0 * z + d
    up2, down2 = up * up, down * down
    host_up, host_down = up2 + g * up + 1.0, down2 + g * down + 1.0
    a, b = ball * host_up - h * up2 * up2, ball * host_down - h * down2 * down2
    a1 = ball1 * host_up + ball * (2.0 * up + g) - 4.0 * h * up2 * up
    b1 = ball1 * host_down + ball * (2.0 * down + g) - 4.0 * h * down2 * down
    pair = up * down
    t, t1 = h * q * pair * pair, 4.0 * h * q * pair * z
    f, f1 = a * b - t * t, a1 * b + a * b1 - 2.0 * t * t1
    size = f.real * f.real + f.imag * f.imag
    if size == 0.0:
        return 1e300, 0.0
    return (f1.real * f.real + f1.imag * f.imag) / size, (f1.imag * f.real - f1.real * f.imag) / size


@njit(**INLINE)
def _guess(roots: Matrix, w: float, g: float, d: float, h: float, q: float) -> None:
    """Rotor whirls near -+ i W, balls as on a rotor of infinite speed; slightly off any symmetry."""
    whirl = math.sqrt(max(1.0 - 0.25 * g * g, 0.01))
    for i in range(2):
        side = 1.0 - 2.0 * i
        for j in range(2):
            roots[2 * i + j, 0] = -0.5 * g - 0.013 * (1 + j)
            roots[2 * i + j, 1] = side * w + (1.0 - 2.0 * j) * (whirl + 0.017 * (1 + i))
    for i in range(2):
        pull = h * w * w * (1.0 + (1.0 - 2.0 * i) * min(q, 0.98)) / (1.0 + w * w / (1.0 + w * w))
        bow = pull - 0.25 * d * d
        for j in range(2):
            side = 1.0 - 2.0 * j
            if bow >= 0.0:
                roots[4 + 2 * i + j, 0] = -0.5 * d - 0.011 * (1 + i)
                roots[4 + 2 * i + j, 1] = side * (math.sqrt(bow) + 0.019 * (1 + j))
            else:
                fast = 0.5 * d + math.sqrt(-bow)
                roots[4 + 2 * i + j, 0] = -fast * (1.0 + 0.03 * i) if j == 0 else -pull / fast * (1.0 + 0.03 * i)
                roots[4 + 2 * i + j, 1] = 0.007 * side * (1.0 + i)


@njit(**INLINE)
def _solve(roots: Matrix, w: float, g: float, d: float, h: float, q: float) -> bool:
    """Improve the eight roots (real, imaginary) in place; whether they converged."""
    # Aberth's method: Newton's step, corrected by all other roots as if they were divided out, converges for all at once
    done = 0  # bits
    for _ in range(MOST):
        for i in range(ROOTS):
            if done >> i & 1:
                continue
            x, y = roots[i, 0], roots[i, 1]
            # f'/f, less the sum of 1/(z - other root)
            re, im = _newton(x, y, w, g, d, h, q)
            slope = re * re + im * im
            for j in range(ROOTS):
                if j != i:
                    dx, dy = x - roots[j, 0], y - roots[j, 1]
                    size = dx * dx + dy * dy
                    if size == 0.0:
                        dx, dy, size = 1e-9, 1e-9, 2e-18
                    re -= dx / size
                    im += dy / size
            # the step is its inverse; a root is done when the step is small and f is small beside its slope
            size = re * re + im * im
            if size == 0.0:
                re, im, size = 1.0, 1.0, 2.0
            step_x, step_y = re / size, -im / size
            roots[i, 0] -= step_x
            roots[i, 1] -= step_y
            near = NEAR * (1.0 + abs(x) + abs(y))
            if step_x * step_x + step_y * step_y < near * near and slope * near * near > 1.0:
                done |= 1 << i
        if done == (1 << ROOTS) - 1:
            break
    if done != (1 << ROOTS) - 1:
        return False
    # two iterates may have met at one root and missed another: then the sum of the roots is wrong
    mass = 1.0 - h
    total = 2.0 * mass * (g + d) / (mass * mass - h * h * q * q)
    for i in range(ROOTS):
        total += roots[i, 0]
    return abs(total) < 1e-11 * (1.0 + w + d + g)


@njit(void(matrix_type, vector_type, vector_type, matrix_type), **EXACT)
def growth_rates(points: Matrix, rates: Floats, frequencies: Floats, roots: Matrix) -> None:
    """Greatest real part that counts, and the imaginary part with it, for each row of ``points``; nan if not found.

    Of balls in line the eigenvalue zero, which is there by symmetry, does not count. ``roots`` (8, 2) is work space and
    ends as the roots of the last point.
    """
    fresh = True
    for n in range(points.shape[0]):
        w, g, d = points[n, SPEED], points[n, DAMPING], points[n, DRAG]
        h, q = points[n, COUPLING], points[n, SPREAD]
        # points follow each other on a curve, so the roots of the last one are the best guess
        found = False
        if not fresh:
            found = _solve(roots, w, g, d, h, q)
        if not found:
            _guess(roots, w, g, d, h, q)
            found = _solve(roots, w, g, d, h, q)
        fresh = not found
        if not found:
            rates[n] = frequencies[n] = math.nan
            continue
        # balls in line turn together without effort: the root next to zero is this symmetry
        skip = -1
        if 1.0 - q < IN_LINE:
            skip = 0
            for i in range(1, ROOTS):
                if abs(roots[i, 0]) + abs(roots[i, 1]) < abs(roots[skip, 0]) + abs(roots[skip, 1]):
                    skip = i
        # the root that grows fastest
        best = -1
        for i in range(ROOTS):
            if i != skip and (best < 0 or roots[i, 0] > roots[best, 0]):
                best = i
        rates[n], frequencies[n] = roots[best, 0], abs(roots[best, 1])
