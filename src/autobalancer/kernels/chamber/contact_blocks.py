"""Which balls touch walls and each other now: what the law of contact needs of them goes into the block."""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

from autobalancer.kernels.chamber.chamber_contact import (
    Meeting,
    Vector,
    add,
    cross,
    dot,
    enter,
    minus,
    plus,
    press,
    put,
    put_vector,
    take,
    three,
    times,
    vector,
)
from autobalancer.kernels.chamber.chamber_records import BLOCK, THETA, TURN_Y, TURN_Z, WALLS
from autobalancer.kernels.compiler.flags import APART, MERGED, njit
from autobalancer.kernels.compiler.numba_struct import data, row

# mypy: disable-error-code="no-untyped-def"


RACE, AHEAD, BEHIND, INNER = 0, 1, 2, 3  # walls


class Frame(NamedTuple):
    """Motion of the chambers with body and rotor."""

    middle: Vector  # of the rotor
    velocity: Vector  # of the middle
    axis: Vector  # of the rotor, of length one
    turn: Vector  # rate of rotation


class Sight(NamedTuple):
    """A ball as its chamber sees it."""

    arm: Vector  # from the middle of the rotor
    axial: float  # from the middle of the chamber
    radial: Vector  # from the axis
    rate: Vector  # relative to a wall that reached to the middle of the ball
    roll: Vector  # relative spin


@njit(**MERGED)
def frame(body, axis):
    """The chambers turn with the spin and the tilting body; of the latter the part along x is across the axis."""
    place, rate = body.place, body.rate
    spin = rate[THETA] + place[TURN_Y] * rate[TURN_Z] - place[TURN_Z] * rate[TURN_Y]
    turn = spin * axis[0], spin * axis[1] + rate[TURN_Y], spin * axis[2] + rate[TURN_Z]
    return Frame(three(place), three(rate), axis, turn)


@njit(**MERGED)
def sight(f, center, position, velocity, spin):
    """A ball as a chamber with its middle at ``center`` along the rotor sees it."""
    arm = minus(position, f.middle)
    axial = dot(arm, f.axis)
    radial = minus(arm, times(axial, f.axis))
    rate = minus(minus(velocity, f.velocity), cross(f.turn, arm))
    return Sight(arm, axial - center, radial, rate, minus(spin, f.turn))


@njit(**MERGED)
def drag(linear, square, rate):
    """Force on a ball in fluid that turns with its chamber, and the power lost."""
    fast = dot(rate, rate)
    part = linear + square * sqrt(fast)
    return times(-part, rate), part * fast


@njit(**MERGED)
def _meet_wall(chamber, filled, i, wall, line, offset, taken, stiffness, s):
    ball = row(chamber.balls, i)
    block, radius = chamber.scratch.contacts, ball.radius
    meeting = Meeting(
        line, offset, taken, stiffness, ball.inverse_mass, radius, 0.0, s.rate, times(radius, s.roll), s.roll
    )  # fmt: skip
    enter(block, filled, meeting, i, -1, wall)
    if chamber.contact.has_memory != 0:
        put_vector(block.stretch, filled, three(chamber.wall_stretch[i, wall]))
    if chamber.contact.varies != 0:
        kinds = chamber.pair_rebounds.shape[0]
        data(block.rebound)[filled] = chamber.pair_rebounds[ball.kind, kinds]
    if (ball.touches >> wall) & 1 == 0:
        note_impact(chamber.since, line, s.rate, ball.inverse_mass)


@njit(**MERGED)
def note_impact(since, line, rate, lightness):
    """A contact begins with the relative velocity ``rate``, along ``line`` from the ball to its partner."""
    speed = max(dot(rate, line) / sqrt(dot(line, line)), 0.0)
    since.impact_speeds += speed
    since.impact_energies += 0.5 * speed * speed / lightness


@njit(**MERGED)
def _meet_walls(chamber, filled, i, s, axis):
    """Contacts of ball ``i`` with the walls of its chamber into the block; answers how full it is, and ``touches``."""
    ball = row(chamber.balls, i)
    room = row(chamber.rooms, ball.chamber)
    r = ball.radius
    way, reach = room.wall_radius - r, room.inner_radius + r
    side = abs(s.axial) + r - room.half_depth
    square = dot(s.radial, s.radial)
    touches = 0
    if square > way * way:
        _meet_wall(chamber, filled, i, RACE, s.radial, -way, 1.0, ball.race_stiffness, s)
        filled += 1
        touches = 1
    if reach > 0.0 and square < reach * reach:
        inwards = -s.radial[0], -s.radial[1], -s.radial[2]
        _meet_wall(chamber, filled, i, INNER, inwards, reach, -1.0, ball.inner_stiffness, s)
        filled += 1
        touches += 8
    if side > 0.0:
        sign = 1.0 if s.axial > 0.0 else -1.0
        wall = AHEAD if s.axial > 0.0 else BEHIND
        _meet_wall(chamber, filled, i, wall, times(sign, axis), side, 0.0, ball.flat_stiffness, s)
        filled += 1
        touches += 2 * wall
        # a chamber as deep as its balls touches both
        other = r - abs(s.axial) - room.half_depth
        if other > 0.0:
            wall = 3 - wall
            _meet_wall(chamber, filled, i, wall, times(-sign, axis), other, 0.0, ball.flat_stiffness, s)
            filled += 1
            touches += 2 * wall
    return filled, touches


@njit(**MERGED)
def change_walls(chamber, i, now):
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


@njit(**APART)
def walls(chamber, axis):
    """Weight and drag of all balls, and their contacts with walls; answers how many of them are left in the block."""
    body, gravity = chamber.body, three(chamber.machine.gravity)
    f = frame(body, axis)
    filled = 0
    for i in range(chamber.balls.shape[0]):
        ball = row(chamber.balls, i)
        room = row(chamber.rooms, ball.chamber)
        # weight, then the contacts with walls of the chamber into the block
        put(ball.force, times(ball.mass, gravity))
        put(ball.moment, (0.0, 0.0, 0.0))
        s = sight(f, room.center, three(ball.position), three(ball.velocity), three(ball.spin))
        filled, touches = _meet_walls(chamber, filled, i, s, axis)
        change_walls(chamber, i, touches)
        if room.drag != 0.0 or room.square_drag != 0.0:
            force, lost = drag(room.drag, room.square_drag, s.rate)
            add(ball.force, force)
            push_back(body, force, cross(s.arm, force), axis)
            chamber.power.drag += lost
        # a full block is evaluated at once, in the vector registers
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
    remember, varies = chamber.contact.has_memory != 0, chamber.contact.varies != 0
    for p in range(chamber.progress.pairs):
        i, j = first[p], second[p]
        one, two = row(chamber.balls, i), row(chamber.balls, j)
        # pairs that are apart end what they remember
        line = minus(three(two.position), three(one.position))
        r1, r2 = one.radius, two.radius
        both = r1 + r2
        if dot(line, line) >= both * both:
            if touching[p] != 0:
                touching[p] = 0
                put(pairs.stretch[p], (0.0, 0.0, 0.0))
            continue
        # a contact that begins is noted with its speed
        if touching[p] == 0:
            touching[p] = 1
            chamber.since.contacts_ball += 1
            rate = minus(three(one.velocity), three(two.velocity))
            note_impact(chamber.since, line, rate, one.inverse_mass + two.inverse_mass)
        # all that the laws need of this contact, into the next place of the block
        spin, other = three(one.spin), three(two.spin)
        meeting = Meeting(
            line, both, -1.0, table[one.kind * kinds + two.kind], one.inverse_mass + two.inverse_mass, min(r1, r2),
            1.0 / both, minus(three(one.velocity), three(two.velocity)), plus(times(r1, spin), times(r2, other)),
            minus(spin, other),
        )  # fmt: skip
        enter(block, filled, meeting, i, j, p)
        if remember:
            put_vector(block.stretch, filled, three(pairs.stretch[p]))
        if varies:
            data(block.rebound)[filled] = chamber.pair_rebounds[one.kind, two.kind]
        filled += 1
        if filled == BLOCK:
            act(chamber, filled, axis)
            filled = 0
    return filled


# What a block of contacts does to balls, body and rotor.


# mypy: disable-error-code="no-untyped-def"


@njit(**APART)
def act(chamber, count, axis):
    """Evaluate the first ``count`` contacts and add their forces, in their order; ``axis`` is that of the rotor."""
    block, body, power, since = chamber.scratch.contacts, chamber.body, chamber.power, chamber.since
    press(chamber.run, chamber.contact, block, count, chamber.rebounds)
    # contact by contact, in the order in which they were entered: sums keep their bits
    remember = chamber.contact.has_memory != 0
    middle = three(body.place)
    force = moment = 0.0, 0.0, 0.0
    lost = slid = rolled = held = 0.0
    most = since.greatest_force
    for i in range(count):
        number, partner, place = data(block.one)[i], data(block.two)[i], data(block.place)[i]
        one = row(chamber.balls, number)
        push, twist, resist = vector(block.push, i), vector(block.twist, i), vector(block.resist, i)
        arm = data(block.arm)[i]
        turn = plus(times(arm * one.radius, twist), resist)
        add(one.force, push)
        add(one.moment, turn)
        if partner >= 0:
            two = row(chamber.balls, partner)
            take(two.force, push)
            add(two.moment, minus(times(arm * two.radius, twist), resist))
            if remember:
                stretch = vector(block.stretch, i)
                for j in range(3):
                    chamber.pairs.stretch[place, j] = stretch[j]
        else:
            force = plus(force, push)
            moment = plus(moment, plus(cross(minus(three(one.position), middle), push), turn))
            if remember:
                stretch = vector(block.stretch, i)
                for j in range(3):
                    chamber.wall_stretch[number, place, j] = stretch[j]
        lost += data(block.lost)[i]
        slid += data(block.slid)[i]
        rolled += data(block.rolled)[i]
        held += data(block.held)[i]
        most = max(most, data(block.normal)[i])
    # walls are of the body; energies are summed for the balance of the run
    push_back(body, force, moment, axis)
    power.contact += lost
    power.friction += slid
    power.rolling += rolled
    power.stored += held
    since.greatest_force = most


@njit(**MERGED)
def push_back(body, force, moment, axis):
    """Body and rotor feel the opposite of a ``force`` on balls and of its ``moment`` about the rotor's middle."""
    take(body.contact_force, force)
    take(body.contact_moment, (dot(moment, axis), moment[1], moment[2]))
