"""Normal forces of real races at states that were saved."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import void

from autobalancer.kernels.balls.rigid.stay import recognize
from autobalancer.kernels.flags import COMPILED, njit
from autobalancer.kernels.host.drive import enter_segment
from autobalancer.kernels.pointers import address, data, plain
from autobalancer.kernels.system import (
    BALLS,
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
    parameters, count = plain(address(p)), p.ball_count
    p.drive.now[0] = 0
    for i in range(times.size):
        enter_segment(times[i], p.drive)
        for b in range(count):
            rate = states[i, BALLS + count + b]
            if p.balls[b].rolling > 0.0 or p.balls[b].adherence > 0.0:
                p.guided[b].mode = 1.0 if rate > 0.0 else -1.0 if rate < 0.0 else 0.0
        if p.ties.shape[0] > 0:
            recognize(times[i], data(states[i]), rhs, parameters)
        rhs(times[i], data(states[i]), data(work), parameters)
        for b in range(count):
            out[i, b] = p.guided[b].normal
