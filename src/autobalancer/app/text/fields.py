"""The fields of a form, read off the classes that check a machine file."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from autobalancer.errors import UnitError
from autobalancer.machine import Machine
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.machine.keys import TAGS, keys_of, parts_at
from autobalancer.machine.part import Part, quantity_of
from autobalancer.shown import in_plain_letters
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
ASKED: dict[
    str, tuple[tuple[tuple[str, ...], tuple[str, ...]], ...]
] = {  # keys to fill in, unless one of the others is given
    "PlanarRotor": (
        (("critical_speed", "stiffness"), ("rubber",)),
        (("damping_ratio",), ("damping", "half_power_bandwidth", "rubber")),
    ),
    "Unbalance": tuple(((key,), ("moment", "couple", "misalignment")) for key in ("mass", "radius")),
    "Race": ((("orbit_radius", "bearing"), ("race_radius",)),),
    "Fluid": ((("name",), ("density", "viscosity")),),
    "Balls": ((("diameter", "mass"), ()), (("material",), ("density",))),
}


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

    @property
    def help(self) -> str:
        """Meaning and what is allowed, as in the documentation."""
        return f"{self.meaning} ({self.allowed})" if self.meaning else self.allowed


def root_of(data: dict[str, Any]) -> type[Part]:
    """The class of a machine file, from its keys."""
    return ChamberMachine if "chambers" in data else Machine


@cache
def fields_of(part: type[Part]) -> tuple[Field, ...]:
    """The fields of a part, but the one that says which part it is."""
    return tuple(
        _field(part, key.name, key.value_and_default, key.meaning) for key in keys_of(part) if key.name not in TAGS
    )


def asked_of(part: type[Part], data: dict[str, Any]) -> set[str]:
    """Optional keys of a part that a form asks for: one of several ways to say what has to be said, and none is taken yet."""
    groups = ASKED.get(part.__name__, ())
    return {key for keys, others in groups if not {*keys, *others} & set(data) for key in keys}


def tag_of(part: type[Part]) -> str:
    """``kind`` or ``law``, where one of them says which part it is; else empty."""
    return next((tag for tag in TAGS if tag in part.model_fields), "")


def word_of(part: type[Part]) -> str:
    """The word of that tag."""
    tag = tag_of(part)
    return str(part.model_fields[tag].default) if tag else ""


def chosen(parts: tuple[type[Part], ...], data: Any) -> type[Part] | None:
    """Which of several parts a table of a file is; ``None`` if it does not say."""
    if len(parts) == 1:
        return parts[0]
    given = data if isinstance(data, dict) else {}
    return next((part for part in parts if given.get(tag_of(part)) == word_of(part)), None)


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
    base: dict[str, Any] = {
        "name": name,
        "required": info.is_required(),
        "allowed": allowed,
        "meaning": in_plain_letters(meaning),
    }
    parts = parts_at(part, name)
    if parts:
        return Field(kind="tables" if "list" in allowed.split(";")[0] else "table", parts=parts, **base)
    ways = _ways(info.annotation)
    quantity = quantity_of(part, name)
    if quantity is not None and quantity.shape != "three" and not _listed(info.annotation):
        units = (quantity.unit, *UNITS.get(quantity.unit, ()))
        return Field(kind="quantity", unit=quantity.unit, units=units, **base)
    if len(ways) == 1 and get_origin(ways[0]) is Literal:
        return Field(kind="choice", choices=tuple(map(str, get_args(ways[0]))), **base)
    if ways == [bool]:
        return Field(kind="switch", **base)
    if ways == [str]:
        return Field(kind="text", **base)
    return Field(kind="other", **base)


def _ways(annotation: Any) -> list[Any]:
    """What may stand in a place, without ``None`` and without what reads it."""
    if get_origin(annotation) is Annotated:
        return _ways(get_args(annotation)[0])
    if get_origin(annotation) in (Union, UnionType):
        return [way for entry in get_args(annotation) if entry is not NoneType for way in _ways(entry)]
    return [annotation]


def _listed(annotation: Any) -> bool:
    """Whether a list of any length, or a tuple of separate quantities, stands there."""
    if get_origin(annotation) is tuple:
        first = get_args(annotation)[0]
        return Ellipsis in get_args(annotation) or get_origin(first) is Annotated
    return any(
        _listed(entry) for entry in get_args(annotation) if get_origin(annotation) in (Union, UnionType, Annotated)
    )
