"""Balls of one race that touch, and partitions of a race: springs and dampers that never pull, and friction.

Rigid contacts are in the room ``rigid``.

Rolling balls rub where they touch. Friction takes from each ball what its part of the slip gives it, laws/impacts.py.
A ball at a partition hardly rolls, so nothing rubs there.
"""

from __future__ import annotations

import math
from typing import Any

from autobalancer.kernels.flags import INLINE, njit
from autobalancer.kernels.laws.rebound import looked_up
from autobalancer.kernels.pointers import data
from autobalancer.kernels.system import BALLS, System


@njit(**INLINE)
def touch(y: Any, p: System) -> None:
    """Find for each guided ball the torque of what it touches, and what this presses it on the wall.

    Balls are numbered in their order around the race, which contact preserves.
    """
    count, moving = p.ball_count, p.guided
    for i in range(count):
        moving[i].contact = moving[i].given
        moving[i].outward = moving[i].given_out
    for i in range(count):
        angle, rate, pair = y[BALLS + i], y[BALLS + count + i], p.contacts[i]
        if pair.hard > 0.0:
            other = pair.next
            deep = pair.touch - (y[BALLS + other] - angle + pair.wrap)
            if deep > 0.0:
                its = y[BALLS + count + other]
                soft = pair.soft
                if pair.rebound >= 0:
                    near = pair.pace * (rate - its)
                    soft *= looked_up(data(p.rebounds), pair.rebound, pair.pace * pair.quick * deep, near)
                pressed = pair.hard * deep - soft * (its - rate)
                if pressed > 0.0:
                    moving[i].contact -= pressed
                    moving[other].contact += pressed
                    moving[i].outward += pressed * pair.out
                    moving[other].outward += pressed * pair.out_next
                    if pair.rub > 0.0:
                        rub = pressed * pair.rub * math.tanh((pair.arm * rate + pair.arm_next * its) * pair.grip)
                        moving[i].contact -= pair.arm * rub
                        moving[other].contact -= pair.arm_next * rub
                        moving[i].outward -= rub / p.balls[i].orbit
                        moving[other].outward += rub / p.balls[other].orbit
        if pair.wall_hard > 0.0:
            way, deep = 1.0, pair.wall_low - angle
            if angle > pair.wall_high:
                way, deep = -1.0, angle - pair.wall_high
            if deep > 0.0:
                soft = pair.wall_soft
                if pair.wall_rebound >= 0:
                    held, near = pair.wall_pace * pair.wall_quick * deep, -pair.wall_pace * way * rate
                    soft *= looked_up(data(p.rebounds), pair.wall_rebound, held, near)
                moving[i].contact += way * max(pair.wall_hard * deep - way * soft * rate, 0.0)
