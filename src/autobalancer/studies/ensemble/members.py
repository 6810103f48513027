"""The members of an ensemble: each the machine with its own values, seed and starts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import nullcontext
from functools import lru_cache
from typing import Any, Literal

import numpy as np

from autobalancer.assembly.mass_spread import MASS_SPREAD
from autobalancer.assembly.parameters import with_value_at
from autobalancer.assembly.places import Places, places_of
from autobalancer.assembly.system import Assembly
from autobalancer.errors import CatalogError, MachineError, QuestionError, UnitError
from autobalancer.kernels.system import Integers
from autobalancer.machine import Machine
from autobalancer.simulation.prepare import prepare
from autobalancer.studies.ensemble.classes import Class, Differs, class_of, followed
from autobalancer.studies.ensemble.columns import Columns, ball_of
from autobalancer.studies.ensemble.execute import interrupts_noted
from autobalancer.studies.ensemble.groups import Groups
from autobalancer.studies.ensemble.integration import Plan
from autobalancer.studies.variations import variation_text, with_variation

Impossible = Literal["refuse", "record"]
REFUSED = (UnitError, QuestionError, MachineError, CatalogError)  # what says that a member is impossible
KEPT = 64  # machines between two looks at their members


class Members:
    """All members of an ensemble, row by row and in each row seed by seed; machines are made when they are asked for.

    ``seed`` is that of all where there are no others; ``named`` is what a message calls one, such as ``"member"``, if anything.
    """

    def __init__(self, machine: Machine, columns: Columns, seeds: Integers | None, seed: int, named: str) -> None:
        self.machine, self.columns, self._name = machine, columns, named
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

    def varied(self, row: int) -> Machine:
        """The machine of a row, without its start."""
        return with_variation(self.machine, self.columns.parameters, self.columns.row(row))

    def machine_of(self, number: int) -> Machine:
        """The machine of a member, with its start."""
        return self._machine(self.row(number))

    def ready(self, number: int, plan: Plan) -> tuple[Assembly, Places]:
        """A member ready to run.

        Raises
        ------
        MachineError
            If there can be no such machine.
        """
        machine = self.machine_of(number)
        seed = int(self.seeds[number])
        assembly = prepare(machine, plan.end, seed=seed, mass_spread=MASS_SPREAD, max_steps=plan.max_steps)
        return assembly, places_of(machine, assembly)

    def sorted(
        self, plan: Plan, how: Impossible, *, follow: bool = True, keep_on_interrupt: bool = False
    ) -> tuple[Groups, dict[int, str]]:
        """All members made ready, and why some of them cannot run; nothing runs for it.

        With ``follow`` those that differ in numbers are not assembled. With ``keep_on_interrupt`` Ctrl-C ends it with the members
        that are ready by then.

        Raises
        ------
        MachineError, UnitError, QuestionError, CatalogError
            For the first that cannot run, unless those are to be recorded.
        """
        with interrupts_noted() if keep_on_interrupt else nullcontext(list[int]()) as noted:
            try:
                return self._sorted(plan, how, noted, follow=follow)
            except Differs:
                return self._sorted(plan, how, noted, follow=False)

    def _sorted(
        self, plan: Plan, how: Impossible, noted: Sequence[int] = (), *, follow: bool
    ) -> tuple[Groups, dict[int, str]]:
        groups, reasons, classes = Groups(plan), dict[int, str](), dict[Any, Class]()
        names: list[str] | None = None
        for number in range(self.count):
            if noted:
                groups.interrupted = True
                break
            try:
                if follow and names is None:
                    names = followed(self, number, plan)
                key = class_of(self, number, names or [])
                if not follow:
                    groups.add(number, *self.ready(number, plan))
                else:
                    if key not in classes:
                        classes[key] = Class(self, groups, names or [])
                    classes[key].take(number)
            except REFUSED as error:
                text = f"{self._named(number)}{error}"
                if how == "refuse":
                    raise next(kind for kind in REFUSED if isinstance(error, kind))(text) from None
                reasons[number] = text
        for one in classes.values():
            one.finish()
        return groups, reasons

    def _named(self, number: int) -> str:
        row = self.row(number)
        starts = {name: values[row] for name, values in self.columns.starts.items()}
        told = variation_text([*self.columns.parameters, *starts], (*self.columns.row(row), *starts.values()))
        return f"{self._name} {number + 1}{', ' + told if told else ': '}" if self._name else told

    def _of_row(self, row: int) -> Machine:
        varied = self.varied(row)
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
