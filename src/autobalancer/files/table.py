"""Tables in text files whose first line names the columns with their units, such as ``speed [rpm], angle [deg]``.

Comment lines start with #, columns are parted by comma, semicolon or tab; with semicolons a comma is a decimal mark.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autobalancer.errors import AutobalancerError, ResultError, UnitError
from autobalancer.files.text import TABLE, read_text
from autobalancer.units import to_si

_NAME = (
    r"[A-Za-z_][A-Za-z0-9_. &]*(?:(?<=[A-Za-z0-9_])\[\d+\][A-Za-z_. &]*)*"  # an index follows its name without a space
)
_HEAD = re.compile(rf"^\s*\"?\s*({_NAME})\s*(?:[\[(](.*)[\])])?\s*\"?\s*$")


@dataclass(frozen=True)
class Table:
    """What a table says; ``heads`` has the column and the unit, as written, of each name in lower case."""

    place: str
    heads: dict[str, tuple[int, str]]
    lines: tuple[tuple[int, tuple[str, ...]], ...]
    example: str
    error: type[AutobalancerError]

    def texts(self, name: str) -> list[str]:
        """The cells of a column.

        Raises
        ------
        AutobalancerError
            Of the kind of the table, if there is no such column.
        """
        if name not in self.heads:
            raise self._missing(repr(name))
        column = self.heads[name][0]
        return [cells[column].strip().strip('"').strip() for _, cells in self.lines]

    def numbers(self, name: str, unit: str) -> NDArray[np.float64]:
        """A column in the SI ``unit``.

        Raises
        ------
        AutobalancerError
            Of the kind of the table, if the column, its unit or a number is not there or not understood.
        """
        if name not in self.heads:
            raise self._missing(f"{name!r} with a unit")
        column, written = self.heads[name]
        if not written and unit:
            raise self._missing(f"{name!r} with a unit")
        try:
            zero = float(to_si(f"0 {written}", unit))  # not nothing where the unit is a temperature
            factor = float(to_si(f"1 {written}", unit)) - zero
        except UnitError as reason:
            raise self.error(f"{self.place}: unit of column {name!r}: {reason}") from None
        return np.array([zero + factor * self._number(number, cells[column]) for number, cells in self.lines])

    def _missing(self, what: str) -> AutobalancerError:
        return self.error(
            f"{self.place}: no column {what}; the first line must name the columns, such as: {self.example}"
        )

    def _number(self, line: int, cell: str) -> float:
        try:
            value = float(cell)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise self.error(f"{self.place}, line {line}: {cell.strip()!r} is not a number")
        return value


def read_table(path: Path, example: str, place: str = "", error: type[AutobalancerError] = ResultError) -> Table:
    """Read a table.

    Parameters
    ----------
    path
        The file.
    example
        A line of column names, for messages.
    place
        What messages begin with; by default the path.
    error
        The kind of error to raise.

    Raises
    ------
    AutobalancerError
        Of the given kind, if the file cannot be read, holds no table, or a line has too few or too many cells.
    """
    place = place or str(path)
    lines = read_text(path, TABLE, error, place).splitlines()
    body = [(n, line) for n, line in enumerate(lines, 1) if line.strip() and not line.lstrip().startswith("#")]
    if len(body) < 2:
        raise error(f"{place}: no table; the first line must name the columns, such as: {example}")
    separator = next((mark for mark in (";", "\t", ",") if mark in body[0][1]), ",")
    names = [_HEAD.match(cell) for cell in body[0][1].split(separator)]
    heads = {head[1].strip().lower(): (i, (head[2] or "").strip()) for i, head in enumerate(names) if head}
    found = []
    for number, line in body[1:]:
        cells = tuple((line.replace(",", ".") if separator == ";" else line).split(separator))
        if not "".join(cells[len(names) :]).strip():
            cells = cells[: len(names)]
        if len(cells) != len(names):
            raise error(f"{place}, line {number}: {len(cells)} cells for {len(names)} columns")
        found.append((number, cells))
    return Table(place, heads, tuple(found), example, error)
