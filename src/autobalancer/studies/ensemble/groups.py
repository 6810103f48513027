"""Members whose numbers lie alike in memory: one fresh run, and the words in which each member differs from it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from autobalancer.assembly.places import Places
from autobalancer.assembly.system import Assembly
from autobalancer.kernels.integrators.record import Record
from autobalancer.kernels.measures.gauges import HELD
from autobalancer.kernels.measures.limits import ITERATED
from autobalancer.kernels.system import BALLS, Floats, Integers
from autobalancer.simulation.steppers import Stepper
from autobalancer.studies.ensemble.integration import (
    APART,
    Bench,
    Found,
    Integration,
    Plan,
    fresh_integration,
    kind_of,
)
from autobalancer.studies.ensemble.layout import Layout


class Group:
    """Members of one layout. ``numbers`` are theirs in the ensemble."""

    def __init__(self, first: Integration, stepper: Stepper, balls: int) -> None:
        self.first, self.stepper, self.balls = first, stepper, balls
        self.layout = Layout(first, kind_of(first), APART)
        fresh = self.layout.packed(first)
        assert fresh is not None
        self.fresh: Integers = fresh
        self.numbers: list[int] = []
        self.later: dict[int, tuple[Assembly, Places]] = {}  # members that are not measured by compiled code alone
        self._blocks: list[tuple[Integers, Any]] = []  # places, and what stands there, (members, places)

    def takes(self, one: Integration, stepper: Stepper, number: int) -> bool:
        """Take a member, if its numbers lie like those of the others and it is integrated as they are."""
        if _way(stepper) != _way(self.stepper):
            return False
        block = self.layout.packed(one)
        if block is None:
            return False
        self.add([number], where := np.flatnonzero(block != self.fresh), block[None, where])
        return True

    def add(self, numbers: Sequence[int], places: Integers, words: Any) -> None:
        """Take members by their words, (members, places), among which are all in which they differ."""
        other = (words != self.fresh[places]).any(axis=0)
        self.numbers.extend(numbers)
        self._blocks.append((places[other], words[:, other]))

    def last(self) -> Integers:
        """All words of the member that was taken last."""
        found, (places, words) = self.fresh.copy(), self._blocks[-1]
        found[places] = words[-1]
        return found

    def words(self) -> tuple[Integers, Any]:
        """Where members differ from the fresh run, and what stands there, (members, places)."""
        places = np.unique(np.concatenate([*(where for where, _ in self._blocks), np.zeros(0, np.int64)]))
        words, first = np.tile(self.fresh[places], (len(self.numbers), 1)), 0
        for where, values in self._blocks:
            words[first : first + len(values), np.searchsorted(places, where)] = values
            first += len(values)
        return places, words

    def starts(self, places: Integers, words: Any) -> Floats:
        """Ball angles at the start, (members, balls)."""
        first = self.layout.place("memory.state", BALLS) if self.balls else 0
        found = np.tile(self.fresh[first : first + self.balls], (len(self.numbers), 1))
        for ball in range(self.balls):
            where = np.flatnonzero(places == first + ball)
            if where.size:
                found[:, ball] = words[:, where[0]]
        return found.view(np.float64)

    def bench(self) -> Bench:
        """A place for one thread."""
        return Bench(self.first, self.stepper, self.layout)

    def room(self, keep_states: bool) -> Found:
        """Room for what all members leave."""
        return Found.room(len(self.numbers), self.balls, self.first.memory.state.size if keep_states else 0)


def _way(stepper: Stepper) -> tuple[Any, ...]:
    """All that says how a member is integrated, besides its numbers."""
    long = stepper.long
    return stepper.method, stepper.moving, None if long is None else (long.nodes, long.watch)


class Groups:
    """All members, sorted by their layout."""

    def __init__(self, plan: Plan) -> None:
        self.plan, self.all = plan, list[Group]()
        self.interrupted = False  # whether somebody interrupted while members were made ready, so that some are missing
        self._records: dict[Any, Record] = {}

    def add(self, number: int, assembly: Assembly, places: Places) -> Group:
        """Take an assembled member; the group into which it goes."""
        one, stepper = fresh_integration(assembly, places, self.plan, self._records)
        group = next((group for group in self.all if group.takes(one, stepper, number)), None)
        if group is None:
            group = Group(one, stepper, len(assembly.balls))
            self.all.append(group)
            group.takes(one, stepper, number)
        if one.gauges.scalars[HELD] == ITERATED:
            group.later[number] = assembly, places
        return group
