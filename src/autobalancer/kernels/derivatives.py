"""Time derivatives of states that were saved."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import void

from autobalancer.kernels.balls.rigid.stay import recognize
from autobalancer.kernels.flags import COMPILED, njit
from autobalancer.kernels.host.drive import enter_segment
from autobalancer.kernels.pointers import address, data, plain
from autobalancer.kernels.system import (
    Floats,
    Matrix,
    System,
    matrix_type,
    rhs_type,
    system_type,
    vector_type,
)


@njit(void(rhs_type, system_type, vector_type, matrix_type, matrix_type), **COMPILED)
def derivatives(
    rhs: Callable[[float, Any, Any, Any], None], p: System, times: Floats, states: Matrix, out: Matrix
) -> None:
    """Write the time derivative of each state into ``out`` (times, n)."""
    parameters = plain(address(p))
    p.drive.now[0] = 0
    for i in range(times.size):
        enter_segment(times[i], p.drive)
        if p.ties.shape[0] > 0:
            recognize(times[i], data(states[i]), rhs, parameters)
        rhs(times[i], data(states[i]), data(out[i]), parameters)
