"""From a machine to the numbers of its equations of motion."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from autobalancer.assembly.contacts import set_contacts
from autobalancer.assembly.fluid_numbers import Lags, mode_count
from autobalancer.assembly.mass_spread import with_mass_spread
from autobalancer.assembly.profile import Piece, profile_pieces, unbalance_factor
from autobalancer.assembly.race_numbers import is_real, race_numbers
from autobalancer.assembly.resolved import is_resolved, resolved_numbers, resolved_scales, resolved_size, start_states
from autobalancer.assembly.rotors.reduction import Reduction
from autobalancer.assembly.spatial import Parts, pulled, rotor_numbers, spatial_parts, struck, top_speed, turned
from autobalancer.catalog.resolve import Ball, occupied_angle, resolve
from autobalancer.catalog.resolve_springs import planar_rotor
from autobalancer.errors import MachineError
from autobalancer.kernels.resolved_layout import BALL_STATES
from autobalancer.kernels.system import (
    BALL_COLUMNS,
    BALLS,
    DRAG,
    DRIVE,
    INERTIA,
    KIND,
    LINEAR,
    MASS,
    MOMENT,
    NEXT,
    OFFSET_X,
    OFFSET_Y,
    ORBIT,
    PRESCRIBED,
    SEGMENT_COLUMNS,
    SPEED,
    SPIN,
    START,
    STATION,
    THETA,
    TORQUE,
    UNBALANCE,
    VX,
    VY,
    WALL_HIGH,
    WALL_LOW,
    Floats,
    Matrix,
    System,
    X,
    Y,
)
from autobalancer.machine import ConstantTorque, Machine, PlanarRotor, PrescribedSpeed, TargetTorque, TorqueTable
from autobalancer.random_numbers import generator


@dataclass(frozen=True)
class Assembly:
    """A machine ready to integrate: its system, its state at time 0, the size of its motions."""

    system: System
    state: Floats  # (6 + 2 n,)
    scale: Floats  # (6 + 2 n,) size of each component, for absolute tolerances
    growing: Floats  # (6 + 2 n,) 1 where the tolerance grows with the component, 0 for angles and speeds
    balls: tuple[Ball, ...]
    critical_speeds: tuple[float, ...] = ()  # undamped, with the balls on the rotor, ascending
    general: bool = False  # whether the equations are those of kernels/stations.py
    resolved: bool = False  # whether they are those of kernels/resolved_balls.py
    reference: str = ""  # the place whose deflection is X, Y
    stations: dict[str, Matrix] = field(default_factory=dict)  # rows (2, R) of the named stations
    reduction: Reduction | None = None
    places: Matrix = field(default_factory=lambda: np.zeros((0, 2, 0)))  # rows (P, 2, R) of the balancers


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
    if general or beyond or not isinstance(machine.rotor, PlanarRotor):
        return assemble_general(machine, balls, seed=seed, rotating=rotating, contact=contact, lags=lags or {})
    pull = float(machine.gravity) if machine.axis == "horizontal" else 0.0
    isotropic = machine.rotor.isotropic
    turns = (isotropic and pull == 0.0) if rotating is None else rotating and isotropic
    rotor = planar_rotor(machine)
    (kx, ky), (bx, by) = rotor.stiffness_xy, rotor.damping_xy
    system = System(
        rotating=1.0 if turns else 0.0,
        mass=total_mass(machine, balls),
        stiffness_x=kx,
        stiffness_y=ky,
        damping_x=bx,
        damping_y=by,
        gravity_x=0.0,
        gravity_y=-pull,
        polar_inertia=float(machine.rotor.inertia or 0.0) + sum(ball_inertia(ball) for ball in balls),
        balls=ball_matrix(balls),
        rotor=np.zeros(0),
        **drive_numbers(machine),
    )
    critical = tuple(critical_speeds(system))
    state = _start(machine, balls, system, seed)
    if contact and balls:
        fastest = max(top_speed(machine) or 0.0, *critical)
        state[BALLS : BALLS + len(balls)] = set_contacts(machine, balls, _angles(state, balls), system.balls, fastest)
    scale, growing = _scales(machine, balls, system)
    return Assembly(system, state, scale, growing, balls, critical)


def _angles(state: Floats, balls: tuple[Ball, ...]) -> Floats:
    return state[BALLS : BALLS + len(balls)]


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
    """Numbers of a machine for the equations of kernels/stations.py and kernels/guided_race.py."""
    pull = float(machine.gravity) if machine.axis == "horizontal" else 0.0
    parts = spatial_parts(machine, balls) if parts is None else parts
    resolved = is_resolved(machine)
    real = not resolved and is_real(machine, balls, lags)
    if real and machine.tilting_races == "full":
        raise MachineError(
            "tilting_races: the full motion on a tilting race supports only linear drag on smooth circular races; "
            "take 'deflection', or leave out friction, drag over the whole range, slipstream, waves of the race and excitations"
        )
    calm = pull == 0.0 and not machine.excitations
    turns = (parts.isotropic and calm) if rotating is None else rotating and parts.isotropic
    if machine.excitations:
        turns = False
    numbers = drive_numbers(machine)
    rotor = rotor_numbers(machine, parts, numbers["segments"])
    n, size = len(balls), parts.size
    state = np.zeros(2 + 2 * size + 2 * n)
    if real:
        rotor = race_numbers(machine, parts, balls, rotor, lags, state.size)
        state = np.zeros(state.size + mode_count(lags))
    own = slice(state.size, state.size + BALL_STATES * n)
    angles = np.array(start_angles(balls, generator(seed)), np.float64)
    if resolved:
        rotor = resolved_numbers(machine, parts, balls, angles, rotor, lags, state.size)
        state = np.zeros(state.size + resolved_size(balls, lags))
    system = System(
        rotating=1.0 if turns else 0.0,
        mass=parts.model.total_mass + sum(ball.effective_mass for ball in balls),
        stiffness_x=0.0,
        stiffness_y=0.0,
        damping_x=0.0,
        damping_y=0.0,
        gravity_x=0.0,
        gravity_y=-pull,
        polar_inertia=float(machine.rotor.inertia or 0.0)
        + (0.0 if real or resolved else sum(ball_inertia(ball) for ball in balls)),
        balls=ball_matrix(balls),
        rotor=rotor,
        **numbers,
    )
    rest = BALLS + 2 * n
    angle = float(machine.start.rotor_angle)
    state[[THETA, SPEED]] = angle, _first_speed(machine, system)
    where = [X, Y, *range(rest, rest + size - 2)]
    fast = [VX, VY, *range(rest + size - 2, rest + 2 * size - 4)]
    place, velocity = pulled(parts, *machine.start.deflection), struck(parts, *machine.start.velocity)
    state[where] = turned(place, -angle) if turns else place
    state[fast] = turned(velocity, -angle) if turns else velocity
    state[BALLS : BALLS + n] = angles
    fastest = max([top_speed(machine) or 0.0, *parts.critical_speeds])
    if contact and balls and not resolved:
        state[BALLS : BALLS + n] = set_contacts(machine, balls, _angles(state, balls), system.balls, fastest)
    state[BALLS + n : rest] = [ball.start_speed for ball in balls]
    length, frequency = parts.length(balls), parts.frequency
    length = max(length, abs(complex(*machine.start.deflection)), 1e-9)
    scale, growing = np.ones(state.size), np.zeros(state.size)
    scale[where], scale[fast] = length, length * frequency
    growing[where] = growing[fast] = 1.0
    scale[SPEED] = scale[BALLS + n : rest] = scale[2 + 2 * size + 2 * n :] = frequency
    if resolved:
        state[own] = start_states(machine, balls, _angles(state, balls), rotor, state[SPEED]).ravel()
        scale[own] = resolved_scales(balls, rotor, fastest).ravel()
    return Assembly(
        system, state, scale, growing, balls, parts.critical_speeds, True, resolved, parts.reference, parts.stations,
        parts.reduction, parts.places,
    )  # fmt: skip


def drive_numbers(machine: Machine) -> dict[str, Any]:
    """The fields of a system that drive and schedules fill."""
    drive = machine.drive
    table = np.zeros((0, 2))
    if isinstance(drive, TorqueTable):
        table = np.column_stack([[float(w) for w in drive.speed], [float(q) for q in drive.torque]])
    return {
        "drive": PRESCRIBED if isinstance(drive, PrescribedSpeed) else TORQUE,
        "torque_damping": 0.0 if isinstance(drive, PrescribedSpeed) else float(drive.damping),
        "torque_table": np.ascontiguousarray(table, np.float64),
        "segments": _segments(machine),
        "now": np.zeros(1, np.int64),
    }


def total_mass(machine: Machine, balls: tuple[Ball, ...]) -> float:
    """Mass of a planar rotor and its balls (effective), kg."""
    assert isinstance(machine.rotor, PlanarRotor)
    return float(machine.rotor.mass) + sum(ball.effective_mass for ball in balls)


def critical_speeds(system: System) -> list[float]:
    """Undamped critical speeds with the balls on the rotor, rad/s, ascending; one if the supports are isotropic."""
    return sorted({math.sqrt(k / system.mass) for k in (system.stiffness_x, system.stiffness_y)})


def unbalance_at(system: System, time: float) -> complex:
    """Resultant unbalance in the rotor at a time (just after a jump), kg m."""
    rows = system.segments
    row = rows[max(0, int(np.searchsorted(rows[:, START], time, side="right")) - 1)]
    u = row[UNBALANCE : UNBALANCE + 2] + (time - row[START]) * row[UNBALANCE + 2 : UNBALANCE + 4]
    return complex(u[0], u[1])


def ball_inertia(ball: Ball) -> float:
    """Inertia of a ball about the shaft, its own spin included, kg m^2."""
    spin = ball.spin_ratio * ball.mass * ball.radius**2
    return spin + ball.effective_mass * (abs(ball.eccentricity) ** 2 + ball.orbit_radius**2)


def ball_matrix(balls: tuple[Ball, ...]) -> Matrix:
    matrix = np.zeros((len(balls), BALL_COLUMNS))
    for row, ball in zip(matrix, balls, strict=True):
        row[MASS] = ball.effective_mass
        row[MOMENT] = ball.moment
        row[INERTIA] = ball.inertia
        row[SPIN] = ball.moment * ball.orbit_radius - ball.spin_ratio * ball.mass * ball.radius * ball.orbit_radius
        row[DRAG] = ball.drag
        row[OFFSET_X], row[OFFSET_Y] = ball.eccentricity.real, ball.eccentricity.imag
        row[NEXT], row[WALL_LOW], row[WALL_HIGH] = -1.0, -math.inf, math.inf
        row[ORBIT], row[STATION] = ball.orbit_radius, ball.balancer
    return matrix


def _drive_pieces(machine: Machine) -> list[Piece]:
    drive = machine.drive
    if isinstance(drive, PrescribedSpeed):
        return profile_pieces(drive.profile)
    if isinstance(drive, ConstantTorque):
        return [Piece(0.0, LINEAR, (float(drive.torque), 0.0, 0.0, 0.0))]
    if isinstance(drive, TargetTorque):
        gain = float(drive.gain)
        pieces = profile_pieces(drive.profile)
        scaled = []
        for piece in pieces:
            a, b, c, d = piece.numbers
            linear = piece.kind == LINEAR
            scaled.append(
                Piece(
                    piece.start,
                    piece.kind,
                    (gain * a, gain * b if linear else b, c, d if linear else gain * d),
                )
            )
        return scaled
    return [Piece(0.0, LINEAR, (0.0, 0.0, 0.0, 0.0))]


def _segments(machine: Machine) -> Matrix:
    """The common grid of all times at which drive or unbalance take another course."""
    pieces = _drive_pieces(machine)
    times = {0.0, *(piece.start for piece in pieces)}
    for unbalance in machine.unbalances:
        if unbalance.schedule is not None:
            times |= {float(t) for t in unbalance.schedule.time}
    grid = sorted(times)
    rows = np.zeros((len(grid), SEGMENT_COLUMNS))
    for number, (row, time) in enumerate(zip(rows, grid, strict=True)):
        piece = [p for p in pieces if p.start <= time][-1]
        row[START], row[KIND] = time, piece.kind
        row[DRIVE : DRIVE + 4] = piece.at(time)
        after, change = 0j, 0j
        for unbalance in machine.unbalances:
            vector = cmath.rect(unbalance.size, float(unbalance.angle))
            factor = unbalance_factor(unbalance, time)
            after += vector * factor
            if number + 1 < len(grid):
                late = unbalance_factor(unbalance, grid[number + 1], before=True)
                change += vector * (late - factor) / (grid[number + 1] - time)
        row[UNBALANCE : UNBALANCE + 4] = after.real, after.imag, change.real, change.imag
    return rows


def _first_speed(machine: Machine, system: System) -> float:
    first = system.segments[0]
    if system.drive == PRESCRIBED:
        return float(first[DRIVE]) if first[KIND] == LINEAR else float(first[DRIVE + 3])
    return float(machine.start.speed)


def _start(machine: Machine, balls: tuple[Ball, ...], system: System, seed: int) -> Floats:
    n = len(balls)
    state = np.zeros(BALLS + 2 * n)
    speed = _first_speed(machine, system)
    angle = float(machine.start.rotor_angle)
    back = cmath.exp(-1j * angle) if system.rotating else 1.0
    place = complex(*machine.start.deflection) * back
    velocity = complex(*machine.start.velocity) * back
    state[[X, Y, VX, VY, THETA, SPEED]] = place.real, place.imag, velocity.real, velocity.imag, angle, speed
    state[BALLS : BALLS + n] = start_angles(balls, generator(seed))
    state[BALLS + n :] = [ball.start_speed for ball in balls]
    return state


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


def _scales(machine: Machine, balls: tuple[Ball, ...], system: System) -> tuple[Floats, Floats]:
    frequency = math.sqrt(max(system.stiffness_x, system.stiffness_y) / system.mass)
    drives = sum(unbalance.size for unbalance in machine.unbalances) + sum(ball.moment for ball in balls)
    length = drives / system.mass + max((abs(ball.eccentricity) for ball in balls), default=0.0)
    length = max(length, abs(complex(*machine.start.deflection)), 1e-9)
    scale, growing = np.ones(BALLS + 2 * len(balls)), np.zeros(BALLS + 2 * len(balls))
    scale[[X, Y]] = length
    scale[[VX, VY]] = length * frequency
    scale[SPEED] = frequency
    scale[BALLS + len(balls) :] = frequency
    growing[[X, Y, VX, VY]] = 1.0
    return scale, growing
