"""Frequency responses in universal files: dataset 58 (function at nodal degree of freedom), ASCII, with units of 164.

Formats after the description of the Structural Dynamics Research Laboratory, University of Cincinnati.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.errors import ResultError, UnitError
from autobalancer.rotordynamics.receptance.measured import receptance_dataset
from autobalancer.rotordynamics.receptance.table_file import unit_factor

RESPONSE, FREQUENCY, FORCE = 4, 18, (9, 13)  # function type; kinds of data: frequency, reaction and excitation force
MOTIONS = {8: "receptance", 11: "mobility", 12: "accelerance"}
LENGTHS = {"receptance": "m", "mobility": "m/s", "accelerance": "m/s^2"}


@dataclass(frozen=True)
class _Function:
    """One frequency response as it stands in the file, SI."""

    title: str
    frequency: NDArray[np.float64]
    values: NDArray[np.complex128]
    kind: str
    response: tuple[str, int]  # node, direction
    reference: tuple[str, int]

    @property
    def driving_point(self) -> bool:
        """Whether force and response are at one place and along one line."""
        return self.response[0] == self.reference[0] and abs(self.response[1]) == abs(self.reference[1])


def read_universal(lines: list[str], name: str, function: int | None) -> xr.Dataset:
    """The wanted frequency response of a universal file.

    Raises
    ------
    ResultError
        If there is none, several and none chosen, or a dataset is binary or damaged.
    """
    length = force = 1.0
    found: list[_Function] = []
    for number, block in _blocks(lines):
        kind = block[0].strip() if block else ""
        if kind == "164" and len(block) > 2:
            factors = [float(part.replace("D", "E")) for part in block[2].split()[:2]]
            length, force = 1.0 / factors[0], 1.0 / factors[1]
        elif kind.startswith("58b"):
            raise ResultError(f"{name}, line {number}: dataset 58b is binary; export as ASCII (dataset 58)")
        elif kind == "58":
            try:
                one = _function(block[1:], length, force)
            except (ValueError, IndexError) as reason:
                raise ResultError(f"{name}, dataset 58 at line {number}: {reason}") from None
            found += [one] if one is not None else []
    if not found:
        raise ResultError(f"{name}: no dataset 58 with a frequency response of motion over force")
    candidates = [one for one in found if one.driving_point] if function is None else found[function - 1 : function]
    if len(candidates) != 1 or (function is not None and function < 1):
        rows = "; ".join(
            f"{i}: {f.kind}, node {f.response[0]} direction {f.response[1]} over node {f.reference[0]} "
            f"direction {f.reference[1]}"
            for i, f in enumerate(found, 1)
        )
        raise ResultError(
            f"{name}: choose one function by its number, the one at the race along one line. There are {rows}"
        )
    one = candidates[0]
    sign = float(np.sign(one.response[1] or 1) * np.sign(one.reference[1] or 1))  # minus directions of an accelerometer
    return receptance_dataset(one.frequency, sign * one.values, one.kind, title=f"{name}, {one.title}")


def _blocks(lines: list[str]) -> list[tuple[int, list[str]]]:
    marks = [i for i, line in enumerate(lines) if line.strip() == "-1" and line[:6].strip() == "-1"]
    return [(a + 2, lines[a + 1 : b]) for a, b in zip(marks[::2], marks[1::2], strict=False)]


def _function(block: list[str], length: float, force: float) -> _Function | None:
    place = block[5].ljust(80)
    if int(place[:5]) != RESPONSE:
        return None
    shape = [block[6].ljust(80)[i : i + 10] for i in range(0, 30, 10)]
    form, count, even = (int(part) for part in shape)
    start, step = (float(block[6][i : i + 13]) for i in (30, 43))
    data = [line.ljust(80) for line in block[7:10]]
    abscissa, over, under = (int(line[:10]) for line in data)
    if abscissa != FREQUENCY or over not in MOTIONS or (under not in FORCE):
        return None
    if form not in (5, 6):
        raise ValueError("the values are not complex")
    width, each = (13, 3 - even) if form == 5 else (20, 3 - even)
    numbers = _numbers(block[11:], width, form == 6 and not even)
    if numbers.size != count * each:
        raise ValueError(f"{numbers.size} numbers where {count * each} are announced")
    rows = numbers.reshape(count, each)
    frequency = start + step * np.arange(count) if even else rows[:, 0]
    kind = MOTIONS[over]
    scale = _unit(data[1][47:67], LENGTHS[kind], length) / _unit(data[2][47:67], "N", force)
    return _Function(
        title=block[0].strip(),
        frequency=np.asarray(_unit(data[0][47:67], "rad/s", unit_factor("Hz", "rad/s")) * frequency, np.float64),
        values=np.asarray(scale * (rows[:, -2] + 1j * rows[:, -1]), np.complex128),
        kind=kind,
        response=(place[41:51].strip(), int(place[51:55] or 0)),
        reference=(place[66:76].strip(), int(place[76:80] or 0)),
    )


def _numbers(lines: list[str], width: int, mixed: bool) -> NDArray[np.float64]:
    """Fields of fixed width: 13, 20, or 13 and twice 20 for uneven double values."""
    found = []
    for line in lines:
        line = line.rstrip().replace("D", "E").replace("d", "E")
        if mixed:
            parts = [line[:13], line[13:33], line[33:53]]
        else:
            parts = [line[i : i + width] for i in range(0, len(line), width)]
        found += [float(part) for part in parts if part.strip()]
    return np.array(found)


def _unit(label: str, si: str, default: float) -> float:
    label = label.strip()
    if not label or label.upper() == "NONE":
        return default
    if label in ("g", "G") and si == "m/s^2":
        label = "g_0"
    try:
        return unit_factor(label, si)
    except UnitError as reason:
        raise ValueError(f"unit label: {reason}") from None
