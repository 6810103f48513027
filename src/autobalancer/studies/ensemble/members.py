"""The members of an ensemble: each the machine with its own values, seed and starts."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import replace
from functools import lru_cache
from itertools import islice
from typing import Any, Literal, NamedTuple

import numpy as np

from autobalancer.assembly.contact import ring, set_contacts
from autobalancer.assembly.places import Places, meetings_of, places_of, with_touches
from autobalancer.assembly.quantities import with_value_at
from autobalancer.assembly.reduced_rotor import top_speed
from autobalancer.assembly.system import (
    MASS_SPREAD,
    Assembly,
    Model,
    equal_groups,
    planar_sizes,
    start_angles,
    unbalance_courses,
    unbalances_over,
)
from autobalancer.catalog.resolve import Ball, occupied_angle, resolve
from autobalancer.drag.viscous import ViscousDrag
from autobalancer.errors import CatalogError, MachineError, QuestionError, UnitError
from autobalancer.kernels.records import CONTACT
from autobalancer.kernels.system import BALLS, VY, Floats, Integers, X, Y
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.progress import interrupts_noted
from autobalancer.random_numbers import generator
from autobalancer.simulation.fluid_lag import prepare
from autobalancer.studies.ensemble.columns import Changed, Columns, Described, Words, ball_of
from autobalancer.studies.ensemble.layout import (
    BLOCK,
    FEWEST,
    Group,
    Groups,
    Interpolated,
    Plan,
    Polynomials,
    bits,
    fitted,
    fresh_integration,
    words_of,
)
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
        self._machine = lru_cache(maxsize=KEPT)(lambda row: self._started(self.varied(row), row))

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
        return _ready(self.machine_of(number), int(self.seeds[number]), plan)

    def ready_with(self, number: int, values: Mapping[str, float], plan: Plan) -> tuple[Assembly, Places]:
        """A member ready to run with other values of some parameters."""
        row = self.row(number)
        parameters = {**dict(zip(self.columns.parameters, self.columns.row(row), strict=True)), **values}
        machine = with_variation(self.machine, parameters, tuple(parameters.values()))
        return _ready(self._started(machine, row), int(self.seeds[number]), plan)

    def sorted(
        self,
        plan: Plan,
        how: Impossible,
        *,
        follow: bool = True,
        interpolate: bool = False,
        keep_on_interrupt: bool = False,
    ) -> tuple[Groups, dict[int, str]]:
        """All members made ready, and why some of them cannot run; nothing runs for it.

        With ``follow`` those that differ in numbers are not assembled. With ``interpolate`` numbers of rotors that tilt or bend
        may come from a few assembled members between which they are smooth, see :class:`Class`. With ``keep_on_interrupt``
        Ctrl-C ends it with the members that are ready by then.

        Raises
        ------
        MachineError, UnitError, QuestionError, CatalogError
            For the first that cannot run, unless those are to be recorded.
        """
        with interrupts_noted() if keep_on_interrupt else nullcontext(list[int]()) as noted:
            try:
                found = self._sorted(plan, how, noted, follow=follow, interpolate=interpolate)
            except Differs:
                found = self._sorted(plan, how, noted, follow=False)
            noted.clear()  # those that are ready are to run
            return found

    def _sorted(
        self, plan: Plan, how: Impossible, noted: Sequence[int] = (), *, follow: bool, interpolate: bool = False
    ) -> tuple[Groups, dict[int, str]]:
        groups, reasons, classes = Groups(plan), dict[int, str](), dict[Any, Class]()
        names: list[str] | None = None
        interpolate = interpolate and self.columns.count > FEWEST

        def take(number: int) -> None:
            nonlocal names
            if not follow:
                groups.add(number, *self.ready(number, plan))
                return
            if names is None:
                names = followed(self, number, plan)
                if interpolate and len({class_of(self, one, names) for one in range(self.count)}) > FEWEST:
                    names = [
                        name
                        for name, values in self.columns.parameters.items()
                        if name in names or _are_numbers(values)
                    ]
            key = class_of(self, number, names)
            if key not in classes:
                classes[key] = Class(self, groups, names, interpolate=interpolate)
            classes[key].take(number)

        def take_all(numbers: Iterable[int], take: Callable[[int], None]) -> None:
            for number in numbers:
                if noted:
                    groups.interrupted = True
                    return
                try:
                    take(number)
                except REFUSED as error:
                    text = f"{self._named(number)}{error}"
                    if how == "refuse":
                        raise next(kind for kind in REFUSED if isinstance(error, kind))(text) from None
                    reasons[number] = text

        take_all(range(self.count), take)
        for one in classes.values():
            take_all(one.interpolated(), one.follow)
            one.finish()
        return groups, dict(sorted(reasons.items()))

    def _named(self, number: int) -> str:
        row = self.row(number)
        starts = {name: values[row] for name, values in self.columns.starts.items()}
        told = variation_text([*self.columns.parameters, *starts], (*self.columns.row(row), *starts.values()))
        return f"{self._name} {number + 1}{', ' + told if told else ': '}" if self._name else told

    def _started(self, machine: Machine, row: int) -> Machine:
        starts = self.columns.starts
        return (
            with_starts(machine, {name: float(values[row]) for name, values in starts.items()}) if starts else machine
        )


def _ready(machine: Machine, seed: int, plan: Plan) -> tuple[Assembly, Places]:
    assembly = prepare(machine, plan.end, seed=seed, mass_spread=MASS_SPREAD, max_steps=plan.max_steps)
    return assembly, places_of(machine, assembly)


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


# Members sorted into groups: one of each class is assembled, the others follow it where they can.


TRIED = 3  # other values of a parameter that say whether members can follow it
UNBALANCE = "unbalance"  # in the names of parameters of which one can be followed


class Waiting(NamedTuple):
    """A member that follows, before its words are written down."""

    number: int
    values: list[Any]  # of its parameters
    words: Words  # besides those of parameters whose numbers are known


class Differs(Exception):
    """A member that followed is not the one that is assembled; caught in members.py, where all are assembled then."""


class Between(NamedTuple):
    """A member between assembled ones: what its start alone makes of its words, and the order of its balls."""

    number: int
    words: Words
    order: Any


class Class:
    """Members that differ in parameters that can be followed, and in their starts.

    Where they would have to be described one by one, on rotors that tilt or bend, those whose parameters are numbers wait
    until all are known. Then a few of them are assembled, and the words of the others are polynomials of the parameters,
    if these meet more assembled ones within the tolerance of the run.
    """

    def __init__(self, members: Members, groups: Groups, names: list[str], *, interpolate: bool = False) -> None:
        self._members, self._groups, self._names = members, groups, names
        self._interpolate, self._between = interpolate, list[Between]()
        self._first = 0  # the member that was assembled first
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
        start = None
        if self._interpolate and self._follower is not None:
            machine = members.varied(members.row(number))
            if self._follower.between(machine, self._values(number)):
                start = self._follower.start(machine, *self._start(number))
        if start is not None:
            self._between.append(Between(number, *start))
            return
        self.follow(number)

    def _values(self, number: int) -> list[Any]:
        row = self._members.row(number)
        return [self._members.columns.parameters[name][row] for name in self._names]

    def follow(self, number: int) -> None:
        """Take a member by what is different in it, or assemble it."""
        members = self._members
        if self._follower is not None:
            row, values = members.row(number), self._values(number)
            words = self._follower.words(values, lambda: members.varied(row), *self._start(number))
            if words is not None:
                self._waiting.append(Waiting(number, values, words))
                if len(self._waiting) == BLOCK:
                    self.finish()
                return
        self._groups.add(number, *members.ready(number, self._groups.plan))

    def interpolated(self) -> list[int]:
        """Take the members that wait to lie between assembled ones; the numbers of those that cannot."""
        waiting, self._between = self._between, []
        numbers, group, follower = [one.number for one in waiting], self._group, self._follower
        if not waiting or group is None or follower is None:
            return []
        plan, made = self._groups.plan, dict[bytes, Changed]()

        def block_of(values: Floats) -> Integers | None:
            given = dict(zip(self._names, values.tolist(), strict=True))
            assembly, places = self._members.ready_with(self._first, given, plan)
            made[values.tobytes()] = Changed({}, places.machine, assembly.balls, assembly, again=True)
            return group.block_like_first(assembly, places, plan)

        values = np.array([self._values(number) for number in numbers], np.float64)
        try:
            found = fitted(values, block_of, group.fresh, group.layout, plan.tolerance)
        except REFUSED:
            return numbers
        if found is None:
            return numbers
        orders = sorted({one.order for one in waiting if one.order})
        contacts = list[Polynomials]()
        for order in orders:
            words = [follower.contacts_in(made[row.tobytes()], order) for row in values[found.nodes]]
            own = found.of_words([one for one in words if one is not None], group.layout) if None not in words else None
            if own is None:
                return numbers
            contacts.append(own)
        which = np.array([1 + orders.index(one.order) if one.order else 0 for one in waiting], np.int64)
        places = np.array(sorted({place for one in waiting for place in one.words}), np.int64)
        usual = dict(zip(places.tolist(), found.block[places].tolist(), strict=True))
        starts = np.array([list((usual | one.words).values()) for one in waiting], np.int64).reshape(len(waiting), -1)
        its = Interpolated(found, contacts, which, (places, starts))
        group.add_later(numbers, its.places, its.words)
        self._groups.interpolated += len(waiting)
        self._groups.error = max(self._groups.error, found.error)
        return []

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
        self._first = number
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
    described, texts = Described(varied, assembly, plan.end, plan.tolerance), list[str]()
    for name, values in columns.items():
        own = repr(values[members.row(number)])
        others = list(islice((value for value in values if repr(value) != own), TRIED))
        if can_follow(machine, assembly, name) or any(_follows(described, varied, name, other) for other in others):
            texts.append(name)
    return texts


def _follows(described: Described, machine: Machine, name: str, value: Any) -> bool:
    """Whether a machine with this value need not be assembled; one that is impossible is no answer."""
    try:
        return described.follows(with_variation(machine, [name], (value,)))
    except (MachineError, UnitError, QuestionError):
        return False


def _are_numbers(values: Sequence[Any]) -> bool:
    return all(isinstance(value, float | int) for value in values)


def class_of(members: Members, number: int, names: list[str]) -> Any:
    """What members must have in common: the values of all parameters that are not followed."""
    row = members.row(number)
    return tuple(repr(values[row]) for name, values in members.columns.parameters.items() if name not in names)


# Members that follow an assembled one by a few numbers: drag, unbalance, starts, and what described.py finds of their
# machine.
#
# What a column touches is worked out by the functions that assemble a machine, so a member has the same bits either
# way. A few members of each kind are assembled all the same and compared word by word; if one differed, all would be
# assembled.


_BETA = re.compile(r"balancers\[(\d+)\]\.races\[(\d+)\]\.drag\.damping")
_PART = re.compile(r"unbalances\[(\d+)\]\.(moment|mass|radius|angle)")
Start = tuple[int, dict[str, float]]  # seed, and the columns of starts


def can_follow(machine: Machine, assembly: Assembly, name: str) -> bool:
    """Whether a column changes only numbers that :class:`Follower` knows."""
    if assembly.resolved or any(ball.drag_curve is not None or ball.slipstream for ball in assembly.balls):
        return False
    if name == "drag":
        return bool(assembly.balls)
    if result := _BETA.fullmatch(name):
        return isinstance(_race(machine, int(result[1]) - 1, int(result[2]) - 1).drag, ViscousDrag)
    if assembly.model is not Model.PLANAR or not isinstance(machine.rotor, PlanarRotor):
        return False
    if name == "unbalance":
        return bool(machine.unbalances)  # one of 0 has no part that could grow
    result = _PART.fullmatch(name)
    return bool(result and getattr(machine.unbalances[int(result[1]) - 1], result[2]) is not None)


def starts_can_follow(machine: Machine, assembly: Assembly, names: Sequence[str]) -> bool:
    """Whether members may start elsewhere without an assembly of their own; ``names`` are those of the columns of starts."""
    forces = any(race.forces for balancer in machine.balancers for race in balancer.races)
    walls = any(race.partitions is not None for balancer in machine.balancers for race in balancer.races)
    held = any(ball.adherence > 0.0 for ball in assembly.balls)
    speeds = any(ball_of(name)[0] == "ball_speed" for name in names)
    return not (assembly.resolved or forces or walls or (held and speeds) or equal_groups(machine, resolve(machine)))


class Follower:
    """Words of members that differ from an assembled one in these ``names`` of parameters and in their starts.

    ``begin`` is the start of the assembled one. Parameters that change more than a few numbers that are known here are
    ``described``: the machine of a member says what is different.
    """

    def __init__(
        self,
        group: Group,
        machine: Machine,
        assembly: Assembly,
        names: Sequence[str],
        tolerance: float,
        begin: Start,
        described: Described | None,
    ) -> None:
        self._group, self._machine, self._assembly, self._tolerance = group, machine, assembly, tolerance
        self._begin, self._described = begin, described
        self._parameters = [] if described is not None else [self._of_parameter(name) for name in names]
        self._own = Changed({}, machine, assembly.balls, assembly, again=False)
        self._last: tuple[Any, Changed] = (None, self._own)
        self._orders: dict[Any, Words] = {}
        self._seen: dict[Any, Floats] = {}  # ball angles of one member in each order
        layout, self._block = group.layout, group.last()
        self._state, self._start = layout.place("memory.state", 0), layout.place("memory.start", 0)
        touching = len(assembly.system.contacts)
        self._wraps = [layout.place("system.contacts", i, field="wrap") for i in range(touching)]

    def words(
        self, values: Sequence[Any], machine: Callable[[], Machine], seed: int, starts: dict[str, float]
    ) -> Words | None:
        """The words of a member besides those :meth:`of_parameters`; None if it has to be assembled: a value may be impossible.

        ``machine`` is what the values make of it, without its start.
        """
        own, result = self._own, dict[int, int]()
        if self._described is not None:
            if self._last[0] != tuple(values):
                changed = self._described.changed(machine(), self._group.layout, self._block)
                if changed is None:
                    return None
                if not changed.assembly is self._last[1].assembly is self._assembly:
                    self._orders = {}  # of other balls
                self._last = tuple(values), changed
            own = self._last[1]
            result = dict(own.words)
        elif not all(isinstance(value, float | int) and math.isfinite(value) and value > 0.0 for value in values):
            return None
        if (seed, starts) == self._begin and not own.again:
            return result
        return result if self._follow_start(own, seed, starts, result) else None

    def of_parameters(self, values: Sequence[Sequence[Any]]) -> dict[int, Integers]:
        """Words of many members that follow, at each place an array over them; ``values`` has a row of each of them."""
        result: dict[int, Integers] = {}
        for i, follow in enumerate(self._parameters):
            result |= follow(np.array([float(row[i]) for row in values]))
        return result

    def _of_parameter(self, name: str) -> Callable[[Floats], dict[int, Integers]]:
        layout, balls = self._group.layout, self._assembly.balls
        match = _BETA.fullmatch(name)
        if name == "drag" or match:
            race = (int(match[1]) - 1, int(match[2]) - 1) if match else None
            own = [i for i, ball in enumerate(balls) if race in (None, (ball.balancer, ball.race))]
            first, second = ([layout.place("system.balls", i, field=f) for i in own] for f in ("drag", "viscous"))
            places = list(zip(first, second, [balls[i] for i in own], strict=True))

            def follow_drag(values: Floats) -> dict[int, Integers]:
                result = {drag: words_of(values) for drag, _, _ in places}
                return result | {viscous: words_of(values / ball.orbit_radius**2) for _, viscous, ball in places}

            return follow_drag
        part = _PART.fullmatch(name)
        number, key = (int(part[1]) - 1, part[2]) if part else (0, "moment")
        fields = [f"unbalance{field}" for field in ("_x", "_y", "_rate_x", "_rate_y")]
        rows, parts = self._assembly.system.drive.segments, self._machine.unbalances
        segments = [
            [layout.place("system.drive.segments", i, field=field) for field in fields] for i in range(len(rows))
        ]
        courses, absolute = unbalance_courses(self._machine, rows.start.tolist()), layout.place("memory.absolute", 0)

        def follow_unbalance(values: Floats) -> dict[int, Integers]:
            ones = [parts[number].model_copy(update={key: value}) for value in values.tolist()]
            sizes, vectors = np.array([one.size for one in ones]), np.array([one.vector for one in ones])
            each = [vectors if i == number else one.vector for i, one in enumerate(parts)]
            resultant = unbalances_over(courses, [one.real for one in each], [one.imag for one in each])
            result = {
                place: words_of(own + np.zeros(len(ones)))
                for places, numbers in zip(segments, resultant, strict=True)
                for place, own in zip(places, numbers, strict=True)
            }
            moments = [sizes if i == number else one.size for i, one in enumerate(parts)]
            length, velocity, _ = planar_sizes(self._machine, self._assembly.balls, self._assembly.system, moments)
            lengths, velocities = (words_of(self._tolerance * size) for size in (length, velocity))
            return result | {absolute + i: lengths if i in (X, Y) else velocities for i in range(X, VY + 1)}

        return follow_unbalance

    def between(self, machine: Machine, values: Sequence[Any]) -> bool:
        """Whether the words of a member may be functions of its parameters, and take long to work out otherwise."""
        if self._described is None or self._assembly.model is Model.PLANAR:
            return False
        return _are_numbers(values) and self._described.is_costly(machine)

    def start(self, machine: Machine, seed: int, starts: dict[str, float]) -> tuple[Words, Any] | None:
        """What a start alone makes of the words, and the order of the balls; nothing of the start of the assembled one.

        None if such a start may be impossible.
        """
        if (seed, starts) == self._begin:
            return {}, None
        balls = _started(resolve(machine), starts)
        if not _apart(machine, balls):
            return None
        angles = np.array(start_angles(balls, generator(seed)), np.float64)
        words, order = self._of_angles(balls, angles), None
        if len(self._assembly.system.contacts):
            order, wraps = self._order(balls, angles)
            words |= wraps
            self._seen.setdefault(order, angles)
        return words, order

    def contacts_in(self, own: Changed, order: Any) -> Words | None:
        """The contacts of a member with its balls in such an order around their races."""
        return self._contacts_of(own, own.balls, self._seen[order])

    def _follow_start(self, own: Changed, seed: int, starts: dict[str, float], words: Words) -> bool:
        balls = _started(own.balls, starts)
        if not _apart(own.machine, balls):
            return False
        angles = np.array(start_angles(balls, generator(seed)), np.float64)
        contacts = self._contacts(own, balls, angles)
        if contacts is None:
            return False
        words.update(contacts)
        words.update(self._of_angles(balls, angles))
        return True

    def _of_angles(self, balls: tuple[Ball, ...], angles: Floats) -> Words:
        words: Words = {}
        for first in (self._state, self._start):
            for i, (angle, ball) in enumerate(zip(angles, balls, strict=True)):
                words[first + BALLS + i] = bits(angle)
                words[first + BALLS + len(balls) + i] = bits(ball.start_speed)
        return words

    def _contacts(self, own: Changed, balls: tuple[Ball, ...], angles: Floats) -> Words | None:
        """Who is next to whom; for each order the contacts are made once. None if they are of another kind."""
        if not len(self._assembly.system.contacts):
            return {}
        order, wraps = self._order(balls, angles)
        if order not in self._orders:
            made = self._contacts_of(own, balls, angles)
            if made is None:
                return None
            self._orders[order] = made
        return self._orders[order] | wraps

    def _order(self, balls: tuple[Ball, ...], angles: Floats) -> tuple[Any, Words]:
        rings = [ring(members, angles) for members in _races(balls)]
        wraps = {self._wraps[i]: bits(wrap) for links in rings if len(links) > 1 for i, _, wrap in links}
        return tuple((i, j) for links in rings for i, j, _ in links), wraps

    def _contacts_of(self, own: Changed, balls: tuple[Ball, ...], angles: Floats) -> Words | None:
        rows = CONTACT.rows(len(balls))
        fastest = max(top_speed(own.machine) or 0.0, *own.assembly.critical_speeds)
        made = set_contacts(own.machine, balls, angles, rows, fastest)
        system = own.assembly.system._replace(contacts=rows, rebounds=made.rebounds)
        noting, touches = with_touches(own.machine, replace(own.assembly, system=system, balls=balls))
        meetings, rebounds = meetings_of(touches)
        values = {
            "system.contacts": rows,
            "system.rebounds": made.rebounds,
            "system.touches": noting.system.touches,
            "gauges.meetings": meetings,
            "gauges.rebounds": rebounds,
        }
        parts = [self._group.layout.words(path, value) for path, value in values.items()]
        if any(part is None for part in parts) or (rows.rigid != self._assembly.system.contacts.rigid).any():
            return None
        return {place: word for part in parts for place, word in (part or {}).items()}


def _started(balls: tuple[Ball, ...], starts: dict[str, float]) -> tuple[Ball, ...]:
    """The balls with the starts of a member."""
    result = list(balls)
    for name, value in starts.items():
        kind, number = ball_of(name)
        for i in range(len(result)) if number is None else (number,):
            turned = kind == "ball_angle"
            result[i] = replace(result[i], start_angle=value) if turned else replace(result[i], start_speed=value)
    return tuple(result)


def _races(balls: tuple[Ball, ...]) -> list[list[int]]:
    places = sorted({(ball.balancer, ball.race) for ball in balls})
    return [[i for i, ball in enumerate(balls) if (ball.balancer, ball.race) == place] for place in places]


def _race(machine: Machine, balancer: int, race: int) -> Any:
    return machine.balancers[balancer].races[race]


def _apart(machine: Machine, balls: tuple[Ball, ...]) -> bool:
    """Whether given start angles are surely possible."""
    for members in _races(balls):
        given = [balls[i] for i in members if balls[i].start_angle is not None]
        if given and len(given) < len(members):
            return False
        if not given or not _race(machine, given[0].balancer, given[0].race).collisions:
            continue
        for i, one in enumerate(given):
            for other in given[i + 1 :]:
                turn = math.remainder(float(one.start_angle or 0.0) - float(other.start_angle or 0.0), 2.0 * math.pi)
                if abs(turn) < 0.5 * occupied_angle([one, other]):
                    return False
    return True
