"""A rolling bearing."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from autobalancer.arrays import Matrix
from autobalancer.errors import Problem
from autobalancer.machine.part import Damping, Stiffness, key
from autobalancer.machine.rotors.joint import ACROSS, ALONG, HARDENING, DamperConstant, PointJoint, SpringStiffness
from autobalancer.machine.rotors.support import Hardening, along_x_and_y


class BallBearing(PointJoint):
    """A bearing on the axis, between a rotating body and a standing one or the ground; it lets the axis tilt."""

    kind: Literal["bearing"] = "bearing"
    interface: ClassVar[int] = 1
    stiffness: Stiffness = key(ACROSS)
    damping: Damping = key(ACROSS, 0.0)
    hardening: Hardening | None = key(HARDENING, None)
    axial_stiffness: SpringStiffness = key(ALONG, 0.0)
    axial_damping: DamperConstant = key(ALONG, 0.0)

    def matrices(self, speed: float) -> tuple[Matrix, Matrix]:
        """Diagonal, nothing against tilting."""
        stiffness = [*along_x_and_y(self.stiffness), float(self.axial_stiffness)]
        damping = [*along_x_and_y(self.damping), float(self.axial_damping)]
        return np.diag([*stiffness, 0.0, 0.0, 0.0]), np.diag([*damping, 0.0, 0.0, 0.0])

    def hardenings(self) -> tuple[Hardening, ...]:
        """Across the axis."""
        return () if self.hardening is None else (self.hardening,)

    def unfit(self, turning: int) -> list[Problem]:
        """One ring turns, the other does not."""
        if turning == 1:
            return []
        which = "both turn" if turning else "none of them turns"
        return [(("between",), f"a bearing connects a rotating body and a non-rotating one; {which}")]
