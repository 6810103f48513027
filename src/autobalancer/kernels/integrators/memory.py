"""What an integration remembers between two calls: it can stop after any step and go on."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import types

from autobalancer.kernels.lanes import LANES
from autobalancer.kernels.system import Floats, Integers, Matrix, integers_type, matrix_type, vector_type

# places in Memory.clock
TIME, STEP, END, LONGEST, ERROR, TAKEN = range(6)
CLOCK = 6
# places in Memory.counts
ACCEPTED, REJECTED, EVALUATIONS, NEXT_SAMPLE, NEXT_BIN, NEXT_TURN, EVENTS_SEEN, FRESH = range(8)
COUNTS = 8


class Memory(NamedTuple):
    """State, step size, counters and work arrays of one integration of n equations; w is n rounded up to whole lanes."""

    clock: Floats  # (CLOCK,) time, next step, end, longest step, last error, length of the last step
    counts: Integers  # (COUNTS,)
    state: Floats  # (n,)
    start: Floats  # (w,) state at the begin of the last step
    trial: Floats  # (w,) work
    stages: Matrix  # (total, w) work
    dense: Matrix  # (degree, w) dense output of the last step, of as many components as were wanted
    shares: Floats  # (total,) work
    absolute: Floats  # (w,) tolerance
    relative: Floats  # (w,) tolerance
    spare: Floats  # (w,) work


memory_type = types.NamedTuple(
    [
        vector_type, integers_type, vector_type, vector_type, vector_type,
        matrix_type, matrix_type, vector_type, vector_type, vector_type, vector_type,
    ],
    Memory,
)  # fmt: skip


def memory(
    state: Floats, end: float, absolute: Floats, relative: Floats, *, total: int, degree: int, longest: float
) -> Memory:
    """A fresh memory that starts at time 0 from ``state``; the first step is chosen by the stepper."""
    n = state.size
    extra = -n % LANES
    width = n + extra
    return Memory(
        np.array([0.0, 0.0, end, longest, 1.0, 0.0]),
        np.zeros(COUNTS, np.int64),
        np.array(state, np.float64),
        np.pad(np.asarray(state, np.float64), (0, extra)),
        np.zeros(width),
        np.zeros((total, width)),
        np.zeros((degree, width)),
        np.zeros(total),
        np.pad(np.asarray(absolute, np.float64), (0, extra), constant_values=1.0),
        np.pad(np.asarray(relative, np.float64), (0, extra)),
        np.zeros(width),
    )
