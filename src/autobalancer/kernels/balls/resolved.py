"""Equations of motion of any linear rotor with balls that are resolved in contact: free in the plane of their race.

Symbols, in the axes of the rotor: rho_s = E + rho from the station to the ball, u = rho' its velocity as seen from the rotor,
sigma its spin as seen from there; F all forces on the ball but its weight W (walls, other balls, floor, drag, adherence),
tau their torque on its spin. They depend on the state alone. With A the acceleration of the station,

    m z'' + mu u' = F + W,         z'' = A + k + i w' rho_s + u',      k = 2 i w u - w^2 rho_s
    J (sigma' + w') = tau

m is the effective mass; mu, the rest of the ball's mass and the virtual mass, feels motion relative to the chamber only, as
along the race of a guided ball (:mod:`autobalancer.kernels.balls.guided`), because the fluid turns with the chamber. The
station feels W - m z'' = R - S A - w' c, which with s = mu/(m + mu) gives R = s (W - m k) - (1 - s) F, S = s m and
c = s m i rho_s, and the rotor's torque is rho_s x (W - m z'') - tau. Without a fluid this is -F: action and reaction.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from autobalancer.kernels.balls.floor import climbing, on_floor
from autobalancer.kernels.balls.forces import push_resolved
from autobalancer.kernels.balls.rates import rates_of
from autobalancer.kernels.balls.walls import TINY, touch
from autobalancer.kernels.called import call_friction
from autobalancer.kernels.flags import EQUATIONS, INLINE, njit
from autobalancer.kernels.host.linear import Motion
from autobalancer.kernels.laws.contact import adherence, normal_force
from autobalancer.kernels.laws.curves import drag_force
from autobalancer.kernels.laws.lag import fluid_lag
from autobalancer.kernels.laws.rebound import NONE as CONSTANT
from autobalancer.kernels.laws.rebound import damping_at
from autobalancer.kernels.laws.slipstream import slipstream
from autobalancer.kernels.pointers import data
from autobalancer.kernels.records.drive import PRESCRIBED
from autobalancer.kernels.records.fluid import NONE
from autobalancer.kernels.records.resolved import (
    BALL_SPIN,
    BALL_STATES,
    BALL_VX,
    BALL_VY,
    BALL_X,
    BALL_Y,
    HOLD,
    TUMBLE_X,
    TUMBLE_Y,
)
from autobalancer.kernels.system import BALLS, System


@njit(**INLINE)
def _slide(p: System, ball: Any, at: Any, slip: float, pressed: float) -> float:
    """Friction of a wall against this slip, N."""
    at.slip, at.pressed = slip, pressed
    coefficient = call_friction(ball.friction, at, p.friction_numbers, ball.first_number)
    if not math.isfinite(coefficient) and math.isfinite(slip + pressed):
        at.wrong, at.wrong_slip, at.wrong_pressed = 1, slip, pressed
    return pressed * coefficient


@njit(**INLINE)
def _rub(p: System, ball: Any, at: Any, slip: float, climb: float, pressed: float) -> tuple[float, float]:
    """Friction of a wall against slip along the race and upwards, N."""
    if climb == 0.0:
        return _slide(p, ball, at, slip, pressed), 0.0
    fast = math.sqrt(slip * slip + climb * climb + TINY)
    both = _slide(p, ball, at, fast, pressed) / fast
    return both * slip, both * climb


@njit(**INLINE)
def _in_chamber(time, y, p, ball, own, angle, free, at) -> None:  # type: ignore[no-untyped-def]
    """Forces of walls, partitions, floor and fluid on a ball with its state at ``own``, into ``free``; it slips ``at``."""
    x, z, vx, vz, spin = y[own + BALL_X], y[own + BALL_Y], y[own + BALL_VX], y[own + BALL_VY], y[own + BALL_SPIN]
    nx, ny, along, wall, inner = touch(p, ball, x, z, vx, vz)
    radius, lightness = ball.radius, 1.0 / (ball.mass + ball.extra)
    slip, climb = along + radius * spin, climbing(ball, nx, ny, y[own + TUMBLE_X], y[own + TUMBLE_Y])
    rub, up, torque, hold_rate = 0.0, 0.0, 0.0, 0.0
    if wall > 0.0:
        rub, up = _rub(p, ball, at, slip, climb, wall)
        torque = -radius * rub
    if inner > 0.0:
        grip, down = _rub(p, ball, at, along - radius * spin, -climb, inner)
        rub, up = rub + grip, up - down
        torque += radius * grip
    if ball.rolling_arm > 0.0:
        torque -= ball.rolling_arm * (wall + inner) * math.tanh(radius * spin / ball.rest_speed)
    if ball.adherence > 0.0:
        held, hold_rate = adherence(
            y[own + HOLD],
            slip,
            along,
            ball.adherence * wall,
            ball.hold_stiffness,
            ball.hold_damping,
            ball.rest_speed,
        )
        rub += held
    push = inner - wall
    force_x, force_y = push * nx + rub * ny, push * ny - rub * nx

    if ball.partition != NONE:
        part = p.partitions[ball.partition]
        side, px, py = 1.0, part.behind_x, part.behind_y
        if angle > part.middle:
            side, px, py = -1.0, part.ahead_x, part.ahead_y
        depth = radius - (x * px + z * py)
        if depth > 0.0 and side * (x * py - z * px) > 0.0:
            inward, along = vx * px + vz * py, vx * py - vz * px
            damping = damping_at(
                p.rebounds, part.rebound, part.damping, depth, -inward, part.stiffness, lightness, ball.hertz
            )
            push = normal_force(depth, -inward, part.stiffness, damping, ball.hertz)
            rub = push * ball.ball_sliding * math.tanh((along + radius * spin) / ball.slip_speed)
            force_x += push * px - rub * py
            force_y += push * py + rub * px
            torque -= radius * rub

    floor = on_floor(ball, wall + inner, vx, vz, y[own + TUMBLE_X], y[own + TUMBLE_Y])
    force_x, force_y = force_x + floor[0], force_y + floor[1]
    free.tumble_x, free.tumble_y = floor[2] - radius * up * ny, floor[3] + radius * up * nx

    lag = fluid_lag(time, y, p.fluid, ball)
    ux, uy = vx - lag * z, vz + lag * x
    fast = math.sqrt(ux * ux + uy * uy + TINY)
    braked = drag_force(p.fluid, ball.drag_curve, ball.viscous, fast) / fast
    if ball.slipstream != NONE:
        ahead = uy * nx - ux * ny
        spared = (1.0 - slipstream(y, p.fluid, ball.slipstream, ahead, fast)) * braked * ahead
        force_x, force_y = force_x - spared * ny, force_y + spared * nx
    free.force_x, free.force_y = force_x - braked * ux, force_y - braked * uy
    free.torque, free.hold_rate = torque, hold_rate


@njit(**INLINE)
def _meet(y, p, i, j, own, its) -> None:  # type: ignore[no-untyped-def]
    """Forces between two balls i and j of one race with their states at ``own`` and ``its``, added to those they feel."""
    one, other = p.free_balls[i], p.free_balls[j]
    x, z = y[its + BALL_X] - y[own + BALL_X], y[its + BALL_Y] - y[own + BALL_Y]
    reach = one.radius + other.radius
    square = x * x + z * z + TINY
    if square >= reach * reach:
        return
    apart = math.sqrt(square)
    nx, ny = x / apart, z / apart
    vx, vz = y[its + BALL_VX] - y[own + BALL_VX], y[its + BALL_VY] - y[own + BALL_VY]
    stiffness = one.ball_stiffness
    if one.hertz == 1:
        stiffness *= math.sqrt(one.radius * other.radius / reach)
    heavy, light = one.mass + one.extra, other.mass + other.extra
    lightness, near = (heavy + light) / (heavy * light), -(vx * nx + vz * ny)
    damping = one.ball_damping * math.sqrt(stiffness / lightness)
    table = p.pair_rebounds[i * p.ball_count + j] if p.pair_rebounds.size > 0 else CONSTANT
    damping = damping_at(p.rebounds, table, damping, reach - apart, near, stiffness, lightness, one.hertz)
    push = normal_force(reach - apart, near, stiffness, damping, one.hertz)
    rub = 0.0
    if one.ball_sliding > 0.0:
        arm = apart / reach
        spins = arm * (one.radius * y[own + BALL_SPIN] + other.radius * y[its + BALL_SPIN])
        slip = vz * nx - vx * ny - spins
        rub = push * one.ball_sliding * math.tanh(slip / one.slip_speed)
        p.free[i].torque += arm * one.radius * rub
        p.free[j].torque += arm * other.radius * rub
    force_x, force_y = push * nx + rub * ny, push * ny - rub * nx
    p.free[i].force_x -= force_x
    p.free[i].force_y -= force_y
    p.free[j].force_x += force_x
    p.free[j].force_y += force_y


class Row(NamedTuple):
    """What a resolved ball gives its station and the rotor, R - S A - w' c, in the rotor."""

    x: float
    y: float
    arm_x: float
    arm_y: float
    carried: float  # S
    torque: float
    inertia: float


@njit(**INLINE)
def row(ball: Any, free: Any, arm_x: float, arm_y: float, felt_x: float, felt_y: float) -> Row:
    """Of a ball at ``arm`` from its station, that would feel the acceleration ``felt`` without forces."""
    share = ball.extra / (ball.mass + ball.extra)
    carried = share * ball.mass
    x, y = carried * felt_x - (1.0 - share) * free.force_x, carried * felt_y - (1.0 - share) * free.force_y
    torque, inertia = arm_x * y - arm_y * x - free.torque, carried * (arm_x * arm_x + arm_y * arm_y)
    return Row(x, y, -carried * arm_y, carried * arm_x, carried, torque, inertia)


@njit(**EQUATIONS)
def resolved(time: float, y: Any, dy: Any, system: Any) -> None:
    """Time derivative ``dy`` of the state ``y`` of :mod:`autobalancer.kernels.records.resolved`."""
    rates_of(time, y, dy, system, _touching, _gather, _recover, 2)


@njit(**INLINE)
def _states(p: System, b: int) -> int:
    """Where the states of ball b begin."""
    return 2 + 2 * p.host.size + 2 * p.ball_count + b * BALL_STATES


@njit(**INLINE)
def _touching(time: float, y: Any, p: System, motion: Motion) -> None:
    """All forces but weight, on all balls."""
    for b in range(p.ball_count):
        _in_chamber(time, y, p, p.free_balls[b], _states(p, b), y[BALLS + b], p.free[b], p.slips[b])
    for b in range(p.ball_count):
        for other in range(b + 1, p.ball_count):
            race = p.free_balls[b].race
            if race >= 0 and race == p.free_balls[other].race:
                _meet(y, p, b, other, _states(p, b), _states(p, other))
    push_resolved(y, p, motion.speed)


@njit(**INLINE)
def _falling(motion: Motion) -> tuple[float, float]:
    """Gravity in the rotor."""
    return (
        motion.cosine * motion.gravity_x + motion.sine * motion.gravity_y,
        motion.cosine * motion.gravity_y - motion.sine * motion.gravity_x,
    )


@njit(**INLINE)
def _gather(time, y, p, motion, b, each) -> tuple[float, float]:  # type: ignore[no-untyped-def]
    """Put ball b into its station; its torque and inertia there."""
    ball, own, speed = p.free_balls[b], _states(p, b), motion.speed
    push, arm, turn, inert = data(p.work.push), data(p.work.arm), data(p.work.turn), data(p.work.inert)
    arm_x, arm_y = ball.center_x + y[own + BALL_X], ball.center_y + y[own + BALL_Y]
    fall_x, fall_y = _falling(motion)
    felt_x = fall_x + 2.0 * speed * y[own + BALL_VY] + speed * speed * arm_x
    felt_y = fall_y - 2.0 * speed * y[own + BALL_VX] + speed * speed * arm_y
    part = row(ball, p.free[b], arm_x, arm_y, felt_x, felt_y)
    at, s, c = ball.station * each, motion.sine, motion.cosine
    x, y_ = part.x - motion.acceleration * part.arm_x, part.y - motion.acceleration * part.arm_y
    push[at] += c * x - s * y_
    push[at + 1] += s * x + c * y_
    inert[at * each] += part.carried
    inert[at * each + 3] += part.carried
    if p.drive.kind != PRESCRIBED:
        bent_x, bent_y = c * part.arm_x - s * part.arm_y, s * part.arm_x + c * part.arm_y
        arm[at] += bent_x
        arm[at + 1] += bent_y
        turn[at] += bent_x
        turn[at + 1] += bent_y
    return part.torque, part.inertia


@njit(**INLINE)
def _recover(y, dy, p, motion, b, acceleration, each) -> bool:  # type: ignore[no-untyped-def]
    """The rates of ball b."""
    ball, free, own, speed, one = p.free_balls[b], p.free[b], _states(p, b), motion.speed, data(p.work.one)
    mass, whole, at = ball.mass, ball.mass + ball.extra, ball.station * each
    x, z, vx, vz = y[own + BALL_X], y[own + BALL_Y], y[own + BALL_VX], y[own + BALL_VY]
    arm_x, arm_y = ball.center_x + x, ball.center_y + z
    fall_x, fall_y = _falling(motion)
    ax = motion.cosine * one[at] + motion.sine * one[at + 1]
    ay = motion.cosine * one[at + 1] - motion.sine * one[at]
    ax += -2.0 * speed * vz - speed * speed * arm_x - acceleration * arm_y - fall_x
    ay += 2.0 * speed * vx - speed * speed * arm_y + acceleration * arm_x - fall_y
    dx, dz = (free.force_x - mass * ax) / whole, (free.force_y - mass * ay) / whole
    dy[own + BALL_X], dy[own + BALL_Y] = vx, vz
    dy[own + BALL_VX], dy[own + BALL_VY] = dx, dz
    dy[own + BALL_SPIN] = free.torque / ball.spin_inertia - acceleration
    dy[own + HOLD] = free.hold_rate
    dy[own + TUMBLE_X] = free.tumble_x / ball.spin_inertia + speed * y[own + TUMBLE_Y]
    dy[own + TUMBLE_Y] = free.tumble_y / ball.spin_inertia - speed * y[own + TUMBLE_X]
    inverse = 1.0 / (x * x + z * z + TINY)
    rate = (x * vz - z * vx) * inverse
    dy[BALLS + b] = rate
    dy[BALLS + p.ball_count + b] = (x * dz - z * dx) * inverse - 2.0 * rate * (x * vx + z * vz) * inverse
    return False
