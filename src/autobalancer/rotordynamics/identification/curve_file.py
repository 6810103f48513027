"""Tables of amplitude against speed with units in their column names."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from autobalancer.assembly.rotors.model import Floats
from autobalancer.errors import ResultError, UnitError
from autobalancer.units import to_si

_NAME = re.compile(r"^\s*\"?\s*([A-Za-z_ ]+?)\s*[\[(](.*)[\])]\s*\"?\s*$")


def read_curve(path: Path, unit: str) -> tuple[Floats, Floats]:
    """Speeds (rad/s) and amplitudes (in the SI ``unit``) of a table ``speed [rpm], amplitude [mm]``.

    Lines that begin with # are comments; columns are parted by comma, semicolon or tab.

    Raises
    ------
    ResultError
        If the file, a column, a unit or a number is not there or not understood.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as reason:
        raise ResultError(f"{path}: cannot be read: {reason}") from None
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    separator = next((mark for mark in (";", "\t", ",") if lines and mark in lines[0]), ",")
    heads = [_NAME.match(cell) for cell in lines[0].split(separator)] if lines else []
    names = [head[1].strip().lower() if head else "" for head in heads]
    if len(lines) < 2 or "speed" not in names or "amplitude" not in names:
        raise ResultError(
            f"{path}: the first line must name the columns with their units, such as: speed [rpm], amplitude [mm]"
        )
    columns = []
    for name, si in (("speed", "rad/s"), ("amplitude", unit)):
        at = names.index(name)
        head = heads[at]
        assert head is not None
        try:
            factor = float(to_si(f"1 {head[2].strip()}", si))
            columns.append(factor * np.array([float(line.split(separator)[at]) for line in lines[1:]]))
        except UnitError as reason:
            raise ResultError(f"{path}: unit of column {name!r}: {reason}") from None
        except (ValueError, IndexError):
            raise ResultError(f"{path}: column {name!r} holds something that is not a number") from None
    return columns[0], columns[1]
