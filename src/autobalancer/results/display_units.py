"""Units in which results are shown, in tables and on axes: results are SI, people read rpm and µm."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from autobalancer.errors import one_of

if TYPE_CHECKING:
    import xarray as xr


# Numbers of results as people read them.


# units of an unbalance, how many of them are 1 kg m, and up to how many each is taken
MOMENTS = (("g mm", 1e6, 1e4), ("kg mm", 1e3, 1e3), ("kg m", 1.0, math.inf))
LENGTHS = (("m", 1.0), ("mm", 1e3), ("µm", 1e6), ("nm", 1e9))


def length_text(value: float) -> str:
    """A length in m as text in its natural unit: ``"8.8 nm"``."""
    if abs(value) < 1e-11:
        return "0" if value == 0.0 else "< 0.01 nm"
    sign, factor = next(((sign, factor) for sign, factor in LENGTHS if abs(value) * factor >= 1.0), LENGTHS[-1])
    return f"{significant(value * factor)} {sign}"


def moment_text(value: float, digits: int = 3) -> str:
    """An unbalance in kg m as text: ``"500 g mm"``, above 10 000 g mm ``"124 kg mm"``, above 1000 kg mm in kg m."""
    if 0.0 < abs(value) < 1e-9:
        return "< 0.001 g mm"
    unit, factor = next(
        (unit, factor) for unit, factor, most in MOMENTS if not abs(value) * factor > most * (1.0 + 1e-9)
    )
    return f"{significant(value * factor, digits)} {unit}"


def couple_text(value: float) -> str:
    """A couple unbalance in kg m^2 as text: ``"10 kg mm²"``."""
    shown = value * 1e6
    return "< 0.001 kg mm²" if 0.0 < abs(shown) < 1e-3 else f"{significant(shown)} kg mm²"


def share_text(value: float) -> str:
    """A share as text in percent: ``"12.3 %"``."""
    return "< 0.01 %" if 0.0 < value < 1e-4 else f"{significant(100.0 * value)} %"


def velocity_text(value: float) -> str:
    """A velocity in m/s as text: ``"1.2 mm/s"``."""
    return "< 0.001 mm/s" if 0.0 < value < 1e-6 else f"{significant(value * 1e3)} mm/s"


def force_text(value: float) -> str:
    """A force in N as text."""
    return "< 0.001 N" if 0.0 < abs(value) < 1e-3 else f"{significant(value)} N"


def significant(value: float, digits: int = 3) -> str:
    """So many digits without an exponent where people would write none."""
    return f"{value:.0f}" if 10.0 ** (digits - 1) <= abs(value) < 1e6 else f"{value:.{digits}g}"


def side_text(value: float, reference: float) -> str:
    """On which side of a reference a value is, and how far in percent of it: ``"2.2 % below"``."""
    share = 100.0 * (value / reference - 1.0)
    return f"{significant(abs(share))} % {'above' if share >= 0.0 else 'below'}"


def worded(text: str, bodies: str) -> str:
    """A text about balls as one about these ``bodies``, such as "cylinders"."""
    return re.sub(r"\bball(s?)\b", rf"{bodies[:-1]}\1", text)


@dataclass(frozen=True)
class AxisUnit:
    """How a quantity is shown: ``factor * si + offset``, followed by ``sign``; only temperatures have an offset."""

    sign: str
    factor: float
    offset: float = 0.0

    def shown(self, si: Any) -> Any:
        """A value, or an array of values, as shown."""
        return self.factor * si + self.offset

    def in_si(self, shown: Any) -> Any:
        """The value that is shown so."""
        return (shown - self.offset) / self.factor


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
SHOWN = {
    "m^2/s": AxisUnit("mm²/s", 1e6),
    "kg m": AxisUnit("g mm", 1e6),
    "1": AxisUnit("", 1.0),
    "m": AxisUnit("mm", 1e3),
    "rad": AxisUnit("°", 180.0 / math.pi),
    "kg/m^3": AxisUnit("kg/m³", 1.0),
    "K": AxisUnit("°C", 1.0, -273.15),
}
MEASURES = {
    "m": ("µm", 1e6),
    "rad": ("deg", 180.0 / math.pi),
    "m/s": ("mm/s", 1e3),
    "kg m": ("g mm", 1e6),
    "1": ("%", 100.0),
}


def speed_axis(unit: str) -> AxisUnit:
    """The unit of a speed axis.

    Raises
    ------
    QuestionError
        If ``unit`` is not one of ``SPEED_UNITS``.
    """
    one_of("speed_unit", unit, *SPEED_UNITS)
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
    one_of("deflection_unit", unit, *LENGTH_UNITS)
    return LENGTH_UNITS[unit]


def vibration_axis(unit: str, greatest: float) -> AxisUnit:
    """The unit of amplitudes in the SI ``unit``: of a displacement as suits the ``greatest``, of a velocity mm/s."""
    if unit == "m":
        return length_axis(None, greatest or 1.0)
    return AxisUnit(*MEASURES[unit]) if unit == "m/s" else AxisUnit(unit, 1.0)


def round_down(value: float) -> float:
    """The next of 1, 2, 5, 10, 20, ... that is not above ``value``: a scale one can say."""
    power = 10.0 ** math.floor(math.log10(value))
    return power * next(step for step in (5.0, 2.0, 1.0) if step * power <= value * (1.0 + 1e-12))


def times_larger(own: float, greatest: float, share: float = 0.3) -> float:
    """How much larger a thing is drawn that is below a ``share`` of the ``greatest`` beside it; 1 if it is not, or nothing."""
    return round_down(greatest / own) if 0.0 < own < share * greatest else 1.0


def axis_unit(values: xr.DataArray, speed_unit: str) -> AxisUnit:
    """The unit in which a coordinate is shown; small masses are shown in g."""
    unit = str(values.attrs.get("units", ""))
    if unit == "rad/s":
        return speed_axis(speed_unit)
    if unit == "kg":
        return AxisUnit("g", 1e3) if values.size and float(values.max()) < 1.0 else AxisUnit("kg", 1.0)
    return SHOWN.get(unit, AxisUnit(unit, 1.0))


def measure_unit(unit: str) -> tuple[str, float]:
    """The unit in which a measure in an SI ``unit`` is shown, and its factor; speeds have :func:`speed_axis`."""
    return MEASURES.get(unit, (unit, 1.0))
