"""What walls and floor do to resolved balls at states that were saved."""

from __future__ import annotations

import math
from typing import Any

from numba import types, void

from autobalancer.kernels.balls.floor import carried_by_floor
from autobalancer.kernels.balls.path import closest, orbit
from autobalancer.kernels.balls.walls import TINY, touch
from autobalancer.kernels.flags import COMPILED, njit
from autobalancer.kernels.records.resolved import BALL_VX, BALL_VY, BALL_X, BALL_Y
from autobalancer.kernels.system import Matrix, System, matrix_type, system_type


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
