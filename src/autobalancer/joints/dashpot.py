"""Dampers at a point."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np

from autobalancer.arrays import Matrix
from autobalancer.errors import Problem
from autobalancer.machine.part import Damping, Position, key
from autobalancer.machine.rotors.joint import (
    ACROSS,
    ALONG,
    BESIDE,
    TILT,
    TURN,
    DamperConstant,
    PointJoint,
    Spot,
    unfit_at,
)
from autobalancer.machine.rotors.support import TiltDamping, along_x_and_y


class Dashpot(PointJoint):
    """A damper at a point: across the axis (one value, or a pair along x and y), along it, against tilting and turning."""

    kind: Literal["dashpot"] = "dashpot"
    interface: ClassVar[int] = 1
    offset: tuple[Position, Position] = key(BESIDE, (0.0, 0.0))
    damping: Damping = key(ACROSS, 0.0)
    axial_damping: DamperConstant = key(ALONG, 0.0)
    tilt_damping: TiltDamping = key(TILT, 0.0)
    torsional_damping: TiltDamping = key(TURN, 0.0)

    def spots(self) -> tuple[Spot, ...]:
        """Beside the axis, if so described."""
        return (Spot((float(self.offset[0]), float(self.offset[1]), float(self.position))),)

    def matrices(self, speed: float) -> tuple[Matrix, Matrix]:
        """No stiffness."""
        across, tilting = along_x_and_y(self.damping), float(self.tilt_damping)
        values = [*across, float(self.axial_damping), tilting, tilting, float(self.torsional_damping)]
        return np.zeros((6, 6)), np.diag(values)

    def unfit(self, turning: int) -> list[Problem]:
        """On its axis, without torsion, and no dashpot at all between two rotating bodies."""
        return unfit_at(self, turning, self.offset, damped=any(along_x_and_y(self.damping)) or self.tilt_damping > 0.0)
