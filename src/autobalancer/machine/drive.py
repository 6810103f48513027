"""What turns the rotor: a prescribed speed, or a torque against an external damping torque, at once or through couplings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from autobalancer.machine.part import (
    Acceleration,
    Angle,
    AngularDamping,
    Duration,
    Inertia,
    Label,
    Listed,
    Part,
    Positive,
    Quantity,
    Speed,
    Time,
    Torque,
    key,
)

# What stands between a motor and the rotor, and turns elastically: couplings, the mount of the motor, its ripple.


TorsionalStiffness = Annotated[float, Quantity("N*m/rad", positive=True)]
TwistError = Annotated[float, Quantity("rad", non_negative=True)]


class Coupling(Part):
    """An elastic piece of the drive train, and the inertia on its side towards the motor.

    A coupling that is not aligned twists by itself while it turns: by ``error`` cos(``order`` angle + ``phase``), the angle
    being that of its side towards the rotor. Backlash is not part of it.
    """

    name: Label = key("of what has this inertia, in results", "")
    stiffness: TorsionalStiffness = key("torque over twist")
    damping: AngularDamping = key("torque over speed of the twist", 0.0)
    inertia: Inertia | None = key(
        "of all that turns with its side towards the motor; not needed at a motor whose speed is prescribed", None
    )
    error: TwistError = key("amplitude of the twist that bad alignment prescribes without a torque", 0.0)
    order: Positive = key("cycles of this error per turn: 1 for a shaft off center, 2 for a shaft at an angle", 2.0)
    phase: Angle = key("of this error at angle zero", 0.0)


class MotorMount(Part):
    """The stator of the motor on an elastic mount, in which it turns to and fro: it bears the torque on the rotor."""

    inertia: Inertia = key("of the stator about the shaft")
    stiffness: TorsionalStiffness = key("torque of the mount over angle of the stator")
    damping: AngularDamping = key("torque of the mount over speed of the stator", 0.0)


class TorqueRipple(Part):
    """A torque of the motor that changes as it turns: ``torque`` cos(``order`` angle + ``phase``)."""

    torque: Torque = key("amplitude")
    order: Positive = key("cycles per turn of the motor against its stator")
    phase: Angle = key("at angle zero", 0.0)


Couplings = Annotated[tuple[Coupling, ...], Listed]
Ripples = Annotated[tuple[TorqueRipple, ...], Listed]

CHAIN = "from the rotor to the motor; without any the motor sits on the rotor"
MOUNTED = "where the stator of the motor can turn; else it stands still"
RIPPLE = "torques of the motor that change as it turns"


def check_chain(couplings: Sequence[Coupling], *, prescribed: bool) -> None:
    """Every coupling has an inertia, but for the last one before a motor whose speed is prescribed.

    Raises
    ------
    ValueError
        If one lacks it.
    """
    needed = couplings[:-1] if prescribed else couplings
    for number, coupling in enumerate(needed, start=1):
        if coupling.inertia is None:
            raise ValueError(
                f"couplings[{number}].inertia: missing; a torque acts on it, so give the inertia of all that turns with "
                "this side of the coupling"
            )


# Speed over time, as an engineer would say it.


class Constant(Part):
    """One speed for ever."""

    kind: Literal["constant"] = "constant"
    speed: Speed = key("from the start on")


class Ramp(Part):
    """From ``start`` to ``end`` at a steady rate within ``duration``, after an optional ``delay``; then constant."""

    kind: Literal["ramp"] = "ramp"
    start: Speed = key("before the ramp", 0.0)
    end: Speed = key("after the ramp")
    duration: Duration = key("of the ramp")
    delay: Time = key("before the ramp", 0.0)


class Table(Part):
    """Speeds at times, straight in between, constant outside. The times must increase."""

    kind: Literal["table"] = "table"
    time: Annotated[tuple[Time, ...], Listed] = key("must increase")
    speed: Annotated[tuple[Speed, ...], Listed] = key("as many as times, linear in between, constant outside")

    @model_validator(mode="after")
    def _consistent(self) -> Table:
        if not self.time:
            raise ValueError("time: the profile is empty; give at least one time and one speed")
        if len(self.time) != len(self.speed):
            raise ValueError(f"given {len(self.time)} times and {len(self.speed)} speeds; give the same number of both")
        if any(b <= a for a, b in zip(self.time, self.time[1:], strict=False)):
            raise ValueError("time: must increase from entry to entry")
        return self


class Dwell(Part):
    """Hold each of ``speeds`` for ``hold``, and change between them at the rate ``acceleration``."""

    kind: Literal["dwell"] = "dwell"
    speeds: Annotated[tuple[Speed, ...], Field(min_length=1), Listed] = key(
        "one after the other; the first one from the start on"
    )
    hold: Duration = key("at each speed")
    acceleration: Acceleration = key("from one to the next, up or down")


class Hill(Part):
    """S-shaped run-up: start + (end - start) t^n / (half_time^n + t^n), half way at ``half_time``."""

    kind: Literal["hill"] = "hill"
    start: Speed = key("at time zero", 0.0)
    end: Speed = key("approached at late times")
    half_time: Duration = key("when half of the change is done")
    exponent: Positive = key("$n$, at least 1")

    @model_validator(mode="after")
    def _finite_jerk(self) -> Hill:
        if self.exponent < 1.0:
            raise ValueError(
                f"exponent: given {self.exponent:g}; must be at least 1, otherwise the initial acceleration is infinite"
            )
        return self


class Reduction(Part):
    """A run-up with a temporary reduction, which lets the balls find better places.

    Up to ``peak``, hold, down to ``reduced``, hold, up to ``end``; all changes at the rate ``acceleration``. With
    ``dwell`` it also waits at that speed on the way to ``peak``.
    """

    kind: Literal["reduction"] = "reduction"
    start: Speed = key("at time zero", 0.0)
    peak: Speed = key("first speed")
    reduced: Speed = key("second speed")
    end: Speed = key("last speed")
    acceleration: Acceleration = key("of all changes, up or down")
    hold_peak: Time = key("time at the first speed", 0.0)
    hold_reduced: Time = key("time at the second speed", 0.0)
    dwell: Speed | None = key("speed at which it waits on the way to the first speed", None)
    hold_dwell: Time = key("time at that speed", 0.0)

    @model_validator(mode="after")
    def _waits_somewhere(self) -> Reduction:
        if self.hold_dwell > 0.0 and self.dwell is None:
            raise ValueError("hold_dwell: needs 'dwell', the speed at which the rotor waits")
        return self


Profile = Annotated[Constant | Ramp | Table | Dwell | Hill | Reduction, Field(discriminator="kind")]


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
