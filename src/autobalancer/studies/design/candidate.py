"""One candidate: races, balls and fluids in numbers; and all candidates of a specification."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any

from autobalancer.assembly.quantities import changed_part, with_quantity
from autobalancer.catalog.bearing_table import bearing
from autobalancer.catalog.fluid_table import fluid
from autobalancer.catalog.resolve import resolve, settled
from autobalancer.catalog.small_tables import material
from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.laws.capabilities import capability, largest_count, needed_count
from autobalancer.machine import Balancer, Balls, Machine, PlanarRotor, PrescribedSpeed, Race, RunPlan, Table
from autobalancer.studies.design.spec import Filling, Spec


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
        found = {"ring": self.ring.label, "count": f"{self.count} ball{'s' * (self.count != 1)}"}
        found |= {"races": f"{self.races} races"} if self.races > 1 else {}
        found |= {"planes": " and ".join(self.planes)} if self.planes else {}
        return found | ({"fluid": self.fluid} if self.fillings else {})

    @property
    def fluid(self) -> str:
        """Its fluids as text."""
        return " / ".join(one.label for one in self.fillings)

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
        return tuple(one.at(spec.temperature[0])[0] for one in fillings)
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
        and any(planes_of(spec, one) > 1 for one in options.planes)
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


def capability_of_races(spec: Spec, one: Candidate) -> float:
    """What the balls of one plane can balance when the fluid is cold, kg m.

    Raises
    ------
    QuestionError
        If the balls float.
    """
    dense = densities(spec, one.fillings)
    each = dense if len(dense) == one.races else dense * one.races
    ring, ball = one.ring, density_of_balls(spec)
    return sum(
        capability(ring.orbit_radius, ring.ball_diameter, ball, one.count, fluid_density=float(found)) for found in each
    )


# The machine of a candidate: the machine of the specification with other balancers, fluids and drive.


CHANGED = ("bearing", "orbit_radius", "race_radius", "balls", "fluid", "drag", "width", "height")


def machine_of(spec: Spec, one: Candidate, temperature: float, unbalance: float | None = None) -> Machine:
    """The machine of a candidate with its fluids at a temperature (K).

    Parameters
    ----------
    spec
        Its machine gives rotor, drive, friction and whatever else a candidate does not change.
    one
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
            spec, one, template, one.fillings[min(number, len(one.fillings) - 1)] if one.fillings else None, temperature
        )
        for number in range(one.races)
    )
    if one.planes:
        balancers = tuple(Balancer(name=name, station=name, races=races) for name in one.planes)
    elif machine.balancers:
        balancers = tuple(
            changed_part(balancer, races=races, **_renamed(balancer.name, template, one))
            for balancer in machine.balancers
        )
    else:
        balancers = (Balancer(races=races),)
    found: Machine = changed_part(machine, balancers=balancers)
    return found if unbalance is None else with_quantity(found, "unbalance", unbalance)


def _renamed(name: str, template: Race | None, one: Candidate) -> dict[str, str]:
    """The name of a balancer with the new bearing, where it has the old one in it."""
    old = template.bearing if template is not None else None
    return {"name": name.replace(old, one.ring.bearing)} if old and one.ring.bearing and old in name else {}


def _race(spec: Spec, one: Candidate, template: Race | None, filling: Any, temperature: float) -> Race:
    ring, options = one.ring, spec.options
    kept = {} if template is None else {k: getattr(template, k) for k in template.model_fields_set if k not in CHANGED}
    if template is not None and template.fluid is not None and template.fluid.lag != "none":
        kept |= {"width": template.width, "height": template.height}
    size = {"bearing": ring.bearing} if ring.bearing else {"orbit_radius": ring.orbit_radius}
    drag: Any = options.drag if options.drag is not None else template.drag if template is not None else None
    return Race(
        **kept, **size, drag=drag, fluid=_fluid(template, filling, temperature), balls=(_balls(spec, one, template),)
    )


def _balls(spec: Spec, one: Candidate, template: Race | None) -> Balls:

    motion = template.balls[0].motion if template is not None else "rolling"
    stuff = dict(spec.options.balls) or {"density": density_of_balls(spec)}
    return Balls(count=one.count, diameter=one.ring.ball_diameter, motion=motion, **stuff)


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
