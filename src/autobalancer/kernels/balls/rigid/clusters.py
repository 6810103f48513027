"""Guided balls in rigid contact: balls of a race that touch have one acceleration, so they enter the equations as one ball.

With the torque l_k >= 0 of the contact between ball k and the next one, friction between them and what both press on the wall
included, the rows of such a cluster read

    I_k phi'' = f_k - a_k l_k + b_(k-1) l_(k-1),    f_k = push - spin w' - lean.A,    a = b = 1 without friction.

Multiplied by weights g with g_(k+1) b_k = g_k a_k their sum has no torque of a contact: phi'' = sum g f / sum g I. Balls
beside a partition, and those that adherence holds, have phi'' = 0. The torques follow from the rows, torques.py.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from autobalancer.kernels.balls.guided import Row
from autobalancer.kernels.flags import APART, INLINE, njit
from autobalancer.kernels.pointers import behind, data
from autobalancer.kernels.records.drive import PRESCRIBED
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
    p = behind(system_at(system))
    each, torque, inertia = p.work.inert.shape[1], 0.0, 0.0
    push, arm, turn, inert = data(p.work.push), data(p.work.arm), data(p.work.turn), data(p.work.inert)
    for head in range(p.ball_count):
        if not leads(p, head):
            continue
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
    p = behind(system_at(system))
    xx, xy, yy, fx, fy, ax, ay, inertia, torque = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for head in range(p.ball_count):
        if not leads(p, head):
            continue
        _, found = _common(y, p, head, 0.0)
        k, more = head, True
        while more:
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
