"""States of rest of balls that feel more than the deflection of their race, found from those of balls that do not.

The rotor follows the balls, Q = Q(phi), so that Newton's method has one unknown for each ball. Directions in which the torques
on the balls hardly change are a continuum of states, or so near to one that it makes no difference: along them the state
stays where it is, and they count in ``freedom``.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from autobalancer.stability.host.planar import Floats, Matrix
from autobalancer.stability.host.stations import Stations
from autobalancer.stability.host.vector_field import Field
from autobalancer.stability.states.exchanges import without_exchanges
from autobalancer.stability.states.state import StationState, state_vector

CORRECTIONS = 30
SLACK = 1e-7  # singular value of the torques' change with the angles, over the greatest, that counts as none
CLOSE = 1e-11  # rad: last correction
FAR = 0.5  # rad: a state farther from where it began is another one
LARGEST = 0.2  # rad: of one correction


def settled(st: Stations, speed: float, states: Iterable[StationState]) -> list[StationState]:
    """The states with all that the balls feel; without those that cease to exist, and exchanges of equal balls."""
    field = Field(st, speed)
    found = [_settled(field, state) for state in without_exchanges(st, states)]
    return [state for state in found if state is not None]


def _settled(field: Field, state: StationState) -> StationState | None:
    angles = np.array(state.angles)
    for _ in range(CORRECTIONS):
        torque, slope = torques(field, angles)
        left, sizes, right = np.linalg.svd(slope)
        firm = sizes > SLACK * max(float(sizes[0]), 1e-300)
        step = -right[firm].T @ ((left.T @ torque)[firm] / sizes[firm])
        angles = angles + step * min(1.0, LARGEST / max(float(np.abs(step).max(initial=0.0)), 1e-300))
        if np.abs(step).max(initial=0.0) < CLOSE:
            break
    else:
        return None
    if np.abs(angles - state.angles).max() > FAR:
        return None
    st = field.host
    whirl = st.rows @ st.coordinates(field.speed, angles)
    return replace(state, angles=angles, whirl=whirl, freedom=int((~firm).sum()))


def torques(field: Field, angles: Floats) -> tuple[Floats, Matrix]:
    """What turns balls at rest, (n,) N m, and its change with their angles, (n, n), while the rotor follows them."""
    st, speed, first = field.host, field.speed, field.rotor
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
