"""Measures of many runs of a chamber, as arrays over layers, friction, number of balls and seed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.results.answers.chamber_study import ChamberStudy
from autobalancer.results.chamber.measures import catalog_unit
from autobalancer.results.provenance import provenance

DIMS = ("layers", "friction", "balls", "seed")
NOT_ASKED = "not asked"


class Cell(NamedTuple):
    """One run of a study: ``"deep"`` or ``"single"``, friction, number of balls, seed of the filling."""

    layers: str
    friction: float
    balls: int
    seed: int


def gathered(cells: Sequence[Cell], rows: Sequence[Mapping[str, Any]]) -> xr.Dataset:
    """Runs as one dataset.

    Parameters
    ----------
    cells
        Which run each row is of.
    rows
        ``outcome`` and measures by name; a missing or unknown one counts as nan.

    Returns
    -------
    xarray.Dataset
        Over ``layers``, ``friction``, ``balls`` and ``seed``: every measure, nan where there is none, and ``outcome``.

    Raises
    ------
    QuestionError
        If there is no run.
    """
    if not cells:
        raise QuestionError("study: no runs were asked for; give at least one of each")
    labels: list[list[Any]] = [
        list(dict.fromkeys(cell.layers for cell in cells)),
        sorted({cell.friction for cell in cells}),
        sorted({cell.balls for cell in cells}),
        sorted({cell.seed for cell in cells}),
    ]
    shape = tuple(len(values) for values in labels)
    names = sorted({name for row in rows for name in row if name != "outcome"})
    values = {name: np.full(shape, np.nan) for name in names}
    outcome = np.full(shape, NOT_ASKED, dtype=object)
    for cell, row in zip(cells, rows, strict=True):
        place = tuple(of.index(value) for of, value in zip(labels, cell, strict=True))
        outcome[place] = row["outcome"]
        for name in names:
            value = row.get(name)
            values[name][place] = np.nan if value is None else float(value)
    found = xr.Dataset(coords=dict(zip(DIMS, labels, strict=True)), attrs=provenance())
    for name, numbers in values.items():
        found[name] = (DIMS, numbers, {"units": catalog_unit(name), "long_name": name.replace("_", " ")})
    found["outcome"] = (DIMS, outcome)
    return ChamberStudy.of(found)
