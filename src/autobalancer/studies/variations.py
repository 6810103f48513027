"""The variations of a sweep: machines with other parameters, and how an axis and a message name them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from autobalancer.assembly.parameters import with_value_at
from autobalancer.assembly.quantities import parameter_range, parameter_unit, si_value, with_parameter
from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.machine import Machine
from autobalancer.machine.part import Part
from autobalancer.machine.path import entry_at
from autobalancer.machine.plain_names import QUANTITIES, axis_attributes, parts_of
from autobalancer.units import argument
from autobalancer.units.ranges import is_range


def with_variation(machine: Machine, variations: Iterable[str], point: tuple[Any, ...]) -> Machine:
    """The machine with the values of ``point`` at the paths or plain names.

    Raises
    ------
    QuestionError
        If there is no such parameter.
    MachineError
        If a value is impossible.
    """
    for path, value in zip(variations, point, strict=True):
        machine = with_parameter(machine, path, float(value) if isinstance(value, np.floating) else value)
    return machine


def listed(machine: Machine, name: str, values: Any) -> Sequence[Any]:
    """A single value of a parameter as a list of one, a range as its values."""
    refuse_of_all(name)
    if is_range(values):
        return [value.item() for value in parameter_range(machine, name, values)]
    return [values] if isinstance(values, str | int | float | Mapping | Part) else values


def refuse_of_all(name: str) -> None:
    """Refuse an entry that is the same for all runs.

    Raises
    ------
    QuestionError
        For the duration.
    """
    if any(part.split(".")[0] == "run" for part in parts_of(name)):
        raise QuestionError(f"{name}: the runs have one duration, which is given beside what varies, as 'duration'")


def variation_text(variations: Iterable[str], point: tuple[Any, ...]) -> str:
    """The begin of a message: ``"variation with rotor.mass = 2, rotor.damping = 10 N*s/m: "``; empty without any."""
    values = ", ".join(f"{path} = {_inner(value)}" for path, value in zip(variations, point, strict=True))
    return f"variation with {values}: " if values else ""


def coordinate(machine: Machine, path: str, values: Sequence[Any]) -> tuple[Any, dict[str, str]]:
    """Values along an axis, with its name and unit: numbers in SI, else texts, of whole parts too."""
    found = [_number(machine, path, value) for value in values]
    if not all(isinstance(value, (int, float, np.number)) for value in found):
        found = [_text(value) for value in found]
    return found, axis_attributes(path) | {"units": _unit(machine, path)}


def _unit(machine: Machine, path: str) -> str:
    """SI unit of a parameter; empty for a name, a number without unit or a whole part."""
    try:
        return parameter_unit(machine, path).replace("*", " ")
    except QuestionError:
        return ""


def _number(machine: Machine, path: str, value: Any) -> Any:
    """The SI number that a text became."""
    if not isinstance(value, str):
        return value
    try:
        if path in QUANTITIES or len(parts_of(path)) > 1:
            return si_value(machine, path, value)
        entry = entry_at(with_value_at(machine, path, value), path)
    except AutobalancerError:  # of a member that is impossible
        return _as_written(machine, path, value)
    return float(entry) if isinstance(entry, float) else entry


def _as_written(machine: Machine, path: str, value: str) -> Any:
    """The SI number that a text would be in a machine where it is possible; else the text."""
    try:
        return argument(path, value, parameter_unit(machine, path))
    except AutobalancerError:
        return value


def _text(value: Any) -> str:
    """A value in one line; a part as ``"law = beta, beta = 0.001"``."""
    if isinstance(value, Part):
        value = value.model_dump(exclude_unset=True)
    if isinstance(value, Mapping):
        parts = (f"{key} = {_inner(entry)}" for key, entry in value.items())
        return ", ".join(parts)
    if isinstance(value, (list, tuple, np.ndarray)):
        return f"[{', '.join(_inner(entry) for entry in value)}]"
    return f"{value:g}" if isinstance(value, (float, np.floating)) else str(value)


def _inner(value: Any) -> str:
    whole = isinstance(value, (Part, Mapping))
    return f"{{{_text(value)}}}" if whole else _text(value)
