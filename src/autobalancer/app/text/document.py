"""Edits of a machine file as text: its comments and its order stay where they can."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Sequence
from copy import deepcopy
from typing import Any

import tomli_w

from autobalancer.errors import KeyPath

Path = KeyPath
EMPTY = """name = "New machine"
axis = "horizontal"

[rotor]
kind = "planar"

[[unbalances]]

[[balancers]]

[[balancers.races]]

[balancers.races.fluid]

[balancers.races.drag]
law = "discoidal"

[[balancers.races.balls]]
count = 2
material = "steel"

[drive]
kind = "speed"

[drive.profile]
kind = "ramp"

[run]
duration = "10 s"
"""


def data_of(text: str) -> dict[str, Any] | None:
    """The tables of a text; ``None`` if it is not TOML."""
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError):
        return None


def value_at(data: Any, path: Path) -> Any:
    """What stands at a path; ``None`` if nothing does."""
    for step in path:
        if isinstance(step, str):
            data = data.get(step) if isinstance(data, dict) else None
        elif isinstance(data, list):
            data = data[step] if step < len(data) else None
        elif step != 0:  # one entry stands for a list of one
            return None
    return data


def with_value(text: str, path: Path, value: Any) -> str:
    """The text with another value at a path; tables on the way are made."""

    def change(owner: Any) -> None:
        owner[path[-1]] = value

    return _changed(text, path[:-1], change)


def without(text: str, path: Path) -> str:
    """The text without the key or the entry of a list at a path; a list that becomes empty goes with it."""

    def change(owner: Any) -> None:
        if isinstance(owner, dict) or isinstance(path[-1], int):
            del owner[path[-1]]

    where = path
    if isinstance(path[-1], int):
        held = value_at(data_of(text) or {}, path[:-1])
        if not isinstance(held, list) or len(held) == 1:
            where = path[:-1]
    return _changed(text, where[:-1], change if where is path else lambda owner: owner.__delitem__(where[-1]))


def with_entry(text: str, path: Path, entry: dict[str, Any]) -> str:
    """The text with one more entry at the end of a list of tables."""

    def change(owner: Any) -> None:
        held = owner.get(path[-1])
        if held is None:
            owner[path[-1]] = [entry]
        elif isinstance(held, list):
            held.append(entry)
        else:
            owner[path[-1]] = [_plain(held), entry]

    return _changed(text, path[:-1], change)


def _changed(text: str, path: Path, change: Callable[[Any], None]) -> str:
    """Change the owner at ``path``, in the text with its comments; without them where that does not give the same machine."""
    plain = deepcopy(tomllib.loads(text))
    change(_owner(plain, path))
    try:
        import tomlkit

        document: Any = tomlkit.parse(text)
        change(_owner(document, path))
        found = tomlkit.dumps(document)
        if tomllib.loads(found) == plain:
            return found
    except Exception:
        pass  # what keeps comments is a convenience; the plain way is always possible
    return tomli_w.dumps(plain)


def _owner(data: Any, path: Sequence[str | int]) -> Any:
    for step in path:
        if isinstance(step, int):
            data = data[step] if isinstance(data, list) else data
        else:
            data = data.setdefault(step, {})
    return data


def _plain(value: Any) -> Any:
    return value.unwrap() if hasattr(value, "unwrap") else value
