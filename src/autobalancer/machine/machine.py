"""The machine: rotor, unbalance, balancers, drive."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from autobalancer.machine.balancer.race import Balancer
from autobalancer.machine.drive import Drive, PrescribedSpeed
from autobalancer.machine.excitation import Excitation
from autobalancer.machine.part import (
    Angle,
    Duration,
    Gravity,
    ImpossiblePart,
    Listed,
    Name,
    Part,
    Position,
    Problem,
    Speed,
    Velocity,
)
from autobalancer.machine.rotors import Rotor
from autobalancer.machine.rotors.planar import PlanarRotor
from autobalancer.machine.rotors.rigid import RigidRotor
from autobalancer.machine.station import Station
from autobalancer.machine.unbalance import Unbalance
from autobalancer.shown import html_table


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

    ``tilting_races`` says what a ball feels of a race that tilts: the ``deflection`` of its center only (Rodrigues et al.
    2011, equation 1), or the ``full`` motion, with the inertia and weight of the ball along the axis.
    """

    name: Name
    description: str = ""
    axis: Literal["vertical", "horizontal"]
    gravity: Gravity = 9.80665
    rotor: Rotor
    stations: Annotated[tuple[Station, ...], Listed] = ()
    unbalances: tuple[Unbalance, ...] = ()
    balancers: tuple[Balancer, ...] = ()
    tilting_races: Literal["deflection", "full"] = "deflection"
    excitations: Annotated[tuple[Excitation, ...], Listed] = ()
    drive: Drive
    start: Start = Field(default_factory=Start)
    run: RunPlan | None = None

    def __repr__(self) -> str:
        return f"<Machine {self.name!r}: " + ", ".join(f"{what}: {value}" for what, value in self._rows()) + ">"

    __str__ = __repr__

    def _repr_html_(self) -> str:
        return html_table(("", ""), [*self._rows(), ("description", self.description or "none")], self.name)

    def _rows(self) -> list[tuple[str, str]]:
        """What is worth a line when it is shown."""
        races = [race for balancer in self.balancers for race in balancer.races]
        balls = sum(race.ball_count for race in races)
        drive = "prescribed speed" if isinstance(self.drive, PrescribedSpeed) else "torque"
        return [
            ("rotor", f"{self.rotor.kind}, {self.axis} axis"),
            ("balls", f"{balls} in {len(races)} race{'s' * (len(races) != 1)}"),
            ("unbalances", str(len(self.unbalances))),
            ("drive", drive),
            ("run", "no duration" if self.run is None else f"{float(self.run.duration):g} s"),
        ]

    @model_validator(mode="after")
    def _drivable(self) -> Machine:
        prescribed = isinstance(self.drive, PrescribedSpeed)
        if not prescribed and self.rotor.inertia is None:
            raise ValueError("rotor.inertia: missing; a torque can only drive a rotor whose inertia is given")
        if prescribed and self.start.speed != 0.0:
            raise ValueError("start.speed: the drive prescribes the speed; leave it out")
        return self

    @model_validator(mode="after")
    def _placed(self) -> Machine:
        names = [station.name for station in self.stations]
        problems: list[Problem] = [
            (("stations", i, "name"), f"{name!r} is given twice") for i, name in enumerate(names) if name in names[:i]
        ]
        planar = isinstance(self.rotor, PlanarRotor)
        for kind in ("balancers", "unbalances", "excitations"):
            for i, part in enumerate(getattr(self, kind)):
                if not hasattr(part, "station"):
                    continue
                if isinstance(part.station, str) and part.station not in names:
                    known = ", ".join(map(repr, names)) or "none"
                    problems.append(((kind, i, "station"), f"no station is named {part.station!r}; there is {known}"))
                elif planar and part.station is not None and not isinstance(part.station, str) and part.station != 0.0:
                    problems.append(((kind, i, "station"), "a planar rotor has one plane only; leave it out"))
        for i, unbalance in enumerate(self.unbalances):
            if planar and unbalance.is_couple:
                problems.append((("unbalances", i), "a planar rotor does not tilt and feels no couple; leave it out"))
            elif unbalance.misalignment is not None and not isinstance(self.rotor, RigidRotor):
                text = "only a rigid rotor has one principal axis; give 'couple' and a 'station'"
                problems.append((("unbalances", i, "misalignment"), text))
        if problems:
            raise ImpossiblePart("Machine", problems)
        return self
