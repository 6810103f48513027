"""All numbers of an integration in one block of words, so that another run is a copy and a few other words.

A word has 64 bits: a float, or a whole number. A block begins with the plain numbers of the tuples in their order, then come the
arrays. Two arrays in one place of memory have one place in the block.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numba import types

from autobalancer.kernels.system import Floats, Integers

APART = -1  # where an array begins that has no place in a block
LINE = 8  # words: arrays begin with a line of the processor's cache


class Leaf(NamedTuple):
    """A plain number (no shape) or an array, and where it begins in a block."""

    path: str
    first: int
    shape: tuple[int, ...] | None
    dtype: Any


class Layout:
    """Where the numbers of a tuple are.

    ``kind`` is its compiled type, which says what is a float; ``apart`` are paths of arrays that have no place in a block.
    """

    def __init__(self, value: Any, kind: Any, apart: tuple[str, ...] = ()) -> None:
        found, known = list(leaves(value)), dict[tuple[int, Any], int]()
        self.apart = apart
        self.numbers = self.size = sum(not isinstance(leaf, np.ndarray) for _, leaf in found)
        self._order: list[Leaf] = []
        number = 0
        for (path, leaf), of in zip(found, _kinds(kind), strict=True):
            if not isinstance(leaf, np.ndarray):
                self._order.append(Leaf(path, number, None, np.dtype(float if isinstance(of, types.Float) else int)))
                number += 1
                continue
            where = leaf.__array_interface__["data"][0], leaf.shape
            if path in apart:
                first = APART
            elif leaf.size and where in known:
                first = known[where]
            else:
                first = self.size + (-self.size % LINE)
                self.size = first + leaf.nbytes // 8
                known[where] = first
            self._order.append(Leaf(path, first, leaf.shape, leaf.dtype))
        self._by_path = {leaf.path: leaf for leaf in self._order}
        self._form = _flat(value, [])
        plain = [leaf for leaf in self._order if leaf.shape is None]
        self._numbers = struct.Struct("".join("d" if leaf.dtype.kind == "f" else "q" for leaf in plain))

    def packed(self, value: Any) -> Integers | None:
        """The block of a tuple of the same shape; None if it has another one."""
        found: list[Any] = []
        if _flat(value, found) != self._form:
            return None
        numbers: list[Any] = []
        parts, size = [b""], self.numbers
        for own, leaf in zip(found, self._order, strict=True):
            if leaf.shape is None:
                numbers.append(own)
                continue
            if leaf.first < 0:
                continue
            if own.shape != leaf.shape or own.dtype != leaf.dtype:
                return None
            if leaf.first < size or not own.size:  # an array that was there already, or none
                continue
            parts.append(bytes(8 * (leaf.first - size)))
            parts.append(own.tobytes())
            size = leaf.first + own.nbytes // 8
        parts.append(bytes(8 * (self.size - size)))
        parts[0] = self._numbers.pack(*numbers)
        return np.frombuffer(bytearray().join(parts), np.int64)

    def viewed(self, value: Any, block: Integers, path: str = "") -> Any:
        """The tuple ``value`` with its arrays in a block; plain numbers stay, and arrays that are apart are copied."""
        if isinstance(value, tuple):
            inner = [self.viewed(entry, block, below) for below, entry in _below(value, path)]
            return type(value)(*inner) if hasattr(value, "_fields") else tuple(inner)
        if not isinstance(value, np.ndarray):
            return value
        if path in self.apart:
            return value.copy()
        leaf = self._by_path[path]
        words = value.nbytes // 8
        if words == 0:
            return value.copy()
        found = block[leaf.first : leaf.first + words].view(value.dtype).reshape(value.shape)
        return found.view(type(value))

    def words(self, path: str, value: Any, known: Integers | None = None) -> dict[int, int] | None:
        """Places and words of a tuple that stands at a path; None if it has another shape.

        Of arrays those only that differ from a ``known`` block, if there is one.
        """
        found: dict[int, int] = {}
        for below, own in leaves(value, path):
            leaf = self._by_path.get(below)
            if leaf is None or leaf.shape != (own.shape if isinstance(own, np.ndarray) else None):
                return None
            if leaf.shape is None:
                found[leaf.first] = bits(own) if leaf.dtype.kind == "f" else int(own)
                continue
            content = own.tobytes()
            if known is None:
                found.update(enumerate(np.frombuffer(content, np.int64).tolist(), leaf.first))
            elif content != (there := known[leaf.first : leaf.first + len(content) // 8]).tobytes():
                words = np.frombuffer(content, np.int64)
                other = np.flatnonzero(words != there)
                found.update(zip((other + leaf.first).tolist(), words[other].tolist(), strict=True))
        return found

    def has(self, path: str) -> bool:
        """Whether there is a number or an array at a path."""
        return path in self._by_path

    def place(self, path: str, *index: int, field: str = "") -> int:
        """The word of a number: of the array at a path its element, of a record its field."""
        leaf = self._by_path[path]
        if leaf.shape is None:
            return leaf.first
        number = int(np.ravel_multi_index(index, leaf.shape)) if index else 0
        return int(leaf.first + (number * leaf.dtype.itemsize + (leaf.dtype.fields[field][1] if field else 0)) // 8)


def bits(value: float) -> int:
    """The word of a float."""
    return int(np.float64(value).view(np.int64))


def words_of(values: Floats) -> Integers:
    """The words of floats."""
    return values.view(np.int64)


def leaves(value: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """The numbers and arrays of a tuple of tuples with their paths, in their order."""
    if not isinstance(value, tuple):
        yield path, value
        return
    for below, entry in _below(value, path):
        yield from leaves(entry, below)


def _flat(value: Any, found: list[Any]) -> list[int]:
    """Add the numbers and arrays of a tuple to ``found``; returns its form: lengths, -1 for arrays, -2 for numbers."""
    form = [len(value)]
    for entry in value:
        if isinstance(entry, tuple):
            form += _flat(entry, found)
        else:
            form.append(-1 if isinstance(entry, np.ndarray) else -2)
            found.append(entry)
    return form


def _kinds(kind: Any) -> Iterator[Any]:
    if isinstance(kind, types.BaseTuple):
        for inner in kind.types:  # type: ignore[attr-defined]
            yield from _kinds(inner)
    else:
        yield kind


def _below(value: Any, path: str) -> Iterator[tuple[str, Any]]:
    names = getattr(value, "_fields", None) or range(len(value))
    for name, entry in zip(names, value, strict=True):
        yield f"{path}.{name}" if path else str(name), entry
