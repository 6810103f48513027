"""Time records in universal files: dataset 58 in ASCII and 58b in binary, with units of 164.

Formats after the description of the Structural Dynamics Research Laboratory, University of Cincinnati.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from autobalancer.errors import ResultError, UnitError
from autobalancer.measurement.signals.raw import RawColumn, RawFile
from autobalancer.measurement.signals.unit_words import factor_to
from autobalancer.results.signals.universal_file import OWN

Floats = NDArray[np.float64]
TIME_RECORD, TIME = 1, 17  # function type; kind of abscissa
KINDS = {
    8: ("displacement", "m"),
    11: ("velocity", "m/s"),
    12: ("acceleration", "m/s^2"),
    9: ("force", "N"),
    13: ("force", "N"),
}
KINDS |= {15: ("pressure", "Pa")}
AXES = {1: "x", 2: "y", 3: "z"}
HEADS = 11  # lines of a dataset before its numbers
_MARK = re.compile(rb"^ {4}-1 *\r?$", re.MULTILINE)


class _Record(NamedTuple):
    name: str
    start: float
    step: float
    column: RawColumn


def is_universal(path: Path) -> bool:
    """Whether a file begins as universal files do."""
    with path.open("rb") as file:
        return _MARK.match(file.read(32).lstrip(b"\r\n").split(b"\n")[0]) is not None


def read_universal_signals(path: Path) -> RawFile:
    """All time records of a universal file, which must have the same instants.

    Raises
    ------
    ResultError
        If there is none, they differ in their instants, or a dataset is damaged or in a number format that is not IEEE.
    """
    length = 1.0
    found: list[_Record] = []
    for head, body in _datasets(path.read_bytes()):
        if head[0] == "164":
            numbers = [float(part.replace("D", "E")) for part in body.decode("latin-1").split("\n")[1].split()]
            length = 1.0 / numbers[0]
        elif head[0] in ("58", "58b"):
            try:
                one = _record(head, body, length)
            except (ValueError, IndexError) as reason:
                raise ResultError(f"{path.name}, dataset {head[0]}, function {len(found) + 1}: {reason}") from None
            found += [one] if one is not None else []
    if not found:
        raise ResultError(f"{path.name}: no dataset 58 with a time record")
    first, columns = found[0], {}
    for one in found:
        same = (one.start, one.step, one.column.values.size) == (first.start, first.step, first.column.values.size)
        if not same:
            raise ResultError(
                f"{path.name}: {one.name} has other instants than {first.name}; put them into files of their own"
            )
        name = one.name
        while name in columns:
            name += "'"
        columns[name] = one.column
    time = np.asarray(first.start + first.step * np.arange(first.column.values.size), np.float64)
    return RawFile(path.name, time, None, columns)


def _datasets(content: bytes) -> Iterator[tuple[list[str], bytes]]:
    """First words and the rest of each dataset; binary numbers are skipped by their announced length."""
    at = 0
    while (mark := _MARK.search(content, at)) is not None:
        start = mark.end() + 1
        end = content.find(b"\n", start)
        head = content[start:end].decode("latin-1").split()
        at = end + 1
        if not head:
            return
        if head[0] == "58b":
            lines = int(head[3])
            for _ in range(lines):
                at = content.find(b"\n", at) + 1
            at += int(head[4])
        close = _MARK.search(content, at)
        stop = close.start() if close is not None else len(content)
        yield head, content[end + 1 : stop]
        at = close.end() if close is not None else len(content)


def _record(head: list[str], body: bytes, length: float) -> _Record | None:
    lines = body.split(b"\n", HEADS)
    words = [line.decode("latin-1").rstrip("\r").ljust(80) for line in lines[:HEADS]]
    if int(words[5][:5]) != TIME_RECORD:
        return None
    form, count, even = (int(words[6][i : i + 10]) for i in (0, 10, 20))
    start, step = (float(words[6][i : i + 13]) for i in (30, 43))
    if int(words[7][:10]) != TIME or even != 1:
        raise ValueError("the instants are not evenly spaced; export them so")
    if form not in (2, 4):
        raise ValueError("the values are not real")
    values = _binary(head, lines[HEADS], count, form) if head[0] == "58b" else _written(lines[HEADS], count, form)
    quantity, si = KINDS.get(int(words[8][:10]), ("", ""))
    label = words[8][47:67].strip()
    node, direction = words[5][41:51].strip(), int(words[5][51:55] or 0)
    if not label or label.upper() == "NONE":
        factor = length if quantity in ("displacement", "velocity", "acceleration") else 1.0
        values, label = factor * values, si
    elif quantity:
        try:
            values, label = factor_to(label, si) * values, si
        except UnitError as reason:
            raise ValueError(f"unit label: {reason}") from None
    sign = -1.0 if direction < 0 else 1.0
    axis = AXES.get(abs(direction), "")
    own = words[4].split()
    if own[:1] == [OWN] and len(own) > 1:
        way = "".join(own[2:3])
        known: str | float = way if way in ("", *AXES.values()) else float(way)
        return _Record(words[0].strip(), start, step, RawColumn(values, label, own[1], node, known))
    name = "_".join(part for part in (quantity or "signal", node, axis) if part)
    return _Record(name, start, step, RawColumn(sign * values, label, quantity, node, axis))


def _binary(head: list[str], block: bytes, count: int, form: int) -> Floats:
    if int(head[2]) != 2:
        raise ValueError("the numbers are not in IEEE format; export them so, or as ASCII (dataset 58)")
    kind = ("<" if int(head[1]) == 1 else ">") + ("f4" if form == 2 else "f8")
    if len(block) < count * np.dtype(kind).itemsize:
        raise ValueError(f"the file ends before its {count} values do")
    return np.frombuffer(block, kind, count).astype(np.float64)


def _written(block: bytes, count: int, form: int) -> Floats:
    width = 13 if form == 2 else 20
    lines = block.decode("latin-1").replace("D", "E").splitlines()
    cells = [line[i : i + width] for line in lines for i in range(0, len(line.rstrip()), width)]
    values = np.array([float(cell) for cell in cells])
    if values.size != count:
        raise ValueError(f"{values.size} numbers where {count} are announced")
    return values
