"""Balls of one race that touch, and partitions of a race: springs and dampers that never pull."""

from __future__ import annotations

from numba import njit

from autobalancer.kernels.flags import INLINE
from autobalancer.kernels.system import BALLS, CONTACT, HARD, NEXT, SOFT, TOUCH, WALL_HIGH, WALL_LOW, WRAP


@njit(**INLINE)
def touch(y, balls, count: int) -> None:  # type: ignore[no-untyped-def]
    """Put the torque of contact on each ball into its column ``CONTACT``.

    Balls are numbered in their order around the race, which contact preserves.
    """
    for i in range(count):
        balls[i, CONTACT] = 0.0
    for i in range(count):
        angle, rate, hard, soft = y[BALLS + i], y[BALLS + count + i], balls[i, HARD], balls[i, SOFT]
        if hard == 0.0:
            continue
        other = int(balls[i, NEXT])
        if other >= 0:
            deep = balls[i, TOUCH] - (y[BALLS + other] - angle + balls[i, WRAP])
            if deep > 0.0:
                pressed = hard * deep - soft * (y[BALLS + count + other] - rate)
                if pressed > 0.0:
                    balls[i, CONTACT] -= pressed
                    balls[other, CONTACT] += pressed
        if angle < balls[i, WALL_LOW]:
            balls[i, CONTACT] += max(2.0 * (hard * (balls[i, WALL_LOW] - angle) - soft * rate), 0.0)
        elif angle > balls[i, WALL_HIGH]:
            balls[i, CONTACT] -= max(2.0 * (hard * (angle - balls[i, WALL_HIGH]) + soft * rate), 0.0)
