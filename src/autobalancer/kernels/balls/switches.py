"""Balls that come to rest on their race and leave it again: found inside a step, so that rest is exact.

A ball rolls with the sign ``MODE`` of its speed, by which rolling resistance works; where its speed reaches zero it rests
if adherence can hold it (|NEED| <= mu L N), else it rolls the way it is pushed. A ball at rest leaves where adherence
can hold it no longer.
"""

from __future__ import annotations

import math
from typing import Any

from autobalancer.kernels.flags import ADDRESSED, INLINE, PART, njit
from autobalancer.kernels.integrators.dense import component, evaluate, polynomials
from autobalancer.kernels.integrators.memory import EVALUATIONS, TAKEN, Memory
from autobalancer.kernels.integrators.switching import CUT, DUE, FORGET, PASS, SHORTEST, TAKE, pair_at
from autobalancer.kernels.integrators.tableau import Tableau
from autobalancer.kernels.pointers import behind, data
from autobalancer.kernels.system import BALLS, SPEED, System, system_at

ROUNDING = 1.0 + 1e-9  # a ball leaves its rest with an acceleration whose sign is not one of rounding
PIECES = 16  # into which a step is cut in search of a ball that turns round and back
SHORT = 1e-8  # rad of rotor angle in the shortest step for the sake of a ball that breaks loose


@njit(**ADDRESSED)
def adherence(ask: int, time: float, rates: Any, parameters: Any, pair: Any) -> float:
    """The switch of guided balls on real races."""
    pair = pair_at(pair)
    p, (t, m) = behind(system_at(parameters)), behind(pair)
    if ask == TAKE:
        take(p, m)
    elif ask == FORGET:
        forget(p, m)
    elif ask == DUE:
        return 1.0 if _due(p, t, m) else 0.0
    elif ask == CUT:
        return _cut(time, rates, parameters, pair)
    elif ask == PASS:
        _pass(time, rates, parameters, pair)
    elif ask == SHORTEST:
        return SHORT / max(1.0, abs(m.start[SPEED]))
    return 0.0


@njit(**INLINE)
def _loose(ball: Any, moving: Any) -> bool:
    """Whether adherence cannot hold this ball, after the equations were evaluated."""
    path = math.sqrt(moving.held_lean_x**2 + moving.held_lean_y**2) / ball.mass
    pressed = max(moving.normal, -ball.pulls * moving.normal)
    return abs(moving.need) > ROUNDING * ball.adherence * path * pressed


@njit(**INLINE)
def lowest(first: float, last: float, falling: float, rising: float, step: float) -> float:
    """Where the tangents at both ends of a step meet, of a number that falls at its start and rises at its end; else infinite."""
    if falling >= 0.0 or rising <= 0.0:
        return math.inf
    bottom = min(max((last - first - rising * step) / (falling - rising), 0.0), step)
    return first + falling * bottom


@njit(**INLINE)
def rubs(ball: Any) -> bool:
    return ball.rolling > 0.0 or ball.adherence > 0.0


@njit(**INLINE)
def forget(p: System, m: Memory) -> None:
    """Every ball that does not move rests until it is found loose.

    One that is hit just as it breaks loose would else turn back within less time than angles have digits for.
    """
    for b in range(p.ball_count):
        if rubs(p.balls[b]) and m.state[BALLS + p.ball_count + b] == 0.0:
            p.guided[b].mode = 0.0


@njit(**INLINE)
def take(p: System, m: Memory) -> None:
    """Every ball that moves rolls the way it moves."""
    for b in range(p.ball_count):
        speed, moving = m.state[BALLS + p.ball_count + b], p.guided[b]
        if rubs(p.balls[b]) and (moving.mode * speed < 0.0 or (moving.mode == 0.0 and speed != 0.0)):
            moving.mode = math.copysign(1.0, speed)


@njit(**INLINE)
def stopped(place: int, way: float, t: Tableau, m: Memory) -> bool:
    """Whether a speed passed zero in the step just taken, or may have passed it and come back: where its tangents say so.

    Pieces of long steps have no stages; what is between their ends is not looked at.
    """
    first, last = way * data(m.start)[place], way * data(m.state)[place]
    if last < 0.0:
        return True
    if t.total == t.degree or first <= 0.0:
        return False
    width, stages = m.trial.size, data(m.stages)
    falling, rising = way * stages[place], way * stages[(t.main - 1) * width + place]
    return lowest(first, last, falling, rising, m.clock[TAKEN]) < 0.0


@njit(**INLINE)
def _due(p: System, t: Tableau, m: Memory) -> bool:
    """Whether a ball stopped or broke loose in the step just taken, whose end was evaluated last."""
    due = False
    for b in range(p.ball_count):
        ball, moving = p.balls[b], p.guided[b]
        if rubs(ball):
            if moving.mode != 0.0:
                due = due or stopped(BALLS + p.ball_count + b, moving.mode, t, m)
            else:
                due = due or _loose(ball, moving)
    return due


@njit(**INLINE)
def _passed(low: float, high: float, place: int, way: float, m: Memory) -> float:
    """Where between two places a speed passes zero."""
    middle = 0.5 * (low + high)
    while low < middle < high:
        if way * component(place, middle, m) < 0.0:
            high = middle
        else:
            low = middle
        middle = 0.5 * (low + high)
    return high


@njit(**PART)
def crossing(place, way, pair):  # type: ignore[no-untyped-def]
    """The fraction of the step at which a ball that moves this way stops, 2 if it does not.

    Where it ends on the other side, its speed passes zero for the last time; 0 if it was never seen on this side. Where it
    turns round and back, its speed passes zero for the first time.
    """
    t, m = behind(pair)
    low, high = 0.0, 1.0
    if not way * data(m.state)[place] < 0.0:
        if way == 0.0 or not stopped(place, way, t, m):
            return 2.0
        for piece in range(1, PIECES + 1):
            high = piece / PIECES
            if way * component(place, high, m) < 0.0:
                return _passed(low, high, place, way, m)
            low = high
        return 2.0
    seen = way * data(m.start)[place] > 0.0
    for piece in range(7, 0, -1):
        if way * component(place, piece / 8.0, m) > 0.0:
            low, seen = piece / 8.0, True
            break
        high = piece / 8.0
    return _passed(low, high, place, way, m) if seen else 0.0


@njit(**PART)
def _cut(time, rhs, parameters, pair):  # type: ignore[no-untyped-def]
    """The fraction of the step after which the first ball stops or breaks loose; balls that stop there get the mode of rest.

    Judged by the crossing and not by the state at the cut, whose speed may keep its old sign by rounding.
    It is 0 where a ball that broke loose seems to turn back at once: the step is too long for its motion.
    """
    (t, m), p = behind(pair), behind(system_at(parameters))
    polynomials(m.state.size, t, m)
    first, resting = 1.0, False
    for b in range(p.ball_count):
        mode, place = p.guided[b].mode, BALLS + p.ball_count + b
        if rubs(p.balls[b]):
            resting = resting or mode == 0.0
            first = min(first, crossing(place, mode, pair))
    if first == 0.0:
        return first
    if resting:
        low, high, x = 0.0, first, first
        for _ in range(48):
            evaluate(x, pair, data(m.spare))
            rhs(time + x * m.clock[TAKEN], data(m.spare), data(m.trial), parameters)
            m.counts[EVALUATIONS] += 1
            loose = False
            for b in range(p.ball_count):
                ball, moving = p.balls[b], p.guided[b]
                loose = loose or (moving.mode == 0.0 and rubs(ball) and _loose(ball, moving))
            if loose:
                high = x
            else:
                low = x
            if low == first or high - low < 1e-10:
                break
            x = 0.5 * (low + high)
        first = high
    for b in range(p.ball_count):
        mode, place = p.guided[b].mode, BALLS + p.ball_count + b
        if rubs(p.balls[b]) and crossing(place, mode, pair) <= first:
            p.guided[b].mode = 0.0
    return first


@njit(**PART)
def _pass(time, rhs, parameters, pair):  # type: ignore[no-untyped-def]
    """At the end of a cut step, which is in ``m.state``: balls that stopped rest or turn round, balls that are loose roll."""
    (_, m), p = behind(pair), behind(system_at(parameters))
    for b in range(p.ball_count):
        if rubs(p.balls[b]) and p.guided[b].mode == 0.0:
            m.state[BALLS + p.ball_count + b] = 0.0
    rhs(time, data(m.state), data(m.trial), parameters)
    m.counts[EVALUATIONS] += 1
    for b in range(p.ball_count):
        ball, moving = p.balls[b], p.guided[b]
        if rubs(ball) and moving.mode == 0.0 and _loose(ball, moving):
            moving.mode = math.copysign(1.0, moving.need)
