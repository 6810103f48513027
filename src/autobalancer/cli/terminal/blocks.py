"""Blocks of options that several commands share: a parameter of a command that is a dataclass of options."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, is_dataclass
from functools import wraps
from inspect import Parameter, Signature, signature
from typing import Any, get_type_hints


def in_blocks(command: Callable[..., None]) -> Callable[..., None]:
    """A command that the command line sees with the fields of each block in the place of the block."""
    hints, blocks, seen = get_type_hints(command, include_extras=True), dict[str, Any](), list[Parameter]()
    for one in signature(command).parameters.values():
        kind = hints[one.name]
        if not is_dataclass(kind):
            seen.append(one.replace(annotation=kind, kind=Parameter.KEYWORD_ONLY))
            continue
        blocks[one.name], options = kind, get_type_hints(kind, include_extras=True)
        seen += [
            Parameter(field.name, Parameter.KEYWORD_ONLY, default=field.default, annotation=options[field.name])
            for field in fields(kind)
        ]

    @wraps(command)
    def called(**given: Any) -> None:
        made = {
            name: kind(**{field.name: given.pop(field.name) for field in fields(kind)}) for name, kind in blocks.items()
        }
        command(**given, **made)

    called.__annotations__ = {one.name: one.annotation for one in seen}
    called.__signature__ = Signature(seen)  # type: ignore[attr-defined]
    return called
