"""What turns the rotor: a prescribed speed, or a torque against an external damping torque."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from autobalancer.machine.part import Listed, Part, key
from autobalancer.machine.profile import Profile
from autobalancer.machine.quantity import AngularDamping, Speed, Torque


class PrescribedSpeed(Part):
    """The speed follows the profile whatever the balls do."""

    kind: Literal["speed"] = "speed"
    profile: Profile = key("speed over time")


class ConstantTorque(Part):
    """A constant torque less ``damping`` times the speed."""

    kind: Literal["torque"] = "torque"
    torque: Torque = key("on the rotor")
    damping: AngularDamping = key("braking torque over speed", 0.0)


class TargetTorque(Part):
    """``gain`` times a target speed less ``damping`` times the speed (Spannan 2021, section 4.1.1)."""

    kind: Literal["target_torque"] = "target_torque"
    profile: Profile = key("target speed over time")
    gain: AngularDamping = key("driving torque over target speed")
    damping: AngularDamping = key(
        "braking torque over speed; if equal to the gain, the rotor approaches the target", 0.0
    )


class TorqueTable(Part):
    """A torque that depends on the speed, straight between the entries, less ``damping`` times the speed."""

    kind: Literal["torque_table"] = "torque_table"
    speed: Annotated[tuple[Speed, ...], Listed] = key("must increase")
    torque: Annotated[tuple[Torque, ...], Listed] = key("as many as speeds, linear in between, constant outside")
    damping: AngularDamping = key("braking torque over speed", 0.0)

    @model_validator(mode="after")
    def _consistent(self) -> TorqueTable:
        if not self.speed:
            raise ValueError("speed: the table is empty; give at least one speed and one torque")
        if len(self.speed) != len(self.torque):
            raise ValueError(
                f"given {len(self.speed)} speeds and {len(self.torque)} torques; give the same number of both"
            )
        if any(b <= a for a, b in zip(self.speed, self.speed[1:], strict=False)):
            raise ValueError("speed: must increase from entry to entry")
        return self


Drive = Annotated[PrescribedSpeed | ConstantTorque | TargetTorque | TorqueTable, Field(discriminator="kind")]
