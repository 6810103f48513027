"""Guided balls at the stations of a linear rotor: the arrays around kernels/balls/guided.py.

``kind`` is (rows of a station, whether races are rough, whether the normal forces are known from the evaluation before).
"""

from __future__ import annotations

from typing import Any

from autobalancer.kernels.balls.ball_forces import push_guided
from autobalancer.kernels.balls.guided import (
    Path,
    Row,
    Share,
    Slope,
    circle,
    known_acceleration,
    normal,
    on_circle,
    orbit,
    row,
    rubbed,
    rubbing_arm,
    share,
    solved,
    steady_inertia,
    tilting_normal,
    tilting_row,
    tilting_share,
    touch,
    wavy,
)
from autobalancer.kernels.balls.rates import rates_of
from autobalancer.kernels.balls.rigid_torques import keep
from autobalancer.kernels.compiler.flags import EQUATIONS, EQUATIONS_PART, INLINE, njit
from autobalancer.kernels.compiler.numba_struct import data
from autobalancer.kernels.compiler.simd import where
from autobalancer.kernels.host.linear import Motion, dot
from autobalancer.kernels.laws.contact_law import LEAST_SLIP, coefficient
from autobalancer.kernels.laws.curves import drag_force, fluid_lag, slipstream
from autobalancer.kernels.records import NONE, PRESCRIBED
from autobalancer.kernels.system import BALLS, System
from autobalancer.kernels.trigonometry import sine_cosine


@njit(**INLINE)
def touching(time: float, y: Any, p: System, motion: Motion) -> None:
    touch(y, p)
    push_guided(y, p, motion.speed)


@njit(**INLINE)
def gather(time, y, p, motion, b, kind) -> tuple[float, float]:  # type: ignore[no-untyped-def]
    """Put ball b into its station; ``kind``: rows of a station, whether its race is rough, whether ``normal`` is known."""
    each, rough, pressed = kind
    ball, moving, rate = p.balls[b], p.guided[b], y[BALLS + p.ball_count + b]
    # the path at the ball, its row, and its share in the rows of rotor and station
    s, c = sine_cosine(y[BALLS + b])
    nx, ny = motion.cosine * c - motion.sine * s, motion.sine * c + motion.cosine * s
    ex = motion.cosine * ball.center_x - motion.sine * ball.center_y
    ey = motion.sine * ball.center_x + motion.cosine * ball.center_y
    if rough:
        radius, first, second = orbit(p.waves, ball, ball.orbit, c, s)
        path = wavy(radius, first, second, ex, ey, nx, ny)
        drag = _drag(time, y, p, ball, path.length, rate)
        known = known_acceleration(path, motion.speed, rate)
        its = row(ball, path, motion, rate, drag, moving.contact)
        part, steady = share(ball, path, motion, known, rate), 0.0
    else:
        path, known = circle(ball.orbit, ex, ey, nx, ny), (0.0, 0.0)
        its, part = on_circle(ball, ex, ey, nx, ny, motion, rate, moving.contact, True)
        steady = steady_inertia(ball)
    slope = _slope(p, ball.station, each)
    if each == 4:
        its = tilting_row(its, ball.mass, path, motion, slope)
        part = tilting_share(part, ball.mass, path, motion, slope, rate)
    # on a real race the normal force rubs, and a ball at rest keeps what would hold it
    felt, inverse, arm, weight = its, 1.0 / ball.inertia, 0.0, ball.inertia
    if rough:
        force = normal(ball.mass, path, motion, known, moving.outward)
        if each == 4:
            force = tilting_normal(force, ball.mass, path, motion, slope, rate)
        arm = rubbing_arm(ball, path, moving.mode, moving.normal if pressed else force.push)
        weight = float(ball.stretch * path.length * path.length)
        if ball.friction != 0:
            at = p.slips[b]
            at.slip, at.sliding = abs(path.length * rate) + LEAST_SLIP, ball.rolling
            arm *= coefficient(p, ball, at, at.slip) / ball.rolling
        felt = rubbed(its, force, arm)
        inverse = where(moving.mode != 0.0, 1.0 / weight, 0.0)
        _hold(moving, its)
        moving.normal_push, moving.normal_twist = force.push, force.twist
        moving.normal_x, moving.normal_y, moving.normal_u, moving.normal_v = force.x, force.y, force.u, force.v
    if moving.bound != 0:  # it has no row of its own
        _hold(moving, its)
        keep(p.ties[b], felt, weight, arm)
        inverse = 0.0
    # the row solved for phi'' goes into the station
    found = solved(felt, inverse, motion.acceleration)
    moving.push, moving.twist = found.push, found.spin
    moving.lean_x, moving.lean_y, moving.lean_u, moving.lean_v = found.x, found.y, found.u, found.v
    _load(p, ball.station * each, each, motion.acceleration, part, its, found)
    _weigh(p, ball.station * each, each, ball.mass, path, its, found)
    return part.torque - its.spin * found.push, part.inertia + steady - its.spin * found.spin


@njit(**INLINE)
def _hold(moving: Any, its: Row) -> None:
    """Keep the row without friction."""
    moving.held_push, moving.held_twist = its.push, its.spin
    moving.held_lean_x, moving.held_lean_y, moving.held_lean_u, moving.held_lean_v = its.x, its.y, its.u, its.v


@njit(**INLINE)
def _drag(time, y, p, ball, length, rate) -> float:  # type: ignore[no-untyped-def]
    """Drag force on a ball, N."""
    through = length * (rate + fluid_lag(time, y, p.fluid, ball))
    drag = drag_force(p.fluid, ball.drag_curve, ball.viscous, through)
    if ball.slipstream != NONE:
        drag *= slipstream(y, p.fluid, ball.slipstream, through, abs(through))
    return drag


@njit(**INLINE)
def _slope(p: System, station: int, each: int) -> Slope:
    """Of a station with four rows; else there is none."""
    if each == 2:
        return Slope(0.0, 0.0, 0.0, 0.0, 0.0)
    size, width, rows, q, v = p.host.size, p.host.width, data(p.host.rows), data(p.work.q), data(p.work.v)
    at = (4 * station + 2) * width
    return Slope(
        dot(rows, at, q, 0, size), dot(rows, at + width, q, 0, size),
        dot(rows, at, v, 0, size), dot(rows, at + width, v, 0, size), p.host.axial_gravity,
    )  # fmt: skip


@njit(**INLINE)
def _load(p: System, at: int, each: int, acceleration: float, part: Share, its: Row, found: Row) -> None:
    """Force on the station with the rows from ``at`` on: R, and what w' adds to it and to the torque."""
    push, arm, turn = data(p.work.push), data(p.work.arm), data(p.work.turn)
    push[at] += part.x - acceleration * part.arm_x - its.x * found.push
    push[at + 1] += part.y - acceleration * part.arm_y - its.y * found.push
    if each == 4:
        push[at + 2] += part.u - acceleration * part.arm_u - its.u * found.push
        push[at + 3] += part.v - acceleration * part.arm_v - its.v * found.push
    if p.drive.kind != PRESCRIBED:
        arm[at] += part.arm_x - its.x * found.spin
        arm[at + 1] += part.arm_y - its.y * found.spin
        turn[at] += part.arm_x - its.spin * found.x
        turn[at + 1] += part.arm_y - its.spin * found.y
        if each == 4:
            arm[at + 2] += part.arm_u - its.u * found.spin
            arm[at + 3] += part.arm_v - its.v * found.spin
            turn[at + 2] += part.arm_u - its.spin * found.u
            turn[at + 3] += part.arm_v - its.spin * found.v


@njit(**INLINE)
def _weigh(p: System, at: int, each: int, mass: float, path: Path, its: Row, found: Row) -> None:
    """The ball's part of S, the inertia that the station feels."""
    inert, i = data(p.work.inert), at * each
    inert[i] += mass - its.x * found.x
    inert[i + 1] -= its.x * found.y
    inert[i + each] -= its.y * found.x
    inert[i + each + 1] += mass - its.y * found.y
    if each == 4:
        inert[i + 2] -= its.x * found.u
        inert[i + 3] -= its.x * found.v
        inert[i + 6] -= its.y * found.u
        inert[i + 7] -= its.y * found.v
        inert[i + 8] -= its.u * found.x
        inert[i + 9] -= its.u * found.y
        inert[i + 10] += mass * path.x * path.x - its.u * found.u
        inert[i + 11] += mass * path.x * path.y - its.u * found.v
        inert[i + 12] -= its.v * found.x
        inert[i + 13] -= its.v * found.y
        inert[i + 14] += mass * path.x * path.y - its.v * found.u
        inert[i + 15] += mass * path.y * path.y - its.v * found.v


@njit(**INLINE)
def recover(y, dy, p, motion, b, acceleration, kind) -> bool:  # type: ignore[no-untyped-def]
    """Speed and acceleration of ball b; whether it rubs by a normal force of the wrong sign."""
    each, rough, _ = kind
    ball, moving, one = p.balls[b], p.guided[b], data(p.work.one)
    at, gained = ball.station * each, 0.0
    if p.drive.kind != PRESCRIBED:
        gained = acceleration
    x, y_, u, v = one[at], one[at + 1], 0.0, 0.0
    if each == 4:
        u, v = one[at + 2], one[at + 3]
    # phi'' from the row that was solved for it, with the accelerations that are known at last
    rate = moving.push - moving.lean_x * x - moving.lean_y * y_ - moving.twist * gained
    if each == 4:
        rate -= moving.lean_u * u + moving.lean_v * v
    dy[BALLS + b] = y[BALLS + p.ball_count + b]
    dy[BALLS + p.ball_count + b] = rate
    if not rough:
        return False
    # on a real race: what would hold the ball at rest, and how it is pressed on the wall
    need = moving.held_push - moving.held_lean_x * x - moving.held_lean_y * y_ - moving.held_twist * acceleration
    force = moving.normal_push - moving.normal_x * x - moving.normal_y * y_ - moving.normal_twist * acceleration
    if each == 4:
        need -= moving.held_lean_u * u + moving.held_lean_v * v
        force -= moving.normal_u * u + moving.normal_v * v
    moving.need, moving.normal = need, force
    return (
        ball.rolling > 0.0 and moving.mode != 0.0 and moving.bound == 0 and (force > 0.0) != (moving.normal_push > 0.0)
    )


# Equations of motion of a linear rotor with guided balls on smooth circles with linear drag.


@njit(**EQUATIONS)
def guided(time: float, y: Any, dy: Any, system: Any) -> None:
    """Guided balls on smooth circles with linear drag; they feel the deflection of their station."""
    rates_of(time, y, dy, system, touching, gather, recover, (2, False, False))


@njit(**EQUATIONS)
def guided_tilting(time: float, y: Any, dy: Any, system: Any) -> None:
    """The same where balls feel the tilt of their race too."""
    rates_of(time, y, dy, system, touching, gather, recover, (4, False, False))


# Equations of motion of a linear rotor with guided balls on real races: any path, friction, any drag, excitation.


@njit(**EQUATIONS)
def guided_rough(time: float, y: Any, dy: Any, system: Any) -> None:
    """Guided balls on real races: paths of any shape, friction, any drag, fluid that lags, excitation."""
    for pressed in range(2):  # a number that changes: a constant would be compiled for each of its values
        if not _rough(time, y, dy, system, pressed):
            return


@njit(**EQUATIONS)
def guided_rough_tilting(time: float, y: Any, dy: Any, system: Any) -> None:
    """The same where balls feel the tilt of their race too."""
    for pressed in range(2):  # a number that changes: a constant would be compiled for each of its values
        if not _rough_tilting(time, y, dy, system, pressed):
            return


@njit(**EQUATIONS_PART)
def _rough(time, y, dy, system, pressed) -> bool:  # type: ignore[no-untyped-def]
    """Balls rub where the known part of the normal force, or (``pressed``) that found before, is positive."""
    return rates_of(time, y, dy, system, touching, gather, recover, (2, True, pressed))


@njit(**EQUATIONS_PART)
def _rough_tilting(time, y, dy, system, pressed) -> bool:  # type: ignore[no-untyped-def]
    return rates_of(time, y, dy, system, touching, gather, recover, (4, True, pressed))
