"""Bounds of what a machine file may hold, looked at before anything is built from it.

They are far above what a machine has, and keep a slip or a hostile file from taking hours or all memory.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from autobalancer.errors import MachineFileError
from autobalancer.units import shortened

NAME = 200  # characters of a text; a description may have more
DEPTH = 20  # tables within tables
ENTRIES = 1000  # tables in a list
VALUES = 200_000  # numbers in a list, such as a recorded motion
RACES = 100  # of a machine, and balancers
BALLS = 1000  # of a machine with races
FREE_BALLS = 100_000  # of a machine with chambers


def refuse_out_of_bounds(data: dict[str, Any], source: str) -> None:
    """Refuse the content of a file that is out of bounds.

    Raises
    ------
    MachineFileError
        With the place and the bound.
    """
    for place, found in (*_lists_and_texts(data, ""), *_counts(data)):
        raise MachineFileError(f"{source}: {place}: {found}")


def _lists_and_texts(value: Any, place: str, depth: int = 0) -> Iterator[tuple[str, str]]:
    if depth > DEPTH:
        yield place[:100], f"tables and lists are nested more than {DEPTH} deep; a machine needs fewer levels"
    elif isinstance(value, dict):
        for key, entry in value.items():
            if len(key) > NAME:
                yield place or "the file", f"a key of {len(key)} characters: {shortened(key)}; no key is that long"
            yield from _lists_and_texts(entry, f"{place}.{key}" if place else key, depth + 1)
    elif isinstance(value, list):
        races = place == "balancers" or place.endswith(".races")
        tables = any(isinstance(entry, dict) for entry in value[:1])
        most = RACES if races else ENTRIES if tables else VALUES
        if len(value) > most:
            yield place, f"given a list of {len(value)} entries; at most {most} are possible"
        elif tables or any(isinstance(entry, (dict, list, str)) for entry in value):
            for number, entry in enumerate(value, 1):
                yield from _lists_and_texts(entry, f"{place}[{number}]", depth + 1)
    elif isinstance(value, str) and len(value) > NAME and not place.endswith("description"):
        yield place, f"given a text of {len(value)} characters: {shortened(value)}; at most {NAME} are possible"


def _counts(data: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """How many races and balls there are in all."""
    races = [race for balancer in _tables(data.get("balancers")) for race in _tables(balancer.get("races"))]
    if len(races) > RACES:
        yield "balancers", f"given {len(races)} races in all; at most {RACES} are possible"
    for kind, holders, most in (
        ("balancers", races, BALLS),
        ("chambers", _tables(data.get("chambers")), FREE_BALLS),
    ):
        groups = [group for holder in holders for group in _tables(holder.get("balls"))]
        counts = [group.get("count", 1) for group in groups]
        total = sum(count for count in counts if isinstance(count, int))
        if total > most:
            yield kind, f"given {shortened(total)} balls in all; at most {most} are possible"


def _tables(value: Any) -> list[dict[str, Any]]:
    entries = value if isinstance(value, list) else [value]
    return [entry for entry in entries if isinstance(entry, dict)]
