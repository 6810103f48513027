"""Balls, alike ones together."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from autobalancer.machine.part import Listed, Part, key
from autobalancer.machine.quantity import Angle, Density, Length, Mass, Speed

INCOMPLETE = "give two of 'diameter', 'mass' and 'density' (or 'material'); a point ball may have a mass alone"


class Balls(Part):
    """``count`` equal balls that stand side by side in their race.

    Size and mass follow from two of ``diameter``, ``mass`` and ``density`` (or ``material``, a name of the catalog). Balls of
    a race with a ``bearing`` have the diameter of its balls, if nothing but their material is given.
    A ``point`` ball has no spin inertia and may be given by its mass alone; a ``rolling`` ball needs a size.
    ``start_angles`` are the ball angles in the rotor at the start; without them they are drawn at random.
    """

    count: Annotated[int, Field(strict=True, ge=1, le=1000)] = key("balls of this group", 1, symbol="n")
    diameter: Length | None = key(
        "with two of diameter, mass and density (or material) the third follows", None, symbol="d"
    )
    mass: Mass | None = key(
        "of one ball, in air; with two of diameter, mass and density (or material) the third follows", None, symbol="m"
    )
    density: Density | None = key("with two of diameter, mass and density (or material) the third follows", None)
    material: str | None = key("a name of the catalog, instead of a density", None)
    motion: Literal["rolling", "point"] = key(
        "`rolling` without slip, with the inertia of a solid ball; `point`: no spin, no size needed", "rolling"
    )
    start_angles: Annotated[tuple[Angle, ...], Listed] | None = key(
        "in the rotor, one for each ball; without them drawn at random with the seed of the run", None
    )
    start_speeds: Annotated[tuple[Speed, ...], Listed] | None = key(
        "in the rotor, one for each ball; without them at rest in the rotor", None
    )

    @model_validator(mode="after")
    def _determined(self) -> Balls:
        if self.density is not None and self.material is not None:
            raise ValueError("give 'density' or 'material', not both")
        stuff = self.density is not None or self.material is not None
        given = (self.diameter is not None) + (self.mass is not None) + stuff
        if given == 3:
            raise ValueError("diameter, mass and density (or material) are all given; leave one out")
        if given < 2 and not stuff and not (self.motion == "point" and self.mass is not None):
            raise ValueError(INCOMPLETE)
        for name, values in (("start_angles", self.start_angles), ("start_speeds", self.start_speeds)):
            if values is not None and len(values) != self.count:
                raise ValueError(f"{name}: given {len(values)} values for {self.count} balls; give one for each ball")
        return self

    @property
    def unsized(self) -> bool:
        """Whether only the material is known, so that the size is that of the bearing."""
        return self.diameter is None and self.mass is None
