"""A guided ball: on a path of any shape, with any drag, rolling resistance and rest by adherence, also where its race tilts.

Symbols, in the axes of the frame: a ball at rho = E + eps n from the axis, its path tau = d rho/d phi with the length L
per angle, n_hat = -i tau/L outward normal. With A the acceleration of the station and k what is known of the rest,

    z'' = A + tau phi'' + i rho w' + k,    k = d tau/d phi phi'^2 + 2 i w tau phi' - w^2 rho
    I phi'' = r - m tau.A - c w' - f N,    N = -n_hat.m (z'' - g),    I = (inertia) L^2,    c = m rho x tau - j m a L

r holds centrifugal force, weight, drag and contact, N also what balls that touch press each other onto the wall; f = mu L is
the arm of rolling resistance against the motion. The normal force N depends on the accelerations itself: it is put in, which
leaves a system that is linear but not symmetric. A ball at rest on its race has phi'' = 0 instead, and r - m tau.A - c w' is
what must hold it. Derived from the kinetic energy of ball, rotor and spin, J/2 (w - L phi'/a)^2: a ball or roller rolls with
its radius a = r, a pendulum turns with w + phi', which is a = -eps on its circle.

A station has two rows (deflection), or four (slope s too) where balls move with their full inertia on a race that tilts: to
second order in the slope the ball then has the axial motion s.rho and less reach across the axis, rho - (s.rho) s/2. With
h = rho x rho' its kinetic energy grows by m/2 ((s'.rho)^2 + h (s' x s)), its potential by m (a + g.s/2) s.rho, where a is the
acceleration of gravity along the axis. Without (Rodrigues et al. 2011, 1) balls feel the deflection of their station only.

Everything here is a function of numbers; kernels/balls/rates.py has the arrays.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from autobalancer.kernels.compiler.flags import INLINE, njit
from autobalancer.kernels.compiler.numba_struct import data
from autobalancer.kernels.compiler.simd import full_like, root, where
from autobalancer.kernels.host.linear import Motion
from autobalancer.kernels.laws.contact_law import table_value
from autobalancer.kernels.system import BALLS, System
from autobalancer.kernels.trigonometry import sine_cosine


class Path(NamedTuple):
    """Where a ball is on its path, and how the path goes on; m, m^2."""

    x: float  # rho
    y: float
    along_x: float  # tau
    along_y: float
    bend_x: float  # d tau / d phi
    bend_y: float
    out_x: float  # n_hat
    out_y: float
    length: float  # L
    growth: float  # L dL / d phi
    rise: float  # rho.tau
    sweep: float  # rho x tau


class Row(NamedTuple):
    """I phi'' = push - lean.A - spin w' before friction; u and v go with the slope."""

    push: float
    spin: float
    x: float
    y: float
    u: float
    v: float


class Normal(NamedTuple):
    """N = push - (x, y, u, v).A - twist w'."""

    push: float
    twist: float
    x: float
    y: float
    u: float
    v: float


class Share(NamedTuple):
    """What the ball gives its station, R - w' arm, and the rotor, with phi'' = 0; its part of S is known from its mass."""

    x: float
    y: float
    u: float
    v: float
    arm_x: float
    arm_y: float
    arm_u: float
    arm_v: float
    torque: float
    inertia: float


class Slope(NamedTuple):
    """How a race tilts: slope of its axis along x and y, and its rate; and gravity along the axis."""

    x: float
    y: float
    rate_x: float
    rate_y: float
    axial_gravity: float


@njit(**INLINE)
def circle(orbit: float, ex: float, ey: float, nx: float, ny: float) -> Path:
    """A smooth circle around (ex, ey)."""
    tx, ty = -orbit * ny, orbit * nx
    return Path(
        ex + orbit * nx, ey + orbit * ny, tx, ty, -orbit * nx, -orbit * ny, nx, ny,
        orbit, 0.0, ex * tx + ey * ty, orbit * (orbit + ex * nx + ey * ny),
    )  # fmt: skip


@njit(**INLINE)
def wavy(radius: float, first: float, second: float, ex: float, ey: float, nx: float, ny: float) -> Path:
    """A path with this radius and its derivatives with respect to the angle."""
    tx, ty = first * nx - radius * ny, first * ny + radius * nx
    length = root(radius * radius + first * first)
    return Path(
        ex + radius * nx, ey + radius * ny, tx, ty,
        (second - radius) * nx - 2.0 * first * ny, (second - radius) * ny + 2.0 * first * nx,
        ty / length, -tx / length, length, first * (second + radius),
        radius * first + ex * tx + ey * ty, radius * radius + ex * ty - ey * tx,
    )  # fmt: skip


@njit(**INLINE)
def row(ball: Any, path: Path, motion: Motion, rate: float, drag: float, contact: float) -> Row:
    """The ball's own row on a race that does not tilt; ``drag`` is a force, ``contact`` a torque."""
    lean_x, lean_y = ball.mass * path.along_x, ball.mass * path.along_y
    push = ball.mass * motion.speed * motion.speed * path.rise + lean_x * motion.gravity_x + lean_y * motion.gravity_y
    push += contact - drag * path.length - ball.stretch * path.growth * rate * rate
    return Row(push, ball.mass * path.sweep - ball.roll * path.length, lean_x, lean_y, 0.0, 0.0)


@njit(**INLINE)
def known_acceleration(path: Path, speed: float, rate: float) -> tuple[float, float]:
    """k, of the ball against its station."""
    square, turning = rate * rate, 2.0 * speed * rate
    return (
        path.bend_x * square - turning * path.along_y - speed * speed * path.x,
        path.bend_y * square + turning * path.along_x - speed * speed * path.y,
    )


@njit(**INLINE)
def normal(mass: float, path: Path, motion: Motion, known: tuple[float, float], outward: float) -> Normal:
    """The normal force on a race that does not tilt; ``outward`` is what other balls press."""
    out_x, out_y = mass * path.out_x, mass * path.out_y
    push = out_x * (motion.gravity_x - known[0]) + out_y * (motion.gravity_y - known[1]) + outward
    return Normal(push, out_y * path.x - out_x * path.y, out_x, out_y, 0.0, 0.0)


@njit(**INLINE)
def share(ball: Any, path: Path, motion: Motion, known: tuple[float, float], rate: float) -> Share:
    """What station and rotor get on a race that does not tilt."""
    mass, felt_x, felt_y = ball.mass, motion.gravity_x - known[0], motion.gravity_y - known[1]
    arm_x, arm_y = -mass * path.y, mass * path.x
    return Share(
        mass * felt_x, mass * felt_y, 0.0, 0.0, arm_x, arm_y, 0.0, 0.0,
        arm_x * felt_x + arm_y * felt_y + ball.roll * path.growth / path.length * rate * rate,
        mass * (path.x * path.x + path.y * path.y) + ball.own_spin,
    )  # fmt: skip


# The same on a smooth circle with linear drag, where most of these products are known before: one source of the equations of
# planar rotors and stations, of numbers at one instant or of lanes at the nodes of a long step.


@njit(**INLINE)
def on_circle(
    ball: Any, ex: float, ey: float, nx: float, ny: float, motion: Motion, rate: float, contact: float, heavy: bool
) -> tuple[Row, Share]:
    """Row and share of a ball on a circle around (ex, ey); ``heavy``: whether there is gravity.

    Of the inertia, the share has what changes as the ball moves: the rest is :func:`steady_inertia`.
    """
    # around the axis: the ball feels what touches it and its drag, its station the centrifugal force
    pull = (motion.speed + rate) * (motion.speed + rate) * ball.moment
    lean_x, lean_y, zero = ny * -ball.moment, nx * ball.moment, full_like(nx, 0.0)
    its = Row(contact - rate * ball.drag, full_like(nx, ball.spin), lean_x, lean_y, 0.0, 0.0)
    part = Share(pull * nx, pull * ny, 0.0, 0.0, lean_x, lean_y, 0.0, 0.0, zero, zero)
    if ball.center_x != 0.0 or ball.center_y != 0.0:
        its, part = _off_axis(ball, ex, ey, nx, ny, motion.speed, rate, its, part)
    if heavy:
        its, part = _weighed(ball.mass, motion.gravity_x, motion.gravity_y, its, part)
    return its, part


@njit(**INLINE)
def _off_axis(
    ball: Any, ex: float, ey: float, nx: float, ny: float, speed: float, rate: float, its: Row, part: Share
) -> tuple[Row, Share]:
    """What the eccentricity E of the race adds: m eps E.n to the coupling with w', m eps (E x n) w^2 to the ball's row."""
    along, across = (nx * ex + ny * ey) * ball.moment, (nx * ey - ny * ex) * ball.moment
    square, mx, my = speed * speed, ex * ball.mass, ey * ball.mass
    return (
        Row(its.push + across * square, its.spin + along, its.x, its.y, its.u, its.v),
        Share(
            part.x + square * mx, part.y + square * my, part.u, part.v,
            part.arm_x - my, part.arm_y + mx, part.arm_u, part.arm_v,
            part.torque - across * rate * (2.0 * speed + rate), part.inertia + along * 2.0,
        ),
    )  # fmt: skip


@njit(**INLINE)
def _weighed(mass: float, gx: float, gy: float, its: Row, part: Share) -> tuple[Row, Share]:
    """What the weight of the ball adds: along its path, to the force on the station, and about the axis."""
    return (
        Row(its.push + its.x * gx + its.y * gy, its.spin, its.x, its.y, its.u, its.v),
        Share(
            part.x + mass * gx, part.y + mass * gy, part.u, part.v, part.arm_x, part.arm_y, part.arm_u, part.arm_v,
            part.torque + part.arm_x * gx + part.arm_y * gy, part.inertia,
        ),
    )  # fmt: skip


@njit(**INLINE)
def steady_inertia(ball: Any) -> float:
    """What a ball adds to the inertia of the rotor wherever it is on its circle, kg m^2."""
    away = ball.orbit * ball.orbit + ball.center_x * ball.center_x + ball.center_y * ball.center_y
    return ball.mass * away + ball.own_spin


@njit(**INLINE)
def tilting_row(its: Row, mass: float, path: Path, motion: Motion, slope: Slope) -> Row:
    """The ball's row with what the tilt adds."""
    sway, spin, weight = _sway(mass, path, motion, slope)
    push = sway * (slope.rate_x * path.along_x + slope.rate_y * path.along_y) + mass * spin * path.rise * motion.speed
    push -= weight * (slope.x * path.along_x + slope.y * path.along_y)
    arm = 0.5 * mass * path.sweep
    return Row(its.push + push, its.spin, its.x, its.y, arm * slope.y, -arm * slope.x)


@njit(**INLINE)
def tilting_normal(force: Normal, mass: float, path: Path, motion: Motion, slope: Slope, rate: float) -> Normal:
    """The normal force, in the plane of the race, with what the tilt adds."""
    sway, spin, weight = _sway(mass, path, motion, slope)
    out = path.x * path.out_x + path.y * path.out_y
    push = sway * (slope.rate_x * path.out_x + slope.rate_y * path.out_y)
    push += mass * spin * (path.length * rate + motion.speed * out)
    push -= weight * (slope.x * path.out_x + slope.y * path.out_y)
    arm = 0.5 * mass * (path.x * path.out_y - path.y * path.out_x)
    return Normal(force.push + push, force.twist, force.x, force.y, arm * slope.y, -arm * slope.x)


@njit(**INLINE)
def tilting_share(part: Share, mass: float, path: Path, motion: Motion, slope: Slope, rate: float) -> Share:
    """What station and rotor get, with what the tilt adds."""
    sway, spin, weight = _sway(mass, path, motion, slope)
    speed, sag = motion.speed, 0.5 * mass * (slope.x * path.x + slope.y * path.y)
    moving_x, moving_y = path.along_x * rate - speed * path.y, path.along_y * rate + speed * path.x
    known = 2.0 * mass * (slope.rate_x * moving_x + slope.rate_y * moving_y) + weight
    bend = path.x * path.bend_y - path.y * path.bend_x  # d sweep / d phi
    spun = 0.5 * mass * (bend * rate * rate + 2.0 * path.rise * rate * speed)
    whole = 0.5 * mass * (path.x * path.x + path.y * path.y)
    torque = sway * (slope.rate_y * path.x - slope.rate_x * path.y) - mass * spin * path.rise * rate
    torque -= weight * (slope.y * path.x - slope.x * path.y)
    return Share(
        part.x, part.y,
        -known * path.x - sag * motion.gravity_x - spun * slope.y,
        -known * path.y - sag * motion.gravity_y + spun * slope.x,
        part.arm_x, part.arm_y, whole * slope.y, -whole * slope.x, part.torque + torque, part.inertia,
    )  # fmt: skip


@njit(**INLINE)
def _sway(mass: float, path: Path, motion: Motion, slope: Slope) -> tuple[float, float, float]:
    """m s'.rho, s' x s, and the weight along the axis as the tilted race sees it."""
    sway = mass * (slope.rate_x * path.x + slope.rate_y * path.y)
    spin = slope.rate_x * slope.y - slope.rate_y * slope.x
    weight = mass * (slope.axial_gravity + 0.5 * (motion.gravity_x * slope.x + motion.gravity_y * slope.y))
    return sway, spin, weight


@njit(**INLINE)
def rubbing_arm(ball: Any, path: Path, mode: float, force: float) -> float:
    """Arm f of rolling resistance against the motion; a ball that nothing presses on its race does not rub, a bearing does."""
    arm = mode * ball.rolling * path.length
    return where(force > 0.0, arm, -ball.pulls * arm)


@njit(**INLINE)
def rubbed(its: Row, force: Normal, arm: float) -> Row:
    """The ball's row with friction of that arm."""
    return Row(
        its.push - arm * force.push, its.spin - arm * force.twist,
        its.x - arm * force.x, its.y - arm * force.y, its.u - arm * force.u, its.v - arm * force.v,
    )  # fmt: skip


@njit(**INLINE)
def solved(its: Row, inverse: float, acceleration: float) -> Row:
    """phi'' itself: the row times the inverse of its inertia (0 at rest), and a known acceleration of the rotor put in."""
    known = Row(its.push - its.spin * acceleration, its.spin, its.x, its.y, its.u, its.v)
    return scaled(known, inverse)


@njit(**INLINE)
def left_over(its: Row, x: float, y: float, acceleration: float) -> float:
    """What a row leaves where station and rotor have these accelerations, on a race that does not tilt."""
    return its.push - its.spin * acceleration - its.x * x - its.y * y


@njit(**INLINE)
def scaled(its: Row, factor: float) -> Row:
    """All numbers of a row times a factor."""
    return Row(its.push * factor, its.spin * factor, its.x * factor, its.y * factor, its.u * factor, its.v * factor)


# Balls of one race that touch, and partitions of a race: springs and dampers that never pull, and friction.
#
# Rigid contacts are in the room ``rigid``.
#
# Rolling balls rub where they touch. Friction takes from each ball what its part of the slip gives it,
# laws/impacts.py. A ball at a partition hardly rolls, so nothing rubs there.


@njit(**INLINE)
def touch(y: Any, p: System) -> None:
    """Find for each guided ball the torque of what it touches, and what this presses it on the wall.

    Balls are numbered in their order around the race, which contact preserves.
    """
    count, moving = p.ball_count, p.guided
    # what is given from outside, then every soft contact adds to both of its balls
    for i in range(count):
        moving[i].contact = moving[i].given
        moving[i].outward = moving[i].given_out
    for i in range(count):
        angle, rate, pair = y[BALLS + i], y[BALLS + count + i], p.contacts[i]
        if pair.hard > 0.0:
            other = pair.next
            deep = pair.touch - (y[BALLS + other] - angle + pair.wrap)
            # a spring, and a damper that depends on depth and speed where restitution does; it never pulls
            if deep > 0.0:
                its = y[BALLS + count + other]
                soft = pair.soft
                if pair.rebound >= 0:
                    near = pair.pace * (rate - its)
                    soft *= table_value(data(p.rebounds), pair.rebound, pair.pace * pair.quick * deep, near)
                pressed = pair.hard * deep - soft * (its - rate)
                if pressed > 0.0:
                    moving[i].contact -= pressed
                    moving[other].contact += pressed
                    moving[i].outward += pressed * pair.out
                    moving[other].outward += pressed * pair.out_next
                    # friction where both touch: a smooth sign of the slip there, with the arm of each ball
                    if pair.rub > 0.0:
                        rub = pressed * pair.rub * math.tanh((pair.arm * rate + pair.arm_next * its) * pair.grip)
                        moving[i].contact -= pair.arm * rub
                        moving[other].contact -= pair.arm_next * rub
                        moving[i].outward -= rub / p.balls[i].orbit
                        moving[other].outward += rub / p.balls[other].orbit
        # a partition of the race, on the side that is nearer
        if pair.wall_hard > 0.0:
            way, deep = 1.0, pair.wall_low - angle
            if angle > pair.wall_high:
                way, deep = -1.0, angle - pair.wall_high
            if deep > 0.0:
                soft = pair.wall_soft
                if pair.wall_rebound >= 0:
                    held, near = pair.wall_pace * pair.wall_quick * deep, -pair.wall_pace * way * rate
                    soft *= table_value(data(p.rebounds), pair.wall_rebound, held, near)
                moving[i].contact += way * max(pair.wall_hard * deep - way * soft * rate, 0.0)


# The orbit of a race that is not round: eps(phi), a Fourier series, and the point of it that is closest to a ball.


CLOSE = 1e-6  # rad; Newton's next step would be shorter than the square of the last one times the order of the waves
STEPS = 20


@njit(**INLINE)
def orbit(waves: Any, ball: Any, mean: float, c: float, s: float) -> tuple[float, float, float]:
    """Radius and its first two derivatives at the angle with cosine c and sine s; a circle where the ball has no waves."""
    radius, first, second = mean, 0.0, 0.0
    cosine, sine = c, s
    for h in range(1, ball.waves + 1):
        wave = waves[ball.first_wave + h - 1]
        radius += wave.cosine * cosine + wave.sine * sine
        first += h * (wave.sine * cosine - wave.cosine * sine)
        second -= h * h * (wave.cosine * cosine + wave.sine * sine)
        cosine, sine = cosine * c - sine * s, sine * c + cosine * s
    return radius, first, second


@njit(**INLINE)
def closest(waves: Any, ball: Any, mean: float, x: float, z: float, c: float, s: float) -> tuple[float, float, float]:
    """How far (x, z) is outside the orbit, and the outward normal of the orbit there; c and s are its direction.

    Newton's method for (P - C).C' = 0 from the point at the same angle. The distance is exact up to rounding where it is
    less than the radius of curvature, its gradient is the normal, and so a force that depends on it has a potential.
    """
    radius, first, second = orbit(waves, ball, mean, c, s)
    out, along = x * c + z * s - radius, 0.0
    path = radius * radius + first * first
    for _ in range(STEPS):
        bent = path - out * (second - radius) - 2.0 * along * first
        step = (out * first + along * radius) / max(
            bent, 0.25 * path
        )  # the bound keeps a far point on its way downhill
        turned, kept = sine_cosine(step)
        c, s = c * kept - s * turned, s * kept + c * turned
        radius, first, second = orbit(waves, ball, mean, c, s)
        out, along = x * c + z * s - radius, z * c - x * s
        path = radius * radius + first * first
        if abs(step) < CLOSE:
            break
    length = math.sqrt(path)
    even, odd = radius / length, first / length
    return out * even - along * odd, even * c + odd * s, even * s - odd * c
