"""What adherence holds on a race: the whirl below which no ball moves, and the residual unbalance that may stay.

A ball at the angle phi of a race whose center runs a distance c beside the axis of rotation (both seen from the rotor, at
constant speed w) is pushed along the race with m w^2 |Im(c e^-i phi)| and pressed on it with m w^2 (eps + Re(c e^-i phi)). It
stays at rest while the first is below adherence times the second (Spannan 2021, section 4.2.3; conditions derived here).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np
import numpy.typing as npt

from autobalancer.errors import QuestionError
from autobalancer.roots import root
from autobalancer.units import argument

STEP = 4e-3  # relative, of the residuals that are tried
TOGETHER = 50  # of them at once
Floats = npt.NDArray[np.float64]
_DIRECTIONS = np.linspace(-math.pi, math.pi, 180, endpoint=False)


def held_whirl(orbit_radius: float | str, adherence: float, *, weight: float | str = 0.0) -> float:
    """Distance of a race from the axis of rotation up to which a ball at rest stays at any angle, m.

    ``mu eps / sqrt(1 + mu^2) - g/w^2``: the force along the race is greatest, against what holds, where the ball stands
    ``90 deg - atan(mu)`` before the line of the whirl. It does not depend on mass or size of the ball.

    Parameters
    ----------
    orbit_radius
        m.
    adherence
        Greatest force that holds a ball at rest, over the wall force.
    weight
        Acceleration of gravity in the plane of the race over the square of the speed, g/w^2, m: on a horizontal axis
        it moves each ball back and forth once per revolution. A negative result means that this alone moves the balls.

    Raises
    ------
    QuestionError
        If a number is negative, or the orbit radius zero.
    """
    orbit_radius = argument("orbit_radius", orbit_radius, "m")
    weight = argument("weight", weight, "m")
    if not orbit_radius > 0.0:
        raise QuestionError(f"orbit_radius: given {orbit_radius:g} m; must be above zero")
    if adherence < 0.0 or weight < 0.0:
        raise QuestionError(f"adherence, weight: given {adherence:g}, {weight:g}; must not be below zero")
    return adherence * orbit_radius / math.sqrt(1.0 + adherence**2) - weight


def largest_held_residual(
    need: tuple[float, float], moments: Sequence[float], held: float, *, phase: float = math.pi
) -> float:
    """Largest residual unbalance at which the balls of one plane can stop on their way to balance, kg m.

    Up to ``held`` they may stand anywhere. Beyond it a ball rests only within ``asin(held/r)`` of the line of the whirl. So a
    residual r is possible if the unbalance to be balanced is that of r and of balls in these sectors, outwards or inwards.
    Residuals are gone through, from the least that the balls can leave, until one is not possible. Balls trapped near the
    line of the unbalance, where they balance nothing, are beyond that gap and not counted.

    Parameters
    ----------
    need
        Least and greatest size of the unbalance to be balanced, kg m.
    moments
        Of the balls of the plane, kg m.
    held
        Residual unbalance that makes the whirl which friction holds everywhere, kg m.
    phase
        Of the whirl against the residual, rad; pi well above the critical speed.

    Returns
    -------
    float
        At most the sum of the greatest need and all moments. A bound: sectors are taken with their chords.
    """
    most = need[1] + float(sum(moments))
    if held <= 0.0:
        return 0.0
    if held >= most:
        return most
    sides = _patterns(tuple(sorted(round(moment, 15) for moment in moments)))
    total, greatest = float(sum(moments)), max(moments)
    least = max(need[0] - total, 2.0 * greatest - total - need[1], 0.0)  # what the balls leave even without friction
    first = max(held, least * (1.0 - 1e-9))
    residuals = np.geomspace(first, most, math.ceil(math.log(most / first) / STEP) + 2)
    begun, nearest = least <= held, (math.inf, most)
    for part in np.array_split(residuals, math.ceil(residuals.size / TOGETHER)):
        low, high = _reach(part, phase, np.arcsin(np.minimum(held / part, 1.0)), sides)
        gap = np.maximum(low - need[1], need[0] - high).min(axis=1)
        possible = gap <= 1e-9 * most
        ended = ~possible & (begun | (np.cumsum(possible) > 0))
        if ended.any():
            return float(part[np.argmax(ended)])
        begun = begun or bool(possible.any())
        nearest = min(nearest, (float(gap.min()), float(part[np.argmin(gap)])))
    return most if begun else nearest[1]  # sectors narrower than a step: the residual that misses them least


@lru_cache(maxsize=32)
def _patterns(moments: tuple[float, ...]) -> Floats:
    """Sum of the moments of balls that stand outwards, and inwards, for all choices, (K, 2)."""
    if len(set(moments)) == 1:
        count = len(moments)
        outward = np.arange(count + 1.0) * moments[0]
        return np.column_stack([outward, outward[::-1]])
    if len(moments) > 12:
        shares = np.linspace(0.0, sum(moments), 25)
        return np.column_stack([shares, shares[::-1]])
    picks = product((0.0, 1.0), repeat=len(moments))
    chosen = {round(float(np.dot(pick, moments)), 15) for pick in picks}
    outward = np.array(sorted(chosen))
    return np.column_stack([outward, sum(moments) - outward])


def _reach(residuals: Floats, phase: float, half: Floats, sides: Floats) -> tuple[Floats, Floats]:
    """Least and greatest unbalance that each residual and balls in their sectors can be the sum of, (residuals, patterns)."""
    outward = _support(_DIRECTIONS - phase - math.pi, half)[:, None, :]
    inward = _support(_DIRECTIONS - phase, half)[:, None, :]
    # unbalance = residual - balls: support function of the set of its vectors, the residual along zero
    support = residuals[:, None, None] * np.cos(_DIRECTIONS) + sides[:, :1] * outward + sides[:, 1:] * inward
    return np.maximum((-support).max(axis=2), 0.0), support.max(axis=2)


def _support(angle: Floats, half: Floats) -> Floats:
    """How far arcs of the unit circle, each from -half to half, reach in directions, (arcs, directions)."""
    off = np.abs(np.angle(np.exp(1j * angle)))
    return np.asarray(np.cos(np.maximum(off - half[:, None], 0.0)), np.float64)


# Where adherence holds one ball on a race: near the place at which it balances, or near the heavy one it should leave.
#
# Planar rotor with isotropic supports, steady speed.


def rest_interval(
    unbalance: float | str,
    moment: float | str,
    orbit_radius: float | str,
    adherence: float,
    *,
    mass: float | str,
    stiffness: float | str,
    damping: float | str = 0.0,
    speed: float | str,
    heavy: bool = False,
) -> tuple[float, float]:
    """Both ends of the interval in which a ball at rest in the rotor stays, as angles from its place.

    The rotor whirls under unbalance and ball, z = (U + s e^(i phi)) w^2 H(w). A ball stays while the force along the race is
    below adherence times the wall force, ``|Im(z e^(-i phi))|`` <= mu (eps + Re(z e^(-i phi))). On an undamped rotor whose ball
    balances exactly this is, for small angles, ``mu eps |M w^2 - k|/(U w^2)`` to either side.

    Parameters
    ----------
    unbalance, moment
        Of the rotor, and effective mass of the ball times orbit radius, kg m.
    orbit_radius
        m.
    adherence
        Greatest force that holds a ball at rest, over the wall force.
    mass, stiffness, damping
        Of the rotor with the ball in it, kg, N/m, N s/m.
    speed
        rad/s.
    heavy
        Around the place of the unbalance, where a ball at rest adds to the unbalance above the critical speed; else around
        the place opposite to it.

    Returns
    -------
    tuple
        Angles in rad, negative and positive end; -pi or pi where adherence holds the ball all around.

    Raises
    ------
    QuestionError
        If a number is not above zero (damping: below zero), or no place within 90 degrees holds the ball.
    """
    unbalance = argument("unbalance", unbalance, "kg*m")
    moment = argument("moment", moment, "kg*m")
    orbit_radius = argument("orbit_radius", orbit_radius, "m")
    mass = argument("mass", mass, "kg")
    stiffness = argument("stiffness", stiffness, "N/m")
    damping = argument("damping", damping, "N*s/m")
    speed = argument("speed", speed, "rad/s")
    for name, value in (("unbalance", unbalance), ("moment", moment), ("orbit_radius", orbit_radius),
                        ("adherence", adherence), ("mass", mass), ("stiffness", stiffness), ("speed", speed)):  # fmt: skip
        if not value > 0.0:
            raise QuestionError(f"rest_interval: {name}: given {value:g}; must be above zero")
    if damping < 0.0:
        raise QuestionError(f"rest_interval: damping: given {damping:g}; must not be below zero")
    gain = speed**2 / complex(stiffness - mass * speed**2, damping * speed)

    ends = rest_ends(gain, unbalance, moment, orbit_radius, adherence, heavy=heavy)
    if ends is None:
        raise QuestionError(
            f"rest_interval: adherence {adherence:g} holds no ball {'near' if heavy else 'opposite to'} the unbalance"
        )
    return ends


def rest_ends(
    gain: complex, unbalance: float, moment: float, orbit_radius: float, adherence: float, *, heavy: bool = False
) -> tuple[float, float] | None:
    """The same for any rotor, ``gain`` being its whirl for an unbalance at the place of the ball, 1/kg; None without one.

    ``unbalance`` is that of the rotor and of all other balls in the plane.
    """
    toward = 1.0 if heavy else -1.0

    def excess(delta: Any) -> Any:
        seen = (moment + toward * unbalance * np.exp(-1j * delta)) * gain  # z in axes along the ball
        return np.abs(seen.imag) - adherence * (orbit_radius + seen.real)

    tried = np.linspace(-0.5 * math.pi, 0.5 * math.pi, 4001)
    held = tried[excess(tried) < 0.0]
    if not held.size:
        return None
    middle = float(held[np.argmin(np.abs(held))])
    ends = []
    for side in (-math.pi, math.pi):
        tried = np.linspace(middle, middle + side, 4001)
        over = np.flatnonzero(excess(tried) > 0.0)
        first = int(over[0]) if over.size else 0
        ends.append(root(excess, tried[first - 1], tried[first], xtol=1e-14) if first else side)
    return ends[0], ends[1]
