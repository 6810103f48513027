"""Whatever was measured, from its file."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from autobalancer.errors import ResultError
from autobalancer.files.table import read_table
from autobalancer.measurement.balancing.order_table import EXAMPLE, load_orders
from autobalancer.measurement.signals.load import load_signals
from autobalancer.results.store import load_run
from autobalancer.safe_file import as_path

TABLES = (".csv", ".txt", ".tsv", ".dat")


def load_measured(path: str | Path) -> xr.Dataset:
    """Read whatever was measured: a result of this package, a table of orders over the speed, or signals.

    Parameters
    ----------
    path
        A result (.nc); a table with speed, amplitude and phase, see :func:`autobalancer.measure.load_orders`; or a file of
        signals, see :func:`autobalancer.measure.load_signals`.

    Returns
    -------
    xarray.Dataset
        As these functions return it.

    Raises
    ------
    ResultError
        If the file cannot be read as any of them.
    """
    path = as_path(path)
    if path.suffix.lower() == ".nc":
        return load_run(path)
    return load_orders(path) if _has_orders(path) else load_signals(path)


def _has_orders(path: Path) -> bool:
    """Whether it is a table with speed, amplitude and phase, and no time."""
    if path.suffix.lower() not in TABLES:
        return False
    try:
        heads = set(read_table(path, EXAMPLE).heads)
    except ResultError:
        return False  # the reader of signals says what is wrong
    return {"speed", "amplitude", "phase"} <= heads and "time" not in heads
