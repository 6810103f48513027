"""Measured profiles in files beside the machine file: roundness of a race, recorded motion of the base or force.

An entry ``file = "name.csv"`` is replaced by the numbers of the table before the machine is checked, so a result that
carries its machine needs no other file.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autobalancer.errors import MachineFileError
from autobalancer.files.table import read_table

RECORDS = {"recorded_base_motion": ("acceleration", "m/s^2"), "recorded_force": ("force", "N")}
EVEN = 1e-3  # greatest deviation of a step of the angle from the mean step, relative


def with_profiles(data: dict[str, Any], folder: Path, source: str) -> dict[str, Any]:
    """The content of a machine file with every ``file`` entry replaced by its numbers.

    Raises
    ------
    MachineFileError
        If a file is not there, or a column, its unit or a number is missing or not understood.
    """
    for b, balancer in enumerate(_tables(data.get("balancers"))):
        for r, race in enumerate(_tables(balancer.get("races"))):
            place = f"{source}: balancers[{b + 1}].races[{r + 1}].roundness"
            given = race.get("roundness")
            if isinstance(given, dict) and "file" in given:
                _alone(given, ("deviations", "angle"), place)
                path = folder / str(given.pop("file"))
                angle, deviation = _columns(path, (("angle", "rad"), ("deviation", "m")), place)
                given |= _even(angle, deviation, f"{place}.file: {path}")
    for i, entry in enumerate(_tables(data.get("excitations"))):
        if "file" in entry:
            place = f"{source}: excitations[{i + 1}]"
            if entry.get("kind") not in RECORDS:
                raise MachineFileError(
                    f"{place}.file: only the kinds {', '.join(map(repr, RECORDS))} can be read from a file"
                )
            name, unit = RECORDS[entry["kind"]]
            _alone(entry, ("time", name), place)
            path = folder / str(entry.pop("file"))
            entry["time"], entry[name] = (
                column.tolist() for column in _columns(path, (("time", "s"), (name, unit)), place)
            )
    return data


def _tables(value: Any) -> list[dict[str, Any]]:
    entries = value if isinstance(value, list) else [value]
    return [entry for entry in entries if isinstance(entry, dict)]


def _alone(entry: dict[str, Any], others: Sequence[str], place: str) -> None:
    both = [key for key in others if key in entry]
    if both:
        raise MachineFileError(f"{place}.{both[0]}: is read from 'file'; leave one of them out")


def _columns(path: Path, wanted: Sequence[tuple[str, str]], place: str) -> list[NDArray[np.float64]]:
    """The columns of a table beside the machine file, in SI."""
    example = ", ".join(f"{name} [{unit}]" for name, unit in wanted)
    table = read_table(path, example, f"{place}.file: {path}", MachineFileError)
    return [table.numbers(name, unit) for name, unit in wanted]


def _even(angle: NDArray[np.float64], deviation: NDArray[np.float64], place: str) -> dict[str, Any]:
    """One turn at equal steps; a last point that repeats the first is left out."""
    if angle.size > 2 and abs(angle[-1] - angle[0] - 2.0 * math.pi) < 1e-3 * (angle[1] - angle[0]):
        angle, deviation = angle[:-1], deviation[:-1]
    step = 2.0 * math.pi / angle.size
    miss = float(np.abs(np.diff(angle) - step).max(initial=0.0))
    if miss > EVEN * step:
        raise MachineFileError(
            f"{place}: {angle.size} angles must have equal steps of {math.degrees(step):.6g} deg over one turn, "
            f"ascending; one step differs by {math.degrees(miss):.3g} deg"
        )
    return {"deviations": deviation.tolist(), "angle": float(angle[0])}
