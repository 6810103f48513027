"""Balls, alike ones together."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from autobalancer.machine.part import Angle, Density, Length, Listed, Mass, Part, Speed

INCOMPLETE = "give two of 'diameter', 'mass' and 'density' (or 'material'); a point ball may have a mass alone"


class Balls(Part):
    """``count`` equal balls that stand side by side in their race.

    Size and mass follow from two of ``diameter``, ``mass`` and ``density`` (or ``material``, a name of the catalog). Balls of
    a race with a ``bearing`` have the diameter of its balls, if nothing but their material is given.
    A ``point`` ball has no spin inertia and may be given by its mass alone; a ``rolling`` ball needs a size.
    ``start_angles`` are the ball angles in the rotor at the start; without them they are drawn at random.
    """

    count: Annotated[int, Field(strict=True, ge=1, le=1000)] = 1
    diameter: Length | None = None
    mass: Mass | None = None
    density: Density | None = None
    material: str | None = None
    motion: Literal["rolling", "point"] = "rolling"
    start_angles: Annotated[tuple[Angle, ...], Listed] | None = None
    start_speeds: Annotated[tuple[Speed, ...], Listed] | None = None

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
        for key, values in (("start_angles", self.start_angles), ("start_speeds", self.start_speeds)):
            if values is not None and len(values) != self.count:
                raise ValueError(f"{key}: given {len(values)} values for {self.count} balls; give one for each ball")
        return self

    @property
    def unsized(self) -> bool:
        """Whether only the material is known, so that the size is that of the bearing."""
        return self.diameter is None and self.mass is None
