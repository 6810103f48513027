"""All numbers of an integration in one block of words, so that another run is a copy and a few other words.

A word has 64 bits: a float, or a whole number. A block begins with the plain numbers of the tuples in their order, then come the
arrays. Two arrays in one place of memory have one place in the block.
"""

from __future__ import annotations

import math
import os
import struct
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from functools import cached_property
from threading import Lock
from typing import Any, NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from autobalancer.assembly.drive_train import unbalance_jumps
from autobalancer.assembly.places import MOST, Places, desk_for, with_touches
from autobalancer.assembly.system import Assembly, Model
from autobalancer.kernels.compiler.numba_struct import count_numbers, value_type
from autobalancer.kernels.integrators.integrator_state import Memory, memory_type
from autobalancer.kernels.integrators.recording import Record, record_type
from autobalancer.kernels.many_members import DONE, FLAGS, STOP, Found, Members, run_members
from autobalancer.kernels.measures.record_series import WIDTH
from autobalancer.kernels.measures.thresholds import ITERATED
from autobalancer.kernels.measures.workspace import HELD, MeasureInputs, inputs_type
from autobalancer.kernels.system import BALLS, VX, Floats, Integers, Matrix, System, system_type
from autobalancer.progress import interrupts_noted, raise_noted
from autobalancer.results.measure_table import SWEPT
from autobalancer.results.run_arrays import SETTLING_FROM
from autobalancer.simulation.record import Envelope, LastRevolutions, Sampling, record_for
from autobalancer.simulation.steppers import Stepper, rotor_modes, stepper_for
from autobalancer.studies.variations import completed, gauges_for

BLOCK = 512  # members whose words are written down together
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

    @cached_property
    def floats(self) -> NDArray[np.bool_]:
        """Which words of a block are floats."""
        return self._kinds_of_words[0]

    @cached_property
    def plain(self) -> NDArray[np.bool_]:
        """Which of these stand in arrays of numbers of one kind."""
        return self._kinds_of_words[1]

    @cached_property
    def tolerances(self) -> Integers:
        """The words of absolute tolerances."""
        leaves = [self._by_path[path] for path in ("memory.absolute", "long.0.absolute") if self.has(path)]
        return np.concatenate([leaf.first + np.arange(math.prod(leaf.shape or ())) for leaf in leaves])

    @cached_property
    def _kinds_of_words(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        floats, plain = np.zeros((2, self.size), np.bool_)
        for leaf in self._order:
            if leaf.shape is None:
                floats[leaf.first] = leaf.dtype.kind == "f"
            elif leaf.first >= 0:
                each, count = leaf.dtype.itemsize // 8, math.prod(leaf.shape)
                own = np.full(each, leaf.dtype.kind in "fc")
                for kind, offset, *_ in (leaf.dtype.fields or {}).values():
                    own[offset // 8 : (offset + kind.itemsize) // 8] = kind.base.kind in "fc"
                where = slice(leaf.first, leaf.first + each * count)
                floats[where], plain[where] = np.tile(own, count), leaf.dtype.kind in "fc"
        return floats, plain


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


NOT_EMPTY = ("system.impacts",)  # room that a run need not find empty
ASKABLE = (*(one.name for one in SWEPT), "verdict")  # measures of a member
# what measures need (results/measure_table.py) that is not in the envelope
OF_TURNS, OF_END = {"turns", "planes", "forces", "rotor"}, {"final_angle", "impacts"}
# for which the envelope is compared with the last revolutions, or says whether balls rest
MIXED = {"residual_vibration", "vibration", "verdict", *(one.name for one in SWEPT if one.of_rest)}


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
        self._given: tuple[Any, ...] = self._own.system, stepper.pair, record, self._own.memory
        self._first_number = 0
        if stepper.long is not None:
            from autobalancer.kernels.many_members import run_members_long

            nodes, watch, powers, _, amplitudes = stepper.long
            memory, own_amplitudes = self._own.long
            self._first_number = layout.numbers - count_numbers(amplitudes)
            self._run = run_members_long
            self._given = (
                nodes, watch, self._own.system, (stepper.pair, powers), record, (self._own.memory, memory), own_amplitudes,
            )  # fmt: skip

    @property
    def record(self) -> Record:
        """What the member that ran last was asked to keep; the next one overwrites it."""
        return self._own.record

    def run(self, fresh: Integers, places: Integers, words: Any, most: int, flags: Integers, found: Found) -> None:
        """Run members with these ``words`` and write down what they leave."""
        members = Members(self._block, fresh, places, words, most, flags, self._first_number)
        self._run(*self._stepper.moving, *self._given, (self._own.gauges, self._desk), members, found)


# Members whose numbers lie alike in memory: one fresh run, and the words in which each member differs from it.


class Group:
    """Members of one layout. ``numbers`` are theirs in the ensemble."""

    def __init__(self, first: Integration, stepper: Stepper, balls: int) -> None:
        self.first, self.stepper, self.balls = first, stepper, balls
        self.layout = Layout(first, kind_of(first), NOT_EMPTY)
        fresh = self.layout.packed(first)
        assert fresh is not None
        self.fresh: Integers = fresh
        self.numbers: list[int] = []
        self.later: dict[int, tuple[Assembly, Places]] = {}  # members that are not measured by compiled code alone
        # places, members, and what stands there of some of them, (rows, places)
        self._blocks: list[tuple[Integers, int, Callable[[Any], Any]]] = []

    def takes(self, integration: Integration, stepper: Stepper, number: int) -> bool:
        """Take a member, if its numbers lie like those of the others and it is integrated as they are."""
        block = self.block_of(integration, stepper)
        if block is None:
            return False
        self.add([number], where := np.flatnonzero(block != self.fresh), block[None, where])
        return True

    def block_of(self, integration: Integration, stepper: Stepper) -> Integers | None:
        """The words of a member; None if they lie in another way, or it is integrated in another."""
        return self.layout.packed(integration) if _stepper_key(stepper) == _stepper_key(self.stepper) else None

    def block_like_first(self, assembly: Assembly, places: Places, plan: Plan) -> Integers | None:
        """The words of an assembled member with modes in the order and phases of the first one's; None as above.

        None, too, if a measure of it is found after the run.
        """
        one, stepper = fresh_integration(assembly, places, plan)
        block = self.block_of(one, stepper)
        if block is None or one.gauges.scalars[HELD] == ITERATED:
            return None
        if assembly.model is Model.PLANAR or not one.long:
            return block
        like = self.first.long[1]
        modes = rotor_modes(assembly.system, assembly.state, assembly.critical_speeds, like=like)
        return None if modes is None else self.layout.packed(one._replace(long=(one.long[0], modes)))

    def add(self, numbers: Sequence[int], places: Integers, words: Any) -> None:
        """Take members by their words, (members, places), among which are all in which they differ."""
        other = (words != self.fresh[places]).any(axis=0)
        self.add_later(numbers, places[other], words[:, other].__getitem__)

    def add_later(self, numbers: Sequence[int], places: Integers, words_of_rows: Callable[[Any], Any]) -> None:
        """The same of members whose words, (rows, places), are worked out when some of them run."""
        self.numbers.extend(numbers)
        self._blocks.append((places, len(numbers), words_of_rows))

    def last(self) -> Integers:
        """All words of the member that was taken last."""
        result, (places, count, words) = self.fresh.copy(), self._blocks[-1]
        result[places] = words(count - 1)
        return result

    def places(self) -> Integers:
        """Where members differ from the fresh run."""
        return np.unique(np.concatenate([*(where for where, _, _ in self._blocks), np.zeros(0, np.int64)]))

    def words(self, part: range, places: Integers) -> Any:
        """What some members have at the :meth:`places`, (members, places)."""
        words, first = np.tile(self.fresh[places], (len(part), 1)), 0
        for where, count, of_rows in self._blocks:
            begin, end = max(part.start, first), min(part.stop, first + count)
            if begin < end:
                rows = slice(begin - part.start, end - part.start)
                words[rows, np.searchsorted(places, where)] = of_rows(slice(begin - first, end - first))
            first += count
        return words

    def starts(self) -> Floats:
        """Ball angles at the start, (members, balls)."""
        first = self.layout.place("memory.state", BALLS) if self.balls else 0
        result, begin = np.tile(self.fresh[first : first + self.balls], (len(self.numbers), 1)), 0
        for where, count, of_rows in self._blocks:
            own = np.flatnonzero((where >= first) & (where < first + self.balls))
            for rows in range(0, count if own.size else 0, BLOCK):
                part = slice(rows, min(rows + BLOCK, count))
                result[begin + part.start : begin + part.stop, where[own] - first] = of_rows(part)[:, own]
            begin += count
        return result.view(np.float64)

    def bench(self) -> Bench:
        """A place for one thread."""
        return Bench(self.first, self.stepper, self.layout)

    def room(self, keep_states: bool, count: int | None = None) -> Found:
        """Room for what all members leave, or ``count`` of them."""
        members, states = len(self.numbers) if count is None else count, self.first.memory.state.size
        return Found(
            np.full((members, WIDTH + self.balls), np.nan),
            np.full((members, states) if keep_states else (0, 0), np.nan),
            np.zeros((members, 3), np.int64),
        )


def _stepper_key(stepper: Stepper) -> tuple[Any, ...]:
    """All that says how a member is integrated, besides its numbers."""
    long = stepper.long
    return stepper.method, stepper.moving, None if long is None else (long.nodes, long.watch)


class Groups:
    """All members, sorted by their layout."""

    def __init__(self, plan: Plan) -> None:
        self.plan, self.all = plan, list[Group]()
        self.interpolated, self.error = 0, 0.0  # members between assembled ones, and how far their numbers may be off
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


# Words of members as polynomials of their parameters through those of a few assembled ones.


DEGREES = (2, 3, 4, 6, 8, 12)  # of the polynomials, tried in this order
SAVED = 5  # members for each one that is assembled, at least
FEWEST = 55  # members below which no degree saves that
CHECKS = 8  # assembled members with which the polynomials are compared, and a quarter of their terms
DECADES = 3.0  # ratio of the greatest to the least value beyond which its logarithm counts
TWIN = 1e-10  # by which members differ whose words differ by little more than rounding
NOISE = 10.0  # times that, in the words of an array nearby, which polynomials need not meet
NEXT_TO, NEARBY = 33, 129  # words: of the differences of such members, of sizes times the precision of a float
ROUGHLY = 0.01  # by which absolute tolerances may be off


class Polynomials(NamedTuple):
    """Words of members between assembled ones, (members, places)."""

    block: Integers  # of a node
    places: Integers
    same: Integers  # which of these are those of the block
    varied: Integers  # the others
    coefficients: Matrix  # (terms, varied)
    terms: Matrix  # (members, terms)
    nodes: Integers  # members that are met
    error: float  # greatest relative difference from assembled members that are no nodes

    def words(self, rows: Integers) -> Integers:
        """Those of some of the members."""
        words = np.tile(self.block[self.places], (len(rows), 1))
        words[:, self.varied] = words_of(self.terms[rows] @ self.coefficients)
        return words

    def of_words(self, words: Sequence[dict[int, int]], layout: Layout) -> Polynomials | None:
        """Those of other words, which stand in the same places of all nodes; None if a whole number differs."""
        places, block = np.array(sorted(words[0]), np.int64), self.block.copy()
        met = np.array([[own[place] for place in places.tolist()] for own in words], np.int64)
        block[places], varied = met[0], (met != met[0]).any(axis=0)
        if not layout.floats[places[varied]].all():
            return None
        coefficients = np.asarray(np.linalg.solve(self.terms[self.nodes], met[:, varied].view(np.float64)), np.float64)
        return self._replace(
            block=block,
            places=places,
            same=np.flatnonzero(~varied),
            varied=np.flatnonzero(varied),
            coefficients=coefficients,
        )


class Interpolated:
    """Words of many members: polynomials of their parameters, and those of their starts.

    ``orders`` are polynomials of contacts, ``which`` says for each member which of them, from 1, are its own; 0 are those of
    all. ``starts`` are places and words, (members, places), that are known exactly.
    """

    def __init__(
        self, polynomials: Polynomials, orders: Sequence[Polynomials], which: Integers, starts: tuple[Integers, Any]
    ) -> None:
        self._all, self._orders, self._which, self._starts = polynomials, orders, which, starts
        everywhere = [polynomials.places, *(one.places for one in orders), starts[0]]
        self.places = np.unique(np.concatenate(everywhere))
        self._where = [np.searchsorted(self.places, own) for own in everywhere]

    def words(self, part: slice) -> Integers:
        """Those of a part of the members, (rows, places)."""
        rows = np.arange(part.start, part.stop)
        words = np.tile(self._all.block[self.places], (rows.size, 1))
        words[:, self._where[0]] = self._all.words(rows)
        for number, one in enumerate(self._orders, 1):
            its = np.flatnonzero(self._which[rows] == number)
            words[np.ix_(its, self._where[number])] = one.words(rows[its])
        words[:, self._where[-1]] = self._starts[1][rows]
        return words


def fitted(
    values: Matrix, block_of: Callable[[Floats], Integers | None], fresh: Integers, layout: Layout, tolerance: float
) -> Polynomials | None:
    """Polynomials through members with these ``values`` of their parameters, (members, parameters).

    ``block_of`` assembles a member with such values; its words differ from the ``fresh`` ones. Nodes are members that are nearly
    a best choice for interpolation, by a pivoted decomposition of all monomials (Sommariva and Vianello, 2009). None if no
    degree meets other members within the tolerance and rounding, or if assembling nodes would save little.
    """
    from scipy.linalg import qr

    scaled = _scaled(values)
    distinct = np.unique(scaled, axis=0, return_index=True)[1]
    drawn, known = np.random.default_rng(0).permutation(distinct), dict[int, Integers]()
    noise: Floats | None = None
    before = np.inf
    # more terms until members that were not used for the fit are met
    for degree in DEGREES:
        terms = _terms(scaled, degree)
        count = terms.shape[1]
        checks = drawn[: CHECKS + count // 4]
        if SAVED * (count + checks.size) > distinct.size:
            return None
        offered = np.unique(np.concatenate([drawn[checks.size :][: 40 * count], scaled.argmin(0), scaled.argmax(0)]))
        # the members from which the polynomials follow with the least growth of errors
        nodes = offered[qr(terms[offered].T, mode="economic", pivoting=True)[2][:count]]
        if noise is None:
            noise = _noise(values[checks[0]], block_of, layout)
            if noise is None:
                return None
        for row in (*nodes.tolist(), *checks.tolist()):
            block = known[row] if row in known else block_of(values[row])
            if block is None:
                return None
            known[row] = block
        met, others = (np.array([known[row] for row in rows.tolist()]) for rows in (nodes, checks))
        places = np.flatnonzero((met != met[0]).any(axis=0) | (others != met[0]).any(axis=0))
        if not layout.floats[places].all():
            return None
        numbers = met[:, places].view(np.float64)
        coefficients = np.linalg.solve(terms[nodes], numbers)
        apart = np.abs(terms[checks] @ coefficients - others[:, places].view(np.float64)).max(axis=0, initial=0.0)
        # rounding of an assembled member does not count as an error of its polynomial
        off = np.maximum(apart - NOISE * noise[places], 0.0) / np.maximum(np.abs(numbers).max(axis=0), 1e-300)
        rough = np.isin(places, layout.tolerances)
        error = float(off[~rough].max(initial=0.0))
        if error <= tolerance and (off[rough] <= ROUGHLY).all():
            everywhere = np.union1d(np.flatnonzero(met[0] != fresh), places)
            varied = np.isin(everywhere, places)
            same, other = np.flatnonzero(~varied), np.flatnonzero(varied)
            return Polynomials(met[0], everywhere, same, other, coefficients, terms, nodes, error)
        if not error < before:  # more terms do not help
            return None
        before = error
    return None


def _noise(values: Floats, block_of: Callable[[Floats], Integers | None], layout: Layout) -> Floats | None:
    """What rounding alone makes of every word: members that differ by less, compared; in an array that of words nearby."""
    from scipy.ndimage import maximum_filter1d

    blocks = [block_of(values * (1.0 + size)) for size in (0.0, TWIN, -TWIN)]
    if any(block is None for block in blocks):
        return None
    own = np.where(layout.floats, np.array(blocks), 0).view(np.float64)
    own[~np.isfinite(own)] = 0.0
    apart, rounding = np.abs(own - own[0]).max(axis=0), np.finfo(float).eps * np.abs(own[0])
    near, nearby = (
        maximum_filter1d(np.where(layout.plain, one, 0.0), size, mode="constant")
        for one, size in ((apart, NEXT_TO), (rounding, NEARBY))
    )
    return np.asarray(np.where(layout.plain, np.maximum(near, nearby), np.maximum(apart, rounding)))


def _scaled(values: Matrix) -> Matrix:
    """Parameters from -1 to 1; their logarithms where they span decades, without those that are alike."""
    low, high = values.min(axis=0), values.max(axis=0)
    columns = [
        np.log(column) if least > 0.0 and most > DECADES * least else column
        for column, least, most in zip(values.T, low, high, strict=True)
        if most > least
    ]
    return np.array([2.0 * (c - c.min()) / np.ptp(c) - 1.0 for c in columns]).reshape(len(columns), -1).T


def _terms(scaled: Matrix, degree: int) -> Matrix:
    """Products of Chebyshev polynomials up to a degree in all, (members, terms)."""
    each = np.polynomial.chebyshev.chebvander(scaled, degree)
    result = [(np.ones(len(scaled)), degree)]
    for own in each.swapaxes(0, 1):
        result = [(term * own[:, power], left - power) for term, left in result for power in range(left + 1)]
    return np.array([term for term, _ in result]).T


# Groups of members run by threads that need no lock, until all are done or somebody stops them.


PART, LEAST = 0.2, 0.004  # s, that a thread works between two looks, and that it takes at least
Progress = Callable[[int, int], None]


class Ran(NamedTuple):
    """A group that was run."""

    group: Group
    found: Found
    starts: Floats  # (members, balls) ball angles


class Shared(ABC):
    """Work of so many pieces that threads share: each takes its next part of them, with flags of its own."""

    def __init__(self, count: int) -> None:
        self.flags: list[Any] = []
        self.seconds = 0.0  # of a core, in all
        self._count, self._next, self._lock, self._each = count, 0, Lock(), 0.0

    @abstractmethod
    def bench(self) -> Any:
        """A place for one thread."""

    @abstractmethod
    def size(self, left: int) -> int:
        """Of the next part, if so many pieces are left."""

    @abstractmethod
    def run(self, part: range, bench: Any, flags: Any) -> None:
        """Do a part."""

    @abstractmethod
    def done(self) -> int:
        """How much is done."""

    def stop(self) -> None:
        """Let all threads stop at their next look."""
        for flags in self.flags:
            flags[STOP] = 1

    def thread(self, flags: Any, look: Callable[[], None] | None = None) -> None:
        """Work until nothing is left; ``look`` is called between two parts."""
        bench = self.bench()
        while not flags[STOP]:
            with self._lock:
                part = range(self._next, min(self._next + self.size(self._count - self._next), self._count))
                self._next = part.stop
            if not part:
                return
            begin = time.thread_time()
            self.run(part, bench, flags)
            spent = time.thread_time() - begin
            with self._lock:
                self.seconds += spent
                self._each = spent / len(part)
            if look is not None:
                look()


class Work(Shared):
    """The members of one group."""

    def __init__(self, group: Group, most: int, keep_states: bool) -> None:
        super().__init__(len(group.numbers))
        self.group, self.found, self._most = group, group.room(keep_states), most
        self._places = group.places()

    @property
    def ran(self) -> Ran:
        """What there is of it."""
        return Ran(self.group, self.found, self.group.starts())

    def bench(self) -> Bench:
        """A place for one thread."""
        return self.group.bench()

    def done(self) -> int:
        """How many members are done."""
        return sum(int(flags[DONE]) for flags in self.flags)

    def size(self, left: int) -> int:
        """Fewer towards the end so that all threads end together."""
        share = self._each * left / (2 * len(self.flags))
        size = max(1, int(min(PART, max(share, LEAST)) / self._each)) if self._each > 0.0 else 1
        return min(size, -(-self._count // 8))

    def run(self, part: range, bench: Bench, flags: Any) -> None:
        """Run members."""
        words, found = self.group.words(part, self._places), self.found.part(part)
        bench.run(self.group.fresh, self._places, words, self._most, flags, found)


def run_groups(
    groups: Groups, workers: int | None, progress: Progress | None, keep_states: bool = False
) -> tuple[list[Ran], float, bool]:
    """Run all members that are ready; what they left, seconds of a core in all, and whether somebody interrupted any of it."""
    workers = workers if workers is not None else os.cpu_count() or 1
    total, before, ran, seconds = sum(len(group.numbers) for group in groups.all), 0, list[Ran](), 0.0
    stopped = False
    for group in groups.all:
        work = Work(group, groups.plan.max_steps, keep_states)
        if not stopped:
            try:
                run_threads(work, min(workers, len(group.numbers)), before, total, progress)
            except KeyboardInterrupt:
                stopped = True
        _complete(work.ran, groups.plan.end)
        ran.append(work.ran)
        seconds, before = seconds + work.seconds, before + work.done()
    return ran, seconds, stopped or groups.interrupted


@interrupts_noted(keep=False)
def run_threads(work: Shared, workers: int, before: int, total: int, progress: Progress | None) -> None:
    """Let so many threads do a piece of work; ``before`` of the ``total`` are done already.

    Raises
    ------
    KeyboardInterrupt
        When somebody interrupts them, once all threads have stopped.
    """
    work.flags = [np.zeros(FLAGS, np.int64) for _ in range(workers)]
    told = -1

    def look() -> None:
        nonlocal told
        raise_noted()
        if progress is not None and (done := before + work.done()) != told:
            told = done
            progress(done, total)

    if workers == 1:
        work.thread(work.flags[0], look)
        return
    with ThreadPoolExecutor(workers) as pool:
        waiting: set[Future[None]] = {pool.submit(work.thread, flags) for flags in work.flags}
        try:
            while waiting:
                finished, waiting = wait(waiting, timeout=PART)
                look()
                for future in finished:
                    future.result()
        except BaseException:
            work.stop()
            raise


def _complete(ran: Ran, end: float) -> None:
    """What of the measures no compiled code finds."""
    for row, number in enumerate(ran.group.numbers):
        if number in ran.group.later and ran.found.counts[row, 0] > 0:
            assembly, places = ran.group.later[number]
            completed(ran.found.rows[row], assembly, places, gauges_for(assembly, places, end))
