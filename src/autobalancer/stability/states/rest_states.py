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
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import combinations, product
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from autobalancer.arrays import Complexes, Floats, Matrix
from autobalancer.assembly.drive_train import largest_unbalance
from autobalancer.assembly.guided_balls import has_forces
from autobalancer.assembly.rotors import least_moments
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.progress import check_deadline
from autobalancer.random_numbers import generator
from autobalancer.results.display_units import moment_text
from autobalancer.stability.host.reduction import reduced
from autobalancer.stability.host.stations import Plane, Stations, in_plane, is_planar, plane, stations, vector_of
from autobalancer.stability.host.vector_field import Field
from autobalancer.stability.states.ball_positions import PATTERNS, close_polygon


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
    station_states: list[StationState] = []
    for size in range(count, -1, -1):
        for true in combinations(range(count), size):
            check_deadline()
            station_states += _states(st, speed, true)
    return sorted(station_states, key=lambda state: state.rank)


def balanced_of(st: Stations, speed: float, *, exchanges: bool = True) -> list[StationState]:
    """The balanced ones only; of a continuum two members that are mirror images, of two equal balls one if exchanges are."""
    _check(speed)
    states = _states(st.plain_at(speed), speed, tuple(range(len(st.names))), exchanges)
    return states if st.plain else [state for state in settled(st, speed, states) if state.name == "balanced"]


def required(st: Stations, speed: float, centers: Complexes | None = None) -> Complexes:
    """What the balls of each station have to add up to so that all stations are at rest, (P,) kg m.

    Or, with a race center (m) for each station, so that these races run true. Of more stations than the rotor has coordinates,
    the distribution that takes the least share of the capabilities.
    """
    compliance, st = st.compliance(speed), st.plain_at(speed)
    host, free = _host(st, compliance), st.rows @ compliance @ st.fixed_load
    wanted = -free if centers is None else -free - centers / speed**2
    return _least_moments(st, host, wanted, range(len(st.names)))


def _check(speed: float) -> None:
    if not (math.isfinite(speed) and speed > 0.0):
        raise QuestionError(f"speed: given {speed!r}; must be greater than zero, in rad/s")


def _host(st: Stations, compliance: Complexes) -> Complexes:
    return np.asarray(st.rows @ compliance @ st.rows.T, np.complex128)


def _least_moments(st: Stations, host: Complexes, wanted: Complexes, true: range | tuple[int, ...]) -> Complexes:
    """Moments of the stations that do what is wanted; the smallest in shares of the capabilities if many do."""
    return least_moments(host, wanted, st.capability[list(true)])


def _states(st: Stations, speed: float, true: tuple[int, ...], exchanges: bool = True) -> list[StationState]:
    """States in which a race runs true at the stations ``true`` and at no other; with ``exchanges`` of two equal balls."""
    compliance = st.compliance(speed) * speed**2
    host, free = _host(st, compliance), st.rows @ compliance @ st.fixed_load
    rest, numbers = tuple(p for p in range(len(st.names)) if p not in true), (st.moment, st.inertia, st.drag)
    centers = [_centers(st, p) for p in true]
    rank = _rank(host, true)
    most = 1e-8 * max(np.abs(free).max(), np.abs(host).max() * st.moment.max())  # a deflection that is none
    states = []
    # each of these races has one of its race centers on the axis
    for chosen in product(*centers):
        for angles, fixed in _others(st, true, chosen):
            moved = _moments(st, np.flatnonzero(fixed), angles)
            at_rest = np.array([-center for center in chosen], np.complex128)
            free_here = free + host @ moved
            # balls of other stations stand in line with their center, on either side of it
            for row in _aligned(st, host, free_here, true, rest, at_rest):
                full = angles.copy()
                for ball, angle in row.items():
                    full[ball] = angle
                placed = _moments(st, np.array(sorted(row), np.int64), full)
                # what the balls of the true races must make up, and how they can
                wanted = at_rest - (free_here + host @ placed)[list(true)]
                needed = _least_moments(st, host[np.ix_(true, true)], wanted, true)
                ways = []  # in which the free balls of each station add up to that
                for place, target in zip(true, needed, strict=True):
                    balls = np.flatnonzero((st.station == place) & ~fixed)
                    closings = close_polygon(st.moment[balls], target)
                    if not exchanges and balls.size == 2 and all(np.ptp(one[balls]) == 0.0 for one in numbers):
                        closings = closings[:1]
                    ways.append([(balls, way) for way in closings])
                for closed in product(*ways):
                    for balls, way in closed:
                        full[balls] = way
                    whirl = free + host @ st.moments(full)
                    # only what really runs true counts
                    miss = np.abs(whirl[list(true)] - at_rest).max(initial=0.0)
                    if miss > most:
                        continue
                    whirl[list(true)] = at_rest
                    spare = sum(max(int((~fixed & (st.station == p)).sum()) - 2, 0) for p in true)
                    states.append(_named_state(st, true, fixed, full.copy(), whirl, spare + 2 * (len(true) - rank)))
    return states


def _rank(host: Complexes, true: tuple[int, ...]) -> int:
    """How many of these stations the rotor can hold at rest by itself."""
    least = 1e-11 * np.abs(host).max()
    if len(true) < 2:
        return sum(abs(host[p, p]) > least for p in true)
    return int(np.linalg.matrix_rank(host[np.ix_(true, true)], tol=least))


def _centers(st: Stations, place: int) -> list[complex]:
    centers = {complex(c) for c in st.offset[st.station == place]}
    return sorted(centers, key=lambda c: (abs(c), cmath.phase(c)))


def _moments(st: Stations, balls: np.ndarray, angles: Floats) -> Complexes:
    total = np.zeros(len(st.names), np.complex128)
    np.add.at(total, st.station[balls], st.moment[balls] * np.exp(1j * angles[balls]))
    return total


def _others(st: Stations, true: tuple[int, ...], chosen: tuple[complex, ...]) -> Iterator[tuple[Floats, np.ndarray]]:
    """Balls in other races of stations that run true stand along their own vector: angles, and which balls these are."""
    fixed = np.zeros(st.moment.size, bool)
    along = np.zeros(st.moment.size)
    for place, center in zip(true, chosen, strict=True):
        apart = (st.station == place) & (np.abs(st.offset - center) > 1e-15)
        fixed |= apart
        along[apart] = np.angle(st.offset[apart] - center)
    balls = np.flatnonzero(fixed)
    if 2 ** len(balls) > PATTERNS:
        raise QuestionError(f"steady states: {len(balls)} balls in other races have too many arrangements to try all")
    for turns in product((0.0, math.pi), repeat=len(balls)):
        angles = along.copy()
        angles[balls] += turns
        yield angles, fixed


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


def _named_state(
    st: Stations, true: tuple[int, ...], fixed: np.ndarray, angles: Floats, whirl: Complexes, freedom: int
) -> StationState:
    center = whirl[st.station] + st.offset
    at_rest = np.zeros(len(st.names), bool)
    at_rest[list(true)] = True
    standing = fixed | ~at_rest[st.station]
    out = standing & ((np.exp(-1j * angles) * center).real > 0.0)
    if true:
        name = "balanced" if len(true) == len(st.names) else "mixed"
    else:
        sides = [out[st.station == place] for place in range(len(st.names))]
        name = "coincident" if all(side.all() or not side.any() for side in sides) else "in line"
    return StationState(name, angles, whirl, freedom, int(out.sum()))


# Stations that do not run true: every ball stands along the vector c from the axis of rotation to its race center.
#
# With one center per station and its net moment n_p (balls outward counted +) in the direction psi_p of c_p,
#
#     c_p = b_p + sum over q of h_pq n_q e^(i psi_q),    Im[e^(-i psi_p) c_p] = 0,    Re[e^(-i psi_p) c_p] > 0.
#
# One station: a quadratic. Two stations: with x, y = e^(i psi) both conditions are quadratic in x, and their
# resultant is a polynomial of degree six in y, so that no state is missed. More stations, or several centers at a
# station: Newton's method from many starts.


STARTS = 40  # a pattern of balls; times the number of stations
OFF_CIRCLE = 0.02  # roots of the resultant that are farther from the unit circle are none


@dataclass(frozen=True)
class Aligned:
    """Whirl of A stations, Z = ``free`` + ``host`` . moments; SI."""

    host: Complexes  # (A, A) W^2 H
    free: Complexes  # (A,)
    balls: list[NDArray[np.int64]]  # numbers of the balls of each station
    moment: Floats  # (n,) of all balls of the machine
    offset: Complexes  # (n,)


def directions_of(a: Aligned) -> list[dict[int, float]]:
    """Ball angles of all solutions that are found, rad."""
    if any(np.ptp(a.offset[balls].real) or np.ptp(a.offset[balls].imag) for balls in a.balls) or len(a.balls) > 2:
        return _searched(a)
    centers = np.array([a.offset[balls[0]] for balls in a.balls])
    directions = []
    for signs in product(*(_net(a.moment[balls]) for balls in a.balls)):
        nets = np.array([float(sign @ a.moment[balls]) for sign, balls in zip(signs, a.balls, strict=True)])
        solve = _rho_roots if len(a.balls) == 1 else _two
        for psi in solve(a.host * nets, a.free + centers):
            directions.append(
                {
                    int(ball): float(angle if sign > 0.0 else angle + math.pi)
                    for balls, side, angle in zip(a.balls, signs, psi, strict=True)
                    for ball, sign in zip(balls, side, strict=True)
                }
            )
    return directions


def _net(moment: Floats) -> list[Floats]:
    """Patterns of signs, one for each net moment."""
    kinds, place = np.unique(moment, return_inverse=True)
    counts = np.bincount(place)
    if int(np.prod(counts + 1)) > PATTERNS:
        raise QuestionError("steady states: too many different balls to try all arrangements")
    net: dict[float, Floats] = {}
    for outward in product(*(range(int(count) + 1) for count in counts)):
        signs = np.empty(moment.size)
        for kind in range(kinds.size):
            members = np.flatnonzero(place == kind)
            signs[members] = -1.0
            signs[members[: outward[kind]]] = 1.0
        net.setdefault(round(float(signs @ moment), 18), signs)
    return list(net.values())


def _rho_roots(h: Complexes, b: Complexes) -> Iterator[Floats]:
    """e^(i psi) (rho - h) = b, a quadratic in rho > 0."""
    own, force = complex(h[0, 0]), complex(b[0])
    under = abs(force) ** 2 - own.imag**2
    if under < 0.0 or force == 0.0:
        return
    for rho in {own.real + math.sqrt(under), own.real - math.sqrt(under)}:
        if rho > 1e-13 * (abs(own) + abs(force)):
            yield np.array([np.angle(force / (rho - own))])


def _two(h: Complexes, b: Complexes) -> list[Floats]:
    if np.abs(b).max() <= 1e-14 * np.abs(h).max():
        return []  # nothing breaks the symmetry of turning: such states are a continuum that is not isolated
    size = np.maximum(np.abs(b), np.abs(h).sum(axis=1))
    h, b = h / size[:, None], b / size
    y = Polynomial([0.0, 1.0])
    a1, b1, c1 = -(np.conj(b[0]) * y + np.conj(h[0, 1])), 2j * h[0, 0].imag * y, b[0] * y + h[0, 1] * y**2
    a2, b2, c2 = h[1, 0] + 0.0 * y, b[1] + 2j * h[1, 1].imag * y - np.conj(b[1]) * y**2, -np.conj(h[1, 0]) * y**2
    resultant = (a1 * c2 - a2 * c1) ** 2 - (a1 * b2 - a2 * b1) * (b1 * c2 - b2 * c1)
    values: list[Floats] = []
    for second in resultant.roots():
        if abs(abs(second) - 1.0) > OFF_CIRCLE:
            continue
        for first in np.roots([a1(second), b1(second), c1(second)]):
            psi = _polished(h, b, np.angle([first, second])) if abs(abs(first) - 1.0) < OFF_CIRCLE else None
            if psi is not None and not any(np.abs(np.exp(1j * psi) - np.exp(1j * old)).max() < 1e-7 for old in values):
                values.append(psi)
    return values


def _polished(h: Complexes, b: Complexes, psi: Floats) -> Floats | None:
    """Newton's method; none if it does not converge, or a ball would stand the other way round."""
    for _ in range(30):
        turn = np.exp(1j * psi)
        c = b + h @ turn
        miss = (c / turn).imag
        slope = ((1j * h * turn) / turn[:, None]).imag - np.diag((c / turn).real)
        step = np.linalg.lstsq(slope, -miss, rcond=1e-12)[0]
        psi = psi + step * min(1.0, 0.3 / max(float(np.abs(step).max()), 1e-300))
        if np.abs(step).max() < 1e-15:
            break
    turn = np.exp(1j * psi)
    along = (b + h @ turn) / turn
    if np.abs(along.imag).max() > 1e-11 or not (along.real > 1e-13).all():
        return None
    return np.asarray(psi)


def _searched(a: Aligned) -> list[dict[int, float]]:
    """Any number of stations and centers: the whirl by Newton's method for each pattern of signs."""
    from scipy.optimize import root

    balls = np.concatenate(a.balls)
    place = np.repeat(np.arange(len(a.balls)), [len(own) for own in a.balls])
    if 2 ** len(balls) > PATTERNS:
        raise QuestionError(f"steady states: {len(balls)} balls at such stations have too many arrangements to try all")
    moment, offset = a.moment[balls], a.offset[balls]
    # unknowns over the greatest whirl there can be; starts over some orders of magnitude
    scale = np.abs(a.free).max() + float((np.abs(a.host).max() * moment).sum()) + float(np.abs(offset).max())
    random = np.random.default_rng(0)
    count = len(a.balls)
    starts = random.normal(size=(STARTS * count, 2 * count)) * 10.0 ** random.uniform(-2.0, 0.3, (STARTS * count, 1))
    result: list[dict[int, float]] = []
    # each ball stands with its center or against it: for each pattern of signs the whirl is a root
    for pattern in product((1.0, -1.0), repeat=len(balls)):
        signs = np.array(pattern)

        def miss(parts: Floats, signs: Floats = signs) -> Floats:
            whirl = (parts[:count] + 1j * parts[count:]) * scale
            c = whirl[place] + offset
            load = np.zeros(count, np.complex128)
            np.add.at(load, place, moment * signs * c / np.maximum(np.abs(c), 1e-300))
            error = (whirl - a.free - a.host @ load) / scale
            return np.concatenate([error.real, error.imag])

        # roots that are not the same, and no center at rest, which is another kind of state
        seen: list[Complexes] = []
        for start in starts:
            answer = root(miss, start, tol=1e-13)
            c = ((answer.x[:count] + 1j * answer.x[count:]) * scale)[place] + offset
            if np.abs(answer.fun).max() > 1e-10 or np.abs(c).min() < 1e-9 * scale:
                continue
            if any(np.abs(c - old).max() < 1e-7 * scale for old in seen):
                continue
            seen.append(c)
            angles = np.angle(signs * c)
            result.append(dict(zip(balls.tolist(), angles.tolist(), strict=True)))
    return _distinct(result, a)


def _distinct(found: list[dict[int, float]], a: Aligned) -> list[dict[int, float]]:
    """States that differ by an exchange of equal balls of one race center are one."""
    kept: dict[object, dict[int, float]] = {}
    for angles in found:
        key = tuple(
            sorted(
                (round(a.moment[ball], 15), *(round(v, 6) for v in (np.cos(angle), np.sin(angle))), str(a.offset[ball]))
                for ball, angle in angles.items()
            )
        )
        kept.setdefault(key, angles)
    return list(kept.values())


# States of rest of balls that feel more than the deflection of their race, found from those of balls that do not.
#
# The rotor follows the balls, Q = Q(phi), so that Newton's method has one unknown for each ball. Directions in which
# the torques on the balls hardly change are a continuum of states, or so near to one that it makes no difference:
# along them the state stays where it is, and they count in ``freedom``.
#
# The tilt of a race changes a state by little, and it keeps its name. A continuum of states without it stays one: what
# the tilt does along it is of the second order in the slope. Forces on the balls may change everything: there Newton's
# method starts from random angles, too, states may be missed, and they are named by what the balls do.
#
# Where x and y are not alike, no state rests. The mean torques of the forward whirl and of the forces give states near
# the periodic ones, which :mod:`autobalancer.stability.states.linearized` finds from there with all that balls feel.


CORRECTIONS = 40
SLACK = 1e-7  # singular value of the torques' change with the angles, over that by the rotor, that counts as none
CLOSE, NEAR = 1e-11, 1e-7  # rad: last correction, and one below which it may be rounding
DIGITS = 4  # of the directions of balls, by which states that were found by different starts are one
FAR = 0.5  # rad: a state farther from where it began is another one
LARGEST = 0.3  # rad: of one correction
RANDOM = 6  # starts, and as many for each ball


def settled(st: Stations, speed: float, states: Iterable[StationState]) -> list[StationState]:
    """The states with all that the balls feel; without those that cease to exist, and exchanges of equal balls."""
    if st.forces is not None:
        count = st.moment.size
        random = generator(0).uniform(-np.pi, np.pi, (RANDOM * (1 + count), count))
        return searched(st, speed, [*(state.angles for state in states), *random])
    if not st.isotropic:
        return without_exchanges(st, states)
    station_states = []
    for state in without_exchanges(st, states):
        angles, freedom = _newton(st, speed, state.angles, state.freedom)
        if angles is not None and np.abs(angles - state.angles).max() < FAR:
            whirl = st.rows @ st.coordinates(speed, angles)
            station_states.append(replace(state, angles=angles, whirl=whirl, freedom=freedom))
    return station_states


def searched(st: Stations, speed: float, starts: Iterable[Floats]) -> list[StationState]:
    """States that Newton's method reaches from these ball angles, without exchanges of equal balls, in order."""
    station_states = []
    for start in starts:
        angles, freedom = _newton(st, speed, start)
        if angles is not None:
            station_states.append(state_at_rest(st, speed, np.mod(angles, 2.0 * np.pi), freedom))
    return sorted(without_exchanges(st, station_states, DIGITS), key=lambda state: state.rank)


def _newton(st: Stations, speed: float, start: Floats, freedom: int = 0) -> tuple[Floats | None, int]:
    """Ball angles at rest near a start (``None`` if not found), and the dimension of their continuum, at least ``freedom``."""
    # size of the torques' change with the angles as the rotor makes it, N m
    answer = st.rows @ st.compliance(speed) @ st.rows.T
    least = SLACK * float(speed**4 * np.abs(answer).max() * st.moment.max() ** 2)
    angles, last = np.array(start), np.inf
    balance = torques if st.isotropic else mean_torques
    for _ in range(CORRECTIONS):
        check_deadline()
        torque, slope = balance(st, speed, angles)
        left, sizes, right = np.linalg.svd(slope)
        firm = (sizes > least) & (np.arange(sizes.size) < sizes.size - freedom)
        step = -right[firm].T @ ((left.T @ torque)[firm] / sizes[firm])
        length = float(np.abs(step).max(initial=0.0))
        angles = angles + step * min(1.0, LARGEST / max(length, 1e-300))
        if length < CLOSE or 0.5 * last < length < NEAR:
            return angles, int((~firm).sum())
        last = length
    return None, 0


def mean_torques(st: Stations, speed: float, angles: Floats) -> tuple[Floats, Matrix]:
    """As :func:`torques` the mean of what turns balls at rest where x and y are not alike: the forward whirl and forces."""
    flat, n = st.plain_at(speed), angles.size
    push = speed * st.moment * np.exp(1j * angles)  # times W
    answer = speed**2 * flat.rows @ st.compliance(speed) @ flat.rows.T
    center = flat.rows @ flat.coordinates(speed, angles)
    lever = push.conj() * speed * (center[st.station] + st.offset)
    torque = lever.imag
    slope = (push.conj()[:, None] * 1j * answer[np.ix_(st.station, st.station)] * push).imag - np.diag(lever.real)
    if st.forces is not None:
        still, each = np.zeros((n, n)), np.eye(n)
        value, change = st.forces.series(np.broadcast_to(angles, (n, n)), still, each, still, speed, 1)
        torque, slope = torque + value[0], slope + change.T
    return torque, slope


def torques(st: Stations, speed: float, angles: Floats) -> tuple[Floats, Matrix]:
    """What turns balls at rest, (n,) N m, and its change with their angles, (n, n), while the rotor follows them."""
    field = Field(st, speed)
    first = field.rotor
    half, n = first // 2, field.balls
    state = state_vector(st, speed, angles)
    count = half + n
    ways = np.zeros((count, state.size))  # of Q with V = iW Q, and of the angles
    eye, none = np.eye(half // 2), np.zeros((half // 2, half // 2))
    turn = speed * np.block([[none, -eye], [eye, none]])
    ways[:half, :half], ways[:half, half:first] = np.eye(half), turn.T
    ways[half:, first : first + n] = np.eye(n)
    matrices, right = field.series(np.broadcast_to(state, ways.shape), ways, 1)
    # in rest A = -W^2 Q and phi'' = 0
    still = np.concatenate([-(speed**2) * state[:half], np.zeros(n)])
    moved = np.zeros((count, count))
    moved[:half, :half] = -(speed**2) * np.eye(half)
    inertia = field.inertia(matrices[0][0])
    miss = right[0][0] - inertia @ still
    slope = (right[1] - matrices[1] @ still - moved @ inertia.T).T
    follows = np.linalg.solve(slope[:half, :half], slope[:half, half:])
    return miss[half:], slope[half:, half:] - slope[half:, :half] @ follows


# The plane or the stations of a machine at its largest unbalance, and what may be wrong with them.


Described = Plane | Stations


def described(machine: Machine, unbalance: complex | float | None, highest: float | None = None) -> Described:
    """The numbers of any machine with an unbalance; for speeds up to ``highest``, rad/s.

    A mere size keeps the direction of the machine's largest one, which is the default.
    """
    if is_planar(machine):
        vector = largest_unbalance(machine)
        if unbalance is not None:
            value = vector_of(unbalance)
            keeps = isinstance(unbalance, complex) or vector == 0.0
            vector = value if keeps else value * vector / abs(vector)
        return in_plane(machine, vector) if has_forces(machine) else plane(machine, vector)
    st = stations(machine, unbalance, largest=True)
    return reduced(st, max(st.highest_searched, highest or 0.0))


def why_no_state(p: Described) -> str:
    """Why a machine has no balanced state at any speed that was tried."""
    if p.forces is not None:
        return "no state was found in which the balls, with the forces on them, make the deflection smaller"
    off = "no balanced state: the balls cannot make up for unbalance and eccentricity of the race"
    if not p.planar:  # from what the stations need well above the lowest critical speed
        st = p.as_station
        if np.any(st.offset != 0.0):
            return f"{off}s"
        speed = min(3.0 * st.scale_speed, st.model.top_speed)
        parts = []
        for place, (name, need) in enumerate(zip(st.names, np.abs(required(st, speed)).tolist(), strict=True)):
            have = float(st.capability[place])
            if need > have or int((st.station == place).sum()) == 1:
                parts.append(
                    f"at {name!r} {moment_text(need, 4)} are needed at {speed:.4g} rad/s, the balls have {moment_text(have, 4)}"
                )
        return f"no balanced state: {'; '.join(parts)}" if parts else "no balanced state was found"
    need, points = abs(p.unbalance), float(p.moment.sum())
    have = min(points, *np.atleast_1d(p.capability))
    if p.moment.size == 1:
        return "no balanced state: one ball alone balances only an unbalance of exactly its own moment"
    if np.any(p.offset != 0.0):
        return off
    if need > have:
        return f"no balanced state: the balls can balance {moment_text(have, 4)} at most, the unbalance is {moment_text(need, 4)}"
    least = 2.0 * float(p.moment.max()) - points
    if need < least:
        sizes = f"{moment_text(least, 4)}, the unbalance is {moment_text(need, 4)}"
        return f"no balanced state: unequal balls always add up to {sizes}"
    return "no balanced state was found"


def service_speed(st: Stations, highest: float | None) -> float:
    """The speed for which a machine is judged, rad/s: the highest prescribed one, else three times the lowest critical one."""
    return min(3.0 * st.scale_speed if highest is None or highest <= 0.0 else highest, st.model.top_speed)


# One state of rest in the rotor.


ORDER = ("balanced", "mixed", "spread", "coincident", "in line")  # of names
TRUE = 1e-9  # deflection, over that of the balls alone, at which a race runs true
ALIGNED = 1e-6  # part across a ball of the deflection of its race


@dataclass(frozen=True)
class StationState:
    """One state of rest in the rotor; ``freedom`` is the dimension of the continuum to which it belongs."""

    name: str  # balanced, mixed, coincident, in line; with forces on the balls spread, too
    angles: Floats  # (n,) ball angles in the rotor, rad
    whirl: Complexes  # (P,) deflections of the stations in the rotor, m
    freedom: int
    outward: int  # balls that stand outward in races that do not run true

    @property
    def rank(self) -> tuple[int, float]:
        """By which states are listed: name, then the greatest deflection."""
        return ORDER.index(self.name), float(np.abs(self.whirl).max(initial=0.0))


def state_vector(st: Stations, speed: float, angles: Floats) -> Floats:
    """The state of the vector field with the balls at rest at these angles: Q, V, ball angles and ball speeds."""
    whirl = st.coordinates(speed, angles)
    rate = 1j * speed * whirl
    return np.concatenate([whirl.real, whirl.imag, rate.real, rate.imag, angles, np.zeros(angles.size)])


def state_at_rest(st: Stations, speed: float, angles: Floats, freedom: int) -> StationState:
    """The state of balls with forces at these angles, named by what they do.

    *Coincident* or *in line* where all stand along the deflection of their race, *balanced* where they make the greatest
    deflection smaller than without them, *spread* otherwise.
    """
    flat = st.plain_at(speed)
    answer = flat.rows @ st.compliance(speed) * speed**2
    whirl = st.rows @ st.coordinates(speed, angles)
    center, alone = whirl[st.station] + st.offset, (answer @ flat.fixed_load)[st.station] + st.offset
    size, along = np.abs(center), np.exp(-1j * angles) * center
    true = size < TRUE * np.abs(answer @ flat.rows.T).max() * st.moment.max()
    out = ~true & (along.real > 0.0)
    if not true.any() and (np.abs(along.imag) < ALIGNED * size.max()).all():
        sides = [out[st.station == place] for place in range(len(st.names))]
        name = "coincident" if all(side.all() or not side.any() for side in sides) else "in line"
    else:
        name = "balanced" if true.all() or size.max() < np.abs(alone).max() else "spread"
    return StationState(name, angles, whirl, freedom, int(out.sum()))


# States that differ by an exchange of equal balls are one.


def without_exchanges(st: Stations, states: Iterable[StationState], digits: int = 7) -> list[StationState]:
    """Without states that differ by an exchange of equal balls of one station; ``digits`` of their directions count."""
    balls = zip(st.station.tolist(), st.moment.tolist(), st.inertia.tolist(), st.drag.tolist(), strict=True)
    kinds = [tuple(round(number, 15) for number in ball) for ball in balls]
    kept_states: dict[tuple[Any, ...], StationState] = {}
    for state in states:
        x, y = (np.round(part(state.angles), digits).tolist() for part in (np.cos, np.sin))
        key = tuple(sorted(zip(kinds, x, y, strict=True)))
        kept_states.setdefault(key, state)
    return list(kept_states.values())


# Why balls at the stations of a rotor never balance it: a motion in which the rotor yields towards its load.
#
# Balls gather on the side to which their plane moves. They balance only where the plane moves away from the load in
# every motion they can excite: the receptance between their planes, for loads that turn with the rotor, must be
# negative definite (its Hermitian part). A disk-like rotor, J_p > J_t, has no forward conical critical speed and
# always tilts towards its load.


def yields(st: Stations, speed: float) -> bool:
    """Whether in some motion that the balls excite the planes move towards the load."""
    try:
        answer = st.rows @ st.compliance(speed) @ st.rows.T
    except QuestionError:  # a critical speed of an undamped rotor
        return True
    return float(np.linalg.eigvalsh(0.5 * (answer + answer.conj().T))[-1]) > 0.0
