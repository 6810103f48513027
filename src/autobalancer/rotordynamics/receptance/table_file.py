"""Tables of a frequency response with units in their column names."""

from __future__ import annotations

import re

import numpy as np
import xarray as xr

from autobalancer.errors import ResultError, UnitError
from autobalancer.rotordynamics.receptance.measured import receptance_dataset
from autobalancer.units import to_si

KINDS = {"receptance": "m/N", "mobility": "m/s/N", "accelerance": "m/s^2/N"}
_NAME = re.compile(r"^\s*\"?\s*([A-Za-z_ ]+?)\s*[\[(](.*)[\])]\s*\"?\s*$")
_WORDS = {
    "frequency": ("frequency", "freq", "f"),
    "real": ("real", "re", "real part"),
    "imag": ("imag", "im", "imaginary", "imag part", "imaginary part"),
    "amplitude": ("amplitude", "magnitude", "abs", "mag"),
    "phase": ("phase", "angle"),
    "coherence": ("coherence", "coh"),
}


def read_table(lines: list[str], name: str) -> xr.Dataset:
    """The receptance in a table; comment lines start with #, columns are parted by comma, semicolon or tab.

    Raises
    ------
    ResultError
        If a column, a unit or a number is not there or not understood.
    """
    body = [
        (number, line) for number, line in enumerate(lines, 1) if line.strip() and not line.lstrip().startswith("#")
    ]
    if len(body) < 2:
        raise ResultError(f"{name}: no table; the first line must name the columns, each with its unit in brackets")
    separator = next((mark for mark in (";", "\t", ",") if mark in body[0][1]), ",")
    columns = _columns(body[0][1].split(separator), name)
    rows = np.array([_row(line, separator, name, number, len(columns)) for number, line in body[1:]])
    at = {word: i for i, (word, _) in enumerate(columns) if word}
    for needed in ("frequency", *(("amplitude", "phase") if "amplitude" in at else ("real", "imag"))):
        if needed not in at:
            raise ResultError(
                f"{name}: no column {needed!r}; the columns must be frequency and real, imag (or amplitude, phase), "
                "such as: frequency [Hz], real [m/N], imag [m/N]"
            )
    frequency = rows[:, at["frequency"]] * _factor(columns[at["frequency"]][1], "rad/s", name, "frequency")
    first, second = ("amplitude", "phase") if "amplitude" in at else ("real", "imag")
    kind, factor = _kind(columns[at[first]][1], name)
    one, other = rows[:, at[first]], rows[:, at[second]]
    if first == "amplitude":
        angle = _factor(columns[at["phase"]][1], "rad", name, "phase") * other
        one, other = one * np.cos(angle), one * np.sin(angle)
    elif _kind(columns[at[second]][1], name) != (kind, factor):
        raise ResultError(f"{name}: real and imaginary part have different units")
    coherence = rows[:, at["coherence"]] if "coherence" in at else None
    return receptance_dataset(frequency, factor * (one + 1j * other), kind, title=name, coherence=coherence)


_EXAMPLES = {"frequency": "Hz", "phase": "deg"}


def _columns(cells: list[str], name: str) -> list[tuple[str, str]]:
    found = []
    for cell in cells:
        match = _NAME.match(cell)
        words, unit = (match[1], match[2]) if match else (cell.strip().strip('"'), "")
        word = next((key for key, names in _WORDS.items() if words.strip().lower() in names), "")
        if word and word != "coherence" and not unit:
            raise ResultError(
                f"{name}: column {words!r} has no unit; write it in brackets, such as {words} [{_EXAMPLES.get(word, 'm/N')}]"
            )
        found.append((word, unit.strip()))
    return found


def _row(line: str, separator: str, name: str, number: int, count: int) -> list[float]:
    cells = line.split(separator)
    try:
        values = [float(cell.replace(",", ".") if separator == ";" else cell) for cell in cells if cell.strip()]
    except ValueError:
        raise ResultError(f"{name}, line {number}: {line.strip()!r} contains something that is not a number") from None
    if len(values) != count:
        raise ResultError(f"{name}, line {number}: {len(values)} numbers for {count} columns")
    return values


def unit_factor(unit: str, si: str) -> float:
    """How many ``si`` one ``unit`` is; m/s2 and m/s² are understood, too."""
    plain = re.sub(r"(?<=[A-Za-z])(\d)", r"^\1", unit.replace("²", "2"))
    return float(to_si(f"1 {plain}", si))


def _factor(unit: str, si: str, name: str, column: str) -> float:
    try:
        return unit_factor(unit, si)
    except UnitError as reason:
        raise ResultError(f"{name}: unit of column {column!r}: {reason}") from None


def _kind(unit: str, name: str) -> tuple[str, float]:
    for kind, si in KINDS.items():
        try:
            return kind, unit_factor(unit, si)
        except UnitError:
            continue
    raise ResultError(
        f"{name}: {unit!r} is not a unit of a frequency response; give deflection, velocity or acceleration over force, "
        "such as m/N, mm/s/N, m/s^2/N or g_0/N"
    )
