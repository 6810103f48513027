"""Equations of motion of any linear rotor with guided balls at any number of stations.

    M q'' + (C(w) + w G) q' + (K(w) + w' G/2) q = w^2 Re(u e^(i theta)) - w' d/d theta Re(u e^(i theta)) + sum B_p^T F_p

The balls are eliminated one by one as on the planar rotor, so that a station feels F = R - S A - w' c, with its
acceleration A = B q''. With H = B M^-1 B^T only (1 + H S) A = B f + H R - w' (B g + H c) is left to be solved, twice as
large as there are stations. All matrices come multiplied by M^-1.

A station has two rows (deflection), or four (slope too) where the balls move with their full inertia on a race that
tilts: then a ball at rho from the axis has the axial acceleration -(s'') of s = slope . rho, and presses with m s''.
Without it (Rodrigues et al. 2011, 1) balls feel the deflection of their station only.

Layout of ``System.rotor``: :data:`COORDINATES` and the other header places, then the blocks that :func:`blocks` lists.
"""

from __future__ import annotations

from numba import njit

from autobalancer.kernels.drive import drive_value, table_torque, unbalance_value
from autobalancer.kernels.elimination import solve_two
from autobalancer.kernels.flags import EQUATIONS, INLINE
from autobalancer.kernels.lanes import LANES, add_product, lanes, put
from autobalancer.kernels.pointers import behind, data
from autobalancer.kernels.system import (
    BALLS,
    DRAG,
    INERTIA,
    LEAN_X,
    MASS,
    MOMENT,
    OFFSET_X,
    OFFSET_Y,
    ORBIT,
    PRESCRIBED,
    PUSH,
    SPEED,
    SPIN,
    START,
    STATION,
    THETA,
    TWIST,
    VX,
    VY,
    Floats,
    System,
    X,
    Y,
)
from autobalancer.kernels.trigonometry import sine_cosine

# header of System.rotor
COORDINATES, WIDTH, PLACES, ROWS, TABLE, AXIAL_GRAVITY, HEADER = range(7)


@njit(**INLINE)
def blocks(width: int, rows: int, table: int):  # type: ignore[no-untyped-def]
    """Where the blocks of ``System.rotor`` begin.

    ``width`` is the number of coordinates rounded up to whole lanes, ``rows`` of all stations together. Blocks: speeds of
    the table; G; C and K at each speed (matrices column by column, times M^-1); M N, N = G/2; rows B; B M^-1; H; work;
    loads of each segment: u times M^-1 (real, imaginary part), u, and the rates of all four.
    """
    square = width * width
    gyroscopic = HEADER + table
    damping = gyroscopic + square
    stiffness = damping + table * square
    spin = stiffness + table * square
    place = spin + square
    reach = place + rows * width
    host = reach + rows * width
    work = host + rows * rows
    loads = work + 6 * width + rows * (rows + 8)
    return gyroscopic, damping, stiffness, spin, place, reach, host, work, loads


@njit(**INLINE)
def _dot(one, i: int, other, j: int, count: int) -> float:  # type: ignore[no-untyped-def]
    total = 0.0
    for k in range(count):
        total += one[i + k] * other[j + k]
    return total


@njit(**EQUATIONS)
def spatial(time: float, y: Floats, dy: Floats, system: System) -> None:
    """Time derivative ``dy`` of the state ``y`` of :mod:`autobalancer.kernels.system`."""
    p = behind(system)
    balls, count = p.balls, p.balls.shape[0]
    r = data(p.rotor)
    size, width, places = int(r[COORDINATES]), int(r[WIDTH]), int(r[PLACES])
    each, table = int(r[ROWS]), int(r[TABLE])
    rows = places * each
    gyroscopic, damping, stiffness, spinning, place, reach, host, work, loads = blocks(width, rows, table)
    q, v, f, g, raw, answer = work, work + width, work + 2 * width, work + 3 * width, work + 4 * width, work + 5 * width
    left = work + 6 * width  # station rows: matrix, force R, arm c, own mass S by row, slopes
    right_a, right_b, pushing, arms = left + rows * rows, left + rows * (rows + 1), left + rows * (rows + 2), 0
    arms = pushing + rows
    own = arms + rows  # S, `each` columns
    speed, acceleration = y[SPEED], 0.0
    drive, drive_rate = drive_value(time, p)
    if p.drive == PRESCRIBED:
        speed, acceleration = drive, drive_rate

    gx, gy = p.gravity_x, p.gravity_y
    turn_sin, turn_cos, frame_speed = 0.0, 1.0, speed
    if p.rotating != 1.0:
        turn_sin, turn_cos = sine_cosine(y[THETA])
        frame_speed = 0.0
    elif gx != 0.0 or gy != 0.0:
        s, c = sine_cosine(y[THETA])
        gx, gy = c * gx + s * gy, c * gy - s * gx

    # the rotor by itself: q'' = f - w' g
    rest = BALLS + 2 * count
    r[q], r[q + 1], r[v], r[v + 1] = y[X], y[Y], y[VX], y[VY]
    for i in range(2, size):
        r[q + i], r[v + i] = y[rest + i - 2], y[rest + size - 4 + i]
    segment, share, square = p.now[0], 0.0, width * width
    since = time - p.segments[segment, START]
    load = loads + 8 * width * segment
    row = 0
    if table > 1:
        amount = min(abs(speed), r[HEADER + table - 1])
        while row < table - 2 and r[HEADER + row + 1] < amount:
            row += 1
        share = (amount - r[HEADER + row]) / (r[HEADER + row + 1] - r[HEADER + row])
    kept = 1.0 - share
    near_c, near_k = damping + row * square, stiffness + row * square
    turning = speed * speed
    for i in range(0, width, LANES):
        force = lanes()
        for j in range(size):
            at = j * width + i
            add_product(force, -kept * r[q + j], r, near_k + at)
            add_product(force, -kept * r[v + j], r, near_c + at)
            add_product(force, -speed * r[v + j], r, gyroscopic + at)
            if share > 0.0:
                add_product(force, -share * r[q + j], r, near_k + square + at)
                add_product(force, -share * r[v + j], r, near_c + square + at)
        add_product(force, turning * turn_cos, r, load + i)
        add_product(force, -turning * turn_sin, r, load + width + i)
        add_product(force, turning * turn_cos * since, r, load + 4 * width + i)
        add_product(force, -turning * turn_sin * since, r, load + 5 * width + i)
        put(force, r, f + i)
        arm = lanes()
        add_product(arm, -turn_sin, r, load + i)
        add_product(arm, -turn_cos, r, load + width + i)
        add_product(arm, -turn_sin * since, r, load + 4 * width + i)
        add_product(arm, -turn_cos * since, r, load + 5 * width + i)
        for j in range(size):
            add_product(arm, 0.5 * r[q + j], r, gyroscopic + j * width + i)
        put(arm, r, g + i)

    inertia, torque = p.polar_inertia, 0.0
    if p.drive != PRESCRIBED:
        for i in range(0, width, LANES):
            arm = lanes()
            add_product(arm, -turn_sin, r, load + 2 * width + i)
            add_product(arm, -turn_cos, r, load + 3 * width + i)
            add_product(arm, -turn_sin * since, r, load + 6 * width + i)
            add_product(arm, -turn_cos * since, r, load + 7 * width + i)
            for j in range(size):
                add_product(arm, r[q + j], r, spinning + j * width + i)
            put(arm, r, raw + i)
        ux, uy = unbalance_value(time, p)
        torque = (turn_cos * ux - turn_sin * uy) * gy - (turn_sin * ux + turn_cos * uy) * gx

    for i in range(rows * (each + 2)):
        r[pushing + i] = 0.0

    for b in range(count):
        first = int(balls[b, STATION]) * each
        push_at, arm_at, own_at = pushing + first, arms + first, own + first * each
        mass, moment, spin = balls[b, MASS], balls[b, MOMENT], balls[b, SPIN]
        ball_speed = y[BALLS + count + b]
        in_space = speed + ball_speed
        s, c = sine_cosine(y[BALLS + b])
        nx, ny = turn_cos * c - turn_sin * s, turn_sin * c + turn_cos * s
        lean_x, lean_y = -moment * ny, moment * nx
        bound, push = balls[b, INERTIA], -balls[b, DRAG] * ball_speed + lean_x * gx + lean_y * gy
        pull = moment * in_space * in_space
        r[push_at] += pull * nx + mass * gx
        r[push_at + 1] += pull * ny + mass * gy
        r[arm_at] += lean_x
        r[arm_at + 1] += lean_y
        r[own_at] += mass
        r[own_at + each + 1] += mass
        torque += lean_x * gx + lean_y * gy
        ec, es = balls[b, OFFSET_X], balls[b, OFFSET_Y]
        ex, ey = 0.0, 0.0
        if ec != 0.0 or es != 0.0:
            along = moment * (ec * c + es * s)
            across = moment * (es * c - ec * s)
            ex, ey = turn_cos * ec - turn_sin * es, turn_sin * ec + turn_cos * es
            r[push_at] += mass * ex * turning
            r[push_at + 1] += mass * ey * turning
            r[arm_at] -= mass * ey
            r[arm_at + 1] += mass * ex
            push += across * turning
            spin += along
            inertia += 2.0 * along
            torque += mass * (ex * gy - ey * gx) - across * ball_speed * (in_space + speed)
        lean_u, lean_v = 0.0, 0.0
        if each == 4:
            # the axial motion of the ball: s = slope . rho, s'' = slope''.rho + a phi'' + u w' + known
            slope_x, slope_y, turn_x, turn_y = 0.0, 0.0, 0.0, 0.0
            at = place + (first + 2) * width
            slope_x, slope_y = _dot(r, at, r, q, size), _dot(r, at + width, r, q, size)
            turn_x, turn_y = _dot(r, at, r, v, size), _dot(r, at + width, r, v, size)
            orbit = balls[b, ORBIT]
            rho_x, rho_y = ex + orbit * nx, ey + orbit * ny
            a = orbit * (slope_y * nx - slope_x * ny)
            u = a + slope_y * ex - slope_x * ey
            moving_x, moving_y = -speed * ey - in_space * orbit * ny, speed * ex + in_space * orbit * nx
            known = 2.0 * (turn_x * moving_x + turn_y * moving_y) + r[AXIAL_GRAVITY]
            known -= turning * (slope_x * ex + slope_y * ey)
            known -= in_space * in_space * orbit * (slope_x * nx + slope_y * ny)
            lean_u, lean_v = mass * a * rho_x, mass * a * rho_y
            bound += mass * a * a
            push -= mass * a * known
            spin += mass * a * u
            inertia += mass * u * u
            torque -= mass * u * known
            r[push_at + 2] -= mass * known * rho_x
            r[push_at + 3] -= mass * known * rho_y
            r[arm_at + 2] += mass * u * rho_x
            r[arm_at + 3] += mass * u * rho_y
            r[own_at + 2 * each + 2] += mass * rho_x * rho_x
            r[own_at + 2 * each + 3] += mass * rho_x * rho_y
            r[own_at + 3 * each + 2] += mass * rho_x * rho_y
            r[own_at + 3 * each + 3] += mass * rho_y * rho_y
        inverse = 1.0 / bound
        push, twist = push * inverse, spin * inverse
        inertia -= spin * twist
        torque -= spin * push
        balls[b, PUSH], balls[b, TWIST] = push, twist
        for i in range(each):
            lean = lean_x if i == 0 else lean_y if i == 1 else lean_u if i == 2 else lean_v
            balls[b, LEAN_X + i] = lean * inverse
            r[push_at + i] -= lean * push
            r[arm_at + i] -= lean * twist
            for j in range(each):
                other = lean_x if j == 0 else lean_y if j == 1 else lean_u if j == 2 else lean_v
                r[own_at + i * each + j] -= lean * other * inverse

    # (1 + H S) A = B f + H R - w' (B g + H c), solved for both right-hand sides: A = a - b w'
    for i in range(rows):
        at, line = place + i * width, host + i * rows
        r[right_a + i] = _dot(r, at, r, f, size) + _dot(r, line, r, pushing, rows)
        r[right_b + i] = _dot(r, at, r, g, size) + _dot(r, line, r, arms, rows)
        for other in range(places):
            for j in range(each):
                total = 0.0
                for k in range(each):
                    total += r[line + other * each + k] * r[own + (other * each + k) * each + j]
                r[left + i * rows + other * each + j] = total
        r[left + i * rows + i] += 1.0
    solve_two(r, left, right_a, right_b, rows)

    # forces on the stations, put into the rotor
    for i in range(rows):
        first = (i // each) * each
        r[pushing + i] -= _dot(r, own + i * each, r, right_a + first, each)
        r[answer] = r[arms + i]
        r[arms + i] -= _dot(r, own + i * each, r, right_b + first, each)
        if p.drive != PRESCRIBED:
            torque -= r[answer] * r[right_a + i]
            inertia -= r[answer] * r[right_b + i]
    for i in range(0, width, LANES):
        force, arm = lanes(), lanes()
        add_product(force, 1.0, r, f + i)
        add_product(arm, 1.0, r, g + i)
        for j in range(rows):
            add_product(force, r[pushing + j], r, reach + j * width + i)
            add_product(arm, r[arms + j], r, reach + j * width + i)
        put(force, r, f + i)
        put(arm, r, g + i)
    if p.drive != PRESCRIBED:
        torque += drive + table_torque(speed, p) - p.torque_damping * speed
        torque -= _dot(r, raw, r, f, size)
        acceleration = torque / (inertia - _dot(r, raw, r, g, size))

    dy[THETA], dy[SPEED] = speed, acceleration
    dy[X], dy[Y] = r[v] + frame_speed * r[q + 1], r[v + 1] - frame_speed * r[q]
    dy[VX] = r[f] - acceleration * r[g] + frame_speed * r[v + 1]
    dy[VY] = r[f + 1] - acceleration * r[g + 1] - frame_speed * r[v]
    for i in range(2, size):
        other, way = i + 1 - 2 * (i % 2), frame_speed * (1 - 2 * (i % 2))
        fast, turned = 0.0, 0.0
        if frame_speed != 0.0:
            fast, turned = way * r[q + other], way * r[v + other]
        dy[rest + i - 2] = r[v + i] + fast
        dy[rest + size - 4 + i] = r[f + i] - acceleration * r[g + i] + turned
    for b in range(count):
        first = int(balls[b, STATION]) * each
        free, bound = balls[b, PUSH], balls[b, TWIST]
        for i in range(each):
            free -= balls[b, LEAN_X + i] * r[right_a + first + i]
            bound -= balls[b, LEAN_X + i] * r[right_b + first + i]
        dy[BALLS + b] = y[BALLS + count + b]
        dy[BALLS + count + b] = free - bound * acceleration
