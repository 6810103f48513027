"""Change one parameter of a machine by its path, spelled as in error messages and files."""

from __future__ import annotations

import re
from typing import Any

from autobalancer.assembly.near_paths import did_you_mean
from autobalancer.catalog.resolve_springs import is_spring, settled, with_spring
from autobalancer.errors import MachineError, QuestionError
from autobalancer.machine import Machine
from autobalancer.machine.part import Part

_STEP = re.compile(r"([a-z_]+)((?:\[\d+\])*)")


def with_parameter(machine: Machine, path: str, value: Any) -> Machine:
    """A machine in which the entry at ``path`` is ``value``.

    Parameters
    ----------
    machine
        Left as it is.
    path
        For example ``rotor.mass`` or ``balancers[1].races[1].balls[1].diameter``; entries are counted from 1.
    value
        SI, or a string with a unit, or a whole part.

    Raises
    ------
    QuestionError
        If there is no such entry; the message lists what there is.
    MachineError
        If the value is impossible there.
    """
    try:
        if is_spring(machine, path):
            return with_spring(machine, path, value)
        whole, steps = settled(machine, path), path_steps(path)
        try:
            changed = _changed(whole, steps, value, path)
        except QuestionError as error:
            raise QuestionError(f"{error}{did_you_mean(machine, path)}") from None
    except MachineError as error:
        raise MachineError(f"parameter {path!r} = {value!r}: {error}") from None
    assert isinstance(changed, Machine)
    return changed


def path_steps(path: str) -> list[str | int]:
    """Keys and places of a path; places are counted from 0.

    Raises
    ------
    QuestionError
        If it cannot be read.
    """
    steps: list[str | int] = []
    for piece in path.split("."):
        match = _STEP.fullmatch(piece)
        if match is None:
            raise QuestionError(
                f"parameter {path!r}: cannot read {piece!r}; write it like 'balancers[1].races[1].drag.beta'"
            )
        steps.append(match[1])
        steps += [int(number) - 1 for number in re.findall(r"\d+", match[2])]
    return steps


def _there(owner: Any) -> str:
    """What a part has in place of a key that it has not."""
    if isinstance(owner, Part):
        return f"there is {', '.join(type(owner).model_fields)}"
    if isinstance(owner, tuple) and owner and isinstance(owner[0], Part):
        return f"it is a list; choose an entry, [1]{'' if len(owner) == 1 else f' to [{len(owner)}]'}"
    return "there is nothing"


def _changed(owner: Any, steps: list[str | int], value: Any, path: str) -> Any:
    if not steps:
        return value
    step, rest = steps[0], steps[1:]
    if isinstance(step, str):
        if not isinstance(owner, Part) or step not in type(owner).model_fields:
            raise QuestionError(f"parameter {path!r}: no {step!r} there; {_there(owner)}")
        entry = _changed(getattr(owner, step), rest, value, path)
        return type(owner)(**{**{key: getattr(owner, key) for key in owner.model_fields_set}, step: entry})
    if not isinstance(owner, tuple) or not 0 <= step < len(owner):
        count = len(owner) if isinstance(owner, tuple) else 0
        raise QuestionError(f"parameter {path!r}: entry {step + 1} does not exist; there are {count}, counted from 1")
    return (*owner[:step], _changed(owner[step], rest, value, path), *owner[step + 1 :])
