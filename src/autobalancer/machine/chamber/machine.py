"""The machine with deep chambers."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from autobalancer.machine.chamber.body import ChamberBody, ChamberRotor, ChamberSupport, ChamberUnbalance
from autobalancer.machine.chamber.chamber import Chamber
from autobalancer.machine.chamber.contact import ChamberContact
from autobalancer.machine.chamber.drive import ChamberDrive
from autobalancer.machine.chamber.triple import Acceleration3
from autobalancer.machine.drive import PrescribedSpeed
from autobalancer.machine.machine import RunPlan
from autobalancer.machine.part import Angle, Listed, Name, Part, Speed


class ChamberStart(Part):
    """Rotor at time zero."""

    rotor_angle: Angle = 0.0
    speed: Speed = 0.0


class ChamberMachine(Part):
    """A rotor with chambers in which balls move freely, on a body on supports.

    x points along the rotor; displacements are counted from the rest position of the machine without balls. ``gravity`` is
    a vector.
    """

    name: Name
    description: str = ""
    gravity: Acceleration3 = (0.0, 0.0, -9.80665)
    body: ChamberBody
    supports: Annotated[tuple[ChamberSupport, ...], Listed] = ()
    rotor: ChamberRotor
    unbalances: Annotated[tuple[ChamberUnbalance, ...], Listed] = ()
    chambers: Annotated[tuple[Chamber, ...], Listed, Field(min_length=1)]
    contact: ChamberContact
    drive: ChamberDrive
    start: ChamberStart = Field(default_factory=ChamberStart)
    run: RunPlan | None = None

    @model_validator(mode="after")
    def _consistent(self) -> ChamberMachine:
        if isinstance(self.drive, PrescribedSpeed) and self.start.speed != 0.0:
            raise ValueError("start.speed: the drive prescribes the speed; leave it out")
        total = sum(unbalance.size for unbalance in self.unbalances)
        if total**2 >= self.rotor.mass * self.rotor.polar_inertia:
            raise ValueError(
                f"unbalances: together {total:g} kg m; more than mass and polar inertia of the rotor can carry"
            )
        return self
