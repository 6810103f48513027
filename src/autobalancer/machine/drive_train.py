"""What stands between a motor and the rotor, and turns elastically: couplings, the mount of the motor, its ripple."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

from autobalancer.machine.part import Label, Listed, Part, key
from autobalancer.machine.quantity import Angle, AngularDamping, Inertia, Positive, Quantity, Torque

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
