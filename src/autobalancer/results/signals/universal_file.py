"""Universal files: functions in dataset 58 (ASCII) and 58b (binary), with units of dataset 164; signals are written in 58.

Format after the description of the Structural Dynamics Research Laboratory, University of Cincinnati. Programs write it in their
own ways: the mark that closes binary numbers may follow these at once, one mark may stand between two datasets where two
belong, texts may be in UTF-8. All of that is read, and functions are counted against their marks.

In files of this package the name of a channel is the first line of its record; in the fifth stand its quantity and direction,
which the format has no place for where they are a tacho or an angle.
"""

from __future__ import annotations

import mmap
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.errors import ResultError
from autobalancer.results.signals.signals import BLOCK, LONG, Samples

KINDS = {"displacement": 8, "velocity": 11, "acceleration": 12, "force": 9, "pressure": 15}
AXES = {"x": 1, "y": 2, "z": 3}
OWN = "autobalancer"  # first word of the fifth line
IN_LINE, LONGEST = 4, 10  # numbers in a line; letters of a place
UNIVERSAL = (".uff", ".unv")  # how names of such files end
HEADS = 11  # lines of a function before its numbers
_MARK = re.compile(rb"^ {0,4}-1 *\r?(?:\n|\Z)", re.MULTILINE)
_CLOSE = re.compile(rb"[\r\n]* {4}-1 *\r?(?:\n|\Z)")  # after binary numbers, which end wherever they end
_HEAD = re.compile(rb" *(\d{1,5})(b?)([^\n]*)\n")
_STARTS = re.compile(rb" {0,4}-1 *\r?\n {4}58[b \r\n]")
_BEGIN = re.compile(rb"(?:\xef\xbb\xbf)?\s*-1 *\r?\n *\d+b?\s")


@dataclass(frozen=True)
class Axis:
    """What the numbers of one axis are: the code of the format and the label of their unit, empty where there is none."""

    kind: int
    unit: str


@dataclass(frozen=True, eq=False)
class Function:
    """One function as it stands in the file; ``length`` and ``force`` are the SI values of the units of dataset 164."""

    kind: int
    words: tuple[str, ...]
    response: tuple[str, int]  # node, direction
    reference: tuple[str, int]
    abscissa: NDArray[np.float64] | Samples
    values: NDArray[np.float64] | NDArray[np.complex128] | Samples
    axes: tuple[Axis, Axis, Axis]  # abscissa, numerator, denominator
    length: float
    force: float


def is_universal(start: bytes) -> bool:
    """Whether a file begins as universal files do."""
    return _BEGIN.match(start) is not None


def read_universal(content: bytes | mmap.mmap, name: str, path: Path | None = None) -> tuple[list[Function], list[str]]:
    """All functions of a universal file, and what is to be said of those that could not be found.

    Where its path is given, the binary real numbers of long functions stay in it.

    Raises
    ------
    ResultError
        If one is damaged or in a format of numbers that is not IEEE.
    """
    length = force = 1.0
    found: list[Function] = []
    for kind, binary, start, end in _datasets(content):
        try:
            if kind == "164":
                parts = content[start:end].decode("latin-1").replace("D", "E").split("\n")[1].split()
                length, force = (1.0 / float(part) for part in parts[:2])
            elif kind == "58":
                found.append(_function(content, (start, end), binary, (length, force), path))
        except (ValueError, IndexError, ArithmeticError) as reason:
            place = f"dataset {kind}{'b' if binary else ''}" + f" of function {len(found) + 1}" * (kind == "58")
            raise ResultError(f"{name}, {place}: {reason}") from None
    there = 0
    for at in range(0, len(content), 8 * BLOCK):
        part = content[at : at + 8 * BLOCK + 64]
        there += sum(match.start() < 8 * BLOCK for match in _STARTS.finditer(part))
        if isinstance(content, mmap.mmap) and hasattr(content, "madvise"):
            content.madvise(mmap.MADV_DONTNEED)
    lost = f"{len(found)} of {there} functions (datasets 58) could be read; lengths or marks of the others are wrong"
    return found, [lost] if there > len(found) else []


def _datasets(content: bytes | mmap.mmap) -> Iterator[tuple[str, list[str], int, int]]:
    """Number, words that only binary ones have, and of each dataset the places of its first line and behind its last."""
    mark = _MARK.search(content)
    while mark is not None:
        head = _HEAD.match(content, mark.end())
        if head is None:  # a mark that only closes
            mark = _MARK.search(content, mark.end())
            continue
        words = head[3].decode("latin-1").split() if head[2] else []
        start = head.end()
        if words:
            for _ in range(HEADS):
                start = content.find(b"\n", start) + 1 or len(content)
            announced = int(words[3]) if len(words) > 3 and words[3].isdigit() else 0
            mark = _CLOSE.match(content, start + announced) or _CLOSE.search(content, start)
        else:
            mark = _MARK.search(content, start)
        yield head[1].decode(), words, head.end(), mark.start() if mark is not None else len(content)


def _function(
    content: bytes | mmap.mmap, place: tuple[int, int], binary: list[str], units: tuple[float, float], path: Path | None
) -> Function:
    begin, end = at, _ = place
    for _ in range(HEADS):
        at = content.find(b"\n", at, end) + 1 or end + 1
    lines = content[begin:at].split(b"\n")
    if at > end or (binary and len(binary) < 4):
        raise ValueError(f"its head is not whole, {HEADS} lines and of binary numbers their form and length")
    words = [_text(line).rstrip().ljust(80) for line in lines[:HEADS]]
    about, shape = words[5], words[6]
    form, count, even = (int(shape[i : i + 10]) for i in (0, 10, 20))
    if form not in (2, 4, 5, 6):
        raise ValueError(f"ordinate data type {form}; must be 2, 4, 5 or 6, real or complex numbers")
    start, step = (float(shape[i : i + 13]) for i in (30, 43))
    steps = Samples(count, lambda first, last: np.asarray(start + step * np.arange(first, last), np.float64))
    abscissa: NDArray[np.float64] | Samples
    values: NDArray[np.float64] | NDArray[np.complex128] | Samples
    if binary and form < 5 and count > LONG and path is not None:
        numbers = _binary((at, end), binary, count, form, even == 1)
        columns = [Samples(count, column) for column in _columns(path, at, numbers)]
        abscissa, values = (steps if even == 1 else columns[0]), columns[-1]
    else:
        rows = _numbers(content, (at, end), binary, count, form, even == 1)
        parts = rows if even == 1 else rows[:, 1:]
        abscissa = np.asarray(steps if even == 1 else rows[:, 0], np.float64)
        values = parts[:, 0] if form < 5 else parts[:, 0] + 1j * parts[:, 1]
    return Function(
        kind=int(about[:5]),
        words=tuple(line.strip() for line in words[:5]),
        response=(about[41:51].strip(), int(about[51:55].strip() or 0)),
        reference=(about[66:76].strip(), int(about[76:80].strip() or 0)),
        abscissa=abscissa,
        values=values,
        axes=(_axis(lines[7]), _axis(lines[8]), _axis(lines[9])),
        length=units[0],
        force=units[1],
    )


def _columns(path: Path, offset: int, row: np.dtype) -> list[Callable[[int, int], NDArray[np.float64]]]:
    """Readers of the columns of binary numbers."""

    def column(name: str) -> Callable[[int, int], NDArray[np.float64]]:
        def read(first: int, end: int) -> NDArray[np.float64]:
            rows = np.fromfile(path, row, end - first, offset=offset + first * row.itemsize)
            return np.asarray(rows[name], np.float64)

        return read

    return [column(name) for name in row.names or ()]


def _text(line: bytes) -> str:
    try:
        return line.decode("utf-8")
    except UnicodeDecodeError:
        return line.decode("latin-1")


def _axis(line: bytes) -> Axis:
    """Columns are counted in letters, by some programs in bytes: then the gap before the unit is not where it should be."""
    text = _text(line.rstrip()).ljust(80)
    label = text[47:67] if text[46] == " " else _text(line[47:67])
    label = label.strip()
    return Axis(int(text[:10]), "" if label.upper() == "NONE" else label)


def _numbers(
    content: bytes | mmap.mmap, place: tuple[int, int], binary: list[str], count: int, form: int, even: bool
) -> NDArray[np.float64]:
    """Rows of abscissa (where uneven) and one or two parts of each value."""
    if not binary:
        return _written(content[place[0] : place[1]], count, (1 if form < 5 else 2) + (not even), form in (2, 5), even)
    row = _binary(place, binary, count, form, even)
    rows = np.frombuffer(content, row, count, place[0])
    return np.stack([rows[name].astype(np.float64) for name in row.names or ()], axis=1)


def _binary(place: tuple[int, int], binary: list[str], count: int, form: int, even: bool) -> np.dtype:
    """How a row of binary numbers stands in the file."""
    each, single = (1 if form < 5 else 2) + (not even), form in (2, 5)
    if binary[1] != "2":
        raise ValueError("the numbers are not in IEEE format; export them so, or as ASCII (dataset 58)")
    order = "<" if binary[0] == "1" else ">"
    kinds = [order + ("f4" if single else "f8")] * each
    if not single and not even and int(binary[3]) == count * (8 * each - 4):
        kinds[0] = order + "f4"  # the abscissa alone is single
    row = np.dtype([(f"part{k}", kind) for k, kind in enumerate(kinds)])
    if place[1] - place[0] < count * row.itemsize:
        raise ValueError(f"the file ends before its {count} values do")
    return row


def _written(block: bytes, count: int, each: int, single: bool, even: bool) -> NDArray[np.float64]:
    """Fields of fixed width: 13, 20, or 13 and 20 in turn where double values are uneven; else parted by blanks."""
    widths = [13] if single else [20] if even else [13, *[20] * (each - 1)]
    text = block.decode("latin-1").replace("D", "E").replace("d", "E")
    found: list[float] = []
    try:
        for line in text.splitlines():
            at, rest = 0, line.rstrip()
            while at < len(rest):
                wide = widths[len(found) % len(widths)]
                found.append(float(rest[at : at + wide]))
                at += wide
    except ValueError:
        found = []
    if len(found) != count * each:
        found = [float(part) for part in text.split()]
    if len(found) != count * each:
        raise ValueError(f"{len(found)} numbers where {count * each} are announced")
    return np.array(found, np.float64).reshape(count, each)


def universal_text(signals: xr.Dataset) -> str:
    """All channels of signals.

    Raises
    ------
    ResultError
        If these are no signals, the name of a place is longer than the format allows, or the sampling interval needs more than
        its six digits.
    """
    if "sampling_rate" not in signals.attrs:
        raise ResultError("universal files hold signals; write other results as .nc, .csv or .json")
    time = np.asarray(signals["time"].values, np.float64)
    return "".join(
        _record(str(name), entry, time) for name, entry in signals.data_vars.items() if entry.dims == ("time",)
    )


def _record(name: str, entry: xr.DataArray, time: np.ndarray) -> str:
    place, unit = str(entry.attrs.get("place", "")), str(entry.attrs.get("units", ""))
    direction, quantity = str(entry.attrs.get("direction", "")), str(entry.attrs.get("quantity", ""))
    if len(place) > LONGEST:
        raise ResultError(f"{name}: place {place!r} has more than {LONGEST} letters, the most of a universal file")
    step = (time[-1] - time[0]) / (time.size - 1)
    if abs(float(f"{step:.5e}") - step) * time.size > 0.5 * step:
        raise ResultError(
            f"{name}: the interval {step:.9g} s has more than the six digits of a universal file; write .nc or .csv"
        )
    about = f"{'NONE':<20} {'NONE':<20}"
    lines = [
        "    -1",
        "    58",
        name[:80],
        *["NONE"] * 3,
        f"{OWN} {quantity} {direction}"[:80],
        f"{1:5d}{0:10d}{0:5d}{0:10d} {'NONE':<10}{place:>10}{AXES.get(direction, 0):4d} {'NONE':<10}{0:10d}{0:4d}",
        f"{4:10d}{time.size:10d}{1:10d}{time[0]:13.5e}{step:13.5e}{0.0:13.5e}",
        f"{17:10d}{0:5d}{0:5d}{0:5d} {'Time':<20} {'s':<20}",
        f"{KINDS.get(quantity, 0):10d}{0:5d}{0:5d}{0:5d} {quantity[:20]:<20} {unit:<20}",
        *[f"{0:10d}{0:5d}{0:5d}{0:5d} {about}"] * 2,
    ]
    values = np.asarray(entry.values, np.float64)
    lines += ["".join(f"{value:20.12e}" for value in values[i : i + IN_LINE]) for i in range(0, values.size, IN_LINE)]
    return "\n".join([*lines, "    -1", ""])
