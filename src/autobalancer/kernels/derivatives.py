"""Time derivatives and normal forces at states that were saved."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import void

from autobalancer.kernels.balls.rigid_impacts import recognize
from autobalancer.kernels.compiler.flags import COMPILED, njit
from autobalancer.kernels.compiler.numba_struct import address, as_void, data
from autobalancer.kernels.host.shaft_train import enter_segment
from autobalancer.kernels.system import BALLS, Floats, Matrix, System, matrix_type, rhs_type, system_type, vector_type


@njit(void(rhs_type, system_type, vector_type, matrix_type, matrix_type), **COMPILED)
def derivatives(
    rhs: Callable[[float, Any, Any, Any], None], p: System, times: Floats, states: Matrix, out: Matrix
) -> None:
    """Write the time derivative of each state into ``out`` (times, n)."""
    parameters = as_void(address(p))
    p.drive.now[0] = 0
    for i in range(times.size):
        enter_segment(times[i], p.drive)
        if p.ties.shape[0] > 0:
            recognize(times[i], data(states[i]), rhs, parameters)
        rhs(times[i], data(states[i]), data(out[i]), parameters)


# Normal forces of real races at states that were saved.


@njit(void(rhs_type, system_type, vector_type, matrix_type, vector_type, matrix_type), **COMPILED)
def normal_forces(
    rhs: Callable[[float, Any, Any, Any], None], p: System, times: Floats, states: Matrix, work: Floats, out: Matrix
) -> None:
    """Write the normal force on each ball into ``out`` (times, balls).

    A ball that can rest does so where its speed is exactly zero. ``work`` is as long as a state.
    """
    parameters, count = as_void(address(p)), p.ball_count
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
