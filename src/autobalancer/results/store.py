"""Result files: netCDF, self-describing, readable by everything that reads netCDF."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import xarray as xr

from autobalancer.errors import ResultError
from autobalancer.results.provenance import MAKER

# netCDF turns a list of one into a scalar; these come back as lists
LISTS = {"critical_speeds", "points", "events_seen", "events_watched", "parameters", "speeds_without_state", "states"}


def save_run(run: xr.Dataset, path: str | Path) -> Path:
    """Write a result as netCDF; an existing file is replaced only when the new one is complete.

    Raises
    ------
    ResultError
        If the file cannot be written.
    """
    path = Path(path)
    unfinished = path.with_name(path.name + ".unfinished")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        run.to_netcdf(unfinished, engine="netcdf4")
        os.replace(unfinished, path)
    except OSError as reason:
        unfinished.unlink(missing_ok=True)
        raise ResultError(f"{path}: cannot be written: {reason}") from None
    return path


def load_run(path: str | Path) -> xr.Dataset:
    """Read a result file into memory.

    Raises
    ------
    ResultError
        If there is no such file, it is damaged, or this package did not write it.
    """
    path = Path(path)
    if not path.is_file():
        raise ResultError(f"{path}: no such file")
    try:
        with xr.open_dataset(path, engine="netcdf4") as stored:
            run = stored.load()
    except (OSError, ValueError, RuntimeError) as reason:
        raise ResultError(f"{path}: not a readable result file: {reason}") from None
    if not str(run.attrs.get("source", "")).startswith(MAKER):
        raise ResultError(f"{path}: was not written by autobalancer; its attribute 'source' says nothing of the kind")
    for key in LISTS & set(run.attrs):
        run.attrs[key] = np.atleast_1d(run.attrs[key]).tolist()
    return run
