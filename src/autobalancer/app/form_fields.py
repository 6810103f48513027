"""The fields of a form, read off the classes that check a machine file."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from autobalancer.app.problems import EntryPath, data_of, value_at, with_value, without
from autobalancer.assembly.quantities import in_author_units, parameter_of, value_of, with_quantity, with_value_at
from autobalancer.errors import AutobalancerError, QuestionError, UnitError, spell
from autobalancer.files.machine_file import machine_text, parse_machine
from autobalancer.machine import Machine, PrescribedSpeed
from autobalancer.machine.keys import TAGS, keys_of, parts_at
from autobalancer.machine.part import Part, quantity_of
from autobalancer.machine.path import QUANTITIES, entry_at, label_of_path, path_steps, si_unit_of, text_of, unit_at
from autobalancer.studies.study.study_spec import KINDS
from autobalancer.tables import in_plain_letters
from autobalancer.units import from_si, to_si

Kind = Literal["quantity", "choice", "switch", "text", "other", "table", "tables"]
PLAIN = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
NUMBER = re.compile(rf"\s*({PLAIN.pattern})\s*(.*?)\s*")
UNITS = {  # beside the SI unit, those in which a quantity is usually given
    "m": ("um", "mm", "cm"),
    "kg": ("g",),
    "s": ("ms",),
    "rad": ("deg",),
    "rad/s": ("rpm", "Hz"),
    "": ("%",),
    "K": ("degC",),
    "m/s": ("mm/s",),
    "m^2/s": ("mm^2/s",),
    "kg*m": ("g*mm",),
    "kg*m^2": ("kg*mm^2",),
    "N": ("mN", "kN"),
    "N/m": ("kN/m", "MN/m"),
    "N*s/m": ("kN*s/m",),
    "Pa": ("GPa",),
}
COMMA = re.compile(r"([-+]?\d*),(\d{1,2}|\d{4,})")  # three digits after it may be thousands: the reader asks then


@dataclass(frozen=True)
class Field:
    """One key as a form shows it."""

    name: str
    kind: Kind
    required: bool
    allowed: str  # what may stand there: unit, bounds, default
    meaning: str
    unit: str = ""  # SI, of a quantity
    units: tuple[str, ...] = ()  # in which it may be given
    choices: tuple[str, ...] = ()
    parts: tuple[type[Part], ...] = ()  # of a table
    default: str = ""  # of a text or a choice
    many: bool = False  # whether a list may stand there
    ends: bool = False  # whether 'from' and 'to' may stand there

    @property
    def help(self) -> str:
        """Meaning and what is allowed, as in the documentation."""
        return f"{self.meaning} ({self.allowed})" if self.meaning else self.allowed


@cache
def fields_of(part: type[Part]) -> tuple[Field, ...]:
    """The fields of a part, but the one that says which part it is."""
    return tuple(
        _field(part, key.name, key.value_and_default, key.meaning) for key in keys_of(part) if key.name not in TAGS
    )


def tag_of(part: type[Part]) -> str:
    """``kind`` or ``law``, where one of them says which part it is; else empty."""
    return next((tag for tag in TAGS if tag in part.model_fields), "")


def word_of(part: type[Part]) -> str:
    """The word of that tag."""
    tag = tag_of(part)
    return str(part.model_fields[tag].default) if tag else ""


def number_and_unit(value: Any, unit: str) -> tuple[str, str] | None:
    """``"4.4 g"`` as ``("4.4", "g")``, a number with its SI unit; ``None`` for anything else, such as a pair."""
    if isinstance(value, bool) or value is None:
        return None
    if isinstance(value, (int, float)):
        return f"{value:.12g}", unit
    found = NUMBER.fullmatch(value) if isinstance(value, str) else None
    return (found[1], found[2] or unit) if found else None


def in_unit(number: str, written: str, wanted: str, unit: str) -> str:
    """The same quantity in another unit; the number itself where one of the units is none of this quantity."""
    try:
        si = to_si(f"{float(number)!r} {written}" if written else float(number), unit)
        return f"{from_si(float(si), unit, wanted) if wanted else float(si):.10g}"
    except UnitError:
        return number


def written(number: str, chosen_unit: str, unit: str) -> Any:
    """What stands in the file for a number in a unit: a text, a plain number where the quantity has no unit, else nothing."""
    number = COMMA.sub(r"\1.\2", number.strip()) if COMMA.fullmatch(number.strip()) else number.strip()
    if not number:
        return ""
    if not unit and not chosen_unit and PLAIN.fullmatch(number):
        return int(number) if re.fullmatch(r"[-+]?\d+", number) else float(number)
    return f"{number} {chosen_unit}".strip()


def _field(part: type[Part], name: str, allowed: str, meaning: str) -> Field:
    info = part.model_fields[name]
    quantity = quantity_of(part, name)
    base: dict[str, Any] = {
        "name": name,
        "required": info.is_required(),
        "allowed": allowed,
        "meaning": in_plain_letters(meaning),
        "default": str(info.get_default() or "") if not info.is_required() else "",
        "many": "values" in quantity.shape if quantity is not None else _listed(info.annotation),
        "ends": quantity is not None and "range" in quantity.shape,
    }
    parts = parts_at(part, name)
    if parts:
        return Field(kind="tables" if "list" in allowed.split(";")[0] else "table", parts=parts, **base)
    ways = _alternatives(info.annotation)
    if quantity is not None and quantity.shape.startswith("one") and not _listed(info.annotation):
        units = (quantity.unit, *UNITS.get(quantity.unit, ()))
        return Field(kind="quantity", unit=quantity.unit, units=units, **base)
    if len(ways) == 1 and get_origin(ways[0]) is Literal:
        return Field(kind="choice", choices=tuple(map(str, get_args(ways[0]))), **base)
    if ways == [bool]:
        return Field(kind="switch", **base)
    if ways == [str]:
        return Field(kind="text", **base)
    return Field(kind="other", **base)


def _alternatives(annotation: Any) -> list[Any]:
    """What may stand in a place, without ``None`` and without what reads it."""
    if get_origin(annotation) is Annotated:
        return _alternatives(get_args(annotation)[0])
    if get_origin(annotation) in (Union, UnionType):
        return [way for entry in get_args(annotation) if entry is not NoneType for way in _alternatives(entry)]
    return [annotation]


def _listed(annotation: Any) -> bool:
    """Whether a list of any length, or a tuple of separate quantities, stands there."""
    if get_origin(annotation) is tuple:
        first = get_args(annotation)[0]
        return Ellipsis in get_args(annotation) or get_origin(first) is Annotated
    return any(
        _listed(entry) for entry in get_args(annotation) if get_origin(annotation) in (Union, UnionType, Annotated)
    )


# The numbers of a machine that may be varied or fitted, with their values as its text has them.


LEFT_OUT = ("run.", "start.")  # what is no quantity of the machine
USUAL = {"rad": "deg", "rad/s": "rpm", "kg*m": "g*mm", "m": "mm", "m^2/s": "mm^2/s"}


@dataclass(frozen=True)
class Number:
    """One number of a machine."""

    path: str
    label: str
    value: float  # SI
    number: str  # as it is written, or as a person would write it
    unit: str
    in_text: bool

    @property
    def given(self) -> str:
        """With its unit."""
        return f"{self.number} {self.unit}".strip()

    def around(self) -> tuple[str, str]:
        """Bounds about it for a search: half to double; of an angle half a turn to either side."""
        if unit_at(self.path) == "rad":
            half, middle = (180.0, float(self.number)) if self.unit == "deg" else (math.pi, self.value)
            unit = self.unit if self.unit == "deg" else "rad"
            return f"{middle - half:.6g} {unit}", f"{middle + half:.6g} {unit}"
        ends = sorted((0.5 * float(self.number), 2.0 * float(self.number)))
        if self.value == 0.0:
            return "", ""
        return f"{ends[0]:.6g} {self.unit}".strip(), f"{ends[1]:.6g} {self.unit}".strip()


def numbers_of(text: str, machine: Machine) -> list[Number]:
    """All numbers with a value, those of the text first; whole numbers, such as a count of balls, are not among them."""
    data = data_of(text) or {}
    found = [_number(path, data, machine) for path in _paths(machine, "") if not path.startswith(LEFT_OUT)]
    known = [one for one in found if one is not None]
    return sorted(known, key=lambda one: not one.in_text)


def with_numbers(text: str, fitted: Machine, paths: list[str]) -> str:
    """The text with the numbers that ``fitted`` has at these paths; comments and units stay.

    Where the text has another machine than the one that was fitted, it is the text of the fitted one.
    """
    edited = text
    try:
        for path in paths:
            value, steps = parameter_of(fitted, path), tuple(path_steps(path))
            unit = unit_at(path)
            held = number_and_unit(value_at(data_of(edited), steps), unit)
            wanted = held[1] if held else USUAL.get(unit, unit)
            number = in_unit(f"{value:.12g}", unit, wanted, unit)
            edited = with_value(edited, steps, written(f"{float(number):.8g}", wanted, unit))
        same: Any = parse_machine(edited, "machine")
        for path in paths:
            same = with_value_at(same, path, parameter_of(fitted, path))
    except (AutobalancerError, KeyError, TypeError, IndexError):
        return machine_text(fitted)
    said = {"description": ""}
    return edited if same.model_copy(update=said) == fitted.model_copy(update=said) else machine_text(fitted)


def _paths(owner: Any, start: str) -> Iterator[str]:
    """Paths of all numbers; entries are counted from 1, and lists of more than three numbers are left out."""
    if isinstance(owner, Part):
        for key in type(owner).model_fields:
            yield from _paths(getattr(owner, key), f"{start}.{key}".lstrip("."))
    elif isinstance(owner, tuple):
        if len(owner) <= 3 or any(isinstance(entry, Part) for entry in owner):
            for number, entry in enumerate(owner, start=1):
                yield from _paths(entry, f"{start}[{number}]")
    elif isinstance(owner, float) and math.isfinite(owner):
        yield start


def _number(path: str, data: Any, machine: Machine) -> Number | None:
    try:
        value, unit = parameter_of(machine, path), unit_at(path)
    except AutobalancerError:
        return None
    held = number_and_unit(value_at(data, tuple(path_steps(path))), unit)
    if held is None:
        usual = USUAL.get(unit, unit)
        held = in_unit(f"{value:.12g}", unit, usual, unit), usual
    elif held[1] != unit and in_unit(held[0], held[1], unit, unit) == held[0] and float(held[0]) != value:
        held = f"{value:.12g}", unit  # written in a unit that is not a usual one
    there = value_at(data, tuple(path_steps(path))) is not None
    return Number(path, label_of_path(path), value, held[0], held[1], there)


# Quantities of a machine, such as its last speed and its viscosity, written into its text; comments stay where they
# can.


CLOSE = 1e-6  # relative; numbers are written with eight digits
LAST = {"constant": "speed", "ramp": "end", "hill": "end", "reduction": "end"}  # keys with the last speed
MANY = {"table": "speed", "dwell": "speeds"}  # keys with all speeds


def machine_with(machine: Machine, wanted: Mapping[str, float]) -> Machine:
    """A machine with other values of some quantities, SI; ``"speed"`` is the last that its drive prescribes.

    Raises
    ------
    QuestionError
        If the machine has no such quantity.
    MachineError
        If the values make no possible machine.
    """
    for name, value in wanted.items():
        machine = _with_speed(machine, value) if name == "speed" else with_quantity(machine, name, value)
    return machine


def text_with(text: str, machine: Machine, wanted: Mapping[str, float]) -> str:
    """The text of a machine with other values of some quantities, SI; units and comments stay.

    Where that does not give the machine, it is the text of the changed machine, without comments. Raises as
    :func:`machine_with`.
    """
    changed = machine_with(machine, wanted)
    before, after = (tomllib.loads(machine_text(one)) for one in (machine, changed))
    edited = text
    try:
        for path, value in _differences(before, after, ()):
            if _is_default(machine, changed, path):
                continue
            edited = (
                without(edited, path) if value is None else with_value(edited, path, _as_written(edited, path, value))
            )
        if alike(parse_machine(edited, "machine"), changed):
            return _tidy(edited)
    except (AutobalancerError, KeyError, TypeError, IndexError, ValueError):
        pass  # the text is not written as the machine is, such as a table in a file beside it
    return machine_text(in_author_units(changed, machine))


def alike(a: Any, b: Any) -> bool:
    """Whether two machines, or parts of them, are the same but for rounding and the description."""
    if isinstance(a, Part):
        keys = [key for key in type(a).model_fields if key != "description"]
        return type(a) is type(b) and all(alike(getattr(a, key), getattr(b, key)) for key in keys)
    if isinstance(a, tuple) and isinstance(b, tuple):
        return len(a) == len(b) and all(map(alike, a, b))
    if isinstance(a, float) and isinstance(b, float):
        return math.isclose(a, b, rel_tol=CLOSE)
    return bool(a == b)


def _with_speed(machine: Machine, value: float) -> Machine:
    profile = machine.drive.profile if isinstance(machine.drive, PrescribedSpeed) else None
    if profile is None:
        raise QuestionError(
            "speed: a torque drives this machine, so its speed follows from that and is no number of its file"
        )
    if profile.kind in LAST:
        return with_value_at(machine, f"drive.profile.{LAST[profile.kind]}", value)
    key = MANY[profile.kind]
    speeds = [float(speed) for speed in getattr(profile, key)]
    if not speeds[-1] > 0.0:
        raise QuestionError(
            "speed: the drive of this machine ends at standstill; change its profile on the page Describe"
        )
    first = len(speeds)
    while first and speeds[first - 1] == speeds[-1]:
        first -= 1
    for number in range(first, len(speeds)):
        machine = with_value_at(machine, f"drive.profile.{key}[{number + 1}]", value)
    return machine


def _differences(before: Any, after: Any, path: EntryPath) -> Iterator[tuple[EntryPath, Any]]:
    """Paths with what stands there after; ``None`` where nothing does. Another law or kind is another table."""
    if before == after:
        return
    if isinstance(before, dict) and isinstance(after, dict):
        if all(before.get(tag) == after.get(tag) for tag in ("kind", "law")):
            for key in before:
                if key not in after:
                    yield (*path, key), None
            for key, value in after.items():
                yield from _differences(before.get(key), value, (*path, key))
            return
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for number, (one, other) in enumerate(zip(before, after, strict=True)):
            yield from _differences(one, other, (*path, number))
        return
    yield path, after


def _is_default(machine: Machine, changed: Machine, path: EntryPath) -> bool:
    """Whether what is new in the text is what stood there unwritten."""
    where = spell(path)
    try:
        return bool(entry_at(machine, where) == entry_at(changed, where))
    except QuestionError:
        return False


def _tidy(text: str) -> str:
    """Blanks in tables on one line as people set them, where that changes nothing else."""
    tidied = re.sub(r",(?=[a-z_]+ = )", ", ", re.sub(r"\{ {2,}", "{ ", text))
    return tidied if data_of(tidied) == data_of(text) else text


def _as_written(text: str, path: EntryPath, value: Any) -> Any:
    """A number with the unit that the text has there, or that people take."""
    if isinstance(value, dict):
        return {key: _as_written(text, (*path, key), one) for key, one in value.items()}
    unit = unit_at(spell(path))
    given = number_and_unit(value, unit)
    if given is None or not unit:
        return value
    held = number_and_unit(value_at(data_of(text), path), unit)
    wanted = held[1] if held else USUAL.get(unit, unit)
    number = in_unit(given[0], given[1], wanted, unit)
    if number == given[0]:  # one of the units is not a usual one
        wanted = given[1]
    return written(f"{float(number):.8g}", wanted, unit)


# What varies in the text of a study, as rows of a form: values or a distribution, each entry as a person writes it.


VALUES = "values"
WORDS = {VALUES: "values", **{word: word for word in KINDS}, "discrete": "one of several"}
SHOWN = {  # entries of each kind in the form
    VALUES: (VALUES,),
    **{word: tuple(name for name in kind.model_fields if name not in TAGS) for word, kind in KINDS.items()},
}


@dataclass(frozen=True)
class Row:
    """One parameter that varies."""

    name: str
    at: EntryPath  # in the tables of the study
    kind: str
    label: str
    entries: dict[str, str]  # as they are written


def varied_rows(text: str) -> list[Row]:
    """All that varies, in the order of the text."""
    data = data_of(text) or {}
    vary = data.get("vary")
    return [_row(at, given) for at, given in _spread(vary if isinstance(vary, dict) else {}, ("vary",))]


def offered(text: str, machine: Machine) -> dict[str, Number]:
    """What of a machine may vary, by its name: quantities such as the viscosity, then all its numbers."""
    found = {}
    for name in QUANTITIES:
        try:
            value = value_of(machine, name)
        except AutobalancerError:
            continue
        if math.isfinite(value):
            unit = si_unit_of(name)
            usual = "degC" if unit == "K" else USUAL.get(unit, unit)
            number = f"{float(in_unit(f'{value:.12g}', unit, usual, unit)):.6g}"
            found[name] = Number(name, text_of(name), value, number, usual, True)
    return found | {one.path: one for one in numbers_of(text, machine)}


def with_row(text: str, number: Number) -> str:
    """The text with one more parameter that varies, by 10 % to begin with."""
    return _spaced(with_value(text, ("vary", number.path), fresh("normal", number)))


def with_kind(text: str, row: Row, kind: str, number: Number | None) -> str:
    """The text with another distribution of a parameter; what both have stays."""
    known = fresh(kind, number)
    if kind != VALUES and isinstance(known, dict):
        for key in SHOWN[kind]:
            if row.entries.get(key) and key != VALUES:
                known[key] = as_entry(row.entries[key])
    return _spaced(with_value(text, row.at, known))


def with_entry(text: str, row: Row, key: str, given: str) -> str:
    """The text with another entry of a parameter; without it where nothing is given."""
    many = key in (VALUES, "weights")
    value = as_list(given) if many else as_entry(given)
    if row.kind == VALUES:
        return with_value(text, row.at, value)
    return with_value(text, (*row.at, key), value) if given.strip() else without(text, (*row.at, key))


def fresh(kind: str, number: Number | None) -> Any:
    """A distribution to begin with, about what the machine has."""
    unit = number.unit if number is not None else ""
    middle = float(number.number) if number is not None else 1.0
    away, width = (0.1 * abs(middle), "10 %") if middle else (1.0, f"1 {unit}".strip())
    if unit in ("degC", "degF", "K"):
        away, width = 10.0, "5 K"
    if unit == "deg":
        away, width = (180.0, "10 deg")
    low, high = (_written(middle + sign * away, unit) for sign in (-1.0, 1.0))
    several = [_written(middle + part * 3.0 * away, unit) for part in (-1.0, 0.0, 1.0)]
    if kind == VALUES:
        return several
    of = {
        "normal": {"standard_deviation": width},
        "uniform": {"low": low, "high": high},
        "log-normal": {"factor": 1.1},
        "triangular": {"low": low, "high": high},
        "tolerance": {"plus_minus": width},
        "discrete": {VALUES: several},
    }
    return {"distribution": kind, **of[kind]}


def as_entry(given: str) -> Any:
    """A number where no unit is written, else the text."""
    given = given.strip()
    return _spread_number(given) if PLAIN.fullmatch(given) else given


def as_list(given: str) -> Any:
    """``5, 10, 20 mm^2/s`` as a list; a unit at the end is that of all; a range stays a text."""
    given = given.strip().removeprefix("[").removesuffix("]")
    if ":" in given:
        return given
    parts = [part.strip().strip('"') for part in given.split(",") if part.strip()]
    last = number_and_unit(parts[-1], "") if parts else None
    unit = last[1] if last else ""
    return [as_entry(f"{part} {unit}" if unit and PLAIN.fullmatch(part) else part) for part in parts]


def entry_text(value: Any) -> str:
    """An entry as a person writes it: of a list whose entries have one unit it stands at the end."""
    if value is None:
        return ""
    if not isinstance(value, list):
        return f"{value:.12g}" if isinstance(value, float) else str(value)
    found = [number_and_unit(one, "") for one in value]
    units = {one[1] for one in found if one is not None}
    if all(found) and len(units) == 1:
        return f"{', '.join(one[0] for one in found if one)} {units.pop()}".strip()
    return ", ".join(map(str, value))


def _spaced(text: str) -> str:
    """With an empty line above each table."""
    found = re.sub(r"(?m)^([^\n#\[][^\n]*\n)(?=\[)", r"\1\n", text)
    return found if data_of(found) == data_of(text) else text


def _spread(table: dict[str, Any], at: EntryPath) -> Iterator[tuple[EntryPath, Any]]:
    """Entries of 'vary', those of tables of the study as ``sudden_unbalance.angle``, too."""
    for name, given in table.items():
        tables = isinstance(given, dict) and given and all(isinstance(value, (dict, list)) for value in given.values())
        if tables and not {"distribution", VALUES} & set(given):
            yield from _spread(given, (*at, name))
        else:
            yield (*at, name), given


def _row(at: EntryPath, given: Any) -> Row:
    name = ".".join(map(str, at[1:]))
    if not isinstance(given, dict):
        return Row(name, at, VALUES, _label(name), {VALUES: entry_text(given)})
    if "distribution" not in given:
        return Row(name, at, VALUES, _label(name), {VALUES: entry_text(given.get(VALUES))})
    kind = str(given["distribution"])
    entries = {key: entry_text(value) for key, value in given.items() if key != "distribution"}
    return Row(name, at, kind if kind in KINDS else "", _label(name), entries)


def _label(name: str) -> str:
    try:
        return text_of(name)
    except AutobalancerError:
        return name


def _written(value: float, unit: str) -> Any:
    number = f"{value:.6g}"
    return f"{number} {unit}" if unit else _spread_number(number)


def _spread_number(text: str) -> int | float:
    return int(text) if re.fullmatch(r"[-+]?\d+", text) else float(text)
