"""Measured signals from files."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from autobalancer.errors import QuestionError, ResultError
from autobalancer.files.samples import sample_hint
from autobalancer.measurement.signals.table import read_signal_table
from autobalancer.results.answers.signals import Signals
from autobalancer.results.store import load_run


def load_signals(path: str | Path) -> Signals:
    """Read measured signals.

    Parameters
    ----------
    path
        A table (``.csv``, ``.txt``, ...) whose first line names the columns, each with its unit in brackets:
        ``time [s], x [um], tacho [V]``. Or a file that :func:`~autobalancer.save_run` wrote (``.nc``).

    Returns
    -------
    xarray.Dataset
        As :func:`~autobalancer.measure.signals` makes it.

    Raises
    ------
    ResultError
        If the file cannot be read; the message says where and what is expected.
    QuestionError
        If the times are not even or a value is not finite.
    """
    path = Path(path)
    if path.suffix.lower() == ".nc":
        return _own(load_run(path), path)
    if not path.is_file():
        raise ResultError(f"{path}: no such file{sample_hint(path)}")
    return read_signal_table(path)


def _own(found: xr.Dataset, path: Path) -> Signals:
    if not isinstance(found, Signals):
        raise QuestionError(f"{path}: holds no measured signals; ab.measure.signals and load_signals make them")
    return found
