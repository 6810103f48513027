"""A number of a contact that depends on the speed at which an impact began, from the state of the contact alone.

A state in contact is a point of a plane: the approach v, and q, the speed whose energy the spring holds (sqrt(k/m) d of a
linear spring, sqrt(4 k/(5 m)) d^(5/4) of Hertz). Every impact runs through that plane on a path of its own, which tells at
which speed it began; so no contact has to remember it. Tables give the number over the angle atan2(q, v), 0 at first touch,
pi where the bodies part, and over the logarithm of the distance from the origin; assembly/contact/ fills them.
"""

from __future__ import annotations

import math
from typing import Any

from autobalancer.kernels.flags import INLINE, njit
from autobalancer.kernels.pointers import data

TURNS = 129  # angles from 0 to pi
PER_DECADE = 48  # distances in a decade
LOWEST, DECADES = -5, 7  # from 1e-5 m/s to 100 m/s
LEVELS = PER_DECADE * DECADES + 1
SIZE = TURNS * LEVELS  # numbers in a table, angle by angle
TINY = 1e-300
NONE = -1  # in place of a table: the number is constant


@njit(**INLINE)
def looked_up(numbers: Any, first: int, held: float, approach: float) -> float:
    """The number of the table that begins at ``first``, where the spring holds the speed ``held`` and the bodies approach."""
    level = (0.5 * math.log10(held * held + approach * approach + TINY) - LOWEST) * PER_DECADE
    level = min(max(level, 0.0), LEVELS - 1.000001)
    turn = min(max(math.atan2(held, approach), 0.0) * ((TURNS - 1) / math.pi), TURNS - 1.000001)
    i, j = int(turn), int(level)
    a, b, at = turn - i, level - j, first + i * LEVELS + j
    low = numbers[at] + b * (numbers[at + 1] - numbers[at])
    high = numbers[at + LEVELS] + b * (numbers[at + LEVELS + 1] - numbers[at + LEVELS])
    return low + a * (high - low)


@njit(**INLINE)
def held_speed(depth: float, stiffness: float, lightness: float, hertz: int) -> float:
    """The speed at which the bodies would part with the energy of the spring, m/s; ``lightness`` is 1/m of the reduced mass."""
    if hertz == 0:
        return math.sqrt(stiffness * lightness) * depth
    return math.sqrt(0.8 * stiffness * lightness * depth * math.sqrt(depth) * depth)


@njit(**INLINE)
def damping_at(
    numbers: Any, first: int, damping: float, depth: float, rate: float, stiffness: float, lightness: float, hertz: int
) -> float:
    """Damping of a contact ``depth`` deep, which grows at ``rate``; where it has a table, ``damping`` is that of ratio 1."""
    if first == NONE or depth <= 0.0:
        return damping
    return damping * looked_up(data(numbers), first, held_speed(depth, stiffness, lightness, hertz), rate)
