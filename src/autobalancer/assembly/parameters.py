"""Change one parameter of a machine by its path, spelled as in error messages and files."""

from __future__ import annotations

from typing import Any, TypeVar, cast

from autobalancer.catalog.resolve_springs import is_spring, settled, with_spring
from autobalancer.errors import MachineError
from autobalancer.machine import Machine
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.machine.path import number_at, with_entry

EitherMachine = TypeVar("EitherMachine", bound=Machine | ChamberMachine)


def with_value_at(machine: EitherMachine, path: str, value: Any) -> EitherMachine:
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
        if isinstance(machine, Machine) and is_spring(machine, path):
            changed: Any = with_spring(machine, path, value)
        else:
            known = settled(machine, path) if isinstance(machine, Machine) else machine
            changed = with_entry(known, path, value)
    except MachineError as error:
        raise MachineError(f"parameter {path!r} = {value!r}: {error}") from None
    return cast(EitherMachine, changed)


def parameter_of(machine: Machine, path: str) -> float:
    """The number at a path, SI; of a planar rotor also the springs that follow from its critical speed.

    Raises
    ------
    QuestionError
        If there is no single number.
    """
    return number_at(settled(machine, path), path)
