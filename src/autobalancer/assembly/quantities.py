"""Change one quantity of a machine by its plain name, such as ``viscosity``, or by its path."""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Callable, Iterator
from difflib import get_close_matches
from typing import Any, TypeVar, cast

import numpy as np

from autobalancer.assembly.drive_train import profile_pieces
from autobalancer.assembly.system import total_mass
from autobalancer.catalog.resolve import WORDS, fluid_numbers, resolve, roller_face, settled
from autobalancer.drag.viscous import ViscousDrag
from autobalancer.errors import MachineError, QuestionError, UnitError
from autobalancer.machine import Balls, Fluid, Friction, Machine, PlanarRotor, PrescribedSpeed, Race, Unbalance
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.machine.part import Part, Quantity, quantity_of
from autobalancer.machine.path import QUANTITIES, did_you_mean, entry_at, parts_of, si_unit_of, unit_at, with_entry
from autobalancer.machine.rotors.planar import DAMPERS, SPRINGS
from autobalancer.machine_kinds import RACES, machine_kind
from autobalancer.units import WrittenFloat, shortened, to_si
from autobalancer.units.quantity import range_values


def with_quantity(machine: Machine, name: str, value: Any) -> Machine:
    """A machine with another value of one quantity.

    Parameters
    ----------
    machine
        Left as it is.
    name
        A name of :data:`~autobalancer.machine.path.QUANTITIES`, which concerns all races and all balls at once, or a
        path of :func:`~autobalancer.assembly.quantities.with_value_at`. Another viscosity keeps the density of the fluid;
        another temperature changes both, as the catalog says; another rolling resistance raises the adherence if it must;
        another ball mass the diameter, another diameter the density of the ball; another unbalance keeps its direction,
        and its schedules are dropped; on rotors that tilt or bend all unbalances and couples change in proportion, and their
        resultant is the value. Several of them joined by ``&``, such as ``"ball_mass & drag"``, change together: the
        value is that of the first, the others keep their proportion to it.
    value
        SI, or a string with a unit.

    Raises
    ------
    QuestionError
        If there is no such quantity, or nothing that it could change.
    MachineError
        If the value is impossible there.
    """
    if len(parts_of(name)) > 1:
        return _together(machine, name, value)
    if _is_path(name):
        return with_value_at(machine, name, value)
    value = si_value(machine, name, value)
    if name in ("damping", "stiffness"):
        return with_value_at(machine, f"rotor.{name}", value)
    if name == "unbalance" and not isinstance(machine.rotor, PlanarRotor):
        return _with_unbalances(machine, value)
    if name == "unbalance":
        angle = cmath.phase(sum(u.vector for u in machine.unbalances))
        return with_value_at(machine, "unbalances", (Unbalance(moment=value, angle=angle),) if value > 0.0 else ())
    if not machine.balancers:
        raise QuestionError(f"quantity {name!r}: the machine has no balancer")
    if name == "viscosity":
        return _with_races(machine, lambda where, race: race_with_viscosity(where, race, value))
    if name == "drag":
        return _with_races(machine, lambda where, race: {"drag": ViscousDrag(damping=value)})
    if name == "rolling_resistance":
        return _with_races(machine, lambda where, race: {"friction": race_with_rolling(race, value)})
    if name == "temperature":
        return _with_races(machine, lambda where, race: {"fluid": race_with_temperature(where, race, value)})
    if name == "plateau":
        return _with_races(machine, lambda where, race: {"drag": race_with_plateau(where, race, value)})
    if name == "count" and sum(len(race.balls) for b in machine.balancers for race in b.races) > 1:
        raise QuestionError("quantity 'count': the machine has several groups of balls; give the path of one of them")
    balls = iter(resolve(machine))

    def changed(where: str, race: Race) -> dict[str, Any]:
        groups = []
        for group in race.balls:
            first, *_ = (next(balls) for _ in range(group.count))
            groups.append(group_with_ball(group, first, name, value, where))
        return {"balls": tuple(groups)}

    return _with_races(machine, changed)


def with_parameter(machine: EitherMachine, name: str, value: Any) -> EitherMachine:
    """A machine in which a parameter has another value.

    Parameters
    ----------
    machine
        Left as it is.
    name
        A path such as ``rotor.mass`` or ``balancers[1].races[1].balls[1].diameter``, with entries counted from 1; or, of balls
        in races, a plain name of :data:`~autobalancer.machine.path.QUANTITIES`, such as ``viscosity``, see
        :func:`with_quantity`.
    value
        SI, or a text with a unit; at a path also a whole part.

    Raises
    ------
    QuestionError
        If there is no such entry or name; the message lists what there is.
    MachineError
        If the value is impossible there.
    """
    if machine_kind(machine) is not RACES:  # whose parts have plain names, too
        return with_value_at(machine, name, value)
    races = cast(Machine, machine)
    if name in QUANTITIES or len(parts_of(name)) > 1:
        return cast(EitherMachine, with_quantity(races, name, value))
    if meant := _near_quantity(races, name):
        raise QuestionError(f"parameter {name!r}: no such name; there are {', '.join(QUANTITIES)}, and paths{meant}")
    return with_value_at(machine, name, value)


def _near_quantity(machine: Machine, name: str) -> str:
    """The end of a message that suggests plain names; empty if none is near or the machine has such an entry."""
    if "." in name or "[" in name or name in type(machine).model_fields:
        return ""
    near = get_close_matches(name, QUANTITIES, n=2, cutoff=0.75)
    return f"; did you mean {' or '.join(map(repr, near))}?" if near else ""


def _together(machine: Machine, name: str, value: Any) -> Machine:
    first, *others = parts_of(name)
    for part in others:
        _is_path(part)  # refuses names that are none
    changed = with_quantity(machine, first, value)
    now = {part: value_of(machine, part) for part in (first, *others)}
    lacking = next((part for part, number in now.items() if math.isnan(number)), first if now[first] == 0.0 else "")
    if lacking:
        raise QuestionError(
            f"parameter {name!r}: {lacking!r} has {'the value zero' if now[lacking] == 0.0 else 'no single value'} in this "
            "machine, so that nothing can be in proportion to it; name others, or paths of single entries"
        )
    factor = si_value(machine, first, value) / now[first]
    for part in others:
        changed = with_quantity(changed, part, factor * now[part])
    return changed


def si_value(machine: Machine, name: str, value: Any) -> float:
    """A value of a quantity or path as a number in SI; of several that change together, of the first."""
    name, *_ = parts_of(name)
    if _is_path(name):
        return parameter_of(with_value_at(machine, name, value), name)
    if name == "count":
        number = float(to_si(value if isinstance(value, str) else float(value), ""))
        if number != int(number) or number < 1.0:
            raise QuestionError(f"quantity 'count': given {value!r}; must be a whole number of balls, 1 or more")
        return int(number)
    number = float(to_si(value if isinstance(value, str) else float(value), QUANTITIES[name].unit))
    if number < 0.0:
        raise QuestionError(f"quantity {name!r}: given {value!r}; must not be negative")
    return number


def parameter_range(machine: Machine, name: str, text: str, owner: str = "") -> np.ndarray:
    """A range such as ``"1:100 mm^2/s:30"`` as values of a quantity or path, SI; of a count all whole numbers in it.

    ``owner`` is what a message names, by default the parameter.
    """
    parameter_range = range_values(owner or name, text, parameter_unit(machine, name))
    return np.arange(round(parameter_range[0]), round(parameter_range[-1]) + 1) if name == "count" else parameter_range


def value_of(machine: Machine, name: str) -> float:
    """The value that the machine has, SI; nan if none, or not one for all. ``"speed"`` is the last prescribed one."""
    name, *_ = parts_of(name)
    if name == "speed":
        if not isinstance(machine.drive, PrescribedSpeed):
            return math.nan
        return float(profile_pieces(machine.drive.profile)[-1].numbers[0])
    if _is_path(name):
        return parameter_of(machine, name)
    if name in ("damping", "stiffness"):
        none = math.nan, math.nan  # of rotors that have one at each support
        x, y = getattr(settled(machine).rotor, f"{name}_xy", none)
        return float(x) if x == y else math.nan
    if name == "unbalance":
        return abs(sum(u.vector for u in machine.unbalances))
    balls = resolve(machine)
    if name == "count":
        return float(len(balls))
    races = [race for balancer in machine.balancers for race in balancer.races]
    if name == "viscosity":
        values = {fluid_numbers(race.fluid)[1] if race.fluid is not None else math.nan for race in races}
    elif name == "rolling_resistance":
        values = {float(race.friction.rolling_resistance) if race.friction is not None else 0.0 for race in races}
    elif name in ("temperature", "plateau"):
        given = [getattr(race.fluid if name == "temperature" else race.drag, name, None) for race in races]
        values = {math.nan if entry is None else float(entry) for entry in given}
    else:
        key = {"drag": "drag", "ball_mass": "mass", "ball_diameter": "diameter"}[name]
        values = {float(getattr(ball, key)) for ball in balls}
    return float(values.pop()) if len(values) == 1 else math.nan


def parameter_unit(machine: Machine, name: str) -> str:
    """The SI unit of a quantity or of the entry at a path, empty where it is a plain number.

    Raises
    ------
    QuestionError
        If there is no such quantity or entry.
    """
    first, *others = parts_of(name)
    if others:
        units = [parameter_unit(machine, part) for part in (first, *others)]  # refuses names that are none
        return units[0]
    if name == "speed" or name in QUANTITIES:
        return si_unit_of(name)
    if "." not in name:
        known = ", ".join(("speed", *QUANTITIES))
        raise QuestionError(
            f"parameter {name!r}: no such name; there are {known}, and paths such as 'rotor.damping'"
            f"{_near_quantity(machine, name) or did_you_mean(machine, name)}"
        )
    entry_at(machine, name)  # refuses a path that leads nowhere
    return unit_at(name)


def _is_path(name: str) -> bool:
    if name not in QUANTITIES and "." not in name:
        raise QuestionError(
            f"quantity {name!r}: no such name; there are {', '.join(QUANTITIES)}, "
            "and paths such as 'rotor.damping' or 'balancers[1].races[1].drag.damping'"
        )
    return name not in QUANTITIES


def _with_unbalances(machine: Machine, value: float) -> Machine:
    """All unbalances of a rotor in proportion, with this resultant."""
    now = value_of(machine, "unbalance")
    if now == 0.0:
        raise QuestionError(
            "quantity 'unbalance': the unbalances of this machine have no resultant that they could be in proportion to; give "
            "the path of one, such as 'unbalances[1].moment', or of a couple, 'unbalances[1].couple'"
        )
    if value == 0.0:
        return with_value_at(machine, "unbalances", ())
    sizes = ("moment", "radius", "couple", "misalignment")  # not the mass, which belongs to the rotor
    parts = []
    for part in machine.unbalances:
        options = {key: float(getattr(part, key)) * value / now for key in sizes if getattr(part, key) is not None}
        parts.append(changed_part(part, **options))
    return with_value_at(machine, "unbalances", tuple(parts))


def _with_races(machine: Machine, change: Callable[[str, Race], dict[str, Any]]) -> Machine:
    for b, balancer in enumerate(machine.balancers, 1):
        for r, race in enumerate(balancer.races, 1):
            where = f"balancers[{b}].races[{r}]"
            machine = with_value_at(machine, where, changed_part(race, **change(where, race)))
    return machine


# Parts of a race with another value of one quantity; refused by name where it has none.


def race_with_viscosity(where: str, race: Race, value: float) -> dict[str, Any]:
    """The fluid of a race with another kinematic viscosity."""
    if race.fluid is None or not race.drag.needs_fluid:
        raise QuestionError(
            f"quantity 'viscosity': the drag of {where} is given by its torque, which no viscosity changes; "
            "vary 'drag', or describe fluid and drag law"
        )
    density, _ = fluid_numbers(race.fluid)
    shear = race.fluid.shear
    if shear is not None and shear.measured_at is not None:
        raise QuestionError(
            f"quantity 'viscosity': the rates of shear of the fluid of {where} change with its temperature; vary 'temperature'"
        )
    return {"fluid": Fluid(density=density, viscosity=value, virtual_mass=race.fluid.virtual_mass, shear=shear)}


def race_with_rolling(race: Race, value: float) -> Friction:
    """The friction of a race with another rolling resistance."""
    given = race.friction or Friction()
    held = None if given.adherence is None else max(float(given.adherence), value)
    return Friction(rolling_resistance=value, adherence=held, rolling_law=given.rolling_law)


def race_with_temperature(where: str, race: Race, value: float) -> Fluid:
    """The fluid of a race at another temperature."""
    if race.fluid is None or race.fluid.name is None:
        raise QuestionError(
            f"quantity 'temperature': {where} has no fluid of the catalog, whose density and viscosity would change with it; "
            "name one"
        )
    changed: Fluid = changed_part(race.fluid, temperature=value)
    return changed


def race_with_plateau(where: str, race: Race, value: float) -> Any:
    """The law of drag of a race with another plateau."""
    if "plateau" not in type(race.drag).model_fields:
        raise QuestionError(f"quantity 'plateau': the law of drag of {where}, {race.drag.word()!r}, has none")
    return changed_part(race.drag, plateau=value)


def group_with_ball(group: Balls, ball: Any, name: str, value: float, where: str) -> Balls:
    """A group of balls with another count, mass or diameter."""
    if name == "count":
        kept = {key: getattr(group, key) for key in group.model_fields_set if not key.startswith("start")}
        return Balls(**{**kept, "count": int(value)})
    size = ("diameter", "mass", "density", "material")
    others = {key: getattr(group, key) for key in group.model_fields_set if key not in size}
    if name == "ball_mass":
        sized = {"diameter": ball.diameter} if ball.diameter else {}
        return Balls(**others, mass=value, **sized)
    if not ball.volume:
        raise QuestionError(f"quantity 'ball_diameter': the density of the {group.body}s of {where} is not known")
    if group.body == "roller":
        others["length"] = ball.volume / roller_face(group)
    return Balls(**others, diameter=value, density=ball.mass / ball.volume)


def changed_part(part: Any, **new: Any) -> Any:
    """A part with other entries, checked anew."""
    return type(part)(**{**{key: getattr(part, key) for key in part.model_fields_set}, **new})


# Change one parameter of a machine by its path, spelled as in error messages and files.


EitherMachine = TypeVar("EitherMachine", bound=Machine | ChamberMachine)


def with_value_at(machine: EitherMachine, path: str, value: Any) -> EitherMachine:
    """A machine in which the entry at ``path`` is ``value``.

    Parameters
    ----------
    machine
        Left as it is.
    path
        For example ``rotor.mass`` or ``balancers[1].races[1].balls[1].diameter``; entries are counted from 1.
    value
        SI, or a string with a unit, or a whole part.

    Raises
    ------
    QuestionError
        If there is no such entry; the message lists what there is.
    MachineError
        If the value is impossible there.
    """
    try:
        if isinstance(machine, Machine) and _is_spring(machine, path):
            changed: Any = _with_spring(machine, path, value)
        else:
            known = settled(machine, path) if isinstance(machine, Machine) else machine
            changed = with_entry(known, path, value)
    except MachineError as error:
        raise MachineError(f"parameter {path!r} = {value!r}: {error}") from None
    return cast(EitherMachine, changed)


def _is_spring(machine: Machine, path: str) -> bool:
    """Whether a path names one of these entries of a planar rotor."""
    return isinstance(machine.rotor, PlanarRotor) and path in (
        *WORDS,
        *(f"rotor.{keys[0]}" for keys in (SPRINGS, DAMPERS)),
    )


def _with_spring(machine: Machine, path: str, value: Any) -> Machine:
    """A machine with another entry of those that give springs and dampers; the others of its group are dropped.

    So a machine with a stiffness can be given a critical speed, and the other way round.
    """
    machine, key = settled(machine, path), path.removeprefix("rotor.")
    rotor = machine.rotor
    dropped = {*(SPRINGS if key in SPRINGS else DAMPERS)}
    kept = {name: getattr(rotor, name) for name in rotor.model_fields_set - dropped}
    changed = PlanarRotor(**{**kept, key: value})
    return Machine(**{**{name: getattr(machine, name) for name in machine.model_fields_set}, "rotor": changed})


def parameter_of(machine: Machine, path: str) -> float:
    """The number at a path, SI; of a planar rotor also the springs that follow from its critical speed.

    Raises
    ------
    QuestionError
        If there is no single number.
    """
    return _number_at(settled(machine, path), path)


def _number_at(machine: Part, path: str) -> float:
    """The number at a path, SI.

    Raises
    ------
    QuestionError
        If there is nothing, or no single number.
    """
    entry = entry_at(machine, path)
    if isinstance(entry, tuple) and entry and all(isinstance(part, float) for part in entry):
        raise QuestionError(f"parameter {path!r}: it is {len(entry)} numbers; choose one, such as '{path}[1]'")
    if isinstance(entry, bool) or not isinstance(entry, (int, float)):
        raise QuestionError(f"parameter {path!r}: is {shortened(entry)} in this machine, not a number")
    return float(entry)


# A machine made of another one, in the words of its author: the units, and a critical speed in place of a stiffness.


P = TypeVar("P", bound=Part)
USUAL = {
    "rad": "deg",
    "rad/s": "rpm",
    "kg*m": "g*mm",
    "m": "mm",
    "m^2/s": "mm^2/s",
    "K": "degC",
}  # where the author has none
DIGITS, READ = 10, 15  # of a number with a unit: written, and kept when it is read
WRITTEN = re.compile(r"^\s*[-+.\deE]+\s*(.*?)\s*$")


def in_author_units(machine: P, author: P, *, exact: bool = False) -> P:
    """The same machine with new numbers in the units in which the author of another one wrote such numbers.

    A number without a unit that the author wrote stays one; what he did not write at all has the unit that he took elsewhere
    for a quantity of its kind, else a usual one. Numbers are rounded to ten digits; ``exact`` ones are read back as they are,
    and stay without a unit where no text with one gives the same.
    """
    units: dict[str, str] = {}
    for quantity, value in _written(author):
        units.setdefault(quantity.unit, unit_of(value))
    changed: P = _part(machine, author, {**USUAL, **units}, (DIGITS, READ) if exact else (DIGITS,))
    return changed


def with_author_springs(machine: Machine, author: Machine) -> Machine:
    """The same planar rotor with a critical speed, damping ratio or bandwidth where the author of another one gave these."""
    rotor, before = machine.rotor, author.rotor
    if not isinstance(rotor, PlanarRotor) or not isinstance(before, PlanarRotor) or not rotor.settled:
        return machine
    mass = total_mass(machine, resolve(machine))
    keys = {key: getattr(rotor, key) for key in rotor.model_fields_set}
    speeds = [math.sqrt(k / mass) for k in rotor.stiffness_xy]
    ratios = [b / (2.0 * mass * w) for b, w in zip(rotor.damping_xy, speeds, strict=True)]
    if before.critical_speed is not None:
        keys |= {"stiffness": None, "critical_speed": _one_or_pair(speeds)}
    width = before.half_power_bandwidth
    if width is not None and _all_equal(ratios):
        keys |= {"damping": None, "half_power_bandwidth": 2.0 * ratios[0]}
    elif width is not None or before.damping_ratio is not None:
        keys |= {"damping": None, "damping_ratio": _one_or_pair(ratios)}
    return machine.model_copy(
        update={"rotor": PlanarRotor(**{key: value for key, value in keys.items() if value is not None})}
    )


def _all_equal(values: list[float]) -> bool:
    return math.isclose(values[0], values[1], rel_tol=1e-12)


def _one_or_pair(values: list[float]) -> float | tuple[float, ...]:
    return values[0] if _all_equal(values) else tuple(values)


def _written(part: Part) -> Iterator[tuple[Quantity, WrittenFloat]]:
    """All quantities of a part that were written with a unit."""
    for key in part.model_fields_set:
        quantity, stack = quantity_of(type(part), key), [getattr(part, key)]
        while stack:
            value = stack.pop()
            if isinstance(value, tuple):
                stack += reversed(value)
            elif isinstance(value, Part):
                yield from _written(value)
            elif isinstance(value, WrittenFloat) and quantity is not None:
                yield quantity, value


def unit_of(value: WrittenFloat) -> str:
    """The unit in which a quantity was written."""
    match = WRITTEN.match(value.text)
    return match[1] if match else ""


def _part(part: Any, author: Any, units: dict[str, str], digits: tuple[int, ...]) -> Any:
    changed = {}
    for key in part.model_fields_set:
        known = type(author) is type(part) and key in author.model_fields_set
        value, before = getattr(part, key), getattr(author, key) if known else None
        new = _entry(value, before, quantity_of(type(part), key), units, digits)
        if new is not value:
            changed[key] = new
    return part.model_copy(update=changed) if changed else part


def _entry(value: Any, author: Any, quantity: Quantity | None, units: dict[str, str], digits: tuple[int, ...]) -> Any:
    if isinstance(value, Part):
        return _part(value, author, units, digits)
    if isinstance(value, tuple):
        alike = isinstance(author, tuple) and len(author) == len(value)
        before = author if alike else (author[0] if isinstance(author, tuple) and author else author,) * len(value)
        new = tuple(_entry(one, other, quantity, units, digits) for one, other in zip(value, before, strict=True))
        return value if all(one is other for one, other in zip(new, value, strict=True)) else new
    if quantity is None or isinstance(value, WrittenFloat) or not isinstance(value, float):
        return value
    if isinstance(author, WrittenFloat):
        return _with_unit(value, unit_of(author), quantity.unit, digits)
    if isinstance(author, float) or not quantity.unit:
        return value  # as the author has it, in SI
    return _with_unit(value, units.get(quantity.unit, quantity.unit), quantity.unit, digits)


def _with_unit(value: float, written: str, unit: str, digits: tuple[int, ...]) -> float:
    """A number in SI as a text with this unit; itself where the unit is none for it, or no number of ``digits`` the same."""
    try:
        zero, one = (to_si(f"{number} {written}", unit) for number in (0, 1))
        texts = [f"{(value - zero) / (one - zero):.{count}g} {written}" for count in digits]
        read = [WrittenFloat(text, float(to_si(text, unit))) for text in texts]
    except (UnitError, ArithmeticError):
        return value
    return next((one for one in read if one == value or len(digits) == 1), value)
