"""An unbalance that appears at speed: the members at rest in their places first, then the same with the unbalance added.

Two runs joined: the state at the end of the first, rotor and balls, is the start of the second. The measures are those of the
second, so peak and settling count from the moment at which the unbalance appears.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from autobalancer.assembly.parameters import with_value_at
from autobalancer.errors import QuestionError
from autobalancer.kernels.measures.columns import END, STATUS, VERDICT
from autobalancer.kernels.measures.limits import NO_VERDICT
from autobalancer.machine import Machine
from autobalancer.machine.part import unknown_key
from autobalancer.results.verdict.rule import BALANCED, WORDS
from autobalancer.studies.ensemble.execute import Ran, run_groups
from autobalancer.studies.ensemble.groups import Groups
from autobalancer.studies.ensemble.integration import Plan
from autobalancer.studies.ensemble.members import Members
from autobalancer.units import argument, shortened

TABLE = "sudden_unbalance"
OF_UNBALANCE = ("moment", "mass", "radius", "couple", "angle", "station")
NEEDED = ("speed", "before", "after")
HELD_SPEED = "drive.profile.speed"
BALANCED_BEFORE = "balanced_before"
NONE_YET = {"time": [0.0], "factor": [0.0]}  # a schedule
EXAMPLE = '{ moment = "200 g*mm", speed = "1200 rpm", before = "20 s", after = "20 s" }'


@dataclass(frozen=True)
class Sudden:
    """When an unbalance of the machine appears: the balls have ``before`` (s) without it and ``after`` (s) with it."""

    place: str  # path of the unbalance that appears
    before: float
    after: float

    def paths(self) -> dict[str, str]:
        """Names of its keys under 'vary', and the paths in the machine for which they stand."""
        return {"speed": HELD_SPEED, **{key: f"{self.place}.{key}" for key in OF_UNBALANCE}}

    def without(self, machine: Machine) -> Machine:
        """The machine as it is before."""
        return with_value_at(machine, f"{self.place}.schedule", NONE_YET)


def with_sudden(machine: Machine, given: Any) -> tuple[Machine, Sudden]:
    """A machine that runs at one speed with one unbalance more, and when that appears, from the table of a study file.

    Raises
    ------
    QuestionError
        With the key at fault.
    MachineError
        If there can be no such unbalance.
    """
    if not isinstance(given, Mapping):
        raise QuestionError(f"{TABLE}: given {shortened(given)}; must be a table, such as {EXAMPLE}")
    for key in given:
        if key not in (*OF_UNBALANCE, *NEEDED):
            raise QuestionError(f"{TABLE}.{key}: {unknown_key(key, [*OF_UNBALANCE, *NEEDED])}")
    for key in NEEDED:
        if key not in given:
            raise QuestionError(f"{TABLE}.{key}: missing; write {TABLE} = {EXAMPLE}")
    times = {key: argument(f"{TABLE}.{key}", given[key], "s") for key in ("before", "after")}
    for key, value in times.items():
        if not (math.isfinite(value) and value > 0.0):
            raise QuestionError(f"{TABLE}.{key}: given {given[key]!r}; must be a time greater than zero")
    profile = {"kind": "constant", "speed": argument(f"{TABLE}.speed", given["speed"], "rad/s")}
    machine = with_value_at(machine, "drive", {"kind": "speed", "profile": profile})
    added = {key: given[key] for key in OF_UNBALANCE if key in given}
    machine = with_value_at(machine, "unbalances", (*machine.unbalances, added))
    return machine, Sudden(f"unbalances[{len(machine.unbalances)}]", **times)


def after_jump(
    members: Members, before: Groups, sudden: Sudden, plan: Plan, workers: int | None, progress: Any
) -> tuple[list[Ran], dict[int, str], np.ndarray, float, bool]:
    """Members run to the moment at which the unbalance appears, and on with it.

    Returns
    -------
    ran, reasons, balanced, seconds, interrupted
        What the second runs left; why members have none; which were balanced before, (members,); time of a core in all.
    """
    ran, seconds, interrupted = run_groups(before, workers, None, keep_states=True)
    balanced, reasons, later = np.zeros(members.count, np.bool_), dict[int, str](), Groups(plan)
    with_it = Members(members.machine, members.columns, None, 0, "")
    for one in ran:
        for row, number in enumerate(one.group.numbers):
            state, numbers = one.found.states[row], one.found.rows[row]
            if numbers[END] < sudden.before or not np.isfinite(state).all():
                reasons[number] = f"the run before the unbalance appears ended early ({int(numbers[STATUS])})"
                continue
            word = numbers[VERDICT] if np.isfinite(numbers[VERDICT]) else NO_VERDICT
            balanced[number] = WORDS[int(word)] == BALANCED
            assembly, places = with_it.ready(number, plan)
            later.add(number, replace(assembly, state=state.copy()), places)
    if interrupted:
        return [], reasons, balanced, seconds, True
    ran, more, interrupted = run_groups(later, workers, progress)
    return ran, reasons, balanced, seconds + more, interrupted
