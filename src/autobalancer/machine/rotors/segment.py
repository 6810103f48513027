"""A cylindrical piece of a shaft, and what it is made of."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import Field, model_validator

from autobalancer.machine.part import Part, key
from autobalancer.machine.quantity import Density, Length, Offset, Positive, Quantity

Modulus = Annotated[float, Quantity("Pa", positive=True)]
PoissonRatio = Annotated[float, Quantity("", non_negative=True)]


class ShaftMaterial(Part):
    """What a shaft is made of; either ``shear_modulus`` or ``poisson_ratio``, which gives the other."""

    density: Density = key("of the shaft", symbol=r"\rho")
    youngs_modulus: Modulus = key("Young's modulus", symbol="E")
    shear_modulus: Modulus | None = key("either this or Poisson's ratio", None, symbol="G")
    poisson_ratio: PoissonRatio | None = key("either this or the shear modulus", None, symbol=r"\nu")

    @model_validator(mode="after")
    def _one_way(self) -> ShaftMaterial:
        if (self.shear_modulus is None) == (self.poisson_ratio is None):
            raise ValueError("give either 'shear_modulus' or 'poisson_ratio'")
        if not -1e-9 <= self.poisson < 0.5 + 1e-9:
            where = "poisson_ratio" if self.shear_modulus is None else "shear_modulus"
            raise ValueError(f"{where}: gives a Poisson ratio of {self.poisson:g}; it must be from 0 to 0.5")
        return self

    @property
    def poisson(self) -> float:
        """Poisson's ratio, as given or E/(2 G) - 1."""
        if self.poisson_ratio is not None:
            return float(self.poisson_ratio)
        return float(self.youngs_modulus) / (2.0 * float(self.shear_modulus or 0.0)) - 1.0

    @property
    def shear(self) -> float:
        """Shear modulus, Pa, as given or E/(2 (1 + nu))."""
        if self.shear_modulus is not None:
            return float(self.shear_modulus)
        return float(self.youngs_modulus) / (2.0 * (1.0 + float(self.poisson_ratio or 0.0)))


class ShaftSegment(Part):
    """A cylinder, hollow if it has an ``inner_diameter``, cut into equal ``elements``.

    ``shear_coefficient`` is the share of the section that carries shear; by default that of Cowper (1966).
    """

    length: Length = key("along the axis")
    diameter: Length = key("outer diameter")
    inner_diameter: Offset = key("of the bore", 0.0)
    elements: Annotated[int, Field(strict=True, ge=1, le=1000)] = key(
        "equal pieces into which it is cut; disks and supports cut it further", 4
    )
    material: ShaftMaterial | None = key("in place of that of the rotor", None)
    shear_coefficient: Positive | None = key(
        "share of the section that carries shear; by default that of Cowper (1966)", None
    )

    @model_validator(mode="after")
    def _hollow(self) -> ShaftSegment:
        if self.inner_diameter >= self.diameter:
            raise ValueError(
                f"inner_diameter: given {self.inner_diameter:g} m; must be smaller than the diameter, {self.diameter:g} m"
            )
        return self

    @property
    def area(self) -> float:
        """Of the section, m^2."""
        return 0.25 * math.pi * (float(self.diameter) ** 2 - float(self.inner_diameter) ** 2)

    @property
    def second_moment(self) -> float:
        """Of the area about a diameter, m^4."""
        return math.pi / 64.0 * (float(self.diameter) ** 4 - float(self.inner_diameter) ** 4)

    @property
    def volume(self) -> float:
        """m^3."""
        return self.area * float(self.length)
