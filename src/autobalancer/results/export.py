"""Results as text that any program reads: a table of comma-separated values, or JSON."""

from __future__ import annotations

import csv
import io
import json
import math
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.errors import ResultError
from autobalancer.results.answers.answer import Answer


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
    """The main table of a result, in SI with units in the first line: ``time [s],speed [rad/s],...``.

    Rows follow the numeric dimensions of the largest group of variables; dimensions that only count or name, such as
    balls and stations, become columns.

    Raises
    ------
    ResultError
        If it has no table.
    """
    if isinstance(result, Answer):
        result = result.in_si()
    rows = _row_dims(result)
    if not rows:
        raise ResultError("this result has no table; write it as .nc or .json")
    index = [
        result[name] if name in result.coords else xr.DataArray(np.arange(1, result.sizes[name] + 1), dims=name)
        for name in rows
    ]
    grids = xr.broadcast(*index) if len(index) > 1 else index
    heads = [_head(name, str(entry.attrs.get("units", ""))) for name, entry in zip(rows, index, strict=True)]
    columns = [grid.transpose(*rows).values.ravel() for grid in grids]
    for name, entry in result.variables.items():
        if str(name) in rows or not set(rows) & set(entry.dims) or not set(entry.dims) - set(rows) <= _named(result):
            continue
        if not set(rows) <= set(entry.dims):
            continue
        others = [dim for dim in entry.dims if dim not in rows]
        values = entry.transpose(*rows, *others).values.reshape(columns[0].size, -1)
        for k, (place, unit) in enumerate(zip(_places(result, others), _units(result, entry, others), strict=True)):
            heads.append(_head(f"{name}{place}", unit))
            columns.append(values[:, k])
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(heads)
    table.writerows([_cell(value) for value in row] for row in zip(*columns, strict=True))
    return text.getvalue()


TABLE = 2  # dimensions that rows may follow
WRITERS = {".csv": result_csv, ".json": result_json}


def _named(result: xr.Dataset) -> set[Any]:
    """Dimensions that count or name things: they become columns."""
    return {dim for dim in result.dims if dim not in result.coords or result[dim].dtype.kind not in "f"}


def _row_dims(result: xr.Dataset) -> list[str]:
    """The one or two numeric dimensions that span the most values; without any, the dimension of the most values."""
    named = _named(result)
    groups: dict[tuple[str, ...], int] = {}
    for entry in result.data_vars.values():
        dims = tuple(str(dim) for dim in entry.dims if dim not in named) or tuple(map(str, entry.dims[:1]))
        if dims:
            groups[dims] = groups.get(dims, 0) + entry.size

    ranked = [(len(dims) if len(dims) <= TABLE and not named & set(dims) else 0, groups[dims], dims) for dims in groups]
    return list(max(ranked)[2]) if ranked else []


def _places(result: xr.Dataset, dims: list[Any]) -> list[str]:
    """``[1]``, ``[2]`` or ``[B1]`` for each value of the dimensions that become columns."""
    places = [""]
    for dim in dims:
        labels = result[dim].values if dim in result.coords else np.arange(1, result.sizes[dim] + 1)
        places = [f"{place}[{label}]" for place in places for label in labels]
    return places


def _units(result: xr.Dataset, entry: Any, dims: list[Any]) -> list[str]:
    """The unit of each such column: of the variable, or of its channel, which ``units`` says, in the form ``units_form``."""
    own = str(entry.attrs.get("units", ""))
    if own or "units" not in result.variables or not set(result["units"].dims) <= set(dims):
        return [own] * math.prod(result.sizes[dim] for dim in dims)
    form = str(entry.attrs.get("units_form", "{}"))
    like = xr.DataArray(np.zeros([result.sizes[dim] for dim in dims]), dims=dims)
    units = xr.broadcast(result["units"].reset_coords(drop=True), like)[0].transpose(*dims).values.ravel()
    return [form.format(unit if unit.isalpha() or form == "{}" else f"({unit})") for unit in map(str, units)]


def _head(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit and unit != "1" else name


def _cell(value: Any) -> str:
    if isinstance(value, (float, np.floating)):
        return "" if math.isnan(value) else repr(float(value))
    return str(value)
