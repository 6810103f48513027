"""Growth rate of the balanced state over the speed, for any planar machine without gravity in its plane.

Three routes, the fastest that is exact: equal balls in races with one center by the polynomial of degree eight; other
machines on isotropic supports by the eigenvalues of their linearized equations; orthotropic supports by the multipliers
over a revolution. More than two balls in races that run true have a continuum of balanced states; some members stand
for it, from the least to the greatest |S2| where that decides.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.stability.characteristic import PlanarBalancer, growth_rates
from autobalancer.stability.equilibria import Equilibrium, _running_true, close_polygon
from autobalancer.stability.floquet import periodic_state
from autobalancer.stability.lateral import Floats, Plane
from autobalancer.stability.linear import eigensystem, kept, matrices
from autobalancer.stability.spread import spread_of_two, spread_range

MEMBERS = (0.0, 0.02, 0.1, 0.3, 0.6, 1.0)  # of the continuum, by |S2| from least to greatest
SAMPLES = 24  # of a continuum of unequal balls
POINTS = {"polynomial": 1500, "eigenvalues": 240, "multipliers": 100}  # speeds at which a border is looked for


class Balanced(Protocol):
    """One balanced state, followed over the speed."""

    @property
    def route(self) -> str:
        """polynomial, eigenvalues or multipliers."""

    def rates(self, speeds: Floats) -> Floats:
        """Growth rates, 1/s; nan where there is no such state."""


def target(p: Plane, speed: float, center: complex) -> complex:
    """What the balls of races with this center have to add up to so that these run true, kg m."""
    if center == 0.0:
        return -p.fixed_load
    return -center * p.dynamic_stiffness(speed) / speed**2 - p.fixed_load


@dataclass(frozen=True)
class EqualBalls:
    """Equal balls in races with one center: only |S2| counts. ``place`` in its range: 0 the least, 1 the greatest."""

    plane: Plane
    place: float = 0.0
    route: str = "polynomial"

    @cached_property
    def balancer(self) -> PlanarBalancer:
        """The numbers of the closed form."""
        return planar_balancer_of(self.plane)

    def shares(self, speeds: Floats) -> Floats:
        """Resultant of the balls in units of one ball."""
        p, center = self.plane, complex(self.plane.offset[0])
        if center == 0.0:
            return np.full(speeds.size, abs(p.fixed_load) / p.moment[0])
        sizes = np.array([abs(target(p, float(w), center)) for w in speeds])
        return np.asarray(sizes / p.moment[0], np.float64)

    def spreads(self, speeds: Floats) -> Floats:
        """|S2| at each speed; nan where the balls are too weak."""
        shares = self.shares(speeds)
        possible = shares <= self.balancer.count * (1.0 + 1e-12)
        return np.where(possible, self._spread(np.minimum(shares, self.balancer.count)), np.nan)

    def rates(self, speeds: Floats) -> Floats:
        """Growth rates, 1/s."""
        spreads = self.spreads(speeds)
        rates = growth_rates(self.balancer, speeds, np.nan_to_num(spreads))[0]
        return np.where(np.isnan(spreads), np.nan, rates)

    def _spread(self, shares: Floats) -> Floats:
        count = self.balancer.count
        if count == 2:
            return spread_of_two(shares)
        grid, values = self._table
        return np.asarray(np.interp(shares, grid, values))

    @cached_property
    def _table(self) -> tuple[Floats, Floats]:
        """|S2| over the resultant: one value if the race is centric, else a table."""
        count, center = self.balancer.count, self.plane.offset[0]
        grid = self.shares(np.ones(1)) if center == 0.0 else np.linspace(0.0, count, 40 * count + 1)
        low, high = np.array([spread_range(count, min(float(share), float(count))) for share in grid]).T
        return grid, low + self.place * (high - low)


@dataclass(frozen=True)
class AnyBalls:
    """Balls on isotropic supports. ``leading`` are directions of all but the two heaviest balls, from the target on."""

    plane: Plane
    leading: tuple[float, ...] | None = None  # None: the states in which a race runs true
    route: str = "eigenvalues"

    def rates(self, speeds: Floats) -> Floats:
        """Growth rates, 1/s; of several states the most stable one."""
        return np.array([self._rate(float(speed)) for speed in speeds])

    def _rate(self, speed: float) -> float:
        found = [self._growth(speed, state) for state in self.states(speed)]
        return min(found, default=math.nan)

    def _growth(self, speed: float, state: Equilibrium) -> float:
        values, _ = eigensystem(*matrices(self.plane, speed, state))
        return float(kept(values, state.freedom).real.max())

    def states(self, speed: float) -> list[Equilibrium]:
        """The balanced states at a speed."""
        p = self.plane
        if p.dynamic_stiffness(speed) == 0.0:
            return []
        if self.leading is None:
            return running_true(p, speed)
        center = complex(p.offset[0])
        wanted = target(p, speed, center)
        order = np.argsort(-p.moment, kind="stable")
        angles = np.empty(p.moment.size)
        angles[order[2:]] = cmath.phase(wanted) + np.array(self.leading)
        rest = wanted - complex((p.moment[order[2:]] * np.exp(1j * angles[order[2:]])).sum())
        for pair in close_polygon(p.moment[order[:2]], rest)[:1]:
            angles[order[:2]] = pair
            return [Equilibrium("balanced", angles, -center, p.moment.size - 2, 0)]
        return []


@dataclass(frozen=True)
class OnOrthotropicSupports:
    """Multipliers over a revolution; of several states the most stable one, of a continuum one member."""

    machine: Machine
    plane: Plane
    route: str = "multipliers"

    def rates(self, speeds: Floats) -> Floats:
        """Growth rates, 1/s; nan also where no periodic state is found."""
        return np.array([self._rate(float(speed)) for speed in speeds])

    def _rate(self, speed: float) -> float:
        p = self.plane
        if p.dynamic_stiffness(speed) == 0.0:
            return math.nan
        states = running_true(p, speed)
        if np.ptp(p.moment) == 0.0:
            states = states[:1]  # the mirror image is an exchange of equal balls
        found = []
        for state in states:
            try:
                values = periodic_state(self.machine, p, speed, state).exponents
            except QuestionError:  # shooting found nothing there
                continue
            found.append(float(kept(values, state.freedom).real.max()))
        return min(found, default=math.nan)


def balanced_states(machine: Machine, p: Plane) -> list[Balanced]:
    """Members of the family of balanced states of a machine: one, or several that stand for a continuum."""
    if p.moment.size == 0:
        raise QuestionError("the machine has no balls; there is no balanced state")
    if not p.isotropic:
        return [OnOrthotropicSupports(machine, p)]
    count, one_center = p.moment.size, bool(np.all(p.offset == p.offset[0]))
    if equal_balls(p):
        return [EqualBalls(p, place) for place in (MEMBERS if count > 2 else (0.0,))]
    if count > 2 and one_center:
        return [AnyBalls(p), *_sampled(p)]
    return [AnyBalls(p)]


def running_true(p: Plane, speed: float) -> list[Equilibrium]:
    """The states in which at least one race runs true."""
    stiffness = p.dynamic_stiffness(speed)
    centers = sorted({complex(c) for c in p.offset}, key=lambda c: (abs(c), cmath.phase(c)))
    return [state for center in centers for state in _running_true(p, speed, stiffness, center)]


def equal_balls(p: Plane) -> bool:
    """Whether the polynomial of degree eight holds: isotropic, two or more equal balls, races with one center."""
    columns = (p.moment, p.inertia, p.drag)
    return (
        p.isotropic
        and p.moment.size >= 2
        and all(bool(np.all(column == column[0])) for column in columns)
        and bool(np.all(p.offset == p.offset[0]))
    )


def planar_balancer_of(p: Plane) -> PlanarBalancer:
    """The numbers of the closed forms."""
    return PlanarBalancer(
        mass=p.mass,
        stiffness=p.stiffness[0],
        damping=p.damping[0],
        count=p.moment.size,
        moment=float(p.moment[0]),
        inertia=float(p.inertia[0]),
        drag=float(p.drag[0]),
    )


def _sampled(p: Plane) -> list[AnyBalls]:
    """Places of all but two balls, drawn evenly, for which the other two can close the sum at high speed."""
    random = np.random.default_rng(0)
    high = 40.0 * math.sqrt(p.stiffness[0] / p.mass)
    found: list[AnyBalls] = []
    for _ in range(40 * SAMPLES):
        member = AnyBalls(p, tuple(random.uniform(-math.pi, math.pi, p.moment.size - 2)))
        if member.states(high):
            found.append(member)
        if len(found) == SAMPLES:
            break
    return found
