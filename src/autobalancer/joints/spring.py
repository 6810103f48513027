"""Springs and dampers at a point."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np
from pydantic import model_validator

from autobalancer.arrays import Matrix
from autobalancer.errors import Problem
from autobalancer.machine.part import Damping, Position, Stiffness, key
from autobalancer.machine.rotors.joint import (
    ACROSS,
    ALONG,
    BESIDE,
    HARDENING,
    RUBBER,
    TABLE,
    TILT,
    TURN,
    DamperConstant,
    Elements,
    PointJoint,
    Spot,
    SpringStiffness,
    exclude_beside_rubber,
    exclude_constants,
    unfit_at,
)
from autobalancer.machine.rotors.support import (
    Hardening,
    Rubber,
    SpeedTable,
    TiltDamping,
    TiltStiffness,
    along_x_and_y,
    values_at,
)


class Spring(PointJoint):
    """Springs and dampers at a point, along x and y (one value or a pair), along z, against tilting and turning about z.

    A ``table`` stands for ``stiffness`` and ``damping``, an ``axial_table`` for ``axial_stiffness`` and
    ``axial_damping``. So do ``rubber`` and ``axial_rubber``, which soften with the amplitude.
    """

    kind: Literal["spring"] = "spring"
    interface: ClassVar[int] = 1
    offset: tuple[Position, Position] = key(BESIDE, (0.0, 0.0))
    stiffness: Stiffness | None = key(ACROSS, None)
    damping: Damping = key(ACROSS, 0.0)
    table: SpeedTable | None = key(TABLE, None)
    rubber: Rubber | None = key(RUBBER, None)
    hardening: Hardening | None = key(HARDENING, None)
    axial_stiffness: SpringStiffness = key(ALONG, 0.0)
    axial_damping: DamperConstant = key(ALONG, 0.0)
    axial_table: SpeedTable | None = key(TABLE, None)
    axial_rubber: Rubber | None = key(RUBBER, None)
    tilt_stiffness: TiltStiffness = key(TILT, 0.0)
    tilt_damping: TiltDamping = key(TILT, 0.0)
    torsional_stiffness: TiltStiffness = key(TURN, 0.0)
    torsional_damping: TiltDamping = key(TURN, 0.0)

    @model_validator(mode="after")
    def _one_way(self) -> Spring:
        exclude_constants(self.table, "table", (("stiffness", self.stiffness), ("damping", self.damping)), pairs=True)
        along = (("axial_stiffness", self.axial_stiffness), ("axial_damping", self.axial_damping))
        exclude_constants(self.axial_table, "axial_table", along)
        across = (("stiffness", self.stiffness), ("damping", self.damping), ("table", self.table))
        exclude_beside_rubber(self.rubber, "rubber", across)
        exclude_beside_rubber(self.axial_rubber, "axial_rubber", (*along, ("axial_table", self.axial_table)))
        springs = (
            self.stiffness, self.table, self.rubber, self.axial_stiffness, self.axial_table, self.axial_rubber,
            self.hardening,
        )  # fmt: skip
        if not any((*springs, self.tilt_stiffness, self.torsional_stiffness)):
            raise ValueError("stiffness: missing; give one, or use the kind 'dashpot'")
        return self

    def spots(self) -> tuple[Spot, ...]:
        """Beside the axis, if so described."""
        return (Spot((float(self.offset[0]), float(self.offset[1]), float(self.position))),)

    def matrices(self, speed: float) -> tuple[Matrix, Matrix]:
        """Diagonal."""
        across = values_at(self.table, self.stiffness, self.damping, speed, self.rubber)
        along = values_at(self.axial_table, self.axial_stiffness, self.axial_damping, speed, self.axial_rubber)
        tilting = float(self.tilt_stiffness), float(self.tilt_damping)
        turning = float(self.torsional_stiffness), float(self.torsional_damping)
        stiffness, damping = (np.diag([*across[i], along[i][0], tilting[i], tilting[i], turning[i]]) for i in range(2))
        return stiffness, damping

    def tables(self) -> tuple[SpeedTable | None, ...]:
        """Across and along the axis."""
        return self.table, self.axial_table

    def rubbers(self) -> tuple[Elements, ...]:
        """Across the axis, and along it."""
        return self._there(((0, 1), self.rubber, "across the axis"), ((2,), self.axial_rubber, "along the axis"))

    def hardenings(self) -> tuple[Hardening, ...]:
        """Across the axis."""
        return () if self.hardening is None else (self.hardening,)

    def unfit(self, turning: int) -> list[Problem]:
        """On its axis and without torsion on a rotating body; between two of them undamped and alike along x and y."""
        tabled = self.table.damping if self.table is not None else ()
        damped = any(any(along_x_and_y(entry)) for entry in (self.damping, *tabled)) or self.tilt_damping > 0.0
        found = unfit_at(self, turning, self.offset, damped=damped)
        pairs = (self.stiffness, *(self.table.stiffness if self.table is not None else ()))
        if turning == 2:
            text = "rubber between two rotating bodies rotates with them; this is not modelled, use a stiffness"
            given = ("rubber", self.rubber), ("axial_rubber", self.axial_rubber)
            found += [((name,), text) for name, one in given if one is not None]
        if turning == 2 and not damped and any(isinstance(one, tuple) and one[0] != one[1] for one in pairs):
            text = "between two rotating bodies x and y must be equal, because the joint rotates with them"
            found.append((("stiffness",), text))
        return found
