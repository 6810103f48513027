"""Capability: the unbalance that the balls in one race can compensate.

Spannan (2021), eqs. (2.1) to (2.3). On the orbit radius e one ball occupies 2 a with a = arcsin(d / 2e).
The sum (2.3) over n touching balls is sin(n a) / sin(a), for odd and for even n.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from autobalancer.errors import QuestionError
from autobalancer.units import argument

_ROUNDING = 1e-9
"""Balls that miss their place by this fraction of a ball fit: it is rounding, not geometry."""


def half_sector(orbit_radius: float, ball_diameter: float) -> float:
    """Half of the sector that one ball occupies on its orbit [rad].

    Parameters
    ----------
    orbit_radius, ball_diameter
        Radius of the circle of the ball centers and diameter of a ball [m].

    Raises
    ------
    QuestionError
        If a length is not positive or the ball is larger than its orbit.

    Source: Spannan (2021), eq. (2.2).
    """
    _positive(orbit_radius, "orbit_radius", "m")
    _positive(ball_diameter, "ball_diameter", "m")
    if ball_diameter > 2.0 * orbit_radius:
        raise QuestionError(
            f"a ball of {ball_diameter:g} m does not fit on an orbit of radius {orbit_radius:g} m: the "
            f"diameter may be at most {2.0 * orbit_radius:g} m; take a smaller ball or a larger orbit radius"
        )
    return math.asin(0.5 * ball_diameter / orbit_radius)


def potential_ratio(count: npt.ArrayLike, alpha: npt.ArrayLike) -> Any:
    """Capability of ``count`` touching balls in units of the capability of one: sin(n a) / sin(a).

    Parameters
    ----------
    count
        Number of balls; broadcasts with ``alpha``.
    alpha
        Half of the sector occupied by one ball [rad]; at zero the limit ``count`` is returned.

    Returns
    -------
    numpy.ndarray or numpy.float64
        Dimensionless, of the broadcast shape. It passes its maximum 1 / sin(a) at half an orbit and is
        zero for a full one.

    Source: Spannan (2021), eq. (2.3), summed.
    """
    n, a = np.broadcast_arrays(np.asarray(count, float), np.asarray(alpha, float))
    point = a == 0.0
    ratio = np.sin(n * a) / np.where(point, 1.0, np.sin(a))
    return np.where(point, n, ratio)[()]


def largest_count(orbit_radius: float | str, ball_diameter: float | str) -> int:
    """Number of balls of ``ball_diameter`` (m) that fill an orbit of ``orbit_radius`` (m); errors as :func:`half_sector`."""
    orbit_radius = argument("orbit_radius", orbit_radius, "m")
    ball_diameter = argument("ball_diameter", ball_diameter, "m")
    return math.floor(math.pi / half_sector(orbit_radius, ball_diameter) + _ROUNDING)


def largest_useful_count(orbit_radius: float | str, ball_diameter: float | str) -> int:
    """Number of balls with the greatest capability; more balls compensate less.

    It is the integer nearest to pi / (2 a), the smaller one of two equals. The rule of Spannan (2021), below
    eq. (2.2), takes the next lower integer, which is one ball short whenever the fraction exceeds one half.
    ``orbit_radius`` and ``ball_diameter`` are in m; errors as :func:`half_sector`.
    """
    orbit_radius = argument("orbit_radius", orbit_radius, "m")
    ball_diameter = argument("ball_diameter", ball_diameter, "m")
    half_orbit = 0.5 * math.pi / half_sector(orbit_radius, ball_diameter)
    return max(1, math.ceil(half_orbit - 0.5 - _ROUNDING))


def ball_mass(ball_diameter: float, ball_density: float, *, fluid_density: float = 0.0) -> float:
    """Mass of one ball less the mass of the fluid it displaces [kg].

    Densities in kg/m^3. Raises ``QuestionError`` if a value is not positive or if the ball would float:
    then it is driven inwards and balances nothing. Source: Spannan (2021), eq. (2.1).
    """
    _positive(ball_diameter, "ball_diameter", "m")
    _positive(ball_density, "ball_density", "kg/m^3")
    if not 0.0 <= fluid_density < math.inf:
        raise QuestionError(f"given fluid_density = {fluid_density!r} kg/m^3; write a finite number from 0 up")
    if ball_density <= fluid_density:
        raise QuestionError(
            f"balls of {ball_density:g} kg/m^3 float in a fluid of {fluid_density:g} kg/m^3 and balance "
            "nothing; take a denser ball or a lighter fluid"
        )
    return math.pi / 6.0 * ball_diameter**3 * (ball_density - fluid_density)


def ball_capability(
    orbit_radius: float, ball_diameter: float, ball_density: float, *, fluid_density: float = 0.0
) -> float:
    """Unbalance that one ball compensates [kg m]; arguments and errors as for :func:`capability`.

    Source: Spannan (2021), eq. (2.1).
    """
    half_sector(orbit_radius, ball_diameter)
    return ball_mass(ball_diameter, ball_density, fluid_density=fluid_density) * orbit_radius


def capability(
    orbit_radius: float | str,
    ball_diameter: float | str,
    ball_density: float | str,
    count: int | None = None,
    *,
    fluid_density: float | str = 0.0,
) -> float:
    """Largest unbalance that the balls of one race can compensate [kg m].

    Parameters
    ----------
    orbit_radius, ball_diameter
        Radius of the circle of the ball centers and diameter of a ball [m].
    ball_density, fluid_density
        Densities of the balls and of the fluid around them [kg/m^3]; zero neglects the buoyancy.
    count
        Number of balls; by default the number with the greatest capability.

    Raises
    ------
    QuestionError
        If a value is not positive, the balls float or do not fit on the orbit.

    Source: Spannan (2021), eqs. (2.1) to (2.3).
    """
    orbit_radius = argument("orbit_radius", orbit_radius, "m")
    ball_diameter = argument("ball_diameter", ball_diameter, "m")
    ball_density = argument("ball_density", ball_density, "kg/m^3")
    fluid_density = argument("fluid_density", fluid_density, "kg/m^3")
    alpha = half_sector(orbit_radius, ball_diameter)
    fit = largest_count(orbit_radius, ball_diameter)
    if count is None:
        count = largest_useful_count(orbit_radius, ball_diameter)
    elif isinstance(count, bool) or count != int(count) or not 1 <= count <= fit:
        raise QuestionError(
            f"given count = {count!r}; on an orbit of radius {orbit_radius:g} m there is room for 1 to {fit} "
            f"balls of {ball_diameter:g} m"
        )
    one = ball_capability(orbit_radius, ball_diameter, ball_density, fluid_density=fluid_density)
    return one * float(potential_ratio(count, alpha))


def needed_count(
    unbalance: float,
    orbit_radius: float,
    ball_diameter: float,
    ball_density: float,
    *,
    fluid_density: float = 0.0,
) -> int:
    """Smallest number of balls, two or more, that can compensate ``unbalance`` [kg m].

    One ball alone always adds its full unbalance; from two balls on the sum can be anything from zero up.
    The other arguments are those of :func:`capability`. Raises ``QuestionError`` if no number reaches it.
    """
    _positive(unbalance, "unbalance", "kg m")
    alpha = half_sector(orbit_radius, ball_diameter)
    most = max(2, largest_useful_count(orbit_radius, ball_diameter))
    greatest = capability(orbit_radius, ball_diameter, ball_density, most, fluid_density=fluid_density)
    if unbalance > greatest * (1.0 + _ROUNDING):
        raise QuestionError(
            f"an unbalance of {unbalance:g} kg m is wanted, but this race compensates at most "
            f"{greatest:g} kg m (with {most} balls); take larger or denser balls, a larger "
            "orbit, or more than one race"
        )
    one = ball_capability(orbit_radius, ball_diameter, ball_density, fluid_density=fluid_density)
    share = min(1.0, unbalance / one * math.sin(alpha))
    return min(most, max(2, math.ceil(math.asin(share) / alpha - _ROUNDING)))


def _positive(value: float, name: str, unit: str) -> None:
    if not 0.0 < value < math.inf:
        raise QuestionError(f"given {name} = {value!r} {unit}; write a finite number greater than zero")
