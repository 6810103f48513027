"""How far the fluid around a ball lagged behind its race at the saved states of a run."""

from __future__ import annotations

import numpy as np

from autobalancer.assembly.system import Assembly
from autobalancer.kernels import race_layout, resolved_layout
from autobalancer.kernels.race_layout import TABLE_COUNT, TABLE_START, TABLE_STEP, TABLE_VALUES
from autobalancer.kernels.rotor_layout import BALL_ROWS
from autobalancer.kernels.system import Floats, Matrix


def saved_lag(assembly: Assembly, number: int, states: Matrix, times: Floats) -> Floats:
    """The lag w - W_f, rad/s, at each of ``states`` (times, n) for the ball of this number; 0 where no fluid lags."""
    rotor, lag = assembly.system.rotor, np.zeros(times.size)
    if not (assembly.general or assembly.resolved) or rotor[BALL_ROWS] == 0.0:
        return lag
    layout = resolved_layout if assembly.resolved else race_layout
    columns = resolved_layout.RESOLVED_COLUMNS if assembly.resolved else race_layout.RACE_COLUMNS
    row = rotor[int(rotor[BALL_ROWS]) + number * columns :][:columns]
    first, table = int(row[layout.FIRST_MODE]), int(row[layout.LAG_TABLE])
    lag += states[:, first : first + int(row[layout.MODES])].sum(axis=1)
    if table != 0:
        count = int(rotor[table + TABLE_COUNT])
        known = rotor[table + TABLE_START] + rotor[table + TABLE_STEP] * np.arange(count)
        lag += np.interp(times, known, rotor[table + TABLE_VALUES :][: 2 * count : 2])
    return lag
