"""Members whose rotor or balls have other numbers: masses, sizes, springs, dampers, places of the race.

All that an assembly makes of these numbers is made anew by the functions that make it there; drive, record and the order of all
numbers stay those of the assembled member. What is known of a rotor is taken from memory, see autobalancer/remembered.py.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import Any, NamedTuple

from autobalancer.assembly.contact.rigid import pull_of
from autobalancer.assembly.contact.touches import Touch, touches_of
from autobalancer.assembly.drive import first_speed
from autobalancer.assembly.fluids import FluidRows
from autobalancer.assembly.guided import ball_inertia, ball_rows, moving_rows, put_on_races
from autobalancer.assembly.host import host_of
from autobalancer.assembly.places import places_of
from autobalancer.assembly.spatial import Parts, length_scale, spatial_parts, spatial_scales, top_speed
from autobalancer.assembly.starts import planar_scales
from autobalancer.assembly.system import Assembly, Model, critical_speeds, total_mass
from autobalancer.catalog.resolve import Ball
from autobalancer.catalog.resolve_springs import planar_rotor
from autobalancer.kernels.records.drive import PRESCRIBED
from autobalancer.kernels.records.fluid import NONE
from autobalancer.kernels.system import SPEED, Drive, Floats, Integers, Planar
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.simulation.long_steps import planar_amplitudes, why_no_long_steps
from autobalancer.simulation.modes import rotor_modes
from autobalancer.studies.ensemble.layout import Layout, bits
from autobalancer.studies.sweep_row import gauges_for

OF_PLANAR_ROTOR = {
    "mass", "stiffness", "critical_speed", "damping", "damping_ratio", "half_power_bandwidth", "inertia",
}  # fmt: skip
MODAL = ("stiffness", "damping", "gyroscopic")  # matrices on which modes depend
LONG = "long.1.exponents"
OF_MODES = ("exponents", "shapes", "inverse", "numbers", "bases")


class Before:
    """The assembled member, and what the numbers of others are compared with."""

    def __init__(self, machine: Machine, assembly: Assembly) -> None:
        self.machine, self.assembly = machine, assembly

    @cached_property
    def touches(self) -> tuple[Touch, ...]:
        """Its contacts."""
        return touches_of(self.machine, self.assembly)

    @cached_property
    def parts(self) -> Parts:
        """Its rotor, which is not planar."""
        return spatial_parts(self.machine, self.assembly.balls)


class Own(NamedTuple):
    """A member as far as it was made anew."""

    assembly: Assembly
    modes: Any  # amplitudes of long steps; None where they are those of the assembled one


def keeps_its_form(rotor: Any, before: Any, changed: set[str]) -> bool:
    """Whether a rotor differs from another of its kind in numbers only, as far as its description says."""
    return not isinstance(rotor, PlanarRotor) or (changed <= OF_PLANAR_ROTOR and rotor.isotropic == before.isotropic)


def numbers_of(machine: Machine, balls: tuple[Ball, ...], before: Before, drive: Drive, *, long: bool) -> Own | None:
    """A machine and its balls, made anew as far as it has to be; None if it is integrated in another way.

    ``long`` says whether the assembled one takes long steps.
    """
    made = _planar if before.assembly.model is Model.PLANAR else _general
    found = made(machine, balls, before, drive, long=long)
    if found is None or bool(why_no_long_steps(found.assembly)) != bool(why_no_long_steps(before.assembly)):
        return None
    return found


def number_words(
    machine: Machine, own: Own, before: Before, end: float, tolerance: float, layout: Layout, block: Integers
) -> dict[int, int] | None:
    """The words of such a machine where they differ from the ``block`` of the assembled one; None for another layout."""
    first, made = before.assembly, own.assembly
    touches = before.touches if made.balls is first.balls else touches_of(machine, made)
    values: dict[str, Any] = {"gauges": gauges_for(made, places_of(machine, made), end, touches)}
    for name, value in made.system._asdict().items():
        if value is not getattr(first.system, name):
            values[f"system.{name}"] = value
    if own.modes is not None:
        values |= {f"long.1.{name}": getattr(own.modes, name) for name in OF_MODES}
    words = scale_words(tolerance * made.scale, layout)
    for path, value in values.items():
        its = layout.words(path, value, block)
        if its is None:
            return None
        words |= its
    if made.system.ties.size:
        critical = made.critical_speeds
        usual = max(critical) if first.model is Model.PLANAR else min(critical, default=0.0)
        pull = bits(pull_of(made.balls, max(top_speed(machine) or 0.0, usual)))
        words |= {layout.place("system.rigid.margin", i): pull for i in (2, 3)}
    return words


def scale_words(sizes: Floats, layout: Layout) -> dict[int, int]:
    """The words of absolute tolerances."""
    return dict(enumerate(map(bits, sizes), layout.place("memory.absolute", 0)))


def _planar(machine: Machine, balls: tuple[Ball, ...], before: Before, drive: Drive, *, long: bool) -> Own | None:
    first = before.assembly
    (kx, ky), (bx, by) = (rotor := planar_rotor(machine)).stiffness_xy, rotor.damping_xy
    system = first.system._replace(
        planar=Planar(total_mass(machine, balls), kx, ky, bx, by),
        polar_inertia=float(machine.rotor.inertia or 0.0) + sum(ball_inertia(ball) for ball in balls),
    )
    if balls is not first.balls:
        system = system._replace(balls=ball_rows(balls))
    scale = planar_scales(machine, balls, system)[0]
    critical = tuple(critical_speeds(system.planar))
    own = replace(first, system=system, balls=balls, critical_speeds=critical, scale=scale)
    return Own(own, planar_amplitudes(own) if long and not why_no_long_steps(own) else None)


def _general(machine: Machine, balls: tuple[Ball, ...], before: Before, drive: Drive, *, long: bool) -> Own | None:
    """On any other rotor; None if it has another number of modes, or parts whose numbers are not known here."""
    first, parts = before.assembly, spatial_parts(machine, balls)
    if parts.mounts or parts.hard or first.mounts or first.hard or machine.excitations or drive.linked:
        return None
    kept = parts.reduction.basis is before.parts.reduction.basis
    moved = any(machine.start.deflection) or any(machine.start.velocity)
    if parts.size != before.parts.size or parts.isotropic != before.parts.isotropic or (moved and not kept):
        return None
    host = host_of(machine, parts, drive.segments.start)[0]
    system = first.system._replace(
        host=_kept(host, first.system.host), drive=drive, polar_inertia=float(machine.rotor.inertia or 0.0)
    )
    if balls is not first.balls:
        rows, fluids = ball_rows(balls), FluidRows(balls, {}, 0)
        if first.system.fluid.modes.size or (first.system.balls.lag_table != NONE).any():
            return None
        if first.rough:
            put_on_races(machine, balls, rows, moving_rows(balls), fluids)
            system = system._replace(fluid=fluids.fluid)
        system = system._replace(balls=rows)
    scale = spatial_scales(parts, length_scale(machine, parts, balls), len(balls), first.state.size)[0]
    own = replace(
        first, system=system, balls=balls, critical_speeds=parts.critical_speeds, scale=scale, reduction=parts.reduction,
        places=parts.places, stations=parts.stations,
    )  # fmt: skip
    reach = drive is first.system.drive and (drive.kind == PRESCRIBED or own.critical_speeds == first.critical_speeds)
    if not long or (reach and all(getattr(host, name) is getattr(first.system.host, name) for name in MODAL)):
        return Own(own, None)
    state = own.state.copy()
    state[SPEED] = first_speed(machine, drive)
    modes = rotor_modes(system, state, parts.critical_speeds)
    return None if modes is None else Own(own, modes)


def _kept(now: Any, before: Any) -> Any:
    """The one before if nothing in it was made anew."""
    return before if all(one is other for one, other in zip(now, before, strict=True)) else now
