"""Torques of forces that are leaves on guided balls, at many places; for questions of stability."""

from __future__ import annotations

from numba import float64, void

from autobalancer.kernels.balls.forces import push_guided
from autobalancer.kernels.flags import COMPILED, njit
from autobalancer.kernels.pointers import data
from autobalancer.kernels.system import Matrix, System, matrix_type, system_type


@njit(void(system_type, matrix_type, float64, matrix_type), **COMPILED)
def force_torques(p: System, states: Matrix, speed: float, out: Matrix) -> None:
    """Write torques (N m), then wall forces (N), of each ball into ``out`` (k, 2 n) at states (k, 6 + 2 n) of the balls."""
    for k in range(states.shape[0]):
        for b in range(p.ball_count):
            p.guided[b].contact, p.guided[b].outward = 0.0, 0.0
        push_guided(data(states[k]), p, speed)
        for b in range(p.ball_count):
            out[k, b], out[k, p.ball_count + b] = p.guided[b].contact, p.guided[b].outward
