"""Which balls touch walls and each other now: what the law of contact needs of them goes into the block."""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from math import sqrt

from numba import njit

from autobalancer.kernels.chamber.block import enter, put_vector
from autobalancer.kernels.chamber.contact import Meeting
from autobalancer.kernels.chamber.records import BLOCK, THETA, TURN_Y, TURN_Z, WALLS
from autobalancer.kernels.chamber.share import act, push_back
from autobalancer.kernels.chamber.vectors import add, cross, dot, minus, plus, put, three, times
from autobalancer.kernels.flags import APART, MERGED
from autobalancer.kernels.pointers import data, row

RACE, AHEAD, BEHIND, INNER = 0, 1, 2, 3  # walls


@njit(**MERGED)
def _meet_wall(chamber, filled, i, wall, line, offset, taken, stiffness, rate, roll):
    ball = row(chamber.balls, i)
    block, radius = chamber.scratch.contacts, ball.radius
    meeting = Meeting(
        line, offset, taken, stiffness, ball.inverse_mass, radius, 0.0, rate, times(radius, roll), roll
    )  # fmt: skip
    enter(block, filled, meeting, i, -1, wall)
    if chamber.contact.has_memory != 0:
        put_vector(block.stretch, filled, three(chamber.wall_stretch[i, wall]))


@njit(**MERGED)
def _change(chamber, i, now):
    """Note which walls ball ``i`` touches ``now``: contacts that begin count, springs of those that end are forgotten."""
    ball = row(chamber.balls, i)
    before = ball.touches
    if now == before:
        return
    ball.touches = now
    for wall in range(WALLS):
        if (now & ~before) >> wall & 1:
            chamber.since.contacts_wall += 1
        if (before & ~now) >> wall & 1:
            put(chamber.wall_stretch[i, wall], (0.0, 0.0, 0.0))


@njit(**MERGED)
def turning(body, axis):
    """Rate of rotation of the chambers: the spin, and tilting; of this the part along x is across the axis."""
    place, rate = body.place, body.rate
    spin = rate[THETA] + place[TURN_Y] * rate[TURN_Z] - place[TURN_Z] * rate[TURN_Y]
    return spin * axis[0], spin * axis[1] + rate[TURN_Y], spin * axis[2] + rate[TURN_Z]


@njit(**APART)
def walls(chamber, axis):
    """Weight and drag of all balls, and their contacts with walls; answers how many of them are left in the block."""
    body = chamber.body
    gravity, middle, velocity = three(chamber.machine.gravity), three(body.place), three(body.rate)
    turn = turning(body, axis)
    filled = 0
    for i in range(chamber.balls.shape[0]):
        ball = row(chamber.balls, i)
        put(ball.force, times(ball.mass, gravity))
        put(ball.moment, (0.0, 0.0, 0.0))
        room = row(chamber.rooms, ball.chamber)
        arm = minus(three(ball.position), middle)
        axial = dot(arm, axis)
        radial = minus(arm, times(axial, axis))
        axial -= room.center
        r = ball.radius
        way = room.wall_radius - r
        half = room.half_depth
        side = abs(axial) + r - half
        square = dot(radial, radial)
        outside = square > way * way
        reach = room.inner_radius + r
        inward = reach > 0.0 and square < reach * reach
        now = 0
        if outside or inward or side > 0.0:
            # against the wall as if it reached to the middle of the ball
            rate = minus(minus(three(ball.velocity), velocity), cross(turn, arm))
            roll = minus(three(ball.spin), turn)
            if outside:
                _meet_wall(chamber, filled, i, RACE, radial, -way, 1.0, ball.race_stiffness, rate, roll)
                filled += 1
                now = 1
            if inward:
                inwards = -radial[0], -radial[1], -radial[2]
                _meet_wall(chamber, filled, i, INNER, inwards, reach, -1.0, ball.inner_stiffness, rate, roll)
                filled += 1
                now += 8
            if side > 0.0:
                sign = 1.0 if axial > 0.0 else -1.0
                wall = AHEAD if axial > 0.0 else BEHIND
                _meet_wall(chamber, filled, i, wall, times(sign, axis), side, 0.0, ball.flat_stiffness, rate, roll)
                filled += 1
                now += 2 * wall
                # a chamber as deep as its balls touches both
                other = r - abs(axial) - half
                if other > 0.0:
                    wall = 3 - wall
                    _meet_wall(
                        chamber, filled, i, wall, times(-sign, axis), other, 0.0, ball.flat_stiffness, rate, roll
                    )
                    filled += 1
                    now += 2 * wall
        _change(chamber, i, now)
        if room.drag != 0.0 or room.square_drag != 0.0:
            # fluid that turns with the chamber
            rate = minus(minus(three(ball.velocity), velocity), cross(turn, arm))
            square = dot(rate, rate)
            part = room.drag + room.square_drag * sqrt(square)
            force = times(-part, rate)
            add(ball.force, force)
            push_back(body, force, cross(arm, force), axis)
            chamber.power.drag += part * square
        if filled > BLOCK - WALLS:
            act(chamber, filled, axis)
            filled = 0
    return filled


@njit(**APART)
def near_pairs(chamber, filled, axis):
    """Contacts of balls with each other, into a block that holds ``filled``; answers how many are left in it."""
    pairs, block = chamber.pairs, chamber.scratch.contacts
    first, second, touching = pairs.first, pairs.second, pairs.touching
    kinds = chamber.pair_stiffness.shape[0]
    table = data(chamber.pair_stiffness)
    remember = chamber.contact.has_memory != 0
    for p in range(chamber.progress.pairs):
        i, j = first[p], second[p]
        one, two = row(chamber.balls, i), row(chamber.balls, j)
        line = minus(three(two.position), three(one.position))
        r1, r2 = one.radius, two.radius
        both = r1 + r2
        if dot(line, line) >= both * both:
            if touching[p] != 0:
                touching[p] = 0
                put(pairs.stretch[p], (0.0, 0.0, 0.0))
            continue
        if touching[p] == 0:
            touching[p] = 1
            chamber.since.contacts_ball += 1
        spin, other = three(one.spin), three(two.spin)
        meeting = Meeting(
            line, both, -1.0, table[one.kind * kinds + two.kind], one.inverse_mass + two.inverse_mass, min(r1, r2),
            1.0 / both, minus(three(one.velocity), three(two.velocity)), plus(times(r1, spin), times(r2, other)),
            minus(spin, other),
        )  # fmt: skip
        enter(block, filled, meeting, i, j, p)
        if remember:
            put_vector(block.stretch, filled, three(pairs.stretch[p]))
        filled += 1
        if filled == BLOCK:
            act(chamber, filled, axis)
            filled = 0
    return filled
