"""Units in which most machines are written: read without the table of all units, which takes a tenth of a second to make."""

from __future__ import annotations

import math

_TURN = 2.0 * math.pi
COMMON = {  # unit as written, SI unit that is wanted: factor, and what is added after it
    ("um", "m"): (1e-6, 0.0),
    ("mm", "m"): (1e-3, 0.0),
    ("cm", "m"): (1e-2, 0.0),
    ("g", "kg"): (1e-3, 0.0),
    ("ms", "s"): (1e-3, 0.0),
    ("deg", "rad"): (_TURN / 360.0, 0.0),
    ("rpm", "rad/s"): (_TURN / 60.0, 0.0),
    ("Hz", "rad/s"): (_TURN, 0.0),
    ("%", ""): (1e-2, 0.0),
    ("degC", "K"): (1.0, 273.15),
    ("mm/s", "m/s"): (1e-3, 0.0),
    ("mm^2/s", "m^2/s"): (1e-6, 0.0),
    ("g*mm", "kg*m"): (1e-6, 0.0),
    ("kg*mm^2", "kg*m^2"): (1e-6, 0.0),
    ("mN", "N"): (1e-3, 0.0),
    ("kN", "N"): (1e3, 0.0),
    ("kN/m", "N/m"): (1e3, 0.0),
    ("MN/m", "N/m"): (1e6, 0.0),
    ("kN*s/m", "N*s/m"): (1e3, 0.0),
    ("GPa", "Pa"): (1e9, 0.0),
}
SAME = {  # SI units as this package writes them
    "kg", "m", "rad", "rad/s", "rad/s^2", "s", "N", "N/m", "N*s/m", "N*m", "N*m*s", "N*m/rad", "kg*m", "kg*m^2",
    "kg/m^3", "m^2/s", "m/s", "m/s^2", "K", "Pa", "Pa*s",
}  # fmt: skip


def common(number: float, written: str, unit: str) -> float | None:
    """The number in the SI ``unit``; ``None`` if it is not written in one of the common units."""
    if written == unit and unit in SAME:
        return number
    factor, added = COMMON.get((written, unit), (math.nan, 0.0))
    return None if math.isnan(factor) else number * factor + added
