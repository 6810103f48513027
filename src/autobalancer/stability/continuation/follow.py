"""Pseudo-arclength continuation: one predictor-corrector for steady states, periodic orbits and border curves.

Keller (1977): n equations in n + 1 unknowns define a curve; the next point is looked for in the plane across the tangent, so
that folds are ordinary points. The last unknown is a parameter scaled so that 0 and 1 are the ends of its range.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol, Self, TypeVar

import numpy as np

from autobalancer.errors import MachineError
from autobalancer.roots import root
from autobalancer.stability.host.stations import Floats

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
            guess = here.u + size * here.tangent
            row = here.tangent * problem.weight
            try:
                u, corrections = correct(problem, guess, row, float(row @ here.u) + size)
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
    found: dict[float, Point] = {0.0: a, 1.0: b}

    def value(share: float) -> float:
        if share not in found:
            found[share] = between(problem, a, b, share)
        return test(found[share])

    if value(0.0) * value(1.0) > 0.0:
        raise NoConvergence
    share = root(value, 0.0, 1.0, xtol=precision, rtol=1e-14)
    return found[share] if share in found else between(problem, a, b, share)


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
