"""Laws of a contact: normal force, adherence. Depths in m, velocities in m/s, forces in N. Friction laws are leaves."""

from __future__ import annotations

import math
from typing import Any

from autobalancer.kernels.compiler.callbacks import call_friction
from autobalancer.kernels.compiler.flags import EXACT_PART, INLINE, njit
from autobalancer.kernels.compiler.numba_struct import data


@njit(**INLINE)
def normal_force(depth: float, rate: float, stiffness: float, damping: float, hertz: int) -> float:
    """Force of a contact ``depth`` deep, which grows at ``rate``; it never pulls.

    Linear (Spannan 2021, 5.3), or Hertz with the damping of Tsuji et al. (1992), whose restitution depends on no speed.
    """
    if depth <= 0.0:
        return 0.0
    if hertz == 0:
        return max(stiffness * depth + damping * rate, 0.0)
    root = math.sqrt(depth)
    return max(stiffness * depth * root + damping * math.sqrt(root) * rate, 0.0)


LEAST_SLIP = 1e-9  # m/s; what a law says of a guided ball that begins to roll


@njit(**INLINE)
def coefficient(p: Any, ball: Any, at: Any, known: float) -> float:
    """What the friction law of a ball says ``at`` its slip; that it is not a number is noted there, where ``known`` is one."""
    found = call_friction(ball.friction, at, p.friction_numbers, ball.first_number)
    if not math.isfinite(found) and math.isfinite(known):
        at.wrong, at.wrong_slip, at.wrong_pressed = 1, at.slip, at.pressed
    return found


@njit(**INLINE)
def resting(slip: float, speed: float, rest_speed: float) -> float:
    """1 for a ball at rest in its race, 0 for one that slips or moves at ``rest_speed``, smooth between half of it and it."""
    fast = max(abs(slip), abs(speed)) / rest_speed
    if fast <= 0.5:
        return 1.0
    if fast >= 1.0:
        return 0.0
    part = 2.0 * (1.0 - fast)
    return part * part * (3.0 - 2.0 * part)


@njit(**INLINE)
def adherence(
    hold: float, slip: float, speed: float, limit: float, stiffness: float, damping: float, rest_speed: float
) -> tuple[float, float]:
    """Force against the motion along the race, and the rate of the spring's deflection ``hold`` (Spannan 2021, 5.15).

    The three conditions of the source are smooth: slip and speed below ``rest_speed`` let the spring hold, at most with
    ``limit``, where it yields, and let go as it relaxes. The force takes from the ball what goes into the spring, or more.
    """
    share = resting(slip, speed, rest_speed)
    whole = stiffness * hold + damping * speed
    kept = 1.0
    if abs(whole) > limit:
        kept = limit / abs(whole)
    return share * kept * whole, share * kept * speed - (1.0 - share) * hold * stiffness / damping


# A number of a contact that depends on the speed at which an impact began, from the state of the contact alone.
#
# A state in contact is a point of a plane: the approach v, and q, the speed whose energy the spring holds (sqrt(k/m) d
# of a linear spring, sqrt(4 k/(5 m)) d^(5/4) of Hertz). Every impact runs through that plane on a path of its own,
# which tells at which speed it began; so no contact has to remember it. Tables give the number over the angle atan2(q,
# v), 0 at first touch, pi where the bodies part, and over the logarithm of the distance from the origin;
# assembly/contact/ fills them.


TURNS = 129  # angles from 0 to pi
PER_DECADE = 48  # distances in a decade
LOWEST, DECADES = -5, 7  # from 1e-5 m/s to 100 m/s
LEVELS = PER_DECADE * DECADES + 1
SIZE = TURNS * LEVELS  # numbers in a table, angle by angle
TINY = 1e-300
NONE = -1  # in place of a table: the number is constant

# A law of restitution by its numbers: SLOW what slow dry impacts leave; SLOWEST the speed below which a fluid leaves nothing;
# YIELD_SPEED above which restitution falls, as a power with this EXPONENT; then the POINTS of a measured one, (speed, factor).
SLOW, SLOWEST, YIELD_SPEED, EXPONENT, COUNT, POINTS = range(6)


@njit(**EXACT_PART)
def restitution_at(laws: Any, first: int, speed: float) -> float:
    """Share of the ``speed`` (m/s) that an impact leaves by the law that begins at ``first``; see laws/impacts.py."""
    law = data(laws[first:])
    factor, count, k = 1.0, int(law[COUNT]), POINTS
    if speed > law[YIELD_SPEED]:
        factor = (law[YIELD_SPEED] / speed) ** law[EXPONENT]
    if count > 0:
        last = POINTS + 2 * (count - 1)
        while k < last and law[k + 2] <= speed:
            k += 2
        factor = law[k + 1]
        if k < last and speed > law[k]:
            factor += (law[k + 3] - law[k + 1]) / (law[k + 2] - law[k]) * (speed - law[k])
    if law[SLOWEST] > 0.0:
        factor *= 1.0 - law[SLOWEST] / max(speed, law[SLOWEST])
    return float(law[SLOW] * factor)


@njit(**INLINE)
def table_value(numbers: Any, first: int, held: float, approach: float) -> float:
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
    return damping * table_value(data(numbers), first, held_speed(depth, stiffness, lightness, hertz), rate)
