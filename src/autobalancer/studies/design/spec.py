"""What a designer asks: machine, operation, unbalance, space, temperature, limits, candidates and how they are searched."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from autobalancer.catalog.fluid_table import blend, catalog_name, fluid
from autobalancer.errors import CatalogError, QuestionError
from autobalancer.files.machine_file import machine_text
from autobalancer.laws.viscosity import blend_viscosity
from autobalancer.machine import Machine
from autobalancer.results.recorded import SETTLING_FROM
from autobalancer.rotordynamics.receptance.answer import FittedReceptance

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
    found = blend(first, second, viscosity)
    return Filling(found.first, found.second, found.fraction)


@cache
def _at(filling: Filling, temperature: float) -> tuple[float, float]:
    one = fluid(filling.name, temperature)
    if not filling.second:
        return one.density, one.viscosity
    two, w = fluid(filling.second, temperature), filling.share
    density = 1.0 / (w / one.density + (1.0 - w) / two.density)
    return density, float(blend_viscosity(w, (one.viscosity, one.density), (two.viscosity, two.density)))


def known_fluid(where: str, name: str) -> str:
    """A name of the catalog as the catalog writes it.

    Raises
    ------
    QuestionError
        If the catalog has no such fluid.
    """
    try:
        return catalog_name(name)
    except CatalogError as error:
        raise QuestionError(f"{where}: {error}") from None


MEASURED = {  # limits on numbers of a run: the name of the measure, its unit, and what it is
    "peak_deflection": ("peak_deflection", "m", "greatest deflection on the way up or down"),
    "residual_vibration": ("residual_vibration", "m", "vibration at the end of a run-up"),
    "residual_unbalance": ("residual_unbalance", "kg m", "residual unbalance at the end of a run-up"),
    "settling_time": ("settling_time", "s", "settling time of the last ball"),
}
STALL, MARGIN, PRESSURE, SHARE = "stall_probability", "border_margin", "contact_pressure", "share"
ENOUGH = "capability_margin"
MASS, OUTER, CAPABILITY = "ball_mass", "outer", "capability"
OBJECTIVES = {**{name: unit for name, (_, unit, _) in MEASURED.items()}, MASS: "kg", OUTER: "m"}


@dataclass(frozen=True)
class Operation:
    """Speeds (rad/s) at which the machine works, and how it gets there and back (s); 0 where the drive of the machine says it."""

    speeds: tuple[float, ...]
    run_up: float = 0.0
    hold: float = 0.0
    coast_down: float = 0.0


@dataclass(frozen=True)
class Space:
    """Free bore, outer diameter and width along the axis, and the wall around a race that is no bearing; m."""

    bore: float = 0.0
    outer: float = math.inf
    width: float = math.inf
    wall: float = 0.0


@dataclass(frozen=True)
class Options:
    """What there is to choose from. Sizes may be pairs (from, to), which are searched without steps."""

    bearings: tuple[str, ...] = ()
    orbit_radii: tuple[float, ...] = ()
    ball_diameters: tuple[float, ...] = ()
    counts: tuple[int, ...] = ()  # empty: the fewest that balance the largest unbalance
    fluids: tuple[tuple[Filling, ...], ...] = ()  # of each choice one for each race of a plane; or one for all of them
    races: tuple[int, ...] = (1,)
    planes: tuple[tuple[str, ...], ...] = ((),)
    balls: dict[str, Any] = field(default_factory=dict)  # keys of balls: material or density
    drag: dict[str, Any] | None = None
    free: tuple[tuple[str, float, float], ...] = ()  # name, from, to of what is searched without steps
    blend: tuple[str, str] | None = None  # the oils whose blend is searched


@dataclass(frozen=True)
class Search:
    """How designs are run and compared."""

    members: int
    budget: int
    generations: int
    objectives: tuple[str, str]
    seed: int
    tolerance: float
    settling_from: str = SETTLING_FROM[0]


@dataclass(frozen=True)
class Spec:
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
    measured: FittedReceptance | None = None  # what the rotor was fitted to
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
    def share(self) -> float:
        """Share of the runs that must keep each limit."""
        return self.limits.get(SHARE, 0.95)

    @property
    def capability_margin(self) -> float:
        """How many times the largest unbalance the balls must be able to balance."""
        return self.limits.get(ENOUGH, 1.0)

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
