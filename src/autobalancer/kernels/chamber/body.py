r"""Equations of motion of body and rotor.

Coordinates: displacement (x, y, z) of the rotor's middle O, small rotations (a, b, c) of the body about x, y, z through O, and
the angle theta of the rotor in space. The axis of the rotor points along (1, c, -b). With U = sum of the unbalances,
turned by theta into S (along y) and T (along z), and their couples about O likewise C, D:

    T_kin = T_body + m/2 |v|^2 + Jt/2 (b'^2 + c'^2) + Jp/2 w^2 - Jp w c' b (gyroscopic)
          + x' (b' T - c' S + w (b S + c T)) + w (S z' - T y' - C b' - D c')

Locked coordinates have no rate; what holds them is the constraint force. Torque of the drive and of the bearings acts between
body and rotor, along the axis; so the moment of the contacts about the axis turns the rotor, and only that across it the body.
Source: Pakuła (2021), (2), (5), (7), (13), (43)-(51), with the signs of the derivation.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from math import cos, sin, sqrt
from typing import NamedTuple

from autobalancer.kernels.chamber.records import COORDINATES, RIGHT, THETA, TURN_X, TURN_Y, TURN_Z, X, Y, Z
from autobalancer.kernels.chamber.vectors import dot, put, three
from autobalancer.kernels.flags import APART, MERGED, njit

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
