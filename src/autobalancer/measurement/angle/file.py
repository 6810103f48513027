"""Measured equilibrium angles from a table, several fluids in one."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from autobalancer.catalog.fluid_families import ROOM
from autobalancer.catalog.fluid_table import fluid
from autobalancer.errors import CatalogError, ResultError
from autobalancer.files.table import Table, read_table
from autobalancer.measurement.angle.statics import Floats, TurnedRace
from autobalancer.safe_file import as_path

EXAMPLE = "fluid, density [kg/m^3], viscosity [mm^2/s], speed [rpm], angle [deg]"


@dataclass(frozen=True)
class AngleSeries:
    """Speeds (rad/s) and angles from the lowest point (rad) in one fluid, kg/m^3 and m^2/s; no fluid is that of the machine."""

    name: str
    speeds: Floats
    angles: Floats
    fluid_density: float = 0.0
    viscosity: float = 0.0

    def race(self, race: TurnedRace) -> TurnedRace:
        """The ball and its race in this fluid."""
        return replace(race, fluid_density=self.fluid_density, viscosity=self.viscosity) if self.viscosity else race


def load_angle_series(path: str | Path) -> list[AngleSeries]:
    """Read a table of measured equilibrium angles.

    Parameters
    ----------
    path
        A table with the columns ``speed`` and ``angle``. Rows in the same fluid are one series. It is described by the
        columns ``density`` and ``viscosity``, and perhaps named by ``fluid``; else it is that of the catalog with this name,
        at the ``temperature`` of the row or 25 degC. Without any of these columns it is the fluid of the machine.

    Returns
    -------
    list
        Series in the order in which they begin.

    Raises
    ------
    ResultError
        If the file, a column, a unit or a number is missing or cannot be read, or a fluid is unknown or ambiguous.
    """
    table = read_table(as_path(path), EXAMPLE)
    speeds, angles = table.numbers("speed", "rad/s"), table.numbers("angle", "rad")
    described = [name for name in ("density", "viscosity") if name in table.heads]
    if len(described) == 1:
        raise ResultError(
            f"{table.place}: column {described[0]!r} alone describes no fluid; give density and viscosity"
        )
    if "fluid" not in table.heads and not described:
        return [AngleSeries("fluid of the machine", speeds, angles)]
    densities, viscosities = _fluids(table) if not described else (
        table.numbers("density", "kg/m^3"), table.numbers("viscosity", "m^2/s")
    )  # fmt: skip
    for column, what in ((densities, "density"), (viscosities, "viscosity")):
        if not (column > 0.0).all():
            raise ResultError(f"{table.place}: column {what!r} holds {column.min():g}; it must be above zero")
    names = table.texts("fluid") if "fluid" in table.heads else ["fluid"] * speeds.size
    keys = list(zip(names, densities.tolist(), viscosities.tolist(), strict=True))
    found = []
    for key in dict.fromkeys(keys):
        rows = np.flatnonzero([other == key for other in keys])
        alone = sum(key[0] == name for name, *_ in dict.fromkeys(keys)) == 1
        name = key[0] if alone else f"{key[0]}, {1e6 * key[2]:.4g} mm^2/s"
        found.append(AngleSeries(name, speeds[rows], angles[rows], key[1], key[2]))
    return found


def _fluids(table: Table) -> tuple[Floats, Floats]:
    names = table.texts("fluid")
    warm = table.numbers("temperature", "K") if "temperature" in table.heads else np.full(len(names), ROOM)
    try:
        states = [fluid(name, float(kelvin)) for name, kelvin in zip(names, warm, strict=True)]
    except CatalogError as error:
        raise ResultError(
            f"{table.place}: column 'fluid': {error}; or describe the fluid by the columns density [kg/m^3] and "
            "viscosity [mm^2/s]"
        ) from None
    return np.array([state.density for state in states]), np.array([state.viscosity for state in states])
