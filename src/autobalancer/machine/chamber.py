"""Machines whose balls move freely in deep chambers."""

from __future__ import annotations

import math
from cmath import rect
from typing import Annotated, Literal

from pydantic import Field, model_validator

from autobalancer.machine.drive import AsynchronousMotor, PrescribedSpeed
from autobalancer.machine.keys import document
from autobalancer.machine.machine import RunPlan
from autobalancer.machine.part import (
    Angle,
    AngularDamping,
    Density,
    Inertia,
    Length,
    Listed,
    Mass,
    Name,
    Offset,
    Part,
    PoissonRatio,
    Position,
    Positive,
    Quantity,
    Ratio,
    Speed,
    UnbalanceMoment,
    key,
)
from autobalancer.machine.rebound import Rebound
from autobalancer.notebook import picture_html
from autobalancer.tables import html_table

# Quantities along the three axes: x along the rotor, y and z across it.


Triple = tuple[float, float, float]
Place3 = Annotated[Triple, Quantity("m", shape="three")]
Stiffness3 = Annotated[Triple, Quantity("N/m", non_negative=True, shape="three")]
Damping3 = Annotated[Triple, Quantity("N*s/m", non_negative=True, shape="three")]
Inertia3 = Annotated[Triple, Quantity("kg*m^2", positive=True, shape="three")]
Acceleration3 = Annotated[Triple, Quantity("m/s^2", shape="three")]


# A chamber and what is in it.


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


# What carries the chambers: body, supports, rotor, unbalances.


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


# How balls touch each other and the walls.


Fraction = Annotated[float, Quantity("", positive=True, most=1.0)]
Coefficient = Annotated[float, Quantity("", non_negative=True, most=5.0)]
Modulus = Annotated[float, Quantity("Pa", positive=True)]
HertzStiffness = Annotated[float, Quantity("N/m^1.5", positive=True)]
SlipSpeed = Annotated[float, Quantity("m/s", positive=True)]


class _Elastic(Part):
    """Stiffness k of F = k d^1.5: one for all contacts, or by Hertz from the material of balls and walls."""

    stiffness: HertzStiffness | None = key("$k$ in $k d^{3/2}$ of all contacts; this or `youngs_modulus`", None)
    youngs_modulus: Modulus | None = key(
        "of balls and walls: stiffness by Hertz for each pair; this or `stiffness`", None
    )
    poisson_ratio: PoissonRatio = key("of balls and walls; only with `youngs_modulus`", 0.3)
    restitution: Fraction = key("speed after over speed before")
    rebound: Rebound | None = key(
        "how restitution falls with the speed of impacts and in a fluid; without it it is constant", None
    )
    friction: Coefficient = key("coefficient of sliding friction, of all contacts unless `ball_friction` is given")
    ball_friction: Coefficient | None = key("the same of balls on balls; by default that of the walls", None)
    rolling_arm: Offset = key("$f$: rolling resistance is a moment $f F$ against the relative spin", 0.0)
    slip_speed: SlipSpeed = key("sliding speed below which friction falls to zero in proportion", 1e-3)

    @model_validator(mode="after")
    def _one_stiffness(self) -> _Elastic:
        if (self.stiffness is None) == (self.youngs_modulus is None):
            raise ValueError("give either 'stiffness' (of all contacts) or 'youngs_modulus'")
        return self


class RestitutionContact(_Elastic):
    """Pakuła (2021): k d^1.5 in approach, R^2 k d^1.5 in separation, R that of the impact; sliding friction at all times.

    ``slip_speed`` is the sliding speed below which friction falls to zero in proportion.
    """

    law: Literal["restitution"] = "restitution"


class HistoryContact(_Elastic):
    """Hertz with viscous damping (Tsuji et al. 1992) and a tangential spring that remembers, so that balls can stick.

    ``shear_ratio`` is the tangential over the normal stiffness; by default that of Mindlin, 2 (1 - nu)/(2 - nu).
    """

    law: Literal["history"] = "history"
    shear_ratio: Positive | None = key(
        r"tangential over normal stiffness; without it that of Mindlin, $2(1-\nu)/(2-\nu)$", None
    )


ChamberContact = Annotated[RestitutionContact | HistoryContact, Field(discriminator="law")]


# The machine with deep chambers.


# What turns the rotor of a machine with deep chambers.


ChamberDrive = Annotated[PrescribedSpeed | AsynchronousMotor, Field(discriminator="kind")]


class ChamberStart(Part):
    """Rotor at time zero."""

    rotor_angle: Angle = key("at time zero", 0.0)
    speed: Speed = key("of the rotor, only where a torque drives", 0.0)


class ChamberMachine(Part):
    """A rotor with chambers in which balls move freely, on a body on supports.

    x points along the rotor; displacements are counted from the rest position of the machine without balls. ``gravity`` is
    a vector.
    """

    name: Name = key("name of the machine, in titles of pictures and results")
    description: str = key("source and purpose", "")
    gravity: Acceleration3 = key("along x (the rotor), y and z (up, for a horizontal rotor)", (0.0, 0.0, -9.80665))
    body: ChamberBody = key("what carries rotor and motor")
    supports: Annotated[tuple[ChamberSupport, ...], Listed] = key(
        "springs and dampers between body and ground; a `fixed` body needs none", ()
    )
    rotor: ChamberRotor = key("shaft and chambers, without balls")
    unbalances: Annotated[tuple[ChamberUnbalance, ...], Listed] = key(
        "of the rotor; two opposite ones at different places are a couple", ()
    )
    chambers: Annotated[tuple[Chamber, ...], Field(min_length=1), Listed] = key("one or several on the rotor")
    contact: ChamberContact = key("of balls with each other and with walls")
    drive: ChamberDrive = key("what turns the rotor")
    start: ChamberStart = Field(default_factory=ChamberStart, description="rotor at time zero")
    run: RunPlan | None = key("default duration of a run", None)

    def _repr_html_(self) -> str:
        count = sum(group.count for chamber in self.chambers for group in chamber.balls)
        rows = [
            ("body", self.body.freedom),
            ("balls", f"{count} in {len(self.chambers)} deep chamber{'s' * (len(self.chambers) != 1)}"),
            ("unbalances", str(len(self.unbalances))),
            ("drive", self.drive.kind),
            ("run", "no duration" if self.run is None else f"{float(self.run.duration):g} s"),
            ("description", self.description or "none"),
        ]
        return html_table(("", ""), rows, self.name) + picture_html(self, f"drawing of {self.name}", "machine")

    @model_validator(mode="after")
    def _consistent(self) -> ChamberMachine:
        if getattr(self.drive, "couplings", ()):
            raise ValueError("drive.couplings: the rotor of a deep chamber has none; leave them out")
        if isinstance(self.drive, PrescribedSpeed) and self.start.speed != 0.0:
            raise ValueError("start.speed: the drive prescribes the speed; leave it out")
        _check_cylinders(self.chambers, self.contact)
        rebound = self.contact.rebound
        wet = rebound is not None and rebound.critical_stokes is not None
        for number, chamber in enumerate(self.chambers, 1):
            if wet and chamber.viscosity is None:
                raise ValueError(f"chambers[{number}].viscosity: missing; contact.rebound.critical_stokes needs it")
            if chamber.viscosity is not None and not wet:
                raise ValueError(
                    f"chambers[{number}].viscosity: has no effect without contact.rebound.critical_stokes; give that too, or "
                    "leave it out (the drag of the fluid is 'drag' and 'square_drag')"
                )
        total = sum(unbalance.size for unbalance in self.unbalances)
        if total**2 >= self.rotor.mass * self.rotor.polar_inertia:
            raise ValueError(
                f"unbalances: together {total:g} kg m; more than mass and polar inertia of the rotor can carry"
            )
        return self


def _check_cylinders(chambers: tuple[Chamber, ...], contact: ChamberContact) -> None:
    """Refuse what cylinders do not know."""
    bodies = {balls.body for chamber in chambers for balls in chamber.balls}
    if bodies == {"ball"}:
        return
    if len(bodies) > 1:
        raise ValueError("chambers: have balls and cylinders; a machine has the one or the other")
    if contact.law != "restitution":
        raise ValueError("contact.law: given 'history'; cylinders know 'restitution' only")
    if contact.stiffness is not None:
        raise ValueError(
            "contact.stiffness: is that of balls, k in k d^1.5; the contacts of cylinders are along lines: give youngs_modulus"
        )
    if contact.rebound is not None:
        raise ValueError("contact.rebound: is known for balls only; give cylinders a constant restitution")


document(ChamberMachine)
