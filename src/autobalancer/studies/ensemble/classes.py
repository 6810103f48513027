"""Members sorted into groups: one of each class is assembled, the others follow it where they can."""

from __future__ import annotations

from itertools import islice
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from autobalancer.errors import MachineError, QuestionError, UnitError
from autobalancer.kernels.system import Integers
from autobalancer.studies.ensemble.described import Described, Words
from autobalancer.studies.ensemble.follow import Follower, Start, can_follow, starts_can_follow
from autobalancer.studies.ensemble.groups import Group, Groups
from autobalancer.studies.ensemble.integration import Plan, fresh_integration
from autobalancer.studies.variations import with_variation

if TYPE_CHECKING:
    from autobalancer.assembly.system import Assembly
    from autobalancer.machine import Machine
    from autobalancer.studies.ensemble.members import Members

BLOCK = 512  # members whose words are written down together
TRIED = 3  # other values of a parameter that say whether members can follow it
UNBALANCE = "unbalance"  # in the names of parameters of which one can be followed


class Waiting(NamedTuple):
    """A member that follows, before its words are written down."""

    number: int
    values: list[Any]  # of its parameters
    words: Words  # besides those of parameters whose numbers are known


class Differs(Exception):
    """A member that followed is not the one that is assembled; caught in members.py, where all are assembled then."""


class Class:
    """Members that differ in parameters that can be followed, and in their starts."""

    def __init__(self, members: Members, groups: Groups, names: list[str]) -> None:
        self._members, self._groups, self._names = members, groups, names
        self._group: Group | None = None
        self._follower: Follower | None = None
        self._base, self._differing = np.zeros(0, np.int64), set[int]()
        self._count, self._next = 0, 1
        self._waiting: list[Waiting] = []

    def take(self, number: int) -> None:
        """Take a member: the first is assembled, and so is one that cannot follow it; the others wait for :meth:`finish`."""
        members = self._members
        if self._group is None:
            self._begin(number)
            return
        if self._follower is not None:
            row = members.row(number)
            values = [members.columns.parameters[name][row] for name in self._names]
            words = self._follower.words(values, lambda: members.varied(row), *self._start(number))
            if words is not None:
                self._waiting.append(Waiting(number, values, words))
                if len(self._waiting) == BLOCK:
                    self.finish()
                return
        self._groups.add(number, *members.ready(number, self._groups.plan))

    def finish(self) -> None:
        """Write down the words of all members that wait."""
        if self._group is None or self._follower is None or not self._waiting:
            return
        waiting, self._waiting = self._waiting, []
        known = self._follower.of_parameters([one.values for one in waiting])
        places = np.array(
            sorted({place for one in waiting for place in one.words} | known.keys() | self._differing), np.int64
        )
        usual = dict(zip(places.tolist(), self._base[places].tolist(), strict=True))
        if any(one.words for one in waiting):
            words = np.array([list((usual | one.words).values()) for one in waiting], np.int64)
        else:
            words = np.tile(self._base[places], (len(waiting), 1))
        for place, column in known.items():
            words[:, np.searchsorted(places, place)] = column
        for number, row in zip((one.number for one in waiting), words, strict=True):
            self._count += 1
            if self._count == self._next:
                self._next *= 8
                self._compare(number, places, row)
        self._group.add([one.number for one in waiting], places, words)

    def _begin(self, number: int) -> None:
        assembly, places = self._members.ready(number, self._groups.plan)
        self._group = group = self._groups.add(number, assembly, places)
        starts = list(self._members.columns.starts)
        machine = self._members.machine_of(number)
        moves = starts or len(set(self._members.seeds.tolist())) > 1
        if number in group.later or (moves and not starts_can_follow(machine, assembly, starts)):
            return
        self._base = group.last()
        self._differing = set(np.flatnonzero(self._base != group.fresh).tolist())
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

    def _compare(self, number: int, places: Integers, words: Integers) -> None:
        """Assemble the member all the same."""
        assert self._group is not None
        try:
            one, _ = fresh_integration(*self._members.ready(number, self._groups.plan), self._groups.plan)
        except (MachineError, UnitError, QuestionError):
            raise Differs from None
        known, block = self._group.layout.packed(one), self._group.fresh.copy()
        block[places] = words
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
