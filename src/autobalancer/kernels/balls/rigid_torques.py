"""Guided balls in rigid contact: balls of a race that touch have one acceleration, so they enter the equations as one ball.

With the torque l_k >= 0 of the contact between ball k and the next one, friction between them and what both press on the wall
included, the rows of such a cluster read

    I_k phi'' = f_k - a_k l_k + b_(k-1) l_(k-1),    f_k = push - spin w' - lean.A,    a = b = 1 without friction.

Multiplied by weights g with g_(k+1) b_k = g_k a_k their sum has no torque of a contact: phi'' = sum g f / sum g I. Balls
beside a partition, and those that adherence holds, have phi'' = 0. The torques follow from the rows, see below.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from autobalancer.kernels.balls.guided import Row
from autobalancer.kernels.compiler.flags import APART, INLINE, njit
from autobalancer.kernels.compiler.numba_struct import data, deref
from autobalancer.kernels.records import PRESCRIBED
from autobalancer.kernels.system import BALLS, System, system_at


class Link(NamedTuple):
    """What the contact of a ball with the next one does, over its torque."""

    back: float  # torque against the ball
    ahead: float  # torque on the next one
    out: float  # force that presses the ball on the wall, 1/m
    out_next: float  # force that presses the next one on the wall, 1/m


@njit(**INLINE)
def keep(its: Any, felt: Row, inertia: float, arm: float) -> None:
    """Keep the row of a ball until its cluster is complete; ``arm`` is that of rolling resistance."""
    its.push, its.spin, its.x, its.y, its.u, its.v = felt.push, felt.spin, felt.x, felt.y, felt.u, felt.v
    its.inertia, its.arm = inertia, arm


@njit(**INLINE)
def link(y: Any, p: System, k: int) -> Link:
    """The contact of ball k with the next one; friction by its slip."""
    pair, rub = p.contacts[k], 0.0
    if pair.rub > 0.0:
        rate, its = y[BALLS + p.ball_count + k], y[BALLS + p.ball_count + pair.next]
        rub = pair.rub * math.tanh((pair.arm * rate + pair.arm_next * its) * pair.grip)
    j = pair.next
    return Link(
        1.0 + pair.arm * rub, 1.0 - pair.arm_next * rub,
        pair.out - rub / p.balls[k].orbit, pair.out_next + rub / p.balls[j].orbit,
    )  # fmt: skip


@njit(**INLINE)
def leads(p: System, k: int) -> bool:
    """Whether a cluster begins with this ball."""
    return bool(p.guided[k].bound != 0 and p.ties[k].follows == 0)


@njit(**INLINE)
def _common(y: Any, p: System, head: int, acceleration: float) -> tuple[Row, Row]:
    """Sum of the rows without friction, and the row of a cluster solved for phi''; tells it to its balls."""
    # along the cluster: each row is weighed so that the torques of the contacts cancel in the sum
    k, weight, held = head, 1.0, p.ties[head].low != 0
    total, push, spin, x, y_, u, v = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    own_push, own_spin, own_x, own_y, own_u, own_v = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    more = True
    while more:
        its, moving = p.ties[k], p.guided[k]
        held = held or its.high != 0 or moving.mode == 0.0
        total += weight * its.inertia
        push += weight * (its.push - its.spin * acceleration)
        spin += weight * its.spin
        x += weight * its.x
        y_ += weight * its.y
        u += weight * its.u
        v += weight * its.v
        own_push += moving.held_push
        own_spin += moving.held_twist
        own_x += moving.held_lean_x
        own_y += moving.held_lean_y
        own_u += moving.held_lean_u
        own_v += moving.held_lean_v
        more = its.joined == 1
        if more:
            j = p.contacts[k].next
            at = link(y, p, k)
            its.back, its.ahead = at.back + its.arm * at.out, at.ahead - p.ties[j].arm * at.out_next
            weight *= its.back / its.ahead
            k = j
    # phi'' of the cluster; at a partition, or where adherence holds a ball, it is zero
    inverse = 0.0 if held else 1.0 / total
    found = Row(push * inverse, spin * inverse, x * inverse, y_ * inverse, u * inverse, v * inverse)
    k, more = head, True
    while more:
        moving = p.guided[k]
        moving.push, moving.twist = found.push, found.spin
        moving.lean_x, moving.lean_y, moving.lean_u, moving.lean_v = found.x, found.y, found.u, found.v
        more = p.ties[k].joined == 1
        k = p.contacts[k].next
    return Row(own_push, own_spin, own_x, own_y, own_u, own_v), found


@njit(**APART)
def bind(y: Any, system: Any, acceleration: float) -> tuple[float, float]:
    """Put all clusters into their stations; returns their torque and inertia there."""
    p = deref(system_at(system))
    each, torque, inertia = p.work.inert.shape[1], 0.0, 0.0
    push, arm, turn, inert = data(p.work.push), data(p.work.arm), data(p.work.turn), data(p.work.inert)
    for head in range(p.ball_count):
        if not leads(p, head):
            continue
        # the station feels the cluster as one ball with the sum of the rows: R, c and S lose the part of phi''
        own, found = _common(y, p, head, acceleration)
        mine, its = (own.x, own.y, own.u, own.v), (found.x, found.y, found.u, found.v)
        at = p.balls[head].station * each
        for i in range(each):
            push[at + i] -= mine[i] * found.push
            if p.drive.kind != PRESCRIBED:
                arm[at + i] -= mine[i] * found.spin
                turn[at + i] -= own.spin * its[i]
            for j in range(each):
                inert[(at + i) * each + j] -= mine[i] * its[j]
        torque -= own.spin * found.push
        inertia -= own.spin * found.spin
    return torque, inertia


@njit(**APART)
def bind_planar(y: Any, system: Any) -> tuple[float, float, float, float, float, float, float, float, float]:
    """What all clusters take from the rows of a planar rotor: mass xx, xy, yy, force x, y, arm x, y, inertia and torque."""
    p = deref(system_at(system))
    xx, xy, yy, fx, fy, ax, ay, inertia, torque = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for head in range(p.ball_count):
        if not leads(p, head):
            continue
        _, found = _common(y, p, head, 0.0)
        k, more = head, True
        while more:
            # each ball with its own row times the common phi''
            its = p.ties[k]
            xx += its.x * found.x
            xy += its.x * found.y
            yy += its.y * found.y
            fx += its.x * found.push
            fy += its.y * found.push
            ax += its.x * found.spin
            ay += its.y * found.spin
            inertia += its.spin * found.spin
            torque += its.spin * found.push
            more = its.joined == 1
            k = p.contacts[k].next
    return xx, xy, yy, fx, fy, ax, ay, inertia, torque


# Torques of rigid contacts, once the accelerations are known.
#
# They follow ball by ball along a row from f_k - I_k phi'', see above. Balls at rest by adherence leave them
# open: there ``least`` and ``most`` say what a ball may pass on to the next one.


ROUNDING = 1.0 + 1e-9  # a ball leaves its rest with an acceleration whose sign is not one of rounding
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
    p, wrong = deref(system_at(system)), False
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
    p = deref(system_at(system))
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
    p = deref(system_at(system))
    first, end, margin = p.ties[head], p.ties[last], p.rigid.margin
    low, high = first.low != 0, end.high != 0
    first.press_low, end.press_high = 0.0, 0.0
    if p.guided[head].mode == 0.0:
        _held(system, head, last)
        return
    # from the free end on: each contact carries what the balls beyond it lack
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
    # the other way where the row is free behind, or closed at both ends
    k, carried = head, 0.0
    while k != last:
        its = p.ties[k]
        its.press = (its.rest + carried) / its.back
        least, carried = min(least, its.press), its.press * its.ahead
        k = p.contacts[k].next
    if high:
        end.press_high = end.rest + carried
        least = min(least, end.press_high)
    # a ring or a row between partitions may press by any amount more
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
    p = deref(system_at(system))
    first, margin = p.ties[head], p.rigid.margin
    least, most = 0.0, FAR if first.low != 0 else 0.0
    out_before, pushed, kept = 0.0, 0.0, 0.0
    k, more = head, True
    while more:
        its, ball, pair = p.ties[k], p.balls[k], p.contacts[k]
        # what a ball may pass on: between what it must, and what adherence lets it take against it; what the neighbor
        # presses it on the wall adds to the grip on both sides
        held, more = capacity(p, k), k != last
        grip = ROUNDING * ball.adherence * ball.orbit * (1.0 - ball.pulls)
        out = pair.out if more else 0.0
        most = FAR if most == FAR else (its.rest + held + (1.0 + grip * out_before) * most) / (1.0 - grip * out)
        least = max(its.rest - held + (1.0 - grip * out_before) * least, 0.0) / (1.0 + grip * out)
        its.least, its.most, its.press, out_before = least, most, least, pair.out_next
        pushed += its.rest
        kept += held
        k = pair.next
    # the row rests if each interval is not empty and its free end need not press
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
    # rolling resistance was taken with the sign of the known part of the normal force; was that right?
    k, more = head, True
    while more:
        ball, moving = p.balls[k], p.guided[k]
        rubs = ball.rolling > 0.0 and moving.mode != 0.0
        wrong = wrong or (rubs and (moving.normal > 0.0) != (moving.normal_push > 0.0))
        more = p.ties[k].joined == 1
        k = p.contacts[k].next
    return wrong
