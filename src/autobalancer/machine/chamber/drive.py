"""The asynchronous motor."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from autobalancer.machine.drive import PrescribedSpeed
from autobalancer.machine.part import Part, key
from autobalancer.machine.quantity import Positive, Speed, Torque


class AsynchronousMotor(Part):
    """Torque over speed by the formula of Kloss, Pakuła (2021), (5).

    ``overload`` is breakdown over rated torque; the breakdown torque acts at ``synchronous_speed`` less
    ``breakdown_slip`` times it.
    """

    kind: Literal["asynchronous"] = "asynchronous"
    rated_torque: Torque = key("at rated speed")
    overload: Positive = key("breakdown over rated torque")
    synchronous_speed: Speed = key("where the motor has no torque")
    breakdown_slip: Positive = key("of the breakdown torque, over the synchronous speed; less than 1")

    @model_validator(mode="after")
    def _slips(self) -> AsynchronousMotor:
        if self.breakdown_slip >= 1.0:
            raise ValueError(f"breakdown_slip: given {self.breakdown_slip:g}; must be less than 1")
        return self


ChamberDrive = Annotated[PrescribedSpeed | AsynchronousMotor, Field(discriminator="kind")]
