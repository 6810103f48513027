"""Reading the tables of the catalog, and the message for a name that none of them has."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from importlib.resources import files
from typing import NoReturn

from autobalancer.errors import CatalogError
from autobalancer.tables import Table


@cache
def rows(name: str) -> tuple[dict[str, str], ...]:
    """Rows of ``catalog/data/<name>``, column title to text."""
    text = files("autobalancer.catalog").joinpath("data", name).read_text(encoding="utf-8")
    return tuple(csv.DictReader(text.splitlines()))


def key(name: str) -> str:
    """The form in which names are compared: case and spacing do not matter."""
    return " ".join(name.lower().replace("%", " %").split())


def unknown(kind: str, argument: object, names: Iterable[str], hint: str) -> NoReturn:
    """Raise the ``CatalogError`` for a name that is not there, with the names that look like it."""
    by_key = {key(name): name for name in names}
    close = [by_key[match] for match in get_close_matches(key(str(argument)), by_key, n=4, cutoff=0.5)]
    similar = f"similar names: {', '.join(map(repr, close))}" if close else "no name is similar"
    raise CatalogError(f"no {kind} is called {argument!r}; {similar}; {hint}")


# Materials of balls: what counts is their density.


@dataclass(frozen=True)
class Material:
    """A material of balls: ``density`` in kg/m^3, where it comes from and how far it may be off."""

    name: str
    density: float
    source: str
    remark: str = ""


class Materials(Table[Material]):
    """Materials of the catalog, a tuple."""

    head = ("material", "density kg/m³", "source")

    def row(self, entry: Material) -> tuple[str, ...]:
        """Name, density and source."""
        return (entry.name, f"{entry.density:g}", entry.source)


@cache
def materials() -> Materials:
    """All materials of the catalog. Each entry names the source of its density."""
    return Materials(
        Material(row["name"], float(row["density_kg_m3"]), row["source"], row["remark"])
        for row in rows("materials.csv")
    )


def material(name: str) -> Material:
    """One material by its name, upper or lower case. Raises ``CatalogError`` with similar names."""
    material = _by_key().get(key(name))
    if material is None:
        unknown(
            "material",
            name,
            [entry.name for entry in materials()],
            "`autobalancer catalog materials` lists them",
        )
    return material


@cache
def _by_key() -> dict[str, Material]:
    return {key(entry.name): entry for entry in materials()}


# Published coefficients of friction between a ball and its race: what they were found on, and where.


NONE_GIVEN = (
    "no friction given: residuals are those of ideal balls; typical coefficients: autobalancer catalog friction"
)
"""What every answer about a machine without friction says."""


@dataclass(frozen=True)
class FrictionCoefficients:
    """Rolling resistance and adherence of one pair, as in ``friction`` of a race; nan where the source has none.

    ``kind`` says how they were found: measured, fitted, inferred, or an order of magnitude only; ``conditions`` on what.
    """

    name: str
    rolling_resistance: float
    adherence: float
    kind: str
    conditions: str
    source: str
    remark: str = ""


class Frictions(Table[FrictionCoefficients]):
    """Coefficients of friction of the catalog, a tuple."""

    head = ("pair", "rolling resistance", "adherence", "found")

    def row(self, entry: FrictionCoefficients) -> tuple[str, ...]:
        """Name, coefficients, and how they were found."""
        values = (entry.rolling_resistance, entry.adherence)
        return (entry.name, *("-" if math.isnan(value) else f"{value:g}" for value in values), entry.kind)


@cache
def friction() -> Frictions:
    """All coefficients of the catalog, from the smoothest pair to the roughest. They span more than three orders of magnitude."""
    return Frictions(
        FrictionCoefficients(
            name=row["name"],
            rolling_resistance=_number(row["rolling_resistance"]),
            adherence=_number(row["adherence"]),
            kind=row["kind"],
            conditions=row["conditions"],
            source=row["source"],
            remark=row["remark"],
        )
        for row in rows("friction.csv")
    )


def _number(text: str) -> float:
    return float(text) if text else math.nan


# How far off center a race may be: half of the run-out that a standard permits, for bearing rings and for turned
# parts.


RING = "half the run-out that ISO 492, class Normal, permits for a bearing ring of this size"
TURNED = "half the run-out that ISO 2768-2, class H, permits for a turned part"
TURNED_ECCENTRICITY = 50e-6  # m, for parts of any size; checked as the page on typical values says


def ring_eccentricity(diameter: float) -> float:
    """Eccentricity (m) that the permissible radial run-out of an outer ring of this diameter (m) allows.

    Radial bearings of the class Normal, ISO 492; above 800 mm the value of 800 mm. The seat of the ring adds its own.
    """
    table = _table()
    return 0.5 * next((run_out for largest, run_out in table if diameter <= largest), table[-1][1])


@cache
def _table() -> tuple[tuple[float, float], ...]:
    """Largest outside diameter and radial run-out, m; checked as the page on typical values says."""
    return tuple((1e-3 * float(row["up_to_mm"]), 1e-6 * float(row["run_out_um"])) for row in rows("ring_run_out.csv"))
