"""The options that commands share, each in one place: a new command takes them by name."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from autobalancer.cli.terminal.sheet import use_speed_unit
from autobalancer.errors import AutobalancerError, QuestionError, UnitError

if TYPE_CHECKING:
    import numpy as np


class SpeedUnit(StrEnum):
    """How speeds are shown."""

    RPM = "rpm"
    RAD = "rad/s"
    HZ = "Hz"


MachineFile = Annotated[Path, typer.Argument(help="Machine file.")]
Outs = Annotated[
    list[Path] | None,
    typer.Option("--out", help="Result file: .nc, or a table as .csv or .json. May be repeated."),
]
Plot = Annotated[Path | None, typer.Option(help="Picture: .png, .svg or .pdf.")]
Unit = Annotated[
    SpeedUnit,
    typer.Option("--speed-unit", case_sensitive=False, callback=use_speed_unit, help="Unit in which speeds are shown."),
]
FrequencyUnit = Annotated[
    SpeedUnit, typer.Option("--frequency-unit", case_sensitive=False, help="Unit in which frequencies are shown.")
]
Seed = Annotated[int, typer.Option(help="Chooses among the random numbers; equal seeds, equal results.")]
Settling = Annotated[
    str, typer.Option("--settling-from", help="From where settling times count: the end of the run-up, or release.")
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON in SI units.")]
Csv = Annotated[bool, typer.Option("--csv", help="Print the table as CSV, with units in its first line.")]


# Quantities and ranges as one writes them on the command line: every number with its unit.


FORM = "from:to:count"


class Reader:
    """How the text of an option becomes a value: a mark in the annotation of the option."""

    def read(self, option: str, text: str) -> Any:
        """The value; a fault names the option."""
        raise NotImplementedError


@dataclass(frozen=True)
class In(Reader):
    """One quantity in an SI unit; an empty text is none."""

    unit: str

    def read(self, option: str, text: str) -> float | None:
        """The value; a fault names the option."""
        return optional(option, text, self.unit)


COUNT = 401  # speeds of a curve whose range gives no count


@dataclass(frozen=True)
class Speeds(Reader):
    """A range of speeds, or one speed; ``count`` of them where the text has no number."""

    count: int | None = None

    def read(self, option: str, text: str) -> Any:
        """The values; a fault names the option."""
        return speed_range(option, text, self.count) if text else None


@dataclass(frozen=True)
class Ranged(Reader):
    """A range with the number of its values, in an SI unit."""

    unit: str

    def read(self, option: str, text: str) -> Any:
        """The values; a fault names the option."""
        from autobalancer.units.quantity import range_values

        return range_values(option, text, self.unit)


@dataclass(frozen=True)
class Ends(Reader):
    """Both ends of a range, in an SI unit."""

    unit: str

    def read(self, option: str, text: str) -> Any:
        """The values; a fault names the option."""
        from autobalancer.units.quantity import ends

        return ends(option, text, self.unit)


@dataclass(frozen=True)
class Listed(Reader):
    """Quantities with commas between, or a range of them, in an SI unit."""

    unit: str

    def read(self, option: str, text: str) -> Any:
        """The values; a fault names the option."""
        from autobalancer.units.quantity import listed

        return listed(option, text, self.unit)


def quantity(option: str, text: str, unit: str) -> float:
    """One quantity in the SI ``unit``; a fault names the option."""
    from autobalancer.units.quantity import written

    return written(option, text, unit)


def optional(option: str, text: str, unit: str) -> float | None:
    """The same, or ``None`` where nothing was given."""
    return quantity(option, text, unit) if text else None


def speed_range(option: str, text: str, count: int | None = None) -> np.ndarray:
    """``"500 rpm:3000 rpm:200"`` (from, to, count) or one speed, in rad/s; the speeds ascend from above zero.

    ``count`` is taken where the text gives none.
    """
    import numpy as np

    from autobalancer.units.quantity import is_range, range_values

    full = f"{text}:{count}" if count is not None and text.count(":") == 1 else text
    speeds = range_values(option, full, "rad/s") if is_range(full) else np.array([_one_or_range(option, full)])
    if not speeds[0] > 0.0 or np.any(np.diff(speeds) <= 0.0):
        raise QuestionError(f"{option}: given {text!r}; must ascend from above zero")
    return speeds


def named_range(option: str, text: str, form: str = FORM) -> tuple[str, str]:
    """``"viscosity=1 mm^2/s:100 mm^2/s:200"`` as name and range; the range is empty where only a name was given."""
    name, mark, span = text.partition("=")
    if not name.strip() or (mark and not span.strip()):
        raise QuestionError(f"{option}: given {text!r}; write it as NAME={form}, such as {_sample(form)}")
    return name.strip(), span.strip()


def parameter_values(option: str, text: str, machine: Any) -> tuple[str, np.ndarray]:
    """``"viscosity=1 mm^2/s:100 mm^2/s:200"`` as name and values, SI; whole numbers for a count."""
    from autobalancer.assembly.quantities import parameter_range

    name, span = named_range(option, text)
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
    from autobalancer.units.quantity import example

    return f'"speed={example("rad/s", form)[1:]}'


def _one_or_range(option: str, text: str) -> float:
    from autobalancer.units.quantity import example

    try:
        return quantity(option, text, "rad/s")
    except UnitError as reason:
        raise UnitError(f"{reason}; a range is written as {FORM}: {example('rad/s', FORM)}") from None
