"""A race and the balancer that holds one or several of them in one plane."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from autobalancer.errors import MachineError
from autobalancer.machine.balancer.fluid import Drag, Fluid
from autobalancer.machine.balancer.force import Force
from autobalancer.machine.balancer.resolved import Contact, Friction, Harmonic, Partitions, ResolvedContact, Roundness
from autobalancer.machine.part import (
    Angle,
    Density,
    Label,
    Length,
    Listed,
    Mass,
    MassInertia,
    Name,
    Offset,
    Part,
    Speed,
    key,
)
from autobalancer.machine.plugins import OneOf
from autobalancer.machine.rotors.body import Place

# Balls, or rollers or pendulums in their place, alike ones together.


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


# Which keys fit which body of a race: balls, rollers, pendulums.


ROLLER = "a roller needs its 'diameter', and 'mass' or two of 'mass', 'length' and 'density' (or 'material')"
PENDULUM = (
    "a pendulum needs its 'mass' and 'inertia', the moment of inertia about its own center of mass (0 for a point mass)"
)
ONLY = {
    "motion": ("ball",),
    "density": ("ball", "roller"),
    "material": ("ball", "roller"),
    "length": ("roller",),
    "inner_diameter": ("roller",),
    "inertia": ("pendulum",),
    "bearing_radius": ("pendulum",),
}
"""The bodies to which a key of a group belongs; keys that are not here belong to all."""


def refuse_keys(group: Any) -> None:
    """Refuse keys of another body.

    Raises
    ------
    ValueError
        With the key, what it is for, and what to do.
    """
    for name, bodies in ONLY.items():
        if name in group.model_fields_set and getattr(group, name) is not None and group.body not in bodies:
            owners = " and ".join(f"{body}s" for body in bodies)
            raise ValueError(
                f"{name}: a key of {owners}, but this is a group of {group.body}s; leave it out, or change 'body'"
            )


def check_roller(group: Any) -> None:
    """Refuse a roller whose size or mass is not determined, or is so twice."""
    stuff = group.density is not None or group.material is not None
    given = (group.mass is not None) + (group.length is not None) + stuff
    if group.diameter is None or (given < 2 and group.mass is None):
        raise ValueError(ROLLER)
    if given == 3:
        raise ValueError("mass, length and density (or material) are all given; leave one out")
    if group.inner_diameter is not None and group.inner_diameter >= group.diameter:
        raise ValueError(
            f"inner_diameter: given {1e3 * group.inner_diameter:.4g} mm; must be smaller than the diameter, "
            f"{1e3 * group.diameter:.4g} mm"
        )


def check_pendulum(group: Any) -> None:
    """Refuse a pendulum without mass or inertia."""
    if group.mass is None or group.inertia is None:
        raise ValueError(PENDULUM)


def refuse_bodies(race: Any) -> None:
    """Refuse rollers and pendulums in a race that does not fit them.

    Raises
    ------
    ValueError
        With the key, the reason, and what to do.
    """
    bodies = {group.body for group in race.balls}
    if bodies == {"ball"}:
        return
    others = " and ".join(f"{body}s" for body in ("roller", "pendulum") if body in bodies)
    if race.drag.law != "viscous":
        raise ValueError(
            f"drag: the law {race.drag.law!r} is that of spheres; for {others} give the damping, with the law 'viscous'"
        )
    if race.slipstream:
        raise ValueError(f"slipstream: known of balls only, and this race has {others}; leave it out")
    if race.bearing is not None:
        raise ValueError(f"bearing: its groove is made for balls, and this race has {others}; give 'orbit_radius'")
    if "roller" in bodies:
        _refuse_rollers(race)
    if "pendulum" in bodies:
        if len(bodies) > 1:
            raise ValueError("balls: pendulums share no race with others; give them a race of their own")
        _refuse_pendulums(race)


def _refuse_rollers(race: Any) -> None:
    if race.fluid is not None:
        if "virtual_mass" not in race.fluid.model_fields_set:
            raise ValueError("fluid.virtual_mass: missing; its default, 2, is that of balls, and this race has rollers")
        for group in race.balls:
            if group.body == "roller" and group.inner_diameter is not None:
                raise ValueError("fluid: how it moves with a hollow roller is not known; leave 'inner_diameter' out")
            if group.body == "roller" and group.length is None and group.density is None and group.material is None:
                raise ValueError("fluid: it carries part of a roller whose size is known; give its 'length'")
    if race.resolved is not None and race.resolved.reduced_modulus is not None:
        raise ValueError(
            "resolved.reduced_modulus: the contact of spheres (Hertz), and this race has rollers; give 'stiffness'"
        )


def _refuse_pendulums(race: Any) -> None:
    reasons = {
        "race_radius": "a pendulum runs on no wall; give 'orbit_radius', from the pivot to its center of mass",
        "resolved": "a pendulum is guided by its bearing; leave it out",
        "harmonics": "the path of a pendulum is a circle; leave it out",
        "roundness": "the path of a pendulum is a circle; leave it out",
        "fluid": "a pendulum does not know what it displaces; leave it out and give the drag by the law 'viscous'",
    }
    for name, reason in reasons.items():
        if getattr(race, name):
            raise ValueError(f"{name}: {reason}")
    if race.friction is not None and race.friction.rolling_law is not None:
        raise ValueError("friction.rolling_law: a pendulum slides in its bearing; leave it out")
    if race.friction is not None and any(group.bearing_radius is None for group in race.balls):
        raise ValueError("balls.bearing_radius: missing; the friction of a pendulum acts at the radius of its bearing")
    for group in race.balls:
        if None not in (group.bearing_radius, race.orbit_radius) and group.bearing_radius >= race.orbit_radius:
            raise ValueError(
                f"balls.bearing_radius: given {1e3 * group.bearing_radius:.4g} mm; must be smaller than the orbit radius, "
                f"{1e3 * race.orbit_radius:.4g} mm"
            )


class Race(Part):
    """A circular race with balls.

    Give ``orbit_radius`` (of the ball centers), for unequal balls ``race_radius`` (of the wall they run on), or the ``bearing``
    of the catalog whose outer ring it is: it has the orbit radius, and the diameter of balls that have none of their own.
    ``eccentricity`` is the distance of the race center from the rotor's axis, in the direction ``eccentricity_angle``
    of the rotor. ``width`` and ``height`` of the chamber, if given, must hold the balls.

    Balls that meet touch and keep their order: without ``contact`` they rebound with 14 % of their
    speed, as critical damping makes them. ``collisions = false`` lets them pass
    through each other, as many models in the literature do; balls of unknown size always do. ``harmonics`` or a measured
    ``roundness`` are deviations of the orbit from its circle. In a ``slipstream`` each ball feels less drag behind the next one
    ahead of it. With ``resolved`` the balls are not guided along the race but
    free in its plane, between the outer wall and, if ``width`` is given, the inner one.
    """

    bearing: Name | None = key(
        "of the catalog, such as `16021`, whose outer ring it is: gives `orbit_radius`, and the diameter of balls "
        "of which only the material is given",
        None,
    )
    orbit_radius: Length | None = key(
        "of the ball centers; this, `race_radius` or a `bearing`", None, symbol=r"\varepsilon"
    )
    race_radius: Length | None = key(
        "of the wall on which the balls run, larger by a ball radius; for balls of unequal size", None
    )
    eccentricity: Offset = key("distance of the center of the race from the shaft", 0.0, symbol="E")
    eccentricity_angle: Angle = key("direction of this center in the rotor", 0.0)
    width: Length | None = key(
        "of the chamber, along the radius; must hold the balls. Used by `resolved` balls and lagging fluid", None
    )
    height: Length | None = key("of the chamber, along the shaft; must hold the balls. Used by lagging fluid", None)
    fluid: Fluid | None = key("required by all drag laws except `viscous`", None)
    drag: Annotated[Drag, OneOf(Drag)] = key("law of the drag of the fluid on the balls")
    slipstream: bool = key(
        "`true`: a ball close behind another feels less drag; needs a `fluid` and balls of one known size",
        False,
        known="basin",
    )
    friction: Friction | None = key("dry friction between balls and race; without it there is none", None)
    contact: Contact | None = key("how balls rebound from each other; by default with 14 % of their speed", None)
    collisions: bool = key("`false`: balls pass through each other, and several may rest at one place", True)
    partitions: Partitions | None = key(
        "thin walls across the race; collisions with them are like those between balls", None
    )
    harmonics: Annotated[tuple[Harmonic, ...], Listed] = key(
        "deviation of the orbit from its circle, wave by wave; this or `roundness`", ()
    )
    roundness: Roundness | None = key("the same as a measured profile", None)
    resolved: ResolvedContact | None = key(
        "balls free in the plane of the race, in place of guided ones; for all races of a machine or for none", None
    )
    forces: Annotated[tuple[Annotated[Force, OneOf(Force)], ...], Listed] = key(
        "on the balls beside contact and fluid: springs, magnets, pins, or forces of your own", ()
    )
    balls: Annotated[tuple[Balls, ...], Field(min_length=1)] = key(
        "groups of equal balls; they are placed in the race in this order"
    )

    @model_validator(mode="after")
    def _bodies(self) -> Race:
        refuse_bodies(self)
        return self

    @model_validator(mode="after")
    def _complete(self) -> Race:
        radii = (self.orbit_radius is not None) + (self.race_radius is not None)
        if radii > 1 or (radii == 0 and self.bearing is None):
            raise ValueError(
                "give either 'orbit_radius' (ball centers) or 'race_radius' (wall), or the 'bearing' of the catalog "
                "whose ring it is"
            )
        unsized = [i for i, group in enumerate(self.balls) if group.unsized]
        if unsized and self.bearing is None:
            message = f"{INCOMPLETE}; or name the 'bearing' of the race, whose balls they are"
            raise MachineError.of("Race", [(("balls", i), message) for i in unsized])
        if self.fluid is None and self.drag.needs_fluid:
            raise ValueError(f"drag: the law {self.drag.word()!r} needs a fluid; add 'fluid', or use the law 'viscous'")
        if not self.collisions and self.contact is not None:
            raise ValueError("collisions: balls that pass through each other have no 'contact'; leave one out")
        if self.harmonics and self.roundness is not None:
            raise ValueError("roundness: give either 'harmonics' or a measured 'roundness', not both")
        if self.slipstream and self.fluid is None:
            raise ValueError("slipstream: needs the viscosity of a fluid; add 'fluid', or leave it out")
        return self

    @model_validator(mode="after")
    def _sheared(self) -> Race:
        shear = None if self.fluid is None else self.fluid.shear
        if shear is None:
            return self
        if not self.drag.needs_fluid:
            raise ValueError(
                f"fluid.shear: the drag law {self.drag.word()!r} gives the torque without the viscosity; take another one, such "
                "as 'cd_times_re'"
            )
        if shear.at_ball is None:
            raise ValueError(
                "fluid.shear.at_ball: missing; the drag needs the effective rate of shear at a ball over its velocity divided "
                "by its diameter; give a guess, such as 0.5; the example plot_sheared_drag computes it for a race"
            )
        if self.slipstream:
            raise ValueError("slipstream: known for fluids of constant viscosity only; leave it or 'fluid.shear' out")
        return self

    @model_validator(mode="after")
    def _wet(self) -> Race:
        for name, part in (("contact", self.contact), ("resolved", self.resolved)):
            if part is None or part.rebound is None or part.rebound.critical_stokes is None:
                continue
            where = f"{name}.rebound.critical_stokes"
            if self.fluid is None:
                raise ValueError(f"{where}: needs the viscosity of a fluid; add 'fluid', or leave it out")
            if self.fluid.shear is not None:
                raise ValueError(f"{where}: known for fluids of constant viscosity only; leave it or 'fluid.shear' out")
            if any(group.body != "ball" for group in self.balls):
                raise ValueError(f"{where}: is known for balls only, not for rollers or pendulums; leave it out")
        return self

    @model_validator(mode="after")
    def _rubbing(self) -> Race:
        if self.contact is None or self.contact.friction == 0.0:
            return self
        if self.resolved is not None:
            raise ValueError(
                "contact.friction: applies to guided balls; for 'resolved' balls use resolved.ball_friction"
            )
        if not all(group.rolls for group in self.balls):
            raise ValueError(
                "contact.friction: only rolling balls and rollers rub on each other; set motion = 'rolling'"
            )
        return self

    @model_validator(mode="after")
    def _resolvable(self) -> Race:
        if self.resolved is None:
            return self
        if any(group.motion == "point" for group in self.balls):
            raise ValueError("resolved: resolved balls can spin; set motion = 'rolling' and give their size")
        if self.friction is not None and self.friction.rolling_law is not None:
            raise ValueError("friction.rolling_law: applies to guided balls; for these use resolved.friction_law")
        rests = self.friction is not None and self.friction.holding > 0.0
        if rests and self.resolved.rest_speed is None:
            raise ValueError("resolved.rest_speed: missing; rolling resistance and adherence need it")
        return self

    @property
    def ball_count(self) -> int:
        """Balls in this race."""
        return sum(group.count for group in self.balls)


class Balancer(Part):
    """One or several races in one plane of the rotor.

    ``station`` is where on the axis: a position, or the name of one of the machine's stations; needless on a planar rotor.
    """

    name: Label = key("used in messages, results and pictures", "")
    station: Place | None = key(
        "where on the axis: a position, or the name of a station; not needed on a planar rotor", None
    )
    races: Annotated[tuple[Race, ...], Field(min_length=1)] = key("all in one plane of the rotor")
