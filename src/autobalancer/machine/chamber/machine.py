"""The machine with deep chambers."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from autobalancer.machine.chamber.body import ChamberBody, ChamberRotor, ChamberSupport, ChamberUnbalance
from autobalancer.machine.chamber.chamber import Chamber
from autobalancer.machine.chamber.contact import ChamberContact
from autobalancer.machine.chamber.triple import Acceleration3
from autobalancer.machine.drive import AsynchronousMotor, PrescribedSpeed
from autobalancer.machine.machine import RunPlan
from autobalancer.machine.part import Listed, Name, Part, key
from autobalancer.machine.quantity import Angle, Speed
from autobalancer.pictured import picture_html
from autobalancer.shown import html_table

# What turns the rotor of a machine with deep chambers.


ChamberDrive = Annotated[PrescribedSpeed | AsynchronousMotor, Field(discriminator="kind")]


class ChamberStart(Part):
    """Rotor at time zero."""

    rotor_angle: Angle = key("at time zero", 0.0)
    speed: Speed = key("of the rotor, only where a torque drives", 0.0)


class ChamberMachine(Part):
    """A rotor with chambers in which balls move freely, on a body on supports.

    x points along the rotor; displacements are counted from the rest position of the machine without balls. ``gravity`` is
    a vector.
    """

    name: Name = key("name of the machine, in titles of pictures and results")
    description: str = key("source and purpose", "")
    gravity: Acceleration3 = key("along x (the rotor), y and z (up, for a horizontal rotor)", (0.0, 0.0, -9.80665))
    body: ChamberBody = key("what carries rotor and motor")
    supports: Annotated[tuple[ChamberSupport, ...], Listed] = key(
        "springs and dampers between body and ground; a `fixed` body needs none", ()
    )
    rotor: ChamberRotor = key("shaft and chambers, without balls")
    unbalances: Annotated[tuple[ChamberUnbalance, ...], Listed] = key(
        "of the rotor; two opposite ones at different places are a couple", ()
    )
    chambers: Annotated[tuple[Chamber, ...], Field(min_length=1), Listed] = key("one or several on the rotor")
    contact: ChamberContact = key("of balls with each other and with walls")
    drive: ChamberDrive = key("what turns the rotor")
    start: ChamberStart = Field(default_factory=ChamberStart, description="rotor at time zero")
    run: RunPlan | None = key("default duration of a run", None)

    def _repr_html_(self) -> str:
        count = sum(group.count for chamber in self.chambers for group in chamber.balls)
        rows = [
            ("body", self.body.freedom),
            ("balls", f"{count} in {len(self.chambers)} deep chamber{'s' * (len(self.chambers) != 1)}"),
            ("unbalances", str(len(self.unbalances))),
            ("drive", self.drive.kind),
            ("run", "no duration" if self.run is None else f"{float(self.run.duration):g} s"),
            ("description", self.description or "none"),
        ]
        return html_table(("", ""), rows, self.name) + picture_html(self, "machine", f"drawing of {self.name}")

    @model_validator(mode="after")
    def _consistent(self) -> ChamberMachine:
        if getattr(self.drive, "couplings", ()):
            raise ValueError("drive.couplings: the rotor of a deep chamber has none; leave them out")
        if isinstance(self.drive, PrescribedSpeed) and self.start.speed != 0.0:
            raise ValueError("start.speed: the drive prescribes the speed; leave it out")
        _check_cylinders(self.chambers, self.contact)
        rebound = self.contact.rebound
        wet = rebound is not None and rebound.critical_stokes is not None
        for number, chamber in enumerate(self.chambers, 1):
            if wet and chamber.viscosity is None:
                raise ValueError(f"chambers[{number}].viscosity: missing; contact.rebound.critical_stokes needs it")
            if chamber.viscosity is not None and not wet:
                raise ValueError(
                    f"chambers[{number}].viscosity: has no effect without contact.rebound.critical_stokes; give that too, or "
                    "leave it out (the drag of the fluid is 'drag' and 'square_drag')"
                )
        total = sum(unbalance.size for unbalance in self.unbalances)
        if total**2 >= self.rotor.mass * self.rotor.polar_inertia:
            raise ValueError(
                f"unbalances: together {total:g} kg m; more than mass and polar inertia of the rotor can carry"
            )
        return self


def _check_cylinders(chambers: tuple[Chamber, ...], contact: ChamberContact) -> None:
    """Refuse what cylinders do not know."""
    bodies = {balls.body for chamber in chambers for balls in chamber.balls}
    if bodies == {"ball"}:
        return
    if len(bodies) > 1:
        raise ValueError("chambers: have balls and cylinders; a machine has the one or the other")
    if contact.law != "restitution":
        raise ValueError("contact.law: given 'history'; cylinders know 'restitution' only")
    if contact.stiffness is not None:
        raise ValueError(
            "contact.stiffness: is that of balls, k in k d^1.5; the contacts of cylinders are along lines: give youngs_modulus"
        )
    if contact.rebound is not None:
        raise ValueError("contact.rebound: is known for balls only; give cylinders a constant restitution")
