"""A machine made of another one, in the words of its author: the units, and a critical speed in place of a stiffness."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import Any, TypeVar

from autobalancer.assembly.system import total_mass
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import UnitError
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.machine.part import Part, Quantity, quantity_of
from autobalancer.units import Given, to_si

P = TypeVar("P", bound=Part)
USUAL = {
    "rad": "deg",
    "rad/s": "rpm",
    "kg*m": "g*mm",
    "m": "mm",
    "m^2/s": "mm^2/s",
    "K": "degC",
}  # where the author has none
DIGITS = 10
WRITTEN = re.compile(r"^\s*[-+.\deE]+\s*(.*?)\s*$")


def in_author_units(machine: P, author: P) -> P:
    """The same machine with new numbers in the units in which the author of another one wrote such numbers.

    A number without a unit that the author wrote stays one; what he did not write at all has the unit that he took elsewhere
    for a quantity of its kind, else a usual one. Numbers are rounded to ten digits.
    """
    units: dict[str, str] = {}
    for quantity, value in _written(author):
        units.setdefault(quantity.unit, unit_of(value))
    changed: P = _part(machine, author, {**USUAL, **units})
    return changed


def with_author_springs(machine: Machine, author: Machine) -> Machine:
    """The same planar rotor with a critical speed, damping ratio or bandwidth where the author of another one gave these."""
    rotor, before = machine.rotor, author.rotor
    if not isinstance(rotor, PlanarRotor) or not isinstance(before, PlanarRotor) or not rotor.settled:
        return machine
    mass = total_mass(machine, resolve(machine))
    keys = {key: getattr(rotor, key) for key in rotor.model_fields_set}
    speeds = [math.sqrt(k / mass) for k in rotor.stiffness_xy]
    ratios = [b / (2.0 * mass * w) for b, w in zip(rotor.damping_xy, speeds, strict=True)]
    if before.critical_speed is not None:
        keys |= {"stiffness": None, "critical_speed": _one_or_pair(speeds)}
    width = before.half_power_bandwidth
    if width is not None and _alike(ratios):
        keys |= {"damping": None, "half_power_bandwidth": 2.0 * ratios[0]}
    elif width is not None or before.damping_ratio is not None:
        keys |= {"damping": None, "damping_ratio": _one_or_pair(ratios)}
    return machine.model_copy(
        update={"rotor": PlanarRotor(**{key: value for key, value in keys.items() if value is not None})}
    )


def _alike(values: list[float]) -> bool:
    return math.isclose(values[0], values[1], rel_tol=1e-12)


def _one_or_pair(values: list[float]) -> float | tuple[float, ...]:
    return values[0] if _alike(values) else tuple(values)


def _written(part: Part) -> Iterator[tuple[Quantity, Given]]:
    """All quantities of a part that were written with a unit."""
    for key in part.model_fields_set:
        quantity, stack = quantity_of(type(part), key), [getattr(part, key)]
        while stack:
            value = stack.pop()
            if isinstance(value, tuple):
                stack += reversed(value)
            elif isinstance(value, Part):
                yield from _written(value)
            elif isinstance(value, Given) and quantity is not None:
                yield quantity, value


def unit_of(value: Given) -> str:
    """The unit in which a quantity was written."""
    match = WRITTEN.match(value.text)
    return match[1] if match else ""


def _part(part: Any, author: Any, units: dict[str, str]) -> Any:
    changed = {}
    for key in part.model_fields_set:
        known = type(author) is type(part) and key in author.model_fields_set
        value, before = getattr(part, key), getattr(author, key) if known else None
        new = _entry(value, before, quantity_of(type(part), key), units)
        if new is not value:
            changed[key] = new
    return part.model_copy(update=changed) if changed else part


def _entry(value: Any, author: Any, quantity: Quantity | None, units: dict[str, str]) -> Any:
    if isinstance(value, Part):
        return _part(value, author, units)
    if isinstance(value, tuple):
        alike = isinstance(author, tuple) and len(author) == len(value)
        before = author if alike else (author[0] if isinstance(author, tuple) and author else author,) * len(value)
        new = tuple(_entry(one, other, quantity, units) for one, other in zip(value, before, strict=True))
        return value if all(one is other for one, other in zip(new, value, strict=True)) else new
    if quantity is None or isinstance(value, Given) or not isinstance(value, float):
        return value
    if isinstance(author, Given):
        return _with_unit(value, unit_of(author), quantity.unit)
    if isinstance(author, float) or not quantity.unit:
        return value  # as the author has it, in SI
    return _with_unit(value, units.get(quantity.unit, quantity.unit), quantity.unit)


def _with_unit(value: float, written: str, unit: str) -> float:
    """A number in SI as a text with this unit; itself where the unit is none for it."""
    try:
        zero, one = (to_si(f"{number} {written}", unit) for number in (0, 1))
        text = f"{(value - zero) / (one - zero):.{DIGITS}g} {written}"
        return Given(text, float(to_si(text, unit)))
    except (UnitError, ArithmeticError):
        return value
