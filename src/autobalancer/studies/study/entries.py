"""Entries of a study file that are not quantities of a machine: one of several words, whole numbers, tables."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from autobalancer.errors import QuestionError
from autobalancer.random_numbers import GREATEST
from autobalancer.units import shortened


def one_of(key: str, given: Any, allowed: Sequence[str]) -> str:
    """One of several words."""
    if given not in allowed:
        raise QuestionError(f"{key}: given {given!r}; must be one of {', '.join(map(repr, allowed))}")
    return str(given)


def whole(key: str, given: Any, least: int) -> int:
    """A whole number."""
    if isinstance(given, bool) or not isinstance(given, int) or not least <= given <= GREATEST:
        raise QuestionError(f"{key}: given {given!r}; must be a whole number, {least} or more")
    return given


def number(key: str, given: Any, low: float, high: float) -> float:
    """A number within bounds."""
    if isinstance(given, bool) or not isinstance(given, (int, float)) or not low <= given <= high:
        raise QuestionError(f"{key}: given {given!r}; must be a number from {low:g} to {high:g}")
    return float(given)


def tables(key: str, given: Any) -> list[dict[str, Any]]:
    """Tables of an array in TOML."""
    if not isinstance(given, list) or not all(isinstance(entry, dict) for entry in given):
        raise QuestionError(f"{key}: given {shortened(given)}; must be tables, each written as [[{key}]]")
    return given
