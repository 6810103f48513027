"""Where a resolved ball touches the walls of its race, and how they press it."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from autobalancer.kernels.balls.path import closest, orbit
from autobalancer.kernels.flags import INLINE, njit
from autobalancer.kernels.laws.contact import normal_force
from autobalancer.kernels.laws.rebound import damping_at
from autobalancer.kernels.system import System

TINY = 1e-30  # m^2, keeps the direction of a ball at the center of its race a number


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
