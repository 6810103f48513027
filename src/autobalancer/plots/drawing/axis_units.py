"""Units of axes: results are SI, people read rpm and µm."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from autobalancer.errors import QuestionError
from autobalancer.results.number_text import couple_text, length_text, moment_text, significant

__all__ = [
    "EACH_ITS_OWN",
    "LENGTH_UNITS",
    "SPEED_UNITS",
    "AxisUnit",
    "couple_text",
    "length_axis",
    "length_text",
    "length_tick",
    "moment_axis",
    "moment_text",
    "round_down",
    "significant",
    "speed_axis",
    "times_larger",
]


@dataclass(frozen=True)
class AxisUnit:
    """How a quantity is shown: ``factor * si + offset``, followed by ``sign``; only temperatures have an offset."""

    sign: str
    factor: float
    offset: float = 0.0

    def shown(self, si: Any) -> Any:
        """A value, or an array of values, as shown."""
        return self.factor * si + self.offset


SPEED_UNITS = {
    "rpm": AxisUnit("rpm", 30.0 / math.pi),
    "rad/s": AxisUnit("rad/s", 1.0),
    "Hz": AxisUnit("Hz", 0.5 / math.pi),
}
LENGTH_UNITS = {
    "m": AxisUnit("m", 1.0),
    "mm": AxisUnit("mm", 1e3),
    "um": AxisUnit("µm", 1e6),
    "nm": AxisUnit("nm", 1e9),
}


def speed_axis(unit: str) -> AxisUnit:
    """The unit of a speed axis.

    Raises
    ------
    QuestionError
        If ``unit`` is not one of ``SPEED_UNITS``.
    """
    if unit not in SPEED_UNITS:
        raise QuestionError(f"speed_unit: given {unit!r}; must be one of {', '.join(SPEED_UNITS)}")
    return SPEED_UNITS[unit]


EACH_ITS_OWN = AxisUnit("", 1.0)  # of a logarithmic axis of lengths: its ticks say nm, µm, mm or m


def length_tick(value: float) -> str:
    """``"10 µm"``: a length in m with the unit that suits it."""
    unit = length_axis(None, value * (1.0 + 1e-9))
    return f"{value * unit.factor:g} {unit.sign}"


def length_axis(unit: str | None, greatest: float) -> AxisUnit:
    """The unit of a deflection axis; ``None`` takes the largest one in which ``greatest`` (m) is at least 1.

    Raises
    ------
    QuestionError
        If ``unit`` is not one of ``LENGTH_UNITS``.
    """
    if unit is None:
        return next((u for u in LENGTH_UNITS.values() if greatest * u.factor >= 1.0), LENGTH_UNITS["nm"])
    if unit not in LENGTH_UNITS:
        raise QuestionError(f"deflection_unit: given {unit!r}; must be one of {', '.join(LENGTH_UNITS)}")
    return LENGTH_UNITS[unit]


def moment_axis(greatest: float) -> AxisUnit:
    """The unit of an axis of unbalance up to ``greatest`` (kg m)."""
    return AxisUnit("g mm", 1e6) if greatest < 0.01 else AxisUnit("kg mm", 1e3)


def round_down(value: float) -> float:
    """The next of 1, 2, 5, 10, 20, ... that is not above ``value``: a scale one can say."""
    power = 10.0 ** math.floor(math.log10(value))
    return power * next(step for step in (5.0, 2.0, 1.0) if step * power <= value * (1.0 + 1e-12))


def times_larger(own: float, greatest: float, share: float = 0.3) -> float:
    """How much larger a thing is drawn that is below a ``share`` of the ``greatest`` beside it; 1 if it is not, or nothing."""
    return round_down(greatest / own) if 0.0 < own < share * greatest else 1.0
