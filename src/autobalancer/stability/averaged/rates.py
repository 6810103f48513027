"""Averaged growth rates of balanced states at many speeds at once: of balls whose races have one center.

The averaged equations see the balls through g = sum s^2/beta and |g2|, g2 = sum (s^2/beta) e^(2 i phi), only: two balls with
the same stand for all of them. The other motions of more balls are for nothing. An eccentric race changes only the angles at
which its balls balance.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from autobalancer.stability.averaged.stations import eigenvalues_at, refuse_without_drag
from autobalancer.stability.host.planar import Complexes, Floats, Plane
from autobalancer.stability.host.stations import of_plane
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


def _eigenvalues(p: Plane, speeds: Floats, spreads: Floats) -> Complexes:
    """Of two balls at +-a, cos 2a = |g2|/g, in races that run true, (k, size)."""
    drag = float(p.drag.mean())
    two = {name: getattr(p, name)[[0, 0]] for name in ("ball_mass", "inertia", "race", "offset")}
    moment = np.full(2, np.sqrt(0.5 * drag * float((p.moment**2 / p.drag).sum())))
    pair = of_plane(replace(p, moment=moment, drag=np.full(2, drag), **two))
    angle = 0.5 * np.arccos(np.minimum(spreads, 1.0))
    true = np.zeros((speeds.size, 2), np.complex128)
    return eigenvalues_at(pair, speeds, np.stack([angle, -angle], axis=1), true)
