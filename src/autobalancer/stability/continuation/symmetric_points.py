"""Branch points that belong to a symmetry: where the balls of a race stand in line and the race begins to run true.

There balanced states end. If all balls of the race coincide they are one group that falls apart; two groups that meet are
the same point seen from the other side. Ordinary tests are singular there; in the merged balls, or in the equations of a race
that runs true alone, the point is regular.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from autobalancer.stability.continuation.follow import CORRECTIONS, Point
from autobalancer.stability.continuation.special import Special, crossing_at
from autobalancer.stability.continuation.steady import Steady
from autobalancer.stability.continuation.symmetry import gathered, joined, meeting, restoring, splittings
from autobalancer.stability.host.planar import Floats

SMALL = 1e-9


def symmetric_points(problem: Steady, kind: list[tuple[float, ...]], a: Point, b: Point) -> list[Special]:
    """All of them between two points of a curve."""
    return _meetings(problem, kind, a, b) or _splittings(problem, a, b) + _in_line(problem, a, b)


def _meetings(problem: Steady, kind: list[tuple[float, ...]], a: Point, b: Point) -> list[Special]:
    """Two groups of equal balls come together."""
    found = []
    for one, other in meeting(problem.groups, kind):
        apart = [math.sin(0.5 * float(p.u[4 + one] - p.u[4 + other])) for p in (a, b)]
        if apart[0] * apart[1] >= 0.0:
            continue
        guess = a.u + apart[0] / (apart[0] - apart[1]) * (b.u - a.u)
        groups = joined(problem.groups, (one, other))
        together = Steady(problem.span, groups)
        start = np.append(gathered(problem.state(guess), groups) / together.scale, guess[-1])
        start[4 + one] += 0.5 * math.remainder(guess[4 + other] - guess[4 + one], 2.0 * math.pi)
        u = falling_apart(together, one, start)
        if u is not None:
            point = np.append(gathered(together.state(u), problem.groups) / problem.scale, u[-1])
            balls = slice(4, 4 + len(problem.groups))
            point[balls] += 2.0 * np.pi * np.round((guess[balls] - point[balls]) / (2.0 * np.pi))
            found.append(
                Special("pitchfork", Point(point, b.tangent), onward=((groups, np.zeros(len(groups))),), ends=True)
            )
    return found


def _splittings(problem: Steady, a: Point, b: Point) -> list[Special]:
    """A group in which all balls of a race coincide falls apart."""
    found = []
    for number, group in enumerate(problem.groups):
        r = [_restoring(problem, number, p.u) for p in (a, b)]
        if (
            len(group) < 2
            or r[0] * r[1] >= 0.0
            or min(abs(r[0]), abs(r[1])) < SMALL
            or len(_company(problem, a.u, number)) > 1
        ):
            continue
        u = falling_apart(problem, number, a.u + r[0] / (r[0] - r[1]) * (b.u - a.u))
        ways = tuple(way for way in splittings(problem.groups) if group not in way[0])
        if u is not None:
            found.append(Special("pitchfork" if len(group) == 2 else "branch point", Point(u, b.tangent), onward=ways))
    return found


def _company(problem: Steady, u: Floats, group: int) -> list[int]:
    """Groups that run around the same center as this one, itself included."""
    offset = problem.field(u).plane.offset
    return [int(i) for i in np.flatnonzero(offset == offset[group])]


def _restoring(problem: Steady, group: int, u: Floats) -> float:
    return float(restoring(problem.field(u), u[:-1] * problem.scale)[group])


def falling_apart(problem: Steady, group: int, guess: Floats) -> Floats | None:
    """Where a group of coincident balls is about to fall apart: F = 0 and r = 0, regular in the merged balls."""
    u = np.array(guess)
    for _ in range(CORRECTIONS):
        offsets = 1e-6 * np.eye(u.size)
        row = np.array(
            [(_restoring(problem, group, u + h) - _restoring(problem, group, u - h)) / 2e-6 for h in offsets]
        )
        try:
            step = problem.solve(u, row, -problem.residual(u), -_restoring(problem, group, u))
        except np.linalg.LinAlgError:
            return None
        u = u + step
        if np.abs(step).max() < 1e-12:
            break
    return u if np.abs(step).max() < 1e-9 and np.abs(u - guess).max() < 0.5 else None


def _in_line(problem: Steady, a: Point, b: Point) -> list[Special]:
    """Two groups around one center stand in line and the race runs true: from the balanced side or from the other."""
    if len(problem.groups) != 2 or len(_company(problem, a.u, 0)) != 2:
        return []
    true = [problem.freedom_or_none(p.u) is not None for p in (a, b)]
    if all(true):
        test = [math.sin(float(p.u[4] - p.u[5])) for p in (a, b)]
    elif not any(true):
        test = [_restoring(problem, 0, p.u) for p in (a, b)]
    else:
        return []
    if test[0] * test[1] >= 0.0 or min(map(abs, test)) < SMALL:
        return []
    u = _closing(problem, a.u + test[0] / (test[0] - test[1]) * (b.u - a.u))
    if u is None:
        return []
    return [replace(crossing_at(problem, Point(u, b.tangent), all(true)), kind="pitchfork")]


def _closing(problem: Steady, guess: Floats) -> Floats | None:
    """The balanced state with two groups in line: load + sum s e^(i phi) = 0 and sin(phi1 - phi2) = 0 by Newton's method."""
    x = np.array([guess[4], guess[5], guess[-1]])

    def equations(x: Floats) -> tuple[Floats, complex]:
        field = problem.span.field(float(x[2]), problem.groups)
        p, center = field.plane, complex(field.plane.offset[0])
        load = p.fixed_load + center * p.dynamic_stiffness(field.speed) / field.speed**2
        total = (load + complex((p.moment * np.exp(1j * x[:2])).sum())) / p.moment.sum()
        return np.array([total.real, total.imag, math.sin(x[0] - x[1])]), -center

    for _ in range(2 * CORRECTIONS):
        slope = np.array([(equations(x + h)[0] - equations(x - h)[0]) / 2e-6 for h in 1e-6 * np.eye(3)]).T
        try:
            step = np.linalg.solve(slope, -equations(x)[0])
        except np.linalg.LinAlgError:
            return None
        x = x + step
        if np.abs(step).max() < 1e-13:
            break
    if np.abs(step).max() > 1e-9 or abs(x[2] - guess[-1]) > 0.1:
        return None
    whirl, w = equations(x)[1], problem.field(np.append(guess[:-1], x[2])).speed
    state = np.concatenate([[whirl.real, whirl.imag, -w * whirl.imag, w * whirl.real], x[:2], [0.0, 0.0]])
    return np.append(state / problem.scale, x[2])
