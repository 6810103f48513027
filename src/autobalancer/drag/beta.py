"""Drag given by its torque."""

from __future__ import annotations

from typing import ClassVar, Literal

from autobalancer.machine.balancer.fluid import BallInRace, Drag
from autobalancer.machine.part import AngularDamping, key


class DragTorque(Drag):
    """beta itself, N m s per ball."""

    law: Literal["beta"] = "beta"
    interface: ClassVar[int] = 1
    needs_fluid: ClassVar[bool] = False
    beta: AngularDamping = key("drag torque on one ball over its speed in the rotor", symbol=r"\beta")

    def torque(self, ball: BallInRace) -> float:
        """N m s."""
        return float(self.beta)
