"""A race and the balancer that holds one or several of them in one plane."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from autobalancer.machine.balancer.balls import INCOMPLETE, Balls
from autobalancer.machine.balancer.bodies import refuse_bodies
from autobalancer.machine.balancer.contact import Contact, Friction, Harmonic, Partitions, Roundness
from autobalancer.machine.balancer.drag import Drag
from autobalancer.machine.balancer.fluid import Fluid
from autobalancer.machine.balancer.force import Force
from autobalancer.machine.balancer.resolved import ResolvedContact
from autobalancer.machine.leaves import OneOf
from autobalancer.machine.part import ImpossiblePart, Label, Listed, Name, Part, key
from autobalancer.machine.quantity import Angle, Length, Offset
from autobalancer.machine.station import Place


class Race(Part):
    """A circular race with balls.

    Give ``orbit_radius`` (of the ball centers), for unequal balls ``race_radius`` (of the wall they run on), or the ``bearing``
    of the catalog whose outer ring it is: it has the orbit radius, and the diameter of balls that have none of their own.
    ``eccentricity`` is the distance of the race center from the rotor's axis, in the direction ``eccentricity_angle``
    of the rotor. ``width`` and ``height`` of the chamber, if given, must hold the balls.

    Balls that meet touch and keep their order: without ``contact`` they rebound with 14 % of their
    speed, as critical damping makes them. ``coincidence`` lets them pass
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
    fluid: Fluid | None = key("required by all drag laws except `beta`", None)
    drag: Annotated[Drag, OneOf(Drag)] = key("law of the drag of the fluid on the balls")
    slipstream: bool = key(
        "`true`: a ball close behind another feels less drag; needs a `fluid` and balls of one known size", False
    )
    friction: Friction | None = key("dry friction between balls and race; without it there is none", None)
    contact: Contact | None = key("how balls rebound from each other; by default with 14 % of their speed", None)
    coincidence: bool = key("`true`: balls pass through each other, and several may rest at one place", False)
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
            told = f"{INCOMPLETE}; or name the 'bearing' of the race, whose balls they are"
            raise ImpossiblePart("Race", [(("balls", i), told) for i in unsized])
        if self.fluid is None and self.drag.needs_fluid:
            raise ValueError(f"drag: the law {self.drag.word()!r} needs a fluid; add 'fluid', or use the law 'beta'")
        if self.coincidence and self.contact is not None:
            raise ValueError("coincidence: balls that pass through each other have no 'contact'; leave one out")
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
                "as 'cd_re'"
            )
        if shear.at_ball is None:
            raise ValueError(
                "fluid.shear.at_ball: missing; the drag needs the effective rate of shear at a ball over its velocity divided "
                "by its diameter; give a guess, such as 0.5, and the command sheared-drag finds a better value"
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
