"""What joins the bodies of a rig to each other and to the ground."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from autobalancer.machine.part import Part, key
from autobalancer.machine.quantity import Angle, Damping, Offset, Position, Quantity, Stiffness
from autobalancer.machine.rotors.body import GROUND
from autobalancer.machine.rotors.support import SpeedTable, TiltDamping, TiltStiffness

SpringStiffness = Annotated[float, Quantity("N/m", non_negative=True)]
DamperConstant = Annotated[float, Quantity("N*s/m", non_negative=True)]
Component = Annotated[float, Quantity("")]

BESIDE = "along x and y, beside the axis; only if no body of the joint rotates"
TABLE = "over the speed, in place of the two constants"
TILT = "against tilting"
TURN = "against rotation about the axis"
ALONG = "along the axis"
ACROSS = "across the axis"


class BodyJoint(Part):
    """Joins the two bodies named in ``between``; the one may be ``"ground"``."""

    between: tuple[str, str] = key("names of two bodies, or of one and `ground`")

    @model_validator(mode="after")
    def _two_bodies(self) -> BodyJoint:
        if self.between[0] == self.between[1]:
            raise ValueError(f"between: given {self.between[0]!r} twice; give two bodies, or a body and {GROUND!r}")
        return self


class Lock(BodyJoint):
    """Merges two bodies into one, exactly; between a standing and a rotating body all but the turning is locked."""

    kind: Literal["lock"] = "lock"


class Dashpot(BodyJoint):
    """A damper at a point: across the axis (one value, or a pair along x and y), along it, against tilting and turning."""

    kind: Literal["dashpot"] = "dashpot"
    position: Position = key(ALONG)
    offset: tuple[Position, Position] = key(BESIDE, (0.0, 0.0))
    damping: Damping = key(ACROSS, 0.0)
    axial_damping: DamperConstant = key(ALONG, 0.0)
    tilt_damping: TiltDamping = key(TILT, 0.0)
    torsional_damping: TiltDamping = key(TURN, 0.0)


class Spring(BodyJoint):
    """Springs and dampers at a point, along x and y (one value or a pair), along z, against tilting and turning about z.

    A ``table`` stands for ``stiffness`` and ``damping``, an ``axial_table`` for ``axial_stiffness`` and
    ``axial_damping``.
    """

    kind: Literal["spring"] = "spring"
    position: Position = key(ALONG)
    offset: tuple[Position, Position] = key(BESIDE, (0.0, 0.0))
    stiffness: Stiffness | None = key(ACROSS, None)
    damping: Damping = key(ACROSS, 0.0)
    table: SpeedTable | None = key(TABLE, None)
    axial_stiffness: SpringStiffness = key(ALONG, 0.0)
    axial_damping: DamperConstant = key(ALONG, 0.0)
    axial_table: SpeedTable | None = key(TABLE, None)
    tilt_stiffness: TiltStiffness = key(TILT, 0.0)
    tilt_damping: TiltDamping = key(TILT, 0.0)
    torsional_stiffness: TiltStiffness = key(TURN, 0.0)
    torsional_damping: TiltDamping = key(TURN, 0.0)

    @model_validator(mode="after")
    def _one_way(self) -> Spring:
        one_of(self.table, "table", (("stiffness", self.stiffness), ("damping", self.damping)), pairs=True)
        along = (("axial_stiffness", self.axial_stiffness), ("axial_damping", self.axial_damping))
        one_of(self.axial_table, "axial_table", along)
        springs = (self.stiffness, self.table, self.axial_stiffness, self.axial_table)
        if not any((*springs, self.tilt_stiffness, self.torsional_stiffness)):
            raise ValueError("stiffness: missing; give one, or use the kind 'dashpot'")
        return self


class BallBearing(BodyJoint):
    """A bearing on the axis, between a rotating body and a standing one or the ground; it lets the axis tilt."""

    kind: Literal["bearing"] = "bearing"
    position: Position = key(ALONG)
    stiffness: Stiffness = key(ACROSS)
    damping: Damping = key(ACROSS, 0.0)
    axial_stiffness: SpringStiffness = key(ALONG, 0.0)
    axial_damping: DamperConstant = key(ALONG, 0.0)


class Bushing(BodyJoint):
    """One rubber bushing at a ``radius`` from the axis, or ``count`` of them equally spaced, the first at ``angle``.

    ``direction`` is the axis of the bushing by its components outwards, in the sense of rotation, and along the axis of
    the rotor. Shear is across it. ``shear_table`` and ``axial_table`` hold stiffness and damping over the speed.
    """

    kind: Literal["bushing"] = "bushing"
    position: Position = key(ALONG)
    radius: Offset = key("of the circle on which the bushings sit", 0.0)
    count: Annotated[int, Field(strict=True, ge=1, le=1000)] = key("equally spaced", 1)
    angle: Angle = key("of the first, from the x axis", 0.0)
    direction: tuple[Component, Component, Component] = key(
        "of the axis of a bushing: outwards, in the sense of rotation, along the axis of the rotor", (0.0, 0.0, 1.0)
    )
    shear_stiffness: SpringStiffness = key("of each, across its axis", 0.0)
    shear_damping: DamperConstant = key("of each, across its axis", 0.0)
    shear_table: SpeedTable | None = key(TABLE, None)
    axial_stiffness: SpringStiffness = key("of each, along its axis", 0.0)
    axial_damping: DamperConstant = key("of each, along its axis", 0.0)
    axial_table: SpeedTable | None = key(TABLE, None)
    bending_stiffness: TiltStiffness = key("of each, about axes across its own", 0.0)
    bending_damping: TiltDamping = key("of each, about axes across its own", 0.0)
    torsional_stiffness: TiltStiffness = key("of each, about its axis", 0.0)
    torsional_damping: TiltDamping = key("of each, about its axis", 0.0)

    @model_validator(mode="after")
    def _one_way(self) -> Bushing:
        for name in ("shear", "axial"):
            constants = tuple((f"{name}_{what}", getattr(self, f"{name}_{what}")) for what in ("stiffness", "damping"))
            one_of(getattr(self, f"{name}_table"), f"{name}_table", constants)
        if not any((self.shear_stiffness, self.shear_table, self.axial_stiffness, self.axial_table)):
            raise ValueError("shear_stiffness: missing; give it or 'axial_stiffness', or a table of one of them")
        if not any(self.direction):
            raise ValueError("direction: given 0, 0, 0; a bushing needs an axis")
        if self.count > 1 and self.radius == 0.0:
            raise ValueError(f"radius: missing; {self.count} bushings sit on a circle")
        return self


def one_of(table: SpeedTable | None, name: str, constants: tuple[tuple[str, object], ...], pairs: bool = False) -> None:
    """Refuse a table beside the constants it stands for, and pairs along x and y where there is one direction only."""
    if table is None:
        return
    for other, value in constants:
        if value:
            raise ValueError(f"{other}: '{name}' contains it already; give one or the other")
    if not pairs and any(isinstance(entry, tuple) for entry in (*table.stiffness, *table.damping)):
        raise ValueError(f"{name}: given a pair; this direction has one value at each speed")


PointJoint = Dashpot | Spring | BallBearing | Bushing
Joint = Annotated[Lock | Dashpot | Spring | BallBearing | Bushing, Field(discriminator="kind")]
