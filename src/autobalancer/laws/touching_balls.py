"""Two balls of one race that touch: where they press, and how they rub while they roll.

Ball i rolls with the spin -eps_i phi_i'/r_i as seen from its race, so it turns about the point of the wall it stands on. With e
from the center of ball 1 to that of ball 2 and n_i outward, sin a_1 = -e.n_1 and sin a_2 = e.n_2. At their contact the surface
of ball 1 moves along e turned by -90 degrees with eps_1 (1 + sin a_1) phi_1', that of ball 2 with -eps_2 (1 + sin a_2) phi_2',
so that they slip with

    v = l_1 phi_1' + l_2 phi_2',    l_1 = eps_1 (1 + sin a_1) = 2 R r_2/(r_1 + r_2),    l_2 = 2 R r_1/(r_1 + r_2),

R = eps_i + r_i the radius of the wall, which is the arm of equal balls. A friction force f against the slip takes the torque
f l_i from each ball, by virtual work; the rotor feels nothing of it, as no slip comes from its motion. The force F along e
that presses the balls has the torque F eps_i cos a_i, the same for both, and presses each onto the wall with F sin a_i;
friction presses ball 2 onto it, and ball 1 off it, with f cos a_i. Derived here; a resolved ball has all of it by itself.
"""

from __future__ import annotations

import math
from typing import NamedTuple


class TouchingBalls(NamedTuple):
    """Geometry of a contact; the first of each pair is of the ball at the smaller angle."""

    arms: tuple[float, float]  # l_i: slip over ball speed, and torque over friction force, m
    outward: tuple[float, float]  # sin a_i: force onto the wall over force that presses the balls
    force: float  # force that presses the balls over its torque on either, 1/m


def touching_balls(orbits: tuple[float, float], radii: tuple[float, float]) -> TouchingBalls:
    """Geometry of two balls that touch, from their ``orbits`` (radii of the paths of their centers) and ``radii``, m."""
    apart = radii[0] + radii[1]
    difference = orbits[0] ** 2 - orbits[1] ** 2
    sines = (
        (apart**2 + difference) / (2.0 * apart * orbits[0]),
        (apart**2 - difference) / (2.0 * apart * orbits[1]),
    )
    return TouchingBalls(
        arms=(orbits[0] * (1.0 + sines[0]), orbits[1] * (1.0 + sines[1])),
        outward=sines,
        force=1.0 / (orbits[0] * math.sqrt(1.0 - sines[0] ** 2)),
    )
