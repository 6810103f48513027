"""Special points of a curve of steady states: folds, branch points and Hopf points with their first Lyapunov coefficient.

Kuznetsov (2004): fold, the parameter turns back (section 10.2.1); Hopf, a pair of eigenvalues crosses the imaginary axis;
its coefficient is eq. (5.62). Branch points of groups of equal balls are found by scalar tests that belong to one symmetry
each: two groups meet, or one falls apart (:mod:`autobalancer.stability.steady_curves`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Protocol, Self, TypeVar

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from autobalancer.arrays import Complexes, Floats, Matrix
from autobalancer.errors import MachineError
from autobalancer.roots import root
from autobalancer.stability.steady_curves import (
    DIFFERENCE,
    Groups,
    Range,
    Steady,
    centers_of,
    restoring,
    splittings,
    true_races,
)

# Pseudo-arclength continuation: one predictor-corrector for steady states, periodic orbits and border curves.
#
# Keller (1977): n equations in n + 1 unknowns define a curve; the next point is looked for in the plane across the
# tangent, so that folds are ordinary points. The last unknown is a parameter scaled so that 0 and 1 are the ends of
# its range.


TOLERANCE = 1e-11  # of the last correction, in scaled unknowns
CORRECTIONS = 12
LARGEST_TURN = 0.45  # rad between two tangents


class Problem(Protocol):
    """n equations in n + 1 scaled unknowns."""

    @property
    def weight(self) -> Floats:
        """Of each unknown in the inner product, (n + 1,)."""

    def residual(self, u: Floats) -> Floats:
        """The mismatch, (n,)."""

    def solve(self, u: Floats, row: Floats, right: Floats, last: float) -> Floats:
        """Solution of the equations linearized at ``u`` and bordered by ``row``."""

    def renewed(self, u: Floats, tangent: Floats) -> tuple[Self, Floats, Floats]:
        """The problem in the form that suits the next step (mesh, phase), with point and tangent in it."""


P = TypeVar("P", bound=Problem)


@dataclass(frozen=True)
class Point:
    """A point of a curve with its unit tangent."""

    u: Floats
    tangent: Floats


@dataclass(frozen=True)
class Steps:
    """Sizes of steps in scaled arclength."""

    first: float = 0.01
    least: float = 1e-7
    most: float = 0.03
    count: int = 2000


class NoConvergence(Exception):
    """The corrector failed; the step must be shorter."""


def correct(problem: Problem, guess: Floats, row: Floats, value: float) -> tuple[Floats, int]:
    """The solution with ``row . u = value`` near a guess, and how many corrections it took."""
    u, last = np.array(guess), math.inf
    for number in range(1, CORRECTIONS + 1):
        with np.errstate(all="ignore"):
            try:
                step = problem.solve(u, row, -problem.residual(u), value - float(row @ u))
            except (np.linalg.LinAlgError, MachineError):  # the second: a value beyond the range that no machine has
                raise NoConvergence from None
        size = float(np.abs(step).max())
        if not math.isfinite(size) or (number > 3 and size > 2.0 * last and size > 1e-6):
            raise NoConvergence
        u = u + step
        if size < TOLERANCE or (size < 1e-9 and size > 0.3 * last):  # the second: rounding is reached
            return u, number
        last = size
    raise NoConvergence


def at_parameter(problem: Problem, guess: Floats, value: float) -> Floats:
    """The solution at a given value of the last unknown."""
    row = np.zeros(guess.size)
    row[-1] = 1.0
    return correct(problem, guess, row, value)[0]


def tangent_at(problem: Problem, u: Floats, like: Floats) -> Floats:
    """Unit tangent in the sense of ``like``."""
    zero = np.zeros(u.size - 1)
    t = problem.solve(u, like * problem.weight, zero, 1.0)
    return np.asarray(t / math.sqrt(float(problem.weight @ (t * t))))


def follow(
    problem: P,
    start: Floats,
    like: Floats,
    *,
    steps: Steps,
    low: float = 0.0,
    high: float = 1.0,
) -> Iterator[tuple[P, Point, Point]]:
    """Pieces of the curve from ``start`` on, until the last unknown leaves [low, high].

    The piece at an end of the range ends exactly there. Steps are halved where the corrector fails or the curve turns by
    too much, and grow again; a curve that cannot be followed any more just ends.
    """
    here = Point(start, tangent_at(problem, start, like))
    size = steps.first
    for number in range(steps.count):
        while True:
            if size < steps.least:
                return
            # predictor along the tangent, corrector in the plane across it
            guess = here.u + size * here.tangent
            row = here.tangent * problem.weight
            try:
                u, corrections = correct(problem, guess, row, float(row @ here.u) + size)
                # beyond the range: exactly to its end instead
                if not low <= u[-1] <= high and abs(u[-1] - here.u[-1]) > 1e-12:
                    edge = low if u[-1] < low else high
                    share = (edge - here.u[-1]) / (u[-1] - here.u[-1])
                    if number == 0 and share <= 1e-9:
                        return  # starts at an end of the range and leaves it at once
                    u = at_parameter(problem, here.u + share * (u - here.u), edge)
                there = Point(u, tangent_at(problem, u, here.tangent))
            except (NoConvergence, np.linalg.LinAlgError):
                size *= 0.5
                continue
            # a curve that turns too much was stepped over too far, if it is the same curve at all
            turn = math.acos(min(1.0, abs(float(row @ there.tangent))))
            if turn > LARGEST_TURN and size > 16.0 * steps.least:
                size *= 0.5
                continue
            break
        yield problem, here, there
        if not low < there.u[-1] < high:
            return
        growth = 1.4 if corrections <= 4 and turn < 0.4 * LARGEST_TURN else 0.7 if turn > 0.7 * LARGEST_TURN else 1.0
        size = min(steps.most, size * growth)
        problem, u, t = problem.renewed(there.u, there.tangent)
        here = Point(u, t)


def between(problem: Problem, a: Point, b: Point, share: float) -> Point:
    """The point of the curve at a share of the chord from ``a`` to ``b``."""
    chord = b.u - a.u
    row = chord * problem.weight
    row = row / math.sqrt(float(row @ chord))
    guess = a.u + share * chord
    u = correct(problem, guess, row, float(row @ guess))[0]
    return Point(u, tangent_at(problem, u, chord))


def locate(problem: Problem, a: Point, b: Point, test: Callable[[Point], float], precision: float = 1e-13) -> Point:
    """Where a test function that has opposite signs at ``a`` and ``b`` is zero.

    Raises
    ------
    NoConvergence
        If the curve cannot be followed between them, or the test has one sign only.
    """
    point: dict[float, Point] = {0.0: a, 1.0: b}

    def value(share: float) -> float:
        if share not in point:
            point[share] = between(problem, a, b, share)
        return test(point[share])

    if value(0.0) * value(1.0) > 0.0:
        raise NoConvergence
    share = root(value, 0.0, 1.0, xtol=precision, rtol=1e-14)
    return point[share] if share in point else between(problem, a, b, share)


# Does a curve come back to where it was?


AWAY = 12  # points before which a curve cannot have come back
NEAR = 0.03  # distance from the chord of a step, in units of its length


class Loop:
    """Watches for a return to the start, then to places at ever longer intervals (Brent 1980)."""

    def __init__(self, place: Floats) -> None:
        self.place, self.steps, self.next = place, 0, 4 * AWAY

    def closed(self, a: Floats, b: Floats) -> bool:
        """Whether the step from ``a`` to ``b`` passes the place."""
        self.steps += 1
        chord = b - a
        length = float(np.linalg.norm(chord))
        if self.steps > AWAY and length > 0.0:
            share = float((self.place - a) @ chord) / length**2
            if 0.0 <= share <= 1.0 and np.linalg.norm(self.place - a - share * chord) < NEAR * length:
                return True
        if self.steps == self.next:
            self.place, self.steps, self.next = b, 0, 2 * self.next
        return False


SMALL = 1e-9  # in units of the critical speed: slower rotations of an eigenvalue count as none
APART = 1e-13  # from an eigenvalue, over the greatest entry, so that the matrix can be factorized
DOUBLING = 1e-7  # in units of the critical speed: a frequency so near to the speed is the speed
SINGULAR = 1e-6  # singular value below which the equations have two curves through a point


def special_points(problem: Steady, kind: list[tuple[float, ...]], a: Point, b: Point) -> list[Special]:
    """All special points between two points of a curve, in order."""
    before, after = (int((growing(problem.eigenvalues(p.u)) > 0.0).sum()) for p in (a, b))
    specials: list[Special] = []
    for rank in range(min(before, after), max(before, after)):

        def crossing(p: Point, rank: int = rank) -> float:
            rates = growing(problem.eigenvalues(p.u))
            return float(rates[rank]) if rank < rates.size else -problem.span.frequency

        try:
            point = locate(problem, a, b, crossing)
            if abs(crossing(point)) < 1e-6 * problem.span.frequency:
                specials.append(hopf_point(problem, point))
        except NoConvergence:
            continue
    if problem.loose:  # across a continuum balls may meet and part freely; it ends where its parameter turns
        specials += [
            replace(s, kind="branch point", onward=(), ends=True) for s in _folds_and_branch_points(problem, a, b)
        ]
    else:
        specials += symmetric_points(problem, kind, a, b) or _folds_and_branch_points(problem, a, b)
    chord = (b.u - a.u) * problem.weight
    return sorted(specials, key=lambda s: float(chord @ s.point.u))


def growing(values: Complexes) -> Floats:
    """Real parts of the pairs of complex eigenvalues, greatest first."""
    return np.sort(values.real[values.imag > SMALL * np.abs(values).max()])[::-1]


def hopf_point(problem: Steady, guess: Point) -> Special:
    """The Hopf point near a guess, exactly, with frequency, mode and Lyapunov coefficient.

    Newton's method on F = 0, (J - i w) q = 0, c.q = 1 for state, parameter, frequency w and mode q.
    """
    u, d = np.array(guess.u), guess.u.size - 1
    # begin with the eigenvalue nearest the imaginary axis and its vector
    values = problem.eigenvalues(u) / problem.span.frequency
    chosen = int(np.argmin(np.where(values.imag > SMALL, np.abs(values.real), np.inf)))
    q, w = null_vector(problem.jacobian(u), values[chosen]), float(values[chosen].imag)
    c = np.conj(q) / np.vdot(q, q)
    # all unknowns together; where states form a continuum, the shortest step
    for _ in range(CORRECTIONS):
        matrix, miss = hopf_slopes(problem, u, w, q, c), hopf_equations(problem, u, w, q, c)
        step = (
            np.linalg.lstsq(matrix, -miss, rcond=problem.slack)[0] if problem.loose else np.linalg.solve(matrix, -miss)
        )
        u, w = u + step[: d + 1], w + float(step[d + 1])
        q = q + step[d + 2 : 2 * d + 2] + 1j * step[2 * d + 2 :]
        if np.abs(step).max() < 1e-12 or not np.all(np.isfinite(step)):
            break
    if not (np.all(np.isfinite(u)) and abs(u[-1] - guess.u[-1]) < 1e-3):
        raise NoConvergence
    # on axes that turn with the rotor, half its speed is a period doubling in space
    q = as_ball_angle(q, problem)
    if (
        abs(w * problem.span.frequency - problem.field(u).speed) < DOUBLING * problem.span.frequency
        and problem.count > 1
    ):
        return Special("period doubling", Point(u, guess.tangent), w * problem.span.frequency, mode=q)
    # along a continuum the drift of its other states takes part: no coefficient of one mode decides
    lyapunov = math.nan if problem.loose else lyapunov_coefficient(problem, u, q, w)
    return Special("Hopf", Point(u, guess.tangent), w * problem.span.frequency, lyapunov, q)


def hopf_equations(problem: Steady, u: Floats, w: float, q: Complexes, c: Complexes) -> Floats:
    """Mismatch of F = 0, (J - i w) q = 0, c.q = 1."""
    miss, length = problem.jacobian(u) @ q - 1j * w * q, c @ q - 1.0
    return np.concatenate([problem.residual(u), miss.real, miss.imag, [length.real, length.imag]])


def hopf_slopes(problem: Steady, u: Floats, w: float, q: Complexes, c: Complexes) -> Matrix:
    """Its derivative in state, share, w, Re q, Im q."""
    d = u.size - 1
    eye, j = np.eye(d), problem.jacobian(u)
    shares, weights = problem.span.offsets(float(u[-1]))
    moved = sum(m * problem.jacobian(np.append(u[:-1], s)) @ q for s, m in zip(shares, weights, strict=True))
    bent = problem.bent(u, q)
    turning = j - 1j * w * eye
    rows = np.column_stack([bent, moved, -1j * q, turning, 1j * turning])
    norm = np.concatenate([np.zeros(d + 2), c, 1j * c])
    state_rows = np.column_stack([j, problem.slope(u), np.zeros((d, 2 * d + 1))])
    return np.vstack([state_rows, rows.real, rows.imag, norm.real, norm.imag])


def null_vector(matrix: Matrix, value: complex) -> Complexes:
    """The eigenvector of an eigenvalue that is known well, by inverse iteration."""
    size = matrix.shape[0]
    near = matrix - (value + APART * np.abs(matrix).max()) * np.eye(size)
    result = np.exp(1j * np.arange(size))
    factors = scipy.linalg.lu_factor(near)
    for _ in range(3):
        result = scipy.linalg.lu_solve(factors, result)
        result = result / np.linalg.norm(result)
    return np.asarray(result, np.complex128)


def as_ball_angle(q: Complexes, problem: Steady) -> Complexes:
    """The mode 2 Re(q e^iwt) scaled to a greatest ball angle of 1 rad, that ball at its turning point at t = 0.

    Where it changes over half a turn, in the mean square.
    """
    balls = q.reshape(problem.count, -1)[:, problem.angles]
    most = balls[:, np.argmax((np.abs(balls) ** 2).sum(0))]
    largest = most[np.argmax(np.abs(most))]
    return np.asarray(0.5 * q / (largest / np.abs(largest) * np.linalg.norm(most)), np.complex128)


def lyapunov_coefficient(problem: Steady, u: Floats, q: Complexes, w: float) -> float:
    """Kuznetsov (2004), eq. (5.62): amplitude a' = ... + w l1 a^3 in scaled time; below zero, a small stable cycle is born."""
    j = problem.jacobian(u)
    p = np.conj(null_vector(j.T, 1j * w))
    p = p / np.conj(np.vdot(p, q))
    conj = np.conj(q)
    mean = np.linalg.solve(j, problem.second(u, q, conj))
    twice = np.linalg.solve(2j * w * np.eye(j.shape[0]) - j, problem.second(u, q, q))
    total = (
        problem.third(u, q, conj)
        - 2.0 * problem.second(u, q, mean.astype(np.complex128))
        + problem.second(u, conj, twice)
    )
    return float((np.vdot(p, total)).real / (2.0 * w))


def _folds_and_branch_points(problem: Steady, a: Point, b: Point) -> list[Special]:
    # a fold: the parameter turns back; with a singular Jacobian of rank two less it is a branch point
    if a.tangent[-1] * b.tangent[-1] < 0.0:
        point = _try(problem, a, b, lambda p: float(p.tangent[-1]))
        return (
            []
            if point is None
            else [Special("fold", point)]
            if _regular(problem, point)
            else [crossing_at(problem, point, True)]
        )

    if problem.loose:
        return []

    # another branch crosses where the bordered matrix changes its orientation
    def orientation(p: Point) -> float:
        return float(np.linalg.slogdet(problem.bordered(p.u, p.tangent))[0])

    if orientation(a) * orientation(b) < 0.0:
        point = _try(problem, a, b, orientation)
        if point is not None and not _regular(problem, point):
            return [crossing_at(problem, point, False)]
    return []


def _regular(problem: Steady, point: Point) -> bool:
    rows = problem.bordered(point.u, point.tangent)[:-1]
    return bool(np.linalg.svd(rows, compute_uv=False)[-1] > SINGULAR)


def _try(problem: Steady, a: Point, b: Point, test: Callable[[Point], float]) -> Point | None:
    """:func:`locate`, or ``None`` where the curve cannot be followed."""
    try:
        return locate(problem, a, b, test)
    except (NoConvergence, np.linalg.LinAlgError):
        return None


# Branch points that belong to a symmetry: where the balls of a race stand in line and the race begins to run true.
#
# There balanced states end. If all balls of the race coincide they are one group that falls apart; two groups that
# meet are the same point seen from the other side. Ordinary tests are singular there; in the merged balls, or in the
# equations of a race that runs true alone, the point is regular.


AT_REST = 1e-9  # of the residual, in units of the problem


def symmetric_points(problem: Steady, kind: list[tuple[float, ...]], a: Point, b: Point) -> list[Special]:
    """All of them between two points of a curve."""
    return _meetings(problem, kind, a, b) or _splittings(problem, a, b) + _in_line(problem, a, b)


def _meetings(problem: Steady, kind: list[tuple[float, ...]], a: Point, b: Point) -> list[Special]:
    """Two groups of equal balls come together."""
    meetings, first = [], problem.first
    equal = [kind[group[0]] for group in problem.groups]  # only equal balls can come together
    for one, other in combinations(range(len(equal)), 2):
        if equal[one] != equal[other]:
            continue
        apart = [math.sin(0.5 * float(p.u[first + one] - p.u[first + other])) for p in (a, b)]
        if apart[0] * apart[1] >= 0.0:
            continue
        guess = a.u + apart[0] / (apart[0] - apart[1]) * (b.u - a.u)
        both = tuple(sorted(problem.groups[one] + problem.groups[other]))
        groups = tuple(both if k == one else group for k, group in enumerate(problem.groups) if k != other)
        together = Steady(problem.span, groups)
        start = np.append(together.gathered(problem.state(guess)), guess[-1])
        start[first + one] += 0.5 * math.remainder(guess[first + other] - guess[first + one], 2.0 * math.pi)
        u = falling_apart(together, one, start)
        if u is not None:
            point = np.append(problem.gathered(together.state(u)), u[-1])
            balls = problem.angles
            point[balls] += 2.0 * np.pi * np.round((guess[balls] - point[balls]) / (2.0 * np.pi))
            meetings.append(
                Special("pitchfork", Point(point, b.tangent), onward=((groups, np.zeros(len(groups))),), ends=True)
            )
    return meetings


def _splittings(problem: Steady, a: Point, b: Point) -> list[Special]:
    """A group in which all balls of a race coincide falls apart."""
    specials = []
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
            specials.append(
                Special("pitchfork" if len(group) == 2 else "branch point", Point(u, b.tangent), onward=ways)
            )
    return specials


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
    specials = []
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
            specials.append(replace(crossing_at(problem, Point(u, b.tangent), all(true)), kind="pitchfork"))
    return specials


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
    # the groups whose race runs true, one equation pair for each race
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

    # Newton's method with slopes by differences: the system is small
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
    closing = size < 1e-9 and abs(u[-1] - guess[-1]) < 0.1
    return u if closing and np.abs(problem.residual(u)).max() < AT_REST else None


# What is known of a special point of a curve.


@dataclass(frozen=True)
class Special:
    """A special point, and where to go on from it."""

    kind: str  # fold, Hopf, pitchfork, branch point
    point: Point
    frequency: float = math.nan  # of the Hopf mode, rad/s
    lyapunov: float = math.nan  # first Lyapunov coefficient for an amplitude of the ball angle in rad
    mode: Complexes = field(default_factory=lambda: np.zeros(0, np.complex128))  # scaled, ball angle of amplitude 1 rad
    onward: tuple[tuple[Groups, Floats], ...] = ()  # groups and direction of the ball groups of what branches off
    ends: bool = False  # beyond it the curve is its own copy with balls exchanged


def crossing_at(problem: Steady, point: Point, ends: bool) -> Special:
    """A branch point without a symmetry of its own: on along the other direction in the kernel."""
    vectors = np.linalg.svd(problem.bordered(point.u, point.tangent)[:-1])[2][-2:]
    t = point.tangent / np.linalg.norm(point.tangent)
    other = max((v - (v @ t) * t for v in vectors), key=lambda v: float(np.linalg.norm(v)))
    return Special("branch point", point, onward=((problem.groups, other / np.linalg.norm(other)),), ends=ends)


# Curves of Hopf points and of folds in a plane of two parameters: where steady states are born, vanish or lose
# stability.


class Curve:
    """Unknowns: those of a special point along the first parameter, then the share of the second parameter's range."""

    def __init__(self, span: Range, groups: Groups, start: float, end: float, border: Complexes) -> None:
        self.span, self.groups, self.start, self.end, self.border = span, groups, start, end, border
        self.size = span.count * (span.rotor + 2 * len(groups))  # of the state
        self.weight = np.ones(self.unknowns)

    unknowns: int

    def second(self, u: Floats) -> float:
        """The second parameter."""
        return self.start + (self.end - self.start) * float(u[-1])

    def steady(self, second: float) -> Steady:
        """The steady states at a value of the second parameter."""
        return Steady(self.span.moved(second), self.groups)

    def equations(self, u: Floats, second: float) -> Floats:
        """The mismatch."""
        raise NotImplementedError

    def slopes(self, u: Floats, second: float) -> Matrix:
        """Its derivative with respect to all unknowns but the last."""
        raise NotImplementedError

    def renewed(self, u: Floats, tangent: Floats) -> tuple[Self, Floats, Floats]:
        """The mode is measured against itself from step to step."""
        raise NotImplementedError

    def residual(self, u: Floats) -> Floats:
        return self.equations(u, self.second(u))

    def solve(self, u: Floats, row: Floats, right: Floats, last: float) -> Floats:
        value = self.second(u)
        step = DIFFERENCE * (abs(value) or abs(self.end - self.start))
        four = [self.equations(u, value + k * step) for k in (-2, -1, 1, 2)]
        slope = (four[0] - 8.0 * four[1] + 8.0 * four[2] - four[3]) / (12.0 * step) * (self.end - self.start)
        matrix = np.vstack([np.column_stack([self.slopes(u, value), slope]), row])
        return np.asarray(np.linalg.solve(matrix, np.append(right, last)))

    def tail(self, u: Floats) -> float:
        """Size of the highest harmonic of the state; zero of one at rest."""
        return self.steady(self.second(u)).tail(u[: self.size + 1])

    def share(self, u: Floats) -> float:
        """Share of the first parameter's range."""
        return float(u[self.size])


class HopfCurve(Curve):
    """Unknowns: state, first share, frequency, mode (real and imaginary part), second share."""

    @property
    def unknowns(self) -> int:  # type: ignore[override]
        """3 d + 3."""
        return 3 * self.size + 3

    def parts(self, u: Floats) -> tuple[Floats, float, Complexes]:
        """State with first share, frequency, mode."""
        d = self.size
        return u[: d + 1], float(u[d + 1]), u[d + 2 : 2 * d + 2] + 1j * u[2 * d + 2 : 3 * d + 2]

    def equations(self, u: Floats, second: float) -> Floats:
        return hopf_equations(self.steady(second), *self.parts(u), self.border)

    def slopes(self, u: Floats, second: float) -> Matrix:
        return hopf_slopes(self.steady(second), *self.parts(u), self.border)

    def renewed(self, u: Floats, tangent: Floats) -> tuple[Self, Floats, Floats]:
        q = self.parts(u)[2]
        return type(self)(self.span, self.groups, self.start, self.end, np.conj(q) / np.vdot(q, q)), u, tangent

    def lyapunov(self, u: Floats) -> float:
        """First Lyapunov coefficient, as for a Hopf point."""
        point, frequency, q = self.parts(u)
        return lyapunov_coefficient(
            self.steady(self.second(u)), point, as_ball_angle(q, self.steady(self.second(u))), frequency
        )

    def frequency(self, u: Floats) -> float:
        """rad/s."""
        return float(u[self.size + 1]) * self.span.frequency


class FoldCurve(Curve):
    """Unknowns: state, first share, null vector, second share."""

    @property
    def unknowns(self) -> int:  # type: ignore[override]
        """2 d + 2."""
        return 2 * self.size + 2

    def equations(self, u: Floats, second: float) -> Floats:
        d, problem = self.size, self.steady(second)
        point, q = u[: d + 1], u[d + 1 : 2 * d + 1]
        return np.concatenate(
            [problem.residual(point), problem.jacobian(point) @ q, [float(self.border.real @ q) - 1.0]]
        )

    def slopes(self, u: Floats, second: float) -> Matrix:
        d, problem = self.size, self.steady(second)
        point, q = u[: d + 1], u[d + 1 : 2 * d + 1]
        j, c = problem.jacobian(point), self.border.real
        shares, weights = problem.span.offsets(float(point[-1]))
        moved = sum(m * problem.jacobian(np.append(point[:-1], s)) @ q for s, m in zip(shares, weights, strict=True))
        bent = problem.bent(point, q)
        return np.block(
            [
                [j, problem.slope(point)[:, None], np.zeros((d, d))],
                [bent, np.asarray(moved)[:, None], j],
                [np.zeros((1, d + 1)), c[None]],
            ]
        )

    def renewed(self, u: Floats, tangent: Floats) -> tuple[Self, Floats, Floats]:
        q = u[self.size + 1 : 2 * self.size + 1]
        return type(self)(self.span, self.groups, self.start, self.end, (q / (q @ q)).astype(np.complex128)), u, tangent

    def curvature(self, u: Floats) -> float:
        """Quadratic coefficient of the fold; zero at a cusp."""
        d, problem = self.size, self.steady(self.second(u))
        point, q = u[: d + 1], u[d + 1 : 2 * d + 1]
        left = np.linalg.svd(problem.jacobian(point).T)[2][-1]
        return float(left @ problem.second(point, q, q) / np.sign(left @ problem.slope(point)))
