"""What an integration remembers between two calls: it can stop after any step and go on."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import types

from autobalancer.kernels.system import Floats, Integers, integers_type, matrix_type, vector_type

# places in Memory.clock
TIME, STEP, END, LONGEST, ERROR = range(5)
# places in Memory.counts
ACCEPTED, REJECTED, EVALUATIONS, NEXT_SAMPLE, NEXT_BIN, NEXT_TURN, EVENTS_SEEN, FRESH = range(8)
COUNTS = 8


class Memory(NamedTuple):
    """State, step size, counters and work arrays of one integration of n equations."""

    clock: Floats  # (5,) time, next step, end, longest step, last error
    counts: Integers  # (8,)
    state: Floats  # (n,)
    start: Floats  # (n,) state at the begin of the last step
    trial: Floats  # (n,) work
    stages: Floats  # (total, n) work
    dense: Floats  # (degree, n) dense output of the last step
    absolute: Floats  # (n,) tolerance
    relative: Floats  # (n,) tolerance


memory_type = types.NamedTuple(
    [
        vector_type, integers_type, vector_type, vector_type, vector_type,
        matrix_type, matrix_type, vector_type, vector_type,
    ],
    Memory,
)  # fmt: skip


def memory(
    state: Floats, end: float, absolute: Floats, relative: Floats, *, total: int, degree: int, longest: float
) -> Memory:
    """A fresh memory that starts at time 0 from ``state``; the first step is chosen by the stepper."""
    n = state.size
    return Memory(
        np.array([0.0, 0.0, end, longest, 1.0]),
        np.zeros(8, np.int64),
        np.array(state, np.float64),
        np.array(state, np.float64),
        np.zeros(n),
        np.zeros((total, n)),
        np.zeros((degree, n)),
        np.array(absolute, np.float64),
        np.array(relative, np.float64),
    )
