"""Materials of balls: what counts is their density."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from autobalancer.catalog.tables import key, rows, unknown
from autobalancer.shown import Table


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
    found = _by_key().get(key(name))
    if found is None:
        unknown(
            "material",
            name,
            [entry.name for entry in materials()],
            "`autobalancer catalog materials` lists them",
        )
    return found


@cache
def _by_key() -> dict[str, Material]:
    return {key(entry.name): entry for entry in materials()}
