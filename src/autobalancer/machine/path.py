"""Paths into a machine, such as ``balancers[1].races[1].drag.beta``: what stands there, its unit, its label, its dimension."""

from __future__ import annotations

import re
from itertools import pairwise
from typing import Any

from autobalancer.errors import QuestionError
from autobalancer.machine.keys import parts_at
from autobalancer.machine.machine import Machine
from autobalancer.machine.near_paths import did_you_mean
from autobalancer.machine.part import Part, quantity_of, symbol_of
from autobalancer.units import shortened

_STEP = re.compile(r"([a-z_]+)((?:\[\d+\])*)")


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


def entry_at(machine: Part, path: str) -> Any:
    """What stands at a path: a number, a text, a part, a tuple of parts.

    Raises
    ------
    QuestionError
        If there is nothing; the message says what there is, and which paths may have been meant.
    """
    owner: Any = machine
    for step in path_steps(path):
        _refuse(machine, owner, step, path)
        owner = getattr(owner, step) if isinstance(step, str) else owner[step]
    return owner


def number_at(machine: Part, path: str) -> float:
    """The number at a path, SI.

    Raises
    ------
    QuestionError
        If there is nothing, or no single number.
    """
    entry = entry_at(machine, path)
    if isinstance(entry, tuple) and entry and all(isinstance(part, float) for part in entry):
        raise QuestionError(f"parameter {path!r}: it is {len(entry)} numbers; choose one, such as '{path}[1]'")
    if isinstance(entry, bool) or not isinstance(entry, (int, float)):
        raise QuestionError(f"parameter {path!r}: is {shortened(entry)} in this machine, not a number")
    return float(entry)


def with_entry(machine: Part, path: str, value: Any) -> Any:
    """A copy with ``value`` at a path; only what the path goes through is made and checked again.

    Raises
    ------
    QuestionError
        If there is nothing at the path.
    MachineError
        If the value is impossible there.
    """
    return _changed(machine, machine, path_steps(path), value, path)


def unit_at(path: str, root: type[Part] = Machine) -> str:
    """SI unit of the entry at a path of any machine; empty for a plain number, or where no machine has such an entry."""
    held = (quantity_of(part, key) for part, key in _keys_at(path, root))
    return next((quantity.unit for quantity in held if quantity is not None), "")


def symbol_at(path: str, root: type[Part] = Machine) -> str:
    """Symbol of the key at a path of any machine (LaTeX); empty where there is none."""
    return next((symbol for part, key in _keys_at(path, root) if (symbol := symbol_of(part, key))), "")


def _keys_at(path: str, root: type[Part]) -> list[tuple[type[Part], str]]:
    """The parts that may hold the last key of a path, and this key."""
    parts: tuple[type[Part], ...] = (root,)
    found: list[tuple[type[Part], str]] = []
    try:
        steps = path_steps(path)
    except QuestionError:
        return []
    for step in steps:
        if isinstance(step, str):
            found = [(part, step) for part in parts if step in part.model_fields]
            parts = tuple(inner for part, key in found for inner in parts_at(part, key))
    return found


def label_of_path(path: str) -> str:
    """What a person calls it: ``drag beta of race 1, balancer 1``, ``stiffness of support 2``, ``rotor damping``."""
    steps = path_steps(path)
    if isinstance(steps[-1], int):
        return path
    lists = [
        f"{_one(key)} {place + 1}" for key, place in pairwise(steps) if isinstance(key, str) and isinstance(place, int)
    ]
    last = max((i for i, step in enumerate(steps) if isinstance(step, int)), default=-1)
    inner = [str(step).replace("_", " ") for step in steps[last + 1 :]]
    return " ".join(inner) + (f" of {', '.join(reversed(lists))}" if lists else "")


def dimension_of_path(path: str) -> str:
    """Its name as a dimension of a dataset."""
    return path.replace("[", "_").replace("]", "").replace(".", "_")


def _one(key: Any) -> str:
    word = str(key).replace("_", " ")
    return {"bodies": "body", "balls": "ball group"}.get(word, word.removesuffix("s"))


def _refuse(machine: Part, owner: Any, step: str | int, path: str) -> None:
    if isinstance(step, str):
        if not isinstance(owner, Part) or step not in type(owner).model_fields:
            raise QuestionError(f"parameter {path!r}: no {step!r} there; {_there(owner)}{did_you_mean(machine, path)}")
    elif not isinstance(owner, tuple) or not 0 <= step < len(owner):
        count = len(owner) if isinstance(owner, tuple) else 0
        raise QuestionError(f"parameter {path!r}: entry {step + 1} does not exist; there are {count}, counted from 1")


def _there(owner: Any) -> str:
    """What a part has in place of a key that it has not."""
    if isinstance(owner, Part):
        return f"there is {', '.join(type(owner).model_fields)}"
    if isinstance(owner, tuple) and owner and isinstance(owner[0], Part):
        return f"it is a list; choose an entry, [1]{'' if len(owner) == 1 else f' to [{len(owner)}]'}"
    return "there is nothing"


def _changed(machine: Part, owner: Any, steps: list[str | int], value: Any, path: str) -> Any:
    if not steps:
        return value
    step, rest = steps[0], steps[1:]
    _refuse(machine, owner, step, path)
    if isinstance(step, str):
        entry = _changed(machine, getattr(owner, step), rest, value, path)
        return type(owner)(**{**{key: getattr(owner, key) for key in owner.model_fields_set}, step: entry})
    return (*owner[:step], _changed(machine, owner[step], rest, value, path), *owner[step + 1 :])
