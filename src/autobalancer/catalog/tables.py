"""Reading the tables of the catalog, and the message for a name that none of them has."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from difflib import get_close_matches
from functools import cache
from importlib.resources import files
from typing import NoReturn

from autobalancer.errors import CatalogError


@cache
def rows(name: str) -> tuple[dict[str, str], ...]:
    """Rows of ``catalog/data/<name>``, column title to text."""
    text = files("autobalancer.catalog").joinpath("data", name).read_text(encoding="utf-8")
    return tuple(csv.DictReader(text.splitlines()))


def key(name: str) -> str:
    """The form in which names are compared: case and spacing do not matter."""
    return " ".join(name.lower().replace("%", " %").split())


def unknown(kind: str, given: object, names: Iterable[str], hint: str) -> NoReturn:
    """Raise the ``CatalogError`` for a name that is not there, with the names that look like it."""
    by_key = {key(name): name for name in names}
    close = [by_key[match] for match in get_close_matches(key(str(given)), by_key, n=4, cutoff=0.5)]
    similar = f"similar names: {', '.join(map(repr, close))}" if close else "no name is similar"
    raise CatalogError(f"no {kind} is called {given!r}; {similar}; {hint}")
