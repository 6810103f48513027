"""Text files of others, read as far as they may go, and what TOML says in them."""

from __future__ import annotations

import csv
import datetime
import io
import math
import re
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from autobalancer.arrays import Floats
from autobalancer.errors import AutobalancerError, KeyPath, Problem, QuestionError, ResultError, UnitError
from autobalancer.files.samples import sample_hint
from autobalancer.safe_file import not_to_read
from autobalancer.units import column_factor, shortened

T = TypeVar("T")
MACHINE = 10_000_000  # bytes of a machine file
TABLE = 100_000_000  # bytes of a table
TABLES = (".csv", ".txt", ".tsv", ".dat")  # how names of tables end
WINDOWS = "cp1252"  # of tables that old programs wrote
_WIDE = (b"\xff\xfe", b"\xfe\xff")  # marks of UTF-16, as Notepad and Excel ("Unicode text") write them


def read_text(path: Path, largest: int, error: type[AutobalancerError], place: str = "", otherwise: str = "") -> str:
    """The text of a file in UTF-8, with or without a mark at its beginning, or in UTF-16 with one.

    Parameters
    ----------
    path
        The file.
    largest
        Bytes that it may have; no more are read.
    error
        The kind of error to raise.
    place
        What messages begin with; by default the path.
    otherwise
        Encoding of a file that is not UTF-8; by default such a file is refused.

    Raises
    ------
    AutobalancerError
        Of the given kind, if there is no such file, it is a folder, a device or a pipe, cannot be read, is too large or no text.
    """
    place = place or str(path)
    if reason := not_to_read(path):
        raise error(f"{place}: {reason}{sample_hint(path)}")
    try:
        with path.open("rb") as file:
            content = file.read(largest + 1)
    except (OSError, ValueError) as fault:  # ValueError: no name of a file
        raise error(f"{place}: cannot be read: {fault}") from None
    if len(content) > largest:
        raise error(f"{place}: is larger than {largest // 1_000_000} MB; files of this kind are smaller")
    try:
        return decoded(content, otherwise).replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError:
        raise error(f"{place}: is no text in UTF-8; save it with this encoding") from None
    except ValueError as fault:
        raise error(f"{place}: {fault}") from None


def read_toml(path: Path, error: type[AutobalancerError] = QuestionError) -> dict[str, Any]:
    """The content of a TOML file of at most 10 MB; raises as :func:`read_text`, also if it is no TOML."""
    return parsed_toml(read_text(path, MACHINE, error), str(path), error)


def parsed_toml(text: str, place: str, error: type[AutobalancerError] = QuestionError) -> dict[str, Any]:
    """The content of a text in TOML.

    Parameters
    ----------
    text
        What was read.
    place
        What messages begin with.
    error
        The kind of error to raise.

    Raises
    ------
    AutobalancerError
        Of the given kind, if it is no text, no TOML, or holds a date.
    """
    if not isinstance(text, str):
        raise error(f"{place}: given a {type(text).__name__}; wanted is the text of a file")
    try:
        data = tomllib.loads(text)
    except (ValueError, RecursionError) as reason:  # also a number of thousands of digits
        path = " (a path of Windows needs single quotes, or / for each \\)" if "\\" in str(reason) else ""
        raise error(f"{place}: not valid TOML: {reason}{path}") from None
    for problem in _odd_values(data, ()):
        raise error.of(place, [problem])
    return data


def _odd_values(value: Any, path: tuple[str | int, ...]) -> Iterator[Problem]:
    """Values that TOML knows and no file of ours does."""
    if isinstance(value, dict):
        for key, entry in value.items():
            yield from _odd_values(entry, (*path, key))
    elif isinstance(value, list):
        for number, entry in enumerate(value):
            yield from _odd_values(entry, (*path, number))
    elif isinstance(value, (datetime.date, datetime.time)):
        yield path, f"given the date or time {value}; no key takes one, put a text in quotes"


def question_data(argument: Any, what: str, name: str) -> tuple[dict[str, Any], str, Path, str]:
    """What a file, or a dict of the same form, asks.

    Parameters
    ----------
    argument
        The path of the file, or the dict.
    what, name
        Of a dict: what messages call it, and its name.

    Returns
    -------
    dict, str, Path, str
        Its tables; what messages begin with; the folder from which files are seen; a name.

    Raises
    ------
    QuestionError
        If it is neither, or the file cannot be read.
    """
    if isinstance(argument, Mapping):
        return {str(key): value for key, value in argument.items()}, what, Path(), name
    if not isinstance(argument, (str, Path)):
        raise QuestionError(f"{what}: given {shortened(argument)}; give the path of a file, or a dict of its form")
    path = Path(argument)
    return read_toml(path), str(path), path.parent, path.stem


def built_of(build: Callable[[dict[str, Any]], T], data: dict[str, Any], source: str) -> T:
    """What is built of the keys of a file, or of a dict of its form.

    Where a key is refused, the rest is tried without it, so that one error has all that can be seen of the file.

    Raises
    ------
    QuestionError
        With the ``source`` and every key at fault.
    """
    from autobalancer.machine.schema import OF_MACHINES  # whose models would weigh on all that reads a table

    if len(OF_MACHINES & set(data)) > 1:
        raise QuestionError(
            f"{source}: is a machine file; wanted is a file with other keys ('autobalancer keys --help')"
        )
    problems: list[Problem] = []
    left_out: set[KeyPath] = set()
    while True:
        try:
            result = build(_without(data, left_out))
            if not problems:
                return result
            break
        except AutobalancerError as error:
            if not problems and not isinstance(error, (QuestionError, UnitError)):
                raise
            fresh = [(_as_given(path, left_out), text) for path, text in error.problems]
            # what may only be wrong since a key is missing now is left to the next call
            fresh = [(path, text) for path, text in fresh if not any(_follows(path, text, key) for key, _ in problems)]
            gone = {path for path, _ in fresh if _is_there(data, path)}
            if isinstance(error, (QuestionError, UnitError)):
                problems += fresh
            if not gone:
                break
            left_out |= gone
    raise QuestionError.of(source, problems, "not possible as described" if len(problems) > 1 else "")


def _without(value: Any, left_out: set[KeyPath], path: KeyPath = ()) -> Any:
    """Tables and lists without the entries at these paths."""
    if isinstance(value, dict):
        return {
            key: _without(one, left_out, (*path, key)) for key, one in value.items() if (*path, key) not in left_out
        }
    if isinstance(value, list):
        return [_without(one, left_out, (*path, i)) for i, one in enumerate(value) if (*path, i) not in left_out]
    return value


def _is_there(value: Any, path: KeyPath) -> bool:
    """Whether a path can be left out."""
    for step in path:
        entries = value if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ()
        if step not in entries:
            return False
        value = value[step]
    return bool(path)


def _as_given(path: KeyPath, left_out: set[KeyPath]) -> KeyPath:
    """A path in what was left as a path in what was given: entries of lists that were left out count again."""
    given: KeyPath = ()
    for step in path:
        if isinstance(step, int):
            for gone in sorted(key[-1] for key in left_out if key[:-1] == given and isinstance(key[-1], int)):
                step += gone <= step
        given = (*given, step)
    return given


def _follows(path: KeyPath, text: str, key: KeyPath) -> bool:
    """Whether a problem may be one only because a key was left out: it is at the key, around it or in it, or names it."""
    near = path[: len(key)] == key or key[: len(path)] == path
    named = [step for step in key[-1:] if isinstance(step, str)]
    return near or any(re.search(rf"\b{re.escape(step)}\b", text) for step in named)


def decoded(content: bytes, otherwise: str = "") -> str:
    """The text of bytes in UTF-8, in UTF-16 with its mark, or in another encoding; raises as :func:`encoding_of`."""
    encoding = encoding_of(content, otherwise)
    return content.decode(encoding, "replace" if encoding == otherwise else "strict")


def encoding_of(content: bytes, otherwise: str = "") -> str:
    """The encoding of bytes: UTF-8, UTF-16 with its mark, or the other one.

    Raises
    ------
    ValueError
        If it is no text.
    """
    if content[:2] in _WIDE:
        return "utf-16"
    if b"\0" in content:
        raise ValueError("is no text")
    try:
        content.decode("utf-8-sig")
    except UnicodeDecodeError:
        if not otherwise:
            raise
        return otherwise
    return "utf-8-sig"


# Tables in text files with a line of column names and their units, such as ``speed [rpm], angle [deg]``.
#
# Units may also stand in a line below the names, and lines of a logger above them. Comment lines start with #. Columns
# are parted by semicolon, tab, comma or blanks. Where a comma does not part columns it is a decimal mark; where commas
# and dots both stand in numbers, a column is read only if its own numbers say which is which: 1,500 beside 2.5 is
# refused.


LINES = 50  # among which the names of the columns are sought
PIECE = 1 << 22  # characters of a long table at once
SAMPLE = 20  # rows that say what a column holds
NUMBER, CLOCK, TEXT = "number", "clock", "text"  # what a column holds
_NAME = (
    r"[A-Za-z_][A-Za-z0-9_. &]*(?:(?<=[A-Za-z0-9_])\[\d+\][A-Za-z_. &]*)*"  # an index follows its name without a space
)
_HEADS = (
    re.compile(rf"^({_NAME})\s*(?:[\[(](.*)[\])])?$"),
    re.compile(r"^(.*?)\s*\[([^\[\]]*)\]$"),
    re.compile(r"^(.*?)\s*\((.*)\)$"),
)
_BLANKS = re.compile(r"\S+(?:\s*[\[(][^\])]*[\])])?")  # a name with its unit, where blanks part the columns
_POWER = r"(?:[eEdD][+-]?\d+)?"
_PLAIN = re.compile(rf"^[+-]?(?:\d+([.,]?)\d*|([.,])\d+){_POWER}$")
_GROUPED = re.compile(r"^[+-]?[1-9]\d{0,2}(?:([.,' ’\u00a0\u202f])\d{3})(?:\1\d{3})*(?:(?!\1)([.,])\d*)?$")
_NO_NUMBER = {"nan", "+nan", "-nan", "inf", "+inf", "-inf"}
_GROUPS = str.maketrans("", "", "' ’\u00a0\u202f")
_CLOCK = re.compile(r"^(?:[\d./-]{6,10}[T ,]+)?\d{1,2}:\d{2}:\d{2}(?:[.,]\d+)?(?: ?[AP]M)?(?:Z|[+-]\d{2}:?\d{2})?$")
_UNITS = (
    "s sec sek ms us µs μs min h m mm um µm μm mil V mV g N kN Hz rpm 1/min m/s mm/s m/s² m/s2 m/s^2 ° deg Pa bar °C A"
)


@dataclass(frozen=True)
class Table:
    """What a table says: names and units of its columns, as written, and its lines below with their numbers in the file."""

    place: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    lines: tuple[tuple[int, str], ...]
    separator: str | None
    example: str
    error: type[AutobalancerError]

    @staticmethod
    def pieces(path: Path, example: str, place: str) -> Iterator[Table]:
        """A table of any size in pieces; what its columns hold is decided by the first one.

        Raises
        ------
        ResultError
            As :func:`read_table` raises; also if pieces have different decimal marks, so that a number could be two.
        """
        known, marks, first = None, dict[int, str](), 1
        try:
            with path.open("rb") as binary:
                encoding = encoding_of(b"".join(binary.readlines(1 << 16)), WINDOWS)
            with path.open(encoding=encoding) as file:
                while lines := file.readlines(PIECE):
                    body = _body(lines, first)
                    known = replace(known, lines=_checked(body, known)) if known else _table(body, example, place)
                    for column, mark in known._own_marks().items() if known.lines else ():
                        if marks.setdefault(column, mark) != mark:
                            raise ResultError(
                                f"{place}, from line {first}: numbers have other decimal marks than above; write one decimal "
                                "mark everywhere and no separators"
                            )
                    first += len(lines)
                    yield known
        except UnicodeDecodeError:
            raise ResultError(f"{place}: is no text in {encoding}; save it as UTF-8") from None
        except (OSError, ValueError) as fault:
            raise ResultError(f"{place}: {fault}") from None

    @cached_property
    def heads(self) -> dict[str, tuple[int, str]]:
        """Column and unit of each name in lower case."""
        return {name.lower(): (k, self.units[k]) for k, name in enumerate(self.names)}

    def texts(self, name: str) -> list[str]:
        """The cells of a column.

        Raises
        ------
        AutobalancerError
            Of the kind of the table, if there is no such column.
        """
        return self.cells(self._column(name, repr(name)))

    def numbers(self, name: str, unit: str) -> Floats:
        """A column in the SI ``unit``; what is called an amplitude may be a value from peak to peak, or rms.

        Raises
        ------
        AutobalancerError
            Of the kind of the table, if the column, its unit or a number is not there or not understood.
        """
        column = self._column(name, f"{name!r} with a unit")
        written = self.units[column]
        if not written and unit:
            raise self._missing(f"{name!r} with a unit")
        try:
            factor, zero = column_factor(written, unit, amplitude=name.startswith("amplitude"))
        except UnitError as reason:
            raise self.error(f"{self.place}: unit of column {name!r}: {reason}") from None
        values = self.values(column)
        for k in np.flatnonzero(~np.isfinite(values))[:1]:
            raise self._odd(column, int(k), "is not a number")
        with np.errstate(over="ignore"):
            return np.asarray(zero + factor * values, np.float64)

    def _column(self, name: str, words: str) -> int:
        if name not in self.heads:
            raise self._missing(words)
        if sum(one.lower() == name for one in self.names) > 1:
            raise self.error(f"{self.place}: column {name!r} comes twice; give each a name of its own")
        return self.heads[name][0]

    def _missing(self, what: str) -> AutobalancerError:
        return self.error(
            f"{self.place}: no column {what}; the first line must name the columns, such as: {self.example}"
        )

    def _odd(self, column: int, row: int, words: str) -> AutobalancerError:
        number, line = self.lines[row]
        cell = split(line, self.separator)[column]
        return self.error(f"{self.place}, line {number}, column {self.names[column]!r}: {cell[:40]!r} {words}")

    def cells(self, column: int) -> list[str]:
        """The cells of a column."""
        return [split(line, self.separator)[column] for _, line in self.lines]

    @cached_property
    def kinds(self) -> tuple[str, ...]:
        """What each column holds, by its first cells: numbers, clock times (perhaps with a date) or texts."""
        rows = [split(line, self.separator) for _, line in self.lines[:SAMPLE]]
        kinds = []
        for column in range(len(self.names)):
            cells = [row[column] for row in rows if row[column]]
            clock = cells and all(map(is_clock, cells))
            kinds.append(CLOCK if clock else NUMBER if not cells or any(map(is_number, cells)) else TEXT)
        return tuple(kinds)

    def values(self, column: int) -> Floats:
        """The numbers of a column; nan where a cell is empty.

        Raises
        ------
        AutobalancerError
            Of the kind of the table, if a cell is no number, or may be two different ones.
        """
        if column in self._quick:
            return self._quick[column]
        cells = self.cells(column)
        decimal = self._decimals.get(column, "." if self.separator == "," else ",")
        result = np.empty(len(cells))
        for k, cell in enumerate(cells):
            if cell and not is_number(cell):
                raise self._odd(column, k, "is not a number")
            result[k] = _number(cell, decimal) if cell else math.nan
        return result

    @cached_property
    def _quick(self) -> dict[int, Floats]:
        """The columns of numbers, where one look at the text says what its marks are, and no cell is empty."""
        text = "\n".join(line for _, line in self.lines)
        if '"' in text or (self.separator != "," and "," in text and ("." in text or re.search(r",\d*,", text))):
            return {}
        wanted = [k for k, kind in enumerate(self.kinds) if kind == NUMBER]
        if self.separator != ",":
            text = text.replace(",", ".")
        try:
            rows = np.loadtxt(io.StringIO(text), delimiter=self.separator, ndmin=2, comments=None, usecols=wanted)
        except ValueError:
            return {}
        return {k: np.ascontiguousarray(rows[:, i], np.float64) for i, k in enumerate(wanted)}

    def _own_marks(self) -> dict[int, str]:
        """The decimal mark of each column of numbers that has one."""
        there = "." if self.separator == "," else ",."
        quick = next((mark for mark in there if any(mark in line for _, line in self.lines)), "")
        return {k: quick for k in self._quick if quick} if self._quick else self._decimals

    @cached_property
    def _decimals(self) -> dict[int, str]:
        """The decimal mark of each column of numbers.

        A number such as 0,5 or 1.234,5 or 1,234,567 says itself which mark is which; 1,500 says it only together with others.
        """
        sure: dict[int, str] = {}
        doubtful: dict[
            int, dict[str, int]
        ] = {}  # rows of first numbers with a mark that may part decimals or thousands
        for column in (k for k, kind in enumerate(self.kinds) if kind == NUMBER):
            for row, cell in enumerate(self.cells(column)):
                mark, certain = _decimal(cell)
                if mark and not certain:
                    doubtful.setdefault(column, {}).setdefault(mark, row)
                elif mark and sure.setdefault(column, mark) != mark:
                    raise self._odd(column, row, f"has another decimal mark than numbers above, {sure[column]!r}")
        there = {*sure.values(), *(mark for marks in doubtful.values() for mark in marks)}
        for column, marks in doubtful.items():
            mark, row = next(iter(marks.items()))
            if column not in sure and there != {mark}:
                raise self._odd(
                    column,
                    row,
                    "may have a decimal mark or a separator of thousands, as comma and dot both stand in this table; write "
                    "one decimal mark everywhere and no separators",
                )
            sure.setdefault(column, mark)
        return sure


def is_number(cell: str) -> bool:
    """Whether a cell is a number, whatever its marks."""
    return bool(_PLAIN.match(cell) or _GROUPED.match(cell)) or cell.lower() in _NO_NUMBER


def is_clock(cell: str) -> bool:
    """Whether a cell is a time of day, perhaps with a date."""
    return _CLOCK.match(cell) is not None


def _decimal(cell: str) -> tuple[str, bool]:
    """The decimal mark of a number, empty if it has no mark at all, and whether that is certain."""
    grouped = _GROUPED.match(cell)
    if grouped is None:
        plain = _PLAIN.match(cell)
        return (plain[1] or plain[2] or "", True) if plain else ("", True)
    group, mark = grouped[1], grouped[2]
    if group not in ".,":
        return mark or "", True
    if mark or cell.count(group) > 1:
        return mark or ",.".replace(group, ""), True
    return group, False


def _number(cell: str, decimal: str) -> float:
    other = "." if decimal == "," else ","
    plain = cell.translate(_GROUPS).replace(other, "").replace(decimal, ".")
    return float(re.sub("[dD]", "e", plain) if plain.lower() not in _NO_NUMBER else plain)


def split(line: str, separator: str | None) -> list[str]:
    """The cells of a line, without quotes and blanks around them; without a separator blanks part them."""
    if separator is None:
        return line.split()
    cells = next(csv.reader([line], delimiter=separator)) if '"' in line else line.split(separator)
    return [cell.strip().strip('"').strip() for cell in cells]


def head_of(cell: str) -> tuple[str, str]:
    """Name and unit of ``x [um]``."""
    cell = cell.strip().strip('"').strip()
    match = next((match for head in _HEADS if (match := head.match(cell))), None)
    return (match[1].rstrip(" /"), (match[2] or "").strip()) if match else (cell, "")


def read_table(path: Path, example: str, place: str = "", error: type[AutobalancerError] = ResultError) -> Table:
    """Read a table; a file that is neither UTF-8 nor UTF-16 is read as Windows-1252.

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
    text = read_text(path, TABLE, error, place, WINDOWS)
    return _table(_body(text.split("\n"), 1), example, place, error)


def _body(lines: list[str], first: int) -> list[tuple[int, str]]:
    """The lines that say something, and their numbers."""
    own = ((n, line.rstrip("\n")) for n, line in enumerate(lines, first))
    return [(n, line) for n, line in own if line.strip() and not line.lstrip().startswith("#")]


def _table(
    body: list[tuple[int, str]], example: str, place: str, error: type[AutobalancerError] = ResultError
) -> Table:
    if len(body) < 2:
        raise error(f"{place}: no table; the first line must name the columns, such as: {example}")
    separator, heads, first = _layout([line for _, line in body[: LINES + 3]])
    names, units = (tuple(head[k] for head in heads) for k in (0, 1))
    empty = Table(place, names, units, (), separator, example, error)
    return replace(empty, lines=_checked(body[first:], empty))


def _checked(body: list[tuple[int, str]], table: Table) -> tuple[tuple[int, str], ...]:
    """The lines, if they have as many cells as the table has columns."""
    count, separator = len(table.names), table.separator
    for number, line in body:
        if separator is not None and '"' not in line and line.count(separator) == count - 1:
            continue
        cells = split(line, separator)
        if len(cells) < count or any(cells[count:]):  # empty cells behind the last one do not count
            hint = "; where commas are decimal marks, part the columns by semicolons" if separator == "," else ""
            raise table.error(f"{table.place}, line {number}: {len(cells)} cells for {count} columns{hint}")
    return tuple(body)


def _layout(lines: list[str]) -> tuple[str | None, list[tuple[str, str]], int]:
    """What parts the columns, their names and units, and the first line of numbers."""
    for mark in (";", "\t", ",", None):
        rows = [split(line, mark) for line in lines]
        data = [_is_data(row, whole=mark is None) for row in rows]
        for k, row in enumerate(rows[: LINES + 1]):
            if not all(data[k : k + 3]) or any(not _as_long(row, other) for other in rows[k : k + 3]):
                continue
            if k == 0:
                return mark, _unnamed(row), 0
            if any(_is_data(rows[j], whole=True) and _as_long(row, rows[j]) for j in range(k)):
                break  # what stands between lines of numbers is no line of names
            if mark is None:
                rows = [_BLANKS.findall(line) if i < k else rows[i] for i, line in enumerate(lines)]
            if _is_head(rows[k - 1]) and _as_long(rows[k - 1], row):
                return mark, _heads(rows, k), k
    mark = next((mark for mark in (";", "\t", ",") if mark in lines[0]), ",")
    rows = [split(line, mark) for line in lines]
    return (mark, _unnamed(rows[0]), 0) if all(map(is_number, rows[0])) else (mark, _heads(rows, 1), 1)


def _unnamed(row: Sequence[str]) -> list[tuple[str, str]]:
    return [(str(k), "") for k in range(1, len(row) + 1)]


def _is_data(row: Sequence[str], whole: bool) -> bool:
    """Whether at least half of the cells, or all, are numbers or times."""
    filled = [cell for cell in row if cell]
    numbers = sum(is_number(cell) or is_clock(cell) for cell in filled)
    return len(row) > 1 and numbers > 0 and (numbers == len(filled) if whole else 2 * numbers >= len(filled))


def _is_head(row: Sequence[str]) -> bool:
    return any(row) and not any(is_number(cell) or is_clock(cell) for cell in row)


def _as_long(row: Sequence[str], other: Sequence[str]) -> bool:
    """Whether two lines have as many cells, but for empty ones at their ends."""
    short, long = sorted((row, other), key=len)
    return not any(long[len(short) :])


def _heads(rows: list[list[str]], first: int) -> list[tuple[str, str]]:
    """Names and units above the first line of numbers; the units may stand in a line of their own."""
    block = rows[max(first - 3, 0) : first]
    while len(block) > 1 and not all(_is_head(row) and _as_long(row, rows[first]) for row in block):
        block = block[1:]
    at = next((k for k in (len(block) - 1, len(block) - 2) if k > 0 and _are_units(block[k])), None)
    names = [head_of(cell) for cell in block[-1 if at is None else at - 1]]
    below = [] if at is None else [cell.strip("[]()") for cell in block[at]]
    below += [""] * (len(names) - len(below))
    while len(names) > 1 and names[-1] == ("", ""):
        names.pop()
    return [(name or f"column {k}", unit or below[k - 1]) for k, (name, unit) in enumerate(names, 1)]


def _are_units(row: Sequence[str]) -> bool:
    filled = [cell for cell in row if cell]
    bracketed = all(re.fullmatch(r"\[.*\]|\(.*\)", cell) for cell in filled)
    return bracketed or (any(cell in _UNITS.split() for cell in filled) and all(len(cell) <= 12 for cell in filled))
