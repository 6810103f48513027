"""Quantities and ranges as one writes them on the command line: every number with its unit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from autobalancer.errors import AutobalancerError, QuestionError, UnitError

if TYPE_CHECKING:
    import numpy as np

MOST = 1_000_000  # values along one axis
FORM = "from:to:count"


def quantity(option: str, text: str, unit: str) -> float:
    """One quantity in the SI ``unit``; a fault names the option."""
    from autobalancer.units import option_to_si

    try:
        return option_to_si(text, unit)
    except UnitError as reason:
        raise UnitError(f"{option}: {reason}") from None


def optional(option: str, text: str, unit: str) -> float | None:
    """The same, or ``None`` where nothing was given."""
    return quantity(option, text, unit) if text else None


def speed_range(option: str, text: str, count: int | None = None) -> np.ndarray:
    """``"500 rpm:3000 rpm:200"`` (from, to, count) or one speed, in rad/s; the speeds ascend from above zero.

    ``count`` is taken where the text gives none.
    """
    import numpy as np

    if count is not None and text.count(":") == 1:
        text = f"{text}:{count}"
    speeds = values(option, text, "rad/s") if ":" in text else np.array([_one_or_range(option, text)])
    if not speeds[0] > 0.0 or np.any(np.diff(speeds) <= 0.0):
        raise QuestionError(f"{option}: given {text!r}; must ascend from above zero")
    return speeds


def values(option: str, text: str, unit: str) -> np.ndarray:
    """``"1 mm^2/s:100 mm^2/s:200"`` (from, to, count), SI; ``:log`` at the end makes the steps equal ratios.

    A unit may stand with one of the ends only: ``"1:100 mm^2/s:200"``.
    """
    import numpy as np

    ends, count, log = _parts(option, text, unit)
    low, high = (quantity(option, end, unit) for end in ends)
    if log and not (low > 0.0 and high > 0.0):
        raise QuestionError(f"{option}: given {text!r}; equal ratios need ends above zero")
    return np.geomspace(low, high, count) if log else np.linspace(low, high, count)


def listed(option: str, text: str, unit: str) -> list[float]:
    """``"4,6,8 m/s"``, SI: values with commas between, the unit once at the end; or a range as for :func:`values`."""
    if ":" in text:
        return [float(value) for value in values(option, text, unit)]
    *others, last = (part.strip() for part in text.split(","))
    parts = [with_common_unit([part, last])[0] for part in others] if unit else others
    return [quantity(option, part, unit) for part in (*parts, last)]


def whole(option: str, text: str) -> list[int]:
    """``"3,5,8"``: whole numbers from 1 on."""
    found = listed(option, text, "")
    if any(value != round(value) or value < 1 for value in found):
        raise QuestionError(f"{option}: given {text!r}; must be whole numbers from 1 on, with commas between")
    return [round(value) for value in found]


def interval(option: str, text: str, unit: str) -> tuple[float, float]:
    """``"500 rpm:3000 rpm"`` (from, to), SI."""
    parts = [part.strip() for part in text.split(":")]
    if len(parts) != 2:
        raise QuestionError(f"{option}: given {text!r}; write it as from:to, such as {example(unit)}")
    low, high = (quantity(option, part, unit) for part in with_common_unit(parts))
    return low, high


def named(option: str, text: str, form: str = FORM) -> tuple[str, str]:
    """``"viscosity=1 mm^2/s:100 mm^2/s:200"`` as name and range; the range is empty where only a name was given."""
    name, mark, span = text.partition("=")
    if not name.strip() or (mark and not span.strip()):
        raise QuestionError(f'{option}: given {text!r}; write it as NAME={form}, such as "speed={_sample(form)}"')
    return name.strip(), span.strip()


def parameter_values(option: str, text: str, machine: Any) -> tuple[str, np.ndarray]:
    """``"viscosity=1 mm^2/s:100 mm^2/s:200"`` as name and values, SI; whole numbers for a count."""
    import numpy as np

    name, span = named(option, text)
    if not span:
        raise QuestionError(f'{option}: given {text!r}; write it as NAME={FORM}, such as "speed={_sample(FORM)}"')
    found = values(option, span, unit_of(option, name, machine))
    return name, np.arange(round(found[0]), round(found[-1]) + 1) if name == "count" else found


def unit_of(option: str, name: str, machine: Any) -> str:
    """The SI unit of a named quantity or of a path of this machine, empty where there is none."""
    from autobalancer.assembly.quantities import parameter_unit

    try:
        return parameter_unit(machine, name)
    except AutobalancerError as reason:
        raise QuestionError(f"{option}: {reason}") from None


def with_common_unit(parts: list[str]) -> list[str]:
    """The only unit of two ends for both of them."""
    units = [part.lstrip("+-.0123456789eE ") for part in parts]
    common = next((unit for unit in units if unit), "")
    return [part if unit or not common else f"{part} {common}" for part, unit in zip(parts, units, strict=True)]


def example(unit: str, form: str = "from:to") -> str:
    """A range as one writes it: ``"500 rpm:3000 rpm"``."""
    from autobalancer.units import sample

    if unit == "rad/s":
        return f'"{_sample(form)}"'
    one = sample(unit).strip('"')
    return f'"{one}:{one}{"" if form == "from:to" else ":200"}"'


def _sample(form: str) -> str:
    return "500 rpm:3000 rpm" + ("" if form == "from:to" else ":200")


def _parts(option: str, text: str, unit: str) -> tuple[list[str], int, bool]:
    parts = [part.strip() for part in text.split(":")]
    log = len(parts) == 4 and parts[3] == "log"
    if not (len(parts) == 3 or log) or not parts[2].isdigit() or not 1 <= int(parts[2]) <= MOST:
        if len(parts) == 2 and all(parts):
            raise QuestionError(
                f'{option}: given {text!r}, without the number of values; write it as "{FORM}", such as "{text}:200"'
            )
        raise QuestionError(
            f'{option}: given {text!r}; write it as "{FORM}" or "{FORM}:log", such as {example(unit, FORM)}'
        )
    return with_common_unit(parts[:2]), int(parts[2]), log


def _one_or_range(option: str, text: str) -> float:
    try:
        return quantity(option, text, "rad/s")
    except UnitError as reason:
        raise UnitError(f"{reason}; a range is written as {FORM}: {example('rad/s', FORM)}") from None
