"""Normal forces of real races at states that were saved."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit, void

from autobalancer.kernels.flags import COMPILED
from autobalancer.kernels.pointers import address, data
from autobalancer.kernels.race_layout import ADHERENCE, MODE, NORMAL, RACE_COLUMNS, ROLLING
from autobalancer.kernels.rotor_layout import BALL_ROWS
from autobalancer.kernels.system import (
    BALLS,
    START,
    Floats,
    Matrix,
    System,
    matrix_type,
    rhs_type,
    system_type,
    vector_type,
)


@njit(void(rhs_type, system_type, vector_type, matrix_type, vector_type, matrix_type), **COMPILED)
def normal_forces(
    rhs: Callable[[float, Any, Any, Any], None], p: System, times: Floats, states: Matrix, work: Floats, out: Matrix
) -> None:
    """Write the normal force on each ball into ``out`` (times, balls).

    A ball that can rest does so where its speed is exactly zero. ``work`` is as long as a state.
    """
    parameters, r = address(p), data(p.rotor)
    first, count, segments = int(r[BALL_ROWS]), p.balls.shape[0], p.segments.shape[0]
    p.now[0] = 0
    for i in range(times.size):
        while p.now[0] + 1 < segments and p.segments[p.now[0] + 1, START] <= times[i]:
            p.now[0] += 1
        for b in range(count):
            at, rate = first + b * RACE_COLUMNS, states[i, BALLS + count + b]
            if r[at + ROLLING] > 0.0 or r[at + ADHERENCE] > 0.0:
                r[at + MODE] = 1.0 if rate > 0.0 else -1.0 if rate < 0.0 else 0.0
        rhs(times[i], data(states[i]), data(work), parameters)
        for b in range(count):
            out[i, b] = r[first + b * RACE_COLUMNS + NORMAL]
