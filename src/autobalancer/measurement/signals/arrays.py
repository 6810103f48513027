"""Measured signals in files of arrays: NumPy, MATLAB, and sound files."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from autobalancer.errors import ResultError
from autobalancer.measurement.signals.raw import RawColumn, RawFile
from autobalancer.measurement.signals.table import head_of

TIMES, RATES = ("time", "t"), ("rate", "fs", "sampling_rate", "sample_rate")


def read_arrays(path: Path) -> RawFile:
    """The arrays of a .npz or .mat file: equally long columns, and ``time`` (s) or ``rate`` (Hz).

    Raises
    ------
    ResultError
        If it cannot be read, or the columns are not equally long.
    """
    try:
        held = _held(path)
    except Exception as reason:  # the readers of NumPy and SciPy raise whatever a damaged file leads them to
        raise ResultError(f"{path.name}: cannot be read: {reason}") from None
    arrays = {name: np.squeeze(np.asarray(value)) for name, value in held.items() if not name.startswith("__")}
    numeric = {name: value for name, value in arrays.items() if value.dtype.kind in "fiub"}
    rate = next((float(v) for n, v in numeric.items() if n.lower() in RATES and v.size == 1), None)
    time = next((np.asarray(v, np.float64) for n, v in numeric.items() if n.lower() in TIMES and v.ndim == 1), None)
    columns = {}
    for name, value in numeric.items():
        if value.ndim == 1 and value.size > 1 and name.lower() not in TIMES:
            plain, unit = head_of(name)
            columns[plain] = RawColumn(np.asarray(value, np.float64), unit)
    sizes = {name: column.values.size for name, column in columns.items()}
    if not columns or len({*sizes.values(), *([] if time is None else [time.size])}) > 1:
        there = ", ".join(f"{name} ({size})" for name, size in sizes.items()) or "none"
        raise ResultError(f"{path.name}: wanted are equally long arrays of one dimension; there are {there}")
    return RawFile(path.name, time, None if time is not None else rate, columns)


def _held(path: Path) -> dict[str, Any]:
    if path.suffix.lower() == ".npz":
        with np.load(path, allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    from scipy.io import loadmat

    return dict(loadmat(path))


def read_sound(path: Path) -> RawFile:
    """The channels of a sound file, called 1, 2, ..., as shares of the full scale.

    Raises
    ------
    ResultError
        If it is none.
    """
    from scipy.io import wavfile

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", wavfile.WavFileWarning)  # blocks that hold no samples
            rate, held = wavfile.read(path)
    except Exception as reason:  # as above
        raise ResultError(f"{path.name}: cannot be read: {reason}") from None
    values = np.atleast_2d(held.T).astype(np.float64)
    if held.dtype == np.uint8:
        values = (values - 128.0) / 128.0
    elif held.dtype.kind == "i":
        values /= -float(np.iinfo(held.dtype).min)
    return RawFile(path.name, None, float(rate), {str(k): RawColumn(row) for k, row in enumerate(values, 1)})
