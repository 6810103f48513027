"""What may fill a race of a design: a fluid of the catalog, or a blend of two, at any temperature."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

from autobalancer.catalog.fluid_table import blend, catalog_name, fluid
from autobalancer.errors import CatalogError, QuestionError
from autobalancer.laws.viscosity import blend_viscosity


@dataclass(frozen=True)
class Filling:
    """A fluid by its name, or a blend: ``share`` of ``first`` by mass in ``second``, chosen for a viscosity at 25 °C."""

    name: str
    second: str = ""
    share: float = 1.0

    @property
    def label(self) -> str:
        """As people say it."""
        if not self.second:
            return self.name
        return f"{100.0 * self.share:.3g} % {self.name} in {self.second}"

    def at(self, temperature: float) -> tuple[float, float]:
        """Density (kg/m^3) and kinematic viscosity (m^2/s) at a temperature (K).

        Raises
        ------
        CatalogError
            If the catalog does not know it at this temperature.
        """
        return _at(self, float(temperature))

    def keys(self, temperature: float) -> dict[str, Any]:
        """Keys of a machine file that describe it."""
        if not self.second:
            return {"name": self.name, "temperature": temperature}
        density, viscosity = self.at(temperature)
        return {"density": density, "viscosity": viscosity}


def blended(first: str, second: str, viscosity: float) -> Filling:
    """The blend that has a kinematic viscosity (m^2/s) at 25 °C.

    Raises
    ------
    QuestionError, CatalogError
        If a fluid is unknown, or the viscosity does not lie between those of the two.
    """
    found = blend(first, second, viscosity)
    return Filling(found.first, found.second, found.fraction)


@cache
def _at(filling: Filling, temperature: float) -> tuple[float, float]:
    one = fluid(filling.name, temperature)
    if not filling.second:
        return one.density, one.viscosity
    two, w = fluid(filling.second, temperature), filling.share
    density = 1.0 / (w / one.density + (1.0 - w) / two.density)
    return density, float(blend_viscosity(w, (one.viscosity, one.density), (two.viscosity, two.density)))


def known_fluid(where: str, name: str) -> str:
    """A name of the catalog as the catalog writes it.

    Raises
    ------
    QuestionError
        If the catalog has no such fluid.
    """
    try:
        return catalog_name(name)
    except CatalogError as error:
        raise QuestionError(f"{where}: {error}") from None
