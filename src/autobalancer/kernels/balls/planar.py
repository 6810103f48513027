"""Equations of motion of a planar rotor with guided balls on smooth circles: the fast path of kernels/balls/guided.py.

Spannan 2021, (4.14)-(4.17), derived again with the displaced fluid and its virtual mass, and with the balls
eliminated: a ball row reads ``I phi'' = r - s t.A - c w'``, so that only a symmetric system in the acceleration
A of the race center and the rotor acceleration w' remains. Symbols: s = m eps, t and n the tangential and radial
unit vectors at the ball, c its coupling with the rotor, U the unbalance; all vectors along the axes of the frame.

Row and share of each ball are those of guided.py. What is done with them here is done with numbers or with the lanes of
kernels/compiler/simd.py: planar_nodes.py takes the same functions for all nodes of a long step.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from autobalancer.kernels.balls.ball_forces import push_planar
from autobalancer.kernels.balls.guided import Row, Share, on_circle, scaled, touch
from autobalancer.kernels.balls.rigid_torques import bind_planar, press_planar
from autobalancer.kernels.compiler.flags import EQUATIONS, INLINE, njit
from autobalancer.kernels.compiler.numba_struct import deref
from autobalancer.kernels.host.linear import Motion, motion_of
from autobalancer.kernels.host.shaft_train import unbalance_value
from autobalancer.kernels.records import PRESCRIBED
from autobalancer.kernels.system import BALLS, SPEED, THETA, VX, VY, System, X, Y, system_at
from autobalancer.kernels.trigonometry import sine_cosine


class Rows(NamedTuple):
    """Race center and rotor: (mass) A + arm w' = force, arm.A + inertia w' = torque."""

    mass_xx: float  # kg
    mass_xy: float
    mass_yy: float
    force_x: float  # N
    force_y: float
    arm_x: float  # kg m
    arm_y: float
    inertia: float  # kg m^2
    torque: float  # N m


class Accelerations(NamedTuple):
    """A = a - b w', and w'."""

    ax: float
    ay: float
    bx: float
    by: float
    rotor: float


@njit(**INLINE)
def with_ball(rows: Rows, part: Share) -> Rows:
    """The rows with the share of a ball that stays where it is in the rotor."""
    return Rows(
        rows.mass_xx, rows.mass_xy, rows.mass_yy, rows.force_x + part.x, rows.force_y + part.y,
        rows.arm_x + part.arm_x, rows.arm_y + part.arm_y, rows.inertia + part.inertia, rows.torque + part.torque,
    )  # fmt: skip


@njit(**INLINE)
def eliminated(rows: Rows, its: Row, found: Row) -> Rows:
    """The rows with phi'' of a ball put in; ``found`` is its row solved for it."""
    return Rows(
        rows.mass_xx - its.x * found.x, rows.mass_xy - its.x * found.y, rows.mass_yy - its.y * found.y,
        rows.force_x - its.x * found.push, rows.force_y - its.y * found.push,
        rows.arm_x - its.x * found.spin, rows.arm_y - its.y * found.spin,
        rows.inertia - its.spin * found.spin, rows.torque - its.spin * found.push,
    )  # fmt: skip


@njit(**INLINE)
def accelerations(rows: Rows, known: float, free: bool) -> Accelerations:
    """Both rows solved; w' is ``known`` unless the rotor is ``free``."""
    determinant = rows.mass_xx * rows.mass_yy - rows.mass_xy * rows.mass_xy
    inverse = 1.0 / determinant
    wx = rows.mass_yy * rows.arm_x - rows.mass_xy * rows.arm_y
    wy = rows.mass_xx * rows.arm_y - rows.mass_xy * rows.arm_x
    # only one product waits for w', because it comes last and after a division
    ax = (rows.mass_yy * rows.force_x - rows.mass_xy * rows.force_y) * inverse
    ay = (rows.mass_xx * rows.force_y - rows.mass_xy * rows.force_x) * inverse
    if free:
        needed = rows.torque * determinant - wx * rows.force_x - wy * rows.force_y
        known = needed / (rows.inertia * determinant - wx * rows.arm_x - wy * rows.arm_y)
    return Accelerations(ax, ay, wx * inverse, wy * inverse, known)


@njit(**EQUATIONS)
def planar(time: float, y: Any, dy: Any, system: Any) -> None:
    """Time derivative ``dy`` of the state ``y`` of :mod:`autobalancer.kernels.system`."""
    p = deref(system_at(system))
    motion, heavy = motion_of(time, y, p), p.gravity_x != 0.0 or p.gravity_y != 0.0
    rows = _rotor(time, y, p, motion)
    # what touches or pushes the balls, then ball by ball: its share, and its row put into those of race center and rotor
    touch(y, p)
    if p.forces.shape[0] > 0:
        push_planar(y, system, motion.speed)
    for i in range(p.ball_count):
        ball, moving, rate = p.balls[i], p.guided[i], y[BALLS + p.ball_count + i]
        s, c = sine_cosine(y[BALLS + i])
        nx, ny = motion.cosine * c - motion.sine * s, motion.sine * c + motion.cosine * s
        ex = motion.cosine * ball.center_x - motion.sine * ball.center_y
        ey = motion.sine * ball.center_x + motion.cosine * ball.center_y
        its, part = on_circle(ball, ex, ey, nx, ny, motion, rate, moving.contact, heavy)
        inverse = 1.0 / ball.inertia
        if moving.bound != 0:  # its cluster has a row, it has none
            tie = p.ties[i]
            tie.push, tie.spin, tie.x, tie.y, tie.inertia = its.push, its.spin, its.x, its.y, ball.inertia
            inverse = 0.0
        found = scaled(its, inverse)
        rows = eliminated(with_ball(rows, part), its, found)
        moving.push, moving.twist, moving.lean_x, moving.lean_y = found.push, found.spin, found.x, found.y
    # balls in rigid contact have one acceleration: the difference to what each would do alone
    if p.rigid.bound[0] > 0:
        less = bind_planar(y, system)
        rows = Rows(
            rows.mass_xx - less[0], rows.mass_xy - less[1], rows.mass_yy - less[2],
            rows.force_x - less[3], rows.force_y - less[4], rows.arm_x - less[5], rows.arm_y - less[6],
            rows.inertia - less[7], rows.torque - less[8],
        )  # fmt: skip
    solution = accelerations(rows, motion.acceleration, p.drive.kind != PRESCRIBED)
    _write_rates(y, dy, p, motion.speed, solution)
    if p.rigid.bound[0] > 0:
        w = solution.rotor
        press_planar(y, dy, system, solution.ax - solution.bx * w, solution.ay - solution.by * w, w)


@njit(**INLINE)
def _rotor(time: float, y: Any, p: System, motion: Motion) -> Rows:
    """The rotor by itself: springs, dampers, unbalance; the balls' constant part of its inertia is in it already."""
    ux, uy = unbalance_value(time, p.drive)
    ux, uy = motion.cosine * ux - motion.sine * uy, motion.sine * ux + motion.cosine * uy
    rotor, square = p.planar, motion.speed * motion.speed
    force_x = -rotor.stiffness_x * y[X] - rotor.damping_x * y[VX] + ux * square
    force_y = -rotor.stiffness_y * y[Y] - rotor.damping_y * y[VY] + uy * square
    return Rows(rotor.mass, 0.0, rotor.mass, force_x, force_y, -uy, ux, p.polar_inertia, motion.torque)


@njit(**INLINE)
def _write_rates(y: Any, dy: Any, p: System, speed: float, solution: Accelerations) -> None:
    """Back to the state: balls follow from the accelerations of rotor and race; the axes may turn with the rotor."""
    frame_speed, w = speed if p.rotating == 1 else 0.0, solution.rotor
    dy[X] = y[VX] + frame_speed * y[Y]
    dy[Y] = y[VY] - frame_speed * y[X]
    dy[VX] = solution.ax + frame_speed * y[VY] - solution.bx * w
    dy[VY] = solution.ay - frame_speed * y[VX] - solution.by * w
    dy[THETA], dy[SPEED] = speed, w
    for i in range(p.ball_count):
        moving = p.guided[i]
        free = moving.push - moving.lean_x * solution.ax - moving.lean_y * solution.ay
        bound = moving.twist - moving.lean_x * solution.bx - moving.lean_y * solution.by
        dy[BALLS + i] = y[BALLS + p.ball_count + i]
        dy[BALLS + p.ball_count + i] = free - bound * w
