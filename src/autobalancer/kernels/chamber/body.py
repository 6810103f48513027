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

from numba import njit

from autobalancer.kernels.chamber.contact import APART
from autobalancer.kernels.chamber.layout import (
    BEARING_1,
    BEARING_2,
    BEARING_TORQUE,
    BREAKDOWN,
    CONSTRAINT,
    CONTACT,
    COUPLE_C,
    COUPLE_S,
    DRIVEN,
    GRAVITY_X,
    GRAVITY_Y,
    GRAVITY_Z,
    NECK,
    NEW,
    OVERLOAD,
    P1,
    P2,
    P_BEARINGS,
    P_MOTOR,
    P_SUPPORTS,
    POLAR,
    RATED,
    ROTOR_DAMPING,
    ROTOR_MASS,
    SYNCHRONOUS,
    TORQUE,
    TRANSVERSE,
    U_C,
    U_S,
    Q,
    V,
)

EVEN = 1e-3  # rad/s over which bearing friction changes its sign


@njit(**APART)
def body_rates(number, host, inertia, stiffness, damping, active, work, power, prescribed):
    """Second rates (``host[NEW:]``), reactions and powers from the state and the sums over the contacts.

    ``prescribed`` is the rate of the prescribed speed; ``active`` lists the coordinates 0 to 5 that are free, -1 at its end.
    ``work`` is (14, 8) scratch.
    """
    w = host[V + 6]
    ct, st = cos(host[Q + 6]), sin(host[Q + 6])
    s, t = number[U_C] * ct - number[U_S] * st, number[U_C] * st + number[U_S] * ct
    c, d = number[COUPLE_C] * ct - number[COUPLE_S] * st, number[COUPLE_C] * st + number[COUPLE_S] * ct
    gx, gy, gz = number[GRAVITY_X], number[GRAVITY_Y], number[GRAVITY_Z]
    free = number[DRIVEN] != 0.0
    # rows 0-6: mass matrix in columns 0-6, applied less inertial forces in column 7
    lost = 0.0
    for i in range(6):
        pull, resist = 0.0, 0.0
        for j in range(6):
            pull += stiffness[i, j] * host[Q + j]
            resist += damping[i, j] * host[V + j]
            work[i, j] = inertia[i, j]
        lost += resist * host[V + i]
        work[i, 6] = 0.0
        work[i, 7] = -pull - resist
    power[P_SUPPORTS] = lost
    bv, cv = host[V + 4], host[V + 5]
    polar = number[POLAR]
    work[0, 4] += t
    work[4, 0] += t
    work[0, 5] -= s
    work[5, 0] -= s
    for j in range(6):
        work[6, j] = 0.0
    work[6, 1] = work[1, 6] = -t
    work[6, 2] = work[2, 6] = s
    work[6, 4] = work[4, 6] = -c
    work[6, 5] = work[5, 6] = -d
    work[6, 6] = polar
    lean, tip = host[Q + 4] * s + host[Q + 5] * t, host[Q + 4] * t - host[Q + 5] * s
    work[0, 6] = work[6, 0] = lean
    work[0, 7] += host[CONTACT] + tip * w * w - 2.0 * w * (s * bv + t * cv)
    work[1, 7] += host[CONTACT + 1] + s * w * w
    work[2, 7] += host[CONTACT + 2] + t * w * w
    across_y, across_z = host[Q + 5], -host[Q + 4]  # of the axis
    load_b = host[CONTACT + 4] - across_y * host[CONTACT + 3] + gx * t
    load_c = host[CONTACT + 5] - across_z * host[CONTACT + 3] - gx * s
    work[4, 7] += load_b - polar * w * cv - d * w * w
    work[5, 7] += load_c + polar * w * bv + c * w * w
    work[6, 7] = host[CONTACT + 3] - gy * t + gz * s + gx * lean
    # torques between body and rotor
    slip = w - host[V + 3] - across_y * bv - across_z * cv
    size = sqrt(host[P1] ** 2 + host[P1 + 1] ** 2 + host[P1 + 2] ** 2)
    size += sqrt(host[P2] ** 2 + host[P2 + 1] ** 2 + host[P2 + 2] ** 2)
    against = number[NECK] * size * min(max(slip / EVEN, -1.0), 1.0) + number[ROTOR_DAMPING] * slip
    motor = 0.0
    if free:
        below, width = number[SYNCHRONOUS] - w, number[SYNCHRONOUS] - number[BREAKDOWN]
        motor = 2.0 * number[RATED] * number[OVERLOAD] * below * width / (width * width + below * below)
        work[6, 7] += motor - against
        work[3, 7] -= motor - against
        work[4, 7] -= across_y * (motor - against)
        work[5, 7] -= across_z * (motor - against)
    else:
        # the drive gives what the speed asks for, and the body bears it
        for i in range(6):
            work[i, 7] -= work[i, 6] * prescribed
        work[6, 7] -= polar * prescribed
        for j in range(8):
            work[3, j] += work[6, j]
            work[4, j] += across_y * work[6, j]
            work[5, j] += across_z * work[6, j]
    _solve(host, active, work, free, prescribed)
    _reactions(number, host, active, work, free, motor, against, polar)
    _bearings(number, host, w, s, t, c, d, lean, tip, polar, load_b, load_c)
    power[P_MOTOR] = host[TORQUE] * slip
    power[P_BEARINGS] = against * slip


@njit(**APART)
def _solve(host, active, work, free, prescribed):
    """Gauss elimination over the free coordinates; column 7 of ``work`` is the right-hand side."""
    for i in range(7):
        host[NEW + i] = 0.0
    count = 0
    while active[count] >= 0:
        count += 1
    # the rotor angle comes last; its row is needed whole for the reactions, so the elimination works on copies
    size = count + 1 if free else count
    for i in range(size):
        row = active[i] if i < count else 6
        for j in range(size):
            work[7 + i, j] = work[row, active[j] if j < count else 6]
        work[7 + i, 7] = work[row, 7]
    for k in range(size):
        pivot = 1.0 / work[7 + k, k]
        for i in range(k + 1, size):
            part = work[7 + i, k] * pivot
            for j in range(k + 1, size):
                work[7 + i, j] -= part * work[7 + k, j]
            work[7 + i, 7] -= part * work[7 + k, 7]
    for k in range(size - 1, -1, -1):
        value = work[7 + k, 7]
        for j in range(k + 1, size):
            value -= work[7 + k, j] * host[NEW + (active[j] if j < count else 6)]
        host[NEW + (active[k] if k < count else 6)] = value / work[7 + k, k]
    if not free:
        host[NEW + 6] = prescribed


@njit(**APART)
def _reactions(number, host, active, work, free, motor, against, polar):
    """Torque of the drive, and what holds locked coordinates."""
    top = 7 if free else 6  # with a prescribed speed its inertia is on the right-hand side already
    for i in range(6):
        value = -work[i, 7]
        for j in range(top):
            value += work[i, j] * host[NEW + j]
        host[CONSTRAINT + i] = value
    count = 0
    while active[count] >= 0:
        host[CONSTRAINT + active[count]] = 0.0
        count += 1
    if free:
        host[TORQUE] = motor
    else:
        value = -work[6, 7]
        for j in range(6):
            value += work[6, j] * host[NEW + j]
        host[TORQUE] = value + against
    host[BEARING_TORQUE] = against


@njit(**APART)
def _bearings(number, host, w, s, t, c, d, lean, tip, polar, load_b, load_c):
    """Forces of both bearings on the rotor from its own balances, (43)-(51); the second one guides along the axis."""
    m = number[ROTOR_MASS]
    xa, ya, za, ba, ca, wa = host[NEW], host[NEW + 1], host[NEW + 2], host[NEW + 4], host[NEW + 5], host[NEW + 6]
    bv, cv = host[V + 4], host[V + 5]
    px = (
        m * xa
        + t * ba
        - s * ca
        + lean * wa
        - tip * w * w
        + 2.0 * w * (s * bv + t * cv)
        - host[CONTACT]
        - m * number[GRAVITY_X]
    )
    py = m * ya - t * wa - s * w * w - host[CONTACT + 1] - m * number[GRAVITY_Y]
    pz = m * za + s * wa - t * w * w - host[CONTACT + 2] - m * number[GRAVITY_Z]
    jt = number[TRANSVERSE]
    mb = jt * ba + t * xa - c * wa + polar * w * cv + d * w * w - load_b
    mc = jt * ca - s * xa - d * wa - polar * w * bv - c * w * w - load_c
    # x1 P1y + x2 P2y = mc and -x1 P1z - x2 P2z = mb
    x1, x2 = number[BEARING_1], number[BEARING_2]
    span = 1.0 / (x1 - x2)
    host[P1] = 0.0
    host[P1 + 1] = (mc - x2 * py) * span
    host[P1 + 2] = (-mb - x2 * pz) * span
    host[P2] = px
    host[P2 + 1] = (x1 * py - mc) * span
    host[P2 + 2] = (x1 * pz + mb) * span
