"""From a machine to the numbers of its equations of motion."""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from itertools import zip_longest
from typing import Any, NamedTuple

import numpy as np

from autobalancer.assembly.contact import contact_rows, is_rigid, rigid_room, set_contacts
from autobalancer.assembly.drive_train import (
    Piece,
    is_linked,
    links_of,
    profile_pieces,
    schedule_times,
    unbalance_factor,
)
from autobalancer.assembly.guided_balls import (
    FluidRows,
    Lags,
    UniformTable,
    ball_inertia,
    ball_rows,
    force_rows,
    is_real,
    moving_rows,
    put_on_races,
    uniform_table,
)
from autobalancer.assembly.reduced_rotor import (
    Parts,
    bearings_of,
    coordinate_places,
    element_count,
    force_scales,
    has_hardening,
    has_rubber,
    host_of,
    length_scale,
    pulled_forces,
    rubber_rows,
    spatial_parts,
    spatial_scales,
    top_speed,
    turned,
)
from autobalancer.assembly.resolved import free_rows, friction_rows, is_resolved, resolved_scales, start_states
from autobalancer.assembly.rotors import rows_at
from autobalancer.assembly.rotors.equivalent_stiffness import HardPlace, Mount
from autobalancer.assembly.rotors.reduction import Reduction
from autobalancer.catalog.resolve import Ball, occupied_angle, planar_rotor, resolve
from autobalancer.errors import MachineError, QuestionError
from autobalancer.kernels.records import (
    BALL_STATES,
    COUPLING,
    HILL,
    LINEAR,
    LINK,
    MOUNT,
    PRESCRIBED,
    RECORDED,
    RIPPLE,
    SEGMENT,
    SHAKE,
    TORQUE,
)
from autobalancer.kernels.system import BALLS, SPEED, THETA, VX, VY, Drive, Floats, Matrix, Planar, Rows, System, X, Y
from autobalancer.machine import (
    AsynchronousDrive,
    BaseMotion,
    ConstantTorque,
    HarmonicForce,
    Machine,
    PlanarRotor,
    PrescribedSpeed,
    RecordedBaseMotion,
    RecordedForce,
    TargetTorque,
    TorqueTable,
)
from autobalancer.machine.drive import Coupling
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
    gyroscopic_shares: tuple[float, ...] = ()  # of each critical speed; none of a rotor that does not tilt

    @property
    def whirls(self) -> Matrix:
        """Critical speeds (rad/s) and gyroscopic shares, (K, 2), for kernels/measures/record_series.py."""
        shares = self.gyroscopic_shares or (0.0,) * len(self.critical_speeds)
        return np.array([self.critical_speeds, shares], np.float64).T.copy()

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
    # what the short equations of one plane cannot say goes to the general ones, with the same layout of states
    general = general or is_linked(machine) or has_rubber(machine) or has_hardening(machine)
    general = general or (contact and _has_rigid_friction(machine))
    if general or beyond or not isinstance(machine.rotor, PlanarRotor):
        return assemble_general(machine, balls, seed=seed, rotating=rotating, contact=contact, lags=lags or {})
    # in the turning frame an isotropic machine without gravity is nearly at rest, and steps become long
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
    # contacts are set at the start; their stiffness depends on the fastest that a ball can come
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


def _has_rigid_friction(machine: Machine) -> bool:
    """Whether balls rub on each other in rigid contacts."""
    races = [race for balancer in machine.balancers for race in balancer.races]
    return any(race.contact is not None and race.contact.friction > 0.0 and is_rigid(race) for race in races)


def _pull(machine: Machine) -> float:
    """Gravity across the axis, m/s^2."""
    return float(machine.gravity) if machine.axis == "horizontal" else 0.0


def _guided(balls: tuple[Ball, ...]) -> dict[str, Any]:
    """The fields of a system that guided balls fill."""
    return {"balls": ball_rows(balls), "contacts": contact_rows(len(balls)), "guided": moving_rows(balls)}


def reference_station(machine: Machine) -> str:
    """The name of the place whose deflection is that of the machine; empty of a machine that is not possible."""
    try:
        return assemble(machine).reference or "rotor"
    except MachineError:
        return ""


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
    free = BALL_STATES * n if model is Model.RESOLVED else 0
    relaxing = sum(int(lag.rates.size) for lag in lags.values())  # modes of fluids
    elastic = own + free + relaxing  # where states of rubber begin, and where they end
    end = elastic + 2 * element_count(parts)
    drive = drive_of(machine, end)
    angles = np.array(start_angles(balls, generator(seed)), np.float64)
    fluids = FluidRows(balls, lags, own + free)
    if model is Model.RESOLVED:
        rows = free_rows(machine, balls, angles, fluids)
    else:
        rows = _guided(balls)
        if model in (Model.ROUGH, Model.ROUGH_TILTING):
            rows["waves"] = put_on_races(machine, balls, rows["balls"], rows["guided"], fluids).rows
            rows |= friction_rows(machine, balls, rows["balls"])
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
    place, velocity = _pulled(parts, *machine.start.deflection), _struck(parts, *machine.start.velocity)
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
        state[own : own + free] = start_states(machine, balls, angles, system.free_balls, state[SPEED]).ravel()
        # not the critical speeds of stiff bearings, which no ball goes round at
        usual = top_speed(machine) or min(parts.critical_speeds, default=0.0)
        scale[own : own + free] = resolved_scales(balls, system.free_balls, usual).ravel()
    state = np.append(state, _start_of_links(machine, state[SPEED]))
    scale = np.append(scale, _scale_of_links(machine, parts.frequency))
    growing = np.append(growing, np.zeros(state.size - growing.size))
    usual = max(
        top_speed(machine) or 0.0, min(parts.critical_speeds, default=0.0)
    )  # a shaft's highest mode is far above
    system = system._replace(**rigid_room(balls, system.contacts, state.size, usual))
    return Assembly(
        system, state, scale, growing, balls, parts.critical_speeds, model, parts.reference, parts.stations,
        parts.reduction, parts.places, parts.mounts, parts.hard, parts.gyroscopic_shares,
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


# What shakes the machine, as rows of kernels/records.py.


def excitations(machine: Machine, parts: Parts, width: int, tables: FluidRows) -> tuple[Rows, Matrix]:
    """The rows of a machine's excitations, and accelerations of its coordinates per unit of each, along x and y."""
    rows, vectors = SHAKE.rows(len(machine.excitations)), np.zeros((2 * len(machine.excitations), width))
    inverse = np.linalg.inv(parts.mass)
    for number, (row, shake) in enumerate(zip(rows, machine.excitations, strict=True)):
        direction = np.array([math.cos(float(shake.direction)), math.sin(float(shake.direction))])
        if isinstance(shake, (BaseMotion, RecordedBaseMotion)):
            row.felt, moved = 1, -parts.reduction.basis.T @ parts.model.mass @ parts.model.translation
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


# Drive and unbalance of a machine over time, as the segments of kernels/records.py.


def drive_of(machine: Machine, first_state: int = 0) -> Drive:
    """What turns the rotor of a machine; the states of its links begin at ``first_state``."""
    drive = machine.drive
    prescribed = isinstance(drive, PrescribedSpeed)
    links, ripples = _link_rows(drive, first_state), _ripple_rows(drive)
    breakdown, synchronous, slip = 0.0, 0.0, 0.0
    if isinstance(drive, AsynchronousDrive):
        synchronous = float(drive.synchronous_speed)
        breakdown, slip = float(drive.rated_torque * drive.overload), float(drive.breakdown_slip) * synchronous
    table = np.zeros((0, 2))
    if isinstance(drive, TorqueTable):
        table = np.column_stack([[float(w) for w in drive.speed], [float(q) for q in drive.torque]])
    return Drive(
        kind=PRESCRIBED if prescribed and not len(links) else TORQUE,
        damping=0.0 if isinstance(drive, PrescribedSpeed) else float(drive.damping),
        table=np.ascontiguousarray(table, np.float64),
        segments=_segments(machine),
        now=np.zeros(1, np.int64),
        breakdown_torque=breakdown,
        synchronous_speed=synchronous,
        breakdown_slip=slip,
        motor=PRESCRIBED if prescribed else TORQUE,
        linked=int(len(links) + len(ripples) > 0),
        links=links,
        ripples=ripples,
    )


def _ripple_rows(drive: Any) -> Rows:
    """Records of all ripples of the torque."""
    result = getattr(drive, "ripples", ())
    rows = RIPPLE.rows(len(result))
    for row, part in zip(rows, result, strict=True):
        row.torque, row.order, row.phase = part.torque, part.order, part.phase
    return rows


LINK_STATES = 2  # twist and speed


def _link_rows(drive: Any, first_state: int) -> Rows:
    """Records of all links, their states from ``first_state`` on."""
    links = links_of(drive)
    rows = LINK.rows(len(links))
    for number, (row, part) in enumerate(zip(rows, links, strict=True)):
        row.kind = COUPLING if isinstance(part, Coupling) else MOUNT
        row.state = first_state + LINK_STATES * number
        row.inertia, row.stiffness, row.damping = float(part.inertia or 0.0), part.stiffness, part.damping
        if isinstance(part, Coupling):
            row.error, row.order, row.phase = part.error, part.order, part.phase
    if drive.kind == "speed" and len(rows):
        rows[-1].inertia = 0.0  # nothing asks for it
    return rows


def steady(speed: float, unbalance: complex) -> Drive:
    """A constant prescribed speed, rad/s, and an unbalance in the rotor, kg m."""
    segments = SEGMENT.rows(1)
    segments.value, segments.unbalance_x, segments.unbalance_y = speed, unbalance.real, unbalance.imag
    return Drive(PRESCRIBED, 0.0, np.zeros((0, 2)), segments, np.zeros(1, np.int64), motor=PRESCRIBED)


def first_speed(machine: Machine, drive: Drive) -> float:
    """Speed of the rotor at the start, rad/s."""
    first = drive.segments[0]
    if drive.motor == PRESCRIBED:
        return float(first.value if first.kind == LINEAR else first.begin)
    return float(machine.start.speed)


def _pieces(machine: Machine) -> list[Piece]:
    drive = machine.drive
    if isinstance(drive, PrescribedSpeed):
        return profile_pieces(drive.profile)
    if isinstance(drive, ConstantTorque):
        return [Piece(0.0, LINEAR, (float(drive.torque), 0.0, 0.0, 0.0))]
    if isinstance(drive, TargetTorque):
        gain = float(drive.gain)
        scaled = []
        for piece in profile_pieces(drive.profile):
            a, b, c, d = piece.numbers
            linear = piece.kind == LINEAR
            numbers = gain * a, gain * b if linear else b, c, d if linear else gain * d
            scaled.append(Piece(piece.start, piece.kind, numbers))
        return scaled
    return [Piece(0.0, LINEAR, (0.0, 0.0, 0.0, 0.0))]


def _segments(machine: Machine) -> Rows:
    """The common grid of all times at which drive or unbalance take another course."""
    pieces = _pieces(machine)
    grid = sorted({*(piece.start for piece in pieces), *schedule_times(machine)})
    rows = SEGMENT.rows(len(grid))
    for row, time in zip(rows, grid, strict=True):
        piece = [p for p in pieces if p.start <= time][-1]
        row.start, row.kind = time, piece.kind
        numbers = piece.at(time)
        if piece.kind == HILL:
            row.end, row.half_time, row.exponent, row.begin = numbers
        else:
            row.value, row.rate = numbers[:2]
    courses = unbalance_courses(machine, grid)
    vectors = [unbalance.vector for unbalance in machine.unbalances]
    resultant = unbalances_over(courses, [vector.real for vector in vectors], [vector.imag for vector in vectors])
    for row, course, values in zip(rows, courses, resultant, strict=True):
        row.changing = int(any(late != factor for factor, late in course.factors))
        row.unbalance_x, row.unbalance_y, row.unbalance_rate_x, row.unbalance_rate_y = values
    return rows


class Course(NamedTuple):
    """How the point unbalances change from one time of a grid to the next."""

    factors: list[tuple[float, float]]  # of each unbalance, just after the one time and just before the next
    time: float  # between them, s; 1 after the last, where nothing changes


def unbalance_courses(machine: Machine, grid: Sequence[float]) -> list[Course]:
    """The courses of the unbalances of a machine over a grid of times, s."""
    unbalance_courses = []
    for time, late in zip_longest(grid, grid[1:]):
        factors = [unbalance_factor(unbalance, time) for unbalance in machine.unbalances]
        ends = (
            factors
            if late is None
            else [unbalance_factor(unbalance, late, before=True) for unbalance in machine.unbalances]
        )
        unbalance_courses.append(Course(list(zip(factors, ends, strict=True)), 1.0 if late is None else late - time))
    return unbalance_courses


def unbalances_over(courses: Sequence[Course], x: Sequence[Any], y: Sequence[Any]) -> list[list[Any]]:
    """The resultant of unbalances at the begin of each course, and its rate.

    Parameters
    ----------
    courses
        From :func:`unbalance_courses`.
    x, y
        Of each unbalance at factor one, kg m: a number, or an array over many machines that differ in it.

    Returns
    -------
    list
        Of each course x and y, kg m, and their rates, kg m/s.
    """
    unbalances = []
    for factors, time in courses:
        after = [sum((part * begin for part, (begin, _) in zip(own, factors, strict=True)), 0.0) for own in (x, y)]
        rate = [
            sum((part * (end - begin) / time for part, (begin, end) in zip(own, factors, strict=True)), 0.0)
            for own in (x, y)
        ]
        unbalances.append([*after, *rate])
    return unbalances


# States at the start, and the sizes of motions for tolerances.


def start_angles(balls: tuple[Ball, ...], random: np.random.Generator, *, given: bool = True) -> list[float]:
    """Given angles, or (always if not ``given``) random ones at which the balls of a race do not overlap."""
    angles: list[float] = []
    places = sorted({(ball.balancer, ball.race) for ball in balls})
    for place in places:
        race = [ball for ball in balls if (ball.balancer, ball.race) == place]
        if given and race[0].start_angle is not None:
            angles += [float(ball.start_angle or 0.0) for ball in race]
            continue
        gaps = random.dirichlet(np.ones(len(race))) * (2.0 * math.pi - occupied_angle(race))
        angle = random.uniform(0.0, 2.0 * math.pi)
        for number, ball in enumerate(race):
            angles.append(angle)
            angle += gaps[number] + 0.5 * occupied_angle([ball, race[(number + 1) % len(race)]])
    return angles


def planar_start(machine: Machine, balls: tuple[Ball, ...], system: System, speed: float, angles: Floats) -> Floats:
    """State of a planar rotor and its balls at time 0."""
    n = len(balls)
    state = np.zeros(BALLS + 2 * n)
    angle = float(machine.start.rotor_angle)
    back = cmath.exp(-1j * angle) if system.rotating else 1.0
    place = complex(*machine.start.deflection) * back
    velocity = complex(*machine.start.velocity) * back
    state[[X, Y, VX, VY, THETA, SPEED]] = place.real, place.imag, velocity.real, velocity.imag, angle, speed
    state[BALLS : BALLS + n] = angles
    state[BALLS + n :] = [ball.start_speed for ball in balls]
    return state


def planar_scales(machine: Machine, balls: tuple[Ball, ...], system: System) -> tuple[Floats, Floats]:
    """Size of each component of such a state, and 1 where the tolerance grows with the component."""
    length, velocity, frequency = planar_sizes(
        machine, balls, system, [unbalance.size for unbalance in machine.unbalances]
    )
    scale, growing = np.ones(BALLS + 2 * len(balls)), np.zeros(BALLS + 2 * len(balls))
    scale[[X, Y]] = length
    scale[[VX, VY]] = velocity
    scale[SPEED] = frequency
    scale[BALLS + len(balls) :] = frequency
    growing[[X, Y, VX, VY]] = 1.0
    return scale, growing


def planar_sizes(
    machine: Machine, balls: tuple[Ball, ...], system: System, unbalances: Sequence[Any]
) -> tuple[Any, Any, float]:
    """Sizes of motions of a planar rotor with unbalances of these moments, kg m.

    A moment may be an array over many machines that differ in it; the sizes are arrays over them then.

    Returns
    -------
    deflection, velocity, frequency
        m, m/s, rad/s.
    """
    rotor = system.planar
    frequency = math.sqrt(max(rotor.stiffness_x, rotor.stiffness_y) / rotor.mass)
    drives = sum(unbalances) + sum(ball.moment for ball in balls)
    length = drives / rotor.mass + max((abs(ball.eccentricity) for ball in balls), default=0.0)
    length = np.maximum(length, max(abs(complex(*machine.start.deflection)), 1e-9))
    return length, length * frequency, frequency


# Equal balls that pass through each other, made a little unequal.
#
# Equal balls in one place obey equal equations and never part again, stable or not. Real balls are never equal: within
# a lot of grade 10 (ISO 3290-1) diameters differ by up to 0.5 um, the masses of balls of 5 mm by 3e-4. A spread far
# below that leaves every number of a result as it is and lets the balls leave a state that has become unstable.


MASS_SPREAD = 1e-6  # heaviest less lightest of equal balls over their mass, where nobody says another


def equal_groups(machine: Machine, balls: tuple[Ball, ...]) -> list[list[int]]:
    """Numbers of the balls that are equal, share a race and may lie in one place; only groups of two or more."""
    if is_resolved(machine):
        return []
    groups: dict[tuple[object, ...], list[int]] = {}
    for number, ball in enumerate(balls):
        race = machine.balancers[ball.balancer].races[ball.race]
        mates = [other for other in balls if (other.balancer, other.race) == (ball.balancer, ball.race)]
        if not race.collisions or any(other.diameter == 0.0 for other in mates):
            alike = (ball.balancer, ball.race, ball.mass, ball.diameter, ball.orbit_radius, ball.spin_ratio)
            groups.setdefault(alike, []).append(number)
    return [members for members in groups.values() if len(members) > 1]


def with_mass_spread(machine: Machine, balls: tuple[Ball, ...], spread: float, seed: int) -> tuple[Ball, ...]:
    """The balls with masses at equal steps around their mean, in an order drawn from the seed.

    Raises
    ------
    QuestionError
        For a spread below 0, or of 0.1 and more.
    """
    if not (math.isfinite(spread) and 0.0 <= spread < 0.1):
        raise QuestionError(
            f"mass_spread: given {spread:g}; must be from 0 to less than 0.1, relative to the mass of a ball"
        )
    if spread == 0.0:
        return balls
    random = generator(seed, 3290)
    changed = list(balls)
    for members in equal_groups(machine, balls):
        steps = random.permutation(np.linspace(-0.5, 0.5, len(members)))
        for number, step in zip(members, steps, strict=True):
            changed[number] = replace(balls[number], mass=balls[number].mass * (1.0 + spread * float(step)))
    return tuple(changed)


def _pulled(parts: Parts, x: float, y: float) -> Floats:
    """Coordinates r of the rotor pulled at its reference place to (x, y) by a static force there."""
    if x == 0.0 and y == 0.0:
        return np.zeros(parts.size)
    shape = np.linalg.solve(parts.small(parts.model.stiffness_at(0.0)), np.eye(parts.size)[:, :2])
    return np.asarray(shape @ np.linalg.solve(shape[:2], [x, y]))


def _struck(parts: Parts, x: float, y: float) -> Floats:
    """Velocities of r of the rotor struck at its reference place, which moves at (x, y) afterwards."""
    shape = np.linalg.inv(parts.mass)[:, :2]
    return np.asarray(shape @ np.linalg.solve(shape[:2], [x, y]))


def _start_of_links(machine: Machine, speed: float) -> Floats:
    """State of the links at time zero: no twist, all at the speed of the rotor, the stator at rest."""
    return np.array(
        [x for part in links_of(machine.drive) for x in (0.0, speed if isinstance(part, Coupling) else 0.0)]
    )


def _scale_of_links(machine: Machine, frequency: float) -> Floats:
    """Size of their motions: speeds as all others, twists as they belong to such speeds."""
    values: list[float] = []
    for part in links_of(machine.drive):
        inertia = min(float(machine.rotor.inertia or math.inf), float(part.inertia or math.inf))
        values += [min(1.0, frequency / math.sqrt(part.stiffness / inertia)), frequency]
    return np.array(values)
