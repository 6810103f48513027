"""Contacts of resolved balls with their outer wall at states that were saved."""

from __future__ import annotations

import math

from numba import njit, types, void

from autobalancer.kernels.contact_laws import normal_force
from autobalancer.kernels.flags import COMPILED
from autobalancer.kernels.pointers import data
from autobalancer.kernels.race_shape import closest, orbit
from autobalancer.kernels.resolved_layout import (
    BALL_VX,
    BALL_VY,
    BALL_X,
    BALL_Y,
    HERTZ,
    ORBIT_,
    RESOLVED_COLUMNS,
    SHAPE,
    WALL_DAMPING,
    WALL_STIFFNESS,
)
from autobalancer.kernels.rotor_layout import BALL_ROWS
from autobalancer.kernels.system import Floats, Matrix, matrix_type, vector_type

TINY = 1e-30  # m^2, as in resolved_balls.py


@njit(void(types.Array(types.float64, 3, "C"), vector_type, matrix_type, matrix_type), **COMPILED)
def contacts(own: Floats, rotor: Floats, gap: Matrix, force: Matrix) -> None:
    """Write distance from the wall and normal force, (times, balls), for states (times, balls, BALL_STATES)."""
    r = data(rotor)
    for i in range(own.shape[0]):
        for b in range(own.shape[1]):
            at = int(r[BALL_ROWS]) + b * RESOLVED_COLUMNS
            shape, level = int(r[at + SHAPE]), r[at + ORBIT_]
            x, z = own[i, b, BALL_X], own[i, b, BALL_Y]
            away = math.sqrt(x * x + z * z + TINY)
            nx, ny = x / away, z / away
            depth = away - orbit(r, shape, level, nx, ny)[0]
            if shape > 0:
                depth, nx, ny = closest(r, shape, level, x, z, nx, ny)
            outward = own[i, b, BALL_VX] * nx + own[i, b, BALL_VY] * ny
            gap[i, b] = -depth
            force[i, b] = normal_force(depth, outward, r[at + WALL_STIFFNESS], r[at + WALL_DAMPING], r[at + HERTZ])
