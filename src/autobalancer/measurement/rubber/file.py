"""Measured points of rubber from a table."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import get_args

from autobalancer.errors import ResultError
from autobalancer.files.table import Table, read_table
from autobalancer.laws.rubber import Motion
from autobalancer.measurement.rubber.measured import (
    LOSS_SURE,
    STIFFNESS_SURE,
    rubber_loops,
    rubber_resonances,
)
from autobalancer.results.answers.rubber_points import RubberPoints
from autobalancer.safe_file import as_path

LOOPS = "frequency [Hz], amplitude [mm], stiffness [kN/m], damping [N s/m]"


def load_rubber(
    path: str | Path, *, stiffness_uncertainty: float = STIFFNESS_SURE, loss_uncertainty: float = LOSS_SURE
) -> RubberPoints:
    """Read a table of hysteresis loops or of resonances.

    Parameters
    ----------
    path
        Loops have the columns ``frequency``, ``amplitude``, ``stiffness`` (force over deflection) and ``damping``, as
        :func:`~autobalancer.measure.rubber_loops` explains; resonances ``frequency``, ``amplitude``, ``mass`` and perhaps
        ``decay rate``, as :func:`~autobalancer.measure.rubber_resonances`; both perhaps ``motion``, line or circle.
    stiffness_uncertainty, loss_uncertainty
        Relative standard uncertainties.

    Raises
    ------
    ResultError
        If the file, a column, a unit or a number is missing or cannot be read.
    QuestionError
        If a number is impossible.
    """
    table = read_table(as_path(path), LOOPS)
    motion = _motions(table)
    sure = {"stiffness_uncertainty": stiffness_uncertainty, "loss_uncertainty": loss_uncertainty}
    w, x = table.numbers("frequency", "rad/s"), table.numbers("amplitude", "m")
    if "mass" in table.heads:
        decay = table.numbers("decay rate", "1/s") if "decay rate" in table.heads else None
        points = rubber_resonances(table.numbers("mass", "kg"), w, x, decay, motion=motion, **sure)
    else:
        points = rubber_loops(
            w, x, table.numbers("stiffness", "N/m"), table.numbers("damping", "N*s/m"), motion=motion, **sure
        )
    names = [
        f"line {line} ({name.partition('(')[2]}" for (line, _), name in zip(table.lines, points.names, strict=True)
    ]
    return replace(points, names=tuple(names))


def _motions(table: Table) -> list[Motion]:
    if "motion" not in table.heads:
        return ["line"] * len(table.lines)
    found: list[Motion] = []
    for (line, _), text in zip(table.lines, table.texts("motion"), strict=True):
        if text not in get_args(Motion):
            raise ResultError(f"{table.place}, line {line}: motion: given {text!r}; must be line or circle")
        found.append("circle" if text == "circle" else "line")
    return found
