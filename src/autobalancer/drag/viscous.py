"""Viscous drag with a known damping."""

from __future__ import annotations

from typing import ClassVar, Literal

from autobalancer.machine.balancer.fluid import BallInRace, Drag
from autobalancer.machine.part import AngularDamping, key


class ViscousDrag(Drag):
    """A torque in proportion to the speed of the ball in the race, with a known damping in N m s per ball."""

    law: Literal["viscous"] = "viscous"
    interface: ClassVar[int] = 1
    needs_fluid: ClassVar[bool] = False
    damping: AngularDamping = key("drag torque on one ball over its speed in the rotor", symbol=r"\beta")

    def torque(self, ball: BallInRace) -> float:
        """N m s."""
        return float(self.damping)
