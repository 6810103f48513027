"""Averaged growth rates of balanced states at many speeds at once: of balls whose races have one center.

The averaged equations see the balls through g = sum s^2/beta and |g2|, g2 = sum (s^2/beta) e^(2 i phi), only: two balls with
the same stand for all of them. The other motions of more balls are for nothing. An eccentric race changes only the angles at
which its balls balance.
"""

from __future__ import annotations

import numpy as np

from autobalancer.stability.averaged.stations import refuse_without_drag
from autobalancer.stability.host.planar import Complexes, Floats, Plane
from autobalancer.stability.states.planar import close_polygon

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


def _eigenvalues(p: Plane, w: Floats, spreads: Floats) -> Complexes:
    """Of (4.69) for two balls at +-a, cos 2a = |g2|/g, (k, 6); the matrices are those of one station."""
    drag = float(p.drag.mean())
    moment = np.sqrt(0.5 * drag * float((p.moment**2 / p.drag).sum()))
    angle = 0.5 * np.arccos(np.minimum(spreads, 1.0))
    cos, sin = np.stack([np.cos(angle)] * 2, axis=1), np.stack([np.sin(angle), -np.sin(angle)], axis=1)
    half, w1 = 0.5 * w[:, None], w[:, None]
    share = moment / p.mass
    a, b = np.zeros((w.size, 6, 6)), np.zeros((w.size, 6, 6))
    for i, (k, damping) in enumerate(zip(p.stiffness, p.damping, strict=True)):
        x, y = 2 * i, 2 * i + 1
        a[:, x, x] = a[:, y, y] = -1.0
        b[:, x, x] = b[:, y, y] = -0.5 * damping / p.mass
        b[:, x, y] = 0.5 * w - 0.5 * k / (p.mass * w)
        b[:, y, x] = -b[:, x, y]
        a[:, x, 4:], a[:, y, 4:] = share * sin, -share * cos
        b[:, x, 4:], b[:, y, 4:] = half * share * cos, half * share * sin
        a[:, 4:, x], a[:, 4:, y] = half * cos, half * sin
        b[:, 4:, x], b[:, 4:, y] = half * w1 * sin, -half * w1 * cos
    a[:, [4, 5], [4, 5]] = drag / moment
    unit = np.array([share] * 4 + [1.0] * 2)
    return np.asarray(np.linalg.eigvals(-np.linalg.solve(a * unit, b * unit)), np.complex128)
