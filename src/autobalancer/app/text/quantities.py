"""Quantities of a machine, such as its last speed and its viscosity, written into its text; comments stay where they can."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Iterator, Mapping
from typing import Any

from autobalancer.app.text.document import Path, data_of, value_at, with_value, without
from autobalancer.app.text.fields import in_unit, number_and_unit, written
from autobalancer.app.text.numbers import USUAL
from autobalancer.assembly.author_units import in_author_units
from autobalancer.assembly.parameters import with_value_at
from autobalancer.assembly.quantities import with_quantity
from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.files.machine_file import machine_text, parse_machine
from autobalancer.machine import Machine, PrescribedSpeed
from autobalancer.machine.part import Part, spell
from autobalancer.machine.path import entry_at, unit_at

CLOSE = 1e-6  # relative; numbers are written with eight digits
LAST = {"constant": "speed", "ramp": "end", "hill": "end", "reduction": "end"}  # keys with the last speed
MANY = {"table": "speed", "dwell": "speeds"}  # keys with all speeds


def machine_with(machine: Machine, wanted: Mapping[str, float]) -> Machine:
    """A machine with other values of some quantities, SI; ``"speed"`` is the last that its drive prescribes.

    Raises
    ------
    QuestionError
        If the machine has no such quantity.
    MachineError
        If the values make no possible machine.
    """
    for name, value in wanted.items():
        machine = _with_speed(machine, value) if name == "speed" else with_quantity(machine, name, value)
    return machine


def text_with(text: str, machine: Machine, wanted: Mapping[str, float]) -> str:
    """The text of a machine with other values of some quantities, SI; units and comments stay.

    Where that does not give the machine, it is the text of the changed machine, without comments. Raises as
    :func:`machine_with`.
    """
    changed = machine_with(machine, wanted)
    before, after = (tomllib.loads(machine_text(one)) for one in (machine, changed))
    edited = text
    try:
        for path, value in _differences(before, after, ()):
            if _is_default(machine, changed, path):
                continue
            edited = (
                without(edited, path) if value is None else with_value(edited, path, _as_written(edited, path, value))
            )
        if alike(parse_machine(edited, "machine"), changed):
            return _tidy(edited)
    except (AutobalancerError, KeyError, TypeError, IndexError, ValueError):
        pass  # the text is not written as the machine is, such as a table in a file beside it
    return machine_text(in_author_units(changed, machine))


def alike(a: Any, b: Any) -> bool:
    """Whether two machines, or parts of them, are the same but for rounding and the description."""
    if isinstance(a, Part):
        keys = [key for key in type(a).model_fields if key != "description"]
        return type(a) is type(b) and all(alike(getattr(a, key), getattr(b, key)) for key in keys)
    if isinstance(a, tuple) and isinstance(b, tuple):
        return len(a) == len(b) and all(map(alike, a, b))
    if isinstance(a, float) and isinstance(b, float):
        return math.isclose(a, b, rel_tol=CLOSE)
    return bool(a == b)


def _with_speed(machine: Machine, value: float) -> Machine:
    profile = machine.drive.profile if isinstance(machine.drive, PrescribedSpeed) else None
    if profile is None:
        raise QuestionError(
            "speed: a torque drives this machine, so its speed follows from that and is no number of its file"
        )
    if profile.kind in LAST:
        return with_value_at(machine, f"drive.profile.{LAST[profile.kind]}", value)
    key = MANY[profile.kind]
    speeds = [float(speed) for speed in getattr(profile, key)]
    if not speeds[-1] > 0.0:
        raise QuestionError(
            "speed: the drive of this machine ends at standstill; change its profile on the page Describe"
        )
    first = len(speeds)
    while first and speeds[first - 1] == speeds[-1]:
        first -= 1
    for number in range(first, len(speeds)):
        machine = with_value_at(machine, f"drive.profile.{key}[{number + 1}]", value)
    return machine


def _differences(before: Any, after: Any, path: Path) -> Iterator[tuple[Path, Any]]:
    """Paths with what stands there after; ``None`` where nothing does. Another law or kind is another table."""
    if before == after:
        return
    if isinstance(before, dict) and isinstance(after, dict):
        if all(before.get(tag) == after.get(tag) for tag in ("kind", "law")):
            for key in before:
                if key not in after:
                    yield (*path, key), None
            for key, value in after.items():
                yield from _differences(before.get(key), value, (*path, key))
            return
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for number, (one, other) in enumerate(zip(before, after, strict=True)):
            yield from _differences(one, other, (*path, number))
        return
    yield path, after


def _is_default(machine: Machine, changed: Machine, path: Path) -> bool:
    """Whether what is new in the text is what stood there unwritten."""
    where = spell(path, "").removesuffix(": ")
    try:
        return bool(entry_at(machine, where) == entry_at(changed, where))
    except QuestionError:
        return False


def _tidy(text: str) -> str:
    """Blanks in tables on one line as people set them, where that changes nothing else."""
    tidied = re.sub(r",(?=[a-z_]+ = )", ", ", re.sub(r"\{ {2,}", "{ ", text))
    return tidied if data_of(tidied) == data_of(text) else text


def _as_written(text: str, path: Path, value: Any) -> Any:
    """A number with the unit that the text has there, or that people take."""
    if isinstance(value, dict):
        return {key: _as_written(text, (*path, key), one) for key, one in value.items()}
    unit = unit_at(spell(path, "").removesuffix(": "))
    given = number_and_unit(value, unit)
    if given is None or not unit:
        return value
    held = number_and_unit(value_at(data_of(text), path), unit)
    wanted = held[1] if held else USUAL.get(unit, unit)
    number = in_unit(given[0], given[1], wanted, unit)
    if number == given[0]:  # one of the units is not a usual one
        wanted = given[1]
    return written(f"{float(number):.8g}", wanted, unit)
