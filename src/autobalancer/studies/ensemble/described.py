"""Members whose machine differs from an assembled one in the drag and friction of its races, its drive and its unbalances only.

On planar rotors also in numbers of the rotor and of its balls. Such a member is described, and its balls are resolved, but it is
not assembled: only these rows are made anew, by the functions that assemble them. Whatever else differs is a reason to assemble.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from autobalancer.assembly.contact.meetings import is_rigid
from autobalancer.assembly.contact.touches import touches_of
from autobalancer.assembly.drive import drive_of, first_speed
from autobalancer.assembly.host import loads_of
from autobalancer.assembly.mass_spread import equal_groups
from autobalancer.assembly.profile import unbalance_jumps
from autobalancer.assembly.spatial import Parts, length_scale, spatial_parts, top_speed, with_unbalances
from autobalancer.assembly.starts import planar_scales
from autobalancer.assembly.system import Assembly, Model
from autobalancer.catalog.resolve import Ball, resolve
from autobalancer.kernels.system import BALLS, SPEED, VX, VY, Drive, Matrix, X, Y
from autobalancer.machine import Machine, RigidRotor
from autobalancer.machine.part import Part
from autobalancer.studies.ensemble.layout import Layout, bits
from autobalancer.studies.ensemble.planar import OF_BALL, Before, keeps_its_form, planar_words

Words = dict[int, int]
OF_RACES = {"drag", "fluid", "friction"}  # keys of a race of which the balls feel drag and friction only, see _alike
OF_PLANAR = {"eccentricity", "eccentricity_angle", "balls"}  # besides these on planar rotors
FREE = ("drag", "fluid_viscosity", "stokes", "rolling_resistance", "adherence", "start_angle", "start_speed")


class Differences(NamedTuple):
    """In what a machine differs from the assembled one; nothing or None where it does not."""

    balls: tuple[Ball, ...]
    drive: Drive | None
    unbalances: bool
    planar: bool = False  # numbers of the rotor or of its balls


class Described:
    """What members need not have assembled that differ from this machine; ``end`` is the duration of a run, s."""

    def __init__(self, machine: Machine, assembly: Assembly, end: float, tolerance: float) -> None:
        self._machine, self._assembly, self._end, self._tolerance = machine, assembly, end, tolerance
        self._equal = bool(equal_groups(machine, assembly.balls))

    def follows(self, machine: Machine) -> bool:
        """Whether a machine differs in nothing else."""
        return self._differences(machine) is not None

    def words(self, machine: Machine, layout: Layout) -> Words | None:
        """The words of such a machine; None if it has to be assembled."""
        different = self._differences(machine)
        if different is None:
            return None
        found: Words = {}
        if different.planar:
            balls = different.balls or self._assembly.balls
            own = planar_words(machine, balls, self._assembled, self._end, self._tolerance, layout)
            if own is None:
                return None
            found |= own
        for i, ball in enumerate(different.balls):
            for name, value in _row(ball, self._assembly.balls[i]).items():
                found[layout.place("system.balls", i, field=name)] = bits(value)
        if different.drive is not None:
            own = layout.words("system.drive", different.drive)
            if own is None:
                return None
            found |= own
            speed = bits(first_speed(machine, different.drive))
            found |= {layout.place(f"memory.{name}", SPEED): speed for name in ("state", "start")}
        unbalances = different.unbalances and not different.planar
        return found | self._of_unbalances(machine, layout) if unbalances else found

    def _differences(self, machine: Machine) -> Differences | None:
        """What is different; None if that has to be assembled."""
        changed = _changed(self._machine, machine)
        planar = "rotor" in changed
        if planar and not self._planar(machine):
            return None
        changed -= {"rotor"}
        if not changed <= {"balancers", "drive", "unbalances"} or self._assembly.resolved:
            return None
        balls = self._balls(machine) if "balancers" in changed else ()
        drive = self._drive(machine, "unbalances" in changed) if not changed <= {"balancers"} else None
        if balls is None or (drive is None and not changed <= {"balancers"}):
            return None
        heavier = any(_of_planar(*pair) for pair in zip(balls, self._assembly.balls, strict=False))
        return Differences(balls, drive, "unbalances" in changed, planar or heavier)

    def _planar(self, machine: Machine) -> bool:
        """Whether its planar rotor differs in numbers only."""
        if self._assembly.model is not Model.PLANAR:
            return False
        return keeps_its_form(machine.rotor, self._machine.rotor, _changed(self._machine.rotor, machine.rotor))

    def _of_unbalances(self, machine: Machine, layout: Layout) -> Words:
        """Sizes of the deflections, and the loads of a rigid rotor."""
        assembly, found = self._assembly, dict[int, int]()
        scale = assembly.scale.copy()
        if assembly.model is Model.PLANAR:
            scale[X : VY + 1] = planar_scales(machine, assembly.balls, assembly.system)[0][X : VY + 1]
        else:
            parts, inverse = self._parts
            parts, host = with_unbalances(parts, machine), assembly.system.host
            loads = loads_of(machine, parts, inverse, assembly.system.drive.segments.start, host.width)
            found |= layout.words("system.host.loads", loads) or {}
            rest, more = BALLS + 2 * len(assembly.balls), parts.size - 2
            length = length_scale(machine, parts, assembly.balls)
            scale[[X, Y, *range(rest, rest + more)]] = length
            scale[[VX, VY, *range(rest + more, rest + 2 * more)]] = length * parts.frequency
        absolute = layout.place("memory.absolute", 0)
        return found | {absolute + i: bits(self._tolerance * size) for i, size in enumerate(scale)}

    @cached_property
    def _assembled(self) -> Before:
        return Before(self._assembly, touches_of(self._machine, self._assembly))

    @cached_property
    def _parts(self) -> tuple[Parts, Matrix]:
        """The rotor, and the inverse of its mass."""
        parts = spatial_parts(self._machine, self._assembly.balls)
        return parts, np.asarray(np.linalg.inv(parts.mass), np.float64)

    def _balls(self, machine: Machine) -> tuple[Ball, ...] | None:
        """The balls of a machine whose races differ in drag and friction only."""
        planar = self._assembly.model is Model.PLANAR
        if self._equal or not all(_alike(*pair, planar=planar) for pair in _races(self._machine, machine)):
            return None
        balls = resolve(machine)
        if len(balls) != len(self._assembly.balls):
            return None
        free = (*FREE, *OF_BALL) if planar else FREE
        for ball, own in zip(balls, self._assembly.balls, strict=True):
            if replace(ball, **{key: getattr(own, key) for key in free}) != own:
                return None
            if ball.drag != own.drag and (ball.drag_curve is not None or ball.slipstream):
                return None
            held = (ball.rolling_resistance > 0.0, ball.adherence > 0.0)
            if held != (own.rolling_resistance > 0.0, own.adherence > 0.0):
                return None
        return balls

    def _drive(self, machine: Machine, unbalances: bool) -> Drive | None:
        """The drive of a machine that asks for the same top speed; of shafts and bodies with the same unbalances."""
        now, before = machine.drive, self._machine.drive
        if type(now) is not type(before) or top_speed(machine) != top_speed(self._machine):
            return None
        if unbalance_jumps(machine, self._end) != unbalance_jumps(self._machine, self._end):
            return None
        found, own = drive_of(machine), self._assembly.system.drive
        if own.linked or found.linked or found.segments.shape != own.segments.shape:
            return None
        if self._assembly.model is Model.PLANAR:
            return found
        if not np.array_equal(found.segments.start, own.segments.start):
            return None
        rigid = isinstance(machine.rotor, RigidRotor) and not self._assembly.mounts and not self._assembly.hard
        return found if rigid or not unbalances else None


def _row(ball: Ball, before: Ball) -> dict[str, float]:
    """The numbers of a ball's row that may differ."""
    values: dict[str, float] = {}
    if ball.drag != before.drag:
        values |= {"drag": ball.drag, "viscous": ball.drag / ball.orbit_radius**2}
    if ball.adherence > 0.0:
        values |= {"rolling": ball.rolling_resistance, "adherence": ball.adherence}
    return values


def _changed(one: Part, other: Part) -> set[str]:
    """Keys under which two parts of one kind differ."""
    if one is other:
        return set()
    pairs = ((key, getattr(one, key), getattr(other, key)) for key in type(one).model_fields)
    return {key for key, mine, its in pairs if mine is not its and mine != its}


def _races(one: Machine, other: Machine) -> Iterator[tuple[Any, Any]]:
    """The races of two machines side by side; balancers that differ in more than their races as a whole."""
    if len(one.balancers) != len(other.balancers):
        yield one, other
        return
    for mine, its in zip(one.balancers, other.balancers, strict=True):
        if not _changed(mine, its) <= {"races"} or len(mine.races) != len(its.races):
            yield mine, its
        else:
            yield from zip(mine.races, its.races, strict=True)


def _of_planar(ball: Ball, before: Ball) -> bool:
    """Whether a ball has other numbers than drag and friction."""
    return any(getattr(ball, key) != getattr(before, key) for key in OF_BALL)


def _alike(one: Any, other: Any, *, planar: bool) -> bool:
    """Whether two races differ in nothing but what their balls feel as drag and friction, and what planar rotors know besides."""
    changed = _changed(one, other)
    if not changed <= (OF_RACES | OF_PLANAR if planar else OF_RACES):
        return False
    if changed & OF_PLANAR and (one.partitions is not None or one.forces or not is_rigid(one)):
        return False
    if "friction" in changed and (one.friction is None or other.friction is None):
        return False
    lags = any(race.fluid is not None and race.fluid.lag != "none" for race in (one, other))
    falls = one.contact is not None and one.contact.rebound is not None  # by the fluid between balls
    return changed <= {"friction"} or not (lags or falls)
