"""The members of an ensemble: each the machine with its own values, seed and starts."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal

import numpy as np

from autobalancer.assembly.mass_spread import MASS_SPREAD
from autobalancer.assembly.parameters import with_value_at
from autobalancer.assembly.places import Places, places_of
from autobalancer.assembly.system import Assembly
from autobalancer.errors import MachineError, QuestionError, UnitError
from autobalancer.kernels.system import Integers
from autobalancer.machine import Machine
from autobalancer.simulation.prepare import prepare
from autobalancer.studies.ensemble.columns import Columns, ball_of
from autobalancer.studies.variations import variation_text, with_variation

Impossible = Literal["refuse", "record"]
KEPT = 64  # machines between two looks at their members


@dataclass(frozen=True)
class Ready:
    """A member that can run."""

    assembly: Assembly
    places: Places


class Members:
    """All members of an ensemble, row by row and in each row seed by seed; machines are made when they are asked for."""

    def __init__(
        self, machine: Machine, columns: Columns, seeds: Integers | None, seed: int, end: float, max_steps: int
    ) -> None:
        self.machine, self.columns, self.end, self._max_steps = machine, columns, end, max_steps
        own = columns.seeds if columns.seeds is not None else seeds
        if own is not None:
            self.machine = without_start_angles(machine)
        self._each = 1 if seeds is None else seeds.size  # members of a row
        self.count = columns.count * self._each
        if columns.seeds is not None:
            self.seeds = columns.seeds
        else:
            self.seeds = np.tile(seeds, columns.count) if seeds is not None else np.full(columns.count, seed, np.int64)
        self._machine = lru_cache(maxsize=KEPT)(self._of_row)

    def row(self, number: int) -> int:
        """The row of the columns from which a member is."""
        return number // self._each

    def machine_of(self, number: int) -> Machine:
        """The machine of a member, with its start."""
        return self._machine(self.row(number))

    def ready(self, number: int) -> Ready:
        """A member ready to run.

        Raises
        ------
        MachineError
            If there can be no such machine.
        """
        machine = self.machine_of(number)
        seed = int(self.seeds[number])
        assembly = prepare(machine, self.end, seed=seed, mass_spread=MASS_SPREAD, max_steps=self._max_steps)
        return Ready(assembly, places_of(machine, assembly))

    def impossible(self, how: Impossible) -> dict[int, str]:
        """Why some members cannot run, by their numbers; nothing runs for it.

        Raises
        ------
        MachineError, UnitError, QuestionError
            For the first of them, unless they are to be recorded.
        """
        found: dict[int, str] = {}
        for number in range(self.count):
            try:
                self.ready(number)
            except (MachineError, UnitError, QuestionError) as error:
                text = f"{self._named(number)}{error}"
                if how == "refuse":
                    kinds = (UnitError, QuestionError, MachineError)
                    raise next(kind for kind in kinds if isinstance(error, kind))(text) from None
                found[number] = text
        return found

    def _named(self, number: int) -> str:
        row = self.row(number)
        starts = {name: values[row] for name, values in self.columns.starts.items()}
        told = variation_text([*self.columns.parameters, *starts], (*self.columns.row(row), *starts.values()))
        return f"member {number + 1}{', ' + told if told else ': '}"

    def _of_row(self, row: int) -> Machine:
        varied = with_variation(self.machine, self.columns.parameters, self.columns.row(row))
        starts = self.columns.starts
        return with_starts(varied, {name: float(values[row]) for name, values in starts.items()}) if starts else varied


def without_start_angles(machine: Machine) -> Machine:
    """A machine whose balls start where a seed puts them."""
    for where, race in races(machine):
        if any(group.start_angles is not None for group in race.balls):
            groups = tuple(group.model_copy(update={"start_angles": None}) for group in race.balls)
            machine = with_value_at(machine, f"{where}.balls", groups)
    return machine


def with_starts(machine: Machine, starts: dict[str, float]) -> Machine:
    """A machine with other start angles (rad) and speeds (rad/s) of its balls; the numbers of balls count over all races.

    Raises
    ------
    QuestionError
        If a race would have start angles for some of its balls only.
    MachineError
        If balls would overlap.
    """
    first = 0
    for where, race in races(machine):
        groups = []
        for group in race.balls:
            changed: dict[str, Any] = {}
            for kind, key in (("ball_angle", "start_angles"), ("ball_speed", "start_speeds")):
                values = _own_starts(starts, kind, range(first, first + group.count), getattr(group, key))
                if values is not None:
                    changed[key] = values
            groups.append(type(group)(**{**{k: getattr(group, k) for k in group.model_fields_set}, **changed}))
            first += group.count
        machine = with_value_at(machine, f"{where}.balls", tuple(groups))
    return machine


def races(machine: Machine) -> Iterator[tuple[str, Any]]:
    """The races of a machine with their paths."""
    for b, balancer in enumerate(machine.balancers, 1):
        for r, race in enumerate(balancer.races, 1):
            yield f"balancers[{b}].races[{r}]", race


def _own_starts(starts: dict[str, float], kind: str, balls: range, now: Any) -> tuple[float, ...] | None:
    asked: dict[int, float] = {}
    for name, value in starts.items():
        named, ball = ball_of(name)
        if named == kind:
            asked |= {i: value for i in balls if ball is None or i == ball}
    if not asked:
        return None
    if now is None and kind == "ball_angle" and len(asked) < len(balls):
        missing = next(i for i in balls if i not in asked)
        raise QuestionError(
            f"columns: ball_angle[{missing + 1}] is missing; give the start angles of all balls of a race, or give the others "
            "in the machine"
        )
    given = tuple(map(float, now)) if now is not None else (0.0,) * len(balls)
    return tuple(asked.get(i, given[place]) for place, i in enumerate(balls))
