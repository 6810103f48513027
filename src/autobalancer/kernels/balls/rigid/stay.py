"""Which rigid contacts are closed from an instant on: impacts first, then who presses, then who only chatters.

All of it asks for a state, the right-hand side and tolerances, not for how the state was reached.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from autobalancer.kernels.balls.rigid.closed import (
    close,
    collect,
    count_bound,
    equalize,
    exists,
    gap,
    is_closed,
    opening,
    torque_of,
)
from autobalancer.kernels.balls.rigid.clusters import leads
from autobalancer.kernels.balls.rigid.impact import complementary, responses, solve_active, strike
from autobalancer.kernels.balls.rigid.torques import FAR, LEAST, NOW, PULL, capacity
from autobalancer.kernels.flags import APART, INLINE, njit
from autobalancer.kernels.pointers import behind, data
from autobalancer.kernels.records.impacts import AHEAD, BEHIND, NEXT
from autobalancer.kernels.system import BALLS, System, system_at

NEAR = 1e-9  # rad, by which balls may be apart that touch at the start of a run


class Limits(NamedTuple):
    """What counts as nothing."""

    slow: float  # rad/s: an approach that does not rebound
    low: float  # rad: height of a flight that is not flown


@njit(**INLINE)
def _rest_speed(limits: Limits) -> float:
    return max(1e-3 * limits.slow, 1e-11)


@njit(**APART)
def settle(time, y, rates, system, size, width, limits):  # type: ignore[no-untyped-def]
    """Let closed contacts strike, and find out which stay closed; ``width`` (rad) is that of gaps that count as closed.

    Changes the state ``y`` of ``size`` components; returns evaluations.
    """
    p = behind(system_at(system))
    r, done, still = p.rigid, 0, _rest_speed(limits)
    count = collect(y, system, width)
    approaching = False
    for q in range(count):
        approaching = approaching or r.before[q] < -still
    if approaching:
        done += strike(time, y, rates, system, size, count, limits.slow)
    done += _stay(time, y, rates, system, size, count, still)
    if _catch(y, p, count, still, limits.low):
        done += _stand_still(time, y, rates, system, size, count)
        done += _stay(time, y, rates, system, size, count, still)
    r.margin[LEAST] = FAR
    return done


@njit(**APART)
def _stay(time, y, rates, system, size, count, still):  # type: ignore[no-untyped-def]
    """Close the contacts listed that are at rest and press, and open the others; ``r.base`` are the rates then."""
    p = behind(system_at(system))
    r, done = p.rigid, 0
    for q in range(count):
        kind, k = r.kinds[q], r.balls[q]
        close(p, kind, k, 1 if abs(opening(y, p, kind, k)) <= still else 0)
    count_bound(system)
    equalize(y, system)
    _set_modes(y, p)
    done += _rest(time, y, rates, system, count, still)
    again = True
    while again and done <= 9 * p.ball_count + 9:
        done += _press(time, y, rates, system, size, count, still)
        again = _loosen(system)  # what balls that touch do to the rotor may be just too much for one that rests
    return done


@njit(**APART)
def _press(time, y, rates, system, size, count, still):  # type: ignore[no-untyped-def]
    """Close those contacts listed of rolling balls that press, and open the others."""
    p = behind(system_at(system))
    r, done, some = p.rigid, 0, False
    for q in range(count):
        kind, k = r.kinds[q], r.balls[q]
        r.chosen[q] = 1 if not is_closed(p, kind, k) and _may_press(y, p, kind, k, still) else 0
        some = some or r.chosen[q] != 0
    if some:
        done += responses(time, y, rates, system, size, count)
        for q in range(count):
            r.need[q] = opening(data(r.base), p, r.kinds[q], r.balls[q])
        complementary(system, count)
        for q in range(count):
            if r.chosen[q] != 0:
                rest = r.need[q]
                for j in range(count):
                    rest += r.delassus[q, j] * r.impulse[j] if r.chosen[j] != 0 else 0.0
                presses = r.impulse[q] > 0.0 or rest <= r.margin[PULL] * r.delassus[q, q]
                close(p, r.kinds[q], r.balls[q], 1 if presses else 0)
        count_bound(system)
    return done + open_pulling(time, y, rates, system)


@njit(**INLINE)
def _rubs(ball: Any) -> bool:
    return bool(ball.rolling > 0.0 or ball.adherence > 0.0)


@njit(**INLINE)
def _at_rest(p: System, k: int) -> bool:
    return bool(p.guided[k].mode == 0.0 and _rubs(p.balls[k]))


@njit(**INLINE)
def _set_modes(y: Any, p: System) -> None:
    """Balls that friction can hold rest where their speed is zero, and roll the way they move elsewhere."""
    for k in range(p.ball_count):
        rate = y[BALLS + p.ball_count + k]
        if _rubs(p.balls[k]):
            p.guided[k].mode = math.copysign(1.0, rate) if rate != 0.0 else 0.0


@njit(**INLINE)
def _may_press(y: Any, p: System, kind: int, k: int, still: float) -> bool:
    """Whether a contact of balls that roll is at rest."""
    rest = _at_rest(p, k) or (kind == NEXT and _at_rest(p, p.contacts[k].next))
    return bool(not rest and abs(opening(y, p, kind, k)) <= still)


@njit(**APART)
def _rest(time, y, rates, system, count, still):  # type: ignore[no-untyped-def]
    """Close the contacts among balls that adherence may hold, and let those break loose that it cannot."""
    p = behind(system_at(system))
    r = p.rigid
    for q in range(count):
        kind, k = r.kinds[q], r.balls[q]
        held = _at_rest(p, k) and (kind != NEXT or _at_rest(p, p.contacts[k].next))
        close(p, kind, k, 1 if held and abs(opening(y, p, kind, k)) <= still else 0)
    count_bound(system)
    resting = False
    for k in range(p.ball_count):
        resting = resting or _at_rest(p, k)
    done = 0
    while resting and done <= p.ball_count:
        rates(time, y, data(r.base), system)
        done += 1
        resting = _loosen(system)
    return done


@njit(**APART)
def _loosen(system: Any) -> bool:
    """Let those balls roll that adherence cannot hold, by the last evaluation; whether there were any."""
    p = behind(system_at(system))
    some = False
    for k in range(p.ball_count):
        if p.guided[k].bound == 0 and _at_rest(p, k):
            if is_loose(p, k):
                p.guided[k].mode, some = math.copysign(1.0, p.guided[k].need), True
        elif leads(p, k) and _at_rest(p, k):
            some = _break(p, k) or some
    if some:
        count_bound(system)
    return some


@njit(**INLINE)
def is_loose(p: System, k: int) -> bool:
    """Whether adherence cannot hold a ball that touches nothing."""
    return bool(abs(p.guided[k].need) > capacity(p, k))


@njit(**INLINE)
def _break(p: System, head: int) -> bool:
    """Let those balls of a row at rest roll that cannot be held: the first ones backward, or the last ones forward."""
    k, last, back = head, head, -1
    pushed, more = 0.0, True
    while more:
        its = p.ties[k]
        if back < 0 and its.most < 0.0 and its.joined != 2:
            back = k
        pushed += its.rest
        last, more = k, its.joined == 1
        k = p.contacts[k].next
    end = p.ties[last]
    if end.joined == 2:
        if p.rigid.margin[NOW] >= 0.0:
            return False
        _roll(p, head, last, math.copysign(1.0, pushed))
        return True
    if back >= 0:
        _roll(p, head, back, -1.0)
        p.ties[back].joined = 0
        return True
    if end.high == 0 and end.least > 0.0:
        first = last
        while first != head and p.ties[p.contacts[first].before].least > 0.0:
            first = p.contacts[first].before
        _roll(p, first, last, 1.0)
        if first != head:
            p.ties[p.contacts[first].before].joined = 0
        else:
            p.ties[head].low = 0
        return True
    return False


@njit(**INLINE)
def _roll(p: System, first: int, last: int, way: float) -> None:
    """Balls in a row roll this way; what joined them is to be found again."""
    k, more = first, True
    while more:
        p.guided[k].mode = way
        more = k != last
        if p.ties[k].joined == 1 and more:
            p.ties[k].joined = 1 if p.contacts[k].rigid == 2 else 0
        k = p.contacts[k].next


@njit(**INLINE)
def _catch(y: Any, p: System, count: int, still: float, low: float) -> bool:
    """Choose contacts that would fly apart less than ``low``, besides those that press; whether there are any."""
    r, some = p.rigid, False
    for q in range(count):
        kind, k = r.kinds[q], r.balls[q]
        r.chosen[q] = 1 if is_closed(p, kind, k) else 0
        if r.chosen[q] == 0:
            rate, back = opening(y, p, kind, k), -opening(data(r.base), p, kind, k)
            if rate > still and back > 0.0 and rate * rate < 2.0 * back * low:
                r.chosen[q], some = 1, True
    return some


@njit(**APART)
def _stand_still(time, y, rates, system, size, count):  # type: ignore[no-untyped-def]
    """Stop the openings of the chosen contacts by impulses of either sign, which are tiny."""
    p = behind(system_at(system))
    r = p.rigid
    for q in range(count):
        k = r.balls[q]
        for j in (k, p.contacts[k].next if r.kinds[q] == NEXT else k):
            if r.chosen[q] != 0 and p.guided[j].mode == 0.0 and y[BALLS + p.ball_count + j] != 0.0:
                p.guided[j].mode = math.copysign(1.0, y[BALLS + p.ball_count + j])
    done = responses(time, y, rates, system, size, count)
    for q in range(count):
        r.need[q], r.active[q] = opening(y, p, r.kinds[q], r.balls[q]), r.chosen[q]
    solve_active(system, count)
    for i in range(size):
        for q in range(count):
            if r.chosen[q] != 0:
                y[i] += r.response[q, i] * r.impulse[q]
    return done


@njit(**APART)
def open_pulling(time, y, rates, system):  # type: ignore[no-untyped-def]
    """Open contacts that would pull, the one that pulls most first; returns evaluations. ``r.base`` are the rates then."""
    p = behind(system_at(system))
    r, done, pulls = p.rigid, 0, True
    while pulls and done <= 3 * p.ball_count:
        r.margin[NOW] = FAR
        rates(time, y, data(r.base), system)
        done += 1
        worst, which, its_kind = -r.margin[PULL], -1, NEXT
        for k in range(p.ball_count):
            for kind in (NEXT, BEHIND, AHEAD):
                if exists(p, kind, k) and is_closed(p, kind, k) and torque_of(p, kind, k) < worst:
                    worst, which, its_kind = torque_of(p, kind, k), k, kind
        pulls = which >= 0
        if pulls:
            close(p, its_kind, which, 0)
            count_bound(system)
    return done


@njit(**APART)
def recognize(time, y, rates, system):  # type: ignore[no-untyped-def]
    """Which contacts are closed in a state that a run has left: those without a gap whose balls have the same speed."""
    p = behind(system_at(system))
    for k in range(p.ball_count):
        for kind in (NEXT, BEHIND, AHEAD):
            if exists(p, kind, k):
                touches = gap(y, p, kind, k) < NEAR and opening(y, p, kind, k) == 0.0
                close(p, kind, k, 1 if touches else 0)
    count_bound(system)
    open_pulling(time, y, rates, system)
