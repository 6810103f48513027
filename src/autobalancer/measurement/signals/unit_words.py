"""Units as loggers write them."""

from __future__ import annotations

import math
import re

from autobalancer.errors import QuestionError, UnitError
from autobalancer.measurement.signals.form import UNITS
from autobalancer.units import argument, to_si

TACHO = ("tacho", "encoder", "trigger", "mark", "keyphasor", "pulse")


def factor_to(unit: str, si: str) -> float:
    """How many ``si`` one ``unit`` is; m/s2, m/s² and g are understood, too.

    Raises
    ------
    UnitError
        If it is no unit, or one of another dimension.
    """
    plain = re.sub(r"(?<=[A-Za-z])(\d)", r"^\1", unit.strip().replace("²", "2"))
    if plain in ("g", "G") and si == "m/s^2":
        plain = "g_0"
    return float(to_si(f"1 {plain}" if plain else "1", "" if si == "1" else si.replace("N m", "N*m")))


def hertz_argument(name: str, value: float | str) -> float:
    """A rate or frequency as a number in Hz or a text with a unit, in Hz.

    Raises
    ------
    QuestionError
        If it is not above zero.
    """
    found = argument(name, value, "rad/s") / (2.0 * math.pi) if isinstance(value, str) else argument(name, value, "1/s")
    if not 0.0 < found < math.inf:
        raise QuestionError(f"{name}: given {value!r}; must be above zero")
    return found


def quantity_of(name: str, unit: str) -> str:
    """The quantity that has this unit; a voltage of a column called tacho, trigger, ... is that of a tacho. Empty if none has.

    A unit g is that of an acceleration.
    """
    if not unit.strip():
        return "tacho" if is_tacho(name) else ""
    if unit.strip() in ("g", "G"):
        return "acceleration"
    for quantity, (si, *_) in UNITS.items():
        try:
            factor_to(unit, si)
        except UnitError:
            continue
        if quantity == "tacho":
            return "tacho" if is_tacho(name) else "voltage"
        return quantity
    return ""


def is_tacho(name: str) -> bool:
    """Whether a column is probably that of a tacho, by its name."""
    return any(word in name.lower() for word in TACHO)
