"""The steady state of all equations where x and y are not alike, in harmonics of twice the speed, from ball angles near it.

Newton's method for :class:`~autobalancer.stability.host.cycle.Cycle`, with as many harmonics as the state needs. It starts with
balls at rest, and the rotor as it follows them.
"""

from __future__ import annotations

import math

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.stability.host.cycle import Cycle
from autobalancer.stability.host.planar import Floats
from autobalancer.stability.host.stations import Stations

COUNTS = (9, 17, 33, 65)  # numbers of harmonics that are tried
TAIL = 1e-11  # over the sizes of the components: a harmonic below it has vanished
CORRECTIONS = 40
CLOSE, NEAR = 1e-13, 1e-9  # rad: last correction, and one below which it may be rounding
LARGEST = 0.3  # rad: of one correction
SLACK = 1e-9  # singular value, over the greatest, that counts as none along a continuum of states


def swinging(st: Stations, speed: float, angles: Floats, freedom: int = 0) -> tuple[Cycle, Floats]:
    """The equations and the state near ball angles (n,); of a continuum of ``freedom`` dimensions the nearest member.

    Raises
    ------
    QuestionError
        If Newton's method finds no such state, or the balls do not swing smoothly.
    """
    start = np.asarray(angles, np.float64)
    for count in COUNTS:
        cycle = Cycle(st, speed, count)
        state = settled_on(cycle, start, freedom)
        start = state.reshape(count, -1)[:, cycle.rotor : cycle.rotor + cycle.balls]
        if tail(cycle, state) < TAIL:
            return cycle, state
    raise QuestionError(
        f"steady state: the balls do not swing smoothly at {speed:.6g} rad/s (harmonic {COUNTS[-1] - 1})"
    )


def settled_on(cycle: Cycle, angles: Floats, freedom: int = 0) -> Floats:
    """The state near ball angles, their mean (n,) or harmonic after harmonic (k, n), with as many harmonics as the cycle has.

    Raises
    ------
    QuestionError
        If Newton's method finds no such state.
    """
    start = np.atleast_2d(angles)
    parts = np.zeros((cycle.count, cycle.size))
    parts[: len(start), cycle.rotor : cycle.rotor + cycle.balls] = start
    return _newton(cycle, parts.ravel(), freedom)


def tail(cycle: Cycle, state: Floats) -> float:
    """Size of the highest harmonic, over the sizes of the components."""
    return float(np.abs((state / sizes(cycle)).reshape(cycle.count, -1)[-2:]).max())


def _newton(cycle: Cycle, state: Floats, freedom: int) -> Floats:
    scale = sizes(cycle)
    follows = np.tile(np.arange(cycle.size) < cycle.rotor, cycle.count)
    slope, miss = cycle.jacobian(state), cycle(state)
    state, last = np.array(state), math.inf
    state[follows] -= np.linalg.solve(slope[np.ix_(follows, follows)], miss[follows])
    for _ in range(CORRECTIONS):
        slope, miss = cycle.jacobian(state) * scale / scale[:, None], -cycle(state) / scale
        step = np.linalg.lstsq(slope, miss, rcond=SLACK)[0] if freedom else np.linalg.solve(slope, miss)
        turned = np.abs(step.reshape(cycle.count, -1)[:, cycle.rotor : cycle.rotor + cycle.balls])
        length = float(turned.max(initial=0.0))
        state = state + scale * step * min(1.0, LARGEST / max(length, 1e-300))
        if length < CLOSE or 0.5 * last < length < NEAR:
            return state
        last = length
    raise QuestionError(f"steady state: no periodic state is found near these ball angles at {cycle.speed:.6g} rad/s")


def sizes(cycle: Cycle) -> Floats:
    """Of the components of a state: deflections by the moment of unbalance and balls, angles of one radian."""
    host, n = cycle.host, cycle.balls
    length = (abs(host.unbalance) + float(host.moment.sum())) / host.model.total_mass or 1.0
    one = np.repeat([length, length * cycle.speed, 1.0, cycle.speed], [cycle.rotor // 2, cycle.rotor // 2, n, n])
    return np.asarray(np.tile(one, cycle.count), np.float64)
