"""The same machine without balancing: its balls are spread evenly over their races and held.

Their mass stays on the rotor, so that critical speeds are those of the machine with balls. Their forces cancel but for
those of races that are not centered.
"""

from __future__ import annotations

import cmath

from autobalancer.assembly.guided import ball_inertia
from autobalancer.assembly.spatial import spatial_parts
from autobalancer.assembly.system import Assembly, assemble, assemble_general, total_mass
from autobalancer.catalog.resolve import Ball, resolve
from autobalancer.catalog.resolve_springs import settled
from autobalancer.machine import Machine, PlanarRotor, Unbalance


def assemble_held(machine: Machine, rotating: bool | None = None) -> Assembly:
    """A machine with its balls held, ready to integrate.

    Raises
    ------
    MachineError
        As :func:`autobalancer.assembly.system.assemble`.
    """
    balls = resolve(machine)
    centers = tuple(
        Unbalance(moment=abs(moment), angle=cmath.phase(moment), station=machine.balancers[number].station)
        for number, moment in center_moments(machine, balls).items()
    )
    unbalances = (*machine.unbalances, *centers)
    machine = settled(machine)
    bare = machine.model_copy(update={"balancers": (), "unbalances": unbalances, "tilting_races": "deflection"})
    if isinstance(machine.rotor, PlanarRotor) and not machine.excitations:
        loaded = machine.rotor.model_copy(update={"mass": total_mass(machine, balls)})
        held = assemble(bare.model_copy(update={"rotor": loaded}), rotating=rotating)
    else:
        parts = spatial_parts(machine.model_copy(update={"unbalances": unbalances}), balls, held=True)
        held = assemble_general(bare, (), seed=0, rotating=rotating, contact=False, lags={}, parts=parts)
    inertia = held.system.polar_inertia + sum(ball_inertia(ball) for ball in balls)
    return Assembly(**{**vars(held), "system": held.system._replace(polar_inertia=inertia)})


def center_moments(machine: Machine, balls: tuple[Ball, ...]) -> dict[int, complex]:
    """Unbalance of the balls of each balancer (by its number from 0) when they are spread evenly, kg m, if there is one."""
    found = dict.fromkeys(range(len(machine.balancers)), 0j)
    for ball in balls:
        found[ball.balancer] += ball.effective_mass * ball.eccentricity
    return {number: moment for number, moment in found.items() if moment != 0.0}
