"""Branch points that belong to a symmetry: where the balls of a race stand in line and the race begins to run true.

There balanced states end. If all balls of the race coincide they are one group that falls apart; two groups that meet are
the same point seen from the other side. Ordinary tests are singular there; in the merged balls, or in the equations of a race
that runs true alone, the point is regular.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from autobalancer.stability.continuation.follow import CORRECTIONS, Point
from autobalancer.stability.continuation.special import Special, crossing_at
from autobalancer.stability.continuation.steady import Steady, centers_of, true_races
from autobalancer.stability.continuation.symmetry import joined, meeting, restoring, splittings
from autobalancer.stability.host.planar import Floats

SMALL = 1e-9
AT_REST = 1e-9  # of the residual, in units of the problem


def symmetric_points(problem: Steady, kind: list[tuple[float, ...]], a: Point, b: Point) -> list[Special]:
    """All of them between two points of a curve."""
    return _meetings(problem, kind, a, b) or _splittings(problem, a, b) + _in_line(problem, a, b)


def _meetings(problem: Steady, kind: list[tuple[float, ...]], a: Point, b: Point) -> list[Special]:
    """Two groups of equal balls come together."""
    found, first = [], problem.first
    for one, other in meeting(problem.groups, kind):
        apart = [math.sin(0.5 * float(p.u[first + one] - p.u[first + other])) for p in (a, b)]
        if apart[0] * apart[1] >= 0.0:
            continue
        guess = a.u + apart[0] / (apart[0] - apart[1]) * (b.u - a.u)
        groups = joined(problem.groups, (one, other))
        together = Steady(problem.span, groups)
        start = np.append(together.gathered(problem.state(guess)), guess[-1])
        start[first + one] += 0.5 * math.remainder(guess[first + other] - guess[first + one], 2.0 * math.pi)
        u = falling_apart(together, one, start)
        if u is not None:
            point = np.append(problem.gathered(together.state(u)), u[-1])
            balls = problem.angles
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
    host = problem.field(u).host
    same = (host.offset == host.offset[group]) & (host.station == host.station[group])
    return [int(i) for i in np.flatnonzero(same)]


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
    """Two groups around one center stand in line and their race runs true: from the balanced side or from the other."""
    found = []
    for one in range(len(problem.groups)):
        pair = _company(problem, a.u, one)
        if len(pair) != 2 or pair[0] != one:
            continue
        true = [bool(_true(problem, p.u)[one]) for p in (a, b)]
        if all(true):
            test = [_across(problem, p.u, pair) for p in (a, b)]
        elif not any(true):
            test = [_restoring(problem, one, p.u) for p in (a, b)]
        else:
            continue
        if test[0] * test[1] >= 0.0 or min(map(abs, test)) < SMALL:
            continue
        u = _closing(problem, a.u + test[0] / (test[0] - test[1]) * (b.u - a.u), pair)
        if u is not None:
            found.append(replace(crossing_at(problem, Point(u, b.tangent), all(true)), kind="pitchfork"))
    return found


def _across(problem: Steady, u: Floats, pair: list[int]) -> float:
    angles = u[problem.angles]
    return math.sin(float(angles[pair[0]] - angles[pair[1]]))


def _true(problem: Steady, u: Floats) -> NDArray[np.bool_]:
    """Whether the race of each group runs true."""
    return true_races(problem.field(u), u[:-1] * problem.scale, problem.span.length)


def _closing(problem: Steady, guess: Floats, pair: list[int]) -> Floats | None:
    """The state near a guess in which the race of two groups runs true and they stand in line, by Newton's method.

    Where races run true the balls have no torque whatever their angles: c = 0 takes the place of their two equations, which
    leaves a regular system. Other races must not have more than two groups that run true.
    """
    true = _true(problem, guess)
    true[pair] = True
    firsts = [i for i in np.flatnonzero(true) if _company(problem, guess, int(i))[0] == i]
    if true.sum() != 2 * len(firsts):
        return None
    length = problem.span.length

    def equations(u: Floats) -> Floats:
        field, state = problem.field(u), u[:-1] * problem.scale
        missed = problem.residual(u)
        center = centers_of(field.host, state)[firsts] / length
        torques = problem.angles.stop + np.flatnonzero(true)  # their mean, on anisotropic supports
        return np.concatenate([np.delete(missed, torques), center.real, center.imag, [_across(problem, u, pair)]])

    u, size = np.array(guess), math.inf
    for _ in range(2 * CORRECTIONS):
        slope = np.array([(equations(u + h) - equations(u - h)) / 2e-6 for h in 1e-6 * np.eye(u.size)]).T
        try:
            step = np.linalg.solve(slope, -equations(u))
        except np.linalg.LinAlgError:
            return None
        u, size = u + step, float(np.abs(step).max())
        if size < 1e-13:
            break
    # what balls feel beyond the deflection of their race may leave a state in line without a race that runs true
    found = size < 1e-9 and abs(u[-1] - guess[-1]) < 0.1
    return u if found and np.abs(problem.residual(u)).max() < AT_REST else None
