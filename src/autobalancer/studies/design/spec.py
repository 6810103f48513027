"""What a designer asks: machine, operation, unbalance, space, temperature, limits, candidates and how they are searched."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from autobalancer.files.machine_file import machine_text
from autobalancer.machine import Machine
from autobalancer.results.recorded import SETTLING_FROM
from autobalancer.rotordynamics.receptance.answer import FittedReceptance
from autobalancer.studies.design.fluids import Filling

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
