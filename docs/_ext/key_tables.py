"""The tables of keys of a machine file, read off the classes that check them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from inspect import getclosurevars
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from meanings import MEANINGS
from pydantic import PlainValidator
from pydantic.fields import FieldInfo
from sphinx.util import logging

from autobalancer.machine import Machine
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.machine.part import Part

TAGS = ("kind", "law")  # keys whose value says which class it is
HEAD = "| key | value | default | meaning |\n|---|---|---|---|\n"

ROOTS: dict[str, type[Part]] = {"machine_keys.md": Machine, "chamber_keys.md": ChamberMachine}
_GROUPS = {1: "", 2: "pair of ", 3: "three of "}

Variants = tuple[type[Part], ...]


def pages() -> dict[str, str]:
    """What the documentation includes."""
    explained: set[str] = set()
    made = {name: machine_keys(root, explained) for name, root in ROOTS.items()}
    for name in sorted(set(MEANINGS) - explained):
        logging.getLogger(__name__).warning("docs/_ext/meanings.py explains %s, which no machine has", name)
    return made


def machine_keys(root: type[Part], explained: set[str]) -> str:
    """One section for each table of the file, in the order in which the classes contain each other.

    The keys that it has are added to ``explained``.
    """
    return "".join(_section(header, variants, explained) for header, variants in _tables("", (root,), set(), False))


def _tables(path: str, variants: Variants, seen: set[type[Part]], many: bool) -> Iterator[tuple[str, Variants]]:
    """Header and classes of every table from ``path`` on; a class that has its table already is left out."""
    if variants[0] in seen:
        return
    seen.update(variants)
    yield (f"`[[{path}]]`" if many else f"`[{path}]`") if path else "At the top", variants
    for part in variants:
        for key, field in part.model_fields.items():
            inner = tuple(leaf for leaf in _leaves(field.annotation) if _is_part(leaf))
            if inner:
                yield from _tables(f"{path}.{key}".lstrip("."), inner, seen, _is_list(field.annotation))


def _section(header: str, variants: Variants, explained: set[str]) -> str:
    one = len(variants) == 1
    lead = f"{_prose(variants[0])}\n\n" if one else ""
    rows = "".join(_row(part, key, field, one, explained) for part in variants for key, field in _fields(part))
    return f"### {header}\n\n{lead}{HEAD}{rows}\n"


def _fields(part: type[Part]) -> list[tuple[str, FieldInfo]]:
    """The keys of a class, the one that says which it is first."""
    return sorted(part.model_fields.items(), key=lambda entry: entry[0] not in TAGS)


def _row(part: type[Part], key: str, field: FieldInfo, one: bool, explained: set[str]) -> str:
    if key in TAGS:
        meaning = "the only one so far" if one else _prose(part).split("\n\n")[0]
        return f'| **`{key} = "{field.default}"`** | | | {meaning} |\n'
    name = f"{part.__name__}.{key}"
    explained.add(name)
    meaning = field.description or MEANINGS.get(name, "")
    if not meaning:
        logging.getLogger(__name__).warning("nobody says what %s means; add it to docs/_ext/meanings.py", name)
    return f"| `{key}` | {_value(field)} | {_default(field)} | {meaning} |\n"


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "required"
    value = field.get_default(call_default_factory=True)
    if value is None or value in ((), ""):
        return "–"
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    if isinstance(value, Part):
        return "all at rest"
    if isinstance(value, tuple):
        return ", ".join(f"{entry:g}" for entry in value)
    return f'`"{value}"`' if isinstance(value, str) else f"{value:g}"


def _value(field: FieldInfo) -> str:
    """Unit and bound, or the words allowed, or that a table goes there."""
    metadata = tuple(extra for extra in field.metadata if isinstance(extra, PlainValidator))
    leaves = list(_leaves(Annotated[(field.annotation, *metadata)] if metadata else field.annotation))
    several = _is_list(field.annotation)
    if any(_is_part(leaf) for leaf in leaves):
        return "list of tables" if several else "table"
    lowest = [extra.ge for extra in field.metadata if hasattr(extra, "ge")]
    text = " or ".join(dict.fromkeys(_leaf(leaf) for leaf in leaves)) + "".join(f", ≥ {bound}" for bound in lowest)
    # a validator of the whole field says itself how many it wants
    return f"{'list of ' if several else '' if metadata else _GROUPS[_count(field.annotation)]}{text}"


def _leaf(leaf: Any) -> str:
    if get_origin(leaf) is Literal:
        return " or ".join(f'`"{word}"`' for word in get_args(leaf))
    for extra in get_args(leaf)[1:]:
        if isinstance(extra, PlainValidator):
            return _quantity(extra.func)
    return {str: "text", int: "whole number", bool: "`true` or `false`"}[leaf]


def _quantity(read: Any) -> str:
    """Unit and bound with which a validator of ``machine.part`` was made."""
    made_with = getclosurevars(read).nonlocals
    if "without_low" in made_with:
        low, high = made_with["low"], made_with["high"]
        return f"number, {'>' if made_with['without_low'] else '≥'} {low:g}, ≤ {high:g}"
    if "single" in made_with and read.__module__.endswith("triple"):
        return f"three of {_quantity(made_with['single'])}"
    if "single" in made_with:
        return f"{_quantity(made_with['single'])}; one, or a pair along x and y"
    if read.__name__ == "_bandwidth":
        return "number or rad/s, ≥ 0"
    if "unit" not in made_with:
        return "m, or the name of a station"
    unit = made_with["unit"].replace("*", " ").replace("^2", "²").replace("^3", "³") or "number"
    return unit + (", > 0" if made_with["positive"] else ", ≥ 0" if made_with["non_negative"] else "")


def _leaves(annotation: Any) -> Iterator[Any]:
    """What may stand in a place, one entry of a list for all of it, without ``None``."""
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is Annotated and not any(isinstance(extra, PlainValidator) for extra in arguments[1:]):
        yield from _leaves(arguments[0])
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


def _prose(part: type[Part]) -> str:
    """The docstring of a class as Markdown."""
    text = re.sub(r"``(.+?)``", r"`\1`", part.__doc__ or "")
    return "\n\n".join(" ".join(block.split()) for block in text.split("\n\n"))
