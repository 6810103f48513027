"""From a machine to the numbers of its equations of motion."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

import numpy as np

from autobalancer.assembly.bearings.hardening import bearings_of, has_hardening
from autobalancer.assembly.contact.meetings import contact_rows, has_rigid_friction, set_contacts
from autobalancer.assembly.contact.rigid import rigid_room
from autobalancer.assembly.drive import drive_of, first_speed
from autobalancer.assembly.fluids import FluidRows, Lags, UniformTable, mode_count, uniform_table
from autobalancer.assembly.forces.rows import force_rows
from autobalancer.assembly.guided import ball_inertia, ball_rows, is_real, moving_rows, put_on_races
from autobalancer.assembly.host import host_of
from autobalancer.assembly.mass_spread import with_mass_spread
from autobalancer.assembly.resolved.balls import free_rows, is_resolved, resolved_scales, resolved_size, start_states
from autobalancer.assembly.rotors import rows_at
from autobalancer.assembly.rotors.hardening import HardPlace
from autobalancer.assembly.rotors.mounts import Mount
from autobalancer.assembly.rotors.reduction import Reduction
from autobalancer.assembly.rubber import element_count, force_scales, has_rubber, pulled_forces, rubber_rows
from autobalancer.assembly.spatial import (
    Parts,
    coordinate_places,
    length_scale,
    pulled,
    spatial_parts,
    spatial_scales,
    struck,
    top_speed,
    turned,
)
from autobalancer.assembly.starts import planar_scales, planar_start, start_angles
from autobalancer.assembly.torsion.links import is_linked, scale_of_links, start_of_links
from autobalancer.catalog.resolve import Ball, resolve
from autobalancer.catalog.resolve_springs import planar_rotor
from autobalancer.kernels.records.drive import RECORDED, SHAKE
from autobalancer.kernels.records.resolved import BALL_STATES
from autobalancer.kernels.system import BALLS, SPEED, THETA, Floats, Matrix, Planar, Rows, System
from autobalancer.machine import BaseMotion, HarmonicForce, Machine, PlanarRotor, RecordedBaseMotion, RecordedForce
from autobalancer.random_numbers import generator


class Model(Enum):
    """The equations of motion of a machine; each is in ``kernels/balls``."""

    PLANAR = "guided balls on smooth circles, planar rotor"
    GUIDED = "guided balls on smooth circles, any rotor"
    TILTING = "guided balls on smooth circles that tilt, any rotor"
    ROUGH = "guided balls on real races, any rotor"
    ROUGH_TILTING = "guided balls on real races that tilt, any rotor"
    RESOLVED = "resolved balls, any rotor"


@dataclass(frozen=True)
class Assembly:
    """A machine ready to integrate: its system, its state at time 0, the size of its motions."""

    system: System
    state: Floats  # (6 + 2 n,) and more on a rotor with more coordinates
    scale: Floats  # as the state: size of each component, for absolute tolerances
    growing: Floats  # as the state: 1 where the tolerance grows with the component, 0 for angles and speeds
    balls: tuple[Ball, ...]
    critical_speeds: tuple[float, ...] = ()  # undamped, with the balls on the rotor, ascending
    model: Model = Model.PLANAR
    reference: str = ""  # the place whose deflection is X, Y
    stations: dict[str, Matrix] = field(default_factory=dict)  # rows (2, R) of the named stations
    reduction: Reduction | None = None
    places: Matrix = field(default_factory=lambda: np.zeros((0, 2, 0)))  # rows (P, 2, R) of the balancers
    mounts: tuple[Mount, ...] = ()  # rubber that softens with the amplitude
    hard: tuple[HardPlace, ...] = ()  # bearings that become stiffer as they deflect

    @property
    def general(self) -> bool:
        """Whether the rotor is one of any number of coordinates."""
        return self.model is not Model.PLANAR

    @property
    def resolved(self) -> bool:
        """Whether balls are resolved in contact."""
        return self.model is Model.RESOLVED

    @property
    def rough(self) -> bool:
        """Whether guided balls run on real races: with friction, waves, drag curves or excitation."""
        return self.model in (Model.ROUGH, Model.ROUGH_TILTING)


def assemble(
    machine: Machine,
    *,
    seed: int = 0,
    rotating: bool | None = None,
    general: bool | None = None,
    contact: bool = True,
    lags: Lags | None = None,
    real: bool = True,
    mass_spread: float = 0.0,
) -> Assembly:
    """Numbers of a machine.

    Parameters
    ----------
    machine
        The machine.
    seed
        For the start positions of balls that have none.
    rotating
        Whether the frame turns with the rotor; by default where the machine is then autonomous: isotropic supports
        and no gravity in the plane.
    general
        Whether to take the equations of the general rotor; by default on all but planar ones with plain races.
    contact
        Whether balls of one race touch, where the machine says so; else they pass through each other.
    lags
        How the fluid of a race, by the numbers of its balancer and race from 0, lags behind the rotor.
    real
        Whether friction, drag curves, waves of the race and excitations of a planar rotor count, else drag is linear.
    mass_spread
        Relative difference of the masses of equal balls that pass through each other.

    Raises
    ------
    MachineError
        If a name is unknown to the catalogs, the balls do not fit, or the rotor is not possible.
    """
    balls = with_mass_spread(machine, resolve(machine), mass_spread, seed)
    beyond = real and (is_resolved(machine) or is_real(machine, balls, lags))
    general = general or is_linked(machine) or has_rubber(machine) or has_hardening(machine)
    general = general or (contact and has_rigid_friction(machine))
    if general or beyond or not isinstance(machine.rotor, PlanarRotor):
        return assemble_general(machine, balls, seed=seed, rotating=rotating, contact=contact, lags=lags or {})
    pull = _pull(machine)
    isotropic = machine.rotor.isotropic
    turns = (isotropic and pull == 0.0) if rotating is None else rotating and isotropic
    (kx, ky), (bx, by) = (rotor := planar_rotor(machine)).stiffness_xy, rotor.damping_xy
    system = System(
        rotating=int(turns),
        gravity_x=0.0,
        gravity_y=-pull,
        polar_inertia=float(machine.rotor.inertia or 0.0) + sum(ball_inertia(ball) for ball in balls),
        ball_count=len(balls),
        drive=drive_of(machine),
        planar=Planar(total_mass(machine, balls), kx, ky, bx, by),
        **_guided(balls),
    )
    critical = tuple(critical_speeds(system.planar))
    angles = np.array(start_angles(balls, generator(seed)), np.float64)
    if contact and balls:
        fastest = max(top_speed(machine) or 0.0, *critical)
        angles, rebounds = set_contacts(machine, balls, angles, system.contacts, fastest)
        room = rigid_room(balls, system.contacts, BALLS + 2 * len(balls), fastest)
        system = system._replace(rebounds=rebounds, **room)
    system = system._replace(**force_rows(machine, balls, angles))
    state = planar_start(machine, balls, system, first_speed(machine, system.drive), angles)
    scale, growing = planar_scales(machine, balls, system)
    return Assembly(system, state, scale, growing, balls, critical)


def _pull(machine: Machine) -> float:
    """Gravity across the axis, m/s^2."""
    return float(machine.gravity) if machine.axis == "horizontal" else 0.0


def _guided(balls: tuple[Ball, ...]) -> dict[str, Any]:
    """The fields of a system that guided balls fill."""
    return {"balls": ball_rows(balls), "contacts": contact_rows(len(balls)), "guided": moving_rows(balls)}


def assemble_general(
    machine: Machine,
    balls: tuple[Ball, ...],
    *,
    seed: int,
    rotating: bool | None,
    contact: bool,
    lags: Lags,
    parts: Parts | None = None,
) -> Assembly:
    """Numbers of a machine for the equations of any linear rotor."""
    parts = spatial_parts(machine, balls) if parts is None else parts
    model = _model(machine, balls, lags)
    calm = _pull(machine) == 0.0 and not machine.excitations
    turns = (parts.isotropic and calm) if rotating is None else rotating and parts.isotropic
    n, size = len(balls), parts.size
    rest, own = BALLS + 2 * n, 2 + 2 * size + 2 * n  # where coordinates and where states of balls begin
    further = resolved_size(balls, lags) if model is Model.RESOLVED else mode_count(lags)
    elastic = own + further  # where states of rubber begin, and where they end
    end = elastic + 2 * element_count(parts)
    drive = drive_of(machine, end)
    angles = np.array(start_angles(balls, generator(seed)), np.float64)
    fluids = FluidRows(balls, lags, own + further - mode_count(lags))
    if model is Model.RESOLVED:
        rows = free_rows(machine, balls, angles, fluids)
    else:
        rows = _guided(balls)
        if model in (Model.ROUGH, Model.ROUGH_TILTING):
            rows["waves"] = put_on_races(machine, balls, rows["balls"], rows["guided"], fluids).rows
    host, work = host_of(machine, parts, drive.segments.start)
    shakes, vectors = excitations(machine, parts, host.width, fluids)
    system = System(
        rotating=int(turns and not machine.excitations),
        gravity_x=0.0,
        gravity_y=-_pull(machine),
        polar_inertia=float(machine.rotor.inertia or 0.0),
        ball_count=n,
        drive=drive,
        host=host,
        work=work,
        fluid=fluids.fluid,
        rubber=rubber_rows(parts, elastic),
        bearings=bearings_of(parts),
        shakes=shakes,
        shake_vectors=vectors,
        **rows,
    )
    fastest = max([top_speed(machine) or 0.0, *parts.critical_speeds])
    if contact and balls and model is not Model.RESOLVED:
        angles, rebounds = set_contacts(machine, balls, angles, system.contacts, fastest)
        system = system._replace(rebounds=rebounds)
    system = system._replace(**force_rows(machine, balls, angles))
    state, (where, fast) = np.zeros(end), coordinate_places(size, n)
    angle = float(machine.start.rotor_angle)
    place, velocity = pulled(parts, *machine.start.deflection), struck(parts, *machine.start.velocity)
    state[[THETA, SPEED]] = angle, first_speed(machine, drive)
    state[where] = turned(place, -angle) if system.rotating else place
    state[fast] = turned(velocity, -angle) if system.rotating else velocity
    state[BALLS : BALLS + n], state[BALLS + n : rest] = angles, [ball.start_speed for ball in balls]
    length = length_scale(machine, parts, balls)
    scale, growing = spatial_scales(parts, length, n, end)
    forces = pulled_forces(parts, place)
    state[elastic:] = turned(forces, -angle) if system.rotating else forces
    scale[elastic:], growing[elastic:] = force_scales(parts, length), 1.0
    if model is Model.RESOLVED:
        free = slice(own, own + BALL_STATES * n)
        state[free] = start_states(machine, balls, angles, system.free_balls, state[SPEED]).ravel()
        # not the critical speeds of stiff bearings, which no ball goes round at
        usual = top_speed(machine) or min(parts.critical_speeds, default=0.0)
        scale[free] = resolved_scales(balls, system.free_balls, usual).ravel()
    state = np.append(state, start_of_links(machine, state[SPEED]))
    scale = np.append(scale, scale_of_links(machine, parts.frequency))
    growing = np.append(growing, np.zeros(state.size - growing.size))
    usual = max(
        top_speed(machine) or 0.0, min(parts.critical_speeds, default=0.0)
    )  # a shaft's highest mode is far above
    system = system._replace(**rigid_room(balls, system.contacts, state.size, usual))
    return Assembly(
        system, state, scale, growing, balls, parts.critical_speeds, model, parts.reference, parts.stations,
        parts.reduction, parts.places, parts.mounts, parts.hard,
    )  # fmt: skip


def _model(machine: Machine, balls: tuple[Ball, ...], lags: Lags) -> Model:
    """The simplest equations that contain everything a machine needs."""
    if is_resolved(machine):
        return Model.RESOLVED
    rough, tilting = is_real(machine, balls, lags), machine.tilting_races == "full"
    if rough:
        return Model.ROUGH_TILTING if tilting else Model.ROUGH
    return Model.TILTING if tilting else Model.GUIDED


def total_mass(machine: Machine, balls: tuple[Ball, ...]) -> float:
    """Mass of a planar rotor and its balls (effective), kg."""
    assert isinstance(machine.rotor, PlanarRotor)
    return float(machine.rotor.mass) + sum(ball.effective_mass for ball in balls)


def critical_speeds(rotor: Planar) -> list[float]:
    """Undamped critical speeds with the balls on the rotor, rad/s, ascending; one if the supports are isotropic."""
    return sorted({math.sqrt(k / rotor.mass) for k in (rotor.stiffness_x, rotor.stiffness_y)})


# What shakes the machine, as rows of kernels/records/drive.py.


def excitations(machine: Machine, parts: Parts, width: int, tables: FluidRows) -> tuple[Rows, Matrix]:
    """The rows of a machine's excitations, and accelerations of its coordinates per unit of each, along x and y."""
    rows, vectors = SHAKE.rows(len(machine.excitations)), np.zeros((2 * len(machine.excitations), width))
    inverse = np.linalg.inv(parts.mass)
    for number, (row, shake) in enumerate(zip(rows, machine.excitations, strict=True)):
        direction = np.array([math.cos(float(shake.direction)), math.sin(float(shake.direction))])
        if isinstance(shake, (BaseMotion, RecordedBaseMotion)):
            row.felt, moved = 1, _base(parts)
        else:
            place = rows_at(machine, parts.model, shake.station, "excitations", number, "station")
            moved = (parts.model.both(place.deflection[None]) @ parts.reduction.basis).T
        vectors[2 * number : 2 * number + 2, : parts.size] = (inverse @ moved).T
        if isinstance(shake, (BaseMotion, HarmonicForce)):
            vector = _size(shake) * np.exp(1j * float(shake.phase)) * direction
            row.x_real, row.x_imaginary, row.y_real, row.y_imaginary = vector.view(np.float64)
            row.frequency = float(shake.frequency if shake.frequency is not None else shake.order or 0.0)
            row.by_angle = int(shake.frequency is None)
            continue
        assert isinstance(shake, (RecordedBaseMotion, RecordedForce))
        row.kind = RECORDED
        values = shake.acceleration if isinstance(shake, RecordedBaseMotion) else shake.force
        table = uniform_table(*_with_silence(np.array(shake.time, np.float64), np.array(values, np.float64)))
        row.table_x, row.table_y = (tables.add_table(_times(table, float(share))) for share in direction)
    return rows, vectors


def _base(parts: Parts) -> Matrix:
    """Forces on the coordinates per acceleration of the base along x and y, seen from there."""
    n = parts.model.pairs
    moved = np.zeros((parts.model.size, 2))
    moved[:n, 0] = moved[n:, 1] = parts.model.translation
    return np.asarray(-parts.reduction.basis.T @ parts.model.mass @ moved)


def _size(shake: BaseMotion | HarmonicForce) -> float:
    """Amplitude of force or acceleration."""
    if isinstance(shake, HarmonicForce):
        return float(shake.force)
    if shake.acceleration is not None:
        return float(shake.acceleration)
    return -float(shake.displacement or 0.0) * float(shake.frequency or 0.0) ** 2


def _times(table: UniformTable, share: float) -> UniformTable:
    return UniformTable(table.start, table.step, share * table.values, share * table.slopes)


def _with_silence(times: Floats, values: Floats) -> tuple[Floats, Floats]:
    """The record with zeros one step before and after it, since a table keeps its last value."""
    step = float(np.diff(times).min())
    if values[-1] != 0.0:
        times, values = np.append(times, times[-1] + step), np.append(values, 0.0)
    if values[0] != 0.0 and times[0] > step:
        times, values = np.insert(times, 0, times[0] - step), np.insert(values, 0, 0.0)
    return times, values
