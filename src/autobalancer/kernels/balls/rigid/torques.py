"""Torques of rigid contacts, once the accelerations are known.

They follow ball by ball along a row from f_k - I_k phi'', see clusters.py. Balls at rest by adherence leave them open: there
``least`` and ``most`` say what a ball may pass on to the next one.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from autobalancer.kernels.balls.rigid.clusters import leads, link
from autobalancer.kernels.flags import APART, INLINE, njit
from autobalancer.kernels.pointers import behind, data
from autobalancer.kernels.system import BALLS, System, system_at

ROUNDING = 1.0 + 1e-9  # as in switches.py
# places in Rigid.margin: least torque of a contact now, since a look, the one that counts as a pull, that one as assembled
# (N m); time of the last change (s)
NOW, LEAST, PULL, OWN_PULL, WHEN = range(5)
FAR = 1e300


class Place(NamedTuple):
    """Accelerations of a station and its slope."""

    x: float
    y: float
    u: float
    v: float


@njit(**APART)
def press(y: Any, dy: Any, system: Any, acceleration: float) -> bool:
    """Torques of all contacts, once accelerations are known; whether a ball was taken to rub the wrong way."""
    p, wrong = behind(system_at(system)), False
    each, one = p.work.inert.shape[1], data(p.work.one)
    p.rigid.margin[NOW] = FAR
    for head in range(p.ball_count):
        if leads(p, head):
            at = p.balls[head].station * each
            u, v = (one[at + 2], one[at + 3]) if each == 4 else (0.0, 0.0)
            last = _remainders(y, dy, p, head, Place(one[at], one[at + 1], u, v), acceleration)
            _torques(system, head, last)
            wrong |= _pressed(y, p, head)
    p.rigid.margin[LEAST] = min(p.rigid.margin[LEAST], p.rigid.margin[NOW])
    return wrong


@njit(**APART)
def press_planar(y: Any, dy: Any, system: Any, x: float, y_: float, acceleration: float) -> None:
    """The same on a planar rotor, whose races have the acceleration (x, y_)."""
    p = behind(system_at(system))
    p.rigid.margin[NOW] = FAR
    for head in range(p.ball_count):
        if leads(p, head):
            last = _remainders(y, dy, p, head, Place(x, y_, 0.0, 0.0), acceleration)
            _torques(system, head, last)
    p.rigid.margin[LEAST] = min(p.rigid.margin[LEAST], p.rigid.margin[NOW])


@njit(**INLINE)
def _remainders(y: Any, dy: Any, p: System, head: int, at: Place, acceleration: float) -> int:
    """Find f_k - I_k phi'' of the balls of a cluster, give all the same phi'', and return the last."""
    place, k, last, more = BALLS + p.ball_count, head, head, True
    rate = dy[place + head]
    while more:
        its = p.ties[k]
        free = its.push - its.spin * acceleration - its.x * at.x - its.y * at.y - its.u * at.u - its.v * at.v
        its.rest = free - its.inertia * rate
        dy[place + k] = rate
        last, more = k, its.joined == 1
        k = p.contacts[k].next
    return last


@njit(**APART)
def _torques(system: Any, head: int, last: int) -> None:
    """Torques of the contacts of a cluster from what its balls lack; the least of them counts."""
    p = behind(system_at(system))
    first, end, margin = p.ties[head], p.ties[last], p.rigid.margin
    low, high = first.low != 0, end.high != 0
    first.press_low, end.press_high = 0.0, 0.0
    if p.guided[head].mode == 0.0:
        _held(system, head, last)
        return
    least = FAR
    if low and not high:
        k, carried = last, 0.0
        while k != head:
            carried -= p.ties[k].rest
            before = p.ties[p.contacts[k].before]
            before.press = carried / before.ahead
            least, carried = min(least, before.press), before.press * before.back
            k = p.contacts[k].before
        first.press_low = carried - first.rest
        margin[NOW] = min(margin[NOW], least, first.press_low)
        return
    k, carried = head, 0.0
    while k != last:
        its = p.ties[k]
        its.press = (its.rest + carried) / its.back
        least, carried = min(least, its.press), its.press * its.ahead
        k = p.contacts[k].next
    if high:
        end.press_high = end.rest + carried
        least = min(least, end.press_high)
    full = end.joined == 2
    if full or (low and high):  # a row without play: the least torques that press everywhere
        more = max(0.0, -least)
        k = head
        while k != last:
            p.ties[k].press += more
            k = p.contacts[k].next
        if full:
            end.press = more
        else:
            first.press_low, end.press_high = more, end.press_high + more
        return
    margin[NOW] = min(margin[NOW], least)


@njit(**INLINE)
def capacity(p: System, k: int) -> float:
    """Greatest torque that adherence has against the motion of a ball at rest, but for what its contacts press."""
    ball, moving = p.balls[k], p.guided[k]
    length = math.sqrt(moving.held_lean_x**2 + moving.held_lean_y**2) / ball.mass
    return float(ROUNDING * ball.adherence * length * max(moving.normal, -ball.pulls * moving.normal, 0.0))


@njit(**APART)
def _held(system: Any, head: int, last: int) -> None:
    """What each ball of a row at rest may pass on to the next one, from the first on; below 0 the row cannot rest."""
    p = behind(system_at(system))
    first, margin = p.ties[head], p.rigid.margin
    least, most = 0.0, FAR if first.low != 0 else 0.0
    out_before, pushed, kept = 0.0, 0.0, 0.0
    k, more = head, True
    while more:
        its, ball, pair = p.ties[k], p.balls[k], p.contacts[k]
        held, more = capacity(p, k), k != last
        grip = ROUNDING * ball.adherence * ball.orbit * (1.0 - ball.pulls)
        out = pair.out if more else 0.0
        most = FAR if most == FAR else (its.rest + held + (1.0 + grip * out_before) * most) / (1.0 - grip * out)
        least = max(its.rest - held + (1.0 - grip * out_before) * least, 0.0) / (1.0 + grip * out)
        its.least, its.most, its.press, out_before = least, most, least, pair.out_next
        pushed += its.rest
        kept += held
        k = pair.next
    end = p.ties[last]
    end.press = 0.0
    if end.joined == 2:  # all around the race: only the whole ring can move
        margin[NOW] = min(margin[NOW], kept - abs(pushed))
        return
    k, more = head, True
    while more:
        margin[NOW] = min(margin[NOW], p.ties[k].most)
        more = k != last
        k = p.contacts[k].next
    if end.high != 0:
        end.press_high = least
    else:
        margin[NOW] = min(margin[NOW], -least)


@njit(**INLINE)
def _pressed(y: Any, p: System, head: int) -> bool:
    """Add what contacts press on the wall to the normal forces; whether one was taken to have the other sign."""
    wrong, k, more = False, head, True
    while more:
        its, j = p.ties[k], p.contacts[k].next
        more = its.joined == 1
        if its.joined != 0:
            at = link(y, p, k)
            p.guided[k].normal += its.press * at.out
            p.guided[j].normal += its.press * at.out_next
        k = j
    k, more = head, True
    while more:
        ball, moving = p.balls[k], p.guided[k]
        rubs = ball.rolling > 0.0 and moving.mode != 0.0
        wrong = wrong or (rubs and (moving.normal > 0.0) != (moving.normal_push > 0.0))
        more = p.ties[k].joined == 1
        k = p.contacts[k].next
    return wrong
