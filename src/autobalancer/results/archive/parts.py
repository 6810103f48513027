"""Samples of a long run in many files, read as one dataset: only what is asked for comes into memory."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr
from numpy.typing import NDArray
from xarray.backends import BackendArray
from xarray.core import indexing

from autobalancer.errors import ResultError
from autobalancer.safe_file import endless_heap

NETCDF = threading.RLock()  # the library must not be entered by two threads


def open_parts(files: Sequence[Path], read: Sequence[str] = ()) -> xr.Dataset:
    """The parts of a run, one after the other in time, as one dataset whose samples stay on disk until they are used.

    Times, and what does not depend on time, are read at once. A part is read at a time, so memory stays small while one
    goes through a run in slices.

    Parameters
    ----------
    files
        netCDF files with the dimension ``time`` first; their times ascend.
    read
        Variables that are read at once, as far as there are such: each file is opened once for all of them.

    Raises
    ------
    ResultError
        If there is no part, or one cannot be read.
    """
    if not files:
        raise ResultError("the run has no samples yet; nothing was written before it ended")
    try:
        for file in files:
            if endless := endless_heap(file):
                raise ValueError(endless)
        with NETCDF, xr.open_dataset(files[0], engine="netcdf4", decode_times=False) as stored:
            first = stored.isel(time=slice(0, 0)).load()
    except (OSError, RuntimeError, ValueError) as reason:
        raise ResultError(f"{files[0]}: not a readable part of a run: {reason}") from None
    at_once = [name for name in read if name in first and "time" in first[name].dims]
    pieces = [_samples(file, ("time", *at_once), first=first) for file in files]
    times = [piece["time"] for piece in pieces]
    _ascending(files, times)
    starts = np.concatenate([[0], np.cumsum([time.size for time in times])])
    variables: dict[str, Any] = {}
    for key, variable in first.variables.items():
        name = str(key)
        if name == "time":
            variables[name] = xr.Variable("time", np.concatenate(times), variable.attrs)
        elif name in at_once:
            variables[name] = xr.Variable(variable.dims, np.concatenate([p[name] for p in pieces]), variable.attrs)
        elif "time" in variable.dims:
            lazy = indexing.LazilyIndexedArray(_Parts(files, name, starts, variable.shape[1:], variable.dtype))
            variables[name] = xr.Variable(variable.dims, lazy, variable.attrs)
        else:
            variables[name] = variable
    coords = {name: variables.pop(name) for name in map(str, first.coords)}
    return xr.Dataset(variables, coords, first.attrs)


def _ascending(files: Sequence[Path], times: Sequence[NDArray[Any]]) -> None:
    """Refuse parts that were exchanged, or are of other runs."""
    last = -np.inf
    for file, time in zip(files, times, strict=True):
        if time.dtype.kind not in "fiu" or time.ndim != 1 or not np.all(np.diff(time, prepend=last) > 0.0):
            raise ResultError(
                f"{file}: its times do not follow those of the part before; was it replaced by another file?"
            )
        last = time[-1] if time.size else last


def _samples(
    file: Path, names: Sequence[str], which: slice = slice(None), first: xr.Dataset | None = None
) -> dict[str, NDArray[Any]]:
    """Variables of a file; refused if it is not of the same run as the ``first`` part."""
    try:
        with NETCDF, netCDF4.Dataset(file) as stored:
            if first is not None:
                _refuse_other_run(stored, first)
            return {name: np.asarray(stored.variables[name][which]) for name in names}
    except KeyError as reason:
        raise ResultError(f"{file}: not a readable part of this run: it has no {reason}") from None
    except (OSError, RuntimeError, IndexError, ValueError) as reason:
        raise ResultError(f"{file}: not a readable part of a run: {reason}") from None


def _refuse_other_run(stored: netCDF4.Dataset, first: xr.Dataset) -> None:
    for key, variable in first.variables.items():
        if stored.variables[str(key)].shape[1:] != variable.shape[1:]:
            raise ValueError(f"{str(key)!r} is of another size than in the first part; is it of another run?")
    for name in {"machine", "seed"} & set(first.attrs):
        if getattr(stored, name, None) != first.attrs[name]:
            raise ValueError(f"its {name} is not that of the first part; is it of another run?")


class _Parts(BackendArray):
    """One variable, its first axis time, in many files."""

    def __init__(
        self, files: Sequence[Path], name: str, starts: NDArray[np.int64], rest: tuple[int, ...], dtype: np.dtype[Any]
    ) -> None:
        self.files, self.name, self.starts = list(files), name, starts
        self.shape = (int(starts[-1]), *rest)
        self.dtype = dtype

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.OUTER, self._read)

    def _read(self, key: tuple[Any, ...]) -> NDArray[Any]:
        wanted = np.atleast_1d(np.arange(self.shape[0])[key[0]])
        found = np.empty((wanted.size, *self.shape[1:]), self.dtype)
        for file, start, end in zip(self.files, self.starts[:-1], self.starts[1:], strict=True):
            here = np.flatnonzero((wanted >= start) & (wanted < end))
            if here.size == 0:
                continue
            local = wanted[here] - start
            low, high = int(local.min()), int(local.max()) + 1
            found[here] = _samples(file, (self.name,), slice(low, high))[self.name][local - low]
        for axis in range(len(key) - 1, 0, -1):
            found = found[(slice(None),) * axis + (key[axis],)]
        return found[0] if isinstance(key[0], (int, np.integer)) else found
