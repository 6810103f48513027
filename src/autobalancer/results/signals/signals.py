"""Measured signals show their channels, not their samples; long ones stay in their files and are read piece by piece."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from xarray.backends import BackendArray
from xarray.core.indexing import ExplicitIndexer, IndexingSupport, LazilyIndexedArray, explicit_indexing_adapter

from autobalancer.results.answers.answer import Answer
from autobalancer.results.display_units import axis_unit, length_axis
from autobalancer.shown import Column

Floats = NDArray[np.float64]
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
        found = np.empty(index.size)
        ahead = index[order]
        far = (np.diff(ahead) > NEAR) | (np.diff(ahead // BLOCK) > 0)
        for group in np.split(order, np.flatnonzero(far) + 1) if index.size else []:
            first = int(index[group[0]])
            found[group] = self.samples.piece(first, int(index[group[-1]]) + 1)[index[group] - first]
        return found if isinstance(at, (slice, np.ndarray)) else found[0]


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


def together(starts: NDArray[np.int64], ends: NDArray[np.int64]) -> Iterator[slice]:
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
    most = 60

    def facts(self) -> list[tuple[str, str]]:
        """Length, rate, and where they come from."""
        time = self["time"].values
        step = 1.0 / float(self.attrs["sampling_rate"])
        length = f"{time[0]:.6g} s to {time[-1]:.6g} s, {time.size} samples, one each {1e3 * step:.5g} ms"
        origin = str(self.attrs.get("origin", ""))
        return [("time", length), ("sampling rate", f"{1.0 / step:.6g} Hz"), *([("from", origin)] if origin else [])]

    def columns(self, unit: str = "") -> list[Column]:
        """Quantity, place with direction, mean, least, greatest and standard deviation."""
        shown = [_shown(entry, unit or self.shown_in) for entry in self.data_vars.values()]
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

    def has_table(self) -> bool:
        """Every variable must be a channel."""
        return "sampling_rate" in self.attrs and "time" in self.coords and all(
            entry.dims == ("time",) for entry in self.data_vars.values()
        )  # fmt: skip

    def remarks(self) -> list[str]:
        """What was found and mended when they were read."""
        return [line for line in str(self.attrs.get("warnings", "")).split("\n") if line]


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
