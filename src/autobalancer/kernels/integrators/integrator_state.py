"""What an integration remembers between two calls: it can stop after any step and go on."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import types

from autobalancer.kernels.compiler.flags import ADDRESSED, njit
from autobalancer.kernels.compiler.numba_struct import passed_by_address, pointer_to, struct_type, value_type
from autobalancer.kernels.compiler.simd import LANES
from autobalancer.kernels.integrators.tableau import tableau_type
from autobalancer.kernels.system import Floats, Integers, Matrix, rhs_type, tuple_type

# places in Memory.clock
TIME, STEP, END, LONGEST, ERROR, TAKEN = range(6)
CLOCK = 6
# places in Memory.counts
ACCEPTED, REJECTED, EVALUATIONS, NEXT_SAMPLE, NEXT_BIN, NEXT_TURN, EVENTS_SEEN, FRESH = range(8)
COUNTS = 8


@passed_by_address
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


memory_type = struct_type(tuple_type(Memory))


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


# What the stepper asks of equations that switch: another right-hand side from an instant on that only the motion
# tells.
#
# A switch is one compiled function (ask, time, rates, parameters, pair) -> number, where ``pair`` points to (tableau,
# memory):
#
# TAKE before the integration goes on from ``memory.state``: choose the equations that belong to it FORGET before it
# begins anew from there, whatever was known DUE after a step: not 0 if equations changed within it CUT the fraction of
# the step after which the first change comes, 0 if the step is too long to tell; prepare that change PASS at the end
# of the step that was cut there, which is in ``memory.state``: make the change SHORTEST the shortest step for the sake
# of a change, s


TAKE, FORGET, DUE, CUT, PASS, SHORTEST = range(6)

pair_at = pointer_to(types.Tuple((value_type(tableau_type), value_type(memory_type))))
switch_type = types.FunctionType(types.float64(types.int64, types.float64, rhs_type, types.voidptr, types.voidptr))


@njit(**ADDRESSED)
def no_switch(ask: int, time: float, rates: Any, parameters: Any, pair: Any) -> float:
    """Of equations that never switch."""
    return 0.0
