"""Balls, or rollers or pendulums in their place, alike ones together."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from autobalancer.machine.balancer.bodies import check_pendulum, check_roller, refuse_keys
from autobalancer.machine.part import Listed, Part, key
from autobalancer.machine.quantity import Angle, Density, Length, Mass, MassInertia, Speed

INCOMPLETE = "give two of 'diameter', 'mass' and 'density' (or 'material'); a point ball may have a mass alone"


class Balls(Part):
    """``count`` equal balls, rollers or pendulums that stand side by side in their race.

    Size and mass follow from two of ``diameter``, ``mass`` and ``density`` (or ``material``, a name of the catalog). Balls of
    a race with a ``bearing`` have the diameter of its balls, if nothing but their material is given.
    A ``point`` ball has no spin inertia and may be given by its mass alone; a ``rolling`` ball needs a size.

    A ``roller`` is a cylinder that rolls on the race, solid or with a bore: it has a ``diameter``, and its mass follows from
    ``length`` and density unless it is given. A ``pendulum`` is a ``mass`` that turns on a bearing about the center of the
    race, with the orbit radius to its center of mass and the ``inertia`` about that; the friction of the race is then that
    of its bearing, at ``bearing_radius``. Pendulums pass each other, unless they have the ``diameter`` of a round head.

    ``start_angles`` are the ball angles in the rotor at the start; without them they are drawn at random.
    """

    count: Annotated[int, Field(strict=True, ge=1, le=1000)] = key("balls of this group", 1, symbol="n")
    body: Literal["ball", "roller", "pendulum"] = key(
        "`ball`; `roller`: a cylinder or ring that rolls on the race; `pendulum`: a mass that turns on a bearing about the "
        "center of the race",
        "ball",
    )
    diameter: Length | None = key(
        "with two of diameter, mass and density (or material) the third follows; of a pendulum that of its round head",
        None,
        symbol="d",
    )
    mass: Mass | None = key(
        "of one ball, in air; with two of diameter, mass and density (or material) the third follows", None, symbol="m"
    )
    density: Density | None = key("with two of diameter, mass and density (or material) the third follows", None)
    material: str | None = key("a name of the catalog, instead of a density", None)
    length: Length | None = key(
        "of a roller, along the shaft; with two of mass, length and density (or material) the third follows", None
    )
    inner_diameter: Length | None = key("of the bore of a roller; without it the roller is solid", None)
    inertia: MassInertia | None = key(
        "of a pendulum, about its own center of mass; 0 for a point mass", None, symbol="J_c"
    )
    bearing_radius: Length | None = key("of a pendulum: where its bearing rubs, if the race has `friction`", None)
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
        refuse_keys(self)
        if self.density is not None and self.material is not None:
            raise ValueError("give 'density' or 'material', not both")
        {"ball": _check_ball, "roller": check_roller, "pendulum": check_pendulum}[self.body](self)
        for name, values in (("start_angles", self.start_angles), ("start_speeds", self.start_speeds)):
            if values is not None and len(values) != self.count:
                raise ValueError(f"{name}: given {len(values)} values for {self.count} balls; give one for each ball")
        return self

    @property
    def rolls(self) -> bool:
        """Whether these roll on the race, so that they spin against it."""
        return self.body != "pendulum" and self.motion == "rolling"

    @property
    def unsized(self) -> bool:
        """Whether only the material is known, so that the size is that of the bearing."""
        return self.diameter is None and self.mass is None


def _check_ball(group: Balls) -> None:
    stuff = group.density is not None or group.material is not None
    given = (group.diameter is not None) + (group.mass is not None) + stuff
    if given == 3:
        raise ValueError("diameter, mass and density (or material) are all given; leave one out")
    if given < 2 and not stuff and not (group.motion == "point" and group.mass is not None):
        raise ValueError(INCOMPLETE)
