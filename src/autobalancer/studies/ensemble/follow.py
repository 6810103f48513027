"""Members that follow an assembled one by a few numbers: drag, unbalance, starts, and what described.py finds of their machine.

What a column touches is worked out by the functions that assemble a machine, so a member has the same bits either way. A few
members of each kind are assembled all the same and compared word by word; if one differed, all would be assembled.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from autobalancer.assembly.contact.meetings import ring, set_contacts
from autobalancer.assembly.contact.touches import with_touches
from autobalancer.assembly.drive import unbalance_courses, unbalances_over
from autobalancer.assembly.gauges import meetings_of
from autobalancer.assembly.mass_spread import equal_groups
from autobalancer.assembly.spatial import top_speed
from autobalancer.assembly.starts import planar_sizes, start_angles
from autobalancer.assembly.system import Assembly, Model
from autobalancer.catalog.resolve import Ball, occupied_angle, resolve
from autobalancer.drag.beta import DragTorque
from autobalancer.kernels.records.guided import CONTACT
from autobalancer.kernels.system import BALLS, VY, Floats, Integers, X, Y
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.random_numbers import generator
from autobalancer.studies.ensemble.columns import ball_of
from autobalancer.studies.ensemble.described import Changed, Described, Words
from autobalancer.studies.ensemble.groups import Group
from autobalancer.studies.ensemble.layout import bits, words_of

_BETA = re.compile(r"balancers\[(\d+)\]\.races\[(\d+)\]\.drag\.beta")
_PART = re.compile(r"unbalances\[(\d+)\]\.(moment|mass|radius|angle)")
Start = tuple[int, dict[str, float]]  # seed, and the columns of starts


def can_follow(machine: Machine, assembly: Assembly, name: str) -> bool:
    """Whether a column changes only numbers that :class:`Follower` knows."""
    if assembly.resolved or any(ball.drag_curve is not None or ball.slipstream for ball in assembly.balls):
        return False
    if name == "drag":
        return bool(assembly.balls)
    if found := _BETA.fullmatch(name):
        return isinstance(_race(machine, int(found[1]) - 1, int(found[2]) - 1).drag, DragTorque)
    if assembly.model is not Model.PLANAR or not isinstance(machine.rotor, PlanarRotor):
        return False
    if name == "unbalance":
        return True
    found = _PART.fullmatch(name)
    return bool(found and getattr(machine.unbalances[int(found[1]) - 1], found[2]) is not None)


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
        own, found = self._own, dict[int, int]()
        if self._described is not None:
            if self._last[0] != tuple(values):
                changed = self._described.changed(machine(), self._group.layout, self._block)
                if changed is None:
                    return None
                if not changed.assembly is self._last[1].assembly is self._assembly:
                    self._orders = {}  # of other balls
                self._last = tuple(values), changed
            own = self._last[1]
            found = dict(own.words)
        elif not all(isinstance(value, float | int) and math.isfinite(value) and value > 0.0 for value in values):
            return None
        if (seed, starts) == self._begin and not own.again:
            return found
        return found if self._follow_start(own, seed, starts, found) else None

    def of_parameters(self, values: Sequence[Sequence[Any]]) -> dict[int, Integers]:
        """Words of many members that follow, at each place an array over them; ``values`` has a row of each of them."""
        found: dict[int, Integers] = {}
        for i, follow in enumerate(self._parameters):
            found |= follow(np.array([float(row[i]) for row in values]))
        return found

    def _of_parameter(self, name: str) -> Callable[[Floats], dict[int, Integers]]:
        layout, balls = self._group.layout, self._assembly.balls
        match = _BETA.fullmatch(name)
        if name == "drag" or match:
            race = (int(match[1]) - 1, int(match[2]) - 1) if match else None
            own = [i for i, ball in enumerate(balls) if race in (None, (ball.balancer, ball.race))]
            first, second = ([layout.place("system.balls", i, field=f) for i in own] for f in ("drag", "viscous"))
            places = list(zip(first, second, [balls[i] for i in own], strict=True))

            def follow_drag(values: Floats) -> dict[int, Integers]:
                found = {drag: words_of(values) for drag, _, _ in places}
                return found | {viscous: words_of(values / ball.orbit_radius**2) for _, viscous, ball in places}

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
            found = {
                place: words_of(own + np.zeros(len(ones)))
                for places, numbers in zip(segments, resultant, strict=True)
                for place, own in zip(places, numbers, strict=True)
            }
            moments = [sizes if i == number else one.size for i, one in enumerate(parts)]
            length, velocity, _ = planar_sizes(self._machine, self._assembly.balls, self._assembly.system, moments)
            lengths, velocities = (words_of(self._tolerance * size) for size in (length, velocity))
            return found | {absolute + i: lengths if i in (X, Y) else velocities for i in range(X, VY + 1)}

        return follow_unbalance

    def _follow_start(self, own: Changed, seed: int, starts: dict[str, float], found: Words) -> bool:
        balls = _started(own.balls, starts)
        count = len(balls)
        if not _apart(own.machine, balls):
            return False
        angles = np.array(start_angles(balls, generator(seed)), np.float64)
        contacts = self._contacts(own, balls, angles)
        if contacts is None:
            return False
        found.update(contacts)
        for first in (self._state, self._start):
            for i, (angle, ball) in enumerate(zip(angles, balls, strict=True)):
                found[first + BALLS + i] = bits(angle)
                found[first + BALLS + count + i] = bits(ball.start_speed)
        return True

    def _contacts(self, own: Changed, balls: tuple[Ball, ...], angles: Floats) -> Words | None:
        """Who is next to whom; for each order the contacts are made once. None if they are of another kind."""
        before = self._assembly.system.contacts
        if not len(before):
            return {}
        rings = [ring(members, angles) for members in _races(balls)]
        order = tuple((i, j) for links in rings for i, j, _ in links)
        if order not in self._orders:
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
            if any(part is None for part in parts) or (rows.rigid != before.rigid).any():
                return None
            self._orders[order] = {place: word for part in parts for place, word in (part or {}).items()}
        words = dict(self._orders[order])
        for links in rings:
            if len(links) > 1:
                words |= {self._wraps[i]: bits(wrap) for i, _, wrap in links}
        return words


def _started(balls: tuple[Ball, ...], starts: dict[str, float]) -> tuple[Ball, ...]:
    """The balls with the starts of a member."""
    found = list(balls)
    for name, value in starts.items():
        kind, number = ball_of(name)
        for i in range(len(found)) if number is None else (number,):
            turned = kind == "ball_angle"
            found[i] = replace(found[i], start_angle=value) if turned else replace(found[i], start_speed=value)
    return tuple(found)


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
        if not given or _race(machine, given[0].balancer, given[0].race).coincidence:
            continue
        for i, one in enumerate(given):
            for other in given[i + 1 :]:
                turn = math.remainder(float(one.start_angle or 0.0) - float(other.start_angle or 0.0), 2.0 * math.pi)
                if abs(turn) < 0.5 * occupied_angle([one, other]):
                    return False
    return True
