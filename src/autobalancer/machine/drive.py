"""What turns the rotor: a prescribed speed, or a torque against an external damping torque, at once or through couplings."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from autobalancer.machine.drive_train import (
    CHAIN,
    MOUNTED,
    RIPPLE,
    Couplings,
    MotorMount,
    Ripples,
    check_chain,
)
from autobalancer.machine.part import Listed, Part, key
from autobalancer.machine.profile import Profile
from autobalancer.machine.quantity import AngularDamping, Positive, Speed, Torque


class _Chain(Part):
    """A drive with couplings, each with what it needs."""

    @model_validator(mode="after")
    def _linked(self) -> Self:
        check_chain(getattr(self, "couplings", ()), prescribed=isinstance(self, PrescribedSpeed))
        return self


class PrescribedSpeed(_Chain):
    """The speed follows the profile whatever the balls do. With ``couplings`` it is that of the motor behind them."""

    kind: Literal["speed"] = "speed"
    profile: Profile = key("speed over time")
    couplings: Couplings = key(CHAIN, ())


class ConstantTorque(_Chain):
    """A constant torque less ``damping`` times the speed, of the motor where there are couplings."""

    kind: Literal["torque"] = "torque"
    torque: Torque = key("on the rotor, or on the motor behind its couplings")
    damping: AngularDamping = key("braking torque over speed", 0.0)
    couplings: Couplings = key(CHAIN, ())
    mount: MotorMount | None = key(MOUNTED, None)
    ripples: Ripples = key(RIPPLE, ())


class TargetTorque(_Chain):
    """``gain`` times a target speed less ``damping`` times the speed (Spannan 2021, section 4.1.1)."""

    kind: Literal["target_torque"] = "target_torque"
    profile: Profile = key("target speed over time")
    gain: AngularDamping = key("driving torque over target speed")
    damping: AngularDamping = key(
        "braking torque over speed; if equal to the gain, the rotor approaches the target", 0.0
    )
    couplings: Couplings = key(CHAIN, ())
    mount: MotorMount | None = key(MOUNTED, None)
    ripples: Ripples = key(RIPPLE, ())


class TorqueTable(_Chain):
    """A torque that depends on the speed, straight between the entries, less ``damping`` times the speed."""

    kind: Literal["torque_table"] = "torque_table"
    speed: Annotated[tuple[Speed, ...], Listed] = key("must increase")
    torque: Annotated[tuple[Torque, ...], Listed] = key("as many as speeds, linear in between, constant outside")
    damping: AngularDamping = key("braking torque over speed", 0.0)
    couplings: Couplings = key(CHAIN, ())
    mount: MotorMount | None = key(MOUNTED, None)
    ripples: Ripples = key(RIPPLE, ())

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


class AsynchronousDrive(AsynchronousMotor, _Chain):
    """An asynchronous motor, less ``damping`` times its speed, on the rotor or behind couplings."""

    damping: AngularDamping = key("braking torque over speed", 0.0)
    couplings: Couplings = key(CHAIN, ())
    mount: MotorMount | None = key(MOUNTED, None)
    ripples: Ripples = key(RIPPLE, ())


Drive = Annotated[
    PrescribedSpeed | ConstantTorque | TargetTorque | TorqueTable | AsynchronousDrive, Field(discriminator="kind")
]


def twists(drive: Part) -> bool:
    """Whether anything in the drive turns elastically: couplings, or the stator of the motor."""
    return bool(getattr(drive, "couplings", ())) or getattr(drive, "mount", None) is not None
