"""The keys of a machine file, read off the classes that check them: value, default, meaning."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import PlainValidator
from pydantic.fields import FieldInfo

from autobalancer.errors import spell
from autobalancer.machine.part import Family, Part, Quantity, Range, key_note, quantity_of, symbol_of
from autobalancer.machine.plugins import OneOf
from autobalancer.units import WrittenFloat, from_si

SCALARS = (PlainValidator, Quantity)  # what reads a single entry
TAGS = ("kind", "law", "distribution")  # keys whose value says which class it is
_HEAD = "\n\n    Parameters\n    ----------\n    "
_GROUPS = {1: "", 2: "pair of ", 3: "three of "}


@dataclass(frozen=True)
class Key:
    """One key: what may stand there (unit and bounds of a quantity), its default, its meaning, its symbol (LaTeX)."""

    name: str
    value: str
    default: str
    meaning: str
    symbol: str = ""

    @property
    def value_and_default(self) -> str:
        """``"N m s, ≥ 0; default 0"``."""
        said = {"": "", "–": "; optional", "required": "; required"}
        return self.value + said.get(self.default, f"; default {self.default}")


@dataclass(frozen=True)
class Table:
    """A table of a file at ``path``: the classes that may describe it, and whether it is a list of tables."""

    path: str
    parts: tuple[type[Part], ...]
    many: bool

    @property
    def header(self) -> str:
        """As in a file: ``[rotor]`` or ``[[unbalances]]``, empty at the top."""
        return (f"[[{self.path}]]" if self.many else f"[{self.path}]") if self.path else ""


def tables_of(root: type[Part]) -> Iterator[Table]:
    """Every table of a file, in the order in which the classes contain each other; no class twice."""
    yield from _tables("", (root,), set(), False)


def keys_of(part: type[Part]) -> list[Key]:
    """The keys of a part, the one that says which it is first."""
    fields = sorted(part.model_fields.items(), key=lambda entry: entry[0] not in TAGS)
    return [_key(part, name, field) for name, field in fields]


def parts_at(part: type[Part], name: str) -> tuple[type[Part], ...]:
    """The parts that may stand at a key, one entry of a list for all of it."""
    return tuple(leaf for leaf in _leaves(_hint(part.model_fields[name])) if _is_part(leaf))


def prose_of(part: type[Part]) -> str:
    """What a part says of itself, without its keys."""
    return (part.__doc__ or "").split(_HEAD)[0].rstrip()


def document(root: type[Part]) -> None:
    """Add the keys to the docstring of every part of a file, so that ``help(Race)`` shows them."""
    for table in tables_of(root):
        for part in table.parts:
            rows = (f"{key.name} : {key.value}{_stands(key)}\n        {key.meaning}" for key in keys_of(part))
            part.__doc__ = prose_of(part) + _HEAD + "\n    ".join(rows)


def _stands(key: Key) -> str:
    if key.name in TAGS:
        return ""
    return ", optional" if key.default == "–" else f", {'' if key.default == 'required' else 'default '}{key.default}"


def summary_of(part: type[Part]) -> str:
    """The first paragraph of what a part says of itself."""
    return " ".join((part.__doc__ or "").split("\n\n")[0].split())


def _key(part: type[Part], name: str, field: FieldInfo) -> Key:
    if name in TAGS:
        return Key(name, f'"{field.default}"', "", summary_of(part))
    return Key(name, _value(field), _default(field), field.description or "", symbol_of(part, name))


def _tables(path: str, parts: tuple[type[Part], ...], seen: set[type[Part]], many: bool) -> Iterator[Table]:
    if parts[0] in seen:
        return
    seen.update(parts)
    yield Table(path, parts, many)
    for part in parts:
        for name, field in part.model_fields.items():
            inner = parts_at(part, name)
            if inner:
                yield from _tables(f"{path}.{name}".lstrip("."), inner, seen, _is_list(field.annotation))


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "required"
    if words := key_note(field, "default"):
        return words
    value = field.get_default(call_default_factory=True)
    if value is None or value in ((), "", {}):
        return "–"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, Part):
        return "all at rest"
    if isinstance(value, tuple):
        return ", ".join(f'"{entry}"' if isinstance(entry, str) else f"{entry:g}" for entry in value)
    return f'"{value}"' if isinstance(value, str) else f"{value:g}"


def _value(field: FieldInfo) -> str:
    """Unit and bound, or the words allowed, or that a table goes there."""
    if words := key_note(field, "value"):
        return words
    metadata = any(isinstance(extra, SCALARS) for extra in field.metadata)
    leaves = list(_leaves(_hint(field)))
    several = _is_list(field.annotation)
    if any(_is_part(leaf) for leaf in leaves):
        return "list of tables" if several else "table"
    lowest = [extra.ge for extra in field.metadata if hasattr(extra, "ge")]
    text = " or ".join(dict.fromkeys(_leaf(leaf) for leaf in leaves)) + "".join(f", ≥ {bound}" for bound in lowest)
    # a validator of the whole field says itself how many it wants
    return f"{'list of ' if several else '' if metadata else _GROUPS[_count(field.annotation)]}{text}"


def _hint(field: FieldInfo) -> Any:
    """The annotation of a field, with what reads it."""
    readers = tuple(extra for extra in field.metadata if isinstance(extra, (*SCALARS, OneOf)))
    return Annotated[(field.annotation, *readers)] if readers else field.annotation


def _leaf(leaf: Any) -> str:
    if get_origin(leaf) is Literal:
        return " or ".join(f'"{word}"' for word in get_args(leaf))
    for extra in get_args(leaf)[1:]:
        if isinstance(extra, Quantity):
            return extra.words
        if isinstance(extra, PlainValidator):
            return "text"  # a name or a label
    return {str: "text", int: "whole number", float: "number", bool: "true or false"}[leaf]


def _leaves(annotation: Any) -> Iterator[Any]:
    """What may stand in a place, one entry of a list for all of it, without ``None``."""
    origin, arguments = get_origin(annotation), get_args(annotation)
    family = next((extra for extra in arguments[1:] if isinstance(extra, (OneOf, Family))), None)
    if family is not None:
        yield from family.parts
    elif origin is Annotated and not any(isinstance(extra, SCALARS) for extra in arguments[1:]):
        yield from _leaves(arguments[0])
    elif origin is dict:
        yield from _leaves(arguments[1])
    elif origin in (Union, UnionType, tuple):
        for entry in arguments:
            yield from () if entry is Ellipsis else _leaves(entry)
    elif annotation is not NoneType:
        yield annotation


def _is_part(leaf: Any) -> bool:
    return isinstance(leaf, type) and issubclass(leaf, Part)


def _is_list(annotation: Any) -> bool:
    """Whether a list of any length goes there."""
    return (get_origin(annotation) is tuple and Ellipsis in get_args(annotation)) or any(
        _is_list(entry) for entry in get_args(annotation)
    )


def _count(annotation: Any) -> int:
    """How many entries a tuple of fixed length has that goes there; 1 where anything else may stand."""
    ways = [entry for entry in get_args(annotation) if entry is not NoneType]
    if get_origin(annotation) is tuple:
        return len(ways)
    return _count(ways[0]) if get_origin(annotation) in (Union, UnionType) and len(ways) == 1 else 1


# Numbers without a unit that are so large or so small in SI that another unit was surely in mind.
#
# They stand within the bounds of what is possible, so a note says how they were read. A text with a unit is never
# asked.


USUAL = {  # SI unit: smallest and largest number that passes without a note, and the unit that people have in mind
    "rad/s": (0.0, 300.0, "rpm"),
    "rad": (0.0, 2.0 * math.pi, "deg"),
    "m": (0.0, 2.0, "mm"),
    "kg": (0.0, 10_000.0, "g"),
    "kg*m": (0.0, 0.1, "g*mm"),
    "kg/m^3": (100.0, math.inf, "g/cm^3"),
    "m^2/s": (0.0, 0.01, "mm^2/s"),
    "K": (150.0, 1000.0, "degC"),
    "N/m": (100.0, math.inf, "kN/m"),
}
PRESSURE = "GPa or MPa"  # of steel on steel: 2.5 GPa, 2500 MPa
OF_KEYS = {  # the same of single keys, in place of those above; a gas may have a low density
    ("PlanarRotor", "damping_ratio"): (0.0, 1.0, "%"),
    ("Balls", "mass"): (0.0, 1.0, "g"),
    ("Balls", "diameter"): (0.0, 0.1, "mm"),
    ("FreeBalls", "mass"): (0.0, 1.0, "g"),
    ("FreeBalls", "diameter"): (0.0, 0.1, "mm"),
    ("Unbalance", "mass"): (0.0, 10.0, "g"),
    ("Unbalance", "couple"): (0.0, 0.1, "kg*mm^2"),
    ("Race", "orbit_radius"): (0.0, 1.0, "mm"),
    ("Race", "race_radius"): (0.0, 1.0, "mm"),
    ("Race", "eccentricity"): (0.0, 0.01, "um"),
    ("Harmonic", "amplitude"): (0.0, 0.01, "um"),
    ("ViscousDrag", "damping"): (0.0, 0.1, "mN*m*s"),
    ("Fluid", "density"): (0.01, math.inf, "g/cm^3"),
    ("Limits", "peak_deflection"): (0.0, 0.1, "mm"),
    ("Limits", "residual_vibration"): (0.0, 0.1, "mm"),
    ("Limits", "contact_pressure"): (1e6, math.inf, PRESSURE),
    ("Space", "wall"): (0.0, 0.1, "mm"),
    ("Candidates", "orbit_radius"): (0.0, 1.0, "mm"),
    ("Candidates", "ball_diameter"): (0.0, 0.1, "mm"),
}
ECHOED = {"rad/s": "rpm", "rad": "deg", "K": "degC"}  # units in which a slip is seen at once
LISTED = 5
Place = tuple[str | int, ...]


def bare_numbers(machine: Part) -> tuple[str, ...]:
    """Sentences on how numbers without a unit were read where that is hardly meant; of a list only the first."""
    bare_numbers = list(_odd(machine, ()))
    more = (f"and {len(bare_numbers) - LISTED} more numbers without a unit that are hardly meant in SI",)
    return tuple(bare_numbers[:LISTED]) + (more if len(bare_numbers) > LISTED else ())


def _odd(part: Part, path: Place) -> Iterator[str]:
    for key in type(part).model_fields:
        if key not in part.model_fields_set:
            continue
        entries = _entries(getattr(part, key), (*path, key))
        for place, entry in entries:
            if isinstance(entry, Part):
                yield from _odd(entry, place)
        held = quantity_of(type(part), key)
        if held is None:
            continue
        low, high, meant = OF_KEYS.get((type(part).__name__, key)) or USUAL.get(held.unit, (0.0, math.inf, ""))
        for place, entry in entries:
            if _outside(entry, low, high):
                yield _read_as(spell(place), float(entry), held.unit, meant)
                break


def _entries(value: Any, path: Place) -> list[tuple[Place, Any]]:
    """A value, or those of a list or a range, with their places."""
    if isinstance(value, Range) and value.low is not value.high:
        return [((*path, "from"), value.low), ((*path, "to"), value.high)]
    value = value.low if isinstance(value, Range) else value
    return (
        [((*path, number), entry) for number, entry in enumerate(value)]
        if isinstance(value, tuple)
        else [(path, value)]
    )


def _outside(value: Any, low: float, high: float) -> bool:
    if not isinstance(value, (int, float)) or isinstance(value, (bool, WrittenFloat)):
        return False
    return value != 0.0 and not low <= abs(value) <= high


def _read_as(place: str, number: float, unit: str, meant: str) -> str:
    shown = f"{number:.10g}"
    if meant == PRESSURE:
        meant = "GPa" if abs(number) < 100.0 else "MPa"
    if not unit:
        return f'{place} = {shown} was read as {100.0 * number:.5g} %; write it with its unit, "{shown} {meant}" if that is meant'
    also = f", which is {from_si(number, unit, ECHOED[unit]):.5g} {ECHOED[unit]}" if unit in ECHOED else ""
    return (
        f"{place} = {shown} was read in {unit}{also}, since a number without a unit is SI; "
        f'write it with its unit, "{shown} {meant}" if that is meant'
    )
