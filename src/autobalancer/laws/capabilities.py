"""Capability: the unbalance that the balls in one race can compensate.

Spannan (2021), eqs. (2.1) to (2.3). On the orbit radius e one ball occupies 2 a with a = arcsin(d / 2e).
The sum (2.3) over n touching balls is sin(n a) / sin(a), for odd and for even n.
"""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from autobalancer.errors import QuestionError, UnitError
from autobalancer.units import argument, shortened

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


# Capability of a deep chamber: balls side by side on its wall, in straight rows along the axis.
#
# The sum of Spannan (2021), (2.3), with as many balls at each angle as the depth takes.


Sized = tuple[int, float, float, float]  # number, radius, mass, half of what one takes along the axis


def chamber_capability(radius: float, depth: float, balls: Sequence[tuple[int, float, float] | Sized]) -> float:
    """Largest unbalance that the balls of a cylindrical chamber can balance [kg m].

    Parameters
    ----------
    radius, depth
        Of the chamber [m].
    balls
        Number, radius [m] and mass [kg] of equal balls, for each size; of cylinders half their length [m] too.

    Notes
    -----
    Balls that do not fit on the wall lie in the hollows of the full layer before them, which balances nothing. The balls
    of one angle lie beside each other over the depth; staggered rows may reach a little more.
    """
    merged: dict[tuple[float, float, float], int] = {}
    for count, size, mass, *halves in balls:
        kind = size, mass, halves[0] if halves else size
        merged[kind] = merged.get(kind, 0) + count
    left = [(count, *kind) for kind, count in merged.items() if count]
    inward = 0.0
    while True:
        columns = _columns(radius - inward, depth, left)
        taken = sum(half for _, half in columns)
        if taken <= math.pi * (1.0 + _ROUNDING):
            return _resultant(columns)
        # a full ring has no resultant: what it takes is gone
        ring = _ring(radius - inward, depth, left, math.pi / taken)
        inward += math.sqrt(3.0) * max(size for _, size, _, _ in left)
        left = [(of[0] - gone, *of[1:]) for of, gone in zip(left, ring, strict=True) if of[0] > gone]


def _ring(radius: float, depth: float, balls: Sequence[Sized], share: float) -> list[int]:
    """How many of each size fill one ring: ``share`` of each, then more while there is room, at least one ball."""
    ring = [math.floor(of[0] * share) for of in balls]
    for i, (count, *_) in enumerate(balls):
        while ring[i] < count:
            ring[i] += 1
            tried = [(number, *of[1:]) for number, of in zip(ring, balls, strict=True)]
            if sum(half for _, half in _columns(radius, depth, tried)) > math.pi * (1.0 + _ROUNDING):
                ring[i] -= 1
                break
    return ring


def _columns(radius: float, depth: float, balls: Sequence[Sized]) -> list[tuple[float, float]]:
    """Moment and half of the sector of the balls at each angle, one after the other."""
    columns: list[tuple[float, float]] = []
    for count, size, mass, half in balls:
        orbit = max(radius - size, size)
        deep = max(math.floor(0.5 * depth / half * (1.0 + _ROUNDING)), 1)
        numbers = [deep] * (count // deep) + ([count % deep] if count % deep else [])
        columns += [(number * mass * orbit, math.asin(size / orbit)) for number in numbers]
    return columns


def _resultant(columns: Sequence[tuple[float, float]]) -> float:
    angle, total = 0.0, 0j
    for number, (moment, half) in enumerate(columns):
        angle += half + (columns[number - 1][1] if number else 0.0)
        total += cmath.rect(moment, angle)
    return abs(total)


# Balance quality grades of rigid rotors, ISO 21940-11:2016 (before 2016 ISO 1940-1).
#
# A grade G is the permissible velocity of the mass center, e_per W, of a rotor that turns freely with its service
# speed W. Rotors of all sizes and speeds are then stressed alike. What is called a grade is in mm/s everywhere, as the
# standard writes it: 6.3 of G 6.3.


GRADES = (0.4, 1.0, 2.5, 6.3, 16.0, 40.0, 100.0, 250.0, 630.0, 1600.0, 4000.0)  # mm/s, ISO 21940-11, table 1


def balance_grade(unbalance: float | str, mass: float | str, speed: float | str) -> float:
    """Grade G of a rotor with this unbalance: the velocity U W/M of its mass center, mm/s.

    Parameters
    ----------
    unbalance
        Residual unbalance U of the rotor, kg m; of two planes the sum of both.
    mass
        Mass M of the rotor, kg.
    speed
        Service speed W, rad/s.

    Raises
    ------
    QuestionError
        If the unbalance is negative, or mass or speed are not positive.

    Source: ISO 21940-11:2016, section 6.
    """
    unbalance = argument("unbalance", unbalance, "kg*m")
    mass = argument("mass", mass, "kg")
    speed = argument("speed", speed, "rad/s")
    if not (math.isfinite(unbalance) and unbalance >= 0.0):
        raise QuestionError(f"unbalance: given {unbalance!r}; must be a number not below zero, in kg m")
    return (
        1e3
        * unbalance
        * _balance_quality_positive("speed", speed, "rad/s")
        / _balance_quality_positive("mass", mass, "kg")
    )


def permissible_unbalance(grade: float | str, mass: float | str, speed: float | str) -> float:
    """Residual unbalance U = G M/W (kg m) that a balance quality grade allows; of two planes the sum of both.

    Parameters
    ----------
    grade
        G in mm/s, from 0.4 to 4000: 6.3, ``"G 6.3"`` or ``"6.3 mm/s"``.
    mass
        Mass M of the rotor, kg.
    speed
        Service speed W, rad/s.

    Raises
    ------
    QuestionError
        If a value is not positive, or the grade is none.

    Source: ISO 21940-11:2016, section 6.
    """
    mass = argument("mass", mass, "kg")
    speed = argument("speed", speed, "rad/s")
    center = 1e-3 * grade_argument(grade)
    return center * _balance_quality_positive("mass", mass, "kg") / _balance_quality_positive("speed", speed, "rad/s")


def grade_argument(grade: float | str) -> float:
    """A grade in mm/s, from a number of mm/s or a text: ``"2.5"``, ``"G 2.5"``, ``"G2.5"``, ``"2.5 mm/s"``.

    Raises
    ------
    QuestionError
        If it is none, or outside of the grades of the standard: a number in m/s is far below them.
    """
    found = grade
    if isinstance(grade, str):
        text = re.sub(r"^\s*[Gg]\s*", "", grade).strip()
        try:
            found = float(text) if re.fullmatch(r"[0-9.]+", text) else 1e3 * argument("grade", text, "m/s")
        except (UnitError, ValueError):
            found = math.nan
    if isinstance(found, bool) or not isinstance(found, (int, float)) or not GRADES[0] <= found <= GRADES[-1]:
        raise QuestionError(
            f"grade: given {shortened(grade)}; write it as in ISO 21940-11, such as 2.5 or 'G 2.5' (mm/s), from G {GRADES[0]:g} "
            f"to G {GRADES[-1]:g}"
        )
    return float(found)


def grade_name(grade: float) -> str:
    """The finest grade of table 1 that G (mm/s) keeps: ``"G 6.3"``; ``"above G 4000"`` if it keeps none."""
    for one in GRADES:
        if grade <= one * (1.0 + 1e-9):
            return f"G {one:g}"
    return f"above G {GRADES[-1]:g}"


def _balance_quality_positive(name: str, value: float, unit: str) -> float:
    if not (math.isfinite(value) and value > 0.0):
        raise QuestionError(f"{name}: given {value!r}; must be greater than zero, in {unit}")
    return float(value)
