"""Members on a planar rotor whose rotor or balls have other numbers: masses, springs, dampers, places of the race.

All that an assembly makes of these numbers is made anew by the functions that make it there; drive, record and the order of all
numbers stay those of the assembled member, and so do the contacts: balls keep their sizes.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

from autobalancer.assembly.contact.rigid import pull_of
from autobalancer.assembly.contact.touches import Touch, touches_of
from autobalancer.assembly.guided import ball_inertia, ball_rows
from autobalancer.assembly.places import places_of
from autobalancer.assembly.spatial import top_speed
from autobalancer.assembly.starts import planar_scales
from autobalancer.assembly.system import Assembly, critical_speeds, total_mass
from autobalancer.catalog.resolve import Ball
from autobalancer.catalog.resolve_springs import planar_rotor
from autobalancer.kernels.system import Planar
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.simulation.long_steps import planar_amplitudes, why_no_long_steps
from autobalancer.studies.ensemble.layout import Layout, bits
from autobalancer.studies.sweep_row import gauges_for

OF_ROTOR = {"mass", "stiffness", "critical_speed", "damping", "damping_ratio", "half_power_bandwidth", "inertia"}
OF_BALL = ("mass", "volume", "displaced", "spin_ratio", "virtual_mass", "eccentricity", "fluid_density")
OF_MODES = ("exponents", "shapes", "inverse", "numbers")


class Before(NamedTuple):
    """The assembled member."""

    assembly: Assembly
    touches: tuple[Touch, ...]


def keeps_its_form(rotor: Any, before: Any, changed: set[str]) -> bool:
    """Whether a planar rotor differs in numbers only."""
    if not (isinstance(rotor, PlanarRotor) and isinstance(before, PlanarRotor) and changed <= OF_ROTOR):
        return False
    return rotor.isotropic == before.isotropic


def planar_words(
    machine: Machine, balls: tuple[Ball, ...], before: Before, end: float, tolerance: float, layout: Layout
) -> dict[int, int] | None:
    """The words of a machine and its balls; None if it is integrated in another way than the assembled one."""
    assembly = before.assembly
    (kx, ky), (bx, by) = (rotor := planar_rotor(machine)).stiffness_xy, rotor.damping_xy
    parts: dict[str, Any] = {}
    system = assembly.system._replace(
        planar=Planar(total_mass(machine, balls), kx, ky, bx, by),
        polar_inertia=float(machine.rotor.inertia or 0.0) + sum(ball_inertia(ball) for ball in balls),
    )
    if balls is not assembly.balls:
        parts["system.balls"] = rows = ball_rows(balls)
        system = system._replace(balls=rows)
    speeds = tuple(critical_speeds(system.planar))
    fastest = max(top_speed(machine) or 0.0, *speeds)
    own = replace(assembly, system=system, balls=balls, critical_speeds=speeds)
    if bool(why_no_long_steps(own)) != bool(why_no_long_steps(assembly)):
        return None
    touches = before.touches if balls is assembly.balls else touches_of(machine, own)
    parts |= {
        "system.planar": system.planar,
        "system.polar_inertia": system.polar_inertia,
        "gauges": gauges_for(own, places_of(machine, own), end, touches),
    }
    if layout.has("long.1.exponents"):
        modes = planar_amplitudes(own)
        parts |= {f"long.1.{name}": getattr(modes, name) for name in OF_MODES}
    found: dict[int, int] = {}
    for path, value in parts.items():
        words = layout.words(path, value)
        if words is None:
            return None
        found |= words
    if system.ties.size:
        pull = bits(pull_of(balls, fastest))
        found |= {layout.place("system.rigid.margin", i): pull for i in (2, 3)}
    absolute = layout.place("memory.absolute", 0)
    return found | {
        absolute + i: bits(tolerance * size) for i, size in enumerate(planar_scales(machine, balls, system)[0])
    }
