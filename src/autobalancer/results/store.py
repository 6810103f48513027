"""Result files: netCDF, self-describing, readable by everything that reads netCDF."""

from __future__ import annotations

import csv
import io
import json
import math
import tempfile
import threading
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError, ResultError
from autobalancer.results.answers.answer import KIND, MAKER, Answer, main_table, provenance
from autobalancer.results.answers.kinds import as_kind
from autobalancer.results.signals import UNIVERSAL, universal_text
from autobalancer.safe_file import as_path, endless_heap, not_to_read, ready_to_write, write_safely, write_text_safely

NUMBERS = {
    "time",
    "speed",
    "deflection",
    "x",
    "y",
    "ball_angle_in_rotor",
    "envelope_time",
    "envelope_end",
    "envelope_high",
    "turn_time",
}
LISTED = "lists"  # attribute of a file: which attributes were lists
# files of earlier versions do not say which of their attributes were lists
LISTS = {"critical_speeds", "points", "events_seen", "events_watched", "parameters", "speeds_without_state", "states"}

NETCDF = threading.RLock()  # the library must not be entered by two threads
LEAST_REFUSED = 100_000_000  # bytes; a smaller array that a damaged file claims does no harm


def save_run(run: xr.Dataset, path: str | Path, *, rescue: bool = False) -> Path:
    """Write a result; the suffix says how. An existing file is replaced only when the new one is complete.

    ``.nc`` is netCDF with all there is, and the only form that :func:`load_run` reads. ``.csv`` has the main table in SI,
    with units in its first line, ``.json`` everything. Signals may be a universal file, ``.uff`` (dataset 58), too.

    Parameters
    ----------
    run
        A result of this package.
    path
        The file; its folder is created if it does not exist.
    rescue
        If it cannot be written there, write it to a new folder in the temporary directory; the error says where.

    Raises
    ------
    QuestionError
        If it is no result.
    ResultError
        If the suffix is another one, or the file cannot be written.
    """
    path = as_path(path)
    if not isinstance(run, xr.Dataset):
        raise QuestionError(f"save_run: given a {type(run).__name__}; give a result of this package, such as a run")
    try:
        return _write(run, path)
    except ResultError as reason:
        if not rescue:
            raise
        raise ResultError(f"{reason}\n{_rescued(run, path.name[-60:])}") from None


def _write(run: xr.Dataset, path: Path) -> Path:
    kind = path.suffix.lower()
    if kind == ".nc":
        # with what a file must say so that it comes back as it was: netCDF turns a list of one into a scalar
        lists = [str(key) for key, value in run.attrs.items() if isinstance(value, (list, tuple))]
        empty = {key: "" for key in lists if not run.attrs[key]}
        kept = {"source": provenance()["source"], **run.attrs, **empty}
        whole = run.assign_attrs(kept | {KIND: _kind_of(run), LISTED: " ".join(lists)})
        with NETCDF:
            return write_safely(path, lambda file: whole.to_netcdf(file, engine="netcdf4"))
    if kind in UNIVERSAL:
        return write_text_safely(path, universal_text(run))
    if kind not in WRITERS:
        ready_to_write(path)  # a device or a folder is named as such
        raise ResultError(f"{path}: results are written as .nc, .csv or .json; end the name with one of these")
    return write_text_safely(path, WRITERS[kind](run))


def _kind_of(dataset: xr.Dataset) -> str:
    """Name of its kind; empty for a plain dataset."""
    own = isinstance(dataset, Answer) and type(dataset) is not Answer
    return type(dataset).__name__ if own else str(dataset.attrs.get(KIND, ""))


def _rescued(run: xr.Dataset, name: str) -> str:
    try:
        place = Path(tempfile.mkdtemp(prefix="autobalancer-")) / name
        _write(run, place)
    except (ResultError, OSError) as reason:
        return f"it could not be kept in the temporary directory either: {reason}"
    return f"The result is kept in {place}; move it from there"


def load_run(path: str | Path) -> xr.Dataset:
    """Read the result file at ``path`` into memory; it comes back as what was saved, and shows itself in the same way.

    Raises
    ------
    ResultError
        If the file does not exist, is damaged, or was not written by this package.
    """
    path = as_path(path)
    if reason := not_to_read(path):
        raise ResultError(f"{path}: {reason}")
    if path.suffix == ".toml":
        raise ResultError(
            f"{path}: is no result but a machine file; 'autobalancer simulate {path}' makes a result of it"
        )
    try:
        if endless := endless_heap(path):
            raise ValueError(endless)
        with NETCDF, xr.open_dataset(path, engine="netcdf4") as stored:
            claimed = stored.nbytes
            if claimed > LEAST_REFUSED and claimed > 100 * path.stat().st_size:
                raise ValueError(f"it claims {1e-9 * claimed:.3g} GB and has {1e-9 * path.stat().st_size:.3g} GB")
            run = stored.load()
    except (OSError, ValueError, RuntimeError, MemoryError, OverflowError, LookupError, AttributeError) as reason:
        raise ResultError(f"{path}: not a readable result file: {reason}") from None
    if not str(run.attrs.get("source", "")).startswith(MAKER):
        raise ResultError(f"{path}: was not written by autobalancer; its attribute 'source' says nothing of the kind")
    odd = [str(name) for name in NUMBERS & set(run.variables) if run[name].dtype.kind not in "fiu"]
    if odd:
        raise ResultError(f"{path}: damaged; {odd[0]!r} does not hold numbers")
    kind, listed = (str(run.attrs.pop(name, "")) for name in (KIND, LISTED))
    for key in (LISTS | set(listed.split())) & set(run.attrs):
        value = run.attrs[key]
        run.attrs[key] = [] if isinstance(value, str) and not value else np.atleast_1d(value).tolist()
    return as_kind(run, kind)


# Results as text that any program reads: a table of comma-separated values, or JSON.


def plain_json(value: Any) -> Any:
    """Lists, dictionaries, texts and numbers that JSON can say: nan is null, infinity the text ``"Infinity"``."""
    if isinstance(value, dict):
        return {str(key): plain_json(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple, set)):
        return [plain_json(entry) for entry in value]
    if isinstance(value, np.ndarray):
        return plain_json(value.tolist())
    if isinstance(value, np.generic):
        return plain_json(value.item())
    if isinstance(value, float):
        if math.isfinite(value):
            return float(value)
        return None if math.isnan(value) else "Infinity" if value > 0.0 else "-Infinity"
    if isinstance(value, complex):
        return plain_json([value.real, value.imag])
    return value if value is None or isinstance(value, (str, bool, int)) else str(value)


def result_json(result: xr.Dataset) -> str:
    """The whole result: attributes, and of each variable dimensions, unit, meaning and values."""
    variables = {
        str(name): {"dims": list(entry.dims), **plain_json(entry.attrs), "values": plain_json(entry.values)}
        for name, entry in result.variables.items()
    }
    return (
        json.dumps({"attributes": plain_json(result.attrs), "variables": variables}, indent=1, allow_nan=False) + "\n"
    )


def result_csv(result: xr.Dataset) -> str:
    """The main table of a result, in SI with units in the first line: ``time [s],speed [rad/s],...``."""
    columns = main_table(result)
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(columns)
    table.writerows([_cell(value) for value in row] for row in zip(*columns.values(), strict=True))
    return text.getvalue()


WRITERS = {".csv": result_csv, ".json": result_json}


def _cell(value: Any) -> str:
    if isinstance(value, (float, np.floating)):
        return "" if math.isnan(value) else repr(float(value))
    return str(value)
