"""Arguments of functions as people write them: a number in SI, a text with a unit, or a range as one text."""

from __future__ import annotations

from typing import Any, TypeVar

from autobalancer.errors import UnitError
from autobalancer.units.quantity import read_text, sample, shortened
from autobalancer.units.ranges import ends, is_range, range_values

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
