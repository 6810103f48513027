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
from autobalancer.machine.part import Part

TAGS = ("kind", "law")
HEAD = "| key | value | default | meaning |\n|---|---|---|---|\n"


def machine_keys() -> str:
    """One section for each table of the file, in the order in which the classes contain each other."""
    used: set[str] = set()
    text = "".join(_section(header, variants, used) for header, variants in _tables("", (Machine,), set()))
    for name in sorted(set(MEANINGS) - used):
        logging.getLogger(__name__).warning("docs/_ext/meanings.py explains %s, which no machine has", name)
    return text


def _tables(
    path: str, variants: tuple[type[Part], ...], seen: set[type[Part]], many: bool = False
) -> Iterator[tuple[str, tuple[type[Part], ...]]]:
    """(header, the classes that may stand there) of every table below ``path``, each class once."""
    if variants[0] in seen:
        return
    seen.update(variants)
    brackets = f"[[{path}]]" if many else f"[{path}]"
    yield (f"`{brackets}`" if path else "At the top"), variants
    for part in variants:
        for key, field in part.model_fields.items():
            inner = tuple(_parts(field.annotation))
            if inner:
                listed = any(get_origin(kind) is tuple for kind in _leaves(field.annotation, through=False))
                yield from _tables(f"{path}.{key}".lstrip("."), inner, seen, listed)


def _section(header: str, variants: tuple[type[Part], ...], used: set[str]) -> str:
    text = f"### {header}\n\n"
    if len(variants) == 1:
        text += f"{_prose(variants[0])}\n\n"
    return text + HEAD + "".join(_rows(part, len(variants) > 1, used) for part in variants) + "\n"


def _rows(part: type[Part], named: bool, used: set[str]) -> str:
    """The keys of one class; which one it is goes first."""
    text = ""
    for key, field in part.model_fields.items():
        tag = key in TAGS
        if tag and not named:
            text += f"| `{key}` | {_value(field)} | {_default(field)} | the only one so far |\n"
        elif tag:
            short = _prose(part).split("\n\n")[0]
            needed = "one of these" if key == "kind" else "one of these"
            text += f"| **`{key} = \"{field.default}\"`** | | {needed} | {short} |\n"
        else:
            text += f"| `{key}` | {_value(field)} | {_default(field)} | {_meaning(part, key, field, used)} |\n"
    return text


def _meaning(part: type[Part], key: str, field: FieldInfo, used: set[str]) -> str:
    """What the class says about its key, else the list of this folder."""
    name = f"{part.__name__}.{key}"
    used.add(name)
    if field.description is None and name not in MEANINGS:
        logging.getLogger(__name__).warning("nobody says what %s means; add it to docs/_ext/meanings.py", name)
    return field.description or MEANINGS.get(name, "")


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "required"
    value = field.get_default(call_default_factory=True)
    if value is None:
        return "none"
    if isinstance(value, Part):
        return "its defaults"
    if isinstance(value, tuple):
        return ", ".join(f"{entry:g}" for entry in value) if value else "none"
    return f'"{value}"' if isinstance(value, str) else f"{value:g}"


def _value(field: FieldInfo) -> str:
    """Unit and bound, or the words allowed, or the table that goes there."""
    parts = list(_parts(field.annotation))
    annotation = Annotated[(field.annotation, *field.metadata)] if field.metadata else field.annotation
    found = list(dict.fromkeys(_leaf(leaf) for leaf in _leaves(annotation)))
    listed = any(get_origin(kind) is tuple for kind in _leaves(field.annotation, through=False))
    if parts:
        return "tables" if listed else "table"
    text = " or ".join(entry for entry in found if entry)
    return f"list: {text}" if listed and "or a pair" not in text and "x, y" not in text else text


def _leaf(leaf: Any) -> str:
    if get_origin(leaf) is Literal:
        return " or ".join(f'`"{word}"`' for word in get_args(leaf))
    if get_origin(leaf) is Annotated:
        for extra in get_args(leaf)[1:]:
            if isinstance(extra, PlainValidator):
                return _quantity(extra.func)
        return _leaf(get_args(leaf)[0])
    return {str: "text", int: "whole number, at least 1"}.get(leaf, "")


def _quantity(read: Any) -> str:
    """Unit and bound that a validator of ``machine.part`` was made with."""
    made_with = getclosurevars(read).nonlocals
    if "single" in made_with:
        return f"{_quantity(made_with['single'])}; one, or a pair along x and y"
    unit = made_with["unit"].replace("*", " ").replace("^2", "²").replace("^3", "³") or "number"
    bound = ", > 0" if made_with["positive"] else ", ≥ 0" if made_with["non_negative"] else ""
    return f"{unit}{bound}"


def _parts(annotation: Any) -> Iterator[type[Part]]:
    for leaf in _leaves(annotation):
        bare = get_args(leaf)[0] if get_origin(leaf) is Annotated else leaf
        if isinstance(bare, type) and issubclass(bare, Part):
            yield bare


def _leaves(annotation: Any, through: bool = True) -> Iterator[Any]:
    """What an annotation is made of, without ``None``; lists are opened if ``through``."""
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is Annotated and not any(isinstance(extra, PlainValidator) for extra in arguments[1:]):
        yield from _leaves(arguments[0], through)
    elif origin in (Union, UnionType):
        for entry in arguments:
            yield from _leaves(entry, through)
    elif origin is tuple and through:
        for entry in arguments:
            yield from () if entry is Ellipsis else _leaves(entry, through)
    elif annotation is not NoneType:
        yield annotation


def _prose(part: type[Part]) -> str:
    """The docstring of a class as Markdown."""
    text = re.sub(r"``(.+?)``", r"`\1`", part.__doc__ or "")
    return "\n\n".join(" ".join(block.split()) for block in text.split("\n\n"))
