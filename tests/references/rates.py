"""The compiled equations at one instant, called as in a run: by pointers.

Called with arrays they would be compiled a second time, which takes as long as many tests.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import float64, void

from autobalancer.kernels.compiler.flags import COMPILED, njit
from autobalancer.kernels.compiler.numba_struct import address, as_void, data
from autobalancer.kernels.system import System, rhs_type, system_type, vector_type


@njit(void(rhs_type, float64, vector_type, vector_type, system_type), **COMPILED)
def _call(rhs: Callable[..., None], time: float, state: Any, out: Any, system: System) -> None:
    rhs(time, data(state), data(out), as_void(address(system)))


def rates_at(equations: Any, time: float, state: np.ndarray, system: System) -> np.ndarray:
    """Derivative of the state, in the axes of the system."""
    out = np.zeros(state.size)
    _call(equations, time, np.ascontiguousarray(state, dtype=float), out, system)
    return out
