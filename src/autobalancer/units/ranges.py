"""Ranges and lists as one text, on the command line and in Python: ``"500 rpm:3000 rpm:200"``, ``"4,6,8 m/s"``.

``name`` is the argument or option that a message names.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from autobalancer.errors import QuestionError, UnitError
from autobalancer.units.quantity import NUMBER, option_to_si, sample, shortened

if TYPE_CHECKING:
    import numpy as np

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


def whole(name: str, text: str) -> list[int]:
    """``"3,5,8"``: whole numbers from 1 on."""
    found = listed(name, text, "")
    if any(value != round(value) or value < 1 for value in found):
        raise QuestionError(f"{name}: given {text!r}; must be whole numbers from 1 on, with commas between")
    return [round(value) for value in found]


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
