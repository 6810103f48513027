"""Rubber between a linear rotor and what carries it: elements that slide or relax, each with a force of two components.

    f' = k z' - g f,    g = k <f . z'> / F^2  elastoplastic,    k |z'| / F  endochronic,    1/tau  Maxwell

with the stretch z = B q of its piece of rubber in the plane, so that x and y are coupled and no direction is preferred. The force
never leaves |f| <= F, stores |f|^2 / (2 k) and loses g |f|^2 / k. In axes that turn with the rotor f' has -i w f more.
"""

from __future__ import annotations

import math
from typing import Any

from autobalancer.kernels.flags import INLINE, njit
from autobalancer.kernels.host.linear import Motion, dot
from autobalancer.kernels.pointers import data, row
from autobalancer.kernels.records.rubber import ELASTOPLASTIC, ENDOCHRONIC
from autobalancer.kernels.system import System


@njit(**INLINE)
def stretched(y: Any, dy: Any, p: System, motion: Motion) -> Motion:
    """Add the accelerations by all rubber to f, and write the rates of its elements; returns the motion as it is."""
    size, width, f, v = p.host.size, p.host.width, data(p.work.f), data(p.work.v)
    rows, reach = data(p.rubber.rows), data(p.rubber.reach)
    turning = motion.speed if p.rotating == 1 else 0.0
    for m in range(p.rubber.mounts.shape[0]):
        mount, at = row(p.rubber.mounts, m), 2 * m * width
        vx, vy = dot(rows, at, v, 0, size), dot(rows, at + width, v, 0, size)
        pace, push_x, push_y = math.sqrt(vx * vx + vy * vy), 0.0, 0.0
        for e in range(mount.first, mount.first + mount.elements):
            one = row(p.rubber.elements, e)
            fx, fy = y[one.state], y[one.state + 1]
            give = one.give
            if one.law == ELASTOPLASTIC:
                give *= max(fx * vx + fy * vy, 0.0)
            elif one.law == ENDOCHRONIC:
                give *= pace
            dy[one.state] = one.stiffness * vx - give * fx + turning * fy
            dy[one.state + 1] = one.stiffness * vy - give * fy - turning * fx
            push_x += fx
            push_y += fy
        for i in range(size):
            f[i] -= reach[at + i] * push_x + reach[at + width + i] * push_y
    return motion
