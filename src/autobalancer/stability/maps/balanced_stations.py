"""Growth rate of the balanced state over the speed by eigenvalues, or multipliers: any balls at any stations of any rotor.

At a station with more than two balls they have a continuum of ways to balance; members drawn evenly stand for it. For
equal balls at one station only |S2| counts, and two heavier balls with the same N s^2 and |S2| stand for all of them.
"""

from __future__ import annotations

import cmath
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import product

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.patience import still_time
from autobalancer.stability.host.planar import Complexes, Floats
from autobalancer.stability.host.stations import Stations
from autobalancer.stability.states.exchanges import without_exchanges
from autobalancer.stability.states.floquet import exponents_of
from autobalancer.stability.states.linear import kept, modes
from autobalancer.stability.states.planar import close_polygon
from autobalancer.stability.states.settled import settled
from autobalancer.stability.states.spread import spread_of_two, spread_range
from autobalancer.stability.states.state import StationState
from autobalancer.stability.states.stations import balanced_of, required

SAMPLES, FEW = 24, 6  # of a continuum, and where each takes long
PLACES = (0.0, 0.02, 0.1, 0.3, 0.6, 1.0)  # of |S2| from least to greatest


Growth = Callable[[Stations, float, StationState], float]


def growth_of(st: Stations, speed: float, state: StationState) -> float:
    """Greatest real part that counts: without the zeros of a continuum, 1/s."""
    values = modes(st, speed, state)[0] if st.isotropic else exponents_of(st, speed, state)
    return float(kept(values, state.freedom).real.max())


@dataclass(frozen=True)
class MostStable(ABC):
    """Balanced states of which the most stable one counts."""

    stations: Stations
    growth: Growth = growth_of

    def rates(self, speeds: Floats) -> Floats:
        """Growth rates, 1/s; of several states the most stable one; nan where there is none."""
        return np.array([self._rate(float(speed)) for speed in speeds])

    def _rate(self, speed: float) -> float:
        still_time()
        try:
            states = self.states(speed)
        except QuestionError:  # exactly a critical speed of an undamped rotor
            return math.nan
        found = []
        for state in states:
            with suppress(QuestionError):  # on anisotropic supports no periodic state near this one
                found.append(self.growth(self.stations, speed, state))
        return min(found, default=math.nan)

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
            return self._in_plane or without_exchanges(st, balanced_of(st, speed))
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
        still_time()
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
    columns = (st.moment, st.inertia, st.drag)
    equal = all(bool(np.all(column == column[0])) for column in columns)
    return st.plain and st.isotropic and len(st.names) == 1 and st.moment.size >= 2 and equal and not np.any(st.offset)


def members_of(st: Stations, growth: Growth = growth_of) -> list[StationBalls | EqualAtOneStation]:
    """Members of the family of balanced states: one, or several that stand for a continuum.

    ``growth`` is that of the full equations, or of others such as the averaged ones. Multipliers take so long that one member
    has to do.
    """
    if growth is growth_of and not st.isotropic:
        return [StationBalls(st, route="multipliers")]
    if equal_at_one_station(st):
        places = PLACES if st.moment.size > 2 else (0.0,)
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
    found = np.zeros(len(st.names), np.complex128)
    for place in range(len(st.names)):
        here = st.offset[st.station == place]
        if np.any(here != here[:1]):
            return None
        found[place] = here[0] if here.size else 0.0
    return found


def _sampled(st: Stations, counts: list[int], growth: Growth, route: str) -> list[StationBalls]:
    """Places of all but two balls of each station, drawn evenly, for which these two can close the sum at high speed."""
    random = np.random.default_rng(0)
    high = 40.0 * st.scale_speed if math.isinf(st.model.top_speed) else st.model.top_speed
    found: list[StationBalls] = []
    for _ in range(200 * SAMPLES):
        drawn = tuple(tuple(random.uniform(-math.pi, math.pi, max(count - 2, 0)).tolist()) for count in counts)
        member = StationBalls(st, growth, drawn, route)
        if member.states(high):
            found.append(member)
        if len(found) == (SAMPLES if st.plain else FEW):
            break
    return found
