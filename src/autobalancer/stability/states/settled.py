"""States of rest of balls that feel more than the deflection of their race, found from those of balls that do not.

The rotor follows the balls, Q = Q(phi), so that Newton's method has one unknown for each ball. Directions in which the torques
on the balls hardly change are a continuum of states, or so near to one that it makes no difference: along them the state
stays where it is, and they count in ``freedom``.

The tilt of a race changes a state by little, and it keeps its name. A continuum of states without it stays one: what the tilt
does along it is of the second order in the slope. Forces on the balls may change everything: there Newton's
method starts from random angles, too, states may be missed, and they are named by what the balls do.

Where x and y are not alike, no state rests. The mean torques of the forward whirl and of the forces give states near the periodic
ones, which :mod:`autobalancer.stability.states.swinging` finds from there with all that balls feel.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from autobalancer.patience import still_time
from autobalancer.random_numbers import generator
from autobalancer.stability.host.planar import Floats, Matrix
from autobalancer.stability.host.stations import Stations
from autobalancer.stability.host.vector_field import Field
from autobalancer.stability.states.exchanges import without_exchanges
from autobalancer.stability.states.state import StationState, named_at_rest, state_vector

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
    found = []
    for state in without_exchanges(st, states):
        angles, freedom = _newton(st, speed, state.angles, state.freedom)
        if angles is not None and np.abs(angles - state.angles).max() < FAR:
            whirl = st.rows @ st.coordinates(speed, angles)
            found.append(replace(state, angles=angles, whirl=whirl, freedom=freedom))
    return found


def searched(st: Stations, speed: float, starts: Iterable[Floats]) -> list[StationState]:
    """States that Newton's method reaches from these ball angles, without exchanges of equal balls, in order."""
    found = []
    for start in starts:
        angles, freedom = _newton(st, speed, start)
        if angles is not None:
            found.append(named_at_rest(st, speed, np.mod(angles, 2.0 * np.pi), freedom))
    return sorted(without_exchanges(st, found, DIGITS), key=lambda state: state.rank)


def _newton(st: Stations, speed: float, start: Floats, freedom: int = 0) -> tuple[Floats | None, int]:
    """Ball angles at rest near a start (``None`` if not found), and the dimension of their continuum, at least ``freedom``."""
    angles, last, least = np.array(start), np.inf, SLACK * _by_rotor(st, speed)
    balance = torques if st.isotropic else mean_torques
    for _ in range(CORRECTIONS):
        still_time()
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


def _by_rotor(st: Stations, speed: float) -> float:
    """Size of the torques' change with the angles as the rotor makes it, N m."""
    answer = st.rows @ st.compliance(speed) @ st.rows.T
    return float(speed**4 * np.abs(answer).max() * st.moment.max() ** 2)


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
