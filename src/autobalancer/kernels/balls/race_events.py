"""Balls that come to rest on their race and leave it again: found inside a step, so that rest is exact.

A ball rolls with the sign ``MODE`` of its speed, by which rolling resistance works; where its speed reaches zero it rests
if adherence can hold it (|NEED| <= mu L N), else it rolls the way it is pushed. A ball at rest leaves where adherence
can hold it no longer.
"""

from __future__ import annotations

import math
from typing import Any

from autobalancer.kernels.balls.guided import orbit
from autobalancer.kernels.balls.rigid_impacts import (
    NEAR,
    Limits,
    at_rest,
    close,
    count_bound,
    exists,
    free_of_contacts,
    gap,
    is_closed,
    is_loose,
    opening,
    rubs,
    settle,
    thin,
)
from autobalancer.kernels.balls.rigid_torques import FAR, LEAST, NOW, OWN_PULL, PULL, WHEN, capacity
from autobalancer.kernels.compiler.flags import ADDRESSED, INLINE, PART, njit
from autobalancer.kernels.compiler.numba_struct import data, deref
from autobalancer.kernels.integrators.dense_output import component, evaluate, polynomials
from autobalancer.kernels.integrators.integrator_state import (
    ACCEPTED,
    CUT,
    DUE,
    EVALUATIONS,
    FORGET,
    PASS,
    SHORTEST,
    TAKE,
    TAKEN,
    Memory,
    pair_at,
)
from autobalancer.kernels.integrators.tableau import Tableau
from autobalancer.kernels.records import (
    AHEAD,
    BALL_STATES,
    BALL_VX,
    BALL_VY,
    BALL_X,
    BALL_Y,
    BEHIND,
    INNER,
    NEXT,
    NONE,
    OTHER_BALL,
    SIDES,
)
from autobalancer.kernels.system import BALLS, SPEED, System, system_at

INDICATE, HAPPEN = SHORTEST + 1, SHORTEST + 2  # what another program asks that integrates the machine itself
PIECES = 16  # into which a step is cut in search of a ball that turns round and back
SHORT = 1e-8  # rad of rotor angle in the shortest step for the sake of a ball that breaks loose


@njit(**ADDRESSED)
def adherence(ask: int, time: float, rates: Any, parameters: Any, pair: Any) -> float:
    """The switch of guided balls on real races."""
    pair = pair_at(pair)
    p, (t, m) = deref(system_at(parameters)), deref(pair)
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
    elif ask >= INDICATE:
        return _host(ask, time, rates, parameters, pair, False)
    return 0.0


@njit(**INLINE)
def lowest(first: float, last: float, falling: float, rising: float, step: float) -> float:
    """Where the tangents at both ends of a step meet, of a number that falls at its start and rises at its end; else infinite."""
    if falling >= 0.0 or rising <= 0.0:
        return math.inf
    bottom = min(max((last - first - rising * step) / (falling - rising), 0.0), step)
    return first + falling * bottom


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
                due = due or is_loose(p, b)
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
    t, m = deref(pair)
    low, high = 0.0, 1.0
    # its speed has the old sign at both ends: it may have turned round and back in between
    if not way * data(m.state)[place] < 0.0:
        if way == 0.0 or not stopped(place, way, t, m):
            return 2.0
        for piece in range(1, PIECES + 1):
            high = piece / PIECES
            if way * component(place, high, m) < 0.0:
                return _passed(low, high, place, way, m)
            low = high
        return 2.0
    # else from the end backward: the last eighth in which it still moved the old way
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
    (t, m), p = deref(pair), deref(system_at(parameters))
    polynomials(m.state.size, t, m)
    # the first ball that stops, by the zeros of the balls' speeds in the dense output
    first, resting = 1.0, False
    for b in range(p.ball_count):
        mode, place = p.guided[b].mode, BALLS + p.ball_count + b
        if rubs(p.balls[b]):
            resting = resting or mode == 0.0
            first = min(first, crossing(place, mode, pair))
    if first == 0.0:
        return first
    # the first ball at rest that breaks loose until then: bisection with evaluations, as its need follows from the
    # rates, not from the state
    if resting:
        low, high, x = 0.0, first, first
        for _ in range(48):
            evaluate(x, pair, data(m.spare))
            rhs(time + x * m.clock[TAKEN], data(m.spare), data(m.trial), parameters)
            m.counts[EVALUATIONS] += 1
            loose = False
            for b in range(p.ball_count):
                loose = loose or (at_rest(p, b) and is_loose(p, b))
            if loose:
                high = x
            else:
                low = x
            if low == first or high - low < 1e-10:
                break
            x = 0.5 * (low + high)
        first = high
    # who stops by then rests from then on
    for b in range(p.ball_count):
        mode, place = p.guided[b].mode, BALLS + p.ball_count + b
        if rubs(p.balls[b]) and crossing(place, mode, pair) <= first:
            p.guided[b].mode = 0.0
    return first


@njit(**PART)
def _pass(time, rhs, parameters, pair):  # type: ignore[no-untyped-def]
    """At the end of a cut step, which is in ``m.state``: balls that stopped rest or turn round, balls that are loose roll."""
    (_, m), p = deref(pair), deref(system_at(parameters))
    for b in range(p.ball_count):
        if at_rest(p, b):
            m.state[BALLS + p.ball_count + b] = 0.0
    rhs(time, data(m.state), data(m.trial), parameters)
    m.counts[EVALUATIONS] += 1
    for b in range(p.ball_count):
        if at_rest(p, b) and is_loose(p, b):
            p.guided[b].mode = math.copysign(1.0, p.guided[b].need)


# Impacts of balls as a run goes: every contact that begins is noted with its speed, a step later than it began.
#
# The stepper asks for a switch after every step; these look at the state in which the step began, which no retreat
# takes back.


TINY = 1e-30  # m^2, as in resolved_balls.py
SLOWEST = 1e-5  # m/s: balls that rest touch again and again by rounding


@njit(**ADDRESSED)
def impacts_of_guided(ask: int, time: float, rates: Any, parameters: Any, pair: Any) -> float:
    """The switch of guided balls that never stop."""
    if ask == DUE:
        note(time, parameters, pair, False)
    return 0.0


@njit(**ADDRESSED)
def impacts_and_adherence(ask: int, time: float, rates: Any, parameters: Any, pair: Any) -> float:
    """The switch of guided balls on real races."""
    if ask == DUE:
        note(time, parameters, pair, False)
    return adherence(ask, time, rates, parameters, pair)


@njit(**ADDRESSED)
def impacts_of_resolved(ask: int, time: float, rates: Any, parameters: Any, pair: Any) -> float:
    """The switch of resolved balls."""
    if ask == DUE:
        note(time, parameters, pair, True)
    return 0.0


@njit(**INLINE)
def note(time: float, parameters: Any, pair: Any, resolved: bool) -> None:
    """Note the contacts that have begun before the last step; rigid ones are noted where they strike."""
    p, (_, m) = deref(system_at(parameters)), deref(pair_at(pair))
    y = data(m.start)
    for k in range(p.touches.size):
        touch = p.touches[k]
        if resolved:
            depth, approach = _between_resolved(y, p, touch)
        else:
            contact = p.contacts[touch.one]
            if (contact.rigid if touch.kind == NEXT else contact.wall_rigid) != 0:
                continue
            depth, approach = _between_guided(y, p, touch)
        if depth <= 0.0:
            touch.known, touch.approach = 0, approach
            continue
        speed = max(touch.approach, approach)
        if touch.known == 0 and speed > SLOWEST:
            number = p.impact_count[0]
            if number < p.impacts.size:
                p.impacts[number].time, p.impacts[number].speed, p.impacts[number].touch = time, speed, k
            p.impact_count[0] = number + 1
        touch.known = 1


@njit(**INLINE)
def _between_guided(y: Any, p: System, touch: Any) -> tuple[float, float]:
    """By how much a ball overlaps what it may hit (rad), and the speed of approach (m/s)."""
    contact, i = p.contacts[touch.one], touch.one
    angle, rate = y[BALLS + i], y[BALLS + p.ball_count + i]
    if touch.kind == NEXT:
        j = touch.other
        ahead = y[BALLS + j] - angle + contact.wrap
        return contact.touch - ahead, contact.pace * (rate - y[BALLS + p.ball_count + j])
    if touch.kind == BEHIND:
        return contact.wall_low - angle, -contact.wall_pace * rate
    return angle - contact.wall_high, contact.wall_pace * rate


@njit(**INLINE)
def _between_resolved(y: Any, p: System, touch: Any) -> tuple[float, float]:
    """The same of a resolved ball, the overlap in m."""
    first = 2 + 2 * p.host.size + 2 * p.ball_count
    ball, own = p.free_balls[touch.one], first + touch.one * BALL_STATES
    x, z, vx, vz = y[own + BALL_X], y[own + BALL_Y], y[own + BALL_VX], y[own + BALL_VY]
    if touch.kind == OTHER_BALL:
        its, other = first + touch.other * BALL_STATES, p.free_balls[touch.other]
        x, z, vx, vz = y[its + BALL_X] - x, y[its + BALL_Y] - z, y[its + BALL_VX] - vx, y[its + BALL_VY] - vz
        apart = math.sqrt(x * x + z * z + TINY)
        return ball.radius + other.radius - apart, -(vx * x + vz * z) / apart
    if touch.kind == SIDES:
        if ball.partition == NONE:
            return -1.0, 0.0
        part, angle = p.partitions[ball.partition], y[BALLS + touch.one]
        side, px, py = 1.0, part.behind_x, part.behind_y
        if angle > part.middle:
            side, px, py = -1.0, part.ahead_x, part.ahead_y
        if side * (x * py - z * px) <= 0.0:  # beyond the center of the race there is no partition
            return -1.0, 0.0
        return ball.radius - (x * px + z * py), -(vx * px + vz * py)
    away = math.sqrt(x * x + z * z + TINY)
    nx, ny = x / away, z / away
    depth, outward = away - orbit(p.waves, ball, ball.orbit, nx, ny)[0], (vx * x + vz * z) / away
    if touch.kind == INNER:
        return -depth - ball.gap, -outward
    return depth, outward


# The switch of guided balls in rigid contact, with friction too: what closes, opens, stops or breaks loose in a step.


@njit(**ADDRESSED)
def rigid_contact(ask: int, time: float, rates: Any, parameters: Any, pair: Any) -> float:
    """The switch; see :mod:`autobalancer.kernels.integrators.integrator_state`."""
    pair = pair_at(pair)
    p, (t, m) = deref(system_at(parameters)), deref(pair)
    if ask == TAKE:
        _take(time, rates, parameters, pair)
    elif ask == FORGET:
        forget(p, m)
    elif ask == DUE:
        if p.touches.size > 0:
            note(time, parameters, pair, False)
        return 1.0 if _contact_due(p, t, m) else 0.0
    elif ask == CUT:
        return _cut_at_contact(time, rates, parameters, pair)
    elif ask == PASS:
        _pass_contact(time, rates, parameters, pair)
    elif ask == SHORTEST:
        return SHORT / max(1.0, abs(m.start[SPEED]))
    elif ask >= INDICATE:
        return _host(ask, time, rates, parameters, pair, True)
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
    (_, m), p = deref(pair), deref(system_at(parameters))
    if m.counts[ACCEPTED] == 0:
        p.rigid.bound[1], p.rigid.margin[WHEN], p.rigid.margin[PULL] = 0, -1.0, p.rigid.margin[OWN_PULL]
        for k in range(p.ball_count):
            for kind in (NEXT, BEHIND, AHEAD):
                if exists(p, kind, k):
                    close(p, kind, k, 0)
        count_bound(parameters)
        take(p, m)
        m.counts[EVALUATIONS] += settle(time, data(m.state), rates, parameters, m.state.size, NEAR, _limits(p, m))
        return
    take(p, m)
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
def _contact_due(p: System, t: Tableau, m: Memory) -> bool:
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
    (_, m), p = deref(pair), deref(system_at(parameters))
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
    (_, m), p = deref(pair), deref(system_at(parameters))
    evaluate(x, pair, data(m.spare))
    p.rigid.margin[NOW] = FAR
    rates(time + x * m.clock[TAKEN], data(m.spare), data(m.trial), parameters)
    m.counts[EVALUATIONS] += 1
    loose = p.rigid.margin[NOW] < -2.0 * p.rigid.margin[PULL]
    for k in range(p.ball_count):
        if at_rest(p, k) and p.guided[k].bound == 0:
            loose = loose or is_loose(p, k)
    return loose


@njit(**PART)
def _opening_place(first, time, rates, parameters, pair):  # type: ignore[no-untyped-def]
    """The fraction of the step, up to ``first``, after which the first contact opens or ball breaks loose."""
    _, p = deref(pair), deref(system_at(parameters))
    resting = p.rigid.bound[0] > 0
    for k in range(p.ball_count):
        resting = resting or at_rest(p, k)
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
def _cut_at_contact(time, rates, parameters, pair):  # type: ignore[no-untyped-def]
    """The fraction of the step after which the first change comes; balls that stop there get the mode of rest.

    It is 0 where a ball that broke loose seems to turn back at once: the step is too long for its motion.
    """
    (t, m), p = deref(pair), deref(system_at(parameters))
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
def _pass_contact(time, rates, parameters, pair):  # type: ignore[no-untyped-def]
    """At the end of the step that was cut, which is in ``m.state``: impacts, balls that stop or roll, contacts that open."""
    (_, m), p = deref(pair), deref(system_at(parameters))
    for k in range(p.ball_count):
        if at_rest(p, k):
            m.state[BALLS + p.ball_count + k] = 0.0
    stands = time - p.rigid.margin[WHEN] <= 1e-2 * SHORT / max(1.0, abs(m.state[SPEED]))
    p.rigid.bound[1] = p.rigid.bound[1] + 1 if stands else 0
    p.rigid.margin[WHEN] = time
    p.rigid.margin[PULL] = p.rigid.margin[OWN_PULL] * 2.0 ** min(max(p.rigid.bound[1] - 30, 0), 40)
    m.counts[EVALUATIONS] += settle(time, data(m.state), rates, parameters, m.state.size, 0.0, _limits(p, m))


# For another program that integrates the machine itself and looks for events by the sign of indicators.


@njit(**PART)
def _host(ask, time, rates, parameters, pair, rigid):  # type: ignore[no-untyped-def]
    """INDICATE puts numbers into ``m.stages`` that are positive until something is due in ``m.state``; returns how many.

    HAPPEN makes what is due there, and chooses the equations that follow; returns whether the state changed. A speed or a
    gap is due a tenth of its tolerance beyond zero, so that one that begins at zero is not. A flight that is lower than ten
    times the tolerance is not flown, as the other program would find its end by chance; ``m.absolute`` is of its tolerance.
    """
    (_, m), p = deref(pair), deref(system_at(parameters))
    state, before, n, far, changed = data(m.state), data(m.start), p.ball_count, 1.0, 0.0
    if ask == INDICATE:
        return _indicate(time, rates, parameters, pair, rigid)
    for i in range(m.state.size):
        before[i] = state[i]
    # what has stopped or gone too deep; at the start also what is as good as closed
    first = m.counts[ACCEPTED] == 0
    m.counts[ACCEPTED] = 1
    for k in range(n):
        far = max(far, abs(state[BALLS + k]))
        moving, place = p.guided[k], BALLS + n + k
        if rubs(p.balls[k]) and moving.mode * state[place] < 0.0:
            moving.mode, state[place] = 0.0, 0.0
        elif rubs(p.balls[k]) and state[place] != 0.0:
            moving.mode = math.copysign(1.0, state[place])
        for kind in (NEXT, BEHIND, AHEAD):
            if exists(p, kind, k) and not is_closed(p, kind, k):
                deep = max(0.0, -gap(state, p, kind, k))
                state[BALLS + k] += deep * (-0.5 if kind == NEXT else 1.0 if kind == BEHIND else -1.0)
                state[BALLS + p.contacts[k].next] += 0.5 * deep if kind == NEXT else 0.0
    if rigid:
        limits = Limits(0.1 * m.absolute[BALLS + n], 10.0 * m.absolute[BALLS] * far)
        if first:
            free_of_contacts(parameters)
            count_bound(parameters)
        settle(time, state, rates, parameters, m.state.size, NEAR if first else 0.0, limits)
    else:
        rates(time, state, data(m.trial), parameters)
        for k in range(n):
            if at_rest(p, k) and is_loose(p, k):
                p.guided[k].mode = math.copysign(1.0, p.guided[k].need)
    for i in range(m.state.size):
        changed = 1.0 if state[i] != before[i] else changed
    return changed


@njit(**PART)
def _indicate(time, rates, parameters, pair, rigid):  # type: ignore[no-untyped-def]
    (_, m), p = deref(pair), deref(system_at(parameters))
    n, count, state, found = p.ball_count, 0, data(m.state), data(m.stages)
    slow, low, margin = 0.1 * m.absolute[BALLS + n], 0.1 * m.absolute[BALLS], data(p.rigid.margin)
    margin[NOW] = FAR
    rates(time, state, data(m.trial), parameters)
    for k in range(n):
        moving = p.guided[k]
        if rubs(p.balls[k]):
            held = (1.0 + 1e-9) * capacity(p, k) - abs(moving.need) + 1e-300 if moving.bound == 0 else 1.0
            found[count] = held if moving.mode == 0.0 else moving.mode * state[BALLS + n + k] + slow
            count += 1
        for kind in (NEXT, BEHIND, AHEAD):
            if exists(p, kind, k):
                found[count] = 1.0 if is_closed(p, kind, k) else gap(state, p, kind, k) + low
                count += 1
    if rigid:  # what presses least of all contacts that are closed
        found[count] = min(margin[NOW] + 2.0 * margin[PULL], 1.0)
        count += 1
    return float(count)
