"""Measured signals from tables with units in their column names."""

from __future__ import annotations

from pathlib import Path

from autobalancer.errors import ResultError, UnitError
from autobalancer.files.table import read_table
from autobalancer.measurement.signals.form import UNITS, Channel, signals
from autobalancer.results.answers.signals import Signals
from autobalancer.units import to_si

EXAMPLE = "time [s], x [um], y [um], tacho [V]"


def read_signal_table(path: Path) -> Signals:
    """The channels of a table.

    Raises
    ------
    ResultError
        If a column or unit is not there or not understood.
    """
    table = read_table(path, EXAMPLE)
    time = table.numbers("time", "s")
    channels = {}
    for name, (_, unit) in table.heads.items():
        if name == "time":
            continue
        quantity, si = quantity_of(name, unit, table.place)
        direction = name[-1] if name[-1:] in ("x", "y", "z") and not name[-2:-1].isalpha() else ""
        channels[name.replace(" ", "_")] = Channel(table.numbers(name, si), quantity, direction=direction)
    return Signals.of(signals(time, channels, origin=path.name))


def quantity_of(name: str, unit: str, place: str) -> tuple[str, str]:
    """Quantity and SI unit of a column, from its unit; a voltage called tacho, encoder or trigger is that of a tacho.

    Raises
    ------
    ResultError
        If the unit is none of a quantity that is measured.
    """
    for quantity, (si, *_) in UNITS.items():
        try:
            to_si(f"1 {unit}", si)
        except UnitError:
            continue
        marks = any(word in name.lower() for word in ("tacho", "encoder", "trigger", "mark", "keyphasor"))
        return (
            "tacho" if quantity in ("tacho", "voltage") and marks else "voltage" if quantity == "tacho" else quantity
        ), si
    raise ResultError(
        f"{place}: unit {unit!r} of column {name!r}; give that of a {', '.join(UNITS)}, such as um, mm/s, m/s^2, N, V"
    )
