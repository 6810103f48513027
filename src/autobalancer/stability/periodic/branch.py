"""One side of a branch of periodic orbits, from a start to where it ends."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from autobalancer.stability.continuation.follow import NoConvergence, Point, Steps, follow, locate
from autobalancer.stability.continuation.loop import Loop
from autobalancer.stability.continuation.special import Special
from autobalancer.stability.host.planar import Complexes, Floats
from autobalancer.stability.periodic.orbits import FIRST_AMPLITUDE, Orbit, Orbits
from autobalancer.stability.periodic.rows import Row, orbit_row

FIRST, LEAST, MOST = 0.02, 1e-6, 5.0  # steps; the largest in units of that of steady states
INACCURATE = 1e-3  # error of the trivial multiplier above which an orbit is not trusted
COUNT = 500  # at most so many orbits
LONG = 60.0  # times the shortest period of the branch
SETTLED, NEARLY = 1e-3, 2e-2  # change of the parameter while the period doubles: it has no limit, or seems to have none


@dataclass
class Side:
    """Orbits in order, the special ones among them, and how it ended."""

    rows: list[Row]
    specials: list[tuple[Special, Row]] = field(default_factory=list)
    ended: str = "could not be followed further"


def follow_orbits(
    problem: Orbits, u: Floats, like: Floats, most: float, *, born: bool, say: Callable[[float], None]
) -> Side:
    """Follow orbits until the range ends, they close, shrink to a Hopf point (if ``born`` at one) or take for ever."""
    side = Side([orbit_row(problem, u)])
    rows, here = side.rows, problem.orbit(u)
    loop, grown, shortest = Loop(_mark(rows[0])), 0.0, here.period
    for now, a, b in follow(problem, u, like, steps=Steps(FIRST, LEAST, MOST * most, COUNT)):
        there = now.orbit(b.u)
        if abs(there.multipliers[0] - 1.0) > INACCURATE:
            side.ended = "too unstable to be followed"
            break
        for special in special_orbits(now, a, b, here, there):
            row = orbit_row(now, special.point.u)
            side.specials.append((special, row))
            rows.append(row)
        rows.append(orbit_row(now, b.u))
        say(float(b.u[-1]))
        here, shortest = there, min(shortest, there.period)
        size = float(np.ptp(now.states(b.u)[:, now.balls], axis=0).max())
        grown = max(grown, size)
        if born and size < FIRST_AMPLITUDE < 0.5 * grown:
            side.ended = "Hopf"
        elif loop.closed(_mark(rows[-2]), _mark(rows[-1])):
            side.ended = "closed"
        elif there.period > LONG * shortest or _without_limit(rows, SETTLED):
            side.ended = "period without limit"
        elif not 0.0 < b.u[-1] < 1.0:
            side.ended = "end of the range"
        else:
            continue
        break
    if side.ended in ("too unstable to be followed", "period without limit") and _without_limit(rows, NEARLY):
        side.ended = "period without limit"
        last = _extrapolated(rows, problem.span.value)
        side.specials.append((Special("infinite period", Point(u, like), 0.0), last))
    return side


def _mark(row: Row) -> Floats:
    """Numbers by which an orbit is known again: where all balls turn, its growth rate stands in for their angles."""
    span = np.concatenate([row.low, row.high])
    enough = bool(np.isfinite(span).any() and np.isnan(span).any())
    growth = 0.0 if enough else 10.0 * row.growth / row.speed
    return np.concatenate([[row.share, math.log(row.period), growth], np.nan_to_num(span)])


def _without_limit(rows: list[Row], change: float) -> bool:
    """Whether the period has at least doubled at the end while the parameter changed by no more than this share of it."""
    period = rows[-1].period
    values = [row.value for row in rows if row.period > 0.5 * period]
    longer = len(values) > 3 and period > 2.0 * min(row.period for row in rows if math.isfinite(row.period))
    return longer and max(values) - min(values) < change * max(map(abs, values))


def _extrapolated(rows: list[Row], value: Callable[[float], float]) -> Row:
    """Where the period is infinite: at a fold on a stable orbit 1/T^2 runs to zero linearly; elsewhere about here."""
    (x, p), (y, q), (z, r) = ((row.period**-2, row.share) for row in rows[-3:])
    share = r
    if not rows[-1].unstable and q != p and y != x and abs((r - q) / (q - p) * (y - x) / (z - y) - 1.0) < 0.3:
        share = r - z * (r - q) / (z - y)
    return replace(rows[-1], share=share, value=value(share), period=math.inf)


# Special points of a curve of periodic orbits: folds, period doublings, tori and branch points.


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
