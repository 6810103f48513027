"""Members sorted into groups: one of each class is assembled, the others follow it where they can."""

from __future__ import annotations

from itertools import islice
from typing import TYPE_CHECKING, Any

import numpy as np

from autobalancer.errors import MachineError, QuestionError, UnitError
from autobalancer.studies.ensemble.described import Described, Words
from autobalancer.studies.ensemble.follow import Follower, Start, can_follow, starts_can_follow
from autobalancer.studies.ensemble.groups import Group, Groups
from autobalancer.studies.ensemble.integration import Plan, fresh_integration
from autobalancer.studies.variations import with_variation

if TYPE_CHECKING:
    from autobalancer.assembly.system import Assembly
    from autobalancer.machine import Machine
    from autobalancer.studies.ensemble.members import Members

TRIED = 3  # other values of a parameter that say whether members can follow it
UNBALANCE = "unbalance"  # in the names of parameters of which one can be followed


class Differs(Exception):
    """A member that followed is not the one that is assembled; caught in members.py, where all are assembled then."""


class Class:
    """Members that differ in parameters that can be followed, and in their starts."""

    def __init__(self, members: Members, groups: Groups, names: list[str]) -> None:
        self._members, self._groups, self._names = members, groups, names
        self._group: Group | None = None
        self._follower: Follower | None = None
        self._base: Words = {}
        self._count, self._next = 0, 1

    def take(self, number: int) -> None:
        """Take a member: the first is assembled, and so is every one that cannot follow it."""
        if self._group is None:
            self._begin(number)
            return
        if self._follower is None:
            self._groups.add(number, *self._members.ready(number, self._groups.plan))
            return
        members = self._members
        values = [members.columns.parameters[name][members.row(number)] for name in self._names]
        row = members.row(number)
        words = self._follower.words(values, lambda: members.varied(row), *self._start(number))
        if words is None:
            self._groups.add(number, *members.ready(number, self._groups.plan))
            return
        self._count += 1
        words = self._base | words
        if self._count == self._next:
            self._next *= 8
            self._compare(number, words)
        places = np.array(sorted(words), np.int64)
        self._group.add(number, places, np.array([words[place] for place in places.tolist()], np.int64))

    def _begin(self, number: int) -> None:
        assembly, places = self._members.ready(number, self._groups.plan)
        self._group = group = self._groups.add(number, assembly, places)
        starts = list(self._members.columns.starts)
        machine = self._members.machine_of(number)
        moves = starts or len(set(self._members.seeds.tolist())) > 1
        if number in group.later or (moves and not starts_can_follow(machine, assembly, starts)):
            return
        self._base = group.differences(len(group.numbers) - 1)
        plan, row = self._groups.plan, self._members.row(number)
        described = None
        if not all_known(machine, assembly, self._names):
            described = Described(self._members.varied(row), assembly, plan.end, plan.tolerance)
        self._follower = Follower(group, machine, assembly, self._names, plan.tolerance, self._start(number), described)

    def _start(self, number: int) -> Start:
        members = self._members
        row = members.row(number)
        starts = {name: float(start[row]) for name, start in members.columns.starts.items()}
        return int(members.seeds[number]), starts

    def _compare(self, number: int, words: Words) -> None:
        """Assemble the member all the same."""
        assert self._group is not None
        one, _ = fresh_integration(*self._members.ready(number, self._groups.plan), self._groups.plan)
        known, block = self._group.layout.packed(one), self._group.fresh.copy()
        for place, word in words.items():
            block[place] = word
        if known is None or not np.array_equal(known, block):
            raise Differs


def all_known(machine: Machine, assembly: Assembly, names: list[str]) -> bool:
    """Whether the numbers that all these parameters change are known without a machine of each member."""
    unbalances = sum(UNBALANCE in name for name in names)
    return unbalances <= 1 and all(can_follow(machine, assembly, name) for name in names)


def followed(members: Members, number: int, plan: Plan) -> list[str]:
    """The parameters that members can follow, as the machine of this one says."""
    machine, columns = members.machine_of(number), members.columns.parameters
    if not columns:
        return []
    assembly, _ = members.ready(number, plan)
    varied = members.varied(members.row(number))
    described, found = Described(varied, assembly, plan.end, plan.tolerance), list[str]()
    for name, values in columns.items():
        own = repr(values[members.row(number)])
        others = list(islice((value for value in values if repr(value) != own), TRIED))
        if can_follow(machine, assembly, name) or any(_follows(described, varied, name, other) for other in others):
            found.append(name)
    return found


def _follows(described: Described, machine: Machine, name: str, value: Any) -> bool:
    """Whether a machine with this value need not be assembled; one that is impossible is no answer."""
    try:
        return described.follows(with_variation(machine, [name], (value,)))
    except (MachineError, UnitError, QuestionError):
        return False


def class_of(members: Members, number: int, names: list[str]) -> Any:
    """What members must have in common: the values of all parameters that are not followed."""
    row = members.row(number)
    return tuple(repr(values[row]) for name, values in members.columns.parameters.items() if name not in names)
