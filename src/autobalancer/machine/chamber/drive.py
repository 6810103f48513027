"""What turns the rotor of a machine with deep chambers."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from autobalancer.machine.drive import AsynchronousMotor, PrescribedSpeed

ChamberDrive = Annotated[PrescribedSpeed | AsynchronousMotor, Field(discriminator="kind")]
