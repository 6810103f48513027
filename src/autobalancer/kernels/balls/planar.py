"""Equations of motion of a planar rotor with guided balls on smooth circles: the fast path of kernels/balls/guided.py.

Spannan 2021, (4.14)-(4.17), derived again with the displaced fluid and its virtual mass, and with the balls
eliminated: a ball row reads ``I phi'' = r - s t.A - d w'``, so that only a symmetric system in the acceleration
A of the race center and the rotor acceleration w' remains. Symbols: s = m eps, t and n the tangential and radial
unit vectors at the ball, d = c + m eps E cos(gamma - phi), U the unbalance, a = A seen along the frame's axes.
"""

from __future__ import annotations

from typing import Any

from autobalancer.kernels.balls.ball_forces import push_planar
from autobalancer.kernels.balls.guided import touch
from autobalancer.kernels.balls.rigid_torques import bind_planar, press_planar
from autobalancer.kernels.compiler.cache import njit
from autobalancer.kernels.compiler.flags import EQUATIONS
from autobalancer.kernels.compiler.numba_struct import deref
from autobalancer.kernels.host.shaft_train import drive_value, motor_torque, unbalance_value
from autobalancer.kernels.records import PRESCRIBED
from autobalancer.kernels.system import BALLS, SPEED, THETA, VX, VY, X, Y, system_at
from autobalancer.kernels.trigonometry import sine_cosine


@njit(**EQUATIONS)
def planar(time: float, y: Any, dy: Any, system: Any) -> None:
    """Time derivative ``dy`` of the state ``y`` of :mod:`autobalancer.kernels.system`."""
    p = deref(system_at(system))
    rotor, count = p.planar, p.ball_count
    x1, y1, vx, vy = y[X], y[Y], y[VX], y[VY]
    speed, acceleration = y[SPEED], 0.0
    drive, drive_rate = drive_value(time, p.drive)
    if p.drive.kind == PRESCRIBED:
        speed, acceleration = drive, drive_rate

    # axes of the frame: rotor-fixed vectors appear turned by `turn`, space-fixed ones by its inverse
    gx, gy = p.gravity_x, p.gravity_y
    heavy = gx != 0.0 or gy != 0.0
    turn_sin, turn_cos, frame_speed = 0.0, 1.0, speed
    if p.rotating != 1:
        turn_sin, turn_cos = sine_cosine(y[THETA])
        frame_speed = 0.0
    elif heavy:
        s, c = sine_cosine(y[THETA])
        gx, gy = c * gx + s * gy, c * gy - s * gx

    # the rotor by itself, its balls held
    ux, uy = unbalance_value(time, p.drive)
    ux, uy = turn_cos * ux - turn_sin * uy, turn_sin * ux + turn_cos * uy
    square = speed * speed
    force_x = -rotor.stiffness_x * x1 - rotor.damping_x * vx + ux * square
    force_y = -rotor.stiffness_y * y1 - rotor.damping_y * vy + uy * square
    arm_x, arm_y = -uy, ux  # column that couples A with w'
    mass_xx, mass_xy, mass_yy = rotor.mass, 0.0, rotor.mass
    inertia = p.polar_inertia
    torque = ux * gy - uy * gx

    # what touches or pushes the balls, then ball by ball its row
    touch(y, p)
    if p.forces.shape[0] > 0:
        push_planar(y, system, speed)
    for i in range(count):
        ball, moving = p.balls[i], p.guided[i]
        ball_speed = y[BALLS + count + i]
        in_space = speed + ball_speed
        moment, spin = ball.moment, ball.spin
        s, c = sine_cosine(y[BALLS + i])
        nx, ny = turn_cos * c - turn_sin * s, turn_sin * c + turn_cos * s
        lean_x, lean_y = -moment * ny, moment * nx
        row = moving.contact - ball.drag * ball_speed
        pull = moment * in_space * in_space
        force_x += pull * nx
        force_y += pull * ny
        arm_x += lean_x
        arm_y += lean_y
        if heavy:
            row += lean_x * gx + lean_y * gy
            force_x += ball.mass * gx
            force_y += ball.mass * gy
            torque += lean_x * gx + lean_y * gy
        ec, es = ball.center_x, ball.center_y
        if ec != 0.0 or es != 0.0:
            along = moment * (ec * c + es * s)  # m eps E cos(gamma - phi)
            across = moment * (es * c - ec * s)  # m eps E sin(gamma - phi)
            ex = ball.mass * (turn_cos * ec - turn_sin * es)
            ey = ball.mass * (turn_sin * ec + turn_cos * es)
            force_x += ex * square
            force_y += ey * square
            arm_x -= ey
            arm_y += ex
            row += across * square
            spin += along
            inertia += 2.0 * along
            torque += ex * gy - ey * gx - across * ball_speed * (in_space + speed)
        # the ball row, divided by its inertia, put into the rows of host and rotor
        inverse = 1.0 / ball.inertia
        if moving.bound != 0:
            its = p.ties[i]
            its.push, its.spin, its.x, its.y, its.inertia = row, spin, lean_x, lean_y, ball.inertia
            inverse = 0.0
        push, twist = row * inverse, spin * inverse
        share_x, share_y = lean_x * inverse, lean_y * inverse
        mass_xx -= lean_x * share_x
        mass_xy -= lean_x * share_y
        mass_yy -= lean_y * share_y
        force_x -= lean_x * push
        force_y -= lean_y * push
        arm_x -= lean_x * twist
        arm_y -= lean_y * twist
        inertia -= spin * twist
        torque -= spin * push
        moving.push, moving.twist = push, twist
        moving.lean_x, moving.lean_y = share_x, share_y

    # balls in rigid contact have one acceleration: the difference to what each would do alone
    if p.rigid.bound[0] > 0:
        less = bind_planar(y, system)
        mass_xx, mass_xy, mass_yy = mass_xx - less[0], mass_xy - less[1], mass_yy - less[2]
        force_x, force_y, arm_x, arm_y = force_x - less[3], force_y - less[4], arm_x - less[5], arm_y - less[6]
        inertia, torque = inertia - less[7], torque - less[8]

    # A = a - b w'; only one product waits for w', because it comes last and after a division
    determinant = mass_xx * mass_yy - mass_xy * mass_xy
    inverse = 1.0 / determinant
    wx, wy = mass_yy * arm_x - mass_xy * arm_y, mass_xx * arm_y - mass_xy * arm_x
    ax, ay = (mass_yy * force_x - mass_xy * force_y) * inverse, (mass_xx * force_y - mass_xy * force_x) * inverse
    bx, by = wx * inverse, wy * inverse
    if p.drive.kind != PRESCRIBED:
        torque += motor_torque(drive, speed, p.drive)
        needed = torque * determinant - wx * force_x - wy * force_y
        acceleration = needed / (inertia * determinant - wx * arm_x - wy * arm_y)

    # back to the state: balls follow from the accelerations of rotor and race
    dy[X] = vx + frame_speed * y1
    dy[Y] = vy - frame_speed * x1
    dy[VX] = ax + frame_speed * vy - bx * acceleration
    dy[VY] = ay - frame_speed * vx - by * acceleration
    dy[THETA] = speed
    dy[SPEED] = acceleration
    for i in range(count):
        moving = p.guided[i]
        free = moving.push - moving.lean_x * ax - moving.lean_y * ay
        bound = moving.twist - moving.lean_x * bx - moving.lean_y * by
        dy[BALLS + i] = y[BALLS + count + i]
        dy[BALLS + count + i] = free - bound * acceleration
    if p.rigid.bound[0] > 0:
        press_planar(y, dy, system, ax - bx * acceleration, ay - by * acceleration, acceleration)
