"""The machine of a candidate: the machine of the specification with other balancers, fluids and drive."""

from __future__ import annotations

from typing import Any

from autobalancer.assembly.changed_parts import changed_part
from autobalancer.assembly.quantities import with_quantity
from autobalancer.catalog.resolve_springs import settled
from autobalancer.machine import Balancer, Balls, Machine, PrescribedSpeed, Race, RunPlan, Table
from autobalancer.studies.design.candidate import Candidate
from autobalancer.studies.design.spec import Spec

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
            changed_part(balancer, races=races, name=_renamed(balancer.name, template, one))
            for balancer in machine.balancers
        )
    else:
        balancers = (Balancer(races=races),)
    found: Machine = changed_part(machine, balancers=balancers)
    return found if unbalance is None else with_quantity(found, "unbalance", unbalance)


def _renamed(name: str, template: Race | None, one: Candidate) -> str:
    """The name of a balancer, with the new bearing where it has the old one in it."""
    old = template.bearing if template is not None else None
    return name.replace(old, one.ring.bearing) if old and one.ring.bearing else name


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
    from autobalancer.studies.design.candidate import density_of_balls

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
    corners = [(0.0, 0.0), (way.run_up, speed), (way.run_up + way.hold, speed)]
    corners += [(way.run_up + way.hold + way.coast_down, 0.0)] if coasting else []
    time, speeds = zip(*corners, strict=True)
    drive = PrescribedSpeed(profile=Table(time=time, speed=speeds))
    changed: Machine = changed_part(machine, drive=drive, run=RunPlan(duration=time[-1]))
    return changed
