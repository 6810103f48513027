"""Cylinders that stay parallel to the rotor: which of them touch walls and each other, and what that does.

A contact is along a line on the side of a cylinder, or over its end. Two cylinders that overlap by p across the axis and by q
along it hold the energy of both springs in series,

    V = K E* p^2 q^2 / (2 (K p + E* q)),   K = pi/4 E*:

K q p^2 / 2 of a line of length q where p is small, E* p q^2 / 2 of two ends where q is small (a flat punch whose radius is
p/2, Johnson 1985, (3.36)), without a jump between. Moments across the axis that a contact would exert are borne by the rotor,
which holds the cylinders parallel.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from math import pi, sqrt

from autobalancer.kernels.chamber.contact import TINY
from autobalancer.kernels.chamber.gather import (
    AHEAD,
    BEHIND,
    INNER,
    RACE,
    change_walls,
    drag,
    frame,
    note_impact,
    sight,
)  # fmt: skip
from autobalancer.kernels.chamber.line_contact import end_rubs, pressed, rolls, side_rubs
from autobalancer.kernels.chamber.records import TURN_Y, TURN_Z
from autobalancer.kernels.chamber.share import push_back
from autobalancer.kernels.chamber.vectors import add, cross, dot, minus, plus, put, take, three, times
from autobalancer.kernels.flags import APART, MERGED, njit
from autobalancer.kernels.pointers import data, row

LINE = 0.25 * pi  # stiffness of a contact along a line, over its length and the reduced modulus


@njit(**MERGED)
def _book(chamber, press, rub, roll):
    """Losses, energy and greatest force of a contact."""
    power, since = chamber.power, chamber.since
    power.contact += press.lost
    power.stored += press.held
    power.friction += rub
    power.rolling += roll
    since.greatest_force = max(since.greatest_force, press.normal)


@njit(**MERGED)
def _would_tilt(ball, arm, force, holding):
    """Note the moment across the axis of a ``force`` at ``arm`` from the middle, and what the contact could bear."""
    moment = cross(arm, force)
    ball.tilting[0] += moment[1]
    ball.tilting[1] += moment[2]
    ball.holding += holding


@njit(**MERGED)
def _felt_at_wall(chamber, ball, s, axis, force, turn):
    """A force of a wall on a cylinder at its middle, with a moment ``turn`` about its axis."""
    add(ball.force, force)
    ball.moment[0] += turn
    push_back(chamber.body, force, plus(cross(s.arm, force), times(turn, axis)), axis)


@njit(**APART)
def _at_side(chamber, ball, s, axis, normal, depth, stiffness):
    """Contact with the race or an inner wall in the direction ``normal``, at the overlap ``depth``."""
    contact, r = chamber.contact, ball.radius
    spin = dot(s.roll, axis)
    press = pressed(
        chamber.run, contact, stiffness * depth, 0.5 * stiffness * depth * depth, dot(s.rate, normal), ball.inverse_mass
    )
    tangent = cross(axis, normal)
    across, along = dot(s.rate, tangent) + r * spin, dot(s.rate, axis)
    rub = side_rubs(chamber.run, contact.friction, contact.slow, press.normal, across, along, ball.inverse_mass)
    roll = rolls(chamber.run, contact, press.normal, spin, r, ball.inverse_mass)
    slide = plus(times(rub.across, tangent), times(rub.along, axis))
    force = minus(slide, times(press.normal, normal))
    _felt_at_wall(chamber, ball, s, axis, force, r * rub.across + roll.moment)
    _would_tilt(ball, times(r, normal), force, press.normal * ball.half_length)
    _book(chamber, press, rub.lost, roll.lost)


@njit(**APART)
def _at_end(chamber, ball, s, axis, sign, depth):
    """Contact with the flat wall at +x or -x."""
    contact, r, stiffness = chamber.contact, ball.radius, ball.flat_stiffness
    along = dot(s.rate, axis)
    press = pressed(
        chamber.run, contact, stiffness * depth, 0.5 * stiffness * depth * depth, sign * along, ball.inverse_mass
    )
    rate = minus(s.rate, times(along, axis))
    rub = end_rubs(
        chamber.run, contact.friction, contact.slow, press.normal, rate, dot(s.roll, axis), r, ball.inverse_mass
    )
    force = minus(rub.force, times(sign * press.normal, axis))
    _felt_at_wall(chamber, ball, s, axis, force, rub.moment)
    _would_tilt(ball, times(sign * ball.half_length, axis), force, press.normal * r)
    _book(chamber, press, rub.lost, 0.0)


@njit(**MERGED)
def _begins(chamber, ball, wall, normal, s):
    if (ball.touches >> wall) & 1 == 0:
        note_impact(chamber.since, normal, s.rate, ball.inverse_mass)


@njit(**MERGED)
def _meet_walls(chamber, i, s, axis):
    """Contacts of cylinder ``i`` with the walls of its chamber; answers which it touches."""
    ball = row(chamber.balls, i)
    room = row(chamber.rooms, ball.chamber)
    out = sqrt(dot(s.radial, s.radial))
    normal = times(1.0 / max(out, TINY), s.radial)
    depth, touches = out + ball.radius - room.wall_radius, 0
    if depth > 0.0:
        _begins(chamber, ball, RACE, normal, s)
        _at_side(chamber, ball, s, axis, normal, depth, ball.race_stiffness)
        touches = 1
    depth = room.inner_radius + ball.radius - out
    if depth > 0.0:
        normal = times(-1.0, normal)
        _begins(chamber, ball, INNER, normal, s)
        _at_side(chamber, ball, s, axis, normal, depth, ball.inner_stiffness)
        touches += 8
    for wall in range(AHEAD, BEHIND + 1):
        sign = 1.0 if wall == AHEAD else -1.0
        depth = sign * s.axial + ball.half_length - room.half_depth
        if depth > 0.0:
            _begins(chamber, ball, wall, times(sign, axis), s)
            _at_end(chamber, ball, s, axis, sign, depth)
            touches += 2 * wall
    return touches


@njit(**APART)
def cylinders_at_walls(chamber, axis):
    """Weight, drag, contacts with walls, and the gyroscopic moment on the rotor that carries the spins along."""
    body, gravity = chamber.body, three(chamber.machine.gravity)
    f = frame(body, axis)
    for i in range(chamber.balls.shape[0]):
        ball = row(chamber.balls, i)
        room = row(chamber.rooms, ball.chamber)
        put(ball.force, times(ball.mass, gravity))
        put(ball.moment, (0.0, 0.0, 0.0))
        s = sight(f, room.center, three(ball.position), three(ball.velocity), three(ball.spin))
        change_walls(chamber, i, _meet_walls(chamber, i, s, axis))
        if room.drag != 0.0 or room.square_drag != 0.0:
            force, lost = drag(room.drag, room.square_drag, s.rate)
            add(ball.force, force)
            push_back(body, force, cross(s.arm, force), axis)
            chamber.power.drag += lost
        spun = ball.inertia * ball.spin[0]
        body.contact_moment[1] -= spun * body.rate[TURN_Z]
        body.contact_moment[2] += spun * body.rate[TURN_Y]


@njit(**APART)
def cylinders_together(chamber, axis):
    """Contacts of cylinders with each other."""
    pairs, f = chamber.pairs, frame(chamber.body, axis)
    first, second, touching = pairs.first, pairs.second, pairs.touching
    for k in range(chamber.progress.pairs):
        one, two = row(chamber.balls, first[k]), row(chamber.balls, second[k])
        line = minus(three(two.position), three(one.position))
        along = dot(line, axis)
        over = one.half_length + two.half_length - abs(along)
        radial = minus(line, times(along, axis))
        square, both = dot(radial, radial), one.radius + two.radius
        if over <= 0.0 or square >= both * both:
            touching[k] = 0
            continue
        # seen from the rotor, with which the axis tilts
        rate = plus(minus(three(one.velocity), three(two.velocity)), cross(f.turn, line))
        if touching[k] == 0:
            touching[k] = 1
            chamber.since.contacts_ball += 1
            ends = over < both - sqrt(square)
            note_impact(
                chamber.since, times(along, axis) if ends else radial, rate, one.inverse_mass + two.inverse_mass
            )
        turning = dot(f.turn, axis)
        _meet(chamber, one, two, axis, along, radial, rate, one.spin[0] - turning, two.spin[0] - turning)


@njit(**APART)
def _meet(chamber, one, two, axis, along, radial, rate, spin, other):
    """Two cylinders that overlap; ``rate`` and spins as the rotor sees them."""
    run, contact, body = chamber.run, chamber.contact, chamber.body
    kinds, friction = chamber.pair_stiffness.shape[0], chamber.contact.ball_friction
    modulus = data(chamber.pair_stiffness)[one.kind * kinds + two.kind]
    out, lightness = sqrt(dot(radial, radial)), one.inverse_mass + two.inverse_mass
    normal, sign = times(1.0 / max(out, TINY), radial), 1.0 if along > 0.0 else -1.0
    r1, r2, h1, h2 = one.radius, two.radius, one.half_length, two.half_length
    p, q = r1 + r2 - out, h1 + h2 - abs(along)
    flat, flush = 2.0 * min(r1, r2), 2.0 * min(h1, h2)
    deep, wide = min(p, flat), min(q, flush)
    # slopes of V
    stiff, firm = LINE * modulus * deep, modulus * wide
    part = 0.5 * LINE * modulus * modulus * deep * wide / ((stiff + firm) * (stiff + firm))
    by_p = part * wide * (stiff + 2.0 * firm) if p < flat else 0.0
    by_q = part * deep * (2.0 * stiff + firm) if q < flush else 0.0
    load = sqrt(by_p * by_p + by_q * by_q)
    approach = (by_p * dot(rate, normal) + by_q * sign * dot(rate, axis)) / max(load, TINY)
    press = pressed(run, contact, load, part * deep * wide * (stiff + firm), approach, lightness)
    share = press.normal / max(load, TINY)
    at_side, at_end = share * by_p, share * by_q
    # along the line in the middle of its length
    tangent = cross(axis, normal)
    shrink = 1.0 - p / (r1 + r2) if p < flat else 1.0
    a1, a2 = shrink * r1, shrink * r2
    across = dot(rate, tangent) + a1 * spin + a2 * other
    side = side_rubs(run, friction, contact.slow, at_side, across, dot(rate, axis), lightness)
    roll = rolls(run, contact, at_side, spin - other, min(r1, r2), lightness)
    # over the ends, at the middle of what they have in common
    c1 = 0.5 * (max(out - r2, -r1) + min(out + r2, r1))
    c2 = c1 - out
    there = minus(minus(rate, times(dot(rate, axis), axis)), times(c2 * other - c1 * spin, tangent))
    end = end_rubs(run, friction, contact.slow, at_end, there, spin - other, 0.5 * deep, lightness)
    on_side = plus(times(side.across, tangent), minus(times(side.along, axis), times(at_side, normal)))
    on_end = minus(end.force, times(sign * at_end, axis))
    force, turn = plus(on_side, on_end), dot(end.force, tangent)
    add(one.force, force)
    take(two.force, force)
    one.moment[0] += a1 * side.across + roll.moment + c1 * turn + end.moment
    two.moment[0] += a2 * side.across - roll.moment - c2 * turn - end.moment
    # what keeps both parallel acts on the rotor
    couple = cross(plus(radial, times(along, axis)), force)
    couple = minus(couple, times(dot(couple, axis), axis))
    body.contact_moment[1] += couple[1]
    body.contact_moment[2] += couple[2]
    middle = 0.5 * (max(along - h2, -h1) + min(along + h2, h1))
    held_side, held_end = 0.5 * at_side * wide, 0.5 * at_end * deep
    _would_tilt(one, plus(times(middle, axis), times(a1, normal)), on_side, held_side)
    _would_tilt(one, plus(times(sign * h1, axis), times(c1, normal)), on_end, held_end)
    back, pull = times(-1.0, on_side), times(-1.0, on_end)
    _would_tilt(two, minus(times(middle - along, axis), times(a2, normal)), back, held_side)
    _would_tilt(two, plus(times(-sign * h2, axis), times(c2, normal)), pull, held_end)
    _book(chamber, press, side.lost + end.lost, roll.lost)
