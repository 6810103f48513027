"""Equations of motion of a planar rotor with guided balls, any number of balls and races.

Spannan 2021, (4.14)-(4.17), derived again with the displaced fluid and its virtual mass, and with the balls
eliminated: a ball row reads ``I phi'' = r - s t.A - d w'``, so that only a symmetric system in the acceleration
A of the race center and the rotor acceleration w' remains. Symbols: s = m eps, t and n the tangential and radial
unit vectors at the ball, d = c + m eps E cos(gamma - phi), U the unbalance, a = A seen along the frame's axes.
"""

from __future__ import annotations

import math

from numba import float64, njit, void

from autobalancer.kernels.drive import drive_value, table_torque, unbalance_value
from autobalancer.kernels.system import (
    BALLS,
    DRAG,
    INERTIA,
    LEAN_X,
    LEAN_Y,
    MASS,
    MOMENT,
    OFFSET_X,
    OFFSET_Y,
    PRESCRIBED,
    PUSH,
    SPEED,
    SPIN,
    THETA,
    TWIST,
    VX,
    VY,
    Floats,
    System,
    X,
    Y,
    system_type,
    vector_type,
)


@njit(
    void(float64, vector_type, vector_type, system_type),
    cache=True,
    nogil=True,
    error_model="numpy",
    fastmath={"contract", "nsz", "arcp"},
)
def planar(time: float, y: Floats, dy: Floats, p: System) -> None:
    """Time derivative of the state of :mod:`autobalancer.kernels.system`."""
    count = p.balls.shape[0]
    speed, acceleration = y[SPEED], 0.0
    drive, drive_rate = drive_value(time, p)
    if p.drive == PRESCRIBED:
        speed, acceleration = drive, drive_rate

    # axes of the frame: rotor-fixed vectors appear turned by `turn`, space-fixed ones by `back`
    if p.rotating == 1.0:
        turn_cos, turn_sin, frame_speed = 1.0, 0.0, speed
    else:
        turn_cos, turn_sin, frame_speed = math.cos(y[THETA]), math.sin(y[THETA]), 0.0
    gx, gy = p.gravity_x, p.gravity_y
    if p.rotating == 1.0 and (gx != 0.0 or gy != 0.0):
        c, s = math.cos(y[THETA]), math.sin(y[THETA])
        gx, gy = c * gx + s * gy, c * gy - s * gx

    ux, uy = unbalance_value(time, p)
    ux, uy = turn_cos * ux - turn_sin * uy, turn_sin * ux + turn_cos * uy
    square = speed * speed
    force_x = -p.stiffness_x * y[X] - p.damping_x * y[VX] + ux * square
    force_y = -p.stiffness_y * y[Y] - p.damping_y * y[VY] + uy * square
    arm_x, arm_y = -uy, ux  # column that couples A with w'
    mass_xx, mass_xy, mass_yy = p.mass, 0.0, p.mass
    inertia = p.polar_inertia
    torque = ux * gy - uy * gx

    for i in range(count):
        angle, ball_speed = y[BALLS + i], y[BALLS + count + i]
        c, s = math.cos(angle), math.sin(angle)
        nx, ny = turn_cos * c - turn_sin * s, turn_sin * c + turn_cos * s
        tx, ty = -ny, nx
        moment, mass = p.balls[i, MOMENT], p.balls[i, MASS]
        row = moment * (tx * gx + ty * gy) - p.balls[i, DRAG] * ball_speed
        spin = p.balls[i, SPIN]
        in_space = speed + ball_speed
        lean_x, lean_y = moment * tx, moment * ty
        pull = moment * in_space * in_space
        force_x += pull * nx + mass * gx
        force_y += pull * ny + mass * gy
        torque += moment * (nx * gy - ny * gx)
        ec, es = p.balls[i, OFFSET_X], p.balls[i, OFFSET_Y]
        if ec != 0.0 or es != 0.0:
            along = moment * (ec * c + es * s)  # m eps E cos(gamma - phi)
            across = moment * (es * c - ec * s)  # m eps E sin(gamma - phi)
            ex, ey = turn_cos * ec - turn_sin * es, turn_sin * ec + turn_cos * es
            force_x += mass * ex * square
            force_y += mass * ey * square
            lean_x -= mass * ey
            lean_y += mass * ex
            row += across * square
            spin += along
            inertia += 2.0 * along
            torque += mass * (ex * gy - ey * gx) - across * ball_speed * (in_space + speed)
        p.balls[i, LEAN_X] = moment * tx
        p.balls[i, LEAN_Y] = moment * ty
        p.balls[i, PUSH] = row
        p.balls[i, TWIST] = spin
        inverse = 1.0 / p.balls[i, INERTIA]
        share = moment * inverse
        mass_xx -= moment * share * tx * tx
        mass_xy -= moment * share * tx * ty
        mass_yy -= moment * share * ty * ty
        force_x -= share * row * tx
        force_y -= share * row * ty
        arm_x += lean_x - share * spin * tx
        arm_y += lean_y - share * spin * ty
        inertia -= spin * spin * inverse
        torque -= spin * row * inverse

    determinant = 1.0 / (mass_xx * mass_yy - mass_xy * mass_xy)
    if p.drive != PRESCRIBED:
        torque += drive + table_torque(speed, p) - p.torque_damping * speed
        wx = (mass_yy * arm_x - mass_xy * arm_y) * determinant
        wy = (mass_xx * arm_y - mass_xy * arm_x) * determinant
        acceleration = (torque - wx * force_x - wy * force_y) / (inertia - wx * arm_x - wy * arm_y)
    force_x -= arm_x * acceleration
    force_y -= arm_y * acceleration
    ax = (mass_yy * force_x - mass_xy * force_y) * determinant
    ay = (mass_xx * force_y - mass_xy * force_x) * determinant

    dy[X] = y[VX] + frame_speed * y[Y]
    dy[Y] = y[VY] - frame_speed * y[X]
    dy[VX] = ax + frame_speed * y[VY]
    dy[VY] = ay - frame_speed * y[VX]
    dy[THETA] = speed
    dy[SPEED] = acceleration
    for i in range(count):
        push = p.balls[i, PUSH] - p.balls[i, LEAN_X] * ax - p.balls[i, LEAN_Y] * ay
        dy[BALLS + i] = y[BALLS + count + i]
        dy[BALLS + count + i] = (push - p.balls[i, TWIST] * acceleration) / p.balls[i, INERTIA]
