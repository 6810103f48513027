"""Equations of motion of any linear rotor with balls that are resolved in contact: free in the plane of their race.

Symbols, in the axes of the rotor: rho_s = E + rho from the station to the ball, u = rho' its velocity as seen from the rotor,
sigma its spin as seen from there; F all forces on the ball but its weight W (walls, other balls, floor, drag, adherence),
tau their torque on its spin. They depend on the state alone. With A the acceleration of the station,

    m z'' + mu u' = F + W,         z'' = A + k + i w' rho_s + u',      k = 2 i w u - w^2 rho_s
    J (sigma' + w') = tau

m is the effective mass; mu, the rest of the ball's mass and the virtual mass, feels motion relative to the chamber only, as
along the race of a guided ball (:mod:`autobalancer.kernels.guided_balls`), because the fluid turns with the chamber. The
station feels W - m z'' = R - S A - w' c, which with s = mu/(m + mu) gives R = s (W - m k) - (1 - s) F, S = s m and
c = s m i rho_s, and the rotor's torque is rho_s x (W - m z'') - tau. Without a fluid this is -F: action and reaction.
"""

from __future__ import annotations

import math

from numba import njit

from autobalancer.kernels.contact_laws import adherence, friction_coefficient, normal_force
from autobalancer.kernels.curves import drag_force, table_value
from autobalancer.kernels.flags import EQUATIONS, INLINE
from autobalancer.kernels.pointers import behind, data
from autobalancer.kernels.race_shape import closest, orbit
from autobalancer.kernels.resolved_layout import (
    ADHERENCE,
    BALL_DAMPING,
    BALL_SLIDING,
    BALL_SPIN,
    BALL_STATES,
    BALL_STIFFNESS,
    BALL_VX,
    BALL_VY,
    BALL_X,
    BALL_Y,
    CENTER_X,
    CENTER_Y,
    DRAG_CURVE,
    EXTRA,
    FIRST_MODE,
    FLOOR,
    FORCE_X,
    FORCE_Y,
    GAP,
    HERTZ,
    HOLD,
    HOLD_DAMPING,
    HOLD_RATE,
    HOLD_STIFFNESS,
    INNER_DAMPING,
    INNER_STIFFNESS,
    LAG_TABLE,
    MASS_,
    MODE_NUMBERS,
    MODES,
    ORBIT_,
    PART_AHEAD,
    PART_BEHIND,
    PART_DAMPING,
    PART_MIDDLE,
    PART_STIFFNESS,
    PARTITIONS,
    PEAK,
    PEAK_SPEED,
    PLACE_,
    RACE_,
    RADIUS,
    RESOLVED_COLUMNS,
    REST_SPEED,
    ROLLING_ARM,
    SHAPE,
    SLIDING,
    SLIP_SPEED,
    SLIPSTREAM,
    SPIN_INERTIA,
    SPIN_TORQUE,
    VISCOUS,
    WALL_DAMPING,
    WALL_STIFFNESS,
    WEIGHT,
)
from autobalancer.kernels.rotor_layout import BALL_ROWS, COORDINATES, PLACES, TABLE, WIDTH, blocks
from autobalancer.kernels.rotor_motion import alone, together, write_rotor
from autobalancer.kernels.shaking import shake
from autobalancer.kernels.slipstream import slipstream
from autobalancer.kernels.system import BALLS, PRESCRIBED, Floats, System

TINY = 1e-30  # m^2, keeps the direction of a ball at the center of its race a number


@njit(**INLINE)
def _slide(slip: float, r, at: int, pressed: float) -> float:  # type: ignore[no-untyped-def]
    """Friction of a wall against this slip, N."""
    return pressed * friction_coefficient(slip, r[at + SLIDING], r[at + PEAK], r[at + SLIP_SPEED], r[at + PEAK_SPEED])


@njit(**INLINE)
def _in_chamber(time: float, y, r, at: int, own: int, angle: float) -> None:  # type: ignore[no-untyped-def]
    """Forces of walls, partitions, floor and fluid on the ball with row ``at`` and state ``own``, into its work space."""
    x, z, vx, vz, spin = y[own + BALL_X], y[own + BALL_Y], y[own + BALL_VX], y[own + BALL_VY], y[own + BALL_SPIN]
    away = math.sqrt(x * x + z * z + TINY)
    nx, ny = x / away, z / away
    radius, shape, level = r[at + RADIUS], int(r[at + SHAPE]), r[at + ORBIT_]
    depth = away - orbit(r, shape, level, nx, ny)[0]
    outside = depth > 0.0
    if not outside:
        depth += r[at + GAP]
        level -= r[at + GAP]
    if shape > 0 and (outside or depth < 0.0):
        depth, nx, ny = closest(r, shape, level, x, z, nx, ny)
    outward, along = vx * nx + vz * ny, vz * nx - vx * ny
    wall, inner = 0.0, 0.0
    if outside:
        wall = normal_force(depth, outward, r[at + WALL_STIFFNESS], r[at + WALL_DAMPING], r[at + HERTZ])
    else:
        inner = normal_force(-depth, -outward, r[at + INNER_STIFFNESS], r[at + INNER_DAMPING], r[at + HERTZ])

    slip = along + radius * spin
    rub, torque, hold_rate = 0.0, 0.0, 0.0
    if wall > 0.0:
        rub = _slide(slip, r, at, wall)
        torque = -radius * rub
    if inner > 0.0:
        grip = _slide(along - radius * spin, r, at, inner)
        rub += grip
        torque += radius * grip
    if r[at + ROLLING_ARM] > 0.0:
        torque -= r[at + ROLLING_ARM] * (wall + inner) * math.tanh(radius * spin / r[at + REST_SPEED])
    if r[at + ADHERENCE] > 0.0:
        held, hold_rate = adherence(
            y[own + HOLD],
            slip,
            along,
            r[at + ADHERENCE] * wall,
            r[at + HOLD_STIFFNESS],
            r[at + HOLD_DAMPING],
            r[at + REST_SPEED],
        )
        rub += held
    push = inner - wall
    force_x, force_y = push * nx + rub * ny, push * ny - rub * nx

    if r[at + PARTITIONS] != 0.0:
        place = int(r[at + PARTITIONS])
        side, normal = 1.0, place + PART_BEHIND
        if angle > r[place + PART_MIDDLE]:
            side, normal = -1.0, place + PART_AHEAD
        px, py = r[normal], r[normal + 1]
        depth = radius - (x * px + z * py)
        if depth > 0.0 and side * (x * py - z * px) > 0.0:
            inward, along = vx * px + vz * py, vx * py - vz * px
            push = normal_force(depth, -inward, r[place + PART_STIFFNESS], r[place + PART_DAMPING], r[at + HERTZ])
            rub = push * r[at + BALL_SLIDING] * math.tanh((along + radius * spin) / r[at + SLIP_SPEED])
            force_x += push * px - rub * py
            force_y += push * py + rub * px
            torque -= radius * rub

    if r[at + FLOOR] > 0.0 and r[at + WEIGHT] > 0.0:
        # the wall carries as much of the weight as its friction can
        left = r[at + WEIGHT] - r[at + SLIDING] * (wall + inner)
        if left > 0.0:
            fast = math.sqrt(vx * vx + vz * vz + TINY)
            drawn = left * r[at + FLOOR] * math.tanh(fast / r[at + SLIP_SPEED]) / fast
            force_x -= drawn * vx
            force_y -= drawn * vz

    lag = 0.0
    for i in range(int(r[at + MODES])):
        lag += y[int(r[at + FIRST_MODE]) + i]
    if r[at + LAG_TABLE] != 0.0:
        lag += table_value(r, int(r[at + LAG_TABLE]), time)
    ux, uy = vx - lag * z, vz + lag * x
    fast = math.sqrt(ux * ux + uy * uy + TINY)
    braked = drag_force(r, int(r[at + DRAG_CURVE]), r[at + VISCOUS], fast) / fast
    if r[at + SLIPSTREAM] != 0.0:
        ahead = uy * nx - ux * ny
        spared = (1.0 - slipstream(y, r, int(r[at + SLIPSTREAM]), ahead, fast)) * braked * ahead
        force_x, force_y = force_x - spared * ny, force_y + spared * nx
    r[at + FORCE_X], r[at + FORCE_Y] = force_x - braked * ux, force_y - braked * uy
    r[at + SPIN_TORQUE], r[at + HOLD_RATE] = torque, hold_rate


@njit(**INLINE)
def _meet(y, r, one: int, other: int, own: int, its: int) -> None:  # type: ignore[no-untyped-def]
    """Forces between two balls of one race, added to their work spaces."""
    x, z = y[its + BALL_X] - y[own + BALL_X], y[its + BALL_Y] - y[own + BALL_Y]
    reach = r[one + RADIUS] + r[other + RADIUS]
    square = x * x + z * z + TINY
    if square >= reach * reach:
        return
    apart = math.sqrt(square)
    nx, ny = x / apart, z / apart
    vx, vz = y[its + BALL_VX] - y[own + BALL_VX], y[its + BALL_VY] - y[own + BALL_VY]
    stiffness = r[one + BALL_STIFFNESS]
    if r[one + HERTZ] == 1.0:
        stiffness *= math.sqrt(r[one + RADIUS] * r[other + RADIUS] / reach)
    heavy, light = r[one + MASS_] + r[one + EXTRA], r[other + MASS_] + r[other + EXTRA]
    damping = r[one + BALL_DAMPING] * math.sqrt(stiffness * heavy * light / (heavy + light))
    push = normal_force(reach - apart, -(vx * nx + vz * ny), stiffness, damping, r[one + HERTZ])
    rub = 0.0
    if r[one + BALL_SLIDING] > 0.0:
        arm = apart / reach
        spins = arm * (r[one + RADIUS] * y[own + BALL_SPIN] + r[other + RADIUS] * y[its + BALL_SPIN])
        slip = vz * nx - vx * ny - spins
        rub = push * r[one + BALL_SLIDING] * math.tanh(slip / r[one + SLIP_SPEED])
        r[one + SPIN_TORQUE] += arm * r[one + RADIUS] * rub
        r[other + SPIN_TORQUE] += arm * r[other + RADIUS] * rub
    force_x, force_y = push * nx + rub * ny, push * ny - rub * nx
    r[one + FORCE_X] -= force_x
    r[one + FORCE_Y] -= force_y
    r[other + FORCE_X] += force_x
    r[other + FORCE_Y] += force_y


@njit(**EQUATIONS)
def resolved(time: float, y: Floats, dy: Floats, system: System) -> None:
    """Time derivative ``dy`` of the state ``y`` of :mod:`autobalancer.kernels.resolved_layout`."""
    p = behind(system)
    count = p.balls.shape[0]
    r = data(p.rotor)
    size, width, table = int(r[COORDINATES]), int(r[WIDTH]), int(r[TABLE])
    k = blocks(width, int(r[PLACES]) * 2, table)
    free = p.drive != PRESCRIBED
    speed, acceleration, turn_sin, turn_cos, gx, gy, torque = alone(time, y, system, r, 2)
    gx, gy, torque = shake(time, y, system, r, turn_sin, turn_cos, gx, gy, torque)
    inertia, square = p.polar_inertia, speed * speed
    first_row, first_state = int(r[BALL_ROWS]), 2 + 2 * size + 2 * count
    fall_x, fall_y = turn_cos * gx + turn_sin * gy, turn_cos * gy - turn_sin * gx

    for b in range(count):
        _in_chamber(time, y, r, first_row + b * RESOLVED_COLUMNS, first_state + b * BALL_STATES, y[BALLS + b])
    for b in range(count):
        at, own = first_row + b * RESOLVED_COLUMNS, first_state + b * BALL_STATES
        for other in range(b + 1, count):
            its = first_row + other * RESOLVED_COLUMNS
            if r[at + RACE_] >= 0.0 and r[at + RACE_] == r[its + RACE_]:
                _meet(y, r, at, its, own, first_state + other * BALL_STATES)

    for b in range(count):
        at, own = first_row + b * RESOLVED_COLUMNS, first_state + b * BALL_STATES
        station = int(r[at + PLACE_]) * 2
        mass, share = r[at + MASS_], r[at + EXTRA] / (r[at + MASS_] + r[at + EXTRA])
        arm_x, arm_y = r[at + CENTER_X] + y[own + BALL_X], r[at + CENTER_Y] + y[own + BALL_Y]
        known_x = -2.0 * speed * y[own + BALL_VY] - square * arm_x
        known_y = 2.0 * speed * y[own + BALL_VX] - square * arm_y
        carried = share * mass
        felt_x = carried * (fall_x - known_x) - (1.0 - share) * r[at + FORCE_X]
        felt_y = carried * (fall_y - known_y) - (1.0 - share) * r[at + FORCE_Y]
        torque += arm_x * felt_y - arm_y * felt_x - r[at + SPIN_TORQUE]
        lean_x, lean_y = -carried * arm_y, carried * arm_x
        inertia += carried * (arm_x * arm_x + arm_y * arm_y)
        if not free:
            felt_x -= acceleration * lean_x
            felt_y -= acceleration * lean_y
        r[k.pushing + station] += turn_cos * felt_x - turn_sin * felt_y
        r[k.pushing + station + 1] += turn_sin * felt_x + turn_cos * felt_y
        r[k.own + station * 2] += carried
        r[k.own + station * 2 + 3] += carried
        if free:
            bent_x, bent_y = turn_cos * lean_x - turn_sin * lean_y, turn_sin * lean_x + turn_cos * lean_y
            r[k.arms + station] += bent_x
            r[k.arms + station + 1] += bent_y
            r[k.turning + station] += bent_x
            r[k.turning + station + 1] += bent_y

    acceleration = together(system, r, 2, acceleration, torque, inertia)
    write_rotor(y, dy, system, r, 2, speed, acceleration)
    for b in range(count):
        at, own = first_row + b * RESOLVED_COLUMNS, first_state + b * BALL_STATES
        station = k.one + int(r[at + PLACE_]) * 2
        mass, whole = r[at + MASS_], r[at + MASS_] + r[at + EXTRA]
        x, z, vx, vz = y[own + BALL_X], y[own + BALL_Y], y[own + BALL_VX], y[own + BALL_VY]
        arm_x, arm_y = r[at + CENTER_X] + x, r[at + CENTER_Y] + z
        ax, ay = turn_cos * r[station] + turn_sin * r[station + 1], turn_cos * r[station + 1] - turn_sin * r[station]
        ax += -2.0 * speed * vz - square * arm_x - acceleration * arm_y - fall_x
        ay += 2.0 * speed * vx - square * arm_y + acceleration * arm_x - fall_y
        dx, dz = (r[at + FORCE_X] - mass * ax) / whole, (r[at + FORCE_Y] - mass * ay) / whole
        dy[own + BALL_X], dy[own + BALL_Y] = vx, vz
        dy[own + BALL_VX], dy[own + BALL_VY] = dx, dz
        dy[own + BALL_SPIN] = r[at + SPIN_TORQUE] / r[at + SPIN_INERTIA] - acceleration
        dy[own + HOLD] = r[at + HOLD_RATE]
        inverse = 1.0 / (x * x + z * z + TINY)
        rate = (x * vz - z * vx) * inverse
        dy[BALLS + b] = rate
        dy[BALLS + count + b] = (x * dz - z * dx) * inverse - 2.0 * rate * (x * vx + z * vz) * inverse
        numbers, modes = int(r[at + MODE_NUMBERS]), int(r[at + MODES])
        for i in range(modes):
            state = int(r[at + FIRST_MODE]) + i
            dy[state] = r[numbers + modes + i] * acceleration - r[numbers + i] * y[state]
