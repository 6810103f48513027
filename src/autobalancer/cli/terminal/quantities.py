"""Quantities and ranges as one writes them on the command line: every number with its unit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from autobalancer.errors import AutobalancerError, QuestionError, UnitError

if TYPE_CHECKING:
    import numpy as np

FORM = "from:to:count"


def quantity(option: str, text: str, unit: str) -> float:
    """One quantity in the SI ``unit``; a fault names the option."""
    from autobalancer.units.ranges import written

    return written(option, text, unit)


def optional(option: str, text: str, unit: str) -> float | None:
    """The same, or ``None`` where nothing was given."""
    return quantity(option, text, unit) if text else None


def speed_range(option: str, text: str, count: int | None = None) -> np.ndarray:
    """``"500 rpm:3000 rpm:200"`` (from, to, count) or one speed, in rad/s; the speeds ascend from above zero.

    ``count`` is taken where the text gives none.
    """
    import numpy as np

    from autobalancer.units.ranges import is_range, range_values

    full = f"{text}:{count}" if count is not None and text.count(":") == 1 else text
    speeds = range_values(option, full, "rad/s") if is_range(full) else np.array([_one_or_range(option, full)])
    if not speeds[0] > 0.0 or np.any(np.diff(speeds) <= 0.0):
        raise QuestionError(f"{option}: given {text!r}; must ascend from above zero")
    return speeds


def named(option: str, text: str, form: str = FORM) -> tuple[str, str]:
    """``"viscosity=1 mm^2/s:100 mm^2/s:200"`` as name and range; the range is empty where only a name was given."""
    name, mark, span = text.partition("=")
    if not name.strip() or (mark and not span.strip()):
        raise QuestionError(f"{option}: given {text!r}; write it as NAME={form}, such as {_sample(form)}")
    return name.strip(), span.strip()


def parameter_values(option: str, text: str, machine: Any) -> tuple[str, np.ndarray]:
    """``"viscosity=1 mm^2/s:100 mm^2/s:200"`` as name and values, SI; whole numbers for a count."""
    from autobalancer.assembly.quantities import parameter_range

    name, span = named(option, text)
    if not span:
        raise QuestionError(f"{option}: given {text!r}; write it as NAME={FORM}, such as {_sample(FORM)}")
    unit_of(option, name, machine)
    return name, parameter_range(machine, name, span, option)


def unit_of(option: str, name: str, machine: Any) -> str:
    """The SI unit of a named quantity or of a path of this machine, empty where there is none."""
    from autobalancer.assembly.quantities import parameter_unit

    try:
        return parameter_unit(machine, name)
    except AutobalancerError as reason:
        raise QuestionError(f"{option}: {reason}") from None


def _sample(form: str) -> str:
    from autobalancer.units.ranges import example

    return f'"speed={example("rad/s", form)[1:]}'


def _one_or_range(option: str, text: str) -> float:
    from autobalancer.units.ranges import example

    try:
        return quantity(option, text, "rad/s")
    except UnitError as reason:
        raise UnitError(f"{reason}; a range is written as {FORM}: {example('rad/s', FORM)}") from None
