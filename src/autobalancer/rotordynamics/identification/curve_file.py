"""Tables of amplitude against speed with units in their column names."""

from __future__ import annotations

from pathlib import Path

from autobalancer.assembly.rotors.model import Floats
from autobalancer.files.table import read_table


def read_curve(path: Path, unit: str) -> tuple[Floats, Floats]:
    """Speeds (rad/s) and amplitudes (in the SI ``unit``) of a table ``speed [rpm], amplitude [mm]``.

    Raises
    ------
    ResultError
        If the file, a column, a unit or a number is not there or not understood.
    """
    table = read_table(path, "speed [rpm], amplitude [mm]")
    return table.numbers("speed", "rad/s"), table.numbers("amplitude", unit)
