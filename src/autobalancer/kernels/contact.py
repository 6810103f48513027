"""Balls of one race that touch, and partitions of a race: springs and dampers that never pull, and friction.

Rolling balls rub where they touch. Friction takes from each ball what its part of the slip gives it, laws/touching_balls.py.
A ball at a partition hardly rolls, so nothing rubs there.
"""

from __future__ import annotations

import math

from numba import njit

from autobalancer.kernels.flags import INLINE
from autobalancer.kernels.system import (
    ARM,
    ARM_NEXT,
    BALLS,
    CONTACT,
    GRIP,
    HARD,
    NEXT,
    ORBIT,
    OUT,
    OUT_NEXT,
    OUTWARD,
    RUB,
    SOFT,
    TOUCH,
    WALL_HARD,
    WALL_HIGH,
    WALL_LOW,
    WALL_SOFT,
    WRAP,
)


@njit(**INLINE)
def touch(y, balls, count: int) -> None:  # type: ignore[no-untyped-def]
    """Put the torque of contact on each ball into its column ``CONTACT``, and its force on the wall into ``OUTWARD``.

    Balls are numbered in their order around the race, which contact preserves.
    """
    for i in range(count):
        balls[i, CONTACT] = 0.0
        balls[i, OUTWARD] = 0.0
    for i in range(count):
        angle, rate, hard, wall = y[BALLS + i], y[BALLS + count + i], balls[i, HARD], balls[i, WALL_HARD]
        if hard > 0.0:
            other = int(balls[i, NEXT])
            deep = balls[i, TOUCH] - (y[BALLS + other] - angle + balls[i, WRAP])
            if deep > 0.0:
                its = y[BALLS + count + other]
                pressed = hard * deep - balls[i, SOFT] * (its - rate)
                if pressed > 0.0:
                    balls[i, CONTACT] -= pressed
                    balls[other, CONTACT] += pressed
                    balls[i, OUTWARD] += pressed * balls[i, OUT]
                    balls[other, OUTWARD] += pressed * balls[i, OUT_NEXT]
                    if balls[i, RUB] > 0.0:
                        arm, its_arm = balls[i, ARM], balls[i, ARM_NEXT]
                        rub = pressed * balls[i, RUB] * math.tanh((arm * rate + its_arm * its) * balls[i, GRIP])
                        balls[i, CONTACT] -= arm * rub
                        balls[other, CONTACT] -= its_arm * rub
                        balls[i, OUTWARD] -= rub / balls[i, ORBIT]
                        balls[other, OUTWARD] += rub / balls[other, ORBIT]
        if wall > 0.0:
            if angle < balls[i, WALL_LOW]:
                balls[i, CONTACT] += max(wall * (balls[i, WALL_LOW] - angle) - balls[i, WALL_SOFT] * rate, 0.0)
            elif angle > balls[i, WALL_HIGH]:
                balls[i, CONTACT] -= max(wall * (angle - balls[i, WALL_HIGH]) + balls[i, WALL_SOFT] * rate, 0.0)
