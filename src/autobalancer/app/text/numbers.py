"""The numbers of a machine that may be varied or fitted, with their values as its text has them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from autobalancer.app.text.document import data_of, value_at, with_value
from autobalancer.app.text.fields import in_unit, number_and_unit, written
from autobalancer.assembly.parameters import parameter_of, with_value_at
from autobalancer.errors import AutobalancerError
from autobalancer.files.machine_file import machine_text, parse_machine
from autobalancer.machine import Machine
from autobalancer.machine.part import Part
from autobalancer.machine.path import label_of_path, path_steps, unit_at

LEFT_OUT = ("run.", "start.")  # what is no quantity of the machine
USUAL = {"rad": "deg", "rad/s": "rpm", "kg*m": "g*mm", "m": "mm", "m^2/s": "mm^2/s"}


@dataclass(frozen=True)
class Number:
    """One number of a machine."""

    path: str
    label: str
    value: float  # SI
    number: str  # as it is written, or as a person would write it
    unit: str
    in_text: bool

    @property
    def given(self) -> str:
        """With its unit."""
        return f"{self.number} {self.unit}".strip()

    def around(self) -> tuple[str, str]:
        """Bounds about it for a search: half to double; of an angle half a turn to either side."""
        if unit_at(self.path) == "rad":
            half, middle = (180.0, float(self.number)) if self.unit == "deg" else (math.pi, self.value)
            unit = self.unit if self.unit == "deg" else "rad"
            return f"{middle - half:.6g} {unit}", f"{middle + half:.6g} {unit}"
        ends = sorted((0.5 * float(self.number), 2.0 * float(self.number)))
        if self.value == 0.0:
            return "", ""
        return f"{ends[0]:.6g} {self.unit}".strip(), f"{ends[1]:.6g} {self.unit}".strip()


def numbers_of(text: str, machine: Machine) -> list[Number]:
    """All numbers with a value, those of the text first; whole numbers, such as a count of balls, are not among them."""
    data = data_of(text) or {}
    found = [_number(path, data, machine) for path in _paths(machine, "") if not path.startswith(LEFT_OUT)]
    known = [one for one in found if one is not None]
    return sorted(known, key=lambda one: not one.in_text)


def with_numbers(text: str, fitted: Machine, paths: list[str]) -> str:
    """The text with the numbers that ``fitted`` has at these paths; comments and units stay.

    Where the text has another machine than the one that was fitted, it is the text of the fitted one.
    """
    edited = text
    try:
        for path in paths:
            value, steps = parameter_of(fitted, path), tuple(path_steps(path))
            unit = unit_at(path)
            held = number_and_unit(value_at(data_of(edited), steps), unit)
            wanted = held[1] if held else USUAL.get(unit, unit)
            number = in_unit(f"{value:.12g}", unit, wanted, unit)
            edited = with_value(edited, steps, written(f"{float(number):.8g}", wanted, unit))
        same: Any = parse_machine(edited, "machine")
        for path in paths:
            same = with_value_at(same, path, parameter_of(fitted, path))
    except (AutobalancerError, KeyError, TypeError, IndexError):
        return machine_text(fitted)
    said = {"description": ""}
    return edited if same.model_copy(update=said) == fitted.model_copy(update=said) else machine_text(fitted)


def _paths(owner: Any, start: str) -> Iterator[str]:
    """Paths of all numbers; entries are counted from 1, and lists of more than three numbers are left out."""
    if isinstance(owner, Part):
        for key in type(owner).model_fields:
            yield from _paths(getattr(owner, key), f"{start}.{key}".lstrip("."))
    elif isinstance(owner, tuple):
        if len(owner) <= 3 or any(isinstance(entry, Part) for entry in owner):
            for number, entry in enumerate(owner, start=1):
                yield from _paths(entry, f"{start}[{number}]")
    elif isinstance(owner, float) and math.isfinite(owner):
        yield start


def _number(path: str, data: Any, machine: Machine) -> Number | None:
    try:
        value, unit = parameter_of(machine, path), unit_at(path)
    except AutobalancerError:
        return None
    held = number_and_unit(value_at(data, tuple(path_steps(path))), unit)
    if held is None:
        usual = USUAL.get(unit, unit)
        held = in_unit(f"{value:.12g}", unit, usual, unit), usual
    elif held[1] != unit and in_unit(held[0], held[1], unit, unit) == held[0] and float(held[0]) != value:
        held = f"{value:.12g}", unit  # written in a unit that is not a usual one
    there = value_at(data, tuple(path_steps(path))) is not None
    return Number(path, label_of_path(path), value, held[0], held[1], there)
