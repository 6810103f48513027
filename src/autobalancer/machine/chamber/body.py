"""What carries the chambers: body, supports, rotor, unbalances."""

from __future__ import annotations

from cmath import rect
from typing import Annotated, Literal

from pydantic import model_validator

from autobalancer.machine.chamber.triple import Damping3, Inertia3, Place3, Stiffness3
from autobalancer.machine.part import Part, key
from autobalancer.machine.quantity import (
    Angle,
    AngularDamping,
    Inertia,
    Length,
    Mass,
    Offset,
    Position,
    Quantity,
    Ratio,
    UnbalanceMoment,
)


class ChamberSupport(Part):
    """A spring and a damper between body and ground, at ``position`` from the middle of the rotor at rest."""

    position: Place3 = key("from the middle of the rotor")
    stiffness: Stiffness3 = key("along x, y and z")
    damping: Damping3 = key("along x, y and z", (0.0, 0.0, 0.0))


class ChamberBody(Part):
    """The body that carries rotor and motor.

    ``freedom``: ``fixed``; ``planar`` with the motion y, z and the rotation about x (Pakuła 2021, section 2); ``free`` with
    all six coordinates, small rotations. ``mass``, principal ``inertia`` about its own mass center and the ``center`` itself,
    from the middle of the rotor, are those without the rotor.
    """

    freedom: Literal["fixed", "planar", "free"] = key(
        "`fixed`; `planar`: y, z and the rotation about x; `free`: all six coordinates"
    )
    mass: Mass | None = key("without the rotor; required unless `fixed`", None)
    inertia: Inertia3 | None = key("about its own mass center, along x, y and z; required unless `fixed`", None)
    center: Place3 = key("its mass center, from the middle of the rotor", (0.0, 0.0, 0.0))

    @model_validator(mode="after")
    def _movable(self) -> ChamberBody:
        if self.freedom != "fixed" and (self.mass is None or self.inertia is None):
            raise ValueError(f"give 'mass' and 'inertia'; a body whose freedom is {self.freedom!r} needs both")
        return self


class ChamberRotor(Part):
    """Shaft and chambers, without balls; its inertias are about its middle, the mass of unbalances included.

    ``bearings`` are their positions along x, the second one guides along the axis. ``bearing_friction`` is the coefficient
    mu_t of Pakuła (2021), (4), at half the ``neck_diameter``; ``damping`` a torque over the speed relative to the body.
    """

    mass: Mass = key("without balls, with the unbalance masses")
    polar_inertia: Inertia = key("about x")
    transverse_inertia: Inertia = key("about y and z, through its middle; at least half of the polar one")
    bearings: tuple[Annotated[float, Quantity("m")], Annotated[float, Quantity("m")]] = key(
        "positions along x; the second one guides along the axis"
    )
    neck_diameter: Offset = key("at which bearing friction acts", 0.0)
    bearing_friction: Ratio = key(r"coefficient $\mu_t$ of Pakuła (2021), (4)", 0.0)
    damping: AngularDamping = key("braking torque over the speed relative to the body", 0.0)

    @model_validator(mode="after")
    def _apart(self) -> ChamberRotor:
        if self.bearings[0] == self.bearings[1]:
            raise ValueError(f"bearings: both at {self.bearings[0]:g} m; give two different positions along x")
        if self.transverse_inertia < 0.5 * self.polar_inertia:
            raise ValueError(
                f"transverse_inertia: given {self.transverse_inertia:g} kg m2; no body has less than half its polar inertia, "
                f"{0.5 * self.polar_inertia:g} kg m2"
            )
        return self


class ChamberUnbalance(Part):
    """A point unbalance at ``position`` along x; its ``angle`` counts from y to z at rotor angle 0."""

    moment: UnbalanceMoment | None = key("mass times radius; instead of `mass` and `radius`", None)
    mass: Mass | None = key("a part of the mass of the rotor, not in addition to it", None)
    radius: Length | None = key("distance of this mass from the axis", None)
    angle: Angle = key("from y towards z at rotor angle zero", 0.0)
    position: Position = key("along x", 0.0)

    @model_validator(mode="after")
    def _one_way(self) -> ChamberUnbalance:
        if (self.moment is None) == (self.mass is None) or (self.mass is None) != (self.radius is None):
            raise ValueError("give either 'moment', or 'mass' and 'radius'")
        return self

    @property
    def size(self) -> float:
        """kg m."""
        return float(self.moment) if self.moment is not None else float(self.mass or 0.0) * float(self.radius or 0.0)

    @property
    def vector(self) -> complex:
        """As a vector in the rotor with the real part along y and the imaginary part along z, kg m."""
        return rect(self.size, self.angle)
