"""All states in which the balls of any number of stations rest in a rotor at constant speed.

With Z the forward whirl of the P stations, H(W) their receptance for loads that turn with the rotor (gyroscopics
included, balls' mass on the rotor), s_p = sum m E + sum m eps e^(i phi) over the balls of a station and U the load of
the unbalances,

    Z = W^2 (H_u U + H s),    and a ball rests where Im[e^(-i phi) (Z_p + E)] = 0.

So at each station either a race runs true, Z_p = -E, and its balls may stand anywhere as long as s_p is what this needs,
or every ball stands along its Z_p + E. *Balanced*: at all stations a race runs true, s = H^-1 (Z/W^2 - H_u U). *Mixed*:
at some. *Coincident*, *in line*: at none, and at every station all balls on one side, or not.

Which states are found: with one race center per station, all of them as long as at most two stations do not run true
(the quadratic of the planar rotor, a polynomial of degree six); else those that Newton's method reaches from many starts.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator
from itertools import combinations, product

import numpy as np

from autobalancer.assembly.rotors.planes import least_moments
from autobalancer.errors import QuestionError
from autobalancer.patience import still_time
from autobalancer.stability.host.planar import Complexes, Floats
from autobalancer.stability.host.stations import Stations
from autobalancer.stability.states.aligned import Aligned, directions_of
from autobalancer.stability.states.planar import PATTERNS, close_polygon
from autobalancer.stability.states.settled import settled
from autobalancer.stability.states.state import StationState


def states_of(st: Stations, speed: float) -> list[StationState]:
    """All that are found, balanced ones first, then by the greatest deflection.

    Raises
    ------
    QuestionError
        At standstill, or at a critical speed of an undamped rotor, where its deflection is not determined.
    """
    _check(speed)
    if not st.plain:
        return settled(st, speed, states_of(st.plain_at(speed), speed))
    if st.moment.size == 0:
        return [StationState("no balls", np.zeros(0), st.rows @ st.coordinates(speed, np.zeros(0)), 0, 0)]
    count = len(st.names)
    found: list[StationState] = []
    for size in range(count, -1, -1):
        for true in combinations(range(count), size):
            still_time()
            found += _states(st, speed, true)
    return sorted(found, key=lambda state: state.rank)


def balanced_of(st: Stations, speed: float) -> list[StationState]:
    """The balanced ones only; of a continuum two members that are mirror images."""
    _check(speed)
    found = _states(st.plain_at(speed), speed, tuple(range(len(st.names))))
    return found if st.plain else [state for state in settled(st, speed, found) if state.name == "balanced"]


def required(st: Stations, speed: float, centers: Complexes | None = None) -> Complexes:
    """What the balls of each station have to add up to so that all stations are at rest, (P,) kg m.

    Or, with a race center (m) for each station, so that these races run true. Of more stations than the rotor has coordinates,
    the distribution that takes the least share of the capabilities.
    """
    compliance, st = st.compliance(speed), st.plain_at(speed)
    host, free = _host(st, compliance), st.rows @ compliance @ st.fixed_load
    wanted = -free if centers is None else -free - centers / speed**2
    return _least(st, host, wanted, range(len(st.names)))


def _check(speed: float) -> None:
    if not (math.isfinite(speed) and speed > 0.0):
        raise QuestionError(f"speed: given {speed!r}; must be greater than zero, in rad/s")


def _host(st: Stations, compliance: Complexes) -> Complexes:
    return np.asarray(st.rows @ compliance @ st.rows.T, np.complex128)


def _least(st: Stations, host: Complexes, wanted: Complexes, true: range | tuple[int, ...]) -> Complexes:
    """Moments of the stations that do what is wanted; the smallest in shares of the capabilities if many do."""
    return least_moments(host, wanted, st.capability[list(true)])


def _states(st: Stations, speed: float, true: tuple[int, ...]) -> list[StationState]:
    """States in which a race runs true at the stations ``true`` and at no other."""
    compliance = st.compliance(speed) * speed**2
    host, free = _host(st, compliance), st.rows @ compliance @ st.fixed_load
    rest = tuple(p for p in range(len(st.names)) if p not in true)
    centers = [_centers(st, p) for p in true]
    rank = _rank(host, true)
    found = []
    for chosen in product(*centers):
        for angles, fixed in _others(st, true, chosen):
            moved = _moments(st, np.flatnonzero(fixed), angles)
            at_rest = np.array([-center for center in chosen], np.complex128)
            free_here = free + host @ moved
            for row in _aligned(st, host, free_here, true, rest, at_rest):
                full = angles.copy()
                for ball, angle in row.items():
                    full[ball] = angle
                placed = _moments(st, np.array(sorted(row), np.int64), full)
                wanted = at_rest - (free_here + host @ placed)[list(true)]
                needed = _least(st, host[np.ix_(true, true)], wanted, true)
                for closed in _closings(st, true, fixed, needed):
                    for ball, angle in closed.items():
                        full[ball] = angle
                    whirl = free + host @ st.moments(full)
                    miss = np.abs(whirl[list(true)] - at_rest).max(initial=0.0)
                    if miss > 1e-8 * max(np.abs(free).max(), np.abs(host).max() * st.moment.max()):
                        continue
                    whirl[list(true)] = at_rest
                    balls = sum(max(int((~fixed & (st.station == p)).sum()) - 2, 0) for p in true)
                    found.append(_named(st, true, fixed, full.copy(), whirl, balls + 2 * (len(true) - rank)))
    return found


def _rank(host: Complexes, true: tuple[int, ...]) -> int:
    """How many of these stations the rotor can hold at rest by itself."""
    least = 1e-11 * np.abs(host).max()
    if len(true) < 2:
        return sum(abs(host[p, p]) > least for p in true)
    return int(np.linalg.matrix_rank(host[np.ix_(true, true)], tol=least))


def _centers(st: Stations, place: int) -> list[complex]:
    found = {complex(c) for c in st.offset[st.station == place]}
    return sorted(found, key=lambda c: (abs(c), cmath.phase(c)))


def _moments(st: Stations, balls: np.ndarray, angles: Floats) -> Complexes:
    total = np.zeros(len(st.names), np.complex128)
    np.add.at(total, st.station[balls], st.moment[balls] * np.exp(1j * angles[balls]))
    return total


def _others(st: Stations, true: tuple[int, ...], chosen: tuple[complex, ...]) -> Iterator[tuple[Floats, np.ndarray]]:
    """Balls in other races of stations that run true stand along their own vector: angles, and which balls these are."""
    fixed = np.zeros(st.moment.size, bool)
    along = np.zeros(st.moment.size)
    for place, center in zip(true, chosen, strict=True):
        apart = (st.station == place) & ~np.isclose(st.offset, center, rtol=0.0, atol=1e-15)
        fixed |= apart
        along[apart] = np.angle(st.offset[apart] - center)
    balls = np.flatnonzero(fixed)
    if 2 ** len(balls) > PATTERNS:
        raise QuestionError(f"steady states: {len(balls)} balls in other races have too many arrangements to try all")
    for turns in product((0.0, math.pi), repeat=len(balls)):
        angles = along.copy()
        angles[balls] += turns
        yield angles, fixed


def _closings(st: Stations, true: tuple[int, ...], fixed: np.ndarray, needed: Complexes) -> Iterator[dict[int, float]]:
    """Ways in which the free balls of each station add up to what is needed there."""
    ways = []
    for place, target in zip(true, needed, strict=True):
        balls = np.flatnonzero((st.station == place) & ~fixed)
        ways.append(
            [dict(zip(balls.tolist(), w.tolist(), strict=True)) for w in close_polygon(st.moment[balls], target)]
        )
    for choice in product(*ways):
        yield {ball: angle for part in choice for ball, angle in part.items()}


def _aligned(
    st: Stations, host: Complexes, free: Complexes, true: tuple[int, ...], rest: tuple[int, ...], at_rest: Complexes
) -> list[dict[int, float]]:
    """Angles of the balls at stations that do not run true; those that do are eliminated by what holds them at rest."""
    if not rest:
        return [{}]
    t, a = list(true), list(rest)
    inner, start = host[np.ix_(a, a)], free[a]
    if t:
        held = host[np.ix_(a, t)] @ np.linalg.pinv(host[np.ix_(t, t)], rcond=1e-11)
        inner = inner - held @ host[np.ix_(t, a)]
        start = start + held @ (at_rest - free[t])
    balls = [np.flatnonzero(st.station == place) for place in rest]
    return directions_of(Aligned(inner, start, balls, st.moment, st.offset))


def _named(
    st: Stations, true: tuple[int, ...], fixed: np.ndarray, angles: Floats, whirl: Complexes, freedom: int
) -> StationState:
    center = whirl[st.station] + st.offset
    standing = fixed | ~np.isin(st.station, true)
    out = standing & ((np.exp(-1j * angles) * center).real > 0.0)
    if true:
        name = "balanced" if len(true) == len(st.names) else "mixed"
    else:
        sides = [out[st.station == place] for place in range(len(st.names))]
        name = "coincident" if all(side.all() or not side.any() for side in sides) else "in line"
    return StationState(name, angles, whirl, freedom, int(out.sum()))
