"""Balls that come to rest on their race and leave it again: found inside a step, so that rest is exact.

A ball rolls with the sign ``MODE`` of its speed, by which rolling resistance works; where its speed reaches zero it rests
if adherence can hold it (|NEED| <= mu L N), else it rolls the way it is pushed. A ball at rest leaves where adherence
can hold it no longer.
"""

from __future__ import annotations

import math

from numba import njit

from autobalancer.kernels.flags import COMPILED, INLINE
from autobalancer.kernels.integrators.dense import component, evaluate, polynomials
from autobalancer.kernels.integrators.memory import EVALUATIONS, TAKEN
from autobalancer.kernels.pointers import behind, data
from autobalancer.kernels.race_layout import (
    ADHERENCE,
    MASS_,
    MODE,
    NEED,
    NORMAL,
    RACE_COLUMNS,
    RAW_LEAN_X,
    RAW_LEAN_Y,
    ROLLING,
)
from autobalancer.kernels.rotor_layout import BALL_ROWS, RUBBING
from autobalancer.kernels.system import BALLS

ROUNDING = 1.0 + 1e-9  # a ball leaves its rest with an acceleration whose sign is not one of rounding


@njit(**INLINE)
def _loose(r, at: int) -> bool:  # type: ignore[no-untyped-def]
    """Whether adherence cannot hold this ball, after the equations were evaluated."""
    path = math.sqrt(r[at + RAW_LEAN_X] ** 2 + r[at + RAW_LEAN_Y] ** 2) / r[at + MASS_]
    return abs(r[at + NEED]) > ROUNDING * r[at + ADHERENCE] * path * max(r[at + NORMAL], 0.0)


@njit(**INLINE)
def _rubs(r, at: int) -> bool:  # type: ignore[no-untyped-def]
    return r[at + ROLLING] > 0.0 or r[at + ADHERENCE] > 0.0


@njit(**INLINE)
def forget_modes(p, m) -> None:  # type: ignore[no-untyped-def]
    """Before an integration begins anew from a state: every ball that does not move rests until it is found loose."""
    if p.rotor.size > 0:
        r, count = data(p.rotor), p.balls.shape[0]
        if r[RUBBING] != 0.0:
            for b in range(count):
                at = int(r[BALL_ROWS]) + b * RACE_COLUMNS
                if _rubs(r, at) and m.state[BALLS + count + b] == 0.0:
                    r[at + MODE] = 0.0


@njit(**INLINE)
def take_modes(p, m) -> None:  # type: ignore[no-untyped-def]
    """Before an integration goes on from a state: every ball that moves rolls the way it moves."""
    if p.rotor.size > 0:
        r, count = data(p.rotor), p.balls.shape[0]
        if r[RUBBING] != 0.0:
            for b in range(count):
                at, speed = int(r[BALL_ROWS]) + b * RACE_COLUMNS, m.state[BALLS + count + b]
                if _rubs(r, at) and (r[at + MODE] * speed < 0.0 or (r[at + MODE] == 0.0 and speed != 0.0)):
                    r[at + MODE] = math.copysign(1.0, speed)


@njit(**INLINE)
def switch_due(p, m) -> bool:  # type: ignore[no-untyped-def]
    """Whether a ball stopped or broke loose in the step just taken, whose end was evaluated last."""
    if p.rotor.size == 0:
        return False
    r = data(p.rotor)
    if r[RUBBING] == 0.0:
        return False
    due, count = False, p.balls.shape[0]
    for b in range(count):
        at = int(r[BALL_ROWS]) + b * RACE_COLUMNS
        if _rubs(r, at):
            if r[at + MODE] != 0.0:
                due = due or r[at + MODE] * m.state[BALLS + count + b] < 0.0
            else:
                due = due or _loose(r, at)
    return due


@njit(**COMPILED)
def _crossing(place, way, pair):  # type: ignore[no-untyped-def]
    """Where a speed that ends on the other side passes zero for the last time; 0 if it was never seen on this side."""
    _, m = behind(pair)
    low, high = 0.0, 1.0
    seen = way * data(m.start)[place] > 0.0
    for piece in range(7, 0, -1):
        if way * component(place, piece / 8.0, m) > 0.0:
            low, seen = piece / 8.0, True
            break
        high = piece / 8.0
    if not seen:
        return 0.0
    middle = 0.5 * (low + high)
    while low < middle < high:
        if way * component(place, middle, m) < 0.0:
            high = middle
        else:
            low = middle
        middle = 0.5 * (low + high)
    return high


@njit(**COMPILED)
def first_switch(time, rhs, parameters, pair):  # type: ignore[no-untyped-def]
    """The fraction of the step after which the first ball stops or breaks loose; balls that stop there get the mode of rest.

    Judged by the crossing and not by the state at the cut, whose speed may keep its old sign by rounding.
    It is 0 where a ball that broke loose seems to turn back at once: the step is too long for its motion.
    """
    (t, m), p = behind(pair), behind(parameters)
    polynomials(m.state.size, t, m)
    r, count = data(p.rotor), p.balls.shape[0]
    first, resting = 1.0, False
    for b in range(count):
        at, place = int(r[BALL_ROWS]) + b * RACE_COLUMNS, BALLS + count + b
        if _rubs(r, at):
            if r[at + MODE] == 0.0:
                resting = True
            elif r[at + MODE] * m.state[place] < 0.0:
                first = min(first, _crossing(place, r[at + MODE], pair))
    if first == 0.0:
        return first
    if resting:
        low, high, x = 0.0, first, first
        for _ in range(48):
            evaluate(x, pair, data(m.spare))
            rhs(time + x * m.clock[TAKEN], data(m.spare), data(m.trial), parameters)
            m.counts[EVALUATIONS] += 1
            loose = False
            for b in range(count):
                at = int(r[BALL_ROWS]) + b * RACE_COLUMNS
                loose = loose or (r[at + MODE] == 0.0 and _rubs(r, at) and _loose(r, at))
            if loose:
                high = x
            else:
                low = x
            if low == first or high - low < 1e-10:
                break
            x = 0.5 * (low + high)
        first = high
    for b in range(count):
        at = int(r[BALL_ROWS]) + b * RACE_COLUMNS
        passed = _rubs(r, at) and r[at + MODE] * m.state[BALLS + count + b] < 0.0
        if passed and _crossing(BALLS + count + b, r[at + MODE], pair) <= first:
            r[at + MODE] = 0.0
    return first


@njit(**COMPILED)
def switch(time, rhs, parameters, pair):  # type: ignore[no-untyped-def]
    """At the end of a cut step, which is in ``m.state``: balls that stopped rest or turn round, balls that are loose roll."""
    (_, m), p = behind(pair), behind(parameters)
    r, count = data(p.rotor), p.balls.shape[0]
    for b in range(count):
        at = int(r[BALL_ROWS]) + b * RACE_COLUMNS
        if _rubs(r, at) and r[at + MODE] == 0.0:
            m.state[BALLS + count + b] = 0.0
    rhs(time, data(m.state), data(m.trial), parameters)
    m.counts[EVALUATIONS] += 1
    for b in range(count):
        at = int(r[BALL_ROWS]) + b * RACE_COLUMNS
        if _rubs(r, at) and r[at + MODE] == 0.0 and _loose(r, at):
            r[at + MODE] = math.copysign(1.0, r[at + NEED])
