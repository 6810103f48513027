"""Units as loggers write them."""

from __future__ import annotations

import math

from autobalancer.errors import QuestionError, UnitError
from autobalancer.measurement.signals.form import UNITS
from autobalancer.units import argument, column_factor
from autobalancer.units.trade import factor, without_suffix

TACHO = ("tacho", "encoder", "trigger", "mark", "keyphasor", "pulse")


def factor_to(unit: str, si: str) -> float:
    """How many ``si`` one ``unit`` is.

    Raises
    ------
    UnitError
        If it is no unit, or one of another dimension, or that of a value from peak to peak or an rms value, which samples of a
        waveform are not.
    """
    return column_factor(unit.strip(), "" if si == "1" else si)[0]


def hertz_argument(name: str, value: float | str) -> float:
    """A rate or frequency as a number in Hz or a text with a unit, in Hz; 1/s is Hz here, since no rotation is meant.

    Raises
    ------
    QuestionError
        If it is not above zero.
    """
    try:
        found = argument(name, value, "1/s")
    except UnitError:
        found = argument(name, value, "rad/s") / (2.0 * math.pi)
    if not 0.0 < found < math.inf:
        raise QuestionError(f"{name}: given {value!r}; must be above zero")
    return found


def quantity_of(name: str, unit: str) -> str:
    """The quantity that has this unit; a voltage of a column called tacho, trigger, ... is that of a tacho. Empty if none has.

    A unit g is that of an acceleration. Of 1/s, and of a unit with ``pp`` or ``rms``, it is what it would be if it were complete,
    so that :func:`factor_to` can say what is missing.
    """
    unit = without_suffix(unit.strip())[0]
    if not unit.strip():
        return "tacho" if is_tacho(name) else ""
    try:
        found = next((quantity for quantity, (si, *_) in UNITS.items() if factor(unit, si) is not None), "")
        if not found and factor(unit, "1/s") is not None:
            return "speed"
    except UnitError:
        return ""
    return "voltage" if found == "tacho" and not is_tacho(name) else found


def is_tacho(name: str) -> bool:
    """Whether a column is probably that of a tacho, by its name."""
    return any(word in name.lower() for word in TACHO)
