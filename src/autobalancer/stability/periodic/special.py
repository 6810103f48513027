"""Special points of a curve of periodic orbits: folds, period doublings, tori and branch points."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from autobalancer.stability.continuation.follow import NoConvergence, Point, locate
from autobalancer.stability.continuation.special import Special
from autobalancer.stability.host.planar import Complexes, Floats
from autobalancer.stability.periodic.orbits import Orbit, Orbits

PRECISION = 1e-11  # of the share of a step at which a special point lies


def special_orbits(problem: Orbits, a: Point, b: Point, before: Orbit, after: Orbit) -> list[Special]:
    """Special points between two orbits of a curve; ``before`` and ``after`` are the orbits at ``a`` and ``b``."""

    def at(p: Point) -> Orbit:
        return before if p is a else after if p is b else problem.orbit(p.u)

    found: list[Special] = []
    if a.tangent[-1] * b.tangent[-1] < 0.0:
        found += _located(problem, a, b, "fold", lambda p: float(p.tangent[-1]))
    elif _sign(before.own[1:], 1.0) * _sign(after.own[1:], 1.0) < 0.0:
        found += _located(problem, a, b, "branch point", lambda p: _distance(at(p).own[1:], 1.0))
    if _sign(before.apart, 1.0) * _sign(after.apart, 1.0) < 0.0:
        found += _located(problem, a, b, "branch point", lambda p: _distance(at(p).apart, 1.0))
    if _sign(before.multipliers, -1.0) * _sign(after.multipliers, -1.0) < 0.0:
        found += _located(problem, a, b, "period doubling", lambda p: _distance(at(p).multipliers, -1.0))
    counts = [int((_turning(m) > 0.0).sum()) for m in (before.multipliers, after.multipliers)]
    for rank in range(min(counts), max(counts)):

        def crossing(p: Point, rank: int = rank) -> float:
            sizes = _turning(at(p).multipliers)
            return float(sizes[rank]) if rank < sizes.size else -1.0

        found += _located(problem, a, b, "torus", crossing)
    chord = (b.u - a.u) * problem.weight
    return sorted(found, key=lambda s: float(chord @ s.point.u))


def _located(problem: Orbits, a: Point, b: Point, kind: str, test: Callable[[Point], float]) -> list[Special]:
    try:
        point = locate(problem, a, b, test, PRECISION)
    except (NoConvergence, np.linalg.LinAlgError):
        return []
    if kind != "fold" and abs(test(point)) > 1e-4:  # the sign changed because multipliers met, not because they crossed
        return []
    return [Special(kind, point, 2.0 * math.pi / problem.period(point.u))]


def _sign(values: Complexes, at: float) -> float:
    """Sign of the product of all distances from ``at``: changes where a real multiplier passes."""
    return float(np.prod(np.sign((at - values[np.abs(values.imag) < 1e-12 * np.abs(values)]).real)))


def _distance(values: Complexes, at: float) -> float:
    """Distance of the nearest real multiplier from ``at``, with the sign of the product of all."""
    real = values[np.abs(values.imag) < 1e-12 * np.abs(values)].real
    return float(np.abs(real - at).min(initial=1.0)) * _sign(values, at)


def _turning(values: Complexes) -> Floats:
    """ln|multiplier| of the complex pairs, greatest first."""
    return np.sort(np.log(np.abs(values[values.imag > 1e-9 * np.abs(values)])))[::-1]
