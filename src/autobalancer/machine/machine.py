"""The machine: rotor, unbalance, balancers, drive."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

from autobalancer.machine.balancer.race import Balancer
from autobalancer.machine.drive import Drive, PrescribedSpeed
from autobalancer.machine.part import Angle, Duration, Gravity, Part, Position, Speed, Velocity
from autobalancer.machine.rotors.planar import PlanarRotor
from autobalancer.machine.unbalance import Unbalance


class Start(Part):
    """State at time zero; balls bring their own. ``speed`` counts only where a torque drives."""

    rotor_angle: Angle = 0.0
    speed: Speed = 0.0
    deflection: tuple[Position, Position] = (0.0, 0.0)
    velocity: tuple[Velocity, Velocity] = (0.0, 0.0)


class RunPlan(Part):
    """How long a run lasts unless the caller says otherwise."""

    duration: Duration


class Machine(Part):
    """A rotor with ball balancers, complete enough to run.

    A ``vertical`` axis feels no gravity in its plane; on a ``horizontal`` one it pulls along -y, and deflections are
    counted from the rest position of the rotor without balls.
    """

    name: str
    description: str = ""
    axis: Literal["vertical", "horizontal"]
    gravity: Gravity = 9.80665
    rotor: PlanarRotor
    unbalances: tuple[Unbalance, ...] = ()
    balancers: tuple[Balancer, ...] = ()
    drive: Drive
    start: Start = Field(default_factory=Start)
    run: RunPlan | None = None

    @model_validator(mode="after")
    def _drivable(self) -> Machine:
        prescribed = isinstance(self.drive, PrescribedSpeed)
        if not prescribed and self.rotor.inertia is None:
            raise ValueError("rotor.inertia: missing; a torque can only drive a rotor whose inertia is given")
        if prescribed and self.start.speed != 0.0:
            raise ValueError("start.speed: the drive prescribes the speed; leave it out")
        return self
