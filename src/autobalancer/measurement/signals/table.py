"""Tables of loggers: a line of column names, perhaps with units in brackets, then numbers."""

from __future__ import annotations

import io
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autobalancer.errors import ResultError, UnitError
from autobalancer.files.text import TABLE, read_text
from autobalancer.measurement.signals.raw import RawColumn, RawFile
from autobalancer.measurement.signals.unit_words import factor_to

Floats = NDArray[np.float64]
EXAMPLE = "time [s], x [um], y [um], tacho [V]"
LINES = 50  # among which the names of the columns are sought
_HEAD = re.compile(r"^\s*\"?\s*(.*?)\s*(?:[\[(](.*)[\])])?\s*\"?\s*$")
_TIMES = ("time", "t", "zeit")


def read_signal_table(path: Path) -> RawFile:
    """The columns of a table; comment lines start with #, columns are parted by semicolon, tab or comma.

    With semicolons or tabs a comma is a decimal mark. An empty cell is a missing sample. Lines above the names are left out if
    they have another number of cells. A file that is not UTF-8 is read as Windows-1252.

    Raises
    ------
    ResultError
        If there is no line of names, a cell is no number, or a line has too few or too many cells.
    """
    lines = read_text(path, TABLE, ResultError, path.name, "cp1252").splitlines()
    body = [(n, line) for n, line in enumerate(lines, 1) if line.strip() and not line.lstrip().startswith("#")]
    body = body[_head(body) :]
    if len(body) < 2:
        raise ResultError(f"{path.name}: no table; the first line must name the columns, such as: {EXAMPLE}")
    separator = next((mark for mark in (";", "\t", ",") if mark in body[0][1]), ",")
    heads = [head_of(cell) for cell in body[0][1].split(separator)]
    if all(_is_number(name) for name, _ in heads):
        raise ResultError(f"{path.name}: the first line must name the columns, such as: {EXAMPLE}; it has numbers only")
    double = {name for name, _ in heads if [one for one, _ in heads].count(name) > 1}
    if double:
        raise ResultError(f"{path.name}: column {sorted(double)[0]!r} comes twice; give each a name of its own")
    numbers = _numbers(path.name, body[1:], separator, len(heads))
    columns = {
        name: RawColumn(numbers[:, k], unit, quantum=_quantum(body, separator, k))
        for k, (name, unit) in enumerate(heads)
    }
    at = next((k for k, (name, _) in enumerate(heads) if name.lower() in _TIMES), None)
    if at is None:
        return RawFile(path.name, None, None, columns)
    name, unit = heads[at]
    if not unit:
        raise ResultError(f"{path.name}: column {name!r} has no unit; write it in the first line, such as {name} [s]")
    try:
        factor = factor_to(unit, "s")
    except UnitError as reason:
        raise ResultError(f"{path.name}: unit of column {name!r}: {reason}") from None
    quantum = factor * columns.pop(name).quantum
    return RawFile(path.name, factor * numbers[:, at], None, columns, quantum=quantum)


def _head(body: list[tuple[int, str]]) -> int:
    """Which line names the columns: the first, or below lines of a logger the one above the first line of numbers."""
    for k in range(1, min(LINES, len(body) - 1)):
        for mark in (";", "\t", ","):
            first, names, numbers = ([cell.strip() for cell in body[i][1].split(mark)] for i in (0, k, k + 1))
            named = len(names) > 1 and all(names) and not any(map(_is_number, names))
            if named and len(names) == len(numbers) != len(first) and all(map(_is_number, numbers)):
                return k
    return 0


def head_of(cell: str) -> tuple[str, str]:
    """Name and unit of ``x [um]``."""
    match = _HEAD.match(cell)
    return (match[1].strip(), (match[2] or "").strip()) if match else (cell.strip(), "")


def _is_number(text: str) -> bool:
    try:
        float(text.replace(",", "."))
    except ValueError:
        return False
    return True


def _quantum(body: list[tuple[int, str]], separator: str, at: int) -> float:
    """The last digit of a column."""
    cells = (line.split(separator)[at] for _, line in body[1:20])
    return float(10.0 ** -max(map(_digits, cells), default=0))


def _digits(cell: str) -> int:
    """Decimals of a written number: of 1.25e-3 five."""
    head, _, power = cell.strip().lower().replace(",", ".").partition("e")
    return len(head.partition(".")[2]) - (int(power) if power else 0)


def _numbers(place: str, body: list[tuple[int, str]], separator: str, count: int) -> Floats:
    decimal = separator != ","
    text = "\n".join(line.replace(",", ".") if decimal else line for _, line in body)
    try:
        found = np.loadtxt(io.StringIO(text), delimiter=separator, ndmin=2, comments=None)
        if found.shape[1] == count:
            return np.asarray(found, np.float64)
    except ValueError:
        pass
    return np.array([_row(place, number, line, separator, count) for number, line in body])


def _row(place: str, number: int, line: str, separator: str, count: int) -> list[float]:
    """A line that the quick way does not read: it has an empty cell, or a fault that must be named."""
    cells = (line.replace(",", ".") if separator != "," else line).rstrip().split(separator)
    if not "".join(cells[count:]).strip():
        cells = cells[:count]
    if len(cells) != count:
        raise ResultError(f"{place}, line {number}: {len(cells)} cells for {count} columns")
    found = []
    for cell in cells:
        try:
            found.append(float(cell) if cell.strip() else np.nan)
        except ValueError:
            raise ResultError(f"{place}, line {number}: {cell.strip()!r} is not a number") from None
    return found
