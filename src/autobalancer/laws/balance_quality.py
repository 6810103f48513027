"""Balance quality grades of rigid rotors, ISO 21940-11:2016 (before 2016 ISO 1940-1).

A grade G is the permissible velocity of the mass center, e_per W, of a rotor that turns freely with its service speed W. Rotors
of all sizes and speeds are then stressed alike. What is called a grade is in mm/s everywhere, as the standard writes it: 6.3 of
G 6.3.
"""

from __future__ import annotations

import math
import re

from autobalancer.errors import QuestionError, UnitError
from autobalancer.units import argument, shortened

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
    return 1e3 * unbalance * _positive("speed", speed, "rad/s") / _positive("mass", mass, "kg")


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
    return center * _positive("mass", mass, "kg") / _positive("speed", speed, "rad/s")


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


def _positive(name: str, value: float, unit: str) -> float:
    if not (math.isfinite(value) and value > 0.0):
        raise QuestionError(f"{name}: given {value!r}; must be greater than zero, in {unit}")
    return float(value)
