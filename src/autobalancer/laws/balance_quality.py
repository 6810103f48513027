"""Balance quality grades of rigid rotors, ISO 21940-11:2016 (before 2016 ISO 1940-1).

A grade G is the permissible velocity of the mass center, e_per W in mm/s, of a rotor that turns freely with its service
speed W. Rotors of all sizes and speeds are then stressed alike.
"""

from __future__ import annotations

import math

from autobalancer.errors import QuestionError
from autobalancer.units import argument

GRADES = (0.4, 1.0, 2.5, 6.3, 16.0, 40.0, 100.0, 250.0, 630.0, 1600.0, 4000.0)  # mm/s, ISO 21940-11, table 1


def balance_grade(unbalance: float | str, mass: float | str, speed: float | str) -> float:
    """Velocity U W/M of the mass center (m/s) of a rotor with this unbalance; 1000 times that is its grade G in mm/s.

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
    return unbalance * _positive("speed", speed, "rad/s") / _positive("mass", mass, "kg")


def permissible_unbalance(grade: float, mass: float | str, speed: float | str) -> float:
    """Residual unbalance U = G M/W (kg m) that a balance quality grade allows; of two planes the sum of both.

    Parameters
    ----------
    grade
        G in m/s: 6.3e-3 of the grade G 6.3.
    mass
        Mass M of the rotor, kg.
    speed
        Service speed W, rad/s.

    Raises
    ------
    QuestionError
        If a value is not positive.

    Source: ISO 21940-11:2016, section 6.
    """
    mass = argument("mass", mass, "kg")
    speed = argument("speed", speed, "rad/s")
    return _positive("grade", grade, "m/s") * _positive("mass", mass, "kg") / _positive("speed", speed, "rad/s")


def grade_name(velocity: float) -> str:
    """The finest grade of table 1 that a velocity U W/M (m/s) keeps: ``"G 6.3"``; ``"above G 4000"`` if it keeps none."""
    for grade in GRADES:
        if velocity * 1e3 <= grade * (1.0 + 1e-9):
            return f"G {grade:g}"
    return f"above G {GRADES[-1]:g}"


def _positive(name: str, value: float, unit: str) -> float:
    if not (math.isfinite(value) and value > 0.0):
        raise QuestionError(f"{name}: given {value!r}; must be greater than zero, in {unit}")
    return float(value)
