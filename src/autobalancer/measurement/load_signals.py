"""Measured signals from files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from pydantic import Field, PlainValidator
from scipy.interpolate import make_interp_spline

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError, RangeWarning, UnitError, warn
from autobalancer.files.text_files import built_of, read_toml
from autobalancer.machine.part import Label, Question, key
from autobalancer.measurement.signal_formats import RawColumn, RawFile, read_raw
from autobalancer.measurement.signals import (
    UNEVEN,
    UNITS,
    Channel,
    factor_to,
    hertz_argument,
    is_tacho,
    quantity_of,
    signals,
)
from autobalancer.memory import refuse_beyond_memory
from autobalancer.results.signals import BLOCK, LONG, Samples, Signals, extremes, pieces
from autobalancer.results.store import load_run
from autobalancer.safe_file import as_path
from autobalancer.units import optional_argument, shortened, to_si

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
    signals, left = _channels(raw, described, used, t, implausible)
    remarks = [*raw.remarks, *rate_remarks(raw, t, known), *left]
    return _signals(raw if known is None else replace(raw, time=None), t[used], signals, wanted, remarks)


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


def _own(dataset: xr.Dataset, path: Path) -> Signals:
    if not isinstance(dataset, Signals):
        raise QuestionError(f"{path}: holds no measured signals; ab.measure.signals and load_signals make them")
    return dataset


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
    channels = {}
    for name, words in described.items():
        column = _column(raw, name, words)
        channel = _channel(raw.origin, name, words, column, column.values[used])
        values = channel.values if isinstance(channel.values, Samples) else np.asarray(channel.values)
        values, filled = without_holes(name, channel.quantity, t[used], values)
        left += filled
        if not implausible:
            refuse_implausible(name, channel.quantity, values)
        channels[name] = replace(channel, values=values)
        if channel.direction != "" and not (
            words.direction != "" or column.direction or _direction(words.column or name)
        ):
            left.append(
                f"{words.column or name} is taken to be along {channel.direction}; give its direction if it is not"
            )
    return channels, left


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
        found = {name: _resampled(t, one, grid) for name, one in found.items()}
        remarks.append(f"resampled to {wanted:.6g} Hz from {t.size} samples")
        t = grid
    result = signals(t, found, origin=raw.origin)
    for text in remarks:
        warn(f"{raw.origin}: {text}", RangeWarning)
    return Signals.of(result.assign_attrs(warnings="\n".join(remarks)))


def _resampled(t: Floats, channel: Channel, grid: Floats) -> Channel:
    held = channel.values if isinstance(channel.values, Samples) else np.asarray(channel.values, np.float64)
    values = resampled(t, held, grid)
    return Channel(values, channel.quantity, channel.place, channel.direction, uncertainty=channel.uncertainty)


# What the user says of the channels of a file: column, quantity, unit, place, direction, sensitivity.


def _along(given: Any) -> Any:
    if isinstance(given, bool) or not isinstance(given, (str, int, float)):
        raise ValueError(f"given {shortened(given)}; must be a text, or an angle in degrees")
    return given


class DescribedChannel(Question):
    """One channel in words; what is left out is taken from the file."""

    column: Label = key("its name in the file; that of the channel unless given", "")
    quantity: Label = key("what it is, such as `displacement`; `time` says that the column has the instants", "")
    unit: Label = key("of the numbers in the file", "")
    place: Label = key("where the sensor is", "")
    direction: Annotated[str | float, PlainValidator(_along, json_schema_input_type=str | float)] = key(
        "along which it measures", "", value="text, or degrees"
    )
    sensitivity: Label = key(
        'of the sensor, voltage over quantity, such as "100 mV/g"; the numbers of the file are then voltages', ""
    )
    full_scale: Label = key("value at the greatest number that the file can hold; for sound files", "")
    uncertainty: Label = key("one standard deviation of a value", "")


class ChannelFile(Question):
    """What the columns of a file of signals are."""

    name: Label = key("of the file", "")
    description: str = key("what it is about", "")
    channels: Annotated[dict[str, DescribedChannel], Field(min_length=1)] = key("a table for each channel, by its name")


Described = Mapping[str, Mapping[str, Any] | DescribedChannel]


def described_channels(
    argument: Described | str | Path | None, beside: Path | None = None
) -> dict[str, DescribedChannel]:
    """The channels that were described, by name; empty if none were.

    Parameters
    ----------
    argument
        By name, a TOML file with a table ``channels``, or ``None``.
    beside
        The file of the signals; where nothing was given, ``NAME.channels.toml`` beside it is read if it exists.

    Raises
    ------
    QuestionError
        If a key is unknown.
    """
    if argument is None and beside is not None:
        own = beside.with_name(f"{beside.stem}.channels.toml")
        argument = own if own.is_file() else None
    if argument is None:
        return {}
    if not isinstance(argument, (str, Path)):
        given: dict[str, Any] = {"channels": argument}  # checked by the class
        return built_of(lambda data: ChannelFile(**data), given, "").channels if argument else {}
    return built_of(lambda data: ChannelFile(**data), read_toml(Path(argument)), str(argument)).channels


# Instants of samples: even ones as they are, rounded ones made even, uneven ones refused or resampled.


GAP = 1.5  # steps; a longer one is a gap
SAMPLE = 16.0  # bytes of a new sample: its instant, and what checks of it need
MARGIN = 64  # samples beside a piece, beyond which a spline of degree five forgets (0.43^64) where it began
NAMED = 5  # places that a message names


def instants(raw: RawFile, rate: float | None) -> Floats:
    """The instants of the samples, s; (time,).

    Raises
    ------
    QuestionError
        If neither the file nor the caller says them, or they do not ascend.
    """
    if raw.time is None or rate is not None:
        known = rate or raw.rate
        if known is None:
            why = raw.timeless or "no column of time"
            if any(name.lower().startswith("freq") for name in raw.columns):
                raise QuestionError(
                    f"{raw.origin}: {why}; over the frequency it is a receptance ('autobalancer receptance')"
                )
            raise QuestionError(
                f"{raw.origin}: {why}; {'or ' * bool(raw.timeless)}give the rate of the samples, such as rate='2 kHz'"
            )
        size = next((column.values.size for column in raw.columns.values()), 0)
        start = 0.0 if raw.time is None or not np.isfinite(raw.time[:1]).all() else float(raw.time[0])
        refuse_beyond_memory(raw.origin, size, "samples", SAMPLE, "; use fewer, or a piece of the record")
        t = np.arange(size, dtype=np.float64)  # in place: of a long record no more arrays than needed
        t /= known
        t += start
        return t
    t = np.asarray(raw.time)
    for first, part in pieces(t):
        if not np.isfinite(part).all():
            bad = first + int(np.flatnonzero(~np.isfinite(part))[0]) + 1
            raise QuestionError(f"{raw.origin}: time: sample {bad} is not a number")
    back = np.concatenate([first + np.flatnonzero(np.diff(part) <= 0.0) for first, part in pieces(t, 1)])
    if back.size:
        after = t[back[0]]
        rounded = (np.diff(t) >= 0.0).all() and t[-1] > t[0]
        hint = f". {_overruled(t)}" if rounded else ""
        raise QuestionError(f"{raw.origin}: time must ascend; after {after:.9g} s comes {t[back[0] + 1]:.9g} s{hint}")
    return t


def _overruled(t: Floats) -> str:
    """The way out for times that a logger rounded too coarsely, with the rate that they have on average."""
    rate = (t.size - 1) / float(t[-1] - t[0])
    return f"If the samples are even and only their times are rounded, give their rate, such as rate='{rate:.5g} Hz'"


def rate_remarks(raw: RawFile, t: Floats, rate: float | None) -> list[str]:
    """What is to be said where a rate takes the place of a column of time."""
    if raw.time is None or rate is None or raw.time.size < 2:
        return []
    span, own = float(raw.time[-1] - raw.time[0]), float(t[-1] - t[0])
    apart = np.isfinite(span) and abs(span - own) > max(0.01 * own, 2.0 * raw.quantum)
    odd = f"; by it the file lasts {span:.4g} s, by the rate {own:.4g} s" if apart else ""
    return [f"the rate of {rate:.6g} Hz is used, not the column of time{odd}"]


def even(t: Floats, quantum: float, origin: str) -> Floats | None:
    """The same instants at exactly equal steps, if they differ from these no more than by the rounding of the file.

    ``None`` if they are not even.

    Raises
    ------
    QuestionError
        If there is a gap; the message says where.
    """
    every = -(-t.size // LONG)  # the median of a long record is that of evenly chosen steps
    step = float(np.median(t[1::every] - t[:-1:every]))
    gaps = np.concatenate(
        [first + np.flatnonzero(np.diff(part) > GAP * step + quantum) for first, part in pieces(t, 1)]
    )
    if gaps.size and gaps.size < 0.01 * t.size + 1:
        where = ", ".join(f"{t[i]:.6g} s ({t[i + 1] - t[i]:.3g} s)" for i in gaps[:NAMED])
        more = f" and {gaps.size - NAMED} more" if gaps.size > NAMED else ""
        raise QuestionError(
            f"{origin}: samples are missing after {where}{more}; the usual step is {step:.4g} s. Use the pieces between, "
            "with start and end"
        )
    allowed = max(UNEVEN * step, 0.75 * quantum if quantum < 0.6 * step else 0.0)
    mean = 0.5 * (t.size - 1)
    slope = sum(float(((first - mean + np.arange(part.size)) * part).sum()) for first, part in pieces(t))
    slope /= t.size * (t.size**2 - 1) / 12.0  # of the line of least squares, after that through both ends
    for span, count, start in ((t[-1] - t[0], 2.0 * mean, t[0]), (slope, 1.0, float(t.mean()) - slope * mean)):
        line = np.arange(t.size, dtype=np.float64)  # in place: of a long record no more arrays than needed
        line *= span
        line /= count
        line += start
        if all(np.abs(t[first : first + part.size] - part).max() <= allowed for first, part in pieces(line)):
            return line
    return None


def uneven_text(t: Floats, origin: str) -> str:
    """What is wrong with uneven instants, and what to do."""
    steps = np.diff(t)
    i = int(np.argmax(np.abs(steps - np.median(steps))))
    low, high = 1.0 / steps.max(), 1.0 / steps.min()
    return (
        f"{origin}: the samples are not evenly spaced: steps from {steps.min():.4g} s to {steps.max():.4g} s, the oddest "
        f"at {t[i]:.6g} s. Resample them, for example resample='{0.5 * (low + high):.4g} Hz'. {_overruled(t)}"
    )


def resampled(t: Floats, values: Floats | Samples, grid: Floats) -> Floats | Samples:
    """Values at other instants, by a spline of degree five; of a long record they are computed when they are asked for."""

    def piece(first: int, end: int) -> Floats:
        if end <= first:
            return np.empty(0)
        low, high = np.searchsorted(t, grid[[first, end - 1]])
        near = slice(max(0, low - MARGIN), high + MARGIN)
        held = np.asarray(values[near], np.float64)
        return np.asarray(make_interp_spline(t[near], held, k=min(5, held.size - 1))(grid[first:end]), np.float64)

    def blocks(first: int, end: int) -> Floats:
        return np.concatenate([piece(a, min(a + BLOCK, end)) for a in range(first, max(end, first + 1), BLOCK)])

    return Samples(grid.size, blocks) if grid.size > LONG else blocks(0, grid.size)


def grid_of(t: Floats, rate: float, origin: str) -> Floats:
    """Even instants of that rate within the measured ones.

    Raises
    ------
    QuestionError
        If a gap is longer than two of the steps asked for, or so many samples do not fit into the memory.
    """
    count = (t[-1] - t[0]) * rate
    refuse_beyond_memory(f"{origin}: resample", count, "samples", SAMPLE, "; take a lower rate")
    steps = np.diff(t)
    gap = int(np.argmax(steps))
    if steps[gap] > 2.0 / rate and steps[gap] > 3.0 * np.median(steps[:: -(-steps.size // LONG)]):
        raise QuestionError(
            f"{origin}: samples are missing from {t[gap]:.6g} s to {t[gap + 1]:.6g} s; use the pieces before or after"
        )
    return np.asarray(t[0] + np.arange(int(np.floor(count)) + 1) / rate, np.float64)


# What is wrong with measured channels: each finding with its time.


GREATEST = {"displacement": 0.05, "velocity": 50.0, "acceleration": 1e5, "speed": 2e4}  # SI, from peak to peak
LEAST = {"displacement": 1e-10, "velocity": 1e-9, "acceleration": 1e-7}
SMALLER = {"displacement": "mm or um", "velocity": "mm/s", "acceleration": "mm/s^2", "speed": "rpm"}
MOST_PLACES = 4  # places that a message names
PLATEAU = 3  # equal samples at an extreme
GONE = 0.1  # of the period of a signal, up to which a gap of samples that are no numbers is bridged
HOLES = 0.01  # share of all samples that may be no numbers
LEAST_NEAR = 8  # known samples beside a gap


def without_holes(name: str, quantity: str, t: Floats, values: Floats | Samples) -> tuple[Floats | Samples, list[str]]:
    """The samples with single ones and short gaps that are no numbers filled in, and a sentence that says so.

    A single sample is always bridged; more only where the signal goes a small part of its period meanwhile, so that a spline
    through their neighbors is sure of them. Pulses of a tacho, which are no smooth curve, are joined by a line over one sample.

    Raises
    ------
    QuestionError
        With their times, where a gap is too long, at an end, or one of too many.
    """
    bad = np.concatenate([first + np.flatnonzero(~np.isfinite(part)) for first, part in pieces(values)])
    if not bad.size:
        return values, []
    gaps = np.split(bad, np.flatnonzero(np.diff(bad) > 1) + 1)
    filled = [_bridged(quantity, values, gap) if bad.size <= HOLES * values.size else None for gap in gaps]
    open_gaps = [gap for gap, numbers in zip(gaps, filled, strict=True) if numbers is None]
    if open_gaps:
        lost = np.concatenate(open_gaps)
        raise QuestionError(
            f"channel {name!r}: {lost.size} of {values.size} samples are no numbers, {_times(t, lost)}; single samples and gaps "
            f"up to {100.0 * GONE:.0f} % of a period are bridged, not more than {100.0 * HOLES:.0f} % of all. Use the pieces "
            "between, with start and end, or leave this channel out"
        )
    numbers = np.concatenate([np.asarray(one) for one in filled])
    text = (
        f"channel {name!r}: {bad.size} of {values.size} samples were no numbers and are interpolated, {_times(t, bad)}"
    )

    def piece(first: int, end: int) -> Floats:
        part = np.array(values[first:end], np.float64)
        inside = slice(*np.searchsorted(bad, [first, end]))
        part[bad[inside] - first] = numbers[inside]
        return part

    return Samples(values.size, piece) if isinstance(values, Samples) else piece(0, values.size), [text]


def _bridged(quantity: str, values: Floats | Samples, gap: NDArray[np.int64]) -> Floats | None:
    """What a spline of degree five, or a line, through the neighbors says of a gap; none if it is too long."""
    first, end = int(gap[0]), int(gap[-1]) + 1
    start = max(0, first - MARGIN)
    near = np.asarray(values[start : end + MARGIN], np.float64)
    known = np.flatnonzero(np.isfinite(near))
    if first == 0 or end == values.size or known.size < LEAST_NEAR:
        return None
    if quantity == "tacho":
        return np.interp(gap - start, known, near[known]) if gap.size == 1 else None
    moves = np.diff(near)[np.isfinite(np.diff(near))]
    spread = float(np.std(near[known]))
    rate = (
        np.sqrt(np.mean(moves**2)) / spread if spread > 0.0 and moves.size else 0.0
    )  # rad a sample, of its mean frequency
    if gap.size > 1 and (gap.size + 1) * rate > 2.0 * np.pi * GONE:
        return None
    return np.asarray(make_interp_spline(known, near[known], k=min(5, known.size - 1))(gap - start), np.float64)


def refuse_implausible(name: str, quantity: str, values: Floats | Samples) -> None:
    """Refuse a vibration that is a thousand times too large, as of numbers in mm that are called m.

    Raises
    ------
    QuestionError
        With the unit that is probably meant.
    """
    if quantity not in GREATEST:
        return
    low, high = extremes(values)
    if (span := high - low) > GREATEST[quantity]:
        unit = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2", "speed": "rad/s"}[quantity]
        raise QuestionError(
            f"channel {name!r}: a {quantity} of {span:.4g} {unit} from peak to peak; is its unit {SMALLER[quantity]}? "
            "Say the unit of the column; if it is right, implausible=True takes it"
        )


def doubts(name: str, quantity: str, t: Floats, values: Floats | Samples) -> list[str]:
    """Sentences on a channel that is constant, clipped or a thousand times too small."""
    low, high = extremes(values)
    span = high - low
    if span == 0.0:
        return [f"channel {name!r} is constant, {low:.4g} at every sample; is the sensor connected?"]
    doubts = []
    if quantity in LEAST and span < LEAST[quantity]:
        doubts.append(f"channel {name!r}: only {span:.3g} (SI) from peak to peak; is its unit right?")
    if quantity != "tacho":
        clipped = clipped_samples(values)
        if clipped.size:
            doubts.append(
                f"channel {name!r} is clipped: {clipped.size} samples stand at its least or greatest value, "
                f"{_times(t, clipped)}; amplitudes there are too small"
            )
    return doubts


def clipped_samples(values: Floats | Samples) -> NDArray[np.int64]:
    """Indices of samples on plateaus at the extremes that the signal enters steeply, as no smooth peak does.

    A peak that is merely rounded to the last digit q enters a plateau of L samples with at most q (4/L + 12/L²) a step.
    """
    size, quantum = values.size, np.inf
    for _, part in pieces(values, 1):
        steps = np.abs(np.diff(part))
        quantum = min(quantum, float(steps.min(where=steps > 0.0, initial=np.inf)))
    if not np.isfinite(quantum):
        return np.array([], np.int64)

    def step(k: int) -> float:
        """From one sample to the next, without a sign."""
        return float(np.abs(np.diff(np.asarray(values[k : k + 2], np.float64)))[0])

    clipped_samples = []
    for extreme in extremes(values)[::-1]:
        at = np.zeros(size + 2, np.int8)  # with a place before the first sample and one behind the last
        for first, part in pieces(values):
            at[first + 1 : first + 1 + part.size] = np.abs(part - extreme) <= 1e-12 * max(abs(extreme), quantum)
        edges = np.flatnonzero(np.diff(at))
        for first, end in zip(edges[::2], edges[1::2], strict=True):
            length = int(end - first)
            if length < PLATEAU:
                continue
            before = step(first - 2) if first >= 2 else 0.0
            after = step(end) if end < size - 1 else 0.0
            if max(before, after) > 1.5 * quantum * (4.0 / length + 12.0 / length**2):
                clipped_samples.append(np.arange(first, end))
    return np.sort(np.concatenate(clipped_samples)) if clipped_samples else np.array([], np.int64)


def _times(t: Floats, indices: NDArray[np.int64]) -> str:
    """First instants of separate groups of samples: ``at 0.12 s, 0.31 s to 0.33 s``."""
    parts = np.split(indices, np.flatnonzero(np.diff(indices) > 1) + 1)
    texts = [f"{t[p[0]]:.6g} s" + (f" to {t[p[-1]]:.6g} s" if p.size > 1 else "") for p in parts[:MOST_PLACES]]
    more = f" and {len(parts) - MOST_PLACES} places more" if len(parts) > MOST_PLACES else ""
    return f"at {', '.join(texts)}{more}"
