"""How far the fluid around a ball lagged behind its race at the saved states of a run."""

from __future__ import annotations

import numpy as np

from autobalancer.assembly.system import Assembly
from autobalancer.kernels.records.fluid import NONE
from autobalancer.kernels.system import Floats, Matrix


def saved_lag(assembly: Assembly, number: int, states: Matrix, times: Floats) -> Floats:
    """The lag w - W_f, rad/s, at each of ``states`` (times, n) for the ball of this number; 0 where no fluid lags."""
    system, lag = assembly.system, np.zeros(times.size)
    ball, fluid = (system.free_balls if assembly.resolved else system.balls)[number], system.fluid
    lag += states[:, fluid.modes.state[ball.first_mode : ball.first_mode + ball.modes]].sum(axis=1)
    if ball.lag_table != NONE:
        table = fluid.tables[ball.lag_table]
        known = table.start + table.step * np.arange(table.count)
        lag += np.interp(times, known, fluid.points.value[table.first : table.first + table.count])
    return lag
