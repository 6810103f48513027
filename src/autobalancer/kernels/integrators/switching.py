"""What the stepper asks of equations that switch: another right-hand side from an instant on that only the motion tells.

A switch is one compiled function (ask, time, rates, parameters, pair) -> number, where ``pair`` points to (tableau, memory):

TAKE      before the integration goes on from ``memory.state``: choose the equations that belong to it
FORGET    before it begins anew from there, whatever was known
DUE       after a step: not 0 if equations changed within it
CUT       the fraction of the step after which the first change comes, 0 if the step is too long to tell; prepare that change
PASS      at the end of the step that was cut there, which is in ``memory.state``: make the change
SHORTEST  the shortest step for the sake of a change, s
"""

from __future__ import annotations

from typing import Any

from numba import types

from autobalancer.kernels.flags import ADDRESSED, njit
from autobalancer.kernels.integrators.memory import memory_type
from autobalancer.kernels.integrators.tableau import tableau_type
from autobalancer.kernels.pointers import pointer_to
from autobalancer.kernels.system import rhs_type

TAKE, FORGET, DUE, CUT, PASS, SHORTEST = range(6)

pair_at = pointer_to(types.Tuple((tableau_type, memory_type)))
switch_type = types.FunctionType(types.float64(types.int64, types.float64, rhs_type, types.voidptr, types.voidptr))


@njit(**ADDRESSED)
def no_switch(ask: int, time: float, rates: Any, parameters: Any, pair: Any) -> float:
    """Of equations that never switch."""
    return 0.0
