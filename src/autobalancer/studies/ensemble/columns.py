"""The columns of an ensemble: what varies, one number for each member."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from numbers import Integral
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from autobalancer.assembly.contact import pull_of
from autobalancer.assembly.drive_train import unbalance_jumps
from autobalancer.assembly.guided_balls import FluidRows, ball_inertia, ball_rows, moving_rows, put_on_races
from autobalancer.assembly.places import Touch, places_of, touches_of
from autobalancer.assembly.quantities import parameter_unit
from autobalancer.assembly.reduced_rotor import Parts, host_of, length_scale, spatial_parts, spatial_scales, top_speed
from autobalancer.assembly.system import (
    Assembly,
    Model,
    critical_speeds,
    drive_of,
    equal_groups,
    first_speed,
    planar_scales,
    total_mass,
)
from autobalancer.catalog.resolve import Ball, planar_rotor, resolve
from autobalancer.errors import QuestionError
from autobalancer.files.text_files import read_table
from autobalancer.kernels.records import NONE, PRESCRIBED
from autobalancer.kernels.system import SPEED, Drive, Floats, Integers, Planar
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.machine.part import Part
from autobalancer.random_numbers import GREATEST
from autobalancer.simulation.steppers import planar_amplitudes, rotor_modes, why_no_long_steps
from autobalancer.studies.ensemble.layout import Layout, bits
from autobalancer.studies.variations import gauges_for, listed, refuse_of_all
from autobalancer.units import list_argument
from autobalancer.units.quantity import is_range

SEED = "seed"
STARTS = {"ball_angle": "rad", "ball_speed": "rad/s"}
_START = re.compile(r"(ball_angle|ball_speed)(?:\[(\d+)\])?")
EXAMPLE = "viscosity [mm^2/s], ball_angle[1] [deg]"


@dataclass(frozen=True)
class Columns:
    """What varies; every list has one entry for each of the ``count`` rows."""

    count: int
    parameters: dict[str, Sequence[Any]] = field(default_factory=dict)  # numbers in SI, texts, or whole parts
    starts: dict[str, Floats] = field(default_factory=dict)  # ball_angle[1], ball_speed[2], ball_speed: SI
    seeds: Integers | None = None

    def row(self, number: int) -> tuple[Any, ...]:
        """The parameters of one row."""
        return tuple(values[number] for values in self.parameters.values())


def columns_of(machine: Machine, options: Mapping[str, Any] | str | Path | None) -> Columns:
    """The columns that a user gave, checked as far as that needs no machine for each member.

    Raises
    ------
    QuestionError
        For names that there are not, unequal lengths, seeds or starts that are no numbers.
    """
    if isinstance(options, (str, Path)):
        options = _from_file(machine, Path(options))
    if options is not None and not isinstance(options, Mapping):
        raise QuestionError(
            f"columns: given {type(options).__name__}; must be names with their values, or the path of a table"
        )
    lists = {name: _listed(machine, name, values) for name, values in (options or {}).items()}
    sizes = {name: len(values) for name, values in lists.items()}
    if sizes and min(sizes.values()) == 0:
        raise QuestionError(f"columns: {min(sizes, key=sizes.__getitem__)!r} is empty; give at least one value")
    count = max(sizes.values(), default=1)
    unequal = {name: size for name, size in sizes.items() if size not in (1, count)}
    if unequal:
        raise QuestionError(f"columns: must all have the same length, or a single value; given {sizes}")
    lists = {name: values if len(values) == count else [values[0]] * count for name, values in lists.items()}
    seeds, starts = None, {}
    for name in list(lists):
        if name == SEED:
            seeds = _seeds(lists.pop(name))
        elif kind := _START.fullmatch(name):
            starts[name] = _start(machine, name, kind, lists.pop(name))
        else:
            unit_of_column(machine, name)  # refuses names that are none
    return Columns(count, lists, starts, seeds)


def ball_count(machine: Machine) -> int:
    """All balls of a machine."""
    return sum(race.ball_count for balancer in machine.balancers for race in balancer.races)


def ball_of(name: str) -> tuple[str, int | None]:
    """Kind of a start, and the number of its ball from 0; None: of all balls."""
    ball = _START.fullmatch(name)
    assert ball is not None
    return ball[1], int(ball[2]) - 1 if ball[2] else None


def _listed(machine: Machine, name: str, values: Any) -> Sequence[Any]:
    """A single value as a list of one, a range as its values."""
    if _START.fullmatch(name) and is_range(values):
        return list_argument(name, values, STARTS[ball_of(name)[0]])
    if name == SEED and is_range(values):
        raise QuestionError(f"columns: 'seed': given {values!r}; give whole numbers, such as range(100)")
    return listed(machine, name, values if not isinstance(values, np.ndarray) else values.tolist())


def _seeds(values: Sequence[Any]) -> Integers:
    for number, value in enumerate(values, start=1):
        known = isinstance(value, Integral | float) and not isinstance(value, bool)
        if not (known and 0 <= value <= GREATEST and value == int(value)):
            raise QuestionError(
                f"columns: member {number}, 'seed': given {value!r}; must be a whole number from 0 to {GREATEST}"
            )
    return np.array([int(value) for value in values], np.int64)


def _start(machine: Machine, name: str, kind: re.Match[str], values: Sequence[Any]) -> Floats:
    balls, all_balls = ball_count(machine), kind[2] is None
    if (all_balls and kind[1] == "ball_angle") or (not all_balls and not 1 <= int(kind[2]) <= balls):
        raise QuestionError(
            f"columns: no start {name!r}; there are ball_angle[1] to ball_angle[{balls}], ball_speed[1] to "
            f"ball_speed[{balls}], and ball_speed for all balls"
        )
    start = np.array(list_argument(name, values, STARTS[kind[1]]), np.float64)
    wrong = np.flatnonzero(~np.isfinite(start))
    if wrong.size:
        raise QuestionError(f"columns: member {wrong[0] + 1}, {name!r}: given {start[wrong[0]]}; must be finite")
    return start


def _from_file(machine: Machine, path: Path) -> dict[str, Any]:
    """Columns of a text file; the head of each is its name and, where it has one, its unit in brackets."""
    table = read_table(path, EXAMPLE, error=QuestionError)
    result: dict[str, Any] = {}
    for name in table.heads:
        written = table.heads[name][1]
        unit = "" if name == SEED else unit_of_column(machine, name)
        texts = table.texts(name)
        if written or (not any(_is_text(text) for text in texts) and not unit):
            result[name] = table.numbers(name, unit)
        elif any(_is_text(text) for text in texts):
            result[name] = texts
        else:
            raise QuestionError(
                f"{path}: column {name!r}: numbers without a unit; write it in the first line, such as {name} [{unit}]"
            )
    return result


def unit_of_column(machine: Machine, name: str) -> str:
    """The SI unit of a column; empty for plain numbers."""
    refuse_of_all(name)
    kind = _START.fullmatch(name)
    return STARTS[kind[1]] if kind else parameter_unit(machine, name)


def _is_text(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return True
    return False


def is_start(name: str) -> bool:
    """Whether a column is a start of a ball, not a parameter of the machine."""
    return _START.fullmatch(name) is not None


# Members whose machine differs from an assembled one in numbers: of drag and friction, drive, unbalances, rotor and
# balls.
#
# Such a member is described, and its balls are resolved, but it is not assembled: only the rows that differ are made
# anew, by the functions that assemble them. Whatever else differs is a reason to assemble.


Words = dict[int, int]
OF_RACES = {"drag", "fluid", "friction"}  # keys of a race of which balls feel drag and friction only, see _alike
OF_BALLS = {"eccentricity", "eccentricity_angle", "balls", "orbit_radius", "race_radius", "bearing"}
OF_MASS = OF_BALLS | {"fluid"}  # on which the mass depends that forces on balls know
OF_DRAG, OF_FRICTION = (
    {"drag", "fluid_viscosity", "stokes"},
    {"rolling_resistance", "adherence"},
)  # what their rows have of these
START_COLUMNS = {"start_angle", "start_speed"}
SIZES = {"diameter", "orbit_radius"}  # of balls, on which contacts depend


class Differences(NamedTuple):
    """In what a machine differs from the assembled one; nothing or None where it does not."""

    balls: tuple[Ball, ...]
    drive: Drive | None
    unbalances: bool
    numbers: bool = False  # of the rotor or its balls, or of what it knows of its drive


class Changed(NamedTuple):
    """A member that need not be assembled."""

    words: Words
    machine: Machine
    balls: tuple[Ball, ...]
    assembly: Assembly  # with these balls and its critical speeds, else that of the assembled member
    again: bool  # whether start angles and contacts are others, too


class Described:
    """What members need not have assembled that differ from this machine; ``end`` is the duration of a run, s."""

    def __init__(self, machine: Machine, assembly: Assembly, end: float, tolerance: float) -> None:
        self._machine, self._assembly, self._end, self._tolerance = machine, assembly, end, tolerance
        self._equal = bool(equal_groups(machine, resolve(machine)))

    def follows(self, machine: Machine) -> bool:
        """Whether a machine differs in nothing else, as far as that is known without its numbers."""
        return self._differences(machine) is not None

    def is_costly(self, machine: Machine) -> bool:
        """Whether the numbers of its rotor or balls are others, or what a rotor knows of its drive, or it has to be assembled."""
        different = self._differences(machine)
        return different is None or different.numbers

    def changed(self, machine: Machine, layout: Layout, block: Integers) -> Changed | None:
        """The words of such a machine where they differ from a block of the assembled one; None if it has to be assembled."""
        different = self._differences(machine)
        if different is None:
            return None
        words: Words = {}
        balls, system = different.balls or self._assembly.balls, self._assembly.system
        drive = different.drive or system.drive
        again = any(_moved(*pair) for pair in zip(different.balls, self._assembly.balls, strict=False))
        own_assembly = self._assembly
        if different.numbers:
            made = numbers_of(machine, balls, self._before, drive, long=layout.has(LONG))
            own = made and number_words(machine, made, self._before, self._end, self._tolerance, layout, block)
            if made is None or own is None:
                return None
            words, own_assembly = own, made.assembly
            again = again or any(race.contact is not None for balancer in machine.balancers for race in balancer.races)
        for i, ball in enumerate(different.balls):
            for name, value in _row(ball, self._assembly.balls[i]).items():
                words[layout.place("system.balls", i, field=name)] = bits(value)
        if different.drive is not None:
            own = layout.words("system.drive", drive, block)
            if own is None:
                return None
            words |= own
            speed = bits(first_speed(machine, drive))
            words |= {layout.place(f"memory.{name}", SPEED): speed for name in ("state", "start")}
        if different.unbalances and not different.numbers:
            own = self._of_unbalances(machine, drive, layout, block)
            if own is None:
                return None
            words |= own
        return Changed(words, machine, balls, own_assembly, again)

    def _differences(self, machine: Machine) -> Differences | None:
        """What is different; None if that has to be assembled."""
        changed = _changed(self._machine, machine)
        rotor = "rotor" in changed
        if rotor and not self._keeps_its_form(machine):
            return None
        changed -= {"rotor"}
        if not changed <= {"balancers", "drive", "unbalances"} or self._assembly.resolved:
            return None
        balls = self._balls(machine) if "balancers" in changed else ()
        drive = self._drive(machine) if not changed <= {"balancers"} else None
        if balls is None or (drive is None and not changed <= {"balancers"}):
            return None
        heavier = any(_in_numbers(*pair) for pair in zip(balls, self._assembly.balls, strict=False))
        driven = "drive" in changed and self._assembly.model is not Model.PLANAR  # loads and modes know the drive
        return Differences(balls, drive, "unbalances" in changed, rotor or heavier or driven)

    def _keeps_its_form(self, machine: Machine) -> bool:
        """Whether its rotor differs in numbers only."""
        mine, its = machine.rotor, self._machine.rotor
        return type(mine) is type(its) and keeps_its_form(mine, its, _changed(its, mine))

    def _of_unbalances(self, machine: Machine, drive: Drive, layout: Layout, block: Integers) -> Words | None:
        """Sizes of the deflections, and the loads of a rotor that tilts or bends; None if they ask for other modes of it."""
        assembly, balls = self._assembly, self._assembly.balls
        if assembly.model is Model.PLANAR:
            return scale_words(self._tolerance * planar_scales(machine, balls, assembly.system)[0], layout)
        parts = spatial_parts(machine, balls)
        if parts.reduction.basis is not self._before.parts.reduction.basis or parts.mounts or parts.hard:
            return None
        loads = layout.words("system.host.loads", host_of(machine, parts, drive.segments.start)[0].loads, block)
        scale = spatial_scales(parts, length_scale(machine, parts, balls), len(balls), assembly.state.size)[0]
        return None if loads is None else loads | scale_words(self._tolerance * scale, layout)

    @cached_property
    def _before(self) -> Reference:
        return Reference(self._machine, self._assembly)

    def _balls(self, machine: Machine) -> tuple[Ball, ...] | None:
        """The balls of a machine whose races differ in what balls feel of them only."""
        if self._equal or not all(_alike(*pair) for pair in _races(self._machine, machine)):
            return None
        balls = resolve(machine)
        if len(balls) != len(self._assembly.balls):
            return None
        return balls if all(_same_kind(*pair) for pair in zip(balls, self._assembly.balls, strict=True)) else None

    def _drive(self, machine: Machine) -> Drive | None:
        """The drive of a machine that asks for the same top speed."""
        now, before = machine.drive, self._machine.drive
        if type(now) is not type(before) or top_speed(machine) != top_speed(self._machine):
            return None
        if unbalance_jumps(machine, self._end) != unbalance_jumps(self._machine, self._end):
            return None
        drive, own = drive_of(machine), self._assembly.system.drive
        if own.linked or drive.linked or drive.segments.shape != own.segments.shape:
            return None
        return drive


def _row(ball: Ball, before: Ball) -> dict[str, float]:
    """The numbers of a ball's row that may differ."""
    values: dict[str, float] = {}
    if ball.drag != before.drag:
        values |= {"drag": ball.drag, "viscous": ball.drag / ball.orbit_radius**2}
    if ball.adherence > 0.0:
        values |= {"rolling": ball.rolling_resistance, "adherence": ball.adherence}
    return values


def _same_kind(ball: Ball, before: Ball) -> bool:
    """Whether two balls differ in numbers only."""
    return all(one == other for one, other in zip(_kind(ball), _kind(before), strict=True))


def _kind(ball: Ball) -> tuple[Any, ...]:
    held = ball.rolling_resistance > 0.0, ball.adherence > 0.0
    moving = ball.adherence > 0.0 and ball.start_speed
    place = ball.balancer, ball.race, ball.body, ball.slipstream
    return *place, ball.drag_curve is None, ball.diameter > 0.0, *held, moving


def _in_numbers(ball: Ball, before: Ball) -> bool:
    """Whether a ball has other numbers than drag and friction, or a curve of its drag."""
    curved = ball.drag_curve is not None or ball.slipstream
    free = START_COLUMNS | OF_FRICTION | (set() if curved else OF_DRAG)
    return ball is not before and any(
        getattr(ball, field.name) != getattr(before, field.name) for field in fields(Ball) if field.name not in free
    )


def _moved(ball: Ball, before: Ball) -> bool:
    """Whether a ball starts elsewhere or touches others at another angle."""
    return any(getattr(ball, key) != getattr(before, key) for key in START_COLUMNS | SIZES)


def _changed(one: Part, other: Part) -> set[str]:
    """Keys under which two parts of one kind differ."""
    if one is other:
        return set()
    pairs = ((key, getattr(one, key), getattr(other, key)) for key in type(one).model_fields)
    return {key for key, mine, its in pairs if mine is not its and mine != its}


def _races(machine: Machine, other: Machine) -> Iterator[tuple[Any, Any]]:
    """The races of two machines side by side; balancers that differ in more than their races as a whole."""
    if len(machine.balancers) != len(other.balancers):
        yield machine, other
        return
    for mine, its in zip(machine.balancers, other.balancers, strict=True):
        if not _changed(mine, its) <= {"races"} or len(mine.races) != len(its.races):
            yield mine, its
        else:
            yield from zip(mine.races, its.races, strict=True)


def _alike(one: Any, other: Any) -> bool:
    """Whether two races differ in nothing but numbers that their balls have or feel."""
    changed = _changed(one, other)
    if not changed <= OF_RACES | OF_BALLS:
        return False
    if (changed & OF_BALLS and one.partitions is not None) or (changed & OF_MASS and one.forces):
        return False
    if "friction" in changed and len({race.friction and (race.friction.rolling_law,) for race in (one, other)}) > 1:
        return False
    lags = any(race.fluid is not None and race.fluid.lag != "none" for race in (one, other))
    falls = one.contact is not None and one.contact.rebound is not None  # by the fluid between balls
    return changed <= {"friction"} or not (lags or falls)


# Members whose rotor or balls have other numbers: masses, sizes, springs, dampers, places of the race.
#
# All that an assembly makes of these numbers is made anew by the functions that make it there; drive, record and the
# order of all numbers stay those of the assembled member. What is known of a rotor is taken from memory, see
# ``autobalancer.cache``.


OF_PLANAR_ROTOR = {
    "mass", "stiffness", "critical_speed", "damping", "damping_ratio", "half_power_bandwidth", "inertia",
}  # fmt: skip
MODAL = ("stiffness", "damping", "gyroscopic")  # matrices on which modes depend
LONG = "long.1.exponents"
OF_MODES = ("exponents", "shapes", "inverse", "numbers", "bases")


class Reference:
    """The assembled member, and what the numbers of others are compared with."""

    def __init__(self, machine: Machine, assembly: Assembly) -> None:
        self.machine, self.assembly = machine, assembly

    @cached_property
    def touches(self) -> tuple[Touch, ...]:
        """Its contacts."""
        return touches_of(self.machine, self.assembly)

    @cached_property
    def parts(self) -> Parts:
        """Its rotor, which is not planar."""
        return spatial_parts(self.machine, self.assembly.balls)


class Own(NamedTuple):
    """A member as far as it was made anew."""

    assembly: Assembly
    modes: Any  # amplitudes of long steps; None where they are those of the assembled one


def keeps_its_form(rotor: Any, before: Any, changed: set[str]) -> bool:
    """Whether a rotor differs from another of its kind in numbers only, as far as its description says."""
    return not isinstance(rotor, PlanarRotor) or (changed <= OF_PLANAR_ROTOR and rotor.isotropic == before.isotropic)


def numbers_of(machine: Machine, balls: tuple[Ball, ...], before: Reference, drive: Drive, *, long: bool) -> Own | None:
    """A machine and its balls, made anew as far as it has to be; None if it is integrated in another way.

    ``long`` says whether the assembled one takes long steps.
    """
    made = _planar if before.assembly.model is Model.PLANAR else _general
    numbers = made(machine, balls, before, drive, long=long)
    if numbers is None or bool(why_no_long_steps(numbers.assembly)) != bool(why_no_long_steps(before.assembly)):
        return None
    return numbers


def number_words(
    machine: Machine, own: Own, before: Reference, end: float, tolerance: float, layout: Layout, block: Integers
) -> dict[int, int] | None:
    """The words of such a machine where they differ from the ``block`` of the assembled one; None for another layout."""
    first, made = before.assembly, own.assembly
    touches = before.touches if made.balls is first.balls else touches_of(machine, made)
    values: dict[str, Any] = {"gauges": gauges_for(made, places_of(machine, made), end, touches)}
    for name, value in made.system._asdict().items():
        if value is not getattr(first.system, name):
            values[f"system.{name}"] = value
    if own.modes is not None:
        values |= {f"long.1.{name}": getattr(own.modes, name) for name in OF_MODES}
    words = scale_words(tolerance * made.scale, layout)
    for path, value in values.items():
        its = layout.words(path, value, block)
        if its is None:
            return None
        words |= its
    if made.system.ties.size:
        critical = made.critical_speeds
        usual = max(critical) if first.model is Model.PLANAR else min(critical, default=0.0)
        pull = bits(pull_of(made.balls, max(top_speed(machine) or 0.0, usual)))
        words |= {layout.place("system.rigid.margin", i): pull for i in (2, 3)}
    return words


def scale_words(sizes: Floats, layout: Layout) -> dict[int, int]:
    """The words of absolute tolerances."""
    return dict(enumerate(map(bits, sizes), layout.place("memory.absolute", 0)))


def _planar(machine: Machine, balls: tuple[Ball, ...], before: Reference, drive: Drive, *, long: bool) -> Own | None:
    first = before.assembly
    (kx, ky), (bx, by) = (rotor := planar_rotor(machine)).stiffness_xy, rotor.damping_xy
    system = first.system._replace(
        planar=Planar(total_mass(machine, balls), kx, ky, bx, by),
        polar_inertia=float(machine.rotor.inertia or 0.0) + sum(ball_inertia(ball) for ball in balls),
    )
    if balls is not first.balls:
        system = system._replace(balls=ball_rows(balls))
    scale = planar_scales(machine, balls, system)[0]
    critical = tuple(critical_speeds(system.planar))
    own = replace(first, system=system, balls=balls, critical_speeds=critical, scale=scale)
    return Own(own, planar_amplitudes(own) if long and not why_no_long_steps(own) else None)


def _general(machine: Machine, balls: tuple[Ball, ...], before: Reference, drive: Drive, *, long: bool) -> Own | None:
    """On any other rotor; None if it has another number of modes, or parts whose numbers are not known here."""
    first, parts = before.assembly, spatial_parts(machine, balls)
    if parts.mounts or parts.hard or first.mounts or first.hard or machine.excitations or drive.linked:
        return None
    kept = parts.reduction.basis is before.parts.reduction.basis
    moved = any(machine.start.deflection) or any(machine.start.velocity)
    if parts.size != before.parts.size or parts.isotropic != before.parts.isotropic or (moved and not kept):
        return None
    host = host_of(machine, parts, drive.segments.start)[0]
    system = first.system._replace(
        host=_reuse(host, first.system.host), drive=drive, polar_inertia=float(machine.rotor.inertia or 0.0)
    )
    if balls is not first.balls:
        rows, fluids = ball_rows(balls), FluidRows(balls, {}, 0)
        if first.system.fluid.modes.size or (first.system.balls.lag_table != NONE).any():
            return None
        if first.rough:
            put_on_races(machine, balls, rows, moving_rows(balls), fluids)
            system = system._replace(fluid=fluids.fluid)
        system = system._replace(balls=rows)
    scale = spatial_scales(parts, length_scale(machine, parts, balls), len(balls), first.state.size)[0]
    own = replace(
        first, system=system, balls=balls, critical_speeds=parts.critical_speeds, scale=scale, reduction=parts.reduction,
        places=parts.places, stations=parts.stations, gyroscopic_shares=parts.gyroscopic_shares,
    )  # fmt: skip
    reach = drive is first.system.drive and (drive.kind == PRESCRIBED or own.critical_speeds == first.critical_speeds)
    if not long or (reach and all(getattr(host, name) is getattr(first.system.host, name) for name in MODAL)):
        return Own(own, None)
    state = own.state.copy()
    state[SPEED] = first_speed(machine, drive)
    modes = rotor_modes(system, state, parts.critical_speeds)
    return None if modes is None else Own(own, modes)


def _reuse(now: Any, before: Any) -> Any:
    """The one before if nothing in it was made anew."""
    return before if all(one is other for one, other in zip(now, before, strict=True)) else now
