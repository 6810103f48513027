"""The floor of an annulus on a vertical axis, under a resolved ball that its wall does not carry whole.

Symbols, in the axes of the rotor: u = (vx, vz) the velocity of the ball, t = (tumble_x, tumble_y) the horizontal part of its spin
in space, n the normal of the wall, e the vertical. The point of the ball on the floor slips by u - r t x e, the one on the wall
by r (t x n) upwards. With no horizontal spin in the rotor itself, t' = tau/J - w e x t. The ball keeps its height: what carries
it is balanced at any time, and the vertical part of friction on the wall does no work on it, but it brakes the spin.
"""

from __future__ import annotations

import math
from typing import Any

from autobalancer.kernels.flags import INLINE, njit

TINY = 1e-30  # (m/s)^2, keeps the direction of a ball at rest a number


@njit(**INLINE)
def carried_by_floor(ball: Any, pressed: float) -> float:
    """Force of the floor on a ball that its walls press with this force, N: they carry as much as their friction can."""
    if ball.floor <= 0.0 or ball.weight <= 0.0:
        return 0.0
    return max(ball.weight - ball.sliding * pressed, 0.0)


@njit(**INLINE)
def climbing(ball: Any, nx: float, ny: float, tumble_x: float, tumble_y: float) -> float:
    """Upward slip of the ball on its outer wall, m/s."""
    return ball.floor_arm * (tumble_x * ny - tumble_y * nx)


@njit(**INLINE)
def on_floor(ball: Any, pressed: float, vx: float, vz: float, tumble_x: float, tumble_y: float) -> tuple:  # type: ignore[type-arg]
    """Force of the floor on a ball, and its torque on the horizontal part of the spin: four numbers."""
    left, arm = carried_by_floor(ball, pressed), ball.floor_arm
    if left == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    slip_x, slip_y = vx - arm * tumble_y, vz + arm * tumble_x
    fast = math.sqrt(slip_x * slip_x + slip_y * slip_y + TINY)
    drawn = -left * ball.floor * math.tanh(fast / ball.slip_speed) / fast
    force_x, force_y = drawn * slip_x, drawn * slip_y
    turning = math.sqrt(tumble_x * tumble_x + tumble_y * tumble_y + TINY)
    braked = ball.rolling_arm * left * math.tanh(ball.radius * turning / ball.rest_speed) / turning
    return force_x, force_y, arm * force_y - braked * tumble_x, -arm * force_x - braked * tumble_y
