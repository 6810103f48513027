"""Files of measured signals, whatever their format, as columns before they are channels."""

from __future__ import annotations

import math
import mmap
import re
import tempfile
import warnings
import zipfile
import zlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from datetime import date
from functools import partial
from itertools import chain
from pathlib import Path
from threading import Lock
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from autobalancer.arrays import Floats
from autobalancer.errors import ResultError, UnitError
from autobalancer.files.samples import sample_hint
from autobalancer.files.text_files import CLOCK, NUMBER, TABLE, TABLES, WINDOWS, Table, head_of, read_table, read_text
from autobalancer.measurement.signals import factor_to, quantity_of
from autobalancer.results.signals import (
    AXES,
    BLOCK,
    LONG,
    OWN,
    UNIVERSAL,
    Function,
    Samples,
    is_universal,
    pieces,
    read_universal,
)
from autobalancer.safe_file import endless_heap, not_to_read

EXAMPLE = "time [s], x [um], y [um], tacho [V]"
OTHERS = {  # how files begin that are not read: what they are, and what to do
    b"PAR1": ("Parquet", "export it as .csv"),
    b"MDF     ": ("MDF", "export it as .csv, .mat or TDMS"),
    b"\x1f\x8b": ("compressed by gzip", "unpack it first"),
    b"BZh": ("compressed by bzip2", "unpack it first"),
    b"\xfd7zXZ": ("compressed by xz", "unpack it first"),
    b"\x93NUMPY": ("one NumPy array without names", "write .npz, with an array for each channel"),
    b"PK\x03\x04": ("a zip archive, as of Excel", "save the table as .csv"),
    b"\xd0\xcf\x11\xe0": ("an Excel workbook", "save the table as .csv"),
    b"%PDF": ("PDF", "take the numbers themselves"),
}
HDF, MARK = b"\x89HDF", b"\xef\xbb\xbf"  # how HDF5 begins, and how Notepad marks UTF-8
LONG_TABLE = 8 * LONG  # bytes of a table above which it is read by pieces
LARGEST, RATIO, HARMLESS = 1_000_000_000, 100, 100_000_000  # bytes: at most, times the file, always
TIMES = ("time", "t", "zeit", "x_value", "zeitstempel", "timestamp", "uhrzeit")
RATES = ("rate", "fs", "sampling_rate", "sample_rate")
NAMES = {8: "displacement", 11: "velocity", 12: "acceleration", 9: "force", 13: "force", 15: "pressure"}
TIME_RECORD, TIME = 1, 17  # kinds of a function and of its abscissa
DAY = 86400.0
# of MATLAB files, version 5: a matrix, its families of numbers, bytes of an item of each kind, bytes in which its tags stand
MATRIX, NUMERIC, MATRIX_HEAD = 14, range(6, 16), 4096
ITEMS = {1: 1, 2: 1, 3: 2, 4: 2, 5: 4, 6: 4, 7: 4, 9: 8, 12: 8, 13: 8}


@dataclass(frozen=True, eq=False)
class RawColumn:
    """Numbers as they stand in the file; nan where it has none. ``quantum`` is their last digit, zero if they are not rounded.

    Of a long record they are ``Samples``, which stay in the file.
    """

    values: Floats | Samples
    unit: str = ""
    quantity: str = ""
    place: str = ""
    direction: str | float = ""
    quantum: float = 0.0


@dataclass(frozen=True, eq=False)
class RawFile:
    """Columns by name over instants in s.

    Attributes
    ----------
    origin
        Name of the file, for messages.
    time
        Instants, s; ``None`` where the file has none.
    rate
        Samples in a second, where the file says it and has no instants.
    columns
        All but the time.
    quantum
        Last digit of the written instants, s; zero where they are not rounded.
    clock
        Name of the column of ``time``.
    timeless
        Why a column of time could not be used.
    remarks
        What was left out.
    """

    origin: str
    time: Floats | None
    rate: float | None
    columns: dict[str, RawColumn] = field(default_factory=dict)
    quantum: float = 0.0
    clock: str = ""
    timeless: str = ""
    remarks: tuple[str, ...] = ()


def read_raw(path: Path) -> RawFile:
    """The columns of a file, whatever its format.

    Raises
    ------
    ResultError
        If it cannot be read, or would take far more memory than its size lets expect.
    """
    if reason := not_to_read(path):
        raise ResultError(f"{path}: {reason}{sample_hint(path)}")
    with path.open("rb") as file:
        start = file.read(1024)
    suffix = path.suffix.lower()
    other = next((entry for magic, entry in OTHERS.items() if start.startswith(magic)), None)
    form = next(form for form in FORMATS if form.fits(start, suffix))
    if form.text:  # a text that begins like none of them is taken for a table, so others are told apart before
        if other is not None:
            raise ResultError(f"{path.name}: is {other[0]}, which is not read; {other[1]}. What is read: {_listing()}")
        return form.read(path)
    try:
        return form.read(path)
    except ResultError:
        raise
    except Exception as reason:  # libraries raise whatever a damaged file leads them to
        raise ResultError(f"{path.name}: cannot be read: {reason}") from None


def _refuse_bomb(path: Path, unpacked: int, largest: float = LARGEST) -> None:
    """Refuse a file that unpacks to far more than it has; ``largest`` bytes are brought into memory at once.

    Raises
    ------
    ResultError
        With both sizes.
    """
    size = path.stat().st_size
    if unpacked > largest or unpacked > max(HARMLESS, RATIO * size):
        raise ResultError(
            f"{path.name}: has {1e-6 * size:.3g} MB and unpacks to {1e-6 * unpacked:.3g} MB or more; at most "
            f"{RATIO} times the file and {1e-6 * LARGEST:.0f} MB of packed numbers are read. Save them unpacked, as .wav, "
            ".npz (np.savez) or .h5, or save fewer channels, or a shorter piece"
        )


# tables -------------------------------------------------------------------------------------------------------------------


def _table(path: Path) -> RawFile:
    """A table of a logger, a long one by pieces. Columns that hold no numbers are left out."""
    long = path.stat().st_size > LONG_TABLE
    parts = Table.pieces(path, EXAMPLE, path.name) if long else iter([read_table(path, EXAMPLE, path.name)])
    table = next(parts)
    heads = [_written(name, unit) for name, unit in zip(table.names, table.units, strict=True)]
    double = next((name for k, (name, _) in enumerate(heads) if name in [one for one, _ in heads[:k]]), None)
    if double is not None:
        raise ResultError(f"{path.name}: column {double!r} comes twice; give each a name of its own")
    at = _time_column(table, heads)
    if long and at is not None and table.kinds[at] == CLOCK:
        raise ResultError(
            f"{path.name}: times of day are read in tables up to {1e-6 * LONG_TABLE:.0f} MB; write the time in seconds, or give "
            "a shorter piece"
        )
    numeric = [k for k, kind in enumerate(table.kinds) if kind == NUMBER]
    held = dict(_columns(path, chain([table], parts), numeric)) if long else {k: table.values(k) for k in numeric}
    columns = {heads[k][0]: RawColumn(held[k], heads[k][1], quantum=_quantum(table, k)) for k in numeric}
    left = [name for k, (name, _) in enumerate(heads) if table.kinds[k] != NUMBER and k != at]
    remarks = (f"{_listed(left)}: no numbers, left out",) if left else ()
    if at is None:
        nameless = "it does not name its columns; describe 1, 2, ... as channels, one of them with the quantity time"
        words = nameless if [name for name, _ in heads] == [str(k) for k in range(1, len(heads) + 1)] else ""
        return RawFile(path.name, None, None, columns, timeless=words, remarks=remarks)
    name, unit = heads[at]
    if table.kinds[at] == CLOCK:
        return RawFile(path.name, _clock_times(table, at), None, columns, _quantum(table, at), name, remarks=remarks)
    try:
        factor = factor_to(unit, "s") if unit else 0.0
        words = f"column {name!r} has no unit; write it in the first line, such as {name} [s]" if not unit else ""
    except UnitError as reason:
        factor, words = 0.0, f"unit of column {name!r}: {reason}"
    if not factor:
        return RawFile(path.name, None, None, columns, clock=name, timeless=words, remarks=remarks)
    column = columns.pop(name)
    with np.errstate(over="ignore"):
        time = np.asarray(factor * column.values, np.float64)
    return RawFile(path.name, time, None, columns, factor * column.quantum, name, remarks=remarks)


def _columns(path: Path, tables: Iterable[Table], columns: list[int]) -> Iterator[tuple[int, Floats | Samples]]:
    """Columns of numbers of a table in pieces; those of a long record stay in a file."""
    kept = _stored_columns(
        path, (np.column_stack([table.values(k) for k in columns]) for table in tables if table.lines)
    )
    for k, held in zip(columns, kept, strict=True) if columns else ():
        yield k, held if held.size > LONG else np.asarray(held)


def _listed(names: list[str]) -> str:
    return f"column {names[0]!r}" if len(names) == 1 else "columns " + ", ".join(map(repr, names))


def _written(name: str, unit: str) -> tuple[str, str]:
    """Name and unit of ``x/mm``, ``time_s`` and the column of time of LabVIEW, too."""
    before, slash, behind = name.partition("/")
    behind = behind.strip().removeprefix("(").removesuffix(")")
    if not unit and slash and (quantity_of("", behind) or _is_time(behind)):
        return before.strip(), behind
    if not unit and (match := re.fullmatch(r"(time|t|zeit)_(s|ms|us|µs|min|h)", name, re.IGNORECASE)):
        return match[1], match[2]
    return name, "s" if name.lower() == "x_value" and not unit else unit


def _is_time(unit: str) -> bool:
    try:
        return bool(unit) and factor_to(unit, "s") > 0.0
    except UnitError:
        return False


def _time_column(table: Table, heads: list[tuple[str, str]]) -> int | None:
    """The column of time: by its name, else a clock, else the only one whose unit is one of time and that never falls."""
    named = [k for k, (name, _) in enumerate(heads) if name.lower() in TIMES and table.kinds[k] in (NUMBER, CLOCK)]
    clocks = [k for k, kind in enumerate(table.kinds) if kind == CLOCK]
    timed = [k for k, (_, unit) in enumerate(heads) if table.kinds[k] == NUMBER and _is_time(unit)]
    rising = [k for k in timed if (np.diff(table.values(k)) >= 0.0).all()]
    unsure = named or clocks or (rising if len(rising) == 1 else [])
    return next((k for k in unsure if k in clocks or heads[k][1]), unsure[0] if unsure else None)


def _clock_times(table: Table, column: int) -> Floats:
    """Seconds after the first of times of day, whose date may be given; a clock that falls by half a day passed midnight."""
    clock_times, days, before, last = np.empty(len(table.lines)), 0.0, None, ""
    for k, cell in enumerate(table.cells(column)):
        match = _STAMP.match(cell)
        if match is None:
            number = table.lines[k][0]
            raise ResultError(f"{table.place}, line {number}, column {table.names[column]!r}: {cell!r} is not a time")
        hours, minutes, seconds = int(match[2]), int(match[3]), float(match[4].replace(",", "."))
        if match[5]:
            hours = hours % 12 + 12 * (match[5].upper() == "PM")
        clock, day = 3600.0 * hours + 60.0 * minutes + seconds, match[1] or ""
        if before is not None and (day != last or not day):
            known = _days(last, day)
            days += known if known is not None else float(clock < before - 0.5 * DAY)
        clock_times[k], before, last = DAY * days + clock, clock, day
    return np.asarray(clock_times - clock_times[0], np.float64)


_STAMP = re.compile(r"^(?:([\d./-]{6,10})[T ,]+)?(\d{1,2}):(\d{2}):(\d{2}(?:[.,]\d+)?)(?: ?([AP]M))?", re.IGNORECASE)


def _days(first: str, second: str) -> int | None:
    """Days between two dates that begin with the year; ``None`` where they are written in another way."""
    try:
        return (date.fromisoformat(second.replace("/", "-")) - date.fromisoformat(first.replace("/", "-"))).days
    except ValueError:
        return None


def _quantum(table: Table, column: int) -> float:
    """The last digit of a column."""
    cells = (cell.rpartition(":")[2] for cell in table.cells(column)[1:20])
    return float(10.0 ** -min(max(map(_digits, cells), default=0), 300))


def _digits(cell: str) -> int:
    """Decimals of a written number: of 1.25e-3 five."""
    head, _, power = cell.lower().replace(",", ".").partition("e")
    digits = re.match(r"\d*", head.rpartition(".")[2] if "." in head else "")
    exponent = int(power) if re.fullmatch(r"[+-]?\d{1,4}", power) else 0
    return max(len(digits[0] if digits else "") - exponent, -300)


# universal files, arrays, sound --------------------------------------------------------------------------------------------


def _universal(path: Path) -> RawFile:
    """All time records of a universal file, which must have the same instants."""
    functions, remarks = _functions(path)
    channels = [function for function in functions if function.kind == TIME_RECORD]
    if not channels:
        others = f"; its {len(functions)} functions are none" if functions else ""
        raise ResultError(f"{path.name}: no dataset 58 with a time record{others}")
    if len(functions) > len(channels):
        remarks.append(f"{len(functions) - len(channels)} of {len(functions)} functions are no time records, left out")
    first, columns = channels[0], {}
    for channel in channels:
        if channel.axes[0].kind != TIME and not _is_time(channel.axes[0].unit):
            raise ResultError(
                f"{path.name}: a time record is over {channel.axes[0].unit or 'nothing known'}; export time"
            )
        if channel.abscissa.shape != first.abscissa.shape or any(
            not np.array_equal(a, b)
            for (_, a), (_, b) in zip(pieces(channel.abscissa), pieces(first.abscissa), strict=True)
        ):
            raise ResultError(
                f"{path.name}: {channel.words[0]} has other instants than {first.words[0]}; put them into files of their own"
            )
        try:
            name, column = _record(channel)
        except (ValueError, UnitError) as reason:
            raise ResultError(f"{path.name}: {channel.words[0]}: {reason}") from None
        while name in columns:
            name += "'"
        columns[name] = column
    unit = first.axes[0].unit
    factor = factor_to(unit, "s") if _is_time(unit) else 1.0
    return RawFile(path.name, np.asarray(factor * first.abscissa, np.float64), None, columns, remarks=tuple(remarks))


def _functions(path: Path) -> tuple[list[Function], list[str]]:
    """A universal file, of which a long one is not brought into memory as a whole."""
    if path.stat().st_size <= 8 * LONG:
        return read_universal(path.read_bytes(), path.name)
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
        return read_universal(content, path.name, path)


def _record(function: Function) -> tuple[str, RawColumn]:
    if np.iscomplexobj(function.values):
        raise ValueError("the values are not real")
    values = function.values if isinstance(function.values, Samples) else np.asarray(function.values, np.float64)
    label = function.axes[1].unit
    quantity = NAMES.get(function.axes[1].kind, "")
    si = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2", "force": "N", "pressure": "Pa"}.get(
        quantity, ""
    )
    (node, direction), own = function.response, function.words[4].split()
    if not label:
        values = (function.length if quantity in ("displacement", "velocity", "acceleration") else 1.0) * values
        label = si
    elif quantity:
        try:
            values, label = factor_to(label, si) * values, si
        except UnitError as reason:
            raise ValueError(f"unit label: {reason}") from None
    if own[:1] == [OWN] and len(own) > 1:
        way = "".join(own[2:3])
        known: str | float = way if way in ("", *AXES) else float(way)
        return function.words[0], RawColumn(values, label, own[1], node, known)
    axis = next((word for word, code in AXES.items() if code == abs(direction)), "")
    title = function.words[0] if node in ("", "0") and not axis and function.words[0] not in ("", "NONE") else ""
    name = title or "_".join(part for part in (quantity or "signal", node, axis) if part)
    return name, RawColumn((-1.0 if direction < 0 else 1.0) * values, label, quantity, node, axis)


def _arrays(path: Path) -> RawFile:
    """The arrays of a .npz or .mat file: equally long columns, and ``time`` (s) or ``rate`` (Hz)."""
    return _of_arrays(path.name, _numpy(path) if path.suffix.lower() == ".npz" else _matlab(path))


def _of_arrays(origin: str, arrays: dict[str, tuple[ArrayLike, str]], rate: float | None = None) -> RawFile:
    """Columns from arrays and their units by name."""
    plain = {
        name: (value if isinstance(value, Samples) else np.squeeze(np.asarray(value)), unit)
        for name, (value, unit) in arrays.items()
    }
    numeric = {name: both for name, both in plain.items() if both[0].dtype.kind in "fiub"}
    rate = next((float(np.asarray(v)) for n, (v, _) in numeric.items() if n.lower() in RATES and v.size == 1), rate)
    time, clock, quantum, columns = None, "", 0.0, {}
    for name, (value, unit) in numeric.items():
        short, own = head_of(name)
        if value.ndim != 1 or value.size < 2:
            continue
        if time is None and short.lower() in TIMES:
            clock, factor = short, factor_to(own or unit, "s") if own or unit else 1.0
            time = np.asarray(value, np.float64)
            time = time if factor == 1.0 else factor * time
            coarse = not isinstance(value, Samples) and value.dtype.kind == "f" and value.dtype.itemsize < 8
            quantum = factor * float(np.spacing(np.abs(value).max())) if coarse else 0.0
        else:
            held = value if isinstance(value, Samples) else np.asarray(value, np.float64)
            columns[short] = RawColumn(held, own or unit)
    sizes = {name: column.values.size for name, column in columns.items()}
    if not columns or len({*sizes.values(), *([] if time is None else [time.size])}) > 1:
        there = ", ".join(f"{name} ({size})" for name, size in sizes.items()) or "none"
        raise ResultError(f"{origin}: wanted are equally long arrays of one dimension; there are {there}")
    return RawFile(origin, time, None if time is not None else rate, columns, quantum, clock)


def _numpy(path: Path) -> dict[str, tuple[ArrayLike, str]]:
    arrays: dict[str, tuple[Any, str]] = {}
    together = 0  # bytes of the packed arrays that are brought into memory
    with zipfile.ZipFile(path) as archive:
        packed = [entry for entry in archive.infolist() if entry.compress_type != zipfile.ZIP_STORED]
        _refuse_bomb(path, sum(entry.file_size for entry in packed), math.inf)
        for entry in archive.infolist():
            with archive.open(entry) as file:  # the size that an array claims is made room for before it is read
                version = np.lib.format.read_magic(file)
                head = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
                shape, _, kind = head(file)
                before = file.tell()
            size, name = int(np.prod(shape, dtype=object)), entry.filename.removesuffix(".npy")
            if kind.kind not in "fiub":
                continue
            large = size > LONG and max(shape) == size
            together += size * kind.itemsize * (entry in packed and not large)
            _refuse_bomb(path, max(together, size * kind.itemsize), math.inf if large else LARGEST)
            if not large:
                continue
            if entry in packed:
                with archive.open(entry) as file:
                    file.read(before)
                    parts = iter(partial(file.read, BLOCK * kind.itemsize), b"")
                    arrays[name] = _stored_columns(path, (np.frombuffer(part, kind)[:, None] for part in parts))[0], ""
                continue
            with path.open("rb") as raw:  # what is not packed stands in the file as in memory
                raw.seek(entry.header_offset + 26)
                lengths = raw.read(4)
            start = entry.header_offset + 30 + sum(int.from_bytes(lengths[k : k + 2], "little") for k in (0, 2))
            arrays[name] = (_numbers(_stored(path, start + before, kind, size), size), "")
    with np.load(path, allow_pickle=False) as held:
        others = {name: held[name] for name in held.files if name not in arrays}
    return arrays | {name: (values, "") for name, values in others.items() if values.dtype.kind in "fiub"}


def _numbers(rows: Callable[[int, int], NDArray[Any]], size: int) -> Samples:
    return Samples(size, lambda first, end: np.asarray(rows(first, end).ravel(), np.float64))


def _matlab(path: Path) -> dict[str, tuple[ArrayLike, str]]:
    from scipy.io import loadmat, whosmat

    elements = list(_elements(path))
    _refuse_bomb(path, sum(size for _, size, _ in elements))
    for begin, size, order in elements:
        _refuse_damage(begin, size, order)
    shapes = {name: int(np.prod(shape, dtype=object)) for name, shape, _ in whosmat(path)}
    _refuse_bomb(path, 8 * sum(shapes.values()))
    arrays: dict[str, tuple[ArrayLike, str]] = {}
    for name, size in shapes.items():
        value = loadmat(path, variable_names=[name]).get(name)
        if size > LONG and isinstance(value, np.ndarray) and value.dtype.kind in "fiub" and max(value.shape) == size:
            value = _stored_columns(path, [value.reshape(-1, 1)])[0]
        if value is not None:
            arrays[name] = (value, "")
    return arrays


def _elements(path: Path) -> Iterator[tuple[bytes, int, Literal["little", "big"]]]:
    """The variables of a MATLAB file (version 5), unpacked: how each begins, how many bytes it has, and their order."""
    content = path.read_bytes()
    order: Literal["little", "big"] = "little" if content[126:128] == b"IM" else "big"
    at, room = 128, LARGEST
    while content[124:128] in (b"\0\1IM", b"\1\0MI") and at + 8 <= len(content):
        kind, size = (int.from_bytes(content[at + i : at + i + 4], order) for i in (0, 4))
        if kind == 15:
            begin, total, unpacker = b"", 0, zlib.decompressobj()
            for k in range(at + 8, min(at + 8 + size, len(content)), 1 << 16):
                packed = content[k : min(k + (1 << 16), at + 8 + size)]
                while packed and room >= 0:
                    piece = unpacker.decompress(packed, 1 << 20)
                    packed, room, total = unpacker.unconsumed_tail, room - len(piece), total + len(piece)
                    begin = begin or piece[:MATRIX_HEAD]
            yield begin, total, order
        else:
            yield content[at : at + MATRIX_HEAD], min(8 + size, len(content) - at), order
        at += 8 + size


def _refuse_damage(begin: bytes, size: int, order: Literal["little", "big"]) -> None:
    """Refuse a variable whose lengths do not fit each other: SciPy would read beyond its end.

    Raises
    ------
    ValueError
        If it is damaged.
    """

    def tag(at: int) -> tuple[int, int, int, int]:
        """Kind, bytes, place of the content, place of what follows; of four bytes or less all stands in the tag itself."""
        kind, length = (int.from_bytes(begin[at + i : at + i + 4], order) for i in (0, 4))
        if kind >> 16:
            return kind & 0xFFFF, kind >> 16, at + 4, at + 8
        return kind, length, at + 8, at + 8 + length + -length % 8

    kind, length, at, _ = tag(0)
    if kind != MATRIX or at + length > size:
        raise ValueError("a variable is cut short or damaged")
    _, _, flags, at = tag(at)
    family = int.from_bytes(begin[flags : flags + 4], order) & 0xFF
    if family not in NUMERIC:
        return
    _, length, dims, at = tag(at)
    count = math.prod(int.from_bytes(begin[dims + i : dims + i + 4], order) for i in range(0, min(length, 128), 4))
    _, _, _, at = tag(at)
    kind, length, data, _ = tag(at)
    if kind not in ITEMS or length != count * ITEMS[kind] or data + length > size:
        raise ValueError("the numbers of a variable are cut short or damaged")


def _sound(path: Path) -> RawFile:
    """The channels of a sound file, called 1, 2, ..., as shares of the full scale."""
    from scipy.io import wavfile

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", wavfile.WavFileWarning)  # blocks that hold no samples
        try:
            rate, held = wavfile.read(path, mmap=True)
        except ValueError:  # numbers of three bytes
            rate, held = wavfile.read(path)
    count, kind = held.shape[1] if held.ndim > 1 else 1, held.dtype
    zero, full = (128.0, 128.0) if kind == np.uint8 else (0.0, -float(np.iinfo(kind).min) if kind.kind == "i" else 1.0)

    def shares(rows: NDArray[Any]) -> Floats:
        return np.asarray((rows.astype(np.float64) - zero) / full, np.float64)

    def column(k: int) -> RawColumn:
        if len(held) <= LONG:
            return RawColumn(shares(held.reshape(-1, count)[:, k]))
        if not isinstance(held, np.memmap):
            return RawColumn(Samples(len(held), lambda first, end: shares(held[first:end].reshape(-1, count)[:, k])))
        rows = _stored(path, held.offset, kind, len(held), count)
        return RawColumn(Samples(len(held), lambda first, end: shares(rows(first, end)[:, k])))

    return RawFile(path.name, None, float(rate), {str(k + 1): column(k) for k in range(count)})


def _stored(
    path: Path, offset: int, kind: np.dtype[Any], size: int, count: int = 1
) -> Callable[[int, int], NDArray[Any]]:
    """Reads rows of ``count`` numbers of a file, from one to before another."""

    def rows(first: int, end: int) -> NDArray[Any]:
        values = np.fromfile(path, kind, (end - first) * count, offset=offset + first * count * kind.itemsize)
        if values.size < (end - first) * count:
            raise ResultError(f"{path.name}: ends before its {size} samples do")
        return values.reshape(-1, count)

    return rows


def _stored_columns(path: Path, pieces: Iterable[NDArray[Any]]) -> list[Samples]:
    """The columns of rows that come in pieces, in a file without a name that goes with them.

    Raises
    ------
    ResultError
        If the disk is full.
    """
    file, reading, count = tempfile.TemporaryFile(), Lock(), 0  # noqa: SIM115 - open for as long as it is read
    for piece in pieces:
        try:
            file.write(np.ascontiguousarray(piece).data)
        except OSError as reason:
            raise ResultError(
                f"{path.name}: its numbers do not fit into {tempfile.gettempdir()}: {reason}; make room there, or set TMPDIR to "
                "another folder"
            ) from None
        count += len(piece)
    row = np.dtype((piece.dtype, piece.shape[1:]))

    def column(k: int, first: int, end: int) -> Floats:
        column = np.empty(max(end - first, 0))
        with reading:
            file.seek(first * row.itemsize)
            for begin in range(0, column.size, BLOCK):  # rows are wider than what is asked of them
                part = column[begin : begin + BLOCK]
                part[:] = np.frombuffer(file.read(part.size * row.itemsize), row)[:, k]
        return column

    return [Samples(count, partial(column, k)) for k in range(piece.shape[1])]


# formats of the extra [signals] --------------------------------------------------------------------------------------------


def _library(name: str, path: Path, what: str) -> Any:
    from importlib import import_module

    try:
        return import_module(name)
    except ImportError:
        raise ResultError(f'{path.name}: is {what}; pip install "autobalancer[signals]" to read it') from None


def _hdf(path: Path) -> RawFile:
    """The one-dimensional datasets of an HDF5 file, as of MATLAB 7.3, called by their names in it; units from attributes."""
    h5py = _library("h5py", path, "HDF5 (MATLAB 7.3, .h5)")
    entries: dict[str, Any] = {}
    if endless := endless_heap(path):
        raise ResultError(f"{path.name}: is damaged: {endless}")
    with h5py.File(path, "r") as file:
        file.visititems(lambda name, one: entries.update({name: one}) if isinstance(one, h5py.Dataset) else None)
        wanted = {
            name: one
            for name, one in entries.items()
            if one.dtype.kind in "fiub" and one.size and max(one.shape, default=1) == one.size and name[0] != "#"
        }
        for long, most in ((False, LARGEST), (True, math.inf)):
            some = (int(one.size) * one.dtype.itemsize for one in wanted.values() if (one.size > LONG) == long)
            _refuse_bomb(path, sum(some), most)
        last = [name.rpartition("/")[2] for name in wanted]
        names = {name: short if last.count(short) == 1 else name for name, short in zip(wanted, last, strict=True)}

        def values(name: str, one: Any) -> Any:
            if one.size <= LONG:
                return one[()]
            across = one.ndim > 1 and one.shape[0] == 1  # as MATLAB writes a column

            def rows(first: int, end: int) -> NDArray[Any]:
                with h5py.File(path, "r") as file:
                    held = file[name]
                    return np.asarray(held[0, first:end] if across else held[first:end])

            return _numbers(rows, int(one.size))

        return _of_arrays(
            path.name, {names[name]: (values(name, one), _unit_of(one.attrs)) for name, one in wanted.items()}
        )


def _unit_of(attributes: Any) -> str:
    value = next((attributes[key] for key in ("units", "unit", "Unit", "Units") if key in attributes), "")
    return value.decode() if isinstance(value, bytes) else str(value)


def _tdms(path: Path) -> RawFile:
    """The channels of a TDMS file of LabVIEW."""
    tdms = _library("nptdms", path, "TDMS")

    def values(channel: Any) -> Any:
        if len(channel) <= LONG:
            return channel[:]
        group, name = channel.group_name, channel.name

        def rows(first: int, end: int) -> NDArray[Any]:
            with tdms.TdmsFile.open(path) as file:
                return np.asarray(file[group][name][first:end])

        return _numbers(rows, len(channel))

    with tdms.TdmsFile.open(path) as file:
        channels = [channel for group in file.groups() for channel in group.channels() if len(channel)]
        _refuse_bomb(path, 8 * sum(len(channel) for channel in channels if len(channel) <= LONG))
        names = [channel.name for channel in channels]
        arrays, steps = {}, set()
        for channel in channels:
            name = channel.name if names.count(channel.name) == 1 else f"{channel.group_name} {channel.name}"
            arrays[name] = (values(channel), str(channel.properties.get("unit_string", "")))
            steps.add(channel.properties.get("wf_increment"))
    step = steps.pop() if len(steps) == 1 else None
    return _of_arrays(path.name, arrays, 1.0 / float(step) if step else None)


def _labview(path: Path) -> RawFile:
    """The first segment of a text file of LabVIEW (.lvm)."""
    library = _library("lvm_read", path, "a LabVIEW measurement (.lvm)")
    try:
        result = library.read_str(read_text(path, TABLE, ResultError, path.name, WINDOWS))
        segment, several = result[0], int(result["Segments"]) > 1
        names, rows = segment["Channel names"], segment["data"]
        units = ["s", *segment.get("Y_Unit_Label", [])] if names[0] == "X_Value" else segment.get("Y_Unit_Label", [])
    except ResultError:
        raise
    except Exception as reason:  # as above
        raise ResultError(f"{path.name}: cannot be read: {reason}") from None
    short = {"Volts": "V", "Amperes": "A", "": ""}
    arrays = {
        name: (rows[:, k], short.get(unit, unit))
        for k, (name, unit) in enumerate(zip(names, [*units, *[""] * len(names)], strict=False))
        if name != "Comment"
    }
    raw = _of_arrays(path.name, arrays, 1.0 / segment["Delta_X"][0] if segment.get("Delta_X") else None)
    left = ("it has several segments; only the first is read",) if several else ()
    return RawFile(raw.origin, raw.time, raw.rate, raw.columns, raw.quantum, raw.clock, remarks=left)


# what is read -------------------------------------------------------------------------------------------------------------


class Format(NamedTuple):
    """A format of measured files: a row of :data:`FORMATS` and its reader are all that one needs."""

    name: str
    suffixes: tuple[str, ...]
    fits: Callable[[bytes, str], bool]  # by the first kilobyte of a file and its suffix
    read: Callable[[Path], RawFile]
    text: bool = False


FORMATS = (  # the first that fits reads a file; tables take all that is left
    # MATLAB 7.3 is HDF5 behind a text
    Format("HDF5", (".h5", ".hdf5"), lambda start, _: start.startswith(HDF) or HDF in start[512:520], _hdf),
    Format("TDMS", (".tdms",), lambda start, _: start.startswith(b"TDSm"), _tdms),
    Format("NumPy", (".npz",), lambda _, suffix: suffix == ".npz", _arrays),
    Format("MATLAB", (".mat",), lambda _, suffix: suffix == ".mat", _arrays),
    Format("sound", (".wav",), lambda _, suffix: suffix == ".wav", _sound),
    Format(
        "universal files", UNIVERSAL, lambda start, suffix: is_universal(start) or suffix in UNIVERSAL, _universal, True
    ),
    Format(
        "LabVIEW", (".lvm",), lambda start, _: start.lstrip(MARK).startswith(b"LabVIEW Measurement"), _labview, True
    ),
    Format("tables", TABLES, lambda *_: True, _table, True),
)
SUFFIXES = tuple(suffix for form in reversed(FORMATS) for suffix in form.suffixes)


def _listing() -> str:
    return ", ".join(f"{form.name} ({', '.join(form.suffixes)})" for form in reversed(FORMATS)) + " and results (.nc)"
