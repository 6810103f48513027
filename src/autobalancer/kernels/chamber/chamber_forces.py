"""All forces on balls, body and rotor in one state.

Contacts at walls and between balls are gathered into a block; a full block is evaluated and shared out. Those of cylinders are
evaluated one by one.
"""

from __future__ import annotations

from math import cos, pi, sin, sqrt
from typing import NamedTuple

from autobalancer.kernels.chamber.chamber_contact import (
    TINY,
    add,
    cross,
    dot,
    end_rubs,
    minus,
    plus,
    pressed,
    put,
    rolls,
    side_rubs,
    take,
    three,
    times,
)
from autobalancer.kernels.chamber.chamber_records import COORDINATES, RIGHT, THETA, TURN_X, TURN_Y, TURN_Z, X, Y, Z
from autobalancer.kernels.chamber.contact_blocks import (
    AHEAD,
    BEHIND,
    INNER,
    RACE,
    act,
    change_walls,
    drag,
    frame,
    near_pairs,
    note_impact,
    push_back,
    sight,
    walls,
)
from autobalancer.kernels.compiler.flags import APART, MERGED, njit
from autobalancer.kernels.compiler.numba_struct import data, row

# mypy: disable-error-code="no-untyped-def"


@njit(**MERGED)
def _axis(place):
    """Direction of the rotor."""
    y, z = place[TURN_Z], -place[TURN_Y]
    x = 1.0 / sqrt(1.0 + y * y + z * z)
    return x, x * y, x * z


@njit(**APART)
def forces(chamber, prescribed):
    """Fill the forces and moments of the balls, the second rates of the body, losses, and what is stored in contacts.

    ``prescribed`` is the rate of a prescribed speed.
    """
    power, body = chamber.power, chamber.body
    power.motor = power.contact = power.friction = power.rolling = 0.0
    power.supports = power.bearings = power.drag = power.stored = 0.0
    put(body.contact_force, (0.0, 0.0, 0.0))
    put(body.contact_moment, (0.0, 0.0, 0.0))
    axis = _axis(body.place)
    if chamber.contact.cylinders != 0:
        cylinders_at_walls(chamber, axis)
        cylinders_together(chamber, axis)
    else:
        filled = near_pairs(chamber, walls(chamber, axis), axis)
        if filled:
            act(chamber, filled, axis)
    body_rates(chamber.machine, body, chamber.scratch, power, prescribed)


# Equations of motion of body and rotor.
#
# Coordinates: displacement (x, y, z) of the rotor's middle O, small rotations (a, b, c) of the body about x, y, z
# through O, and the angle theta of the rotor in space. The axis of the rotor points along (1, c, -b). With U = sum of
# the unbalances, turned by theta into S (along y) and T (along z), and their couples about O likewise C, D:
#
#     T_kin = T_body + m/2 |v|^2 + Jt/2 (b'^2 + c'^2) + Jp/2 w^2 - Jp w c' b (gyroscopic)
#           + x' (b' T - c' S + w (b S + c T)) + w (S z' - T y' - C b' - D c')
#
# Locked coordinates have no rate; what holds them is the constraint force. Torque of the drive and of the bearings
# acts between body and rotor, along the axis; so the moment of the contacts about the axis turns the rotor, and only
# that across it the body. Source: Pakuła (2021), (2), (5), (7), (13), (43)-(51), with the signs of the derivation.


# mypy: disable-error-code="no-untyped-def"


EVEN = 1e-3  # rad/s over which bearing friction changes its sign


class Turned(NamedTuple):
    """The unbalance in space; names as in the head of this file."""

    w: float  # rad/s
    s: float
    t: float
    c: float
    d: float
    lean: float  # b S + c T
    tip: float  # b T - c S
    load_b: float  # moment about y, of contacts and weight
    load_c: float  # about z


@njit(**MERGED)
def turned(machine, body):
    """The unbalance at the angle of the rotor, and the moments across it."""
    ct, st = cos(body.place[THETA]), sin(body.place[THETA])
    u, v = machine.unbalance[0], machine.unbalance[1]
    s, t = u * ct - v * st, u * st + v * ct
    u, v = machine.couple[0], machine.couple[1]
    c, d = u * ct - v * st, u * st + v * ct
    tilt_b, tilt_c = body.place[TURN_Y], body.place[TURN_Z]
    about, weight = body.contact_moment, machine.gravity[0]
    lean, tip = tilt_b * s + tilt_c * t, tilt_b * t - tilt_c * s
    load_b = about[1] - tilt_c * about[0] + weight * t
    load_c = about[2] + tilt_b * about[0] - weight * s
    return Turned(body.rate[THETA], s, t, c, d, lean, tip, load_b, load_c)


@njit(**MERGED)
def motor_torque(rated, overload, synchronous, breakdown, speed):
    """Formula of Kloss."""
    below, width = synchronous - speed, synchronous - breakdown
    return 2.0 * rated * overload * below * width / (width * width + below * below)


@njit(**MERGED)
def _bearing_torque(machine, body, slip):
    size = sqrt(_square(body.bearing_1)) + sqrt(_square(body.bearing_2))
    return machine.neck * size * min(max(slip / EVEN, -1.0), 1.0) + machine.rotor_damping * slip


@njit(**MERGED)
def _square(numbers):
    a = three(numbers)
    return dot(a, a)


@njit(**APART)
def body_rates(machine, body, scratch, power, prescribed):
    """Second rates of ``body``, reactions and powers from its state and the sums over the contacts.

    ``prescribed`` is the rate of a prescribed speed.
    """
    equations, rate = scratch.equations, body.rate
    u = turned(machine, body)
    power.supports = _supports(machine, body, equations)
    _add_rotor(machine, body, u, equations)
    # torques between body and rotor
    across_y, across_z = body.place[TURN_Z], -body.place[TURN_Y]  # of the axis
    slip = u.w - rate[TURN_X] - across_y * rate[TURN_Y] - across_z * rate[TURN_Z]
    against = _bearing_torque(machine, body, slip)
    motor = 0.0
    if machine.driven != 0:
        motor = motor_torque(
            machine.rated_torque, machine.overload, machine.synchronous_speed, machine.breakdown_speed, u.w
        )
        equations[THETA, RIGHT] += motor - against
        equations[TURN_X, RIGHT] -= motor - against
        equations[TURN_Y, RIGHT] -= across_y * (motor - against)
        equations[TURN_Z, RIGHT] -= across_z * (motor - against)
    else:
        # the drive gives what the speed asks for, and the body bears it
        for i in range(THETA):
            equations[i, RIGHT] -= equations[i, THETA] * prescribed
        equations[THETA, RIGHT] -= machine.polar_inertia * prescribed
        for j in range(RIGHT + 1):
            equations[TURN_X, j] += equations[THETA, j]
            equations[TURN_Y, j] += across_y * equations[THETA, j]
            equations[TURN_Z, j] += across_z * equations[THETA, j]
    _solve(machine, body, scratch, prescribed)
    _reactions(machine, body, equations, motor, against)
    _bearings(machine, body, u)
    power.motor = body.torque * slip
    power.bearings = against * slip


@njit(**MERGED)
def _supports(machine, body, equations):
    """Rows 0 to 5 of the mass matrix in columns 0 to 6, forces of the supports in column 7; answers what these lose."""
    place, rate = body.place, body.rate
    inertia, stiffness, damping = machine.inertia, machine.stiffness, machine.damping
    lost = 0.0
    for i in range(THETA):
        pull, resist = 0.0, 0.0
        for j in range(THETA):
            pull += stiffness[i, j] * place[j]
            resist += damping[i, j] * rate[j]
            equations[i, j] = inertia[i, j]
        lost += resist * rate[i]
        equations[i, THETA] = 0.0
        equations[i, RIGHT] = -pull - resist
    return lost


@njit(**MERGED)
def _add_rotor(machine, body, u, equations):
    """Inertia and inertial forces of the unbalance and of the spin, weight of the unbalance, and the contacts."""
    w, s, t, c, d = u.w, u.s, u.t, u.c, u.d
    bv, cv = body.rate[TURN_Y], body.rate[TURN_Z]
    polar, gravity, contact = machine.polar_inertia, machine.gravity, body.contact_force
    equations[X, TURN_Y] += t
    equations[TURN_Y, X] += t
    equations[X, TURN_Z] -= s
    equations[TURN_Z, X] -= s
    for j in range(THETA):
        equations[THETA, j] = 0.0
    equations[THETA, Y] = equations[Y, THETA] = -t
    equations[THETA, Z] = equations[Z, THETA] = s
    equations[THETA, TURN_Y] = equations[TURN_Y, THETA] = -c
    equations[THETA, TURN_Z] = equations[TURN_Z, THETA] = -d
    equations[THETA, THETA] = polar
    equations[X, THETA] = equations[THETA, X] = u.lean
    equations[X, RIGHT] += contact[0] + u.tip * w * w - 2.0 * w * (s * bv + t * cv)
    equations[Y, RIGHT] += contact[1] + s * w * w
    equations[Z, RIGHT] += contact[2] + t * w * w
    equations[TURN_Y, RIGHT] += u.load_b - polar * w * cv - d * w * w
    equations[TURN_Z, RIGHT] += u.load_c + polar * w * bv + c * w * w
    equations[THETA, RIGHT] = body.contact_moment[0] - gravity[1] * t + gravity[2] * s + gravity[0] * u.lean


@njit(**APART)
def _solve(machine, body, scratch, prescribed):
    """Gauss elimination over the free coordinates; column 7 of the equations is the right-hand side."""
    free, equations, reduced, new = machine.free, scratch.equations, scratch.reduced, body.new_acceleration
    turns = machine.driven != 0
    for i in range(COORDINATES):
        new[i] = 0.0
    count = 0
    while free[count] >= 0:
        count += 1
    # the rotor angle comes last; its row is needed whole for the reactions, so the elimination works on copies
    size = count + 1 if turns else count
    for i in range(size):
        row = free[i] if i < count else THETA
        for j in range(size):
            reduced[i, j] = equations[row, free[j] if j < count else THETA]
        reduced[i, RIGHT] = equations[row, RIGHT]
    for k in range(size):
        pivot = 1.0 / reduced[k, k]
        for i in range(k + 1, size):
            part = reduced[i, k] * pivot
            for j in range(k + 1, size):
                reduced[i, j] -= part * reduced[k, j]
            reduced[i, RIGHT] -= part * reduced[k, RIGHT]
    for k in range(size - 1, -1, -1):
        value = reduced[k, RIGHT]
        for j in range(k + 1, size):
            value -= reduced[k, j] * new[free[j] if j < count else THETA]
        new[free[k] if k < count else THETA] = value / reduced[k, k]
    if not turns:
        new[THETA] = prescribed


@njit(**APART)
def _reactions(machine, body, equations, motor, against):
    """Torque of the drive, and what holds locked coordinates."""
    new, free = body.new_acceleration, machine.free
    turns = machine.driven != 0
    top = COORDINATES if turns else THETA  # with a prescribed speed its inertia is on the right-hand side already
    for i in range(THETA):
        value = -equations[i, RIGHT]
        for j in range(top):
            value += equations[i, j] * new[j]
        body.constraint[i] = value
    count = 0
    while free[count] >= 0:
        body.constraint[free[count]] = 0.0
        count += 1
    if turns:
        body.torque = motor
    else:
        value = -equations[THETA, RIGHT]
        for j in range(THETA):
            value += equations[THETA, j] * new[j]
        body.torque = value + against
    body.bearing_torque = against


@njit(**MERGED)
def _bearings(machine, body, u):
    """Forces of both bearings on the rotor from its own balances, (43)-(51); the second one guides along the axis."""
    w, s, t, c, d = u.w, u.s, u.t, u.c, u.d
    new, rate, contact, gravity = body.new_acceleration, body.rate, body.contact_force, machine.gravity
    m, jt, polar = machine.rotor_mass, machine.transverse_inertia, machine.polar_inertia
    xa, ya, za, ba, ca, wa = new[X], new[Y], new[Z], new[TURN_Y], new[TURN_Z], new[THETA]
    bv, cv = rate[TURN_Y], rate[TURN_Z]
    px = (
        m * xa
        + t * ba
        - s * ca
        + u.lean * wa
        - u.tip * w * w
        + 2.0 * w * (s * bv + t * cv)
        - contact[0]
        - m * gravity[0]
    )
    py = m * ya - t * wa - s * w * w - contact[1] - m * gravity[1]
    pz = m * za + s * wa - t * w * w - contact[2] - m * gravity[2]
    mb = jt * ba + t * xa - c * wa + polar * w * cv + d * w * w - u.load_b
    mc = jt * ca - s * xa - d * wa - polar * w * bv - c * w * w - u.load_c
    # x1 P1y + x2 P2y = mc and -x1 P1z - x2 P2z = mb
    x1, x2 = machine.bearings[0], machine.bearings[1]
    span = 1.0 / (x1 - x2)
    put(body.bearing_1, (0.0, (mc - x2 * py) * span, (-mb - x2 * pz) * span))
    put(body.bearing_2, (px, (x1 * py - mc) * span, (x1 * pz + mb) * span))


# Cylinders that stay parallel to the rotor: which of them touch walls and each other, and what that does.
#
# A contact is along a line on the side of a cylinder, or over its end. Two cylinders that overlap by p across the axis
# and by q along it hold the energy of both springs in series,
#
#     V = K E* p^2 q^2 / (2 (K p + E* q)),   K = pi/4 E*:
#
# K q p^2 / 2 of a line of length q where p is small, E* p q^2 / 2 of two ends where q is small (a flat punch whose
# radius is p/2, Johnson 1985, (3.36)), without a jump between. Moments across the axis that a contact would exert are
# borne by the rotor, which holds the cylinders parallel.


# mypy: disable-error-code="no-untyped-def"


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
    # the race, from inside
    out = sqrt(dot(s.radial, s.radial))
    normal = times(1.0 / max(out, TINY), s.radial)
    depth, touches = out + ball.radius - room.wall_radius, 0
    if depth > 0.0:
        _begins(chamber, ball, RACE, normal, s)
        _at_side(chamber, ball, s, axis, normal, depth, ball.race_stiffness)
        touches = 1
    # the inner wall, from outside
    depth = room.inner_radius + ball.radius - out
    if depth > 0.0:
        normal = times(-1.0, normal)
        _begins(chamber, ball, INNER, normal, s)
        _at_side(chamber, ball, s, axis, normal, depth, ball.inner_stiffness)
        touches += 8
    # the flat walls at both ends
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
        # weight, then where the cylinder is in its chamber and how it moves there
        put(ball.force, times(ball.mass, gravity))
        put(ball.moment, (0.0, 0.0, 0.0))
        s = sight(f, room.center, three(ball.position), three(ball.velocity), three(ball.spin))
        # contacts with walls; what began and ended is counted
        change_walls(chamber, i, _meet_walls(chamber, i, s, axis))
        # drag of the fluid, which the chamber feels too
        if room.drag != 0.0 or room.square_drag != 0.0:
            force, lost = drag(room.drag, room.square_drag, s.rate)
            add(ball.force, force)
            push_back(body, force, cross(s.arm, force), axis)
            chamber.power.drag += lost
        # the rotor tilts the spin of the cylinder: its gyroscopic moment is borne by the rotor
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
        # the overlap across the axis and along it; most pairs end here
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
        # spins as the rotor sees them
        turning = dot(f.turn, axis)
        _meet(chamber, one, two, axis, along, radial, rate, one.spin[0] - turning, two.spin[0] - turning)


@njit(**APART)
def _meet(chamber, one, two, axis, along, radial, rate, spin, other):
    """Two cylinders that overlap; ``rate`` and spins as the rotor sees them."""
    # the overlaps p across and q along, no deeper than the smaller cylinder
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
    # the force is the gradient of V: its size, how fast the overlap grows along it, and damping by that
    load = sqrt(by_p * by_p + by_q * by_q)
    approach = (by_p * dot(rate, normal) + by_q * sign * dot(rate, axis)) / max(load, TINY)
    # one normal force, shared by side and end as the slopes of V are
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
