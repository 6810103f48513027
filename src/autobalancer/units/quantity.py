"""One quantity: a number in SI, or a text with a unit."""

from __future__ import annotations

import math
import re
import sys
from functools import lru_cache
from typing import TYPE_CHECKING, Any, TypeVar

from autobalancer.errors import QuestionError, UnitError
from autobalancer.units.trade import SUFFIXES, added, confused, factor, lacks_turns, similar_unit, without_suffix

if TYPE_CHECKING:
    import numpy as np


LONGEST = 80  # characters of a quantity; a sensible one has 30 at most
NUMBER = re.compile(r"^\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*)$")

_GROUPS = re.compile(r"\s*([+-]?\d+(?:[.,'\u2019_]\d+|[ \xa0\u2009\u202f]\d{3}(?![\d.]))+)(?![\d/])")
_SECOND = re.compile(r"(?:^|\s)[+-]?(?!1/)\d")  # a number within the unit: a range, or two quantities


class WrittenFloat(float):
    """A float in SI that remembers how it was written.

    ``Given("4.4 g", 0.0044)`` equals ``0.0044`` in every calculation; ``.text`` is ``"4.4 g"``.
    """

    text: str

    def __new__(cls, text: str, value: float) -> WrittenFloat:
        self = super().__new__(cls, value)
        self.text = text
        return self

    def __getnewargs__(self) -> tuple[str, float]:  # type: ignore[override]
        return self.text, float(self)

    def __deepcopy__(self, memo: dict[int, Any]) -> WrittenFloat:
        return self


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
        The value in ``unit``; a :class:`WrittenFloat` if it was a string.

    Raises
    ------
    UnitError
        If it is not a finite number, has no unit, or has one of another dimension.
    """
    if isinstance(value, WrittenFloat):
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
def read_text(value: str, unit: str, amplitude: bool = False) -> WrittenFloat:
    """A text as a quantity in the SI ``unit``, as :func:`to_si`.

    Of the ``amplitude`` of a sinusoid a value from peak to peak or an rms value becomes its peak; elsewhere both are refused.
    """
    if len(value) > LONGEST:
        raise UnitError(f"given {shortened(value)} of {len(value)} characters; write for example {sample(unit)}")
    match = NUMBER.match(value)
    if match is None:
        raise UnitError(
            f"given {shortened(value)}, which does not start with a finite number; write for example {sample(unit)}"
        )
    number, (written, suffix) = float(match[1]), without_suffix(match[2].strip())
    if plain := _without_groups(value):
        raise UnitError(f"given {value!r}; {plain}")
    if ":" in written or _SECOND.search(written):
        raise UnitError(f"given {value!r}; one quantity is wanted here, such as {sample(unit)}")
    if not written and unit and (number != 0.0 or unit == "K"):
        raise UnitError(
            f"given {value!r} without a unit; give one, such as {sample(unit)} (a number without quotes is in {unit})"
        )
    scale, zero = conversion(written, unit, value) if written else (1.0, 0.0)
    if suffix and not amplitude:
        peak = f"{number * SUFFIXES[suffix][0]:.6g} {written}"
        raise UnitError(
            f"given {value!r}; no {suffix} value is wanted here. Leave the word away, or write the peak of the sinusoid: {peak!r}"
        )
    peaks = SUFFIXES[suffix][0] if suffix else 1.0
    si = float(f"{number * scale * peaks + zero:.15g}")  # no 1.9999999999999998e-05 from the conversion
    if not math.isfinite(si):
        raise UnitError(f"given {value!r}, which is not a finite number")
    return WrittenFloat(value, si)


def conversion(written: str, unit: str, value: str = "") -> tuple[float, float]:
    """Factor, and what is then added, that bring a number in a ``written`` unit to the SI ``unit``.

    Raises
    ------
    UnitError
        If it is no unit, or one of another dimension; the message quotes ``value``, by default the unit.
    """
    conversion = factor(written, unit)
    if conversion is not None:
        return conversion, added(written)
    value = value or written
    if lacks_turns(written, unit) and unit in _TURNING:
        raise UnitError(f"given {value!r}; turns or radians a second? Write {_TURNING[unit]}")
    kind, samples = (f"quantity in {unit}", sample(unit)) if unit else ("number without a unit", '0.02 or "2 %"')
    near = similar_unit(written, unit)
    hint = f"did you mean {near}?" if near else confused(written, unit)
    raise UnitError("; ".join(filter(None, (f"given {value!r}, but a {kind} is wanted here, such as {samples}", hint))))


def column_factor(written: str, unit: str, amplitude: bool = False) -> tuple[float, float]:
    """The same of the unit in the head of a column, where the suffix of an ``amplitude`` counts.

    Raises
    ------
    UnitError
        Also if there is no unit, or a suffix of a column that is no amplitude.
    """
    plain, suffix = without_suffix(written)
    if suffix and not amplitude:
        raise UnitError(
            f"{written!r} is a {suffix} value, which neither samples nor other quantities are; leave {suffix!r} away if they are "
            "samples, or give the column of the waveform"
        )
    if not plain and unit:
        raise UnitError(f"no unit; give one, such as that of {sample(unit)}")
    scale, zero = conversion(plain, unit) if plain else (1.0, 0.0)
    return (SUFFIXES[suffix][0] if suffix else 1.0) * scale, zero


def _without_groups(value: str) -> str:
    """What to write in place of a number with thousands in groups or a decimal comma; empty where it has neither."""
    match = _GROUPS.match(value)
    if match is None:
        return ""
    first, *groups = re.split(r"[^\d+-]", match[1])
    marks = re.findall(r"[^\d+-]", match[1])
    rest = value[match.end(1) :]
    decimal = marks[-1] in ",." and (len(marks) == 1 or marks[-1] != marks[-2])
    if decimal and len(marks) == 1 and marks[0] == ".":
        return ""
    if any(len(group) != 3 for group in (groups[:-1] if decimal else groups)):
        return "" if marks[0] == "." else "one quantity is wanted here, without commas or spaces within the number"
    point = f"{first}{''.join(groups[:-1])}.{groups[-1]}{rest}".strip()
    whole = f"{first}{''.join(groups)}{rest}".strip()
    if not decimal:
        return f"write the number without groups: {whole!r}"
    if len(marks) > 1:
        return f"write a decimal point and no groups: {point!r}"
    if len(groups[0]) == 3:
        return f"is the comma a decimal mark or one of thousands? Write {point!r} or {whole!r}"
    return f"write a decimal point, not a comma: {point!r}"


def from_si(value: float, si_unit: str, unit: str) -> float:
    """Convert a number from ``si_unit`` to ``unit``: ``from_si(125.66, "rad/s", "rpm")`` is 1200."""
    scale, zero = conversion(unit, si_unit)
    return (value - zero) / scale


_TURNING = {
    "rad/s": "Hz (or rps) for turns, rad/s for radians",
    "rad/s^2": "Hz/s (or rpm/s) for turns, rad/s^2 for radians",
}
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


def option_to_si(text: str, unit: str) -> WrittenFloat:
    """Read a quantity from the command line, where a number needs its unit; only zero is the same in all of them.

    Raises
    ------
    UnitError
        As :func:`to_si`; also for a number without a unit, where there is one.
    """
    match = NUMBER.match(text)
    if unit and match is not None and not match[2].strip():
        if float(match[1]) == 0.0 and unit != "K":
            return WrittenFloat(text.strip(), 0.0)
        raise UnitError(f"given {shortened(text)} without a unit; write it with one, such as {samples_of(unit)}")
    return read_text(text, unit)


def samples_of(unit: str) -> str:
    """Quantities as one writes them, for messages: ``"1200 rpm" or "126 rad/s"``."""
    return f'{sample(unit)} or "126 rad/s"' if unit == "rad/s" else sample(unit)


# Arguments of functions as people write them: a number in SI, a text with a unit, or a range as one text.


T = TypeVar("T")


def argument(name: str, value: Any, unit: str, amplitude: bool = False) -> float:
    """An argument of a function in SI: a number in the SI unit ``unit`` or a text with a unit.

    Numbers pass as they are; whether they make sense is for the function to say. The text of an ``amplitude`` may be a value
    from peak to peak or an rms value of a sinusoid, such as ``"4 mil pp"``.

    Raises
    ------
    UnitError
        If it is neither, or the text is no such quantity; the message names the argument.
    """
    if isinstance(value, str):
        try:
            return float(read_text(value, unit, amplitude))
        except UnitError as error:
            raise UnitError(f"{name}: {error}") from None
    if isinstance(value, bool) or not hasattr(value, "__float__") or getattr(value, "ndim", None):
        kind = f"a number in {unit}" if unit else "a number"
        raise UnitError(f"{name}: given {shortened(value)}; give {kind} or a text such as {sample(unit)}")
    try:
        return float(value)
    except OverflowError:
        raise UnitError(f"{name}: given {shortened(value)}; no number of a machine is that great") from None


def optional_argument(name: str, value: Any, unit: str) -> float | None:
    """The same of an argument that may be left out."""
    return None if value is None else argument(name, value, unit)


def list_argument(name: str, values: Any, unit: str) -> list[float]:
    """The same of several quantities; one alone is a list of one, a text may be a range such as ``"500:3000 rpm:200"``."""
    if is_range(values):
        return [float(value) for value in range_values(name, values, unit)]
    if isinstance(values, str) or not hasattr(values, "__iter__"):
        values = [values]
    return [argument(f"{name}[{number}]", value, unit) for number, value in enumerate(values, start=1)]


def texts_argument(name: str, values: Any, unit: str) -> Any:
    """One quantity or many, of which texts are read; arrays and numbers pass as they are."""
    if is_range(values):
        return range_values(name, values, unit)
    if isinstance(values, str):
        return argument(name, values, unit)
    if isinstance(values, (list, tuple)) and any(isinstance(value, str) for value in values):
        return list_argument(name, values, unit)
    return values


def ends_argument(name: str, values: Any, unit: str) -> tuple[float, float]:
    """Both ends of a range, as a pair or as one text such as ``"10:200 Hz"``."""
    if is_range(values):
        return ends(name, values, unit)
    low, high = list_argument(name, values, unit)
    return low, high


def unbalance_argument(value: T | str) -> T | float:
    """An unbalance in kg m, of which a text is read; complex numbers and descriptions pass."""
    return argument("unbalance", value, "kg*m") if isinstance(value, str) else value


def field_arguments(record: Any, **units: str) -> None:
    """Read the texts among the fields of a frozen record, each in its unit."""
    for name, unit in units.items():
        object.__setattr__(record, name, argument(name, getattr(record, name), unit))


# Ranges and lists as one text, on the command line and in Python: ``"500 rpm:3000 rpm:200"``, ``"4,6,8 m/s"``.
#
# ``name`` is the argument or option that a message names.


MOST = 1_000_000  # values along one axis
COUNT = re.compile(r"[0-9]{1,9}")
FORM = "from:to:count"


def is_range(value: Any) -> bool:
    """Whether it is a text with a range."""
    return isinstance(value, str) and ":" in value


def written(name: str, text: str, unit: str) -> float:
    """One quantity in the SI ``unit``, written with a unit if there is one; a fault names the argument."""
    try:
        return option_to_si(text, unit)
    except UnitError as reason:
        raise UnitError(f"{name}: {reason}") from None


def range_values(name: str, text: str, unit: str) -> np.ndarray:
    """``"1 mm^2/s:100 mm^2/s:200"`` (from, to, count), SI; ``:log`` at the end makes the steps equal ratios.

    A unit may stand with one of the ends only: ``"1:100 mm^2/s:200"``.

    Raises
    ------
    QuestionError
        If it is no such range.
    UnitError
        If an end is no quantity in this unit.
    """
    import numpy as np

    ends, count, log = _parts(name, text, unit)
    low, high = (written(name, end, unit) for end in ends)
    if log and not (low > 0.0 and high > 0.0):
        raise QuestionError(f"{name}: given {text!r}; equal ratios need ends above zero")
    return np.geomspace(low, high, count) if log else np.linspace(low, high, count)


def listed(name: str, text: str, unit: str) -> list[float]:
    """``"4,6,8 m/s"``, SI: values with commas between, the unit once at the end; or a range as :func:`range_values`."""
    if is_range(text):
        return [float(value) for value in range_values(name, text, unit)]
    *others, last = (part.strip() for part in text.split(","))
    parts = [with_common_unit([part, last])[0] for part in others] if unit else others
    return [written(name, part, unit) for part in (*parts, last)]


def whole_numbers(name: str, text: str) -> list[int]:
    """``"3,5,8"``: whole numbers from 1 on."""
    quantity = listed(name, text, "")
    if any(value != round(value) or value < 1 for value in quantity):
        raise QuestionError(f"{name}: given {text!r}; must be whole numbers from 1 on, with commas between")
    return [round(value) for value in quantity]


def ends(name: str, text: str, unit: str) -> tuple[float, float]:
    """``"500 rpm:3000 rpm"`` (from, to), SI."""
    parts = [part.strip() for part in text.split(":")]
    if len(parts) != 2:
        raise QuestionError(f"{name}: given {text!r}; write it as from:to, such as {example(unit)}")
    low, high = (written(name, part, unit) for part in with_common_unit(parts))
    return low, high


def with_common_unit(parts: list[str]) -> list[str]:
    """The only unit of two ends for both of them."""
    units = [match[2].strip() if (match := NUMBER.match(part)) else part for part in parts]
    common = next((unit for unit in units if unit), "")
    return [part if unit or not common else f"{part} {common}" for part, unit in zip(parts, units, strict=True)]


def example(unit: str, form: str = "from:to") -> str:
    """A range as one writes it: ``"500 rpm:3000 rpm"``."""
    number, space, sign = sample(unit).strip('"').partition(" ")
    both = "500 rpm:3000 rpm" if unit == "rad/s" else f"{number}{space}{sign}:{10.0 * float(number):g}{space}{sign}"
    return f'"{both}{"" if form == "from:to" else ":200"}"'


def _parts(name: str, text: str, unit: str) -> tuple[list[str], int, bool]:
    parts = [part.strip() for part in text.split(":")]
    log = len(parts) == 4 and parts[3] == "log"
    if not (len(parts) == 3 or log) or not COUNT.fullmatch(parts[2]) or not 1 <= int(parts[2]) <= MOST:
        if len(parts) == 2 and all(parts):
            raise QuestionError(
                f'{name}: given {text!r}, without the number of values; write it as "{FORM}", such as "{text}:200"'
            )
        raise QuestionError(
            f'{name}: given {shortened(text)}; write it as "{FORM}" or "{FORM}:log", such as {example(unit, FORM)}'
        )
    return with_common_unit(parts[:2]), int(parts[2]), log
