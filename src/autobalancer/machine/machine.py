"""The machine: rotor, unbalance, balancers, drive."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from autobalancer.machine.balancer.race import Balancer
from autobalancer.machine.drive import Drive, PrescribedSpeed, twists
from autobalancer.machine.excitation import BaseMotion, Excitation, RecordedBaseMotion
from autobalancer.machine.liquid_ring import LiquidRing
from autobalancer.machine.part import ImpossiblePart, Listed, Name, Part, Problem, key
from autobalancer.machine.quantity import Angle, Duration, Gravity, Position, Speed, Velocity
from autobalancer.machine.rotors import Rotor
from autobalancer.machine.rotors.modal import ModalRotor
from autobalancer.machine.rotors.planar import PlanarRotor
from autobalancer.machine.rotors.rigid import RigidRotor
from autobalancer.machine.station import Station
from autobalancer.machine.unbalance import Unbalance
from autobalancer.pictured import picture_html
from autobalancer.shown import html_table


class Start(Part):
    """State at time zero; balls bring their own. ``speed`` counts only where a torque drives."""

    rotor_angle: Angle = key("from the x axis to the zero mark", 0.0)
    speed: Speed = key("of the rotor, only where a torque drives", 0.0)
    deflection: tuple[Position, Position] = key("along x and y, in space", (0.0, 0.0))
    velocity: tuple[Velocity, Velocity] = key("along x and y, in space", (0.0, 0.0))


class RunPlan(Part):
    """How long a run lasts unless the caller says otherwise."""

    duration: Duration = key("of a run")


class Machine(Part):
    """A rotor with ball balancers, complete enough to run.

    A ``vertical`` axis feels no gravity in its plane; on a ``horizontal`` one it pulls along -y, and deflections are
    counted from the rest position of the rotor without balls.

    ``tilting_races`` says what a ball feels of a race that tilts: the ``deflection`` of its center only (Rodrigues et al.
    2011, equation 1), or the ``full`` motion, with the inertia and weight of the ball along the axis.
    """

    name: Name = key("name of the machine, in titles of pictures and results")
    description: str = key("source and purpose", "")
    axis: Literal["vertical", "horizontal"] = key(
        "`horizontal`: gravity acts along $-y$; `vertical`: no gravity in the plane"
    )
    gravity: Gravity = key(
        "across a horizontal axis; along a vertical one on shafts and rigs with `up`, and on some balls",
        9.80665,
        symbol="g",
    )
    rotor: Rotor = key("what carries the balancers")
    stations: Annotated[tuple[Station, ...], Listed] = key("named planes across the rotor", ())
    unbalances: tuple[Unbalance, ...] = key("their sum is what is to be balanced", ())
    balancers: tuple[Balancer, ...] = key("may be left out: a rotor without balls", ())
    liquid_rings: Annotated[tuple[LiquidRing, ...], Listed] = key(
        "rings partly filled with liquid, in place of balls; for `liquid-response` only", ()
    )
    tilting_races: Literal["deflection", "full"] = key(
        "`deflection`: balls feel only the deflection of the race; `full`: its axial motion too", "deflection"
    )
    excitations: Annotated[tuple[Excitation, ...], Listed] = key("external base motions and forces", ())
    drive: Drive = key("what turns the rotor")
    start: Start = Field(default_factory=Start, description="state at time zero")
    run: RunPlan | None = key("default duration of a run", None)

    def __repr__(self) -> str:
        return f"<Machine {self.name!r}: " + ", ".join(f"{what}: {value}" for what, value in self._rows()) + ">"

    __str__ = __repr__

    def _repr_html_(self) -> str:
        table = html_table(("", ""), [*self._rows(), ("description", self.description or "none")], self.name)
        return table + picture_html(self, "machine", f"drawing of {self.name}")

    def _rows(self) -> list[tuple[str, str]]:
        """What is worth a line when it is shown."""
        races = [race for balancer in self.balancers for race in balancer.races]
        balls = sum(race.ball_count for race in races)
        drive = "prescribed speed" if isinstance(self.drive, PrescribedSpeed) else "torque"
        count = len(self.drive.couplings)
        drive += f", {count} coupling{'s' * (count != 1)}" if count else ""
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
        if (not prescribed or twists(self.drive)) and self.rotor.inertia is None:
            raise ValueError("rotor.inertia: missing; a torque can only drive a rotor whose inertia is given")
        if prescribed and self.start.speed != 0.0:
            raise ValueError("start.speed: the drive prescribes the speed; leave it out")
        return self

    @model_validator(mode="after")
    def _liquid(self) -> Machine:
        if self.liquid_rings and self.balancers:
            raise ValueError(
                "liquid_rings: balls and rings of liquid on one rotor are not supported; leave one of them out"
            )
        return self

    @model_validator(mode="after")
    def _forced(self) -> Machine:
        problems: list[Problem] = [
            (("balancers", b, "races", r, "forces", f), text)
            for b, balancer in enumerate(self.balancers)
            for r, race in enumerate(balancer.races)
            for f, force in enumerate(race.forces)
            if (text := force.impossible(race, self.axis))
        ]
        if problems:
            raise ImpossiblePart("Machine", problems)
        return self

    @model_validator(mode="after")
    def _known_by_its_modes(self) -> Machine:
        if not isinstance(self.rotor, ModalRotor):
            return self
        unknown = "the modes of a rotor at one plane do not say how its other parts move with"
        problems: list[Problem] = []
        if self.axis == "horizontal" and float(self.gravity):
            problems.append((("axis",), f"{unknown} its weight; take a vertical axis, or 'gravity = 0'"))
        for i, shaken in enumerate(self.excitations):
            if isinstance(shaken, (BaseMotion, RecordedBaseMotion)):
                problems.append((("excitations", i), f"{unknown} its base; take another rotor, or a force"))
        if problems:
            raise ImpossiblePart("Machine", problems)
        return self

    @model_validator(mode="after")
    def _placed(self) -> Machine:
        names = [station.name for station in self.stations]
        problems: list[Problem] = [
            (("stations", i, "name"), f"{name!r} is given twice") for i, name in enumerate(names) if name in names[:i]
        ]
        planar, a_rotor = isinstance(self.rotor, (PlanarRotor, ModalRotor)), f"a {self.rotor.kind} rotor"
        for kind in ("balancers", "unbalances", "excitations"):
            for i, part in enumerate(getattr(self, kind)):
                if not hasattr(part, "station"):
                    continue
                if isinstance(part.station, str) and part.station not in names:
                    known = ", ".join(map(repr, names)) or "none"
                    problems.append(((kind, i, "station"), f"no station is named {part.station!r}; there is {known}"))
                elif planar and part.station is not None and not isinstance(part.station, str) and part.station != 0.0:
                    problems.append(((kind, i, "station"), f"{a_rotor} has one plane only; leave it out"))
        for i, unbalance in enumerate(self.unbalances):
            if planar and unbalance.is_couple:
                problems.append((("unbalances", i), f"{a_rotor} does not tilt and feels no couple; leave it out"))
            elif unbalance.misalignment is not None and not isinstance(self.rotor, RigidRotor):
                text = "only a rigid rotor has one principal axis; give 'couple' and a 'station'"
                problems.append((("unbalances", i, "misalignment"), text))
        if problems:
            raise ImpossiblePart("Machine", problems)
        return self
