"""Thin film between a ball and the wall on which it runs: how force and torque grow as the gap closes.

The gap is h = delta + x^2/(2 A) + z^2/(2 B) with 1/A = 1/r - 1/R_x, 1/B = 1/r - 1/R_z; R are the radii of a hollow wall along
and across the race. Reynolds' equation with walls that move with v_wall and v_ball along x has the exact solution
p = -6 mu V x / ((3 + 2 A/B) h^2), V = v_wall + v_ball, so that with S = (A B)^(1/2) every unit of ln(1/delta) adds

    force on the ball    2 pi mu S (v_wall - v_ball + 3 V / (3 + 2 A/B)),
    torque / r           2 pi mu S (v_wall - v_ball - 3 V / (3 + 2 A/B)),

the torque counted so that a force along x at the place of contact has a positive one. For a plane wall these are the logarithms
of Goldman, Cox and Brenner (1967): 8/15, 2/15, 1/10 and 2/5.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from autobalancer.errors import QuestionError


class FilmSlopes(NamedTuple):
    """Change per unit of ln(1/gap): ``force`` over mu r U, ``torque`` over mu r^2 U."""

    force: float
    torque: float


def film_slopes(
    ball_velocity: float, wall_velocity: float = -1.0, race_radius: float = math.inf, groove_radius: float = math.inf
) -> FilmSlopes:
    """Force and torque on a ball per unit of ln(1/gap).

    Parameters
    ----------
    ball_velocity, wall_velocity
        Of both surfaces at the contact along the race, in the frame of the ball center and in units of its speed U: 0 and -1 for
        a ball that slides, -1 and -1 for one that rolls.
    race_radius, groove_radius
        Radii of the hollow wall along and across the race, in ball radii; infinite for a straight one.

    Raises
    ------
    QuestionError
        If a radius is not larger than that of the ball.
    """
    for name, radius in (("race_radius", race_radius), ("groove_radius", groove_radius)):
        if not radius > 1.0:
            raise QuestionError(f"{name}: given {radius:g} ball radii; a ball fits into larger radii than its own only")
    along, across = 1.0 / (1.0 - 1.0 / race_radius), 1.0 / (1.0 - 1.0 / groove_radius)
    shear = wall_velocity - ball_velocity
    wedge = 3.0 * (wall_velocity + ball_velocity) / (3.0 + 2.0 * along / across)
    size = 2.0 * math.pi * math.sqrt(along * across)
    return FilmSlopes(size * (shear + wedge), size * (shear - wedge))
