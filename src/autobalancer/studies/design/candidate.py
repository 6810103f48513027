"""One candidate: races, balls and fluids in numbers; and all candidates of a specification."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from itertools import product
from typing import Any

from autobalancer.assembly.quantities import changed_part, with_quantity
from autobalancer.catalog.product_tables import bearing, fluid, material
from autobalancer.catalog.resolve import resolve, settled
from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.laws.capabilities import ball_mass, capability, largest_count, needed_count
from autobalancer.laws.impacts import STEEL, greatest_pressure
from autobalancer.machine import Balancer, Balls, Machine, PlanarRotor, PrescribedSpeed, Race, RunPlan, Table
from autobalancer.results.display_units import moment_text
from autobalancer.stability.border import Border
from autobalancer.stability.maps.curve import minimum_viscosity
from autobalancer.stability.maps.exact import borders
from autobalancer.stability.summary import frame_of
from autobalancer.studies.design.specification import MARGIN, PRESSURE, Filling, Spec
from autobalancer.tables import rpm_and_si


@dataclass(frozen=True)
class Ring:
    """A race: its bearing, if it is one, and sizes in m. ``bore``, ``outer`` and ``width`` are what one race takes up."""

    bearing: str
    orbit_radius: float
    ball_diameter: float
    bore: float
    outer: float
    width: float

    @property
    def label(self) -> str:
        """As people say it."""
        return self.bearing or f"orbit {1e3 * self.orbit_radius:.4g} mm, balls {1e3 * self.ball_diameter:.4g} mm"


@dataclass(frozen=True)
class Candidate:
    """What a design is made of; ``fillings`` are the fluids of the races of a plane, one or one each; none: as in the machine."""

    ring: Ring
    count: int  # balls of a race
    races: int  # of a plane
    planes: tuple[str, ...]  # stations; empty: where the machine has its balancers
    fillings: tuple[Filling, ...]

    @property
    def label(self) -> str:
        """As people say it."""
        return ", ".join(self.parts().values())

    def parts(self) -> dict[str, str]:
        """The same piece by piece."""
        result = {"ring": self.ring.label, "count": f"{self.count} ball{'s' * (self.count != 1)}"}
        result |= {"races": f"{self.races} races"} if self.races > 1 else {}
        result |= {"planes": " and ".join(self.planes)} if self.planes else {}
        return result | ({"fluid": self.fluid} if self.fillings else {})

    @property
    def fluid(self) -> str:
        """Its fluids as text."""
        return " / ".join(filling.label for filling in self.fillings)

    def key(self) -> tuple[Any, ...]:
        """What makes two candidates the same design."""
        return self.ring, self.count, self.races, self.planes, self.fillings

    def motion(self) -> tuple[Any, ...]:
        """What its balls do depends on this only: rings of other bearings may have the same orbit and balls."""
        return self.ring.orbit_radius, self.ring.ball_diameter, *self.key()[1:]


def rings(spec: Spec) -> list[Ring]:
    """All races there are to choose from; of free sizes none, which :mod:`search` chooses."""
    options = spec.options
    if options.bearings:
        return [_of_bearing(name) for name in options.bearings]
    own = own_sizes(spec)
    radii = options.orbit_radii or ((own[0],) if own else ())
    sizes = options.ball_diameters or ((own[1],) if own else ())
    return [free_ring(spec, radius, size) for radius, size in product(radii, sizes)]


def own_sizes(spec: Spec) -> tuple[float, float] | None:
    """Orbit radius and ball diameter of the machine, if it has a race; m."""
    balls = resolve(spec.machine) if spec.machine.balancers else ()
    return (float(balls[0].orbit_radius), float(balls[0].diameter)) if balls else None


def _of_bearing(name: str) -> Ring:
    one = bearing(name)
    return Ring(one.designation, one.orbit_radius, one.ball_diameter, one.bore, one.outer, one.width)


def free_ring(spec: Spec, orbit_radius: float, ball_diameter: float) -> Ring:
    """A race that is no bearing, within its walls."""
    wall, reach = spec.space.wall, 0.5 * ball_diameter
    bore, outer = 2.0 * (orbit_radius - reach - wall), 2.0 * (orbit_radius + reach + wall)
    return Ring("", orbit_radius, ball_diameter, bore, outer, ball_diameter + 2.0 * wall)


def density_of_balls(spec: Spec) -> float:
    """kg/m^3: as the candidates say, else as in the machine, else that of steel."""
    given = spec.options.balls
    if "density" in given:
        return float(given["density"])
    if "material" in given:
        return material(str(given["material"])).density
    balls = resolve(spec.machine) if spec.machine.balancers else ()
    if balls and balls[0].volume:
        return float(f"{balls[0].mass / balls[0].volume:.12g}")  # without what rounding left
    return material("steel").density


def densities(spec: Spec, fillings: tuple[Filling, ...]) -> tuple[float, ...]:
    """Of the fluid of each race when it is cold and dense, kg/m^3; of the fluid of the machine where none is chosen."""
    if fillings:
        return tuple(filling.at(spec.temperature[0])[0] for filling in fillings)
    races = [race for balancer in spec.machine.balancers for race in balancer.races]
    part = races[0].fluid if races else None
    if part is None:
        return (0.0,)
    if part.density is not None:
        return (float(part.density),)
    return (fluid(str(part.name), spec.temperature[0]).density,)


def fewest(spec: Spec, ring: Ring, races: int, planes: int, fillings: tuple[Filling, ...]) -> int:
    """The fewest balls, two at least, with which all races balance the largest unbalance with the margin that is asked for.

    If no number does, the one that balances most.
    """
    share = spec.capability_margin * spec.unbalance[1] / (races * planes)
    try:
        dense, ball = max(densities(spec, fillings)), density_of_balls(spec)
        try:
            return max(2, needed_count(share, ring.orbit_radius, ring.ball_diameter, ball, fluid_density=dense))
        except AutobalancerError:
            room = largest_count(ring.orbit_radius, ring.ball_diameter)
            able = [
                capability(ring.orbit_radius, ring.ball_diameter, ball, count, fluid_density=dense)
                for count in range(2, room + 1)
            ]
            return 2 + able.index(max(able))
    except (AutobalancerError, ValueError):  # balls that float, or a race without room for two, are told of later
        return 2


def planes_of(spec: Spec, planes: tuple[str, ...]) -> int:
    """How many planes have balls."""
    return len(planes) or max(1, len(spec.machine.balancers))


def candidates(spec: Spec) -> Iterator[Candidate]:
    """All combinations, in order; without those whose races and fluids do not go together."""
    options = spec.options
    if (
        not options.counts
        and not isinstance(spec.machine.rotor, PlanarRotor)
        and any(planes_of(spec, plane) > 1 for plane in options.planes)
    ):
        raise QuestionError("candidates.count: 'fewest' is known for one plane; give numbers of balls")
    for ring, races, planes, fillings in product(rings(spec), options.races, options.planes, options.fluids or ((),)):
        yield from of_ring(spec, ring, races, planes, fillings)


def of_ring(
    spec: Spec, ring: Ring, races: int, planes: tuple[str, ...], fillings: tuple[Filling, ...]
) -> Iterator[Candidate]:
    """The candidates of one race with all numbers of balls."""
    if len(fillings) > 1 and len(fillings) != races:
        return
    for count in spec.options.counts or (fewest(spec, ring, races, planes_of(spec, planes), fillings),):
        yield Candidate(ring, count, races, planes, fillings)


def capability_of_races(spec: Spec, candidate: Candidate) -> float:
    """What the balls of one plane can balance when the fluid is cold, kg m.

    Raises
    ------
    QuestionError
        If the balls float.
    """
    dense = densities(spec, candidate.fillings)
    each = dense if len(dense) == candidate.races else dense * candidate.races
    ring, ball = candidate.ring, density_of_balls(spec)
    return sum(
        capability(ring.orbit_radius, ring.ball_diameter, ball, candidate.count, fluid_density=float(result))
        for result in each
    )


# The machine of a candidate: the machine of the specification with other balancers, fluids and drive.


CHANGED = ("bearing", "orbit_radius", "race_radius", "balls", "fluid", "drag", "width", "height")


def machine_of(spec: Spec, candidate: Candidate, temperature: float, unbalance: float | None = None) -> Machine:
    """The machine of a candidate with its fluids at a temperature (K).

    Parameters
    ----------
    spec
        Its machine gives rotor, drive, friction and whatever else a candidate does not change.
    candidate
        Races, balls and fluids.
    temperature
        K.
    unbalance
        kg m; without it that of the machine.

    Raises
    ------
    MachineError
        If no machine can be like that.
    """
    machine = settled(spec.machine)
    template = machine.balancers[0].races[0] if machine.balancers else None
    races = tuple(
        _race(
            spec,
            candidate,
            template,
            candidate.fillings[min(number, len(candidate.fillings) - 1)] if candidate.fillings else None,
            temperature,
        )
        for number in range(candidate.races)
    )
    if candidate.planes:
        balancers = tuple(Balancer(name=name, station=name, races=races) for name in candidate.planes)
    elif machine.balancers:
        balancers = tuple(
            changed_part(balancer, races=races, **_renamed(balancer.name, template, candidate))
            for balancer in machine.balancers
        )
    else:
        balancers = (Balancer(races=races),)
    result: Machine = changed_part(machine, balancers=balancers)
    return result if unbalance is None else with_quantity(result, "unbalance", unbalance)


def _renamed(name: str, template: Race | None, candidate: Candidate) -> dict[str, str]:
    """The name of a balancer with the new bearing, where it has the old one in it."""
    old = template.bearing if template is not None else None
    return {"name": name.replace(old, candidate.ring.bearing)} if old and candidate.ring.bearing and old in name else {}


def _race(spec: Spec, candidate: Candidate, template: Race | None, filling: Any, temperature: float) -> Race:
    ring, options = candidate.ring, spec.options
    kept = {} if template is None else {k: getattr(template, k) for k in template.model_fields_set if k not in CHANGED}
    if template is not None and template.fluid is not None and template.fluid.lag != "none":
        kept |= {"width": template.width, "height": template.height}
    size = {"bearing": ring.bearing} if ring.bearing else {"orbit_radius": ring.orbit_radius}
    drag: Any = options.drag if options.drag is not None else template.drag if template is not None else None
    return Race(
        **kept,
        **size,
        drag=drag,
        fluid=_fluid(template, filling, temperature),
        balls=(_balls(spec, candidate, template),),
    )


def _balls(spec: Spec, candidate: Candidate, template: Race | None) -> Balls:

    motion = template.balls[0].motion if template is not None else "rolling"
    stuff = dict(spec.options.balls) or {"density": density_of_balls(spec)}
    return Balls(count=candidate.count, diameter=candidate.ring.ball_diameter, motion=motion, **stuff)


def _fluid(template: Race | None, filling: Any, temperature: float) -> Any:
    part = template.fluid if template is not None else None
    if filling is None:
        return part if part is None or part.name is None else changed_part(part, temperature=temperature)
    kept = {} if part is None else {k: getattr(part, k) for k in ("virtual_mass", "lag") if k in part.model_fields_set}
    return {**kept, **filling.keys(temperature)}


def driven(spec: Spec, machine: Machine, speed: float, *, coasting: bool) -> Machine:
    """The machine with the run-up of the specification to a speed (rad/s), and with the coast-down behind it if ``coasting``."""
    way = spec.operation
    if not way.run_up:
        return machine
    held = way.run_up + (way.hold or 0.0)
    corners = [(0.0, 0.0), (way.run_up, speed), (held, speed)]
    corners += [(held + (way.coast_down or 0.0), 0.0)] if coasting else []
    time, speeds = zip(*corners, strict=True)
    drive = PrescribedSpeed(profile=Table(time=time, speed=speeds))
    changed: Machine = changed_part(machine, drive=drive, run=RunPlan(duration=time[-1]))
    return changed


# What rules a candidate out before any run: space, fluid, capability, pressure; then the exact borders.


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
    cure: Callable[[], str] = str  # what would let it pass, as the end of the reason: asked only where it is shown

    def rule_out(self, stage: str, reason: str, excess: float = math.inf) -> None:
        """Say where and why it stops."""
        self.stage, self.reason, self.excess = stage, reason, excess


def screened(spec: Spec, candidate: Candidate) -> Design:
    """A candidate after the closed forms; ``reason`` is empty if it stays."""
    design = Design(candidate)
    for question in (_space, _rule_out_by_fluid, _capability, _pressure, _machine, _critical):
        question(spec, design)
        if design.reason:
            break
    return design


def _space(spec: Spec, design: Design) -> None:
    space, ring, one = spec.space, design.candidate.ring, design.candidate
    width, outer = ring.width * one.races, math.inf if space.outer is None else space.outer
    widest = math.inf if space.width is None else space.width
    if ring.bore < space.bore * (1.0 - ROUNDING):
        design.rule_out(
            "space", f"its bore of {_mm(ring.bore)} is below {_mm(space.bore)}", (space.bore - ring.bore) / space.bore
        )
    elif ring.outer > outer * (1.0 + ROUNDING):
        design.rule_out(
            "space",
            f"its outer diameter of {_mm(ring.outer)} is above {_mm(outer)}",
            ring.outer / outer - 1.0,
        )
    elif width > widest * (1.0 + ROUNDING):
        design.rule_out("space", f"its width of {_mm(width)} is above {_mm(widest)}", width / widest - 1.0)
    elif ring.orbit_radius <= 0.5 * ring.ball_diameter:
        design.rule_out("space", "its balls are larger than its race")
    elif one.count > (room := largest_count(ring.orbit_radius, ring.ball_diameter)):
        design.rule_out("space", f"its race has room for {room} of {one.count} balls", one.count / room - 1.0)


def _rule_out_by_fluid(spec: Spec, design: Design) -> None:
    one = design.candidate
    try:
        dense = max(densities(spec, one.fillings))
        known = [tuple(filling.at(temperature)[1] for temperature in spec.temperature) for filling in one.fillings]
        if known:
            design.viscosity = known[0][0], known[0][1]
    except AutobalancerError as reason:
        design.rule_out("fluid", str(reason))
        return
    if (heavy := density_of_balls(spec)) <= dense:
        design.rule_out("fluid", f"its balls of {heavy:.0f} kg/m³ float in a fluid of {dense:.0f} kg/m³", dense / heavy)


def _capability(spec: Spec, design: Design) -> None:
    one, planes = design.candidate, planes_of(spec, design.candidate.planes)
    design.capability = capability_of_races(spec, one)
    ring = one.ring
    if one.count * one.races == 1:
        design.rule_out("capability", "one ball alone balances an unbalance of exactly its own moment only")
        return
    design.ball_mass = planes * one.races * one.count * ball_mass(ring.ball_diameter, density_of_balls(spec))
    if isinstance(spec.machine.rotor, PlanarRotor):
        _enough(spec, design, planes * design.capability, spec.unbalance[1], "")


def _enough(spec: Spec, design: Design, have: float, need: float, where: str) -> None:
    requested = spec.capability_margin
    design.margin = min(have / need if need > 0.0 else math.inf, design.margin if design.margin > 0.0 else math.inf)
    if have < requested * need * (1.0 - ROUNDING):
        times = f", {have / need:.3g} times as much; needed is {requested:g} times" if requested > 1.0 else ""
        design.rule_out(
            "capability",
            f"its balls{where} can balance {moment_text(have)} of {moment_text(need)}{times}",
            requested * need / max(have, 1e-12) - 1.0,
        )


def _pressure(spec: Spec, design: Design) -> None:
    ring, speed = design.candidate.ring, spec.fastest
    radius = 0.5 * ring.ball_diameter
    heavy = density_of_balls(spec) - min(densities(spec, design.candidate.fillings))  # less the fluid displaced
    force = ball_mass(ring.ball_diameter, heavy) * ring.orbit_radius * speed**2
    design.pressure = greatest_pressure(force, STEEL, radius, ring.orbit_radius + radius)
    allowed = spec.limits.get(PRESSURE, math.inf)
    if design.pressure > allowed:
        design.rule_out(
            "pressure",
            f"a ball presses with {1e-6 * design.pressure:.0f} MPa on its race at {rpm_and_si(speed)}, allowed are "
            f"{1e-6 * allowed:.4g} MPa",
            design.pressure / allowed - 1.0,
        )


def _machine(spec: Spec, design: Design) -> None:
    """Build it, and of a rotor that tilts ask what each plane has to balance."""
    one = design.candidate
    try:
        middle = 0.5 * sum(spec.temperature)
        design.machine = machine_of(spec, one, middle, spec.unbalance[1])
        if not isinstance(spec.machine.rotor, PlanarRotor):
            for plane in frame_of(design.machine, spec.slowest).stations:
                if not design.reason:
                    _enough(spec, design, plane.capability, plane.required, f" at {plane.name!r}")
    except AutobalancerError as reason:
        design.rule_out("fluid" if "fluid" in str(reason) else "space", str(reason))


def _critical(spec: Spec, design: Design) -> None:
    """No border lies below the lowest critical speed: known at once, where borders take a while."""
    from autobalancer.rotordynamics.campbell import critical_speeds

    assert design.machine is not None
    try:
        speeds = critical_speeds(design.machine)["critical_speed"].values
    except AutobalancerError:  # its borders say what they can
        return
    allowed = spec.slowest / (1.0 + spec.limits.get(MARGIN, 0.0))
    if speeds.size and float(speeds[0]) > allowed:
        design.rule_out(
            "border",
            f"balls balance above the critical speed of {rpm_and_si(float(speeds[0]))} only; needed is {rpm_and_si(allowed)} or "
            "less",
            float(speeds[0]) / allowed - 1.0,
        )


def _mm(length: float) -> str:
    return f"{1e3 * length:.4g} mm"


# Designs whose balls stall or do not balance at an operating speed, by the exact borders; and the least oil that
# would do.


RELEASE, EXACT = "release speed", "exact border"
SAYS = {RELEASE: "its balls stall at the critical speed and are released at", EXACT: "balancing is stable from"}


def judge_borders(spec: Spec, design: Design) -> None:
    """Ask both borders at all temperatures and both ends of the unbalance; rule the design out where one is too high.

    The release speed first, which is found much faster; the exact border only of designs that it lets pass.
    """
    allowed = spec.slowest / (1.0 + spec.limits.get(MARGIN, 0.0))
    for name in (RELEASE, EXACT):
        worst, temperature, size = _worst(spec, design, name)
        if name == RELEASE:
            design.release = worst.speed
        else:
            design.border = worst.speed
        if worst.speed > allowed:
            said = f"{SAYS[name]} {rpm_and_si(worst.speed)} only" if math.isfinite(worst.speed) else _never(name)
            if worst.best < worst.speed:
                said += f" at all positions of the balls, from {rpm_and_si(worst.best)} at the best"
            at = f" at {temperature - 273.15:.4g} °C" if spec.temperature[0] != spec.temperature[1] else ""
            at += f" and {moment_text(size)}" if spec.unbalance[0] != spec.unbalance[1] else ""
            reason = f"{said}{at}; needed is {rpm_and_si(allowed)} or less"
            design.rule_out("border", reason, worst.speed / allowed - 1.0)
            design.cure = partial(_least_viscosity_text, spec, design, name, allowed, (temperature, size))
            return


def _worst(spec: Spec, design: Design, name: str) -> tuple[Border, float, float]:
    """The highest border of a name, and the temperature and unbalance of it; nan if there is none."""
    worst = Border(name, math.nan, ""), 0.0, 0.0
    for temperature in spec.temperatures:
        for size in sorted({max(spec.unbalance[0], 0.02 * spec.unbalance[1]), spec.unbalance[1]}):
            try:
                machine = machine_of(spec, design.candidate, temperature, size)
                (border,) = borders(machine, only=(name,))
            except AutobalancerError:
                continue
            if not border.speed <= worst[0].speed and not math.isnan(border.speed):
                worst = border, temperature, size
    return worst


def _never(name: str) -> str:
    return (
        "its balls stall at the critical speed and are never released"
        if name == RELEASE
        else "balancing is never stable"
    )


def _least_viscosity_text(spec: Spec, design: Design, name: str, allowed: float, at: tuple[float, float]) -> str:
    """How thick the oil would have to be at its density, as the end of a reason; empty where it is not known."""
    one, (temperature, size) = design.candidate, at
    if len(set(one.fillings)) != 1:
        return ""
    has = one.fillings[0].at(temperature)[1]
    try:
        machine = machine_of(spec, one, temperature, size)
        least = minimum_viscosity(machine, allowed, name)
    except AutobalancerError:
        return ""
    if not has < least < math.inf:  # thinner oils may do in a window, which is no design
        return ""
    return f"; that takes {1e6 * least:.3g} mm²/s there, this oil has {1e6 * has:.3g}"
