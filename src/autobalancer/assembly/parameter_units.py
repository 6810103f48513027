"""The unit in which a quantity or an entry of a machine is counted."""

from __future__ import annotations

from typing import Any

from autobalancer.assembly.near_paths import did_you_mean
from autobalancer.assembly.parameters import path_steps
from autobalancer.assembly.quantities import QUANTITIES
from autobalancer.errors import QuestionError
from autobalancer.machine.part import Part, quantity_of


def parameter_unit(machine: Part, name: str) -> str:
    """The SI unit of a named quantity or of the entry at a path, empty where it is a plain number.

    Raises
    ------
    QuestionError
        If there is no such quantity or entry, or it is no number.
    """
    if name == "speed":
        return "rad/s"
    if name in QUANTITIES:
        return QUANTITIES[name][1]
    if "." not in name:
        known = ", ".join(("speed", *QUANTITIES))
        raise QuestionError(
            f"parameter {name!r}: no such name; there are {known}, and paths such as 'rotor.damping'"
            f"{did_you_mean(machine, name)}"
        )
    owner: Any = machine
    unit = ""
    for step in path_steps(name):
        if isinstance(step, str):
            if not isinstance(owner, Part) or step not in type(owner).model_fields:
                known = ", ".join(type(owner).model_fields) if isinstance(owner, Part) else "nothing"
                raise QuestionError(
                    f"parameter {name!r}: no {step!r} there; there is {known}{did_you_mean(machine, name)}"
                )
            held = quantity_of(type(owner), step)
            unit = held.unit if held is not None else ""
            owner = getattr(owner, step)
        elif isinstance(owner, tuple) and 0 <= step < len(owner):
            owner = owner[step]
        else:
            count = len(owner) if isinstance(owner, tuple) else 0
            raise QuestionError(
                f"parameter {name!r}: entry {step + 1} does not exist; there are {count}, counted from 1"
            )
    return unit
