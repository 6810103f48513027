"""A linear rotor by itself, and what it does under the forces of its stations.

    M q'' + (C(w) + w G) q' + (K(w) + w' G/2) q = w^2 Re(u e^(i theta)) - w' d/d theta Re(u e^(i theta)) + sum B_p^T F_p

:func:`alone` works out q'' = f - w' g without the stations. The balls then give each station a force
F = R - S A - w' c, with A = B q'' its acceleration, and the torque a part T - t.A. :func:`together` solves

    (1 + H S) A = B f + H R - w' (B g + H c),    H = B M^-1 B^T,

twice as large as there are stations, and returns w'. With a prescribed speed w' is known and goes to f and R at once.
"""

from __future__ import annotations

from numba import njit

from autobalancer.kernels.drive import drive_value, table_torque, unbalance_value
from autobalancer.kernels.elimination import solve_two, solve_two_by_two
from autobalancer.kernels.flags import EQUATIONS, INLINE
from autobalancer.kernels.lanes import LANES, add_product, lanes, put
from autobalancer.kernels.pointers import behind
from autobalancer.kernels.rotor_layout import COORDINATES, HEADER, PLACES, TABLE, WIDTH, blocks
from autobalancer.kernels.system import BALLS, PRESCRIBED, SPEED, START, THETA, VX, VY, X, Y
from autobalancer.kernels.trigonometry import sine_cosine


@njit(**INLINE)
def dot(one, i: int, other, j: int, count: int) -> float:  # type: ignore[no-untyped-def]
    """Product of ``count`` numbers from place i of one and j of the other."""
    total = 0.0
    for k in range(count):
        total += one[i + k] * other[j + k]
    return total


@njit(**EQUATIONS)
def alone(time, y, system, r, each):  # type: ignore[no-untyped-def]
    """Fill f, g and the stations' zeros in the work space.

    Returns speed, acceleration (0 where a torque drives), sine and cosine that turn rotor-fixed vectors into the frame,
    gravity in the frame, and the torque of drive and weight.
    """
    p = behind(system)
    count = p.balls.shape[0]
    size, width, table = int(r[COORDINATES]), int(r[WIDTH]), int(r[TABLE])
    rows = int(r[PLACES]) * each
    k = blocks(width, rows, table)
    free = p.drive != PRESCRIBED
    speed, acceleration = y[SPEED], 0.0
    drive, drive_rate = drive_value(time, p)
    if not free:
        speed, acceleration = drive, drive_rate

    gx, gy = p.gravity_x, p.gravity_y
    turn_sin, turn_cos = 0.0, 1.0
    if p.rotating != 1.0:
        turn_sin, turn_cos = sine_cosine(y[THETA])
    elif gx != 0.0 or gy != 0.0:
        s, c = sine_cosine(y[THETA])
        gx, gy = c * gx + s * gy, c * gy - s * gx

    # the rotor by itself: q'' = f - w' g
    rest = BALLS + 2 * count
    r[k.q], r[k.q + 1], r[k.v], r[k.v + 1] = y[X], y[Y], y[VX], y[VY]
    for i in range(2, size):
        r[k.q + i], r[k.v + i] = y[rest + i - 2], y[rest + size - 4 + i]
    square, turning = width * width, speed * speed
    row, share = 0, 0.0
    if table > 1:
        amount = min(abs(speed), r[HEADER + table - 1])
        while row < table - 2 and r[HEADER + row + 1] < amount:
            row += 1
        share = (amount - r[HEADER + row]) / (r[HEADER + row + 1] - r[HEADER + row])
    near_c, near_k = k.damping + row * square, k.stiffness + row * square
    # Re(u e^(i theta)) w^2 and its derivative with respect to theta
    load, since = k.loads + 8 * width * p.now[0], time - p.segments[p.now[0], START]
    changing = r[load + 8 * width - 1] != 0.0
    real, imaginary = turning * turn_cos + acceleration * turn_sin, acceleration * turn_cos - turning * turn_sin
    for i in range(0, width, LANES):
        force = lanes()
        add_product(force, real, r, load + i)
        add_product(force, imaginary, r, load + width + i)
        for j in range(size):
            at = j * width + i
            add_product(force, -(1.0 - share) * r[k.q + j], r, near_k + at)
            add_product(force, -(1.0 - share) * r[k.v + j], r, near_c + at)
            add_product(force, -speed * r[k.v + j] - 0.5 * acceleration * r[k.q + j], r, k.gyroscopic + at)
        if share > 0.0:
            for j in range(size):
                at = j * width + i + square
                add_product(force, -share * r[k.q + j], r, near_k + at)
                add_product(force, -share * r[k.v + j], r, near_c + at)
        if changing:
            add_product(force, real * since, r, load + 4 * width + i)
            add_product(force, imaginary * since, r, load + 5 * width + i)
        put(force, r, k.f + i)
    torque = 0.0
    if free:
        for i in range(0, width, LANES):
            arm, own_arm = lanes(), lanes()
            add_product(arm, -turn_sin, r, load + i)
            add_product(arm, -turn_cos, r, load + width + i)
            add_product(arm, -turn_sin * since, r, load + 4 * width + i)
            add_product(arm, -turn_cos * since, r, load + 5 * width + i)
            add_product(own_arm, -turn_sin, r, load + 2 * width + i)
            add_product(own_arm, -turn_cos, r, load + 3 * width + i)
            add_product(own_arm, -turn_sin * since, r, load + 6 * width + i)
            add_product(own_arm, -turn_cos * since, r, load + 7 * width + i)
            for j in range(size):
                add_product(arm, 0.5 * r[k.q + j], r, k.gyroscopic + j * width + i)
                add_product(own_arm, r[k.q + j], r, k.spin + j * width + i)
            put(arm, r, k.g + i)
            put(own_arm, r, k.raw + i)
        ux, uy = unbalance_value(time, p)
        torque = (turn_cos * ux - turn_sin * uy) * gy - (turn_sin * ux + turn_cos * uy) * gx
        torque += drive + table_torque(speed, p) - p.torque_damping * speed

    for i in range(rows * (each + 3)):
        r[k.pushing + i] = 0.0
    return speed, acceleration, turn_sin, turn_cos, gx, gy, torque


@njit(**EQUATIONS)
def together(system, r, each, acceleration, torque, inertia):  # type: ignore[no-untyped-def]
    """Accelerations of the stations (in the first right-hand side) and of the coordinates (in f); returns w'."""
    p = behind(system)
    size, width, table = int(r[COORDINATES]), int(r[WIDTH]), int(r[TABLE])
    places = int(r[PLACES])
    rows = places * each
    k = blocks(width, rows, table)
    free = p.drive != PRESCRIBED
    for i in range(rows):
        at, line = k.place + i * width, k.host + i * rows
        r[k.one + i] = dot(r, at, r, k.f, size) + dot(r, line, r, k.pushing, rows)
        if free:
            r[k.two + i] = dot(r, at, r, k.g, size) + dot(r, line, r, k.arms, rows)
        for other in range(places):
            for j in range(each):
                total = 0.0
                for h in range(each):
                    total += r[line + other * each + h] * r[k.own + (other * each + h) * each + j]
                r[k.left + i * rows + other * each + j] = total
        r[k.left + i * rows + i] += 1.0
    if rows == 2:
        solve_two_by_two(r, k.left, k.one, k.two)
    else:
        solve_two(r, k.left, k.one, k.two, rows)

    # forces on the stations, put into the rotor
    for i in range(rows):
        first = (i // each) * each
        r[k.pushing + i] -= dot(r, k.own + i * each, r, k.one + first, each)
        if free:
            torque -= r[k.turning + i] * r[k.one + i]
            inertia -= r[k.turning + i] * r[k.two + i]
            r[k.arms + i] -= dot(r, k.own + i * each, r, k.two + first, each)
    for i in range(0, width, LANES):
        force = lanes()
        add_product(force, 1.0, r, k.f + i)
        for j in range(rows):
            add_product(force, r[k.pushing + j], r, k.reach + j * width + i)
        put(force, r, k.f + i)
    if free:
        for i in range(0, width, LANES):
            arm = lanes()
            add_product(arm, 1.0, r, k.g + i)
            for j in range(rows):
                add_product(arm, r[k.arms + j], r, k.reach + j * width + i)
            put(arm, r, k.g + i)
        torque -= dot(r, k.raw, r, k.f, size)
        acceleration = torque / (inertia - dot(r, k.raw, r, k.g, size))
        for i in range(size):
            r[k.f + i] -= acceleration * r[k.g + i]
        for i in range(rows):
            r[k.one + i] -= acceleration * r[k.two + i]
    return acceleration


@njit(**EQUATIONS)
def write_rotor(y, dy, system, r, each, speed, acceleration):  # type: ignore[no-untyped-def]
    """The derivatives of all but the balls."""
    p = behind(system)
    size, width, table = int(r[COORDINATES]), int(r[WIDTH]), int(r[TABLE])
    rows = int(r[PLACES]) * each
    k = blocks(width, rows, table)
    rest = BALLS + 2 * p.balls.shape[0]
    frame_speed = speed if p.rotating == 1.0 else 0.0
    dy[THETA], dy[SPEED] = speed, acceleration
    dy[X], dy[Y] = r[k.v] + frame_speed * r[k.q + 1], r[k.v + 1] - frame_speed * r[k.q]
    dy[VX], dy[VY] = r[k.f] + frame_speed * r[k.v + 1], r[k.f + 1] - frame_speed * r[k.v]
    if frame_speed == 0.0:
        for i in range(2, size):
            dy[rest + i - 2], dy[rest + size - 4 + i] = r[k.v + i], r[k.f + i]
    else:
        for i in range(2, size, 2):
            dy[rest + i - 2], dy[rest + i - 1] = (
                r[k.v + i] + frame_speed * r[k.q + i + 1],
                r[k.v + i + 1] - frame_speed * r[k.q + i],
            )
            dy[rest + size - 4 + i] = r[k.f + i] + frame_speed * r[k.v + i + 1]
            dy[rest + size - 3 + i] = r[k.f + i + 1] - frame_speed * r[k.v + i]
