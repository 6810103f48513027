"""A chamber and what is in it."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from autobalancer.machine.chamber.triple import Place3, Triple
from autobalancer.machine.part import Listed, Part, key
from autobalancer.machine.quantity import Density, Length, Mass, Offset, Position, Quantity

Drag = Annotated[float, Quantity("N*s/m", non_negative=True)]
MOST = 2e6  # balls whose volume is that of the chamber; places for all of them are worked out
DynamicViscosity = Annotated[float, Quantity("Pa*s", positive=True)]
SquareDrag = Annotated[float, Quantity("N*s^2/m^2", non_negative=True)]
Velocity3 = Annotated[Triple, Quantity("m/s", shape="three")]
Spin3 = Annotated[Triple, Quantity("rad/s", shape="three")]


class FreeBalls(Part):
    """Equal balls, or cylinders. Their size comes from ``diameter``, from the ``mass`` of one, or the ``total_mass`` of all.

    A ``cylinder`` has a ``length`` too, and stays parallel to the rotor: it moves in all directions and turns about its own
    axis, but does not tilt.

    Without ``positions`` (from the middle of the chamber) they are filled in and settle before the run starts.
    """

    count: Annotated[int, Field(strict=True, ge=1, le=100_000)] = key("balls of this group")
    body: Literal["ball", "cylinder"] = key("`ball`; `cylinder`: with its axis always parallel to the rotor", "ball")
    density: Density = key("of the balls")
    length: Length | None = key("of a cylinder", None)
    diameter: Length | None = key("one of `diameter`, `mass` and `total_mass`", None)
    mass: Mass | None = key("of one ball; one of `diameter`, `mass` and `total_mass`", None)
    total_mass: Mass | None = key("of all balls of the group; one of `diameter`, `mass` and `total_mass`", None)
    positions: tuple[Place3, ...] | None = key(
        "one for each ball, from the middle of the chamber; by default balls are filled in and settle", None
    )
    velocities: tuple[Velocity3, ...] | None = key("in space, one for each ball; with `positions`", None)
    spins: tuple[Spin3, ...] | None = key("in space, one for each ball; with `positions`", None)

    @model_validator(mode="after")
    def _one_size(self) -> FreeBalls:
        if (self.body == "cylinder") != (self.length is not None):
            raise ValueError(
                "length: missing; a cylinder needs it"
                if self.length is None
                else "length: a ball has none; leave it out, or set body = 'cylinder'"
            )
        if sum(entry is not None for entry in (self.diameter, self.mass, self.total_mass)) != 1:
            raise ValueError("give one of 'diameter', 'mass' (of one ball) and 'total_mass' (of all)")
        for name in ("positions", "velocities", "spins"):
            given = getattr(self, name)
            if given is not None and len(given) != self.count:
                raise ValueError(f"{name}: given {len(given)} for {self.count} balls; give one for each")
        if self.positions is None and (self.velocities is not None or self.spins is not None):
            raise ValueError("positions: missing; balls with velocities or spins need them")
        if self.body == "cylinder" and any(spin[1] or spin[2] for spin in self.spins or ()):
            raise ValueError("spins: a cylinder stays parallel to the rotor and turns about x only; give y and z as 0")
        return self

    @property
    def ball_mass(self) -> float:
        """kg."""
        if self.diameter is not None and self.length is not None:
            return float(self.density) * math.pi / 4.0 * float(self.diameter) ** 2 * float(self.length)
        if self.diameter is not None:
            return float(self.density) * math.pi / 6.0 * float(self.diameter) ** 3
        return float(self.mass) if self.mass is not None else float(self.total_mass or 0.0) / self.count

    @property
    def radius(self) -> float:
        """m."""
        if self.length is not None:
            return math.sqrt(self.ball_mass / (math.pi * float(self.density) * float(self.length)))
        return float((0.75 * self.ball_mass / (math.pi * float(self.density))) ** (1.0 / 3.0))

    @property
    def half_width(self) -> float:
        """Half of what it takes along the rotor, m."""
        return 0.5 * float(self.length) if self.length is not None else self.radius

    @property
    def spin_inertia(self) -> float:
        """About the own axis, kg m²."""
        return (0.5 if self.length is not None else 0.4) * self.ball_mass * self.radius**2

    @property
    def tilt_inertia(self) -> float:
        """Of a cylinder across its axis, kg m²; a ball has none that the rotor turns with it."""
        if self.length is None:
            return 0.0
        return self.ball_mass * (self.radius**2 / 4.0 + float(self.length) ** 2 / 12.0)


class Chamber(Part):
    """A cylinder on the rotor with flat walls, its middle at ``position`` along x; a ring with an ``inner_radius``.

    ``drag`` and ``square_drag`` are the force of a fluid that turns with the chamber, over the speed of a ball in it and over
    the square of that speed. A ``depth`` left out is that of one layer: the largest ball and 1 % more.
    """

    radius: Length = key("of the wall")
    inner_radius: Offset = key("of a wall inside, which makes a ring; by default there is none", 0.0)
    depth: Length | None = key(
        "between the flat walls; if left out, one layer of balls: the largest diameter (length of a cylinder) and 1 % more",
        None,
    )
    position: Position = key("of its middle, along x", 0.0)
    drag: Drag = key("force of a fluid that turns with the chamber, over the speed of a ball in it", 0.0)
    square_drag: SquareDrag = key("the same over the square of that speed", 0.0)
    viscosity: DynamicViscosity | None = key(
        "dynamic, of the fluid between balls that meet: for `rebound.critical_stokes` of the contact, which needs it",
        None,
    )
    balls: Annotated[tuple[FreeBalls, ...], Field(min_length=1), Listed] = key("groups of equal balls")

    @model_validator(mode="after")
    def _fits(self) -> Chamber:
        for number, balls in enumerate(self.balls, 1):
            place = f"balls[{number}]"
            gap = self.radius - self.inner_radius
            if self.inner_radius > 0.0 and 2.0 * balls.radius > gap * (1.0 + 1e-12):
                raise ValueError(
                    f"{place}: their diameter is {2e3 * balls.radius:.4g} mm; the ring is only {1e3 * gap:.4g} mm wide, from "
                    f"inner_radius to radius"
                )
            if balls.radius >= self.radius:
                raise ValueError(
                    f"{place}: their diameter is {2e3 * balls.radius:.4g} mm; "
                    f"the chamber is only {2e3 * self.radius:.4g} mm wide"
                )
            if 2.0 * balls.half_width > self.inner_depth * (1.0 + 1e-12):
                size = "diameter" if balls.length is None else "length"
                raise ValueError(
                    f"{place}: their {size} is {2e3 * balls.half_width:.4g} mm; "
                    f"the chamber is only {1e3 * self.inner_depth:.4g} mm deep"
                )
            area = self.radius**2 - self.inner_radius**2
            if area * self.inner_depth > 4.0 / 3.0 * balls.radius**2 * balls.half_width * MOST:
                raise ValueError(
                    f"{place}: their diameter is {2e3 * balls.radius:.4g} mm; more than {MOST:.0e} of them would fill the "
                    f"chamber; take larger balls or a smaller chamber"
                )
        return self

    @property
    def inner_depth(self) -> float:
        """m."""
        return float(self.depth) if self.depth is not None else 2.02 * max(balls.half_width for balls in self.balls)
