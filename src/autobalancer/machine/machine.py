"""The machine: rotor, unbalance, balancers, drive."""

from __future__ import annotations

from cmath import rect
from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field, model_validator

from autobalancer.errors import MachineError, Problem
from autobalancer.machine.balancer.fluid import Fluid
from autobalancer.machine.balancer.race import Balancer
from autobalancer.machine.drive import Drive, PrescribedSpeed, twists
from autobalancer.machine.part import (
    Angle,
    CoupleMoment,
    Duration,
    Gravity,
    Label,
    Length,
    Listed,
    Mass,
    Name,
    Part,
    Position,
    Positive,
    Quantity,
    Ratio,
    Speed,
    Time,
    UnbalanceMoment,
    Velocity,
    key,
)
from autobalancer.machine.rotors import Rotor
from autobalancer.machine.rotors.body import Place, Station
from autobalancer.machine.rotors.modal import ModalRotor
from autobalancer.machine.rotors.rigid import RigidRotor
from autobalancer.notebook import picture_html
from autobalancer.tables import html_table

# What the balancers have to balance.


class Schedule(Part):
    """How an unbalance changes in time: a factor, piecewise linear over time and constant outside.

    Two equal times are a jump: blade loss at 5 s is ``time = [5, 5], factor = [0, 1]``.
    """

    time: Annotated[tuple[Time, ...], Listed] = key("must not decrease; the same time twice is a jump")
    factor: Annotated[tuple[Ratio, ...], Listed] = key(
        "multiplies the moment; as many as times, linear in between, constant outside"
    )

    @model_validator(mode="after")
    def _consistent(self) -> Schedule:
        if not self.time:
            raise ValueError("time: given an empty list; give at least one time")
        if len(self.time) != len(self.factor):
            raise ValueError(
                f"given {len(self.time)} times and {len(self.factor)} factors; give the same number of both"
            )
        if any(b < a for a, b in zip(self.time, self.time[1:], strict=False)):
            raise ValueError("time: must not decrease")
        if any(a == c for a, c in zip(self.time, self.time[2:], strict=False)):
            raise ValueError("time: the same time is given three times; a jump needs it twice")
        return self


LARGEST_TILT = 0.5  # rad; the equations are those of small tilts


class Unbalance(Part):
    """A point unbalance (its moment, or mass and radius) or a couple unbalance, at an angle in the rotor.

    A point unbalance sits at a ``station``: a position along the axis, or the name of one of the machine's stations;
    needless on a planar rotor, and for a couple on a rigid one. The mass belongs to the mass of the rotor; a change in
    time moves the moment only. ``couple`` is the product of inertia: two unbalances U a distance L apart and opposite
    are U L, at the angle of the one at greater z. A principal axis tilted by chi has (J_t - J_p) chi, and
    ``misalignment`` is that chi.
    """

    moment: UnbalanceMoment | None = key("mass times radius; instead of `mass` and `radius`", None, symbol="U")
    mass: Mass | None = key("a part of the mass of the rotor, not in addition to it", None)
    radius: Length | None = key("distance of this mass from the shaft", None)
    couple: CoupleMoment | None = key(
        "product of inertia in place of a point unbalance, at the angle of its part at greater $z$; not on a planar rotor",
        None,
    )
    misalignment: Angle | None = key(
        r"angle $\chi$ of the principal axis, a couple $(J_t - J_p) \chi$; on a rigid rotor only", None, symbol=r"\chi"
    )
    angle: Angle = key("in the rotor, from the zero mark", 0.0)
    station: Place | None = key(
        "where on the axis: a position, or the name of a station; not needed on a planar rotor", None
    )
    schedule: Schedule | None = key("how it changes in time; without one it is constant", None)

    @model_validator(mode="after")
    def _one_way(self) -> Unbalance:
        given = [self.moment, self.mass if self.mass is not None else self.radius, self.couple, self.misalignment]
        if sum(entry is not None for entry in given) != 1 or (self.mass is None) != (self.radius is None):
            raise ValueError("give either 'moment', or 'mass' and 'radius', or 'couple', or 'misalignment'")
        if self.misalignment is not None and abs(self.misalignment) > LARGEST_TILT:
            raise ValueError(
                f"misalignment: given {self.misalignment:g} rad; must be at most {LARGEST_TILT} rad, a small angle"
            )
        return self

    @property
    def is_couple(self) -> bool:
        """Whether it is a pure couple."""
        return self.couple is not None or self.misalignment is not None

    @property
    def size(self) -> float:
        """The moment m0 eps0 at factor one, kg m; 0 of a couple."""
        return float(self.moment) if self.moment is not None else float(self.mass or 0.0) * float(self.radius or 0.0)

    @property
    def vector(self) -> complex:
        """The moment at factor one as a vector in the rotor, m0 eps0 e^(i alpha), kg m; 0 of a couple."""
        return rect(self.size, self.angle)


# What shakes a machine from outside: motion of its base, and forces on its rotor.


BaseAcceleration = Annotated[float, Quantity("m/s^2")]
BaseDisplacement = Annotated[float, Quantity("m", non_negative=True)]
Newton = Annotated[float, Quantity("N")]

PACE = "of a steady vibration, as turns of its own: 10 Hz is 62.83 rad/s; this or `order`"
ORDER = "cycles per turn of the rotor, any number above zero: 1 is synchronous; in place of a frequency"
PHASE = "at time zero; with an `order`, at rotor angle zero"
DIRECTION = "in space, from the x axis"
RECORD = "must increase; no excitation before the first and after the last time"
PUSHED = "where the force acts: a position, or the name of a station; not needed on a planar rotor"


def _one_pace(frequency: float | None, order: float | None) -> None:
    if (frequency is None) == (order is None):
        raise ValueError("give either 'frequency', or 'order' (per turn of the rotor)")


def _recorded(time: tuple[float, ...], values: tuple[float, ...], name: str) -> None:
    if len(time) < 2 or len(time) != len(values):
        raise ValueError(
            f"{name}: given {len(values)} values at {len(time)} times; give the same number of both, at least two"
        )
    if any(b <= a for a, b in pairwise(time)):
        raise ValueError("time: must increase")


class BaseMotion(Part):
    """The base moves to and fro along ``direction`` (from the x axis): amplitude cos(2 pi f t + phase).

    The amplitude is that of the ``acceleration`` or of the ``displacement``. Deflections are then relative to the base.
    """

    kind: Literal["base_motion"] = "base_motion"
    acceleration: BaseAcceleration | None = key("amplitude; this or `displacement`", None)
    displacement: BaseDisplacement | None = key("amplitude; requires a `frequency`", None)
    frequency: Speed | None = key(PACE, None)
    order: Positive | None = key(ORDER, None)
    phase: Angle = key(PHASE, 0.0)
    direction: Angle = key(DIRECTION, 0.0)

    @model_validator(mode="after")
    def _one_way(self) -> BaseMotion:
        if (self.acceleration is None) == (self.displacement is None):
            raise ValueError("give either 'acceleration' or 'displacement'")
        _one_pace(self.frequency, self.order)
        if self.displacement is not None and self.frequency is None:
            raise ValueError("displacement: needs a fixed 'frequency'; give the 'acceleration' with an 'order'")
        return self


class RecordedBaseMotion(Part):
    """A measured acceleration of the base along ``direction``; zero outside its times."""

    kind: Literal["recorded_base_motion"] = "recorded_base_motion"
    time: Annotated[tuple[Time, ...], Listed] = key(RECORD)
    acceleration: Annotated[tuple[BaseAcceleration, ...], Listed] = key(
        "as many as times; a smooth curve goes through them"
    )
    direction: Angle = key(DIRECTION, 0.0)

    @model_validator(mode="after")
    def _consistent(self) -> RecordedBaseMotion:
        _recorded(self.time, self.acceleration, "acceleration")
        return self


class HarmonicForce(Part):
    """A force on the rotor at a station, along ``direction`` in space: amplitude cos(2 pi f t + phase)."""

    kind: Literal["force"] = "force"
    station: Place | None = key(PUSHED, None)
    force: Newton = key("amplitude")
    frequency: Speed | None = key(PACE, None)
    order: Positive | None = key(ORDER, None)
    phase: Angle = key(PHASE, 0.0)
    direction: Angle = key(DIRECTION, 0.0)

    @model_validator(mode="after")
    def _one_way(self) -> HarmonicForce:
        _one_pace(self.frequency, self.order)
        return self


class RecordedForce(Part):
    """A measured force on the rotor at a station; zero outside its times."""

    kind: Literal["recorded_force"] = "recorded_force"
    station: Place | None = key(PUSHED, None)
    time: Annotated[tuple[Time, ...], Listed] = key(RECORD)
    force: Annotated[tuple[Newton, ...], Listed] = key("as many as times; a smooth curve goes through them")
    direction: Angle = key(DIRECTION, 0.0)

    @model_validator(mode="after")
    def _consistent(self) -> RecordedForce:
        _recorded(self.time, self.force, "force")
        return self


Excitation = Annotated[BaseMotion | RecordedBaseMotion | HarmonicForce | RecordedForce, Field(discriminator="kind")]


# A ring partly filled with liquid, in place of balls.


class LiquidRing(Part):
    """A hollow ring around a planar rotor, partly filled with liquid (Wolf 1968), as on the drums of washing machines.

    Give the ``layer`` of liquid that the turning rotor would have without deflection, or the mass of the ``liquid``. Without
    ``width`` there is no inner wall.
    """

    name: Label = key("used in messages and results", "")
    radius: Length = key("of the outer wall, inside", symbol="R")
    height: Length = key("along the axis, inside", symbol="L")
    width: Length | None = key("from the outer to an inner wall, inside", None)
    layer: Length | None = key("thickness on the outer wall while the rotor turns; this or `liquid`", None)
    liquid: Mass | None = key("mass of the liquid; this or `layer`", None)
    fluid: Fluid = key("the liquid; its viscosity does not affect a steady whirl")

    @model_validator(mode="after")
    def _filled(self) -> LiquidRing:
        if (self.layer is None) == (self.liquid is None):
            raise ValueError("give either 'layer' or 'liquid', the mass")
        if self.fluid.lag != "none":
            raise ValueError("fluid.lag: the liquid of a ring turns with it in the answers there are; leave it out")
        room = self.radius if self.width is None else min(self.width, self.radius)
        if self.width is not None and self.width >= self.radius:
            raise ValueError(
                f"width: given {1e3 * self.width:.4g} mm, but the outer wall is at {1e3 * self.radius:.4g} mm; must be smaller"
            )
        if self.layer is not None and self.layer >= room:
            raise ValueError(
                f"layer: given {1e3 * self.layer:.4g} mm, which fills the ring; must be less than {1e3 * room:.4g} mm, because "
                "only liquid with a free surface balances"
            )
        return self


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
        return table + picture_html(self, f"drawing of {self.name}", "machine")

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
            raise MachineError.of("Machine", problems)
        return self

    @model_validator(mode="after")
    def _known_by_its_modes(self) -> Machine:
        if not isinstance(self.rotor, ModalRotor) or self.rotor.knows_whole:
            return self
        unknown = "the modes of a rotor at one plane do not say how its other parts move with"
        if not self.rotor.one_plane:
            unknown = (
                "without the 'participation' of each mode its shapes at stations do not say how the whole moves with"
            )
        problems: list[Problem] = []
        if self.axis == "horizontal" and float(self.gravity):
            problems.append((("axis",), f"{unknown} its weight; take a vertical axis, or 'gravity = 0'"))
        for i, shaken in enumerate(self.excitations):
            if isinstance(shaken, (BaseMotion, RecordedBaseMotion)):
                problems.append((("excitations", i), f"{unknown} its base; take another rotor, or a force"))
        if problems:
            raise MachineError.of("Machine", problems)
        return self

    @model_validator(mode="after")
    def _placed(self) -> Machine:
        names = [station.name for station in self.stations]
        problems: list[Problem] = [
            (("stations", i, "name"), f"{name!r} is given twice") for i, name in enumerate(names) if name in names[:i]
        ]
        planar, a_rotor = self.rotor.one_plane, f"a {self.rotor.kind} rotor"
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
            raise MachineError.of("Machine", problems)
        return self
