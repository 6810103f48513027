"""Answers of measured signals: channels, orders, spectra."""

from __future__ import annotations

import mmap
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from xarray.backends import BackendArray
from xarray.core.indexing import ExplicitIndexer, IndexingSupport, LazilyIndexedArray, explicit_indexing_adapter

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError, ResultError
from autobalancer.results.answers.answer import Answer, Form, Shown, sure
from autobalancer.results.display_units import AxisUnit, axis_unit, length_axis, speed_axis, vibration_axis
from autobalancer.tables import Column

# Measured signals show their channels, not their samples; long ones stay in their files and are read piece by piece.


BLOCK = 1 << 20  # samples of a channel that are in memory at once
LONG = 1 << 22  # samples above which a record stays in its file
NEAR = 1 << 12  # samples between two that are read at once


class Samples:
    """Numbers over the time that are read or computed when they are asked for; ``piece(first, end)`` gives them, in SI."""

    ndim, dtype = 1, np.dtype(np.float64)
    __array_ufunc__ = None  # so that a number times this is one, too

    def __init__(self, size: int, piece: Callable[[int, int], Floats]) -> None:
        self.size, self.shape, self.piece = size, (size,), piece

    def __getitem__(self, part: slice) -> Samples:
        first, end, step = part.indices(self.size)
        if step != 1:
            raise ValueError("samples are cut, not thinned")
        return Samples(max(0, end - first), lambda a, b: self.piece(first + a, first + b))

    def __rmul__(self, factor: float) -> Samples:
        return Samples(self.size, lambda a, b: factor * self.piece(a, b))

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        return np.asarray(self.piece(0, self.size), dtype)

    def variable(self) -> LazilyIndexedArray:
        """As what xarray holds without loading it."""
        return LazilyIndexedArray(_Pieces(self))


class _Pieces(BackendArray):
    """Samples by the indices of xarray."""

    def __init__(self, samples: Samples) -> None:
        self.samples, self.shape, self.dtype = samples, samples.shape, samples.dtype

    def __getitem__(self, key: ExplicitIndexer) -> Any:
        return explicit_indexing_adapter(key, self.shape, IndexingSupport.OUTER, self._taken)

    def _taken(self, key: tuple[Any, ...]) -> Any:
        (at,) = key
        if isinstance(at, slice) and at.step in (None, 1):
            first, end, _ = at.indices(self.samples.size)
            return self.samples.piece(first, max(first, end))
        index = np.arange(self.samples.size)[at] if isinstance(at, slice) else np.atleast_1d(at)
        order = np.argsort(index, kind="stable")
        result = np.empty(index.size)
        ahead = index[order]
        far = (np.diff(ahead) > NEAR) | (np.diff(ahead // BLOCK) > 0)
        for group in np.split(order, np.flatnonzero(far) + 1) if index.size else []:
            first = int(index[group[0]])
            result[group] = self.samples.piece(first, int(index[group[-1]]) + 1)[index[group] - first]
        return result if isinstance(at, (slice, np.ndarray)) else result[0]


def pieces(values: Any, overlap: int = 0) -> Iterator[tuple[int, Floats]]:
    """An array, samples or a channel in pieces of at most a block: where each begins, and its numbers.

    ``overlap`` numbers of the next piece stand at the end of each, as far as there are any.
    """
    for first in range(0, values.shape[0], BLOCK):
        yield first, np.asarray(values[first : first + BLOCK + overlap], np.float64)


def extremes(values: Any) -> tuple[float, float]:
    """Least and greatest of an array, samples or a channel."""
    ends = [(float(part.min()), float(part.max())) for _, part in pieces(values)]
    return min(low for low, _ in ends), max(high for _, high in ends)


def places(values: Any, wanted: Floats) -> NDArray[np.int64]:
    """How many of ascending numbers, such as the rotor angle at all samples, are below each of those that are wanted."""
    return np.asarray(sum(np.searchsorted(part, wanted) for _, part in pieces(values)), np.int64)


def merged_windows(starts: NDArray[np.int64], ends: NDArray[np.int64]) -> Iterator[slice]:
    """Neighboring windows that overlap or touch and have at most a block of samples in all."""
    first = 0
    for k in range(1, starts.size + 1):
        if k == starts.size or starts[k] > ends[k - 1] or ends[k] - starts[first] > BLOCK:
            yield slice(first, k)
            first = k


def at_samples(values: xr.DataArray, index: Floats) -> Floats:
    """A channel between samples, on a straight line; index (point,) counts samples from zero."""
    below = np.clip(np.floor(index).astype(np.int64), 0, values.shape[0] - 2)
    low, high = (np.asarray(values[below + k].values, np.float64) for k in (0, 1))
    return np.asarray(low + (high - low) * np.clip(index - below, 0.0, 1.0), np.float64)


class Signals(Answer):
    """One row for each channel: what it is, where, and how large."""

    __slots__ = ()
    shown_as = Form(
        there=lambda it: (
            "sampling_rate" in it.attrs
            and "time" in it.coords
            and all(entry.dims == ("time",) for entry in it.data_vars.values())
        ),
        most=60,
    )

    @classmethod
    def given(cls, signals: xr.Dataset, owner: str) -> Signals:
        """The argument of a function with this name, if they are such.

        Raises
        ------
        QuestionError
            If they are something else.
        """
        if not isinstance(signals, cls):
            raise QuestionError(f"{owner}: give measured signals, from ab.measure.load_signals or ab.measure.signals")
        return signals

    def facts(self) -> list[tuple[str, str]]:
        """Length, rate, and where they come from."""
        time = self["time"].values
        step = 1.0 / float(self.attrs["sampling_rate"])
        length = f"{time[0]:.6g} s to {time[-1]:.6g} s, {time.size} samples, one each {1e3 * step:.5g} ms"
        origin = str(self.attrs.get("origin", ""))
        return [("time", length), ("sampling rate", f"{1.0 / step:.6g} Hz"), *([("from", origin)] if origin else [])]

    def columns(self, unit: str = "") -> list[Column]:
        """Quantity, place with direction, mean, least, greatest and standard deviation."""
        shown = [_shown(entry, unit or "rpm") for entry in self.data_vars.values()]
        attrs = [entry.attrs for entry in self.data_vars.values()]
        return [
            Column("channel", [str(name) for name in self.data_vars]),
            Column("quantity", [str(a.get("quantity", "")) for a in attrs]),
            Column("place", [_place(a) for a in attrs]),
            Column("unit", [row[0] for row in shown]),
            *(
                Column(head, [row[1][k] for row in shown], form=".4g")
                for k, head in enumerate(("mean", "least", "greatest", "deviation"))
            ),
        ]


def _shown(entry: xr.DataArray, speed: str) -> tuple[str, list[float]]:
    low, high = extremes(entry)
    size = max(abs(low), abs(high))
    unit = length_axis(None, size or 1.0) if entry.attrs.get("units") == "m" else axis_unit(entry, speed)
    rows = [(part.size, part.mean(), part.var()) for part in (unit.shown(part) for _, part in pieces(entry))]
    count, mean, variance = np.array(rows, np.float64).T
    middle = float(np.average(mean, weights=count))
    spread = float(np.sqrt(np.average(variance + (mean - middle) ** 2, weights=count)))
    return unit.sign, [middle, *(float(unit.shown(np.array(end))) for end in (low, high)), spread]


def _place(attrs: dict[str, Any]) -> str:
    """Station and direction."""
    direction = attrs.get("direction", "")
    text = direction if isinstance(direction, str) else f"{float(direction):g}°"
    return f"{attrs.get('place', '')} {text}".strip()


# Orders of measured signals show the greatest amplitude of each, and where it is.


class Orders(Answer):
    """One row for each order of each channel."""

    __slots__ = ()
    shown_as = Form(
        row_of="order",
        needed=("amplitude", "phase", "amplitude_deviation", "phase_deviation"),
        most=60,
    )

    def facts(self) -> list[tuple[str, str]]:
        """Where they come from, speeds, and how they were found."""
        time, speed = self["time"].values, self["speed"].values
        rpm = 30.0 / np.pi
        rows = [
            ("time", f"{time[0]:.5g} s to {time[-1]:.5g} s, {time.size} points"),
            ("speed", f"{speed.min() * rpm:.5g} to {speed.max() * rpm:.5g} rpm"),
            ("method", str(self.attrs.get("method", ""))),
        ]
        if self.attrs.get("runout"):
            rows.append(("runout", str(self.attrs["runout"])))
        return rows

    def columns(self, unit: str = "") -> list[Column]:
        """Greatest amplitude with its deviation, phase and speed there."""
        shown = speed_axis(unit or "rpm")
        pairs = [(c, o) for c in range(self.sizes["channel"]) for o in range(self.sizes["order"])]
        peaks = [int(np.argmax(self["amplitude"].values[o, c])) for c, o in pairs]
        units = [self.amplitude_unit(c) for c, _ in pairs]

        def picked(name: str) -> list[float]:
            return [float(self[name].values[o, c, k]) for (c, o), k in zip(pairs, peaks, strict=True)]

        def scaled(name: str) -> list[float]:
            return [u.factor * value for u, value in zip(units, picked(name), strict=True)]

        return [
            Column("channel", [str(self["channel"].values[c]) for c, _ in pairs]),
            Column("order", [float(self["order"].values[o]) for _, o in pairs], form="g"),
            Column("peak", scaled("amplitude"), form=".5g"),
            Column("+-", scaled("amplitude_deviation"), form=".2g"),
            *([Column("bias", scaled("bias"), form=".2g")] if "bias" in self else []),
            Column("unit", [u.sign for u in units]),
            Column("at", [float(self["speed"].values[k]) * shown.factor for k in peaks], shown.sign, ".5g"),
            Column("phase there", np.rad2deg(picked("phase")), "deg", ".1f"),
            Column("+-", np.rad2deg(picked("phase_deviation")), "deg", ".2g"),
        ]

    def amplitude_unit(self, channel: int) -> AxisUnit:
        """In which unit amplitudes of a channel are shown."""
        greatest = float(np.nanmax(self["amplitude"].values[:, channel]))
        return vibration_axis(str(self["units"].values[channel]), greatest)

    def complex_amplitude(self, channel: str, order: float = 1.0) -> np.ndarray:
        """The amplitude times e^(i phase), SI; (time,)."""
        one = self.sel(channel=channel, order=order)
        return np.asarray(one["amplitude"].values * np.exp(1j * one["phase"].values))


# Spectra of measured signals show their lines with their names.


class Spectrum(Answer):
    """One row for each line that stands out of the noise."""

    __slots__ = ()
    shown_as = Form(
        row_of="line",
        needed=("line_frequency", "line_amplitude", "line_name", "line_channel"),
        shown_in="Hz",
        most=40,
    )

    def facts(self) -> list[tuple[str, str]]:
        """How it was made."""
        a = self.attrs
        rows = [
            ("window", f"{a['window']}, mean of {a['averages']} segment{'s' * bool(a['averages'] > 1)}"),
            ("resolution", f"{a['resolution']:.4g} Hz, noise bandwidth {a['noise_bandwidth']:.4g} Hz"),
        ]
        if np.isfinite(a.get("speed", np.nan)):
            rows.append(("speed", f"{a['speed'] * 30.0 / np.pi:.5g} rpm"))
        else:
            rows.append(("speed", "not known or not steady, so lines have no order"))
        return rows

    def columns(self, unit: str = "") -> list[Column]:
        """Channel, frequency, amplitude and name of each line."""
        units = [self.amplitude_unit(str(name)) for name in self["line_channel"].values]
        factors = np.array([unit.factor for unit in units])
        name = "line_amplitude_deviation"  # not in files of earlier versions
        deviation = [Column("+-", factors * self[name].values, form=".2g")] if name in self else []
        return [
            *self.shown(unit, Shown("line_channel", "channel"), Shown("line_frequency", "frequency")),
            *(self.shown(unit, sure("line_frequency")) if "line_frequency_deviation" in self else []),
            Column("amplitude", factors * self["line_amplitude"].values, form=".4g"),
            *deviation,
            Column("unit", [u.sign for u in units]),
            *self.shown(unit, Shown("line_name", "what it is")),
        ]

    def amplitude_unit(self, channel: str) -> AxisUnit:
        """In which unit amplitudes of a channel are shown."""
        unit = str(self["units"].sel(channel=channel).values)
        greatest = float(np.nanmax(self["amplitude"].sel(channel=channel).values))
        return vibration_axis(unit, greatest)


# Universal files: functions in dataset 58 (ASCII) and 58b (binary), with units of dataset 164; signals are written in
# 58.
#
# Format after the description of the Structural Dynamics Research Laboratory, University of Cincinnati. Programs write
# it in their own ways: the mark that closes binary numbers may follow these at once, one mark may stand between two
# datasets where two belong, texts may be in UTF-8. All of that is read, and functions are counted against their marks.
#
# In files of this package the name of a channel is the first line of its record; in the fifth stand its quantity and
# direction, which the format has no place for where they are a tacho or an angle.


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
    functions: list[Function] = []
    for kind, binary, start, end in _datasets(content):
        try:
            if kind == "164":
                parts = content[start:end].decode("latin-1").replace("D", "E").split("\n")[1].split()
                length, force = (1.0 / float(part) for part in parts[:2])
            elif kind == "58":
                functions.append(_function(content, (start, end), binary, (length, force), path))
        except (ValueError, IndexError, ArithmeticError) as reason:
            place = f"dataset {kind}{'b' if binary else ''}" + f" of function {len(functions) + 1}" * (kind == "58")
            raise ResultError(f"{name}, {place}: {reason}") from None
    there = 0
    for at in range(0, len(content), 8 * BLOCK):
        part = content[at : at + 8 * BLOCK + 64]
        there += sum(match.start() < 8 * BLOCK for match in _STARTS.finditer(part))
        if isinstance(content, mmap.mmap) and hasattr(content, "madvise"):
            content.madvise(mmap.MADV_DONTNEED)
    lost = (
        f"{len(functions)} of {there} functions (datasets 58) could be read; lengths or marks of the others are wrong"
    )
    return functions, [lost] if there > len(functions) else []


class UniversalMode(NamedTuple):
    """One mode of a data set 55, scaled as in the file."""

    frequency: float  # rad/s
    damping_ratio: float
    mass: float
    nodes: list[str]
    motions: NDArray[np.float64]  # (nodes, 3 or 6), along and about x, y, z


class UniversalModes(NamedTuple):
    """Modes of a universal file, where its nodes are, and the SI values of its units of length and mass, where it says them."""

    modes: list[UniversalMode]
    nodes: dict[str, tuple[float, ...]]
    units: tuple[float, float] | None


def read_universal_modes(content: bytes, name: str) -> UniversalModes:
    """All modes of a universal file, normal or complex (data sets 55), with its nodes (15, 2411) and units (164).

    Raises
    ------
    ResultError
        If one is damaged, has no modal mass, or its nodes do not move in phase.
    """
    found = UniversalModes([], {}, None)
    for kind, _, start, end in _datasets(content):
        lines = content[start:end].decode("latin-1").replace("D", "E").splitlines()
        try:
            if kind == "164":
                length, force = (1.0 / float(part) for part in lines[1].split()[:2])
                found = found._replace(units=(length, force / length))
            elif kind == "15":
                found.nodes.update((line.split()[0], tuple(map(float, line.split()[4:7]))) for line in lines)
            elif kind == "2411":
                pairs = zip(lines[::2], lines[1::2], strict=True)
                found.nodes.update((head.split()[0], tuple(map(float, place.split()))) for head, place in pairs)
            elif kind == "55" and int(lines[5][10:20]) in (NORMAL, *COMPLEX):
                found.modes.append(_mode(lines))
        except (ValueError, IndexError, ArithmeticError) as reason:
            place = f"data set {kind}" + f" of mode {len(found.modes) + 1}" * (kind == "55")
            raise ResultError(f"{name}, {place}: {reason}") from None
    return found


NORMAL, COMPLEX = 2, (3, 7)  # kinds of analysis
IN_PHASE = 0.1  # share of a shape that may be a quarter of a period apart from it


def _mode(lines: list[str]) -> UniversalMode:
    """A mode; of a complex one modal A is 2 i w m of the shape as it stands there."""
    analysis, form, each = (int(lines[5][i : i + 10]) for i in (10, 40, 50))
    wide = each * (2 if form == 5 else 1)
    numbers = _fields(lines[7])
    taken = -(-wide // 6)  # lines of a node
    rows = np.array(
        [_fields("".join(lines[i + 1 : i + 1 + taken]))[:wide] for i in range(8, len(lines) - taken, 1 + taken)]
    )
    motions = rows[:, ::2] + 1j * rows[:, 1::2] if form == 5 else rows.astype(np.complex128)
    if analysis == NORMAL:
        frequency, mass, ratio = 2.0 * np.pi * numbers[0], complex(numbers[1]), numbers[2] or 0.5 * numbers[3]
    else:
        pole = complex(*numbers[:2])
        frequency, ratio, mass = abs(pole), -pole.real / abs(pole), complex(*numbers[2:4]) / (2j * pole.imag)
    turn = np.exp(-0.5j * np.angle((motions**2).sum()))
    motions, mass = motions * turn, mass * turn**2
    if np.abs(motions.imag).max() > IN_PHASE * np.abs(motions).max():
        raise ValueError(
            "its nodes do not move in phase, so it is no mode that is damped by itself; give real normal modes"
        )
    if not mass.real > 0.0:
        raise ValueError(f"its modal mass is {mass.real:g}; export scaled modes")
    nodes = [line.strip() for line in lines[8 :: 1 + taken]][: len(rows)]
    return UniversalMode(frequency, float(ratio), float(mass.real), nodes, motions.real)


def _fields(line: str) -> list[float]:
    """Numbers that are 13 letters wide."""
    return [float(line[i : i + 13]) for i in range(0, len(line.rstrip()), 13)]


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
    values: list[float] = []
    try:
        for line in text.splitlines():
            at, rest = 0, line.rstrip()
            while at < len(rest):
                wide = widths[len(values) % len(widths)]
                values.append(float(rest[at : at + wide]))
                at += wide
    except ValueError:
        values = []
    if len(values) != count * each:
        try:
            values = [float(part) for part in text.split()]
        except ValueError as reason:
            raise ValueError(f"{str(reason).rpartition(': ')[2]} is not a number") from None
    if len(values) != count * each:
        raise ValueError(f"{len(values)} numbers where {count * each} are announced")
    return np.array(values, np.float64).reshape(count, each)


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
