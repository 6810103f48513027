"""Measured signals from files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.errors import QuestionError, RangeWarning, UnitError, warn
from autobalancer.measurement.signals.checks import doubts, refuse_implausible, refuse_missing
from autobalancer.measurement.signals.described import Described, DescribedChannel, described_channels
from autobalancer.measurement.signals.form import UNITS, Channel, signals
from autobalancer.measurement.signals.formats import RawColumn, RawFile, read_raw
from autobalancer.measurement.signals.timebase import even, grid_of, instants, rate_remarks, resampled, uneven_text
from autobalancer.measurement.signals.unit_words import factor_to, hertz_argument, is_tacho, quantity_of
from autobalancer.results.signals.signals import Samples, Signals
from autobalancer.results.store import load_run
from autobalancer.safe_file import as_path
from autobalancer.units import optional_argument, to_si

Floats = NDArray[np.float64]
TIME = "time"  # the quantity of a column with the instants


def load_signals(
    path: str | Path,
    channels: Described | str | Path | None = None,
    *,
    rate: float | str | None = None,
    resample: float | str | None = None,
    start: float | str | None = None,
    end: float | str | None = None,
    implausible: bool = False,
) -> xr.Dataset:
    """Read measured signals from a file.

    Parameters
    ----------
    path
        A table (``.csv``, ``.txt``, ...) with a line that names the columns, best with their units, ``time [s], x [um],
        tacho [V]``, or with these in the line below; a universal file with time records (datasets 58 and 58b); arrays of equal
        length with ``time`` (s) or ``rate`` (Hz) in ``.npz`` or ``.mat``; a sound file (``.wav``), whose channels are called
        1, 2, ... and need a ``full_scale``; a file that :func:`~autobalancer.save_run` wrote (``.nc``); with the extra
        ``autobalancer[signals]`` HDF5 (``.h5``, MATLAB 7.3), TDMS and LabVIEW (``.lvm``).
    channels
        What the channels are: a TOML file with a table ``channels``, or the same as a dict,
        ``{"x": {"column": "ai0", "quantity": "displacement", "unit": "um", "place": "bearing A", "direction": "x"}}``, with
        ``sensitivity`` (``"10.2 mV/(m/s^2)"``) where the numbers are voltages. A column with the quantity ``time`` has the
        instants, whatever it is called. By default ``NAME.channels.toml`` beside the file, if there is one, else every column
        with a unit.
    rate
        Samples in a second (Hz), where the file has no column of time, or one that is too coarse: the rate counts.
    resample
        Even rate (Hz) to which unevenly spaced samples are brought by a spline of degree five.
    start, end
        Piece of the file to use, s.
    implausible
        Take vibrations that are so large that their unit is probably wrong.

    Returns
    -------
    xarray.Dataset
        As :func:`~autobalancer.measure.signals` makes it; ``attrs["warnings"]`` says what is doubtful, with its time.

    Raises
    ------
    ResultError
        If the file cannot be read; the message says where and what is expected.
    QuestionError
        If samples are missing, unevenly spaced, not numbers or impossibly large, or a channel is not described well enough.
    """
    path = as_path(path)
    if path.suffix.lower() == ".nc":
        return _own(load_run(path), path)
    raw, described = _timed(read_raw(path), described_channels(channels, path))
    wanted = None if resample is None else hertz_argument("resample", resample)
    known = None if rate is None else hertz_argument("rate", rate)
    t = instants(raw, known)
    used = _piece(t, optional_argument("start", start, "s"), optional_argument("end", end, "s"), raw.origin)
    found, left = _channels(raw, described, used, t, implausible)
    remarks = [*raw.remarks, *rate_remarks(raw, t, known), *left]
    return _signals(raw if known is None else replace(raw, time=None), t[used], found, wanted, remarks)


def _timed(raw: RawFile, described: dict[str, DescribedChannel]) -> tuple[RawFile, dict[str, DescribedChannel]]:
    """The file with the column as its time that was described as such, and the channels that remain."""
    clocks = {name: words for name, words in described.items() if words.quantity == TIME}
    if not clocks:
        return raw, described
    if len(clocks) > 1:
        raise QuestionError(f"{raw.origin}: channels {' and '.join(clocks)}: only one can be the time")
    (name, words), *_ = clocks.items()
    rest = {key: one for key, one in described.items() if key != name}
    if raw.time is not None and (words.column or name) == raw.clock:
        return raw, rest
    column = _column(raw, name, words)
    try:
        factor = factor_to(words.unit or column.unit, "s")
    except UnitError as reason:
        raise QuestionError(f"{raw.origin}: channel {name!r}: {reason}") from None
    others = {key: one for key, one in raw.columns.items() if one is not column}
    return replace(
        raw, time=np.asarray(factor * column.values), rate=None, columns=others, quantum=factor * column.quantum
    ), rest


def _column(raw: RawFile, name: str, words: DescribedChannel) -> RawColumn:
    column = raw.columns.get(words.column or name)
    if column is None:
        there = ", ".join(raw.columns)
        raise QuestionError(f"{raw.origin}: channel {name!r}: no column {words.column or name!r}; there are {there}")
    return column


def _own(found: xr.Dataset, path: Path) -> Signals:
    if not isinstance(found, Signals):
        raise QuestionError(f"{path}: holds no measured signals; ab.measure.signals and load_signals make them")
    return found


def _piece(t: Floats, start: float | None, end: float | None, origin: str) -> slice:
    first = 0 if start is None else int(np.searchsorted(t, start))
    last = t.size if end is None else int(np.searchsorted(t, end, side="right"))
    if last - first < 2:
        raise QuestionError(f"{origin}: no samples from start to end; the file has {t[0]:.6g} s to {t[-1]:.6g} s")
    return slice(first, last)


def _channels(
    raw: RawFile, described: dict[str, DescribedChannel], used: slice, t: Floats, implausible: bool
) -> tuple[dict[str, Channel], list[str]]:
    """The channels, and which columns were left out although nobody asked for that."""
    left = []
    if not described:
        names = [name for name in raw.columns if name != raw.clock]
        known = [name for name in names if raw.columns[name].unit or raw.columns[name].quantity or is_tacho(name)]
        described = {name.replace(" ", "_"): DescribedChannel(column=name) for name in known}
        left = [
            f"{name} has no unit and was left out; describe it as a channel to use it"
            for name in names
            if name not in known
        ]
    if not described:
        raise QuestionError(
            f"{raw.origin}: no column has a unit; write it in brackets after the name, or describe the channels, such as "
            'channels={"x": {"column": "NAME", "quantity": "displacement", "unit": "um"}}. '
            f"There are {', '.join(raw.columns)}"
        )
    found = {}
    for name, words in described.items():
        column = _column(raw, name, words)
        channel = _channel(raw.origin, name, words, column, column.values[used])
        values = channel.values if isinstance(channel.values, Samples) else np.asarray(channel.values)
        refuse_missing(name, t[used], values)
        if not implausible:
            refuse_implausible(name, channel.quantity, values)
        found[name] = channel
        if channel.direction != "" and not (
            words.direction != "" or column.direction or _direction(words.column or name)
        ):
            left.append(
                f"{words.column or name} is taken to be along {channel.direction}; give its direction if it is not"
            )
    return found, left


def _channel(origin: str, name: str, words: DescribedChannel, column: RawColumn, values: Floats | Samples) -> Channel:
    unit = words.unit or column.unit
    quantity = words.quantity or column.quantity or quantity_of(words.column or name, unit)
    if quantity not in UNITS:
        given = f"quantity {quantity!r}" if quantity else f"its unit {unit!r} is that of no quantity"
        raise QuestionError(f"{origin}: channel {name!r}: {given}; the quantity must be one of {', '.join(UNITS)}")
    si = UNITS[quantity][0]
    try:
        if words.sensitivity:
            volts = factor_to(unit or "V", "V")
            factor = volts / float(to_si(words.sensitivity, f"V/({si.replace(' ', '*')})"))
        elif words.full_scale:
            factor = float(to_si(words.full_scale, si))
        elif not unit and quantity != "tacho":
            raise UnitError(f"no unit; write it in brackets after the name, or as unit = {si!r}")
        else:
            factor = factor_to(unit, si) if unit else 1.0
        known = float(to_si(words.uncertainty, si)) if words.uncertainty else None
    except UnitError as reason:
        raise QuestionError(f"{origin}: channel {name!r}: {reason}") from None
    direction = (
        words.direction if words.direction != "" else column.direction or _direction(words.column or name, quantity)
    )
    return Channel(factor * values, quantity, words.place or column.place, direction, uncertainty=known)


def _direction(name: str, quantity: str = "") -> str:
    """``x`` of ``bearing_x``, of an acceleration ``ax``, of a velocity ``vx``; empty where the name says none."""
    last = (name.replace("_", " ").split() or [""])[-1]
    if quantity and last.lower() in [quantity[0] + axis for axis in "xyz"]:
        last = last[1:].lower()
    return last if last in ("x", "y", "z") else ""


def _signals(raw: RawFile, t: Floats, found: dict[str, Channel], wanted: float | None, remarks: list[str]) -> Signals:
    held = {
        name: one.values if isinstance(one.values, Samples) else np.asarray(one.values) for name, one in found.items()
    }
    remarks += [text for name, one in found.items() for text in doubts(name, one.quantity, t, held[name])]
    if wanted is None:
        exact = t if raw.time is None else even(t, raw.quantum, raw.origin)
        if exact is None:
            raise QuestionError(uneven_text(t, raw.origin))
        t = exact
    else:
        grid = grid_of(t, wanted, raw.origin)
        found = {name: _at(t, one, grid) for name, one in found.items()}
        remarks.append(f"resampled to {wanted:.6g} Hz from {t.size} samples")
        t = grid
    result = signals(t, found, origin=raw.origin)
    for text in remarks:
        warn(f"{raw.origin}: {text}", RangeWarning)
    return Signals.of(result.assign_attrs(warnings="\n".join(remarks)))


def _at(t: Floats, channel: Channel, grid: Floats) -> Channel:
    held = channel.values if isinstance(channel.values, Samples) else np.asarray(channel.values, np.float64)
    values = resampled(t, held, grid)
    return Channel(values, channel.quantity, channel.place, channel.direction, uncertainty=channel.uncertainty)
