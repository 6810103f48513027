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
from autobalancer.kernels.elimination import solve_two, solve_two_by_two
from autobalancer.kernels.flags import EQUATIONS, INLINE
from autobalancer.kernels.lanes import LANES, add_product, lanes, put
from autobalancer.kernels.pointers import behind, data
from autobalancer.kernels.system import (
    BALLS,
    DRAG,
    INERTIA,
    LEAN_U,
    LEAN_V,
    LEAN_X,
    LEAN_Y,
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
    loads of each segment: u times M^-1 (real, imaginary part), u, and the rates of all four, the last number of which,
    beyond the coordinates, says whether they change.
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
    loads = work + 5 * width + rows * (rows + 8)
    return gyroscopic, damping, stiffness, spin, place, reach, host, work, loads


@njit(**INLINE)
def _dot(one, i: int, other, j: int, count: int) -> float:  # type: ignore[no-untyped-def]
    total = 0.0
    for k in range(count):
        total += one[i + k] * other[j + k]
    return total


@njit(**INLINE)
def _derivative(time, y, dy, system, each) -> None:  # type: ignore[no-untyped-def]
    p = behind(system)
    balls, count = p.balls, p.balls.shape[0]
    r = data(p.rotor)
    size, width, places, table = int(r[COORDINATES]), int(r[WIDTH]), int(r[PLACES]), int(r[TABLE])
    rows = places * each
    gyroscopic, damping, stiffness, spinning, place, reach, host, work, loads = blocks(width, rows, table)
    q, v, f, g, raw = work, work + width, work + 2 * width, work + 3 * width, work + 4 * width
    left = work + 5 * width
    one, two = left + rows * rows, left + rows * (rows + 1)
    pushing, arms, own = left + rows * (rows + 2), left + rows * (rows + 3), left + rows * (rows + 4)
    # with a prescribed speed w' is known and goes to the forces at once; else all is linear in it
    free = p.drive != PRESCRIBED
    speed, acceleration = y[SPEED], 0.0
    drive, drive_rate = drive_value(time, p)
    if not free:
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
    square, turning = width * width, speed * speed
    row, share = 0, 0.0
    if table > 1:
        amount = min(abs(speed), r[HEADER + table - 1])
        while row < table - 2 and r[HEADER + row + 1] < amount:
            row += 1
        share = (amount - r[HEADER + row]) / (r[HEADER + row + 1] - r[HEADER + row])
    near_c, near_k = damping + row * square, stiffness + row * square
    # Re(u e^(i theta)) w^2 and its derivative with respect to theta
    load, since = loads + 8 * width * p.now[0], time - p.segments[p.now[0], START]
    changing = r[load + 8 * width - 1] != 0.0
    real, imaginary = turning * turn_cos + acceleration * turn_sin, acceleration * turn_cos - turning * turn_sin
    for i in range(0, width, LANES):
        force = lanes()
        add_product(force, real, r, load + i)
        add_product(force, imaginary, r, load + width + i)
        for j in range(size):
            at = j * width + i
            add_product(force, -(1.0 - share) * r[q + j], r, near_k + at)
            add_product(force, -(1.0 - share) * r[v + j], r, near_c + at)
            add_product(force, -speed * r[v + j] - 0.5 * acceleration * r[q + j], r, gyroscopic + at)
        if share > 0.0:
            for j in range(size):
                at = j * width + i + square
                add_product(force, -share * r[q + j], r, near_k + at)
                add_product(force, -share * r[v + j], r, near_c + at)
        if changing:
            add_product(force, real * since, r, load + 4 * width + i)
            add_product(force, imaginary * since, r, load + 5 * width + i)
        put(force, r, f + i)
    inertia, torque = p.polar_inertia, 0.0
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
                add_product(arm, 0.5 * r[q + j], r, gyroscopic + j * width + i)
                add_product(own_arm, r[q + j], r, spinning + j * width + i)
            put(arm, r, g + i)
            put(own_arm, r, raw + i)
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
        force_x, force_y, arm_x, arm_y = pull * nx + mass * gx, pull * ny + mass * gy, lean_x, lean_y
        torque += lean_x * gx + lean_y * gy
        ec, es = balls[b, OFFSET_X], balls[b, OFFSET_Y]
        ex, ey = 0.0, 0.0
        if ec != 0.0 or es != 0.0:
            along = moment * (ec * c + es * s)
            across = moment * (es * c - ec * s)
            ex, ey = turn_cos * ec - turn_sin * es, turn_sin * ec + turn_cos * es
            force_x += mass * ex * turning
            force_y += mass * ey * turning
            arm_x -= mass * ey
            arm_y += mass * ex
            push += across * turning
            spin += along
            inertia += 2.0 * along
            torque += mass * (ex * gy - ey * gx) - across * ball_speed * (in_space + speed)
        if each == 4:
            # the axial motion of the ball: s = slope . rho, s'' = slope''.rho + a phi'' + u w' + known
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
            bound += mass * a * a
            push -= mass * a * known
            spin += mass * a * u
            inertia += mass * u * u
            torque -= mass * u * known
            pressed, carried = mass * (known + u * acceleration), mass * u
            balls[b, LEAN_U], balls[b, LEAN_V] = mass * a * rho_x, mass * a * rho_y
            r[push_at + 2] -= pressed * rho_x
            r[push_at + 3] -= pressed * rho_y
            r[arm_at + 2] += carried * rho_x
            r[arm_at + 3] += carried * rho_y
            r[own_at + 2 * each + 2] += mass * rho_x * rho_x
            r[own_at + 2 * each + 3] += mass * rho_x * rho_y
            r[own_at + 3 * each + 2] += mass * rho_x * rho_y
            r[own_at + 3 * each + 3] += mass * rho_y * rho_y
        inverse = 1.0 / bound
        push, twist = (push - spin * acceleration) * inverse, spin * inverse
        balls[b, PUSH], balls[b, TWIST] = push, twist
        share_x, share_y = lean_x * inverse, lean_y * inverse
        balls[b, LEAN_X], balls[b, LEAN_Y] = share_x, share_y
        r[push_at] += force_x - acceleration * arm_x - lean_x * push
        r[push_at + 1] += force_y - acceleration * arm_y - lean_y * push
        r[own_at] += mass - lean_x * share_x
        r[own_at + 1] -= lean_x * share_y
        r[own_at + each] -= lean_x * share_y
        r[own_at + each + 1] += mass - lean_y * share_y
        if free:
            inertia -= spin * twist
            torque -= spin * push
            r[arm_at] += arm_x - lean_x * twist
            r[arm_at + 1] += arm_y - lean_y * twist
        if each == 4:
            lean_u, lean_v = balls[b, LEAN_U], balls[b, LEAN_V]
            share_u, share_v = lean_u * inverse, lean_v * inverse
            balls[b, LEAN_U], balls[b, LEAN_V] = share_u, share_v
            r[push_at + 2] -= lean_u * push
            r[push_at + 3] -= lean_v * push
            r[arm_at + 2] -= lean_u * twist
            r[arm_at + 3] -= lean_v * twist
            for i in range(2):
                lean = lean_x if i == 0 else lean_y
                r[own_at + i * each + 2] -= lean * share_u
                r[own_at + i * each + 3] -= lean * share_v
                r[own_at + 2 * each + i] -= lean * share_u
                r[own_at + 3 * each + i] -= lean * share_v
            r[own_at + 2 * each + 2] -= lean_u * share_u
            r[own_at + 2 * each + 3] -= lean_u * share_v
            r[own_at + 3 * each + 2] -= lean_u * share_v
            r[own_at + 3 * each + 3] -= lean_v * share_v

    # (1 + H S) A = B f + H R - w' (B g + H c), solved for both right-hand sides: A = a - b w'
    for i in range(rows):
        at, line = place + i * width, host + i * rows
        r[one + i] = _dot(r, at, r, f, size) + _dot(r, line, r, pushing, rows)
        if free:
            r[two + i] = _dot(r, at, r, g, size) + _dot(r, line, r, arms, rows)
        for other in range(places):
            for j in range(each):
                total = 0.0
                for k in range(each):
                    total += r[line + other * each + k] * r[own + (other * each + k) * each + j]
                r[left + i * rows + other * each + j] = total
        r[left + i * rows + i] += 1.0
    if rows == 2:
        solve_two_by_two(r, left, one, two)
    else:
        solve_two(r, left, one, two, rows)

    # forces on the stations, put into the rotor
    for i in range(rows):
        first = (i // each) * each
        r[pushing + i] -= _dot(r, own + i * each, r, one + first, each)
        if free:
            torque -= r[arms + i] * r[one + i]
            inertia -= r[arms + i] * r[two + i]
            r[arms + i] -= _dot(r, own + i * each, r, two + first, each)
    for i in range(0, width, LANES):
        force = lanes()
        add_product(force, 1.0, r, f + i)
        for j in range(rows):
            add_product(force, r[pushing + j], r, reach + j * width + i)
        put(force, r, f + i)
    if free:
        for i in range(0, width, LANES):
            arm = lanes()
            add_product(arm, 1.0, r, g + i)
            for j in range(rows):
                add_product(arm, r[arms + j], r, reach + j * width + i)
            put(arm, r, g + i)
        torque += drive + table_torque(speed, p) - p.torque_damping * speed
        torque -= _dot(r, raw, r, f, size)
        acceleration = torque / (inertia - _dot(r, raw, r, g, size))
        for i in range(size):
            r[f + i] -= acceleration * r[g + i]
        for i in range(rows):
            r[one + i] -= acceleration * r[two + i]

    dy[THETA], dy[SPEED] = speed, acceleration
    dy[X], dy[Y] = r[v] + frame_speed * r[q + 1], r[v + 1] - frame_speed * r[q]
    dy[VX], dy[VY] = r[f] + frame_speed * r[v + 1], r[f + 1] - frame_speed * r[v]
    if frame_speed == 0.0:
        for i in range(2, size):
            dy[rest + i - 2], dy[rest + size - 4 + i] = r[v + i], r[f + i]
    else:
        for i in range(2, size, 2):
            dy[rest + i - 2], dy[rest + i - 1] = (
                r[v + i] + frame_speed * r[q + i + 1],
                r[v + i + 1] - frame_speed * r[q + i],
            )
            dy[rest + size - 4 + i] = r[f + i] + frame_speed * r[v + i + 1]
            dy[rest + size - 3 + i] = r[f + i + 1] - frame_speed * r[v + i]
    for b in range(count):
        first = one + int(balls[b, STATION]) * each
        rate = balls[b, PUSH] - balls[b, LEAN_X] * r[first] - balls[b, LEAN_Y] * r[first + 1]
        if each == 4:
            rate -= balls[b, LEAN_U] * r[first + 2] + balls[b, LEAN_V] * r[first + 3]
        if free:
            rate -= balls[b, TWIST] * acceleration
        dy[BALLS + b] = y[BALLS + count + b]
        dy[BALLS + count + b] = rate


@njit(**EQUATIONS)
def spatial(time: float, y: Floats, dy: Floats, system: System) -> None:
    """Time derivative ``dy`` of the state ``y`` of :mod:`autobalancer.kernels.system`; balls feel deflections."""
    _derivative(time, y, dy, system, 2)


@njit(**EQUATIONS)
def spatial_full(time: float, y: Floats, dy: Floats, system: System) -> None:
    """The same where balls feel the tilt of their race too."""
    _derivative(time, y, dy, system, 4)
