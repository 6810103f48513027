"""What rules a candidate out before any run: space, fluid, capability, pressure; then the exact borders."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from autobalancer.errors import AutobalancerError
from autobalancer.laws.capabilities import ball_mass, largest_count
from autobalancer.laws.impacts import STEEL, greatest_pressure
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.results.number_text import moment_text
from autobalancer.stability.summary import frame_of
from autobalancer.studies.design.candidate import (
    Candidate,
    capability_of_races,
    densities,
    density_of_balls,
    machine_of,
    planes_of,
)
from autobalancer.studies.design.spec import MARGIN, PRESSURE, Spec
from autobalancer.tables import rpm_and_si

ROUNDING = 1e-9


@dataclass
class Design:
    """A candidate and all that is found of it; SI, nan where it was not asked. ``stage`` is where it was ruled out."""

    candidate: Candidate
    stage: str = ""
    reason: str = ""
    excess: float = 0.0  # how far it misses what rules it out, over what is allowed
    capability: float = math.nan  # of one plane
    margin: float = math.nan  # capability over what is to be balanced, the least of all planes
    ball_mass: float = math.nan  # of all balls
    pressure: float = math.nan
    viscosity: tuple[float, float] = (math.nan, math.nan)  # cold and warm, of the first race
    release: float = math.nan  # greatest over temperatures and unbalances; infinite: never released
    border: float = math.nan
    machine: Machine | None = None  # at the middle of the temperatures, with the largest unbalance
    numbers: dict[str, float] = field(default_factory=dict)  # of the runs
    twins: list[str] = field(default_factory=list)  # other bearings whose ring is the same race
    drag_warning: str = ""  # where its balls leave the range of their drag law
    passage: str = ""  # where its passage is worse than without balls

    def rule_out(self, stage: str, reason: str, excess: float = math.inf) -> None:
        """Say where and why it stops."""
        self.stage, self.reason, self.excess = stage, reason, excess


def screened(spec: Spec, one: Candidate) -> Design:
    """A candidate after the closed forms; ``reason`` is empty if it stays."""
    found = Design(one)
    for question in (_space, _fluid, _capability, _pressure, _machine, _critical):
        question(spec, found)
        if found.reason:
            break
    return found


def _space(spec: Spec, found: Design) -> None:
    space, ring, one = spec.space, found.candidate.ring, found.candidate
    width, outer = ring.width * one.races, math.inf if space.outer is None else space.outer
    widest = math.inf if space.width is None else space.width
    if ring.bore < space.bore * (1.0 - ROUNDING):
        found.rule_out(
            "space", f"its bore of {_mm(ring.bore)} is below {_mm(space.bore)}", (space.bore - ring.bore) / space.bore
        )
    elif ring.outer > outer * (1.0 + ROUNDING):
        found.rule_out(
            "space",
            f"its outer diameter of {_mm(ring.outer)} is above {_mm(outer)}",
            ring.outer / outer - 1.0,
        )
    elif width > widest * (1.0 + ROUNDING):
        found.rule_out("space", f"its width of {_mm(width)} is above {_mm(widest)}", width / widest - 1.0)
    elif ring.orbit_radius <= 0.5 * ring.ball_diameter:
        found.rule_out("space", "its balls are larger than its race")
    elif one.count > (room := largest_count(ring.orbit_radius, ring.ball_diameter)):
        found.rule_out("space", f"its race has room for {room} of {one.count} balls", one.count / room - 1.0)


def _fluid(spec: Spec, found: Design) -> None:
    one = found.candidate
    try:
        dense = max(densities(spec, one.fillings))
        known = [tuple(filling.at(temperature)[1] for temperature in spec.temperature) for filling in one.fillings]
        if known:
            found.viscosity = known[0][0], known[0][1]
    except AutobalancerError as reason:
        found.rule_out("fluid", str(reason))
        return
    if (heavy := density_of_balls(spec)) <= dense:
        found.rule_out("fluid", f"its balls of {heavy:.0f} kg/m³ float in a fluid of {dense:.0f} kg/m³", dense / heavy)


def _capability(spec: Spec, found: Design) -> None:
    one, planes = found.candidate, planes_of(spec, found.candidate.planes)
    found.capability = capability_of_races(spec, one)
    ring = one.ring
    if one.count * one.races == 1:
        found.rule_out("capability", "one ball alone balances an unbalance of exactly its own moment only")
        return
    found.ball_mass = planes * one.races * one.count * ball_mass(ring.ball_diameter, density_of_balls(spec))
    if isinstance(spec.machine.rotor, PlanarRotor):
        _enough(spec, found, planes * found.capability, spec.unbalance[1], "")


def _enough(spec: Spec, found: Design, have: float, need: float, where: str) -> None:
    asked = spec.capability_margin
    found.margin = min(have / need if need > 0.0 else math.inf, found.margin if found.margin > 0.0 else math.inf)
    if have < asked * need * (1.0 - ROUNDING):
        times = f", {have / need:.3g} times as much; needed is {asked:g} times" if asked > 1.0 else ""
        found.rule_out(
            "capability",
            f"its balls{where} can balance {moment_text(have)} of {moment_text(need)}{times}",
            asked * need / max(have, 1e-12) - 1.0,
        )


def _pressure(spec: Spec, found: Design) -> None:
    ring, speed = found.candidate.ring, spec.fastest
    radius = 0.5 * ring.ball_diameter
    heavy = density_of_balls(spec) - min(densities(spec, found.candidate.fillings))  # less the fluid displaced
    force = ball_mass(ring.ball_diameter, heavy) * ring.orbit_radius * speed**2
    found.pressure = greatest_pressure(force, STEEL, radius, ring.orbit_radius + radius)
    allowed = spec.limits.get(PRESSURE, math.inf)
    if found.pressure > allowed:
        found.rule_out(
            "pressure",
            f"a ball presses with {1e-6 * found.pressure:.0f} MPa on its race at {rpm_and_si(speed)}, allowed are "
            f"{1e-6 * allowed:.4g} MPa",
            found.pressure / allowed - 1.0,
        )


def _machine(spec: Spec, found: Design) -> None:
    """Build it, and of a rotor that tilts ask what each plane has to balance."""
    one = found.candidate
    try:
        middle = 0.5 * sum(spec.temperature)
        found.machine = machine_of(spec, one, middle, spec.unbalance[1])
        if not isinstance(spec.machine.rotor, PlanarRotor):
            for plane in frame_of(found.machine, spec.slowest).stations:
                if not found.reason:
                    _enough(spec, found, plane.capability, plane.required, f" at {plane.name!r}")
    except AutobalancerError as reason:
        found.rule_out("fluid" if "fluid" in str(reason) else "space", str(reason))


def _critical(spec: Spec, found: Design) -> None:
    """No border lies below the lowest critical speed: known at once, where borders take a while."""
    from autobalancer.rotordynamics.campbell import critical_speeds

    assert found.machine is not None
    try:
        speeds = critical_speeds(found.machine)["critical_speed"].values
    except AutobalancerError:  # its borders say what they can
        return
    allowed = spec.slowest / (1.0 + spec.limits.get(MARGIN, 0.0))
    if speeds.size and float(speeds[0]) > allowed:
        found.rule_out(
            "border",
            f"balls balance above the critical speed of {rpm_and_si(float(speeds[0]))} only; needed is {rpm_and_si(allowed)} or "
            "less",
            float(speeds[0]) / allowed - 1.0,
        )


def _mm(length: float) -> str:
    return f"{1e3 * length:.4g} mm"
