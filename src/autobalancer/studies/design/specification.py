"""What a designer asks: machine, operation, unbalance, space, temperature, limits, candidates and how they are searched."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field, PlainValidator, field_validator

from autobalancer.catalog.product_tables import bearings, blend, catalog_name, fluid
from autobalancer.errors import CatalogError, Problem, QuestionError
from autobalancer.files.machine_file import machine_text
from autobalancer.laws.viscosity import blend_viscosity
from autobalancer.machine import Drag, Machine
from autobalancer.machine.part import (
    LIST,
    TABLE,
    TEXT,
    ByForm,
    Density,
    Duration,
    Inertia,
    Label,
    Length,
    Listed,
    Name,
    Offset,
    Positive,
    Quantity,
    Question,
    key,
    quantity_of,
)
from autobalancer.machine.plugins import OneOf
from autobalancer.random_numbers import GREATEST
from autobalancer.results.answers.answer import Answer
from autobalancer.studies.study.study_spec import Varied
from autobalancer.units import shortened

# What may fill a race of a design: a fluid of the catalog, or a blend of two, at any temperature.


@dataclass(frozen=True)
class Filling:
    """A fluid by its name, or a blend: ``share`` of ``first`` by mass in ``second``, chosen for a viscosity at 25 °C."""

    name: str
    second: str = ""
    share: float = 1.0

    @property
    def label(self) -> str:
        """As people say it."""
        if not self.second:
            return self.name
        return f"{100.0 * self.share:.3g} % {self.name} in {self.second}"

    def at(self, temperature: float) -> tuple[float, float]:
        """Density (kg/m^3) and kinematic viscosity (m^2/s) at a temperature (K).

        Raises
        ------
        CatalogError
            If the catalog does not know it at this temperature.
        """
        return _at(self, float(temperature))

    def keys(self, temperature: float) -> dict[str, Any]:
        """Keys of a machine file that describe it."""
        if not self.second:
            return {"name": self.name, "temperature": temperature}
        density, viscosity = self.at(temperature)
        return {"density": density, "viscosity": viscosity}


def blended(first: str, second: str, viscosity: float) -> Filling:
    """The blend that has a kinematic viscosity (m^2/s) at 25 °C.

    Raises
    ------
    QuestionError, CatalogError
        If a fluid is unknown, or the viscosity does not lie between those of the two.
    """
    filling = blend(first, second, viscosity)
    return Filling(filling.first, filling.second, filling.fraction)


@cache
def _at(filling: Filling, temperature: float) -> tuple[float, float]:
    one = fluid(filling.name, temperature)
    if not filling.second:
        return one.density, one.viscosity
    two, w = fluid(filling.second, temperature), filling.share
    density = 1.0 / (w / one.density + (1.0 - w) / two.density)
    return density, float(blend_viscosity(w, (one.viscosity, one.density), (two.viscosity, two.density)))


def known_fluid(name: str, *path: str | int) -> str:
    """A name of the catalog as the catalog writes it.

    Raises
    ------
    QuestionError
        If the catalog has no such fluid.
    """
    try:
        return catalog_name(name)
    except CatalogError as error:
        raise QuestionError(str(error), path) from None


# The tables of a specification file and their keys.


STALL, MARGIN, PRESSURE, SHARE = "stall_probability", "border_margin", "contact_pressure", "share"
ENOUGH, MASS, OUTER, CAPABILITY = "capability_margin", "ball_mass", "outer", "capability"
ROOM = 298.15  # K
EXAMPLE = 'fluids = ["silicone oil 5", "silicone oil 20"]'
Whole = Annotated[int, Field(strict=True, ge=1, le=GREATEST)]
Wholes = Annotated[tuple[Whole, ...], Field(min_length=1), Listed]
Sizes = Annotated[tuple[float, ...], Quantity("m", positive=True, shape="values or range")]
Objective = Literal[
    "peak_deflection", "residual_vibration", "residual_unbalance", "settling_time", "ball_mass", "outer"
]


def _all_bearings(argument: Any) -> Any:
    return tuple(bearing.designation for bearing in bearings()) if argument == "all" else argument


def _fewest(argument: Any) -> Any:
    return None if argument == "fewest" else argument


class Operation(Question):
    """Speeds at which the machine works, and a straight way up and down; without it the drive of the machine, such as a motor."""

    speed: Annotated[tuple[float, ...], Quantity("rad/s", positive=True, shape="values")] = key(
        "operating speeds; the highest of the drive unless given", ()
    )
    run_up: Duration | None = key("time to the speed", None)
    hold: Duration | None = key("time at the speed", None)
    coast_down: Duration | None = key("time back to rest", None)

    @property
    def speeds(self) -> tuple[float, ...]:
        """Each speed once, ascending, rad/s."""
        return tuple(sorted(set(map(float, self.speed))))


class Space(Question):
    """The room for all races of a plane."""

    bore: Offset = key("free bore", 0.0)
    outer: Offset | None = key("outer diameter", None)
    width: Offset | None = key("width along the axis", None)
    wall: Offset = key("wall around a race that is no bearing", 0.0)

    def contradictions(self) -> Iterator[Problem]:
        """A bore that leaves no room."""
        if self.outer is not None and not self.bore + 2.0 * self.wall < self.outer:
            bore, outer = 1e3 * self.bore, 1e3 * self.outer
            text = f"contradicts space.outer: a bore of {bore:g} mm leaves no room within an outer diameter of {outer:g} mm"
            yield ("bore",), text


class Limits(Question):
    """What designs must keep; what is not given is not limited."""

    peak_deflection: Length | None = key("greatest deflection on the way up or down", None)
    residual_vibration: Length | None = key("vibration at the end of a run-up", None)
    residual_unbalance: Annotated[float, Quantity("kg*m", positive=True)] | None = key(
        "residual unbalance at the end of a run-up", None
    )
    settling_time: Duration | None = key("settling time of the last ball", None)
    stall_probability: Positive | None = key("share of the runs in which a ball or the rotor stalls", None)
    border_margin: Positive | None = key("least (speed - border) / border", None)
    capability_margin: Positive | None = key("least capability over the largest unbalance; 1.5 to 2 is usual", None)
    contact_pressure: Annotated[float, Quantity("Pa", positive=True)] | None = key("between ball and race", None)
    share: Positive | None = key("of the runs that must keep each limit; 0.95 unless given", None)

    @field_validator(STALL, SHARE)
    @classmethod
    def _below_one(cls, value: float | None) -> float | None:
        if value is not None and not value < 1.0:
            raise ValueError(f"given {value:g}; must be between 0 and 1")
        return value

    @field_validator(ENOUGH)
    @classmethod
    def _one_or_more(cls, value: float | None) -> float | None:
        if value is not None and value < 1.0:
            raise ValueError(f"given {value:g}; it is capability over largest unbalance, 1 or more, such as 1.5")
        return value


class Blend(Question):
    """A blend of two oils of the catalog, chosen for its viscosity at 25 °C."""

    blend: tuple[Name, Name] = key("names of the oils")
    viscosity: Annotated[tuple[float, ...], Quantity("m^2/s", positive=True, shape="values or range")] = key(
        "of each blend, or a range that is searched without steps"
    )


class Candidates(Question):
    """What there is to choose from; without bearings and sizes it is the race of the machine."""

    bearings: Annotated[
        tuple[Name, ...], Field(min_length=1), BeforeValidator(_all_bearings, Literal["all"] | tuple[str, ...])
    ] = key("designations of the catalog, whose outer rings are the races", (), value='"all" or list of texts')
    orbit_radius: Sizes = key("of free races", ())
    ball_diameter: Sizes = key("of the balls of free races", ())
    count: Annotated[Wholes | None, BeforeValidator(_fewest, Literal["fewest"] | int | tuple[int, ...])] = key(
        "balls of a race; the fewest that have the margin of the capability unless given",
        None,
        value='"fewest" or list of whole numbers, ≥ 1',
    )
    fluids: Annotated[
        tuple[
            Annotated[Annotated[Name, TEXT] | Annotated[tuple[Name, ...], LIST] | Annotated[Blend, TABLE], ByForm], ...
        ],
        Field(min_length=1),
    ] = key("names, lists with a fluid for each race, or blends", (), value="list of texts, lists of texts, or tables")
    races: Wholes = key("of a plane", (1,))
    planes: Annotated[
        tuple[Annotated[Annotated[Name, TEXT] | Annotated[tuple[Name, ...], LIST], ByForm], ...], Field(min_length=1)
    ] = key("stations that hold a balancer, or lists of some", (), value="list of texts, or of lists of texts")
    material: Name | None = key("of the balls", None)
    density: Density | None = key("of the balls", None)
    drag: Annotated[Drag, OneOf(Drag)] | None = key(
        "law of the drag of the fluid on the balls; that of the machine unless given", None
    )

    def contradictions(self) -> Iterator[Problem]:
        """Nothing to choose from, or sizes from two sources."""
        if not self.model_fields_set:
            yield (), f"says nothing; give what there is to choose from, such as {EXAMPLE}"
        if self.bearings and (self.orbit_radius or self.ball_diameter):
            yield ("bearings",), "have their own sizes; give them, or 'orbit_radius' and 'ball_diameter'"


class Search(Question):
    """How designs are run and compared."""

    members: Annotated[int, Field(strict=True, ge=10, le=GREATEST)] = key("runs of each design", 200)
    budget: Whole = key("designs that are run at most; of more a search", 60)
    generations: Whole = key("of a search", 6)
    objectives: tuple[Objective, Objective] = key("two that should be small", ("peak_deflection", "settling_time"))
    seed: Annotated[int, Field(strict=True, ge=0, le=GREATEST)] = key("equal seeds, equal numbers", 0)
    tolerance: Annotated[float, Field(strict=True, ge=1e-13, le=1e-2)] = key("relative, of the integration", 1e-5)
    settling_from: Literal["run-up", "release"] = key("what settling times count from", "run-up")

    @field_validator("objectives")
    @classmethod
    def _two(cls, value: tuple[str, str]) -> tuple[str, str]:
        if value[0] == value[1]:
            raise ValueError(f"given {list(value)}; give two of {', '.join(OBJECTIVES)}")
        return value


def _file(argument: Any) -> Any:
    if not isinstance(argument, (str, Path)):
        raise ValueError(
            f'given {shortened(argument)}; give the file of a measured frequency response, such as "hammer.csv"'
        )
    return argument


class MeasuredReceptance(Question):
    """A measured rotor, in place of that of the machine or without a machine."""

    receptance: Annotated[str | Path, PlainValidator(_file, json_schema_input_type=str)] = key(
        "file of a measured frequency response, seen from this file"
    )
    band: Annotated[tuple[float, float], Quantity("rad/s", non_negative=True, shape="range")] | None = key(
        "frequencies that are used", None
    )
    modes: Whole | None = key("number of modes", None)
    function: Whole | None = key("which frequency response of a universal file", None)
    mass_added: Annotated[float, Quantity("kg", non_negative=True)] | None = key(
        "what was fixed to the rotor in the test and is no part of it, such as accelerometer and balls", None
    )
    inertia: Inertia | None = key("about the shaft, where a torque drives", None)


class Specification(Question):
    """A machine, what it must do, and what there is to choose from."""

    machine: Any = key(
        "machine file, seen from this file, or the name of a published rig: rotor, supports, drive, friction, and what the "
        "candidates do not change",
        None,
        value="text",
    )
    rotor: MeasuredReceptance | None = key("in place of the rotor of the machine, or without a machine", None)
    name: Label = key("of the design", "")
    operation: Operation = key("speeds, and the way there", Operation(), default_text="–")
    unbalance: Annotated[tuple[float, float], Quantity("kg*m", non_negative=True, shape="range")] | None = key(
        "on rotors that tilt all unbalances change in proportion, and this is their resultant; that of the machine unless given",
        None,
    )
    space: Space = key("of all races of a plane", Space(), default_text="–")
    temperature: Annotated[tuple[float, float], Quantity("K", positive=True, shape="range")] = key(
        "of the fluids", (ROOM, ROOM), default_text="25 °C"
    )
    limits: Limits = key("what designs must keep", Limits(), default_text="–")
    candidates: Candidates = key("what there is to choose from")
    search: Search = key("how designs are run and compared", Search(), default_text="–")
    scatter: Varied = key(
        "what else varies from machine to machine or run to run, as in studies", {}, value="tables of distributions"
    )

    def contradictions(self) -> Iterator[Problem]:
        """No rotor, or nothing to balance."""
        if self.machine is None and self.rotor is None:
            text = 'missing; give the path of a machine file or the name of a published rig, such as machine = "rotor.toml"'
            yield ("machine",), f"{text}, or a measured [rotor]"
        if self.unbalance is not None and not self.unbalance[1] > 0.0:
            yield ("unbalance",), "given 0; the largest must be greater than zero"


def measured_by(limits: type[Limits], *names: str) -> dict[str, tuple[str, str]]:
    """Limits on numbers of a run: unit, and what it is."""
    held = {name: quantity_of(limits, name) for name in names}
    return {
        name: (one.unit.replace("*", " "), str(limits.model_fields[name].description))
        for name, one in held.items()
        if one is not None
    }


MEASURED = measured_by(Limits, "peak_deflection", "residual_vibration", "residual_unbalance", "settling_time")
OBJECTIVES = {**{name: unit for name, (unit, _) in MEASURED.items()}, MASS: "kg", OUTER: "m"}


# A specification that was read.


@dataclass(frozen=True)
class Options:
    """What there is to choose from, with the names of the catalog."""

    bearings: tuple[str, ...] = ()
    orbit_radii: tuple[float, ...] = ()
    ball_diameters: tuple[float, ...] = ()
    counts: tuple[int, ...] = ()  # empty: the fewest that balance the largest unbalance
    fluids: tuple[tuple[Filling, ...], ...] = ()  # of each choice one for each race of a plane; or one for all of them
    races: tuple[int, ...] = (1,)
    planes: tuple[tuple[str, ...], ...] = ((),)
    balls: dict[str, Any] = field(default_factory=dict)  # keys of balls: material or density
    drag: Drag | None = None
    free: tuple[tuple[str, float, float], ...] = ()  # name, from, to of what is searched without steps
    blend: tuple[str, str] | None = None  # the oils whose blend is searched


class Asked:
    """What designs of every kind of machine are judged by; ``run_limits`` has unit and meaning of what is limited in runs."""

    limits: dict[str, float]
    run_limits: ClassVar[Mapping[str, tuple[str, str]]] = MEASURED
    usual_share: ClassVar[float] = 0.95

    @property
    def objectives(self) -> tuple[str, str]:
        """Two numbers that should be small."""
        raise NotImplementedError

    @property
    def share(self) -> float:
        """Share of the runs that must keep each limit."""
        return self.limits.get(SHARE, self.usual_share)

    @property
    def capability_margin(self) -> float:
        """How many times the largest unbalance the balls must be able to balance."""
        return self.limits.get(ENOUGH, 1.0)


@dataclass(frozen=True)
class Spec(Asked):
    """A specification, read and checked; numbers in SI."""

    name: str
    machine: Machine
    operation: Operation
    unbalance: tuple[float, float]
    space: Space
    temperature: tuple[float, float]
    limits: dict[str, float]
    options: Options
    search: Search
    scatter: dict[str, Any] = field(default_factory=dict)  # tables of distributions, as in study files
    measured: Answer | None = None  # what the rotor was fitted to
    remarks: tuple[str, ...] = ()  # how numbers without a unit were read where that is hardly meant

    @property
    def slowest(self) -> float:
        """The lowest operating speed, rad/s."""
        return min(self.operation.speeds)

    @property
    def fastest(self) -> float:
        """The highest operating speed, rad/s."""
        return max(self.operation.speeds)

    @property
    def temperatures(self) -> tuple[float, ...]:
        """Temperatures (K) at which borders are asked: both ends and the middle."""
        low, high = self.temperature
        return (low,) if low == high else (low, 0.5 * (low + high), high)

    @property
    def objectives(self) -> tuple[str, str]:
        """Two numbers that should be small."""
        return self.search.objectives

    def identity(self) -> dict[str, Any]:
        """What makes it this specification and no other, as plain data."""
        return {
            "machine": machine_text(self.machine),
            "operation": repr(self.operation),
            "unbalance": list(self.unbalance),
            "space": repr(self.space),
            "temperature": list(self.temperature),
            "limits": self.limits,
            "options": repr(self.options),
            "search": repr(self.search),
            "scatter": repr(self.scatter),
        }
