"""The paths of a machine that somebody may have meant by a name that is none."""

from __future__ import annotations

from collections.abc import Iterator
from difflib import get_close_matches
from typing import Any

from autobalancer.machine.part import Part

MOST = 4  # paths in one message


def did_you_mean(machine: Part, path: str) -> str:
    """The end of a message: ``"; did you mean 'drive.profile.speed'?"``; empty where nothing is near."""
    key = path.rpartition(".")[2].partition("[")[0]
    paths = list(_paths(machine, ""))
    keys = {place.rpartition(".")[2].partition("[")[0] for place in paths}
    inside = sorted(other for other in keys if len(key) > 2 and (f"_{key}" in other or f"{key}_" in other))
    near = [key] if key in keys else [*inside, *get_close_matches(key, keys - set(inside), n=2, cutoff=0.8)]
    found = [place for one in near for place in paths if place.rpartition(".")[2].partition("[")[0] == one]
    if not found:
        return ""
    more = f" (and {len(found) - MOST} more)" if len(found) > MOST else ""
    return f"; did you mean {' or '.join(map(repr, found[:MOST]))}{more}?"


def _paths(owner: Any, start: str) -> Iterator[str]:
    """Paths of all entries, entries counted from 1; of lists of numbers the whole list."""
    if isinstance(owner, Part):
        for key in type(owner).model_fields:
            path = f"{start}.{key}" if start else key
            yield path
            yield from _paths(getattr(owner, key), path)
    elif isinstance(owner, tuple):
        for number, entry in enumerate(owner, start=1):
            if isinstance(entry, Part):
                yield f"{start}[{number}]"
                yield from _paths(entry, f"{start}[{number}]")
