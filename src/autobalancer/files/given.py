"""A machine as functions are given it: described, or as the path of its file; and what they say of anything else."""

from __future__ import annotations

from pathlib import Path

from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import FREE_BALLS, load_machine, load_race_machine
from autobalancer.machine import Machine
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.units import shortened


def any_machine(given: Machine | ChamberMachine | str | Path) -> Machine | ChamberMachine:
    """The machine, read if ``given`` is a path.

    Raises
    ------
    QuestionError
        If it is neither a machine nor a path.
    MachineFileError
        If the file cannot be read, or its machine is not possible.
    """
    if isinstance(given, Machine | ChamberMachine):
        return given
    if isinstance(given, str | Path):
        return load_machine(given)
    raise QuestionError(_wanted(given))


def balls_in_races(given: Machine | ChamberMachine | str | Path, *, rings: bool = False) -> Machine:
    """The machine with races, read if ``given`` is a path; raises as :func:`any_machine`, also for deep chambers.

    One with rings of liquid is refused unless ``rings``.
    """
    if isinstance(given, ChamberMachine):
        raise QuestionError(f"machine: {FREE_BALLS}")
    if not isinstance(given, Machine | str | Path):
        raise QuestionError(_wanted(given))
    machine = given if isinstance(given, Machine) else load_race_machine(given)
    if machine.liquid_rings and not rings:
        raise QuestionError(
            "liquid_rings: this question does not know liquid with a free surface; liquid-response (ab.rotor.liquid_response) "
            "does, and without 'liquid_rings' this one answers for the rotor alone"
        )
    return machine


def balls_in_chambers(given: Machine | ChamberMachine | str | Path) -> ChamberMachine:
    """The machine with deep chambers, read if ``given`` is a path; raises as :func:`any_machine`, also for races."""
    found = any_machine(given)
    if isinstance(found, ChamberMachine):
        return found
    raise QuestionError(
        "machine: its balls run in races, and this question is for deep chambers; for races there are sweep and basin"
    )


def _wanted(given: object) -> str:
    kind = type(given).__name__
    said = shortened(given) if isinstance(given, int | float) else f"{'an' if kind[0] in 'aeiouAEIOU' else 'a'} {kind}"
    return f"machine: given {said}; wanted is a machine, as of load_machine or example, or the path of a machine file"
