"""Endochronic elements of rubber whose ends move on an ellipse: the periodic force, in two passes over half a turn.

With deflections over a_c and forces over k a_c an element follows s = (a cos t, b sin t) with

    g' = s' - |s'| g,    so that    g(t) = e^(-l(t)) [g(0) + int_0^t e^l s' dt],    l' = |s'|.

It is linear in g. The periodic force changes its sign after half a turn, g(pi) = -g(0), so that the force p that half a turn
brings to one of zero gives g(0) = -p/(1 + e^(-l(pi))) at once. At the tips of a thin ellipse |s'| has a sharp bend; steps become
short there.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from autobalancer.kernels.flags import APART, njit

POINTS = 6  # of Gauss in a step
REACH, GROWTH, FEWEST = (
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


NODES, WEIGHTS, UP_TO = _gauss()


@njit(**APART)
def _step(c: Any, a: float, b: float, t: float, h: float) -> float:
    """Rows of ``c`` at the points of a step: way to there, e to it, and h s'; returns the whole way."""
    whole = 0.0
    for j in range(POINTS):
        u = t + NODES[j] * h
        c[j, 2], c[j, 3] = -h * a * math.sin(u), h * b * math.cos(u)
        c[j, 4] = math.hypot(c[j, 2], c[j, 3])
        whole += WEIGHTS[j] * c[j, 4]
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
def _half_turn(c: Any, sums: Any, a: float, b: float, gx: float, gy: float) -> tuple[float, float, float]:
    """g after half a turn, and the share that is left of a force from before; ``sums`` (8,) grow as in the other law."""
    flat, kept = max(abs(b) / a, FLAT), 1.0
    longest, middle, t = min(math.pi / FEWEST, REACH / a), 0.5 * math.pi, 0.0
    while t < math.pi:
        if t < middle:
            h = min(longest, GROWTH * (t + flat), middle - t)
        else:  # the same steps backward
            h = min(longest, GROWTH / (1.0 + GROWTH) * (math.pi - t + flat), math.pi - t)
        whole = _step(c, a, b, t, h)
        for i in range(POINTS):
            x, y = _gained(c, UP_TO[i], c[i, 0], gx, gy)
            at, weight = t + NODES[i] * h, WEIGHTS[i] * h
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
        gx, gy = _gained(c, WEIGHTS, whole, gx, gy)
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
    x, y, kept = _half_turn(c, sums, a, b, 0.0, 0.0)
    for i in range(8):
        sums[i] = 0.0
    _half_turn(c, sums, a, b, -x / (1.0 + kept), -y / (1.0 + kept))
