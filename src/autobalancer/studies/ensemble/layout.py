"""All numbers of an integration in one block of words, so that another run is a copy and a few other words.

A word has 64 bits: a float, or a whole number. A block begins with the plain numbers of the tuples in their order, then come the
arrays. Two arrays in one place of memory have one place in the block.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numba import types

from autobalancer.assembly.drive_train import unbalance_jumps
from autobalancer.assembly.places import MOST, Places, desk_for, with_touches
from autobalancer.assembly.system import Assembly
from autobalancer.kernels.compiler.numba_struct import count_numbers, value_type
from autobalancer.kernels.integrators.integrator_state import Memory, memory_type
from autobalancer.kernels.integrators.recording import Record, record_type
from autobalancer.kernels.many_members import run_members
from autobalancer.kernels.measures.columns_of_measures import ITERATED, WIDTH
from autobalancer.kernels.measures.workspace import HELD, MeasureInputs, inputs_type
from autobalancer.kernels.system import BALLS, VX, Floats, Integers, Matrix, System, system_type
from autobalancer.results.measure_table import SWEPT
from autobalancer.results.run_arrays import SETTLING_FROM
from autobalancer.simulation.record import Envelope, LastRevolutions, Sampling, record_for
from autobalancer.simulation.steppers import Stepper, stepper_for
from autobalancer.studies.variations import gauges_for

APART = -1  # where an array begins that has no place in a block
LINE = 8  # words: arrays begin with a line of the processor's cache


class Leaf(NamedTuple):
    """A plain number (no shape) or an array, and where it begins in a block."""

    path: str
    first: int
    shape: tuple[int, ...] | None
    dtype: Any


class Layout:
    """Where the numbers of a tuple are.

    ``kind`` is its compiled type, which says what is a float; ``apart`` are paths of arrays that have no place in a block.
    """

    def __init__(self, value: Any, kind: Any, apart: tuple[str, ...] = ()) -> None:
        result, known = list(leaves(value)), dict[tuple[int, Any], int]()
        self.apart = apart
        self.numbers = self.size = sum(not isinstance(leaf, np.ndarray) for _, leaf in result)
        self._order: list[Leaf] = []
        number = 0
        for (path, leaf), of in zip(result, _kinds(kind), strict=True):
            if not isinstance(leaf, np.ndarray):
                self._order.append(Leaf(path, number, None, np.dtype(float if isinstance(of, types.Float) else int)))
                number += 1
                continue
            where = leaf.__array_interface__["data"][0], leaf.shape
            if path in apart:
                first = APART
            elif leaf.size and where in known:
                first = known[where]
            else:
                first = self.size + (-self.size % LINE)
                self.size = first + leaf.nbytes // 8
                known[where] = first
            self._order.append(Leaf(path, first, leaf.shape, leaf.dtype))
        self._by_path = {leaf.path: leaf for leaf in self._order}
        self._form = _flat(value, [])
        plain = [leaf for leaf in self._order if leaf.shape is None]
        self._numbers = struct.Struct("".join("d" if leaf.dtype.kind == "f" else "q" for leaf in plain))

    def packed(self, value: Any) -> Integers | None:
        """The block of a tuple of the same shape; None if it has another one."""
        items: list[Any] = []
        if _flat(value, items) != self._form:
            return None
        numbers: list[Any] = []
        parts, size = [b""], self.numbers
        for own, leaf in zip(items, self._order, strict=True):
            if leaf.shape is None:
                numbers.append(own)
                continue
            if leaf.first < 0:
                continue
            if own.shape != leaf.shape or own.dtype != leaf.dtype:
                return None
            if leaf.first < size or not own.size:  # an array that was there already, or none
                continue
            parts.append(bytes(8 * (leaf.first - size)))
            parts.append(own.tobytes())
            size = leaf.first + own.nbytes // 8
        parts.append(bytes(8 * (self.size - size)))
        parts[0] = self._numbers.pack(*numbers)
        return np.frombuffer(bytearray().join(parts), np.int64)

    def viewed(self, value: Any, block: Integers, path: str = "") -> Any:
        """The tuple ``value`` with its arrays in a block; plain numbers stay, and arrays that are apart are copied."""
        if isinstance(value, tuple):
            inner = [self.viewed(entry, block, below) for below, entry in _below(value, path)]
            return type(value)(*inner) if hasattr(value, "_fields") else tuple(inner)
        if not isinstance(value, np.ndarray):
            return value
        if path in self.apart:
            return value.copy()
        leaf = self._by_path[path]
        words = value.nbytes // 8
        if words == 0:
            return value.copy()
        views = block[leaf.first : leaf.first + words].view(value.dtype).reshape(value.shape)
        return views.view(type(value))

    def words(self, path: str, value: Any, known: Integers | None = None) -> dict[int, int] | None:
        """Places and words of a tuple that stands at a path; None if it has another shape.

        Of arrays those only that differ from a ``known`` block, if there is one.
        """
        result: dict[int, int] = {}
        for below, own in leaves(value, path):
            leaf = self._by_path.get(below)
            if leaf is None or leaf.shape != (own.shape if isinstance(own, np.ndarray) else None):
                return None
            if leaf.shape is None:
                result[leaf.first] = bits(own) if leaf.dtype.kind == "f" else int(own)
                continue
            content = own.tobytes()
            if known is None:
                result.update(enumerate(np.frombuffer(content, np.int64).tolist(), leaf.first))
            elif content != (there := known[leaf.first : leaf.first + len(content) // 8]).tobytes():
                words = np.frombuffer(content, np.int64)
                other = np.flatnonzero(words != there)
                result.update(zip((other + leaf.first).tolist(), words[other].tolist(), strict=True))
        return result

    def has(self, path: str) -> bool:
        """Whether there is a number or an array at a path."""
        return path in self._by_path

    def place(self, path: str, *index: int, field: str = "") -> int:
        """The word of a number: of the array at a path its element, of a record its field."""
        leaf = self._by_path[path]
        if leaf.shape is None:
            return leaf.first
        number = int(np.ravel_multi_index(index, leaf.shape)) if index else 0
        return int(leaf.first + (number * leaf.dtype.itemsize + (leaf.dtype.fields[field][1] if field else 0)) // 8)


def bits(value: float) -> int:
    """The word of a float."""
    return int(np.float64(value).view(np.int64))


def words_of(values: Floats) -> Integers:
    """The words of floats."""
    return values.view(np.int64)


def leaves(value: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """The numbers and arrays of a tuple of tuples with their paths, in their order."""
    if not isinstance(value, tuple):
        yield path, value
        return
    for below, entry in _below(value, path):
        yield from leaves(entry, below)


def _flat(value: Any, found: list[Any]) -> list[int]:
    """Add the numbers and arrays of a tuple to ``found``; returns its form: lengths, -1 for arrays, -2 for numbers."""
    form = [len(value)]
    for entry in value:
        if isinstance(entry, tuple):
            form += _flat(entry, found)
        else:
            form.append(-1 if isinstance(entry, np.ndarray) else -2)
            found.append(entry)
    return form


def _kinds(kind: Any) -> Iterator[Any]:
    if isinstance(kind, types.BaseTuple):
        for inner in kind.types:  # type: ignore[attr-defined]
            yield from _kinds(inner)
    else:
        yield kind


def _below(value: Any, path: str) -> Iterator[tuple[str, Any]]:
    names = getattr(value, "_fields", None) or range(len(value))
    for name, entry in zip(names, value, strict=True):
        yield f"{path}.{name}" if path else str(name), entry


# A fresh run of one member: all numbers that the compiled loop needs.


INTEGRATION_APART = ("system.impacts",)  # room that a run need not find empty
ASKABLE = (*(one.name for one in SWEPT), "verdict")  # measures of a member
# what measures need (results/measure_table.py) that is not in the envelope
OF_TURNS, OF_END = {"turns", "planes", "forces", "rotor"}, {"final_angle", "impacts"}
MIXED = {"residual_vibration", "vibration", "verdict"}  # for which the envelope is compared with the last revolutions


class Plan(NamedTuple):
    """How members are run."""

    end: float  # s
    tolerance: float
    bins: int
    max_steps: int
    method: str = "auto"
    settling_from: str = SETTLING_FROM[0]
    measures: tuple[str, ...] = ASKABLE

    @property
    def wishes(self) -> list[Sampling]:
        """What a run has to record for the measures: nothing where its end alone is asked for."""
        needs = [set(one.needs) for one in SWEPT if one.name in self.measures and OF_END.isdisjoint(one.needs)]
        both = not MIXED.isdisjoint(self.measures)
        samplings: list[Sampling] = []
        if both or any(need.isdisjoint(OF_TURNS) for need in needs):
            samplings.append(Envelope(self.bins))
        if both or any(not need.isdisjoint(OF_TURNS) for need in needs):
            samplings.append(LastRevolutions())
        return samplings


class Integration(NamedTuple):
    """What a run changes or reads; the order is that of the words in a block."""

    system: System
    record: Record
    memory: Memory
    gauges: MeasureInputs
    long: tuple[Any, ...] = ()  # memory and amplitudes of long steps


def kind_of(integration: Integration) -> Any:
    """Its compiled type."""
    kinds = [value_type(kind) for kind in (system_type, record_type, memory_type, inputs_type)]
    if integration.long:
        from autobalancer.kernels.integrators.collocation import amplitudes_type

        kinds.append(types.Tuple((value_type(memory_type), value_type(amplitudes_type))))  # type: ignore[no-untyped-call]
    return types.Tuple(kinds)  # type: ignore[no-untyped-call]


def fresh_integration(
    assembly: Assembly, places: Places, plan: Plan, known: dict[Any, Record] | None = None
) -> tuple[Integration, Stepper]:
    """A run of an assembled machine that has not begun, and how it is integrated; empty records that are ``known`` are taken."""
    jumps, known = unbalance_jumps(places.machine, plan.end), {} if known is None else known
    empty = jumps, assembly.state.size, tuple(assembly.state[:VX])
    if empty not in known:
        known[empty] = record_for(plan.wishes, (), assembly, plan.end, jumps)
    record = known[empty]
    noting, touches = with_touches(places.machine, assembly)
    stepper = stepper_for(noting, plan.end, plan.tolerance, plan.method)
    gauges = gauges_for(noting, places, plan.end, touches)
    long = (stepper.long.memory, stepper.long.amplitudes) if stepper.long is not None else ()
    return Integration(noting.system, record, stepper.memory, gauges, long), stepper


class Bench:
    """A place where one thread runs members of one layout, one after the other."""

    def __init__(self, first: Integration, stepper: Stepper, layout: Layout) -> None:
        self._block = np.zeros(layout.size, np.int64)
        self._own: Integration = layout.viewed(first, self._block)
        self._stepper = stepper
        record = self._own.record
        hits = MOST if len(self._own.system.touches) else 0
        self._desk = desk_for(self._own.gauges, record.turn_states.shape[0], record.bin_low.size, hits)
        self._run: Any = run_members
        self._how: tuple[Any, ...] = ()
        if stepper.long is not None:
            from autobalancer.kernels.many_members import run_members_long

            nodes, watch, powers, _, amplitudes = stepper.long
            self._run = run_members_long
            self._how = nodes, watch, powers, *self._own.long, layout.numbers - count_numbers(amplitudes)

    @property
    def record(self) -> Record:
        """What the member that ran last was asked to keep; the next one overwrites it."""
        return self._own.record

    def run(
        self, fresh: Integers, places: Integers, words: Any, part: range, most: int, flags: Integers, found: Found
    ) -> None:
        """Run some of the members and write down what they leave."""
        own = self._own
        self._run(
            *self._stepper.moving, *self._how, own.system, self._stepper.pair, own.record, own.memory, own.gauges,
            self._desk, self._block, fresh, places, words, part.start, part.stop, most, flags,
            found.rows, found.states, found.counts,
        )  # fmt: skip


class Found(NamedTuple):
    """What members of one layout leave, a row for each."""

    rows: Matrix  # (members, WIDTH + n) measures
    states: Matrix  # (members, states), or (0, 0)
    counts: Any  # (members, 3) accepted, rejected, evaluations; no accepted step: it did not run

    @classmethod
    def room(cls, members: int, balls: int, states: int) -> Found:
        """Room for so many members, with so many numbers of a state."""
        return cls(
            np.full((members, WIDTH + balls), np.nan),
            np.full((members if states else 0, states), np.nan),
            np.zeros((members, 3), np.int64),
        )


# Members whose numbers lie alike in memory: one fresh run, and the words in which each member differs from it.


class Group:
    """Members of one layout. ``numbers`` are theirs in the ensemble."""

    def __init__(self, first: Integration, stepper: Stepper, balls: int) -> None:
        self.first, self.stepper, self.balls = first, stepper, balls
        self.layout = Layout(first, kind_of(first), INTEGRATION_APART)
        fresh = self.layout.packed(first)
        assert fresh is not None
        self.fresh: Integers = fresh
        self.numbers: list[int] = []
        self.later: dict[int, tuple[Assembly, Places]] = {}  # members that are not measured by compiled code alone
        self._blocks: list[tuple[Integers, Any]] = []  # places, and what stands there, (members, places)

    def takes(self, integration: Integration, stepper: Stepper, number: int) -> bool:
        """Take a member, if its numbers lie like those of the others and it is integrated as they are."""
        if _way(stepper) != _way(self.stepper):
            return False
        block = self.layout.packed(integration)
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
        result, (places, words) = self.fresh.copy(), self._blocks[-1]
        result[places] = words[-1]
        return result

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
        result = np.tile(self.fresh[first : first + self.balls], (len(self.numbers), 1))
        for ball in range(self.balls):
            where = np.flatnonzero(places == first + ball)
            if where.size:
                result[:, ball] = words[:, where[0]]
        return result.view(np.float64)

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
