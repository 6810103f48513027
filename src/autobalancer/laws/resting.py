"""Where adherence holds one ball on a race: near the place at which it balances, or near the heavy one it should leave.

Planar rotor with isotropic supports, steady speed.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.units import argument


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

    found = rest_ends(gain, unbalance, moment, orbit_radius, adherence, heavy=heavy)
    if found is None:
        raise QuestionError(
            f"rest_interval: adherence {adherence:g} holds no ball {'near' if heavy else 'opposite to'} the unbalance"
        )
    return found


def rest_ends(
    gain: complex, unbalance: float, moment: float, orbit_radius: float, adherence: float, *, heavy: bool = False
) -> tuple[float, float] | None:
    """The same for any rotor, ``gain`` being its whirl for an unbalance at the place of the ball, 1/kg; None without one.

    ``unbalance`` is that of the rotor and of all other balls in the plane.
    """
    from scipy.optimize import brentq

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
        ends.append(float(brentq(excess, tried[first - 1], tried[first], xtol=1e-14)) if first else side)
    return ends[0], ends[1]
