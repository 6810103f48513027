"""The floor of an annulus on a vertical axis, under a resolved ball that its wall does not carry whole.

Symbols, in the axes of the rotor: u = (vx, vz) the velocity of the ball, t = (tumble_x, tumble_y) the horizontal part of its spin
in space, n the normal of the wall, e the vertical. The point of the ball on the floor slips by u - r t x e, the one on the wall
by r (t x n) upwards. With no horizontal spin in the rotor itself, t' = tau/J - w e x t. The ball keeps its height: what carries
it is balanced at any time, and the vertical part of friction on the wall does no work on it, but it brakes the spin.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from numba import types, void

from autobalancer.kernels.balls.ball_forces import push_resolved
from autobalancer.kernels.balls.guided import closest, orbit
from autobalancer.kernels.balls.rates import rates_of
from autobalancer.kernels.compiler.flags import COMPILED, EQUATIONS, INLINE, njit
from autobalancer.kernels.compiler.numba_struct import data
from autobalancer.kernels.host.linear import Motion
from autobalancer.kernels.laws.contact_law import NONE as CONSTANT
from autobalancer.kernels.laws.contact_law import adherence, coefficient, damping_at, normal_force
from autobalancer.kernels.laws.curves import drag_force, fluid_lag, slipstream
from autobalancer.kernels.records import (
    BALL_SPIN,
    BALL_STATES,
    BALL_VX,
    BALL_VY,
    BALL_X,
    BALL_Y,
    HOLD,
    NONE,
    PRESCRIBED,
    TUMBLE_X,
    TUMBLE_Y,
)
from autobalancer.kernels.system import BALLS, Matrix, System, matrix_type, system_type

TINY = 1e-30  # (m/s)^2, keeps the direction of a ball at rest a number


@njit(**INLINE)
def carried_by_floor(ball: Any, pressed: float) -> float:
    """Force of the floor on a ball that its walls press with this force, N: they carry as much as their friction can."""
    if ball.floor <= 0.0 or ball.weight <= 0.0:
        return 0.0
    return max(ball.weight - ball.sliding * pressed, 0.0)


@njit(**INLINE)
def climbing(ball: Any, nx: float, ny: float, tumble_x: float, tumble_y: float) -> float:
    """Upward slip of the ball on its outer wall, m/s."""
    return ball.floor_arm * (tumble_x * ny - tumble_y * nx)


@njit(**INLINE)
def on_floor(ball: Any, pressed: float, vx: float, vz: float, tumble_x: float, tumble_y: float) -> tuple:  # type: ignore[type-arg]
    """Force of the floor on a ball, and its torque on the horizontal part of the spin: four numbers."""
    left, arm = carried_by_floor(ball, pressed), ball.floor_arm
    if left == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    slip_x, slip_y = vx - arm * tumble_y, vz + arm * tumble_x
    fast = math.sqrt(slip_x * slip_x + slip_y * slip_y + TINY)
    drawn = -left * ball.floor * math.tanh(fast / ball.slip_speed) / fast
    force_x, force_y = drawn * slip_x, drawn * slip_y
    turning = math.sqrt(tumble_x * tumble_x + tumble_y * tumble_y + TINY)
    braked = ball.rolling_arm * left * math.tanh(ball.radius * turning / ball.rest_speed) / turning
    return force_x, force_y, arm * force_y - braked * tumble_x, -arm * force_x - braked * tumble_y


# Where a resolved ball touches the walls of its race, and how they press it.


class Touch(NamedTuple):
    """Outward normal at a ball, its velocity along the race, and the normal forces of both walls."""

    nx: float
    ny: float
    along: float
    wall: float
    inner: float


@njit(**INLINE)
def touch(p: System, ball: Any, x: float, z: float, vx: float, vz: float) -> Touch:
    """Of a ball at this place with this velocity, in the rotor."""
    # the wall at the ball: a circle, or where waves make it another curve, the nearest place of it
    away = math.sqrt(x * x + z * z + TINY)
    nx, ny = x / away, z / away
    level = ball.orbit
    depth = away - orbit(p.waves, ball, level, nx, ny)[0]
    outside = depth > 0.0
    if not outside:
        depth += ball.gap
        level -= ball.gap
    if ball.waves > 0 and (outside or depth < 0.0):
        depth, nx, ny = closest(p.waves, ball, level, x, z, nx, ny)
    # velocity against the wall and along it; then the spring and damper of the wall it touches, never a pull
    outward, along = vx * nx + vz * ny, vz * nx - vx * ny
    wall, inner = 0.0, 0.0
    hard, damping = ball.wall_stiffness, ball.wall_damping
    if not outside:
        depth, outward, hard, damping = -depth, -outward, ball.inner_stiffness, ball.inner_damping
    lightness = 1.0 / (ball.mass + ball.extra)
    damping = damping_at(p.rebounds, ball.rebound, damping, depth, outward, hard, lightness, ball.hertz)
    if outside:
        wall = normal_force(depth, outward, hard, damping, ball.hertz)
    else:
        inner = normal_force(depth, outward, hard, damping, ball.hertz)
    return Touch(nx, ny, along, wall, inner)


# Equations of motion of any linear rotor with balls that are resolved in contact: free in the plane of their race.
#
# Symbols, in the axes of the rotor: rho_s = E + rho from the station to the ball, u = rho' its velocity as seen from
# the rotor, sigma its spin as seen from there; F all forces on the ball but its weight W (walls, other balls, floor,
# drag, adherence), tau their torque on its spin. They depend on the state alone. With A the acceleration of the
# station,
#
#     m z'' + mu u' = F + W,         z'' = A + k + i w' rho_s + u',      k = 2 i w u - w^2 rho_s
#     J (sigma' + w') = tau
#
# m is the effective mass; mu, the rest of the ball's mass and the virtual mass, feels motion relative to the chamber
# only, as along the race of a guided ball (:mod:`autobalancer.kernels.balls.guided`), because the fluid turns with the
# chamber. The station feels W - m z'' = R - S A - w' c, which with s = mu/(m + mu) gives R = s (W - m k) - (1 - s) F,
# S = s m and c = s m i rho_s, and the rotor's torque is rho_s x (W - m z'') - tau. Without a fluid this is -F: action
# and reaction.


@njit(**INLINE)
def _slide(p: System, ball: Any, at: Any, slip: float, pressed: float) -> float:
    """Friction of a wall against this slip, N."""
    at.slip, at.pressed = slip, pressed
    return pressed * coefficient(p, ball, at, slip + pressed)


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
    # how both walls press, and how the ball slips on them: its spin turns the point of contact
    nx, ny, along, wall, inner = touch(p, ball, x, z, vx, vz)
    radius, lightness = ball.radius, 1.0 / (ball.mass + ball.extra)
    slip, climb = along + radius * spin, climbing(ball, nx, ny, y[own + TUMBLE_X], y[own + TUMBLE_Y])
    # both walls: friction by the slip of the point of contact, rolling resistance, adherence
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

    # the nearer partition, where the ball stands beside it and not beyond its edge
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

    # the floor carries what the wall does not
    floor = on_floor(ball, wall + inner, vx, vz, y[own + TUMBLE_X], y[own + TUMBLE_Y])
    force_x, force_y = force_x + floor[0], force_y + floor[1]
    free.tumble_x, free.tumble_y = floor[2] - radius * up * ny, floor[3] + radius * up * nx

    # drag by the velocity in the fluid; in a slipstream less of it along the race
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
    # from one center to the other; most pairs end here
    x, z = y[its + BALL_X] - y[own + BALL_X], y[its + BALL_Y] - y[own + BALL_Y]
    reach = one.radius + other.radius
    square = x * x + z * z + TINY
    if square >= reach * reach:
        return
    apart = math.sqrt(square)
    nx, ny = x / apart, z / apart
    vx, vz = y[its + BALL_VX] - y[own + BALL_VX], y[its + BALL_VY] - y[own + BALL_VY]
    # normal force: Hertz's stiffness depends on both radii, restitution on the speed of approach
    stiffness = one.ball_stiffness
    if one.hertz == 1:
        stiffness *= math.sqrt(one.radius * other.radius / reach)
    heavy, light = one.mass + one.extra, other.mass + other.extra
    lightness, near = (heavy + light) / (heavy * light), -(vx * nx + vz * ny)
    damping = one.ball_damping * math.sqrt(stiffness / lightness)
    table = p.pair_rebounds[i * p.ball_count + j] if p.pair_rebounds.size > 0 else CONSTANT
    damping = damping_at(p.rebounds, table, damping, reach - apart, near, stiffness, lightness, one.hertz)
    push = normal_force(reach - apart, near, stiffness, damping, one.hertz)
    # friction by the slip where both touch, of translation and both spins; it brakes both spins
    rub = 0.0
    if one.ball_sliding > 0.0:
        arm = apart / reach
        spins = arm * (one.radius * y[own + BALL_SPIN] + other.radius * y[its + BALL_SPIN])
        slip = vz * nx - vx * ny - spins
        rub = push * one.ball_sliding * math.tanh(slip / one.slip_speed)
        p.free[i].torque += arm * one.radius * rub
        p.free[j].torque += arm * other.radius * rub
    # action and reaction
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
    """Time derivative ``dy`` of the state ``y`` of :mod:`autobalancer.kernels.records`."""
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
    # in the rotor: arm, and the acceleration that the ball would feel without a force
    arm_x, arm_y = ball.center_x + y[own + BALL_X], ball.center_y + y[own + BALL_Y]
    fall_x, fall_y = _falling(motion)
    felt_x = fall_x + 2.0 * speed * y[own + BALL_VY] + speed * speed * arm_x
    felt_y = fall_y - 2.0 * speed * y[own + BALL_VX] + speed * speed * arm_y
    # its row, turned into the axes of the frame
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
    # acceleration of the station and of the axes of the rotor, less gravity, as the ball sees it
    arm_x, arm_y = ball.center_x + x, ball.center_y + z
    fall_x, fall_y = _falling(motion)
    ax = motion.cosine * one[at] + motion.sine * one[at + 1]
    ay = motion.cosine * one[at + 1] - motion.sine * one[at]
    ax += -2.0 * speed * vz - speed * speed * arm_x - acceleration * arm_y - fall_x
    ay += 2.0 * speed * vx - speed * speed * arm_y + acceleration * arm_x - fall_y
    # force over mass; the part of the mass that only feels motion in the chamber does not see the axes accelerate
    dx, dz = (free.force_x - mass * ax) / whole, (free.force_y - mass * ay) / whole
    dy[own + BALL_X], dy[own + BALL_Y] = vx, vz
    dy[own + BALL_VX], dy[own + BALL_VY] = dx, dz
    dy[own + BALL_SPIN] = free.torque / ball.spin_inertia - acceleration
    dy[own + HOLD] = free.hold_rate
    dy[own + TUMBLE_X] = free.tumble_x / ball.spin_inertia + speed * y[own + TUMBLE_Y]
    dy[own + TUMBLE_Y] = free.tumble_y / ball.spin_inertia - speed * y[own + TUMBLE_X]
    # the angle of the ball, for what is measured and shown: its rate and acceleration follow from x and z
    inverse = 1.0 / (x * x + z * z + TINY)
    rate = (x * vz - z * vx) * inverse
    dy[BALLS + b] = rate
    dy[BALLS + p.ball_count + b] = (x * dz - z * dx) * inverse - 2.0 * rate * (x * vx + z * vz) * inverse
    return False


# What walls and floor do to resolved balls at states that were saved.


@njit(void(types.Array(types.float64, 3, "C"), system_type, matrix_type, matrix_type, matrix_type), **COMPILED)
def contacts(own: Any, p: System, gap: Matrix, force: Matrix, floor: Matrix) -> None:
    """Write distance from the outer wall, its normal force and that of the floor, (times, balls), for states
    (times, balls, BALL_STATES).
    """
    for i in range(own.shape[0]):
        for b in range(own.shape[1]):
            ball = p.free_balls[b]
            x, z = own[i, b, BALL_X], own[i, b, BALL_Y]
            away = math.sqrt(x * x + z * z + TINY)
            nx, ny = x / away, z / away
            depth = away - orbit(p.waves, ball, ball.orbit, nx, ny)[0]
            if ball.waves > 0:
                depth, nx, ny = closest(p.waves, ball, ball.orbit, x, z, nx, ny)
            gap[i, b] = -depth
            at = touch(p, ball, x, z, own[i, b, BALL_VX], own[i, b, BALL_VY])
            force[i, b] = at.wall
            floor[i, b] = carried_by_floor(ball, at.wall + at.inner)
