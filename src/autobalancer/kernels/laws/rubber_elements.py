"""Friction elements of rubber whose ends move on an ellipse: the periodic force, from one period.

With deflections over a_c and forces over k a_c an elastoplastic element follows s = (a cos t, b sin t) with

    g' = s'  where g.s' <= 0 (it sticks),    g' = s' - g (g.s')  where it slides.

Sliding is linear in homogeneous coordinates, g = (G_1, G_2)/G_0 with G_0' = s'.(G_1, G_2) and (G_1, G_2)' = s' G_0 (Hong and Liu
2000). So a step is a power series that converges everywhere, sticking is known in closed form, and the instants at
which one becomes the other are found as roots. The periodic force changes its sign after half a turn, g(t + pi) = -g(t), which
is solved for g(0) by Broyden's method; then Gauss quadrature gives the harmonics

    g_n = (2/pi) int_0^pi g e^(-i n t) dt.

Endochronic elements are found in :mod:`autobalancer.kernels.laws.rubber_elements`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import boolean, void

from autobalancer.kernels.compiler.flags import APART, COMPILED, njit
from autobalancer.kernels.system import Floats, Matrix, matrix_type, vector_type

ORDER = 12  # of the power series of a step
REACH, FEWEST = 1.0, 10  # longest way in a step, over a_c; steps in half a turn
TURNS, CLOSE = 200, 3e-12  # half turns until the force is periodic, and by how much it may miss
ROUGH = 1e-9  # change of the start, over a, from which rounding spoils slopes
ROOT, SOON = 1e-10, 1e-4  # of a step: to which a beginning or end of sliding is known; after which its sign is clear
CHANGES = 7  # between sticking and sliding, most in a step
FAR = 2.0  # motion over a_c from which on an element forgets most in half a turn
MOST = 1.0 + 1e-6  # force over k a_c, with the error of the steps
FARTHEST = 1e3  # motion over a_c beyond which the force stays as it is, to a thousandth of k a_c
TINY = 1e-5  # motion over a_c below which an element is a spring, to its square
SLOPE = 1e-6  # relative change of a circle for slopes
NODES, WEIGHTS = (  # of Gauss
    (
        -0.9324695142031521,
        -0.6612093864662645,
        -0.2386191860831969,
        0.2386191860831969,
        0.6612093864662645,
        0.9324695142031521,
    ),
    (
        0.1713244923791704,
        0.3607615730481386,
        0.4679139345726910,
        0.4679139345726910,
        0.3607615730481386,
        0.1713244923791704,
    ),
)
FORCE, THIRD, OVER_FORWARD, OVER_BACKWARD, MISS, COLUMNS = 0, 4, 8, 12, 16, 17
"""Columns of an answer: forward and backward circle of the force, real and imaginary parts; those of its third harmonic; slopes
of the first four over the radius of the forward and of the backward circle of the motion; by how much g misses its period."""


@njit(**APART)
def _series(c: Any, a: float, b: float, t: float, h: float, gx: float, gy: float) -> None:
    """Coefficients (ORDER + 1, 5) of a sliding step from t to t + h: G_0, G_1, G_2, then those of h s'."""
    # derivatives of s' repeat after four, so each coefficient of it follows from the one before
    cos, sin = math.cos(t), math.sin(t)
    dx, dy, ex, ey, size = -a * sin, b * cos, -a * cos, -b * sin, h
    c[0, 0], c[0, 1], c[0, 2] = 1.0, gx, gy
    for n in range(ORDER):
        c[n, 3], c[n, 4] = size * dx, size * dy
        dx, dy, ex, ey = ex, ey, -dx, -dy
        size *= h / (n + 1)
        # G' = (s'.(G_1, G_2), s'_x G_0, s'_y G_0): coefficients by products of series (Cauchy)
        zero, one, two = 0.0, 0.0, 0.0
        for j in range(n + 1):
            x, y = c[j, 3], c[j, 4]
            zero += x * c[n - j, 1] + y * c[n - j, 2]
            one += x * c[n - j, 0]
            two += y * c[n - j, 0]
        c[n + 1, 0], c[n + 1, 1], c[n + 1, 2] = zero / (n + 1), one / (n + 1), two / (n + 1)


@njit(**APART)
def _slid(c: Any, u: float) -> tuple[float, float]:
    """g at the share u of a sliding step."""
    zero, one, two = c[ORDER, 0], c[ORDER, 1], c[ORDER, 2]
    for n in range(ORDER - 1, -1, -1):
        zero, one, two = zero * u + c[n, 0], one * u + c[n, 1], two * u + c[n, 2]
    return one / zero, two / zero


@njit(**APART)
def _force(c: Any, slides: bool, u: float, t: float, a: float, b: float, cx: float, cy: float) -> tuple[float, float]:
    """g at the share u of a step, at the angle t."""
    if slides:
        return _slid(c, u)
    return cx + a * math.cos(t), cy + b * math.sin(t)


@njit(**APART)
def _power(c: Any, slides: bool, u: float, t: float, a: float, b: float, cx: float, cy: float) -> float:
    """g.s' there."""
    x, y = _force(c, slides, u, t, a, b, cx, cy)
    return b * math.cos(t) * y - a * math.sin(t) * x


@njit(**APART)
def _rate(slides: bool, t: float, a: float, b: float, gx: float, gy: float) -> float:
    """How fast the power g.s' grows: g'.s' - g.s."""
    x, y, dx, dy = a * math.cos(t), b * math.sin(t), -a * math.sin(t), b * math.cos(t)
    power = gx * dx + gy * dy
    return dx * dx + dy * dy - gx * x - gy * y - (power * power if slides else 0.0)


@njit(**APART)
def _change(c: Any, slides: bool, t: float, h: float, a: float, b: float, gx: float, gy: float) -> float:
    """The share of a step from the force (gx, gy) at which an element begins or ends to slide; 1 if it does not."""
    # an element slides where the power g.s' is positive: its values at both ends
    cx, cy = gx - a * math.cos(t), gy - b * math.sin(t)
    low = b * math.cos(t) * gy - a * math.sin(t) * gx
    left, right, high = 0.0, 1.0, _power(c, slides, 1.0, t + h, a, b, cx, cy)
    # no change of sign: still, a minimum or maximum inside may pass zero, which its slopes at both ends tell
    if slides == (high > 0.0) or high == 0.0:  # it may still do both in between
        x, y = _force(c, slides, 1.0, t + h, a, b, cx, cy)
        first, last = _rate(slides, t, a, b, gx, gy), _rate(slides, t + h, a, b, x, y)
        if not (first < 0.0 < last if slides else last < 0.0 < first):
            return 1.0
        right = first / (first - last)
        high = _power(c, slides, right, t + right * h, a, b, cx, cy)
        if slides == (high > 0.0) or high == 0.0:
            return 1.0
    if slides != (low > 0.0) or low == 0.0:  # at a change, by rounding on its other side
        low = _power(c, slides, SOON * right, t + SOON * right * h, a, b, cx, cy)
        if slides != (low > 0.0):
            return 0.0
    # the root between, by false position
    u, side = 0.0, 0
    for _ in range(60):  # the Illinois form of the rule of false position
        u = (left * high - right * low) / (high - low)
        value = _power(c, slides, u, t + u * h, a, b, cx, cy)
        if (value > 0.0) == (high > 0.0):
            right, high = u, value
            low = 0.5 * low if side == 1 else low
            side = 1
        else:
            left, low = u, value
            high = 0.5 * high if side == 2 else high
            side = 2
        if right - left < ROOT or value == 0.0:
            break
    return u


@njit(**APART)
def _half_turn(
    c: Any, sums: Any, a: float, b: float, gx: float, gy: float, steps: int, summed: bool
) -> tuple[float, float]:
    """g after half a turn; ``sums`` (8,) are the integrals of g_x and g_y with cos and sin of t and 3 t."""
    whole = math.pi / steps
    slides = b * gy > 0.0 or (b * gy == 0.0 and b * b > a * gx)  # g.s' > 0 at t = 0, or it grows from zero
    for n in range(steps):
        # a step ends early where sliding begins or ends, and goes on from there with the other law
        t, rest = n * whole, whole
        for turn in range(CHANGES + 1):
            cx, cy = gx - a * math.cos(t), gy - b * math.sin(t)
            if slides:
                _series(c, a, b, t, rest, gx, gy)
            share = _change(c, slides, t, rest, a, b, gx, gy) if turn < CHANGES else 1.0
            if summed and share > 0.0:
                # harmonics one and three of the force, by six points of Gauss
                half = 0.5 * share * rest
                for i in range(6):
                    u = 0.5 * share * (1.0 + NODES[i])
                    at = t + u * rest
                    x, y = _force(c, slides, u, at, a, b, cx, cy)
                    cos, sin, weight = math.cos(at), math.sin(at), WEIGHTS[i] * half
                    cos3, sin3 = cos * (4.0 * cos * cos - 3.0), sin * (3.0 - 4.0 * sin * sin)
                    sums[0] += weight * x * cos
                    sums[1] += weight * x * sin
                    sums[2] += weight * y * cos
                    sums[3] += weight * y * sin
                    sums[4] += weight * x * cos3
                    sums[5] += weight * x * sin3
                    sums[6] += weight * y * cos3
                    sums[7] += weight * y * sin3
            t += share * rest
            gx, gy = _force(c, slides, share, t, a, b, cx, cy)
            if share == 1.0:
                break
            rest *= 1.0 - share
            slides = not slides
    return gx, gy


@njit(**APART)
def _periodic(c: Any, sums: Any, a: float, b: float, start: Any) -> float:
    """The harmonics of the periodic force as ``sums``; returns by how much it misses its period. ``start`` (2,) is g(0)."""
    steps = max(FEWEST, math.ceil(math.pi * a / REACH))
    # begin with the force of a neighboring ellipse, or that of an element that always slides along x
    x, y = start[0], start[1]
    size = math.hypot(x, y)
    if size > MOST or size == 0.0:
        x, y = a / math.sqrt(1.0 + a * a), 0.0
    # find g(0) with g(pi) = -g(0) by Broyden's method: slopes improve with every half turn
    slope = 1.0 if a > FAR else 2.0 / 3.0  # inverse: between 1/2, all kept, and 1, all forgotten
    xx, xy, yx, yy = slope, 0.0, 0.0, slope
    ex, ey = _half_turn(c, sums, a, b, x, y, steps, False)
    mx, my, count = ex + x, ey + y, 1
    while abs(mx) + abs(my) > CLOSE * min(1.0, a) and count < TURNS:
        dx, dy = -(xx * mx + xy * my), -(yx * mx + yy * my)
        # no force is greater than its limit
        size = math.hypot(x + dx, y + dy)
        if size > MOST:
            dx, dy = (x + dx) / size - x, (y + dy) / size - y
        x, y = x + dx, y + dy
        ex, ey = _half_turn(c, sums, a, b, x, y, steps, False)
        bx, by = ex + x - mx, ey + y - my
        mx, my, count = ex + x, ey + y, count + 1
        # what the slopes predicted against what came; they are corrected along the step (rank one)
        px, py = xx * bx + xy * by, yx * bx + yy * by  # what the slopes make of the change
        below = dx * px + dy * py
        if a < FAR and abs(below) > ROUGH * max(ROUGH * a * a, dx * dx + dy * dy):
            rx, ry = (dx - px) / below, (dy - py) / below
            lx, ly = dx * xx + dy * yx, dx * xy + dy * yy
            xx, xy, yx, yy = xx + rx * lx, xy + rx * ly, yx + ry * lx, yy + ry * ly
    # once more with the harmonics summed
    start[0], start[1] = x, y
    for i in range(8):
        sums[i] = 0.0
    _half_turn(c, sums, a, b, x, y, steps, True)
    return (abs(mx) + abs(my)) / min(1.0, a)


@njit(**APART)
def _add(sums: Any, first: int, weight: float, out: Any, column: int) -> None:
    """Add the forward and the backward circle of a harmonic."""
    xc, xs, yc, ys = sums[first], sums[first + 1], sums[first + 2], sums[first + 3]
    out[column] += 0.5 * weight * (xc + ys)  # X = xc - i xs, Y = yc - i ys: (X + i Y)/2
    out[column + 1] += 0.5 * weight * (yc - xs)
    out[column + 2] += 0.5 * weight * (xc - ys)  # conj(X - i Y)/2
    out[column + 3] += 0.5 * weight * (xs + yc)


@njit(**APART)
def _add_element(
    c: Any, sums: Any, forward: float, backward: float, element: Any, always: bool, start: Any, out: Any, column: int
) -> float:
    """Add the force of one element on an ellipse of two circles (m) at a column; returns by how much it misses its period."""
    limit, stiffness = element[0], element[1]
    a, b = (forward + backward) / limit, (forward - backward) / limit
    if (a < TINY and not always) or a == 0.0:
        out[column] += stiffness * forward
        out[column + 2] += stiffness * backward
        return 0.0
    if a > FARTHEST:
        a, b = FARTHEST, FARTHEST * b / a
    for i in range(8):
        sums[i] = 0.0
    miss = 0.0
    if always:
        always_sliding(c, sums, a, b)
    else:
        miss = _periodic(c, sums, a, b, start)
    _add(sums, 0, stiffness * limit * 2.0 / math.pi, out, column)
    if column == FORCE:
        _add(sums, 4, stiffness * limit * 2.0 / math.pi, out, THIRD)
    return miss


@njit(void(matrix_type, matrix_type, boolean, matrix_type, matrix_type, vector_type, matrix_type, boolean), **COMPILED)
def forces_on_ellipses(
    circles: Matrix,
    elements: Matrix,
    always: bool,
    starts: Matrix,
    series: Matrix,
    sums: Floats,
    out: Matrix,
    sloped: bool,
) -> None:
    """Harmonics of the force of elements side by side on n ellipses, ``out`` (n, COLUMNS), N; if ``sloped`` their slopes, N/m.

    ``circles`` (n, 2) are the radii of the forward and the backward circle, m, the major axis along x at t = 0, and ``elements``
    (e, 2) a_c and k, endochronic if they slide ``always``, else elastoplastic.

    ``starts`` (n, 2 e) are the forces at t = 0 over k a_c, where known, else 0; they are updated. ``series``
    (ORDER + 1, 5) and ``sums`` (8,) are work space.
    """
    for i in range(circles.shape[0]):
        forward, backward, answer = circles[i, 0], circles[i, 1], out[i]
        step = SLOPE * (forward + backward)
        for j in range(COLUMNS):
            answer[j] = 0.0
        for e in range(elements.shape[0]):
            start = starts[i, 2 * e : 2 * e + 2]
            miss = _add_element(series, sums, forward, backward, elements[e], always, start, answer, FORCE)
            answer[MISS] = max(answer[MISS], miss)
            if sloped and step > 0.0:
                x, y = start[0], start[1]
                _add_element(series, sums, forward + step, backward, elements[e], always, start, answer, OVER_FORWARD)
                start[0], start[1] = x, y
                _add_element(series, sums, forward, backward + step, elements[e], always, start, answer, OVER_BACKWARD)
                start[0], start[1] = x, y
        for column in (OVER_FORWARD, OVER_BACKWARD):
            for j in range(4):
                answer[column + j] = (answer[column + j] - answer[FORCE + j]) / step if sloped and step > 0.0 else 0.0


# Endochronic elements of rubber whose ends move on an ellipse: the periodic force, in two passes over half a turn.
#
# With deflections over a_c and forces over k a_c an element follows s = (a cos t, b sin t) with
#
#     g' = s' - |s'| g,    so that    g(t) = e^(-l(t)) [g(0) + int_0^t e^l s' dt],    l' = |s'|.
#
# It is linear in g. The periodic force changes its sign after half a turn, g(pi) = -g(0), so that the force p that
# half a turn brings to one of zero gives g(0) = -p/(1 + e^(-l(pi))) at once. At the tips of a thin ellipse |s'| has a
# sharp bend; steps become short there.


POINTS = 6  # of Gauss in a step
ENDOCHRONIC_REACH, GROWTH, ENDOCHRONIC_FEWEST = (
    1.0,
    0.5,
    12,
)  # longest way in a step, over a_c; step over the distance from a tip; steps in a half turn
FLAT = 1e-5  # ratio of the axes below which a tip is that of a line


def _gauss() -> tuple[Any, Any, Any]:
    """Nodes in 0 to 1, weights, and the weights (POINTS, POINTS) of integrals from 0 to each node."""
    nodes, weights = np.polynomial.legendre.leggauss(POINTS)
    nodes = 0.5 * (1.0 + nodes)
    powers = np.vander(nodes, POINTS, increasing=True)
    order = np.arange(1, POINTS + 1)
    return nodes, 0.5 * weights, (nodes[:, None] ** order / order) @ np.linalg.inv(powers)


ENDOCHRONIC_NODES, ENDOCHRONIC_WEIGHTS, UP_TO = _gauss()


@njit(**APART)
def _step(c: Any, a: float, b: float, t: float, h: float) -> float:
    """Rows of ``c`` at the points of a step: way to there, e to it, and h s'; returns the whole way."""
    whole = 0.0
    for j in range(POINTS):
        u = t + ENDOCHRONIC_NODES[j] * h
        c[j, 2], c[j, 3] = -h * a * math.sin(u), h * b * math.cos(u)
        c[j, 4] = math.hypot(c[j, 2], c[j, 3])
        whole += ENDOCHRONIC_WEIGHTS[j] * c[j, 4]
    for i in range(POINTS):
        way = 0.0
        for j in range(POINTS):
            way += UP_TO[i, j] * c[j, 4]
        c[i, 0], c[i, 1] = way, math.exp(way)
    return whole


@njit(**APART)
def _gained(c: Any, weights: Any, way: float, gx: float, gy: float) -> tuple[float, float]:
    """g after a way from the beginning of a step, where it is (gx, gy); ``weights`` of the integral up to there."""
    x, y = gx, gy
    for j in range(POINTS):
        weight = weights[j] * c[j, 1]
        x += weight * c[j, 2]
        y += weight * c[j, 3]
    left = math.exp(-way)
    return left * x, left * y


@njit(**APART)
def _endochronic_half_turn(c: Any, sums: Any, a: float, b: float, gx: float, gy: float) -> tuple[float, float, float]:
    """g after half a turn, and the share that is left of a force from before; ``sums`` (8,) grow as in the other law."""
    # steps grow with the distance from the tips of the ellipse, the same forward and backward
    flat, kept = max(abs(b) / a, FLAT), 1.0
    longest, middle, t = min(math.pi / ENDOCHRONIC_FEWEST, ENDOCHRONIC_REACH / a), 0.5 * math.pi, 0.0
    while t < math.pi:
        if t < middle:
            h = min(longest, GROWTH * (t + flat), middle - t)
        else:  # the same steps backward
            h = min(longest, GROWTH / (1.0 + GROWTH) * (math.pi - t + flat), math.pi - t)
        # way and integral at the points of Gauss; harmonics of the force there
        whole = _step(c, a, b, t, h)
        for i in range(POINTS):
            x, y = _gained(c, UP_TO[i], c[i, 0], gx, gy)
            at, weight = t + ENDOCHRONIC_NODES[i] * h, ENDOCHRONIC_WEIGHTS[i] * h
            cos, sin = math.cos(at), math.sin(at)
            cos3, sin3 = cos * (4.0 * cos * cos - 3.0), sin * (3.0 - 4.0 * sin * sin)
            sums[0] += weight * x * cos
            sums[1] += weight * x * sin
            sums[2] += weight * y * cos
            sums[3] += weight * y * sin
            sums[4] += weight * x * cos3
            sums[5] += weight * x * sin3
            sums[6] += weight * y * cos3
            sums[7] += weight * y * sin3
        gx, gy = _gained(c, ENDOCHRONIC_WEIGHTS, whole, gx, gy)
        kept *= math.exp(-whole)
        t = _next(t, h, middle)
    return gx, gy, kept


@njit(**APART)
def _next(t: float, h: float, middle: float) -> float:
    """The end of a step, exactly at a quarter and at half a turn, however it was rounded."""
    for end in (middle, 2.0 * middle):
        if abs(t + h - end) < 1e-12:
            return end
    return t + h


@njit(**APART)
def always_sliding(c: Any, sums: Any, a: float, b: float) -> None:
    """The integrals of the periodic force with cos and sin of t and 3 t over half a turn, as ``sums`` (8,).

    ``c`` (POINTS or more, 5) is work space.
    """
    x, y, kept = _endochronic_half_turn(c, sums, a, b, 0.0, 0.0)
    for i in range(8):
        sums[i] = 0.0
    _endochronic_half_turn(c, sums, a, b, -x / (1.0 + kept), -y / (1.0 + kept))
