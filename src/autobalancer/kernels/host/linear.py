"""A linear rotor by itself, and what it does under the forces of its stations.

    M q'' + (C(w) + w G) q' + (K(w) + w' G/2) q = w^2 Re(u e^(i theta)) - w' d/d theta Re(u e^(i theta)) + sum B_p^T F_p

:func:`alone` works out q'' = f - w' g without the stations. The balls then give each station a force
F = R - S A - w' c, with A = B q'' its acceleration, and the torque a part T - t.A. :func:`together` solves

    (1 + H S) A = B f + H R - w' (B g + H c),    H = B M^-1 B^T,

twice as large as there are stations, and returns w'. With a prescribed speed w' is known and goes to f and R at once.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from autobalancer.kernels.compiler.flags import EQUATIONS_PART, INLINE, njit
from autobalancer.kernels.compiler.numba_struct import data, deref
from autobalancer.kernels.compiler.simd import LANES, add_product, lanes, put
from autobalancer.kernels.host.shaft_train import drive_value, motor_torque, unbalance_value
from autobalancer.kernels.records import PRESCRIBED
from autobalancer.kernels.system import BALLS, SPEED, THETA, VX, VY, System, X, Y, system_at
from autobalancer.kernels.trigonometry import sine_cosine


class Motion(NamedTuple):
    """The rotor as its balls see it, in the axes of the frame."""

    speed: float
    acceleration: float  # 0 where a torque drives: then w' is found together with the balls
    sine: float  # with the cosine: turns rotor-fixed vectors into the frame
    cosine: float
    gravity_x: float
    gravity_y: float
    torque: float  # of the drive, unless links follow, and of the weight of the unbalance


@njit(**INLINE)
def dot(one, i: int, other, j: int, count: int) -> float:  # type: ignore[no-untyped-def]
    """Product of ``count`` numbers from place i of one and j of the other."""
    total = 0.0
    for k in range(count):
        total += one[i + k] * other[j + k]
    return total


@njit(**INLINE)
def motion_of(time: float, y: Any, p: System) -> Motion:
    """The motion of the rotor at an instant, and the torque on it without its balls."""
    speed, acceleration = y[SPEED], 0.0
    drive, drive_rate = drive_value(time, p.drive)
    free = p.drive.kind != PRESCRIBED
    if not free:
        speed, acceleration = drive, drive_rate
    # axes of the frame: rotor-fixed vectors appear turned into them, space-fixed ones turned back
    gx, gy = p.gravity_x, p.gravity_y
    turn_sin, turn_cos = 0.0, 1.0
    if p.rotating != 1:
        turn_sin, turn_cos = sine_cosine(y[THETA])
    elif gx != 0.0 or gy != 0.0:
        s, c = sine_cosine(y[THETA])
        gx, gy = c * gx + s * gy, c * gy - s * gx
    # the torque matters only where the speed is free: motor, and weight of the unbalance
    torque = 0.0
    if free:
        ux, uy = unbalance_value(time, p.drive)
        torque = (turn_cos * ux - turn_sin * uy) * gy - (turn_sin * ux + turn_cos * uy) * gx
        if p.drive.linked == 0:
            torque += motor_torque(drive, speed, p.drive)
    return Motion(speed, acceleration, turn_sin, turn_cos, gx, gy, torque)


@njit(**EQUATIONS_PART)
def solve_free(time: float, y: Any, system: Any) -> Motion:
    """The rotor without its balls: fill f and g, and the stations' zeros."""
    p = deref(system_at(system))
    h, w = p.host, p.work
    size, width, table = h.size, h.width, h.speeds.shape[0]
    q, v, loads, speeds = data(w.q), data(w.v), data(h.loads), data(h.speeds)
    damping, stiffness, gyroscopic = data(h.damping), data(h.stiffness), data(h.gyroscopic)
    motion, free = motion_of(time, y, p), p.drive.kind != PRESCRIBED
    speed, acceleration, turn_sin, turn_cos = motion.speed, motion.acceleration, motion.sine, motion.cosine

    # the rotor by itself: q'' = f - w' g
    rest = BALLS + 2 * p.ball_count
    q[0], q[1], v[0], v[1] = y[X], y[Y], y[VX], y[VY]
    for i in range(2, size):
        q[i], v[i] = y[rest + i - 2], y[rest + size - 4 + i]
    # matrices over the speed: the row of the table below it, and the share of the next one
    square, turning = width * width, speed * speed
    row, share = 0, 0.0
    if table > 1:
        amount = min(abs(speed), speeds[table - 1])
        while row < table - 2 and speeds[row + 1] < amount:
            row += 1
        share = (amount - speeds[row]) / (speeds[row + 1] - speeds[row])
    near = row * square
    # unbalance: Re(u e^(i theta)) w^2 and its derivative with respect to theta, u as it has become since the segment began
    segment = p.drive.segments[p.drive.now[0]]
    load, since = 8 * width * p.drive.now[0], time - segment.start
    real, imaginary = turning * turn_cos + acceleration * turn_sin, acceleration * turn_cos - turning * turn_sin
    # eight coordinates at once: unbalance, then all that q and q' pull by stiffness, damping and gyroscopic effect
    for i in range(0, width, LANES):
        force = lanes()
        add_product(force, real, loads, load + i)
        add_product(force, imaginary, loads, load + width + i)
        for j in range(size):
            at = j * width + i
            add_product(force, -(1.0 - share) * q[j], stiffness, near + at)
            add_product(force, -(1.0 - share) * v[j], damping, near + at)
            add_product(force, -speed * v[j] - 0.5 * acceleration * q[j], gyroscopic, at)
        if share > 0.0:
            for j in range(size):
                at = j * width + i + square
                add_product(force, -share * q[j], stiffness, near + at)
                add_product(force, -share * v[j], damping, near + at)
        if segment.changing != 0:
            add_product(force, real * since, loads, load + 4 * width + i)
            add_product(force, imaginary * since, loads, load + 5 * width + i)
        put(force, data(w.f), i)
    # the column of w', and the torque on the rotor, where its speed is free
    if free:
        for i in range(0, width, LANES):
            arm, own_arm = lanes(), lanes()
            add_product(arm, -turn_sin, loads, load + i)
            add_product(arm, -turn_cos, loads, load + width + i)
            add_product(arm, -turn_sin * since, loads, load + 4 * width + i)
            add_product(arm, -turn_cos * since, loads, load + 5 * width + i)
            add_product(own_arm, -turn_sin, loads, load + 2 * width + i)
            add_product(own_arm, -turn_cos, loads, load + 3 * width + i)
            add_product(own_arm, -turn_sin * since, loads, load + 6 * width + i)
            add_product(own_arm, -turn_cos * since, loads, load + 7 * width + i)
            for j in range(size):
                add_product(arm, 0.5 * q[j], gyroscopic, j * width + i)
                add_product(own_arm, q[j], data(h.spin), j * width + i)
            put(arm, data(w.g), i)
            put(own_arm, data(w.own_g), i)

    # room for the balls, which come next
    push, arms, turns, inert = data(w.push), data(w.arm), data(w.turn), data(w.inert)
    for i in range(w.push.shape[0]):
        push[i], arms[i], turns[i] = 0.0, 0.0, 0.0
    for i in range(w.inert.size):
        inert[i] = 0.0
    return motion


@njit(**EQUATIONS_PART)
def solve_coupled(system: Any, acceleration: float, torque: float, inertia: float) -> float:
    """Accelerations of the stations (in ``work.one``) and of the coordinates (in f); returns w'."""
    p = deref(system_at(system))
    h, w = p.host, p.work
    size, width, places, rows, each = h.size, h.width, h.stations, h.rows.shape[0], w.inert.shape[1]
    place, mobility, reach = data(h.rows), data(h.mobility), data(h.reach)
    one, two, left, own = data(w.one), data(w.two), data(w.left), data(w.inert)
    push, arms, turns, f, g = data(w.push), data(w.arm), data(w.turn), data(w.f), data(w.g)
    # accelerations of the stations: what the balls pull there depends on them, so a small system
    free = p.drive.kind != PRESCRIBED
    for i in range(rows):
        at, line = i * width, i * rows
        one[i] = dot(place, at, f, 0, size) + dot(mobility, line, push, 0, rows)
        if free:
            two[i] = dot(place, at, g, 0, size) + dot(mobility, line, arms, 0, rows)
        for other in range(places):
            for j in range(each):
                total = 0.0
                for k in range(each):
                    total += mobility[line + other * each + k] * own[(other * each + k) * each + j]
                left[line + other * each + j] = total
        left[line + i] += 1.0
    if rows == 2:
        solve_two_by_two(left, one, two)
    else:
        solve_two(left, one, two, rows)

    # forces on the stations, put into the rotor
    for i in range(rows):
        first = (i // each) * each
        push[i] -= dot(own, i * each, one, first, each)
        if free:
            torque -= turns[i] * one[i]
            inertia -= turns[i] * two[i]
            arms[i] -= dot(own, i * each, two, first, each)
    # the forces move the rotor; last w', to which all is linear
    for i in range(0, width, LANES):
        force = lanes()
        add_product(force, 1.0, f, i)
        for j in range(rows):
            add_product(force, push[j], reach, j * width + i)
        put(force, f, i)
    if free:
        for i in range(0, width, LANES):
            arm = lanes()
            add_product(arm, 1.0, g, i)
            for j in range(rows):
                add_product(arm, arms[j], reach, j * width + i)
            put(arm, g, i)
        torque -= dot(data(w.own_g), 0, f, 0, size)
        acceleration = torque / (inertia - dot(data(w.own_g), 0, g, 0, size))
        for i in range(size):
            f[i] -= acceleration * g[i]
        for i in range(rows):
            one[i] -= acceleration * two[i]
    return acceleration


@njit(**EQUATIONS_PART)
def write_rotor(y: Any, dy: Any, system: Any, speed: float, acceleration: float) -> None:
    """The derivatives of all but the balls."""
    p = deref(system_at(system))
    size, q, v, f = p.host.size, data(p.work.q), data(p.work.v), data(p.work.f)
    rest = BALLS + 2 * p.ball_count
    frame_speed = speed if p.rotating == 1 else 0.0
    dy[THETA], dy[SPEED] = speed, acceleration
    dy[X], dy[Y] = v[0] + frame_speed * q[1], v[1] - frame_speed * q[0]
    dy[VX], dy[VY] = f[0] + frame_speed * v[1], f[1] - frame_speed * v[0]
    if frame_speed == 0.0:
        for i in range(2, size):
            dy[rest + i - 2], dy[rest + size - 4 + i] = v[i], f[i]
    else:
        for i in range(2, size, 2):
            dy[rest + i - 2], dy[rest + i - 1] = v[i] + frame_speed * q[i + 1], v[i + 1] - frame_speed * q[i]
            dy[rest + size - 4 + i] = f[i] + frame_speed * v[i + 1]
            dy[rest + size - 3 + i] = f[i + 1] - frame_speed * v[i]


# A small linear system with two right-hand sides, in place.


@njit(**EQUATIONS_PART)
def solve_two(left, one, two, size):  # type: ignore[no-untyped-def]
    """Gauss elimination with the greatest pivot; ``left`` by rows, answers in place of both right-hand sides."""
    for k in range(size):
        # exchange rows so that the greatest number is divided by
        pivot = k
        for i in range(k + 1, size):
            if abs(left[i * size + k]) > abs(left[pivot * size + k]):
                pivot = i
        if pivot != k:
            for j in range(k, size):
                left[k * size + j], left[pivot * size + j] = left[pivot * size + j], left[k * size + j]
            one[k], one[pivot] = one[pivot], one[k]
            two[k], two[pivot] = two[pivot], two[k]
        # clear the column below
        inverse = 1.0 / left[k * size + k]
        for i in range(k + 1, size):
            factor = left[i * size + k] * inverse
            for j in range(k + 1, size):
                left[i * size + j] -= factor * left[k * size + j]
            one[i] -= factor * one[k]
            two[i] -= factor * two[k]
    # back substitution for both right-hand sides
    for k in range(size - 1, -1, -1):
        for j in range(k + 1, size):
            one[k] -= left[k * size + j] * one[j]
            two[k] -= left[k * size + j] * two[j]
        inverse = 1.0 / left[k * size + k]
        one[k] *= inverse
        two[k] *= inverse


@njit(**INLINE)
def solve_two_by_two(left, one, two) -> None:  # type: ignore[no-untyped-def]
    """:func:`solve_two` for a matrix of two rows."""
    a, b, c, d = left[0], left[1], left[2], left[3]
    inverse = 1.0 / (a * d - b * c)
    x, y = one[0], one[1]
    one[0], one[1] = (d * x - b * y) * inverse, (a * y - c * x) * inverse
    x, y = two[0], two[1]
    two[0], two[1] = (d * x - b * y) * inverse, (a * y - c * x) * inverse
