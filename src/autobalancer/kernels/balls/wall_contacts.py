"""Contacts of resolved balls with their outer wall at states that were saved."""

from __future__ import annotations

import math
from typing import Any

from numba import njit, types, void

from autobalancer.kernels.balls.path import closest, orbit
from autobalancer.kernels.flags import COMPILED
from autobalancer.kernels.laws.contact import normal_force
from autobalancer.kernels.laws.rebound import damping_at
from autobalancer.kernels.records.resolved import BALL_VX, BALL_VY, BALL_X, BALL_Y
from autobalancer.kernels.system import Matrix, System, matrix_type, system_type

TINY = 1e-30  # m^2, as in resolved.py


@njit(void(types.Array(types.float64, 3, "C"), system_type, matrix_type, matrix_type), **COMPILED)
def contacts(own: Any, p: System, gap: Matrix, force: Matrix) -> None:
    """Write distance from the wall and normal force, (times, balls), for states (times, balls, BALL_STATES)."""
    for i in range(own.shape[0]):
        for b in range(own.shape[1]):
            ball = p.free_balls[b]
            x, z = own[i, b, BALL_X], own[i, b, BALL_Y]
            away = math.sqrt(x * x + z * z + TINY)
            nx, ny = x / away, z / away
            depth = away - orbit(p.waves, ball, ball.orbit, nx, ny)[0]
            if ball.waves > 0:
                depth, nx, ny = closest(p.waves, ball, ball.orbit, x, z, nx, ny)
            outward = own[i, b, BALL_VX] * nx + own[i, b, BALL_VY] * ny
            gap[i, b] = -depth
            hard, lightness = ball.wall_stiffness, 1.0 / (ball.mass + ball.extra)
            damping = damping_at(
                p.rebounds, ball.rebound, ball.wall_damping, depth, outward, hard, lightness, ball.hertz
            )
            force[i, b] = normal_force(depth, outward, hard, damping, ball.hertz)
