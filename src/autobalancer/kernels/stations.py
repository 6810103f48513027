"""Equations of motion of any linear rotor with guided balls at any number of stations.

The balls are eliminated one by one as on the planar rotor, so that a station feels F = R - S A - w' c; the rotor is that
of :mod:`autobalancer.kernels.rotor_motion`.

A station has two rows (deflection), or four (slope too) where the balls move with their full inertia on a race that
tilts: to second order in the slope a ball at rho from the center then has the axial motion s = slope . rho, and less
reach across the axis, rho - s slope/2. With h = rho x rho' its kinetic energy grows by
m/2 ((slope' . rho)^2 + h (slope' x slope)). Without (Rodrigues et al. 2011, 1) balls feel the deflection of their
station only.
"""

from __future__ import annotations

from numba import njit

from autobalancer.kernels.contact import touch
from autobalancer.kernels.flags import EQUATIONS, INLINE
from autobalancer.kernels.pointers import behind, data
from autobalancer.kernels.rotor_layout import AXIAL_GRAVITY, COORDINATES, PLACES, TABLE, WIDTH, blocks
from autobalancer.kernels.rotor_motion import alone, dot, together, write_rotor
from autobalancer.kernels.system import (
    BALLS,
    CONTACT,
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
    SPIN,
    STATION,
    TWIST,
    Floats,
    System,
)
from autobalancer.kernels.trigonometry import sine_cosine


@njit(**INLINE)
def _derivative(time, y, dy, system, each) -> None:  # type: ignore[no-untyped-def]
    p = behind(system)
    balls, count = p.balls, p.balls.shape[0]
    r = data(p.rotor)
    size, width, table = int(r[COORDINATES]), int(r[WIDTH]), int(r[TABLE])
    rows = int(r[PLACES]) * each
    k = blocks(width, rows, table)
    free = p.drive != PRESCRIBED
    speed, acceleration, turn_sin, turn_cos, gx, gy, torque = alone(time, y, system, r, each)
    inertia, turning = p.polar_inertia, speed * speed

    touch(y, balls, count)
    for b in range(count):
        first = int(balls[b, STATION]) * each
        push_at, arm_at, turn_at, own_at = k.pushing + first, k.arms + first, k.turning + first, k.own + first * each
        mass, moment, spin = balls[b, MASS], balls[b, MOMENT], balls[b, SPIN]
        ball_speed = y[BALLS + count + b]
        in_space = speed + ball_speed
        s, c = sine_cosine(y[BALLS + b])
        nx, ny = turn_cos * c - turn_sin * s, turn_sin * c + turn_cos * s
        lean_x, lean_y = -moment * ny, moment * nx
        bound, push = balls[b, INERTIA], balls[b, CONTACT] - balls[b, DRAG] * ball_speed + lean_x * gx + lean_y * gy
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
            at = k.place + (first + 2) * width
            slope_x, slope_y = dot(r, at, r, k.q, size), dot(r, at + width, r, k.q, size)
            turn_x, turn_y = dot(r, at, r, k.v, size), dot(r, at + width, r, k.v, size)
            orbit = balls[b, ORBIT]
            rho_x, rho_y = ex + orbit * nx, ey + orbit * ny
            moving_x, moving_y = -speed * ey - in_space * orbit * ny, speed * ex + in_space * orbit * nx
            tilting = slope_y * turn_x - slope_x * turn_y
            skew = mass * orbit * (nx * ey - ny * ex)
            heave = mass * (turn_x * rho_x + turn_y * rho_y)
            weight = mass * (r[AXIAL_GRAVITY] + 0.5 * (gx * slope_x + gy * slope_y))
            push += speed * skew * tilting + orbit * heave * (turn_y * nx - turn_x * ny)
            push -= orbit * weight * (slope_y * nx - slope_x * ny)
            torque += heave * (turn_y * rho_x - turn_x * rho_y) - skew * ball_speed * tilting
            torque -= weight * (slope_y * rho_x - slope_x * rho_y)
            whole = 0.5 * mass * (rho_x * rho_x + rho_y * rho_y)
            own_arm = 0.5 * mass * orbit * (orbit + nx * ex + ny * ey)
            balls[b, LEAN_U], balls[b, LEAN_V] = own_arm * slope_y, -own_arm * slope_x
            known = 2.0 * mass * (turn_x * moving_x + turn_y * moving_y) + weight
            sag = 0.5 * mass * (slope_x * rho_x + slope_y * rho_y)
            spun = 0.5 * skew * (in_space * in_space - turning) + whole * acceleration
            r[push_at + 2] -= known * rho_x + sag * gx + spun * slope_y
            r[push_at + 3] -= known * rho_y + sag * gy - spun * slope_x
            for row in (arm_at, turn_at):
                r[row + 2] += whole * slope_y
                r[row + 3] -= whole * slope_x
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
            for at in (arm_at, turn_at):
                r[at] += arm_x - lean_x * twist
                r[at + 1] += arm_y - lean_y * twist
        if each == 4:
            lean_u, lean_v = balls[b, LEAN_U], balls[b, LEAN_V]
            share_u, share_v = lean_u * inverse, lean_v * inverse
            balls[b, LEAN_U], balls[b, LEAN_V] = share_u, share_v
            r[push_at + 2] -= lean_u * push
            r[push_at + 3] -= lean_v * push
            for at in (arm_at, turn_at):
                r[at + 2] -= lean_u * twist
                r[at + 3] -= lean_v * twist
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

    acceleration = together(system, r, each, acceleration, torque, inertia)
    write_rotor(y, dy, system, r, each, speed, acceleration)
    for b in range(count):
        first = k.one + int(balls[b, STATION]) * each
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
