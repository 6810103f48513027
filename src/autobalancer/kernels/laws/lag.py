"""How far the fluid around a ball lags behind its race."""

from __future__ import annotations

from typing import Any

from autobalancer.kernels.flags import INLINE, njit
from autobalancer.kernels.laws.curves import table_value
from autobalancer.kernels.records.fluid import NONE
from autobalancer.kernels.system import Fluid


@njit(**INLINE)
def fluid_lag(time: float, y: Any, fluid: Fluid, ball: Any) -> float:
    """Speed of the rotor less that of the fluid at the ball, rad/s: the sum of relaxation modes, or a table over time."""
    lag = 0.0
    for i in range(ball.first_mode, ball.first_mode + ball.modes):
        lag += y[fluid.modes[i].state]
    if ball.lag_table != NONE:
        lag += table_value(fluid, ball.lag_table, time)
    return lag


@njit(**INLINE)
def relax(y: Any, dy: Any, fluid: Fluid, acceleration: float) -> None:
    """The derivatives of all relaxation modes."""
    for i in range(fluid.modes.shape[0]):
        mode = fluid.modes[i]
        dy[mode.state] = mode.gain * acceleration - mode.rate * y[mode.state]
