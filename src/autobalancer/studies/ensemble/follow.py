"""Members that follow an assembled one by a few numbers: drag, unbalance, starts. All others need an assembly of their own.

What a column touches is worked out by the functions that assemble a machine, so a member has the same bits either way. A few
members of each kind are assembled all the same and compared word by word; if one differed, all would be assembled.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from autobalancer.assembly.contact.meetings import ring, set_contacts
from autobalancer.assembly.drive import drive_of
from autobalancer.assembly.mass_spread import equal_groups
from autobalancer.assembly.spatial import top_speed
from autobalancer.assembly.starts import planar_scales, start_angles
from autobalancer.assembly.system import Assembly, Model
from autobalancer.catalog.resolve import Ball, occupied_angle
from autobalancer.drag.beta import DragTorque
from autobalancer.kernels.records.guided import CONTACT
from autobalancer.kernels.system import BALLS, VY, Floats, X
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.random_numbers import generator
from autobalancer.studies.ensemble.columns import ball_of
from autobalancer.studies.ensemble.described import Described, Words
from autobalancer.studies.ensemble.groups import Group
from autobalancer.studies.ensemble.layout import bits

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
    return not (assembly.resolved or forces or walls or (held and speeds) or equal_groups(machine, assembly.balls))


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
        self._last: tuple[Any, Words] = (None, {})
        self._fastest = max(top_speed(machine) or 0.0, *assembly.critical_speeds)
        self._orders: dict[Any, Words] = {}
        layout = group.layout
        self._state, self._start = layout.place("memory.state", 0), layout.place("memory.start", 0)
        touching = len(assembly.system.contacts)
        self._wraps = [layout.place("system.contacts", i, field="wrap") for i in range(touching)]

    def words(
        self, values: Sequence[Any], machine: Callable[[], Machine], seed: int, starts: dict[str, float]
    ) -> Words | None:
        """The words of a member; None if it has to be assembled, as a value may be impossible.

        ``machine`` is what the values make of it, without its start.
        """
        found: Words = {}
        if self._described is not None:
            if self._last[0] != tuple(values):
                own = self._described.words(machine(), self._group.layout)
                if own is None:
                    return None
                self._last = tuple(values), own
            found = dict(self._last[1])
        for follow, value in zip(self._parameters, values if self._described is None else (), strict=True):
            if not (isinstance(value, float | int) and math.isfinite(value) and value > 0.0):
                return None
            follow(float(value), found)
        if (seed, starts) == self._begin:
            return found
        return found if self._follow_start(seed, starts, found) else None

    def _of_parameter(self, name: str) -> Callable[[float, Words], None]:
        layout, balls = self._group.layout, self._assembly.balls
        match = _BETA.fullmatch(name)
        if name == "drag" or match:
            race = (int(match[1]) - 1, int(match[2]) - 1) if match else None
            own = [i for i, ball in enumerate(balls) if race in (None, (ball.balancer, ball.race))]
            first, second = ([layout.place("system.balls", i, field=f) for i in own] for f in ("drag", "viscous"))
            places = list(zip(first, second, [balls[i] for i in own], strict=True))

            def follow_drag(value: float, found: Words) -> None:
                for drag, viscous, ball in places:
                    found[drag], found[viscous] = bits(value), bits(value / ball.orbit_radius**2)

            return follow_drag
        part = _PART.fullmatch(name)
        number, key = (int(part[1]) - 1, part[2]) if part else (0, "moment")
        fields = [f"unbalance{field}" for field in ("_x", "_y", "_rate_x", "_rate_y")]
        segments = [
            tuple(layout.place("system.drive.segments", i, field=field) for field in fields)
            for i in range(len(self._assembly.system.drive.segments))
        ]
        absolute = layout.place("memory.absolute", 0)

        def follow_unbalance(value: float, found: Words) -> None:
            parts = list(self._machine.unbalances)
            parts[number] = parts[number].model_copy(update={key: value})
            machine = self._machine.model_copy(update={"unbalances": tuple(parts)})
            for places, row in zip(segments, drive_of(machine).segments, strict=True):
                own = row.unbalance_x, row.unbalance_y, row.unbalance_rate_x, row.unbalance_rate_y
                found.update(zip(places, map(bits, own), strict=True))
            scale = planar_scales(machine, self._assembly.balls, self._assembly.system)[0]
            found.update((absolute + i, bits(self._tolerance * scale[i])) for i in range(X, VY + 1))

        return follow_unbalance

    def _follow_start(self, seed: int, starts: dict[str, float], found: Words) -> bool:
        balls, count = self._balls(starts), len(self._assembly.balls)
        if not _apart(self._machine, balls):
            return False
        angles = np.array(start_angles(balls, generator(seed)), np.float64)
        found.update(self._contacts(balls, angles))
        for first in (self._state, self._start):
            for i, (angle, ball) in enumerate(zip(angles, balls, strict=True)):
                found[first + BALLS + i] = bits(angle)
                found[first + BALLS + count + i] = bits(ball.start_speed)
        return True

    def _balls(self, starts: dict[str, float]) -> tuple[Ball, ...]:
        balls = list(self._assembly.balls)
        for name, value in starts.items():
            kind, number = ball_of(name)
            for i in range(len(balls)) if number is None else (number,):
                turned = kind == "ball_angle"
                balls[i] = replace(balls[i], start_angle=value) if turned else replace(balls[i], start_speed=value)
        return tuple(balls)

    def _contacts(self, balls: tuple[Ball, ...], angles: Floats) -> Iterator[tuple[int, int]]:
        """Who is next to whom; for each order the contacts are made once."""
        if not len(self._assembly.system.contacts):
            return
        rings = [ring(members, angles) for members in _races(balls)]
        order = tuple((i, j) for links in rings for i, j, _ in links)
        if order not in self._orders:
            rows = CONTACT.rows(len(balls))
            set_contacts(self._machine, balls, angles, rows, self._fastest)
            first = self._group.layout.place("system.contacts", 0)
            self._orders[order] = {
                first + k: int(word) for k, word in enumerate(np.frombuffer(rows.tobytes(), np.int64))
            }
        yield from self._orders[order].items()
        for links in rings:
            if len(links) > 1:
                yield from ((self._wraps[i], bits(wrap)) for i, _, wrap in links)


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
