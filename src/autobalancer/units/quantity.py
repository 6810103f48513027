"""One quantity: a number in SI, or a text with a unit."""

from __future__ import annotations

import math
import re
import sys
from functools import cache, lru_cache
from typing import Any

from autobalancer.errors import UnitError
from autobalancer.units.common import common

LONGEST = 80  # characters of a quantity; a sensible one has 30 at most
_POWER = re.compile(
    r"(?:\*\*|\^)\s*(?:[+-]?\d(?:\.\d+)?|\(\s*[+-]?\d(?:\.\d+)?\s*(?:/\s*\d\s*)?\))(?!\s*(?:\*\*|\^|\d))"
)
_FACTOR = re.compile(r"(?<!\w)[\d.]+")
_NUMBER = re.compile(r"^\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*)$")

_SECOND = re.compile(r"(?:^|\s)[+-]?(?!1/)\d")  # a number within the unit: a range, or two quantities


class Given(float):
    """A float in SI that remembers how it was written.

    ``Given("4.4 g", 0.0044)`` equals ``0.0044`` in every calculation; ``.text`` is ``"4.4 g"``.
    """

    text: str

    def __new__(cls, text: str, value: float) -> Given:
        self = super().__new__(cls, value)
        self.text = text
        return self

    def __getnewargs__(self) -> tuple[str, float]:  # type: ignore[override]
        return self.text, float(self)

    def __deepcopy__(self, memo: dict[int, Any]) -> Given:
        return self


@cache
def _registry() -> Any:
    import pint

    registry: Any = pint.UnitRegistry(cache_folder=None, on_redefinition="ignore")
    registry.define("hertz = 2 * pi * radian / second = Hz")  # a speed in Hz counts revolutions
    registry.define("rev = 2 * pi * radian")
    registry.define("cSt = 1e-6 * m**2 / s = centistokes")
    registry.define("gmm = 1e-6 * kg * m = g_mm")
    return registry


def _unit(text: str) -> Any:
    """Refuses what the library would work out for ever, such as ``m**9**9**9``."""
    rest = _POWER.sub(" ", text)
    if len(text) > LONGEST or "**" in rest or "^" in rest or any(found != "1" for found in _FACTOR.findall(rest)):
        raise UnitError(f"{shortened(text)} is not a unit; write one such as 'kg*m^2/s', with exponents below 10")
    try:
        return _registry().Unit(text if text else "dimensionless")
    except Exception as reason:
        raise UnitError(f"{text!r} is not a unit: {reason}") from None


def shortened(value: Any, longest: int = 60) -> str:
    """A value as text for a message."""
    try:
        text = repr(value[: 2 * longest] if isinstance(value, (str, list, tuple)) else value)
    except (ValueError, RecursionError):  # Python writes no whole number of thousands of digits
        return "a value too large to be shown"
    return text if len(text) <= longest else f"{text[: longest - 3]}..."


def to_si(value: float | int | str, unit: str) -> float:
    """Read one quantity.

    Parameters
    ----------
    value
        A number in the SI unit ``unit``, or a string such as ``"1200 rpm"``.
    unit
        The SI unit the caller wants, e.g. ``"kg"`` or ``"rad/s"``. It fixes the dimension.

    Returns
    -------
    float
        The value in ``unit``; a :class:`Given` if it was a string.

    Raises
    ------
    UnitError
        If it is not a finite number, has no unit, or has one of another dimension.
    """
    if isinstance(value, Given):
        return read_text(value.text, unit)
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        allowed = f"in {unit} or a string with a unit, such as {sample(unit)}" if unit else 'such as 0.02 or "2 %"'
        raise UnitError(f"given {shortened(value)}; write a number {allowed}")
    if isinstance(value, str):
        return read_text(value, unit)
    number = float(value) if abs(value) <= sys.float_info.max else math.inf
    if not math.isfinite(number):
        raise UnitError(f"given {shortened(value)}, which is not a finite number")
    return number


@lru_cache(maxsize=4096)
def read_text(value: str, unit: str) -> Given:
    """A text as a quantity in the SI ``unit``, as :func:`to_si`."""
    if len(value) > LONGEST:
        raise UnitError(f"given {shortened(value)} of {len(value)} characters; write for example {sample(unit)}")
    match = _NUMBER.match(value)
    if match is None:
        raise UnitError(
            f"given {shortened(value)}, which does not start with a finite number; write for example {sample(unit)}"
        )
    number, written = float(match[1]), match[2].strip()
    if written.startswith(","):
        raise UnitError(f"given {value!r}; write a decimal point, not a comma: {value.replace(',', '.')!r}")
    if ":" in written or _SECOND.search(written):
        raise UnitError(f"given {value!r}; one quantity is wanted here, such as {sample(unit)}")
    if not written and unit not in ("", "rad"):
        raise UnitError(
            f"given {value!r} without a unit; give one, such as {sample(unit)} (a number without quotes is in {unit})"
        )
    known = common(number, written, unit)
    si = _converted(value, number, written, unit) if known is None else known
    si = float(f"{si:.15g}")  # no 1.9999999999999998e-05 from the conversion
    if not math.isfinite(si):
        raise UnitError(f"given {value!r}, which is not a finite number")
    return Given(value, si)


def _converted(value: str, number: float, written: str, unit: str) -> float:
    """A number in any unit of the library, in the SI ``unit``; infinite where that is too large."""
    source = _unit(written) if written else _unit(unit)
    target = _unit(unit)
    if source.dimensionality != target.dimensionality:
        raise UnitError(
            f"given {value!r}, but a quantity in {unit} is wanted here, such as {sample(unit)}"
            if unit
            else f'given {value!r}, but a number without a unit is wanted here, such as 0.02 or "2 %"'
        )
    try:
        return float(_registry().Quantity(number, source).to(target).magnitude)
    except (ArithmeticError, ValueError):
        return math.inf


def from_si(value: float, si_unit: str, unit: str) -> float:
    """Convert a number from ``si_unit`` to ``unit``: ``from_si(125.66, "rad/s", "rpm")`` is 1200."""
    return float(_registry().Quantity(value, _unit(si_unit)).to(_unit(unit)).magnitude)


_SAMPLES = {
    "": "0.02",
    "kg": "4.4 g",
    "m": "77 mm",
    "rad": "30 deg",
    "rad/s": "1200 rpm",
    "rad/s^2": "0.8 rad/s^2",
    "s": "10 s",
    "N/m": "44.7 kN/m",
    "N*s/m": "68 N*s/m",
    "N*m*s": "1e-4 N*m*s",
    "N*m": "1.5 N*m",
    "kg*m": "594 g*mm",
    "kg*m^2": "50 g*m^2",
    "kg/m^3": "7.8 g/cm^3",
    "m^2/s": "20 mm^2/s",
    "K": "25 degC",
    "m/s": "1 mm/s",
}


def sample(unit: str) -> str:
    """A quantity as one writes it, for messages: ``"1200 rpm"`` for rad/s."""
    return f'"{_SAMPLES[unit]}"' if unit in _SAMPLES else f'"1 {unit}"'


def option_to_si(text: str, unit: str) -> Given:
    """Read a quantity from the command line, where a number needs its unit; only zero is the same in all of them.

    Raises
    ------
    UnitError
        As :func:`to_si`; also for a number without a unit, where there is one.
    """
    match = _NUMBER.match(text)
    if unit and match is not None and not match[2].strip():
        if float(match[1]) == 0.0 and unit != "K":
            return Given(text.strip(), 0.0)
        raise UnitError(f"given {shortened(text)} without a unit; write it with one, such as {samples_of(unit)}")
    return read_text(text, unit)


def samples_of(unit: str) -> str:
    """Quantities as one writes them, for messages: ``"1200 rpm" or "126 rad/s"``."""
    return f'{sample(unit)} or "126 rad/s"' if unit == "rad/s" else sample(unit)
