"""Rubber bushings."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from autobalancer.arrays import Matrix
from autobalancer.errors import Problem
from autobalancer.machine.part import Angle, Offset, Quantity, key
from autobalancer.machine.rotors.joint import (
    RUBBER,
    TABLE,
    DamperConstant,
    Elements,
    PointJoint,
    Spot,
    SpringStiffness,
    exclude_beside_rubber,
    exclude_constants,
)
from autobalancer.machine.rotors.support import Rubber, SpeedTable, TiltDamping, TiltStiffness, values_at

Component = Annotated[float, Quantity("")]


class Bushing(PointJoint):
    """One rubber bushing at a ``radius`` from the axis, or ``count`` of them equally spaced, the first at ``angle``.

    ``direction`` is the axis of the bushing by its components outwards, in the sense of rotation, and along the axis of
    the rotor. Shear is across it. ``shear_table`` and ``axial_table`` hold stiffness and damping over the speed,
    ``shear_rubber`` and ``axial_rubber`` rubber that softens with the amplitude.
    """

    kind: Literal["bushing"] = "bushing"
    interface: ClassVar[int] = 1
    radius: Offset = key("of the circle on which the bushings sit", 0.0)
    count: Annotated[int, Field(strict=True, ge=1, le=1000)] = key("equally spaced", 1)
    angle: Angle = key("of the first, from the x axis", 0.0)
    direction: tuple[Component, Component, Component] = key(
        "of the axis of a bushing: outwards, in the sense of rotation, along the axis of the rotor", (0.0, 0.0, 1.0)
    )
    shear_stiffness: SpringStiffness = key("of each, across its axis", 0.0)
    shear_damping: DamperConstant = key("of each, across its axis", 0.0)
    shear_table: SpeedTable | None = key(TABLE, None)
    shear_rubber: Rubber | None = key(RUBBER, None)
    axial_stiffness: SpringStiffness = key("of each, along its axis", 0.0)
    axial_damping: DamperConstant = key("of each, along its axis", 0.0)
    axial_table: SpeedTable | None = key(TABLE, None)
    axial_rubber: Rubber | None = key(RUBBER, None)
    bending_stiffness: TiltStiffness = key("of each, about axes across its own", 0.0)
    bending_damping: TiltDamping = key("of each, about axes across its own", 0.0)
    torsional_stiffness: TiltStiffness = key("of each, about its axis", 0.0)
    torsional_damping: TiltDamping = key("of each, about its axis", 0.0)

    @model_validator(mode="after")
    def _one_way(self) -> Bushing:
        for name in ("shear", "axial"):
            constants = tuple((f"{name}_{what}", getattr(self, f"{name}_{what}")) for what in ("stiffness", "damping"))
            exclude_constants(getattr(self, f"{name}_table"), f"{name}_table", constants)
            table = (f"{name}_table", getattr(self, f"{name}_table"))
            exclude_beside_rubber(getattr(self, f"{name}_rubber"), f"{name}_rubber", (*constants, table))
        springs = (self.shear_stiffness, self.shear_table, self.axial_stiffness, self.axial_table)
        if not any((*springs, self.shear_rubber, self.axial_rubber)):
            raise ValueError(
                "shear_stiffness: missing; give it or 'axial_stiffness', or a table or rubber of one of them"
            )
        if not any(self.direction):
            raise ValueError("direction: given 0, 0, 0; a bushing needs an axis")
        if self.count > 1 and self.radius == 0.0:
            raise ValueError(f"radius: missing; {self.count} bushings sit on a circle")
        return self

    def spots(self) -> tuple[Spot, ...]:
        """One for each; its first axis is that of the bushing, turned with its place."""
        found = []
        for number in range(self.count):
            angle = float(self.angle) + 2.0 * np.pi * number / self.count
            c, s = np.cos(angle), np.sin(angle)
            along = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ (
                np.array(self.direction, float) / np.linalg.norm(self.direction)
            )
            _, _, axes = np.linalg.svd(along[None])  # the axis, and two directions across it
            point = (float(self.radius) * c, float(self.radius) * s, float(self.position))
            found.append(Spot(point, (tuple(along), tuple(axes[1]), tuple(axes[2]))))
        return tuple(found)

    def matrices(self, speed: float) -> tuple[Matrix, Matrix]:
        """Of one bushing, diagonal in its own axes."""
        shear = values_at(self.shear_table, self.shear_stiffness, self.shear_damping, speed, self.shear_rubber)
        axial = values_at(self.axial_table, self.axial_stiffness, self.axial_damping, speed, self.axial_rubber)
        bending = float(self.bending_stiffness), float(self.bending_damping)
        torsion = float(self.torsional_stiffness), float(self.torsional_damping)
        stiffness, damping = (
            np.diag([axial[i][0], shear[i][0], shear[i][0], torsion[i], bending[i], bending[i]]) for i in range(2)
        )
        return stiffness, damping

    def tables(self) -> tuple[SpeedTable | None, ...]:
        """Of shear and along the axis."""
        return self.shear_table, self.axial_table

    def rubbers(self) -> tuple[Elements, ...]:
        """Shear across its own axis, which is the first, and along it."""
        return self._there(((1, 2), self.shear_rubber, "shear"), ((0,), self.axial_rubber, "along its axis"))

    def unfit(self, turning: int) -> list[Problem]:
        """It would be wrung by a rotating body."""
        text = "a bushing connects non-rotating bodies, or one to the ground; use a 'spring' on the axis here"
        return [(("between",), text)] if turning else []
