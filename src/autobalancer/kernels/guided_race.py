"""Equations of motion with balls on real races: any drag law, fluid that lags, rolling resistance, rest by adherence,
balls that touch, races of any shape, shaken machines; on any linear rotor.

Symbols, in the axes of the frame: a ball at rho = E + eps n from the axis, its path tau = d rho/d phi with the length L
per angle, n_hat = -i tau/L outward normal. With A the acceleration of the station and k what is known of the rest,

    z'' = A + tau phi'' + i rho w' + k,    k = d tau/d phi phi'^2 + 2 i w tau phi' - w^2 rho
    I phi'' = r - m tau.A - c w' - f N,    N = -n_hat.m (z'' - g),    I = (inertia) L^2,    c = m rho x tau - j m r L

r holds centrifugal force, weight, drag and contact, N also what balls that touch press each other onto the wall; f = mu L is
the arm of rolling resistance against the motion. The normal force N depends on the accelerations itself: it is put in, which
leaves a system that is linear but no longer symmetric. A ball at rest on its race has phi'' = 0 instead, and
r - m tau.A - c w' is what must hold it.
Derived from the kinetic energy of ball, rotor and spin; with a circle and no friction it is kernels/stations.py.
"""

from __future__ import annotations

import math

from numba import njit

from autobalancer.kernels.contact import touch
from autobalancer.kernels.curves import drag_force, table_value
from autobalancer.kernels.flags import EQUATIONS
from autobalancer.kernels.pointers import behind, data
from autobalancer.kernels.race_layout import (
    CENTER_X,
    CENTER_Y,
    DRAG_CURVE,
    FIRST_MODE,
    LAG_TABLE,
    MASS_,
    MODE,
    MODE_NUMBERS,
    MODES,
    NEED,
    NORMAL,
    NORMAL_PUSH,
    NORMAL_TWIST,
    NORMAL_X,
    NORMAL_Y,
    ORBIT_,
    OWN_SPIN,
    PLACE_,
    RACE_COLUMNS,
    RAW_LEAN_X,
    RAW_LEAN_Y,
    RAW_PUSH,
    RAW_SPIN,
    ROLL,
    ROLLING,
    SHAPE,
    SLIPSTREAM,
    STRETCH,
    VISCOUS,
)
from autobalancer.kernels.race_shape import orbit
from autobalancer.kernels.rotor_layout import BALL_ROWS, PLACES, TABLE, WIDTH, blocks
from autobalancer.kernels.rotor_motion import alone, together, write_rotor
from autobalancer.kernels.shaking import shake
from autobalancer.kernels.slipstream import slipstream
from autobalancer.kernels.system import (
    BALLS,
    CONTACT,
    LEAN_X,
    LEAN_Y,
    OUTWARD,
    PRESCRIBED,
    PUSH,
    TWIST,
    Floats,
    System,
)
from autobalancer.kernels.trigonometry import sine_cosine


@njit(**EQUATIONS)
def real_race(time: float, y: Floats, dy: Floats, system: System) -> None:
    """Time derivative ``dy`` of the state ``y``: that of kernels/system.py, then the relaxation modes of each fluid."""
    if _rates(time, y, dy, system, False):
        _rates(time, y, dy, system, True)


@njit(**EQUATIONS)
def _rates(time, y, dy, system, pressed) -> bool:  # type: ignore[no-untyped-def]
    """The rates; balls rub where the known part of the normal force, or (``pressed``) that found before, is positive.

    Returns whether that was wrong for any ball.
    """
    p = behind(system)
    balls, count = p.balls, p.balls.shape[0]
    r = data(p.rotor)
    width, table = int(r[WIDTH]), int(r[TABLE])
    rows = int(r[PLACES]) * 2
    k = blocks(width, rows, table)
    free = p.drive != PRESCRIBED
    speed, acceleration, turn_sin, turn_cos, gx, gy, torque = alone(time, y, system, r, 2)
    inertia, square = p.polar_inertia, speed * speed

    gx, gy, torque = shake(time, y, system, r, turn_sin, turn_cos, gx, gy, torque)
    first_row = int(r[BALL_ROWS])
    touch(y, balls, count)
    for b in range(count):
        at = first_row + b * RACE_COLUMNS
        station = int(r[at + PLACE_]) * 2
        push_at, arm_at, turn_at, own_at = (
            k.pushing + station,
            k.arms + station,
            k.turning + station,
            k.own + station * 2,
        )
        mass, rate = r[at + MASS_], y[BALLS + count + b]
        s, c = sine_cosine(y[BALLS + b])
        radius, first, second = orbit(r, int(r[at + SHAPE]), r[at + ORBIT_], c, s)
        nx, ny = turn_cos * c - turn_sin * s, turn_sin * c + turn_cos * s
        ex = turn_cos * r[at + CENTER_X] - turn_sin * r[at + CENTER_Y]
        ey = turn_sin * r[at + CENTER_X] + turn_cos * r[at + CENTER_Y]
        rho_x, rho_y = ex + radius * nx, ey + radius * ny
        tau_x, tau_y = first * nx - radius * ny, first * ny + radius * nx
        bend_x, bend_y = (second - radius) * nx - 2.0 * first * ny, (second - radius) * ny + 2.0 * first * nx
        path = math.sqrt(radius * radius + first * first)
        out_x, out_y = tau_y / path, -tau_x / path
        growth = first * (second + radius)  # path times its derivative
        known_x = bend_x * rate * rate - 2.0 * speed * tau_y * rate - square * rho_x
        known_y = bend_y * rate * rate + 2.0 * speed * tau_x * rate - square * rho_y

        lag = 0.0
        modes = int(r[at + MODES])
        for i in range(modes):
            lag += y[int(r[at + FIRST_MODE]) + i]
        if r[at + LAG_TABLE] != 0.0:
            lag += table_value(r, int(r[at + LAG_TABLE]), time)
        through = path * (rate + lag)
        drag = drag_force(r, int(r[at + DRAG_CURVE]), r[at + VISCOUS], through)
        if r[at + SLIPSTREAM] != 0.0:
            drag *= slipstream(y, r, int(r[at + SLIPSTREAM]), through, abs(through))

        lean_x, lean_y = mass * tau_x, mass * tau_y
        spin = mass * (rho_x * tau_y - rho_y * tau_x) - r[at + ROLL] * path
        push = mass * square * (tau_x * rho_x + tau_y * rho_y) + lean_x * gx + lean_y * gy
        push += balls[b, CONTACT] - drag * path - r[at + STRETCH] * growth * rate * rate
        normal = mass * (out_x * (gx - known_x) + out_y * (gy - known_y)) + balls[b, OUTWARD]
        normal_twist = mass * (out_y * rho_x - out_x * rho_y)
        r[at + RAW_PUSH], r[at + RAW_SPIN], r[at + RAW_LEAN_X], r[at + RAW_LEAN_Y] = push, spin, lean_x, lean_y
        r[at + NORMAL_PUSH], r[at + NORMAL_TWIST] = normal, normal_twist
        r[at + NORMAL_X], r[at + NORMAL_Y] = mass * out_x, mass * out_y

        arm_x, arm_y = -mass * rho_y, mass * rho_x
        inertia += mass * (rho_x * rho_x + rho_y * rho_y) + r[at + OWN_SPIN]
        torque += mass * (rho_x * (gy - known_y) - rho_y * (gx - known_x)) + r[at + ROLL] * growth / path * rate * rate
        force_x, force_y = mass * (gx - known_x) - acceleration * arm_x, mass * (gy - known_y) - acceleration * arm_y
        inverse, rub, mode = 0.0, 0.0, r[at + MODE]
        if mode != 0.0:
            inverse = 1.0 / (r[at + STRETCH] * path * path)
            if (r[at + NORMAL] if pressed else normal) > 0.0:
                rub = mode * r[at + ROLLING] * path
        felt_x, felt_y = lean_x - rub * mass * out_x, lean_y - rub * mass * out_y
        felt_spin = spin - rub * normal_twist
        push = (push - rub * normal - felt_spin * acceleration) * inverse
        share_x, share_y, twist = felt_x * inverse, felt_y * inverse, felt_spin * inverse
        balls[b, PUSH], balls[b, TWIST], balls[b, LEAN_X], balls[b, LEAN_Y] = push, twist, share_x, share_y
        r[push_at] += force_x - lean_x * push
        r[push_at + 1] += force_y - lean_y * push
        r[own_at] += mass - lean_x * share_x
        r[own_at + 1] -= lean_x * share_y
        r[own_at + 2] -= lean_y * share_x
        r[own_at + 3] += mass - lean_y * share_y
        if free:
            inertia -= spin * twist
            torque -= spin * push
            r[arm_at] += arm_x - lean_x * twist
            r[arm_at + 1] += arm_y - lean_y * twist
            r[turn_at] += arm_x - spin * share_x
            r[turn_at + 1] += arm_y - spin * share_y

    acceleration = together(system, r, 2, acceleration, torque, inertia)
    write_rotor(y, dy, system, r, 2, speed, acceleration)
    wrong = False
    for b in range(count):
        at = first_row + b * RACE_COLUMNS
        station = k.one + int(r[at + PLACE_]) * 2
        ax, ay = r[station], r[station + 1]
        rate = balls[b, PUSH] - balls[b, LEAN_X] * ax - balls[b, LEAN_Y] * ay
        if free:
            rate -= balls[b, TWIST] * acceleration
        r[at + NEED] = (
            r[at + RAW_PUSH] - r[at + RAW_LEAN_X] * ax - r[at + RAW_LEAN_Y] * ay - r[at + RAW_SPIN] * acceleration
        )
        normal = (
            r[at + NORMAL_PUSH] - r[at + NORMAL_X] * ax - r[at + NORMAL_Y] * ay - r[at + NORMAL_TWIST] * acceleration
        )
        if r[at + ROLLING] > 0.0 and r[at + MODE] != 0.0:
            wrong = wrong or (normal > 0.0) != (r[at + NORMAL_PUSH] > 0.0)
        r[at + NORMAL] = normal
        dy[BALLS + b] = y[BALLS + count + b]
        dy[BALLS + count + b] = rate
        modes, state = int(r[at + MODES]), int(r[at + FIRST_MODE])
        for i in range(modes):
            numbers = int(r[at + MODE_NUMBERS])
            dy[state + i] = r[numbers + modes + i] * acceleration - r[numbers + i] * y[state + i]
    return wrong
