"""Growth rate of the balanced state over the speed, for any machine without gravity in its plane.

The fastest route that is exact is taken: equal balls of a planar rotor in races with one center by the polynomial of degree
eight; other machines on isotropic supports by the eigenvalues of their linearized equations
(:mod:`autobalancer.stability.maps.balanced`); anisotropic supports by multipliers, where a planar rotor rests over half
a turn at many speeds at once (:mod:`autobalancer.stability.states.linearized`), else over a turn. With
forces on the balls (:mod:`autobalancer.stability.maps.balanced`) states are sought by Newton's method. More than two
balls in races that run true have a continuum of balanced states; some members stand for it, from the least to the greatest
|S2| where that decides.
"""

from __future__ import annotations

import cmath
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from itertools import product
from typing import Protocol

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from autobalancer.arrays import Complexes, Floats, Matrix
from autobalancer.errors import QuestionError
from autobalancer.progress import check_deadline
from autobalancer.results.display_units import length_text
from autobalancer.roots import root
from autobalancer.stability.host.stations import Plane, Stations
from autobalancer.stability.states.ball_positions import close_polygon, spread_of_two, spread_range
from autobalancer.stability.states.ball_positions import growth_rates as right_angle_rates
from autobalancer.stability.states.linearized import deciding_eigenvalues, exponents_of, modes
from autobalancer.stability.states.linearized import growth_rates as half_turn_rates
from autobalancer.stability.states.rest_states import (
    Described,
    StationState,
    balanced_of,
    required,
    searched,
    settled,
    without_exchanges,
)

# Exact stability of the balanced state of an isotropic planar rotor with equal balls, in closed form.
#
# The full equations are linearized in the frame that turns with the rotor. With P(s) = I s^2 + beta s, Z(s) = M s^2 +
# b s + k, c = (m eps)^2 and S2 = sum over balls of e^(2 i phi) the eigenvalues are the roots of
#
#     P^2 Z+ Z- - (c N / 2) P [(s + i W)^4 Z- + (s - i W)^4 Z+] + (c^2 / 4) (N^2 - |S2|^2) (s^2 + W^2)^4 = 0,
#
# Z+ = Z(s + i W), Z- = Z(s - i W), and, for N > 2 balls, of s^(N-2) (I s + beta)^(N-2).


@dataclass(frozen=True)
class PlanarBalancer:
    """An isotropic planar rotor with N equal balls in one centric race; SI, mass includes the balls."""

    mass: float
    stiffness: float
    damping: float
    count: int
    moment: float  # m eps of one ball
    inertia: float  # of one ball angle
    drag: float  # beta of one ball

    @property
    def critical_speed(self) -> float:
        """sqrt(k/M), rad/s."""
        return float(np.sqrt(self.stiffness / self.mass))


def planar_eigenvalues(balancer: PlanarBalancer, speed: float, spread: float) -> NDArray[np.complex128]:
    """The eight eigenvalues that decide, 1/s, at a rotor speed (rad/s).

    ``spread`` is |S2|, between 0 (balls evenly spread over directions, such as two at 135 deg) and N (in line).
    """
    b = balancer
    w = b.critical_speed  # scaled by the critical speed, or the coefficients span forty decades
    ball = Polynomial([0.0, b.drag * w, b.inertia * w * w])
    up, down = Polynomial([1j * speed / w, 1.0]), Polynomial([-1j * speed / w, 1.0])
    rotor = [b.mass * w * w * x * x + b.damping * w * x + b.stiffness for x in (up, down)]
    c = b.moment**2 * w**4
    sides = up**4 * rotor[1] + down**4 * rotor[0]
    polynomial = ball**2 * rotor[0] * rotor[1] - 0.5 * c * b.count * ball * sides
    polynomial += 0.25 * c * c * (b.count**2 - spread**2) * (up * down) ** 4
    return np.asarray(w * np.roots(polynomial.coef.real[::-1]), np.complex128)


def growth_rates(balancer: PlanarBalancer, speeds: Floats, spreads: Floats | float) -> tuple[Floats, Floats]:
    """Growth rates (1/s) at many speeds, and the frequencies (rad/s, seen in the rotor) of what grows: compiled.

    The same as :func:`growth_rate`, which also steps in where two eigenvalues nearly coincide and the iteration fails.
    """
    return scaled_growth_rates(scaled_points(balancer, speeds, spreads), balancer.critical_speed)


def scaled_points(balancer: PlanarBalancer, speeds: Floats, spreads: Floats | float) -> Matrix:
    """Rows (speed, damping, drag, coupling, spread), all scaled as in :mod:`autobalancer.kernels.characteristic`."""
    b, critical = balancer, balancer.critical_speed
    points = np.empty((speeds.size, 5))
    points[:, 0] = speeds / critical
    points[:, 1] = b.damping / (b.mass * critical)
    points[:, 2] = b.drag / (b.inertia * critical)
    points[:, 3] = 0.5 * b.count * b.moment**2 / (b.inertia * b.mass)
    points[:, 4] = np.minimum(np.asarray(spreads) / b.count, 1.0)
    return points


def scaled_growth_rates(points: Matrix, critical: Floats | float) -> tuple[Floats, Floats]:
    """Growth rates and frequencies of scaled points, times the critical speed."""
    from autobalancer.kernels import characteristic as kernel  # loads compiled code: only when needed

    rates, frequencies = np.empty(len(points)), np.empty(len(points))
    kernel.growth_rates(points, rates, frequencies, np.zeros((8, 2)))
    for row in np.flatnonzero(np.isnan(rates)):
        speed, damping, drag, coupling, spread = (float(x) for x in points[row])
        unit = PlanarBalancer(1.0, 1.0, damping, 2, float(np.sqrt(coupling)), 1.0, drag)
        rates[row], frequencies[row] = _leading(unit, speed, 2.0 * spread)
    return rates * critical, frequencies * critical


def growth_rate(balancer: PlanarBalancer, speed: float, spread: float) -> float:
    """Greatest real part of the eigenvalues, 1/s; the balanced state is stable where it is negative.

    For balls in line (|S2| = N) one eigenvalue is zero by symmetry and does not count.
    """
    return _leading(balancer, speed, spread)[0]


def _leading(balancer: PlanarBalancer, speed: float, spread: float) -> tuple[float, float]:
    values = planar_eigenvalues(balancer, speed, spread)
    if balancer.count - spread < 1e-9 * balancer.count:
        values = np.delete(values, np.argmin(np.abs(values)))
    best = values[np.argmax(values.real)]
    return float(best.real), float(abs(best.imag))


def worst_case_border(balancer: PlanarBalancer) -> float:
    """Exact border speed for |S2| = 0, rad/s, from the explicit curve with the whirl frequency as parameter.

    It is the worst case over the unbalance for a well damped rotor; where the rotor is damped lightly, balls in line
    (|S2| = N) may have a higher border.

    With D = M (w^2 - w_c^2): beta(w)^2 = (c N I w^4 / 2) / (D (1 + D^2/(b w)^2)), W = w + beta D / (I b w). beta falls
    with w; below its limit for w to infinity the balanced state is never stable and the border is infinite.
    """
    b = balancer
    critical = b.critical_speed
    if b.damping == 0.0 or b.drag == 0.0:
        return float("inf")
    c = b.moment**2

    def beta(w: float) -> float:
        d = b.mass * (w * w - critical * critical)
        return float(np.sqrt(0.5 * c * b.count * b.inertia * w**4 / (d * (1.0 + (d / (b.damping * w)) ** 2))))

    def miss(x: float) -> float:  # x = ln(w/w_c - 1)
        return float(np.log(beta(critical * (1.0 + np.exp(x))) / b.drag))

    low, high = -34.0, 30.0
    if miss(high) > 0.0:
        return float("inf")
    if miss(low) < 0.0:
        return critical
    w = critical * (1.0 + np.exp(root(miss, low, high, xtol=1e-13)))
    return float(w + b.drag * b.mass * (w * w - critical * critical) / (b.inertia * b.damping * w))


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
    spread: float | None = None  # |S2| if it is given, else what balances

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
        if self.spread is not None:
            return np.full(speeds.size, self.spread)
        shares = self.shares(speeds)
        count = self.balancer.count
        held = np.minimum(shares, count)
        spreads = spread_of_two(held) if count == 2 else np.interp(held, *self._table)
        return np.where(shares <= count * (1.0 + 1e-12), spreads, np.nan)

    def rates(self, speeds: Floats) -> Floats:
        """Growth rates, 1/s."""
        spreads = self.spreads(speeds)
        rates = growth_rates(self.balancer, speeds, np.nan_to_num(spreads))[0]
        return np.where(np.isnan(spreads), np.nan, rates)

    @cached_property
    def _table(self) -> tuple[Floats, Floats]:
        """|S2| over the resultant: one value if the race is centric, else a table."""
        count, grid = self.balancer.count, self.shares(np.ones(1))
        if self.plane.offset[0] == 0.0:
            low, high = np.array([spread_range(count, min(float(share), float(count))) for share in grid]).T
        else:
            grid, low, high = _spread_table(count)
        return grid, low + self.place * (high - low)


@dataclass(frozen=True)
class EqualBallsAtRest(EqualBalls):
    """The same on orthotropic supports, races on the axis: only |S2| counts, its direction is an instant of the turn."""

    route: str = "multipliers of a rotor at rest"

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
        polygon = close_polygon(p.moment, -p.fixed_load)
        if not polygon:
            return np.full(speeds.size, np.nan)
        neutral = np.full(speeds.size, max(p.moment.size - 2, 0))
        return _at_rest(p, speeds, np.tile(polygon[0], (speeds.size, 1)), neutral)


def _at_rest(p: Plane, speeds: Floats, angles: Floats, neutral: NDArray[np.int64]) -> Floats:
    there = np.isfinite(angles).all(axis=1)
    rates = np.full(speeds.size, np.nan)
    rates[there] = half_turn_rates(p, speeds[there], angles[there], neutral[there])
    return rates


def balanced_states(p: Described) -> list[Balanced]:
    """Members of the family of balanced states of a machine: one, or several that stand for a continuum."""
    if p.moment.size == 0:
        raise QuestionError("the machine has no balls; there is no balanced state")
    st = p.as_station
    return _in_closed_form(p) or ([ForcedBalls(st)] if st.forces is not None else list(members_of(st)))


def _in_closed_form(p: Described) -> list[Balanced]:
    """The same where their growth rates are known in closed form; empty where none is."""
    if not isinstance(p, Plane):
        return []
    places = MEMBERS if p.moment.size > 2 else (0.0,)
    if p.isotropic and alike(p):  # the polynomial of degree eight
        return [EqualBalls(p, place) for place in places]
    if p.isotropic or not p.one_centric:
        return []
    return [EqualBallsAtRest(p, place) for place in places] if alike(p) else [BallsAtRest(p)]


def alike(p: Described) -> bool:
    """Whether there are two or more equal balls, in races with one center."""
    columns = (p.moment, p.inertia, p.drag, p.offset)
    return p.moment.size >= 2 and all(bool(np.all(column == column[0])) for column in columns)


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


# Growth rate of the balanced state over the speed by eigenvalues, or multipliers: any balls at any stations of any
# rotor.
#
# At a station with more than two balls they have a continuum of ways to balance; members drawn evenly stand for it.
# For equal balls at one station only |S2| counts, and two heavier balls with the same N s^2 and |S2| stand for all of
# them.


SAMPLES, FEW = 24, 6  # of a continuum, and where each takes long


Growth = Callable[[Stations, float, StationState], float]


def growth_of(st: Stations, speed: float, state: StationState) -> float:
    """Greatest real part that counts: without the zeros of a continuum, 1/s."""
    values = modes(st, speed, state)[0] if st.isotropic else exponents_of(st, speed, state)
    return float(deciding_eigenvalues(values, state.freedom).real.max())


@dataclass(frozen=True)
class MostStable(ABC):
    """Balanced states of which the most stable one counts."""

    stations: Stations
    growth: Growth = growth_of

    def rates(self, speeds: Floats) -> Floats:
        """Growth rates, 1/s; of several states the most stable one; nan where there is none."""
        return np.array([self._rate(float(speed)) for speed in speeds])

    def _rate(self, speed: float) -> float:
        check_deadline()
        try:
            states = self.states(speed)
        except QuestionError:  # exactly a critical speed of an undamped rotor
            return math.nan
        rate = []
        for state in states:
            with suppress(QuestionError):  # on anisotropic supports no periodic state near this one
                rate.append(self.growth(self.stations, speed, state))
        return min(rate, default=math.nan)

    def exists(self, speed: float) -> bool:
        """Whether there is a balanced state, stable or not."""
        try:
            return bool(self.states(speed))
        except QuestionError:
            return False

    @abstractmethod
    def states(self, speed: float) -> list[StationState]:
        """The balanced states at a speed."""


@dataclass(frozen=True)
class StationBalls(MostStable):
    """Balanced states; ``leading`` are directions of all but the two heaviest balls of each station, from its target on."""

    leading: tuple[tuple[float, ...], ...] | None = None  # None: the states in which races run true
    route: str = "eigenvalues"

    def states(self, speed: float) -> list[StationState]:
        """The balanced states at a speed; mirror images of equal balls count once."""
        st = self.stations
        if self.leading is None:
            known: dict[float, list[StationState]] = st.balanced
            if speed not in known:
                known[speed] = self._in_plane or without_exchanges(st, balanced_of(st, speed, exchanges=False))
            return known[speed]
        centers = _centers(st)
        assert centers is not None
        closed = list(self._closed(required(st, speed, centers)))
        freedom = sum(len(part) for part in self.leading)
        states = [StationState("balanced", angles, -centers, freedom, 0) for angles in closed]
        return states if st.plain else settled(st, speed, states)

    @cached_property
    def _in_plane(self) -> list[StationState]:
        """Of one station whose races are on the axis of a planar rotor they are the same at all speeds; else empty."""
        st = self.stations
        if st.model.pairs > 1 or len(st.names) > 1 or np.any(st.offset):
            return []
        return without_exchanges(st, balanced_of(st, math.pi * st.scale_speed))

    def _closed(self, needed: Complexes) -> Iterator[Floats]:
        st = self.stations
        angles = np.empty(st.moment.size)
        assert self.leading is not None
        ways = []
        for place, (target, leading) in enumerate(zip(needed, self.leading, strict=True)):
            balls = np.flatnonzero(st.station == place)
            order = balls[np.argsort(-st.moment[balls], kind="stable")]
            angles[order[2:]] = cmath.phase(target) + np.array(leading)
            rest = target - complex((st.moment[order[2:]] * np.exp(1j * angles[order[2:]])).sum())
            closings = close_polygon(st.moment[order[:2]], rest)
            equal = len(order) > 1 and st.moment[order[0]] == st.moment[order[1]]
            ways.append([(order[:2], way) for way in (closings[:1] if equal else closings)])
        for choice in product(*ways):
            full = angles.copy()
            for balls, way in choice:
                full[balls] = way
            yield full


@dataclass(frozen=True)
class EqualAtOneStation:
    """Equal balls in races on the axis at one station, by their |S2|: fixed, or at ``place`` of what balances."""

    stations: Stations
    place: float = 0.0  # 0 the least, 1 the greatest |S2|
    spread: float | None = None
    growth: Growth = growth_of
    route: str = "eigenvalues"

    @property
    def count(self) -> int:
        """Number of balls N."""
        return self.stations.moment.size

    def spread_at(self, speed: float) -> float:
        """|S2|; nan where the balls are too weak."""
        if self.spread is not None:
            return self.spread
        share = float(abs(required(self.stations, speed)[0])) / float(self.stations.moment[0])
        if share > self.count * (1.0 + 1e-12):
            return math.nan
        if self.count == 2:
            return float(spread_of_two(np.array(min(share, 2.0))))
        grid, low, high = _spread_table(self.count)
        return float(np.interp(share, grid, low + self.place * (high - low)))

    def rates(self, speeds: Floats) -> Floats:
        """Growth rates, 1/s; nan where there is no such state."""
        return np.array([self._rate(float(speed)) for speed in speeds])

    def _rate(self, speed: float) -> float:
        check_deadline()
        try:
            spread = self.spread_at(speed)
        except QuestionError:  # exactly a critical speed of an undamped rotor
            return math.nan
        if math.isnan(spread):
            return math.nan
        pair, state = _pair(self.stations, spread)
        return self.growth(pair, speed, state)


@lru_cache(maxsize=16)
def _spread_table(count: int) -> tuple[Floats, Floats, Floats]:
    """Least and greatest |S2| over the resultant in units of one ball."""
    grid = np.linspace(0.0, count, 40 * count + 1)
    low, high = np.array([spread_range(count, float(share)) for share in grid]).T
    return grid, low, high


def _pair(st: Stations, spread: float) -> tuple[Stations, StationState]:
    """Two balls s' = s sqrt(N/2) at +-a, cos 2a = |S2|/N: the same sums of s^2 and s^2 e^(2 i phi), mass on the rotor alike."""
    count = st.moment.size
    angle = 0.5 * math.acos(min(max(spread / count, -1.0), 1.0))
    both = {name: getattr(st, name)[:2] for name in ("ball_mass", "inertia", "drag", "station", "race", "offset")}
    pair = replace(st, moment=st.moment[:2] * math.sqrt(0.5 * count), **both)
    in_line = int(spread > count * (1.0 - 1e-12))  # then a first-order motion that unbalances nothing
    return pair, StationState("balanced", np.array([angle, -angle]), np.zeros(1, np.complex128), in_line, 0)


def equal_at_one_station(st: Stations) -> bool:
    """Whether only |S2| counts: isotropic, two or more equal balls, races on the axis at one station that do not tilt."""
    return st.plain and st.isotropic and st.one_centric and alike(st)


def members_of(st: Stations, growth: Growth = growth_of) -> list[StationBalls | EqualAtOneStation]:
    """Members of the family of balanced states: one, or several that stand for a continuum.

    ``growth`` is that of the full equations, or of others such as the averaged ones. Multipliers take so long that one member
    has to do.
    """
    if growth is growth_of and not st.isotropic:
        return [StationBalls(st, route="multipliers")]
    if equal_at_one_station(st):
        places = MEMBERS if st.moment.size > 2 else (0.0,)
        return [EqualAtOneStation(st, place, growth=growth) for place in places]
    counts, route = np.bincount(st.station, minlength=len(st.names)), "eigenvalues" if st.plain else "linearized field"
    if counts.max() <= 2 or _centers(st) is None:
        return [StationBalls(st, growth=growth, route=route)]
    return [
        StationBalls(st, growth=growth, route=route),
        *_sampled(st, [int(count) for count in counts], growth, route),
    ]


def _centers(st: Stations) -> Complexes | None:
    """The race center of each station, (P,) m; ``None`` where a station has several."""
    centers = np.zeros(len(st.names), np.complex128)
    for place in range(len(st.names)):
        here = st.offset[st.station == place]
        if np.any(here != here[:1]):
            return None
        centers[place] = here[0] if here.size else 0.0
    return centers


def _sampled(st: Stations, counts: list[int], growth: Growth, route: str) -> list[StationBalls]:
    """Places of all but two balls of each station, drawn evenly, for which these two can close the sum at high speed."""
    random = np.random.default_rng(0)
    high = 40.0 * st.scale_speed if math.isinf(st.model.top_speed) else st.model.top_speed
    station_balls: list[StationBalls] = []
    for _ in range(200 * SAMPLES):
        drawn = tuple(tuple(random.uniform(-math.pi, math.pi, max(count - 2, 0)).tolist()) for count in counts)
        member = StationBalls(st, growth, drawn, route)
        if member.states(high):
            station_balls.append(member)
        if len(station_balls) == (SAMPLES if st.plain else FEW):
            break
    return station_balls


# Growth rate over the speed of the states in which balls with forces on them make the deflection smaller.


NONE = 1e-9  # share of a deflection that is not worth a word
ABOVE = 1.0 + 1e-6  # a border
NEAR = 1.15  # ratio of two speeds between which states are followed


@dataclass(frozen=True)
class ForcedBalls(MostStable):
    """Balanced states, each sought from those at a speed nearby, else anew."""

    route: str = "search"
    known: dict[float, list[StationState]] = field(default_factory=dict, repr=False)

    def left_at(self, speed: float) -> str:
        """What the most stable state leaves of the deflection there, in words; empty at no finite speed, or for nothing."""
        states = self.states(speed * ABOVE) if math.isfinite(speed) else []
        if not states:
            return ""
        st, bare = self.stations, self.stations.plain_at(speed)
        state = min(states, key=lambda one: self.growth(st, speed * ABOVE, one))
        left = float(np.abs(state.whirl).max())
        alone = float((speed**2 * np.abs(bare.rows @ st.compliance(speed) @ bare.fixed_load)).max())
        return (
            f"at this speed the balls reduce the deflection of {length_text(alone)} to {100.0 * left / alone:.3g} %"
            if alone > 0.0 and left > NONE * alone
            else ""
        )

    def states(self, speed: float) -> list[StationState]:
        """The balanced states at a speed."""
        if speed not in self.known:
            near = min(self.known, key=lambda other: abs(math.log(other / speed)), default=math.inf)
            before = self.known[near] if max(near / speed, speed / near) < NEAR else []
            result = searched(self.stations, speed, [state.angles for state in before])
            result = [state for state in result if state.name == "balanced"]
            self.known[speed] = result if result and len(result) >= len(before) else balanced_of(self.stations, speed)
        return self.known[speed]
