"""The keys of a machine file, read off the classes that check them: value, default, meaning."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import PlainValidator
from pydantic.fields import FieldInfo

from autobalancer.machine.part import Family, Part, Quantity, said_of, symbol_of
from autobalancer.machine.plugins import OneOf

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
    if words := said_of(field, "default"):
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
    if words := said_of(field, "value"):
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
