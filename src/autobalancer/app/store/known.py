"""What the forms of analyses need to know of a machine: its speeds, what may be varied, and what is not for it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from autobalancer.assembly.profile import highest_prescribed
from autobalancer.assembly.quantities import value_of
from autobalancer.errors import AutobalancerError
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.machine.plain_names import QUANTITIES, named_unit

RPM = 30.0 / math.pi
UNITS = {"m^2/s": (1e6, "mm^2/s"), "kg": (1e3, "g"), "m": (1e3, "mm"), "kg*m": (1e6, "g*mm")}  # in which people write
LEFT_OUT = ("count", "temperature")  # whole numbers, and what has no zero
DEEP = "is for balls in races; here they move freely in a deep chamber, which the pages Run and Archive are for"
GRAVITY = (
    "is for machines without gravity across the axis; with it balls never rest in the rotor. Run it, or take the basin"
)
NO_BALLS = "asks what balls do, and this machine has none"
NOTHING = "needs a viscosity, a drag or another quantity that all races share, and this machine has none"
LIQUID = "does not know liquid with a free surface; take the liquid rings out of the machine"


@dataclass(frozen=True)
class Known:
    """Speeds in rpm, nan where there are none; of each quantity that may be varied its value and unit, as people write them."""

    machine: Machine
    low: float
    high: float
    speed: float  # the last that the drive prescribes
    critical: float  # the highest critical speed that a run passes
    quantities: dict[str, tuple[float, str]]
    balls: int

    def refusal(self, *, balls: bool, steady: bool, varied: bool) -> str:
        """Why a question is not for this machine, that asks about balls, about steady states, or over a quantity; else empty."""
        if self.machine.liquid_rings:
            return LIQUID
        if balls and not self.balls:
            return NO_BALLS
        if steady and self.machine.axis == "horizontal" and self.machine.gravity > 0.0:
            return GRAVITY
        return NOTHING if varied and not self.quantities else ""


def known_of(machine: Machine) -> Known:
    """What is known of a machine without running or compiling anything.

    Speeds are from half the lowest critical speed to somewhat above the highest speed of the drive.
    """
    from autobalancer.stability.summary.rotor import frame_of

    highest = highest_prescribed(machine) or 0.0
    try:
        critical = [speed for speed in frame_of(machine, highest or None).critical_speeds if speed > 0.0]
    except AutobalancerError:  # the question itself says what is wrong
        critical = []
    lowest = min(critical, default=0.0)
    top = max(1.15 * highest, 1.6 * lowest)
    passed = max((speed for speed in critical if speed < (highest or top)), default=lowest)
    balls = sum(group.count for one in machine.balancers for race in one.races for group in race.balls)
    low = 0.5 * lowest if lowest else 0.02 * top
    last = value_of(machine, "speed")
    found = (low, top, last if last > 0.0 else math.nan, passed)
    speeds = [RPM * speed if speed > 0.0 else math.nan for speed in found]
    return Known(machine, speeds[0], speeds[1], speeds[2], speeds[3], varied(machine), balls)


def varied(machine: Machine) -> dict[str, tuple[float, str]]:
    """The quantities with one value above zero in this machine; viscosity and drag first."""
    found = {}
    for name in QUANTITIES:
        if name in LEFT_OUT or (name == "unbalance" and not isinstance(machine.rotor, PlanarRotor)):
            continue
        try:
            value = value_of(machine, name)
        except (AutobalancerError, AttributeError):
            continue
        if value > 0.0:
            scale, unit = UNITS.get(named_unit(name), (1.0, named_unit(name)))
            found[name] = (scale * value, unit)
    return found


def why_not_at_all(machine: object) -> str:
    """Why no analysis is for what is described; empty for a machine with balls in races."""
    if isinstance(machine, ChamberMachine):
        return DEEP
    return (
        ""
        if isinstance(machine, Machine)
        else "waits until the machine is possible; the page Describe says what is missing"
    )
