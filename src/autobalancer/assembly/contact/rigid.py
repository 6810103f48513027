"""Room for rigid contacts of guided balls."""

from __future__ import annotations

from typing import Any

import numpy as np

from autobalancer.catalog.resolve import Ball
from autobalancer.kernels.records.guided import TIE
from autobalancer.kernels.system import Rigid, Rows

PULL = 1e-13  # torque that counts as a pull, over inertia and frequency squared


def pull_of(balls: tuple[Ball, ...], frequency: float) -> float:
    """Torque that counts as a pull, N m."""
    return PULL * max(ball.inertia for ball in balls) * frequency**2


def rigid_room(balls: tuple[Ball, ...], contacts: Rows, size: int, frequency: float) -> dict[str, Any]:
    """The fields of a system with rigid contacts, nothing without; its states have ``size`` components.

    ``frequency`` is that of what the balls do: the top speed, or the lowest critical one if that is higher, rad/s.
    """
    count = int((contacts.rigid == 1).sum() + 2 * (contacts.wall_rigid > 0).sum())
    if not (contacts.rigid.any() or contacts.wall_rigid.any()):
        return {}
    ties = TIE.rows(len(balls))
    full = np.flatnonzero(contacts.rigid == 2)
    ties.joined[full] = 1
    for race in {(balls[i].balancer, balls[i].race) for i in full}:  # a ring is a row whose last contact closes it
        members = [i for i in full if (balls[i].balancer, balls[i].race) == race]
        ties.joined[members[-1]] = 2
    pull = pull_of(balls, frequency)
    room = Rigid(
        bound=np.zeros(2, np.int64),
        margin=np.array([1e300, 1e300, pull, pull, -1.0]),
        kinds=np.zeros(count, np.int64),
        balls=np.zeros(count, np.int64),
        chosen=np.zeros(count, np.int64),
        active=np.zeros(count, np.int64),
        before=np.zeros(count),
        need=np.zeros(count),
        impulse=np.zeros(count),
        delassus=np.zeros((count, count)),
        left=np.zeros((count, count + 1)),
        response=np.zeros((count, size)),
        base=np.zeros(size),
        middle=np.zeros(size),
        missed=np.zeros(size),
    )
    return {"ties": ties, "rigid": room}
