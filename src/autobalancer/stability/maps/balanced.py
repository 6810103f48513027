"""Growth rate of the balanced state over the speed, for any machine without gravity in its plane.

The fastest route that is exact is taken: equal balls of a planar rotor in races with one center by the polynomial of degree
eight; other machines on isotropic supports by the eigenvalues of their linearized equations
(:mod:`autobalancer.stability.maps.balanced_stations`); anisotropic supports by multipliers, where a planar rotor rests over half
a turn at many speeds at once (:mod:`autobalancer.stability.states.half_turns`), else over a turn. With
forces on the balls (:mod:`autobalancer.stability.maps.balanced_forces`) states are sought by Newton's method. More than two
balls in races that run true have a continuum of balanced states; some members stand for it, from the least to the greatest
|S2| where that decides.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.stability.host.planar import Floats, Plane
from autobalancer.stability.host.stations import Stations, of_plane
from autobalancer.stability.maps.balanced_forces import ForcedBalls
from autobalancer.stability.maps.balanced_stations import members_of
from autobalancer.stability.maps.characteristic import PlanarBalancer, growth_rates
from autobalancer.stability.states.described import Described
from autobalancer.stability.states.half_turns import growth_rates as half_turn_rates
from autobalancer.stability.states.planar import close_polygon
from autobalancer.stability.states.right_angles import growth_rates as right_angle_rates
from autobalancer.stability.states.spread import spread_of_two, spread_range

MEMBERS = (0.0, 0.02, 0.1, 0.3, 0.6, 1.0)  # of the continuum, by |S2| from least to greatest
POINTS = {
    "polynomial": 1500,
    "eigenvalues": 420,
    "linearized field": 150,
    "multipliers": 60,
    "multipliers of a rotor at rest": 100,
    "search": 150,
}  # speeds at which a border is looked for
IN_LINE = 1e-12  # balls stand in line if 1 - |S2|/N is below: one root is zero by symmetry


class Balanced(Protocol):
    """One balanced state, followed over the speed."""

    @property
    def route(self) -> str:
        """A key of ``POINTS``."""

    def rates(self, speeds: Floats) -> Floats:
        """Growth rates, 1/s; nan where there is no such state."""


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
        held = np.array([p.dynamic_stiffness(float(w)) for w in speeds]) / speeds**2
        sizes = np.abs(center * held + p.fixed_load)
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
class EqualBallsAtRest(EqualBalls):
    """The same on orthotropic supports, races on the axis: only |S2| counts, its direction is an instant of the turn."""

    route: str = "multipliers of a rotor at rest"
    spread: float | None = None  # |S2| if it is given, else what balances

    def spreads(self, speeds: Floats) -> Floats:
        """|S2| at each speed; nan where the balls are too weak."""
        return super().spreads(speeds) if self.spread is None else np.full(speeds.size, self.spread)

    def rates(self, speeds: Floats) -> Floats:
        """Growth rates, 1/s."""
        p, count, spreads = self.plane, self.balancer.count, self.spreads(speeds)
        if not spreads.any():
            return right_angle_rates(p, speeds)
        share = np.minimum(spreads / count, 1.0)
        angle = 0.5 * np.arccos(share)
        two = {name: getattr(p, name)[:2] for name in ("ball_mass", "inertia", "drag", "race", "offset")}
        pair = replace(p, moment=p.moment[:2] * math.sqrt(0.5 * count), **two)
        return _at_rest(pair, speeds, np.stack([angle, -angle], axis=1), (share > 1.0 - IN_LINE).astype(int))


@dataclass(frozen=True)
class BallsAtRest:
    """Any balls on orthotropic supports, races on the axis; of a continuum one member."""

    plane: Plane
    route: str = "multipliers of a rotor at rest"

    def rates(self, speeds: Floats) -> Floats:
        """Growth rates, 1/s."""
        p = self.plane
        found = close_polygon(p.moment, -p.fixed_load)
        if not found:
            return np.full(speeds.size, np.nan)
        neutral = np.full(speeds.size, max(p.moment.size - 2, 0))
        return _at_rest(p, speeds, np.tile(found[0], (speeds.size, 1)), neutral)


def _at_rest(p: Plane, speeds: Floats, angles: Floats, neutral: NDArray[np.int64]) -> Floats:
    there = np.isfinite(angles).all(axis=1)
    rates = np.full(speeds.size, np.nan)
    rates[there] = half_turn_rates(p, speeds[there], angles[there], neutral[there])
    return rates


def balanced_states(p: Described) -> list[Balanced]:
    """Members of the family of balanced states of a machine: one, or several that stand for a continuum."""
    if p.moment.size == 0:
        raise QuestionError("the machine has no balls; there is no balanced state")
    if isinstance(p, Stations):
        if p.forces is not None:
            return [ForcedBalls(p)]
        return list(members_of(p))
    if equal_balls(p):
        return [EqualBalls(p, place) for place in (MEMBERS if p.moment.size > 2 else (0.0,))]
    if np.any(p.offset) or p.isotropic:
        return balanced_states(of_plane(p))
    if alike(p):
        return [EqualBallsAtRest(p, place) for place in (MEMBERS if p.moment.size > 2 else (0.0,))]
    return [BallsAtRest(p)]


def equal_balls(p: Plane) -> bool:
    """Whether the polynomial of degree eight holds: isotropic, two or more equal balls, races with one center."""
    return p.isotropic and alike(p)


def alike(p: Plane) -> bool:
    """Whether there are two or more equal balls, in races with one center."""
    columns = (p.moment, p.inertia, p.drag)
    return (
        p.moment.size >= 2
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
