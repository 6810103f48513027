"""Energy of the forces on balls at states that were saved."""

from __future__ import annotations

from numba import void

from autobalancer.kernels.balls.forces import energy_of, put_guided, put_resolved
from autobalancer.kernels.flags import COMPILED, njit
from autobalancer.kernels.pointers import data
from autobalancer.kernels.system import SPEED, Floats, Matrix, System, matrix_type, system_type, vector_type


@njit(void(system_type, matrix_type, vector_type), **COMPILED)
def force_energies(p: System, states: Matrix, out: Floats) -> None:
    """Write the energy of all forces that have one into ``out`` (times,), J."""
    for i in range(states.shape[0]):
        y = data(states[i])
        if p.free_balls.shape[0] > 0:
            put_resolved(y, p, states[i, SPEED])
        else:
            put_guided(y, p, states[i, SPEED])
        out[i] = energy_of(y, p)
