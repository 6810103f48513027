"""The switch of guided balls in rigid contact, with friction too: what closes, opens, stops or breaks loose in a step."""

from __future__ import annotations

from typing import Any

from autobalancer.kernels.balls.impacts import note
from autobalancer.kernels.balls.rigid.closed import (
    close,
    count_bound,
    exists,
    gap,
    is_closed,
    opening,
    thin,
)
from autobalancer.kernels.balls.rigid.stay import NEAR, Limits, is_loose, settle
from autobalancer.kernels.balls.rigid.torques import FAR, LEAST, NOW, OWN_PULL, PULL, WHEN
from autobalancer.kernels.balls.switches import SHORT, crossing, lowest, rubs, stopped
from autobalancer.kernels.balls.switches import forget as forget_modes
from autobalancer.kernels.balls.switches import take as take_modes
from autobalancer.kernels.flags import ADDRESSED, INLINE, PART, njit
from autobalancer.kernels.integrators.dense import component, evaluate, polynomials
from autobalancer.kernels.integrators.memory import ACCEPTED, EVALUATIONS, TAKEN, Memory
from autobalancer.kernels.integrators.switching import CUT, DUE, FORGET, PASS, SHORTEST, TAKE, pair_at
from autobalancer.kernels.integrators.tableau import Tableau
from autobalancer.kernels.pointers import behind, data
from autobalancer.kernels.records.impacts import AHEAD, BEHIND, NEXT
from autobalancer.kernels.system import BALLS, SPEED, System, system_at

PIECES = 16  # into which a step is cut in search of contacts that close


@njit(**ADDRESSED)
def rigid_contact(ask: int, time: float, rates: Any, parameters: Any, pair: Any) -> float:
    """The switch; see :mod:`autobalancer.kernels.integrators.switching`."""
    pair = pair_at(pair)
    p, (t, m) = behind(system_at(parameters)), behind(pair)
    if ask == TAKE:
        _take(time, rates, parameters, pair)
    elif ask == FORGET:
        forget_modes(p, m)
    elif ask == DUE:
        if p.touches.size > 0:
            note(time, parameters, pair, False)
        return 1.0 if _due(p, t, m) else 0.0
    elif ask == CUT:
        return _cut(time, rates, parameters, pair)
    elif ask == PASS:
        _pass(time, rates, parameters, pair)
    elif ask == SHORTEST:
        return SHORT / max(1.0, abs(m.start[SPEED]))
    return 0.0


@njit(**INLINE)
def _limits(p: System, m: Memory) -> Limits:
    """A flight has to be higher than the digits of an angle can tell; where time stands still, limits grow until it goes on."""
    wider = p.rigid.margin[PULL] / p.rigid.margin[OWN_PULL]
    low = max(1e-3 * m.absolute[BALLS], 10.0 * thin(data(m.state), 0))
    return Limits(0.1 * wider * m.absolute[BALLS + p.ball_count], wider * low)


@njit(**PART)
def _take(time, rates, parameters, pair):  # type: ignore[no-untyped-def]
    """Look who touches at the start; later only whether a contact that is closed would pull, as the drive has changed."""
    (_, m), p = behind(pair), behind(system_at(parameters))
    if m.counts[ACCEPTED] == 0:
        p.rigid.bound[1], p.rigid.margin[WHEN], p.rigid.margin[PULL] = 0, -1.0, p.rigid.margin[OWN_PULL]
        for k in range(p.ball_count):
            for kind in (NEXT, BEHIND, AHEAD):
                if exists(p, kind, k):
                    close(p, kind, k, 0)
        count_bound(parameters)
        take_modes(p, m)
        m.counts[EVALUATIONS] += settle(time, data(m.state), rates, parameters, m.state.size, NEAR, _limits(p, m))
        return
    take_modes(p, m)
    if p.rigid.bound[0] > 0:
        p.rigid.margin[NOW] = FAR
        rates(time, data(m.state), data(p.rigid.base), parameters)
        m.counts[EVALUATIONS] += 1
        if p.rigid.margin[NOW] < -2.0 * p.rigid.margin[PULL]:
            m.counts[EVALUATIONS] += settle(time, data(m.state), rates, parameters, m.state.size, 0.0, _limits(p, m))
    p.rigid.margin[LEAST] = FAR


@njit(**INLINE)
def _dips(start: Any, end: Any, p: System, kind: int, k: int, step: float) -> bool:
    """Whether a gap that is open at both ends of a step may have closed in between: where its tangents say so."""
    first, last = gap(start, p, kind, k), gap(end, p, kind, k)
    return bool(lowest(first, last, opening(start, p, kind, k), opening(end, p, kind, k), step) < 0.0)


@njit(**INLINE)
def _due(p: System, t: Tableau, m: Memory) -> bool:
    """Whether something closed, opened, stopped or broke loose in the step just taken, whose end was evaluated last."""
    due, state, start = p.rigid.margin[LEAST] < -2.0 * p.rigid.margin[PULL], data(m.state), data(m.start)
    for k in range(p.ball_count):
        ball, moving = p.balls[k], p.guided[k]
        if rubs(ball):
            if moving.mode != 0.0:
                due = due or stopped(BALLS + p.ball_count + k, moving.mode, t, m)
            elif moving.bound == 0:
                due = due or is_loose(p, k)
        for kind in (NEXT, BEHIND, AHEAD):
            if exists(p, kind, k) and not is_closed(p, kind, k):
                due = due or gap(state, p, kind, k) < -thin(state, k) or _dips(start, state, p, kind, k, m.clock[TAKEN])
    if not due:
        p.rigid.margin[LEAST] = FAR
    return bool(due)


@njit(**INLINE)
def _gap_inside(x: float, p: System, m: Memory, kind: int, k: int) -> float:
    """A gap at the fraction x of the step."""
    pair, angle = p.contacts[k], component(BALLS + k, x, m)
    if kind == NEXT:
        return float(component(BALLS + pair.next, x, m) - angle + pair.wrap - pair.touch)
    return float(angle - pair.wall_low if kind == BEHIND else pair.wall_high - angle)


@njit(**PART)
def _closing(kind, k, parameters, pair):  # type: ignore[no-untyped-def]
    """The fraction of the step at which a gap closes first, 2 if it does not."""
    (_, m), p = behind(pair), behind(system_at(parameters))
    low, none = 0.0, thin(data(m.start), k)
    for piece in range(1, PIECES + 1):
        high = piece / PIECES
        if _gap_inside(high, p, m, kind, k) < -none:
            middle = 0.5 * (low + high)
            while low < middle < high:
                if _gap_inside(middle, p, m, kind, k) < -none:
                    high = middle
                else:
                    low = middle
                middle = 0.5 * (low + high)
            return high
        low = high
    return 2.0


@njit(**PART)
def _pulls(x, time, rates, parameters, pair):  # type: ignore[no-untyped-def]
    """Whether at the fraction x a contact pulls, or a ball at rest breaks loose."""
    (_, m), p = behind(pair), behind(system_at(parameters))
    evaluate(x, pair, data(m.spare))
    p.rigid.margin[NOW] = FAR
    rates(time + x * m.clock[TAKEN], data(m.spare), data(m.trial), parameters)
    m.counts[EVALUATIONS] += 1
    loose = p.rigid.margin[NOW] < -2.0 * p.rigid.margin[PULL]
    for k in range(p.ball_count):
        if rubs(p.balls[k]) and p.guided[k].mode == 0.0 and p.guided[k].bound == 0:
            loose = loose or is_loose(p, k)
    return loose


@njit(**PART)
def _opening_place(first, time, rates, parameters, pair):  # type: ignore[no-untyped-def]
    """The fraction of the step, up to ``first``, after which the first contact opens or ball breaks loose."""
    _, p = behind(pair), behind(system_at(parameters))
    resting = p.rigid.bound[0] > 0
    for k in range(p.ball_count):
        resting = resting or (rubs(p.balls[k]) and p.guided[k].mode == 0.0)
    if not resting:
        return first
    pieces = 8 if p.rigid.bound[0] > 0 else 1
    low, high, found = 0.0, first, False
    for piece in range(1, pieces + 1):
        high = first * piece / pieces
        if _pulls(high, time, rates, parameters, pair):
            found = True
            break
        low = high
    if not found:
        return first
    while high - low > 1e-10:
        middle = 0.5 * (low + high)
        if _pulls(middle, time, rates, parameters, pair):
            high = middle
        else:
            low = middle
    return high


@njit(**PART)
def _cut(time, rates, parameters, pair):  # type: ignore[no-untyped-def]
    """The fraction of the step after which the first change comes; balls that stop there get the mode of rest.

    It is 0 where a ball that broke loose seems to turn back at once: the step is too long for its motion.
    """
    (t, m), p = behind(pair), behind(system_at(parameters))
    polynomials(m.state.size, t, m)
    first = 1.0
    for k in range(p.ball_count):
        for kind in (NEXT, BEHIND, AHEAD):
            if exists(p, kind, k) and not is_closed(p, kind, k):
                first = min(first, _closing(kind, k, parameters, pair))
    for k in range(p.ball_count):
        mode, place = p.guided[k].mode, BALLS + p.ball_count + k
        if rubs(p.balls[k]):
            first = min(first, crossing(place, mode, pair))
    if first == 0.0:
        return first
    first = _opening_place(first, time, rates, parameters, pair)
    for k in range(p.ball_count):
        mode, place = p.guided[k].mode, BALLS + p.ball_count + k
        if rubs(p.balls[k]) and crossing(place, mode, pair) <= first:
            p.guided[k].mode = 0.0
    return first


@njit(**PART)
def _pass(time, rates, parameters, pair):  # type: ignore[no-untyped-def]
    """At the end of the step that was cut, which is in ``m.state``: impacts, balls that stop or roll, contacts that open."""
    (_, m), p = behind(pair), behind(system_at(parameters))
    for k in range(p.ball_count):
        if rubs(p.balls[k]) and p.guided[k].mode == 0.0:
            m.state[BALLS + p.ball_count + k] = 0.0
    stands = time - p.rigid.margin[WHEN] <= 1e-2 * SHORT / max(1.0, abs(m.state[SPEED]))
    p.rigid.bound[1] = p.rigid.bound[1] + 1 if stands else 0
    p.rigid.margin[WHEN] = time
    p.rigid.margin[PULL] = p.rigid.margin[OWN_PULL] * 2.0 ** min(max(p.rigid.bound[1] - 30, 0), 40)
    m.counts[EVALUATIONS] += settle(time, data(m.state), rates, parameters, m.state.size, 0.0, _limits(p, m))
