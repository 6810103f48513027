"""Contact-resolved balls as the rows and states of kernels/resolved_layout.py."""

from __future__ import annotations

import cmath
import math
from functools import partial
from typing import Any

import numpy as np

from autobalancer.assembly.contacts import restitution
from autobalancer.assembly.excitations import add_excitations
from autobalancer.assembly.fluid_numbers import FluidNumbers, Lags, mode_count
from autobalancer.assembly.race_numbers import Shapes
from autobalancer.assembly.resolved_walls import (
    damping_number,
    orbit_at,
    partition_numbers,
    refuse_sharp_waves,
    refuse_soft_wall,
    room,
    stiffnesses,
)
from autobalancer.assembly.spatial import Parts
from autobalancer.catalog.resolve import Ball
from autobalancer.errors import MachineError
from autobalancer.kernels import resolved_layout as at
from autobalancer.kernels.rotor_layout import BALL_ROWS, SHAKERS
from autobalancer.kernels.system import Floats, Matrix, System
from autobalancer.machine import Machine, Race
from autobalancer.machine.part import ImpossiblePart, Problem


def is_resolved(machine: Machine) -> bool:
    """Whether the balls are resolved in contact.

    Raises
    ------
    MachineError
        If they are in some races only, or something else is asked for that these balls do not know.
    """
    races = [(b, r, race) for b, balancer in enumerate(machine.balancers) for r, race in enumerate(balancer.races)]
    if not any(race.resolved is not None for _, _, race in races):
        return False
    problems: list[Problem] = [
        (("balancers", b, "races", r, "resolved"), "missing here, but given for another race; give it for all or none")
        for b, r, race in races
        if race.resolved is None
    ]
    if problems:
        raise ImpossiblePart("Machine", problems)
    if machine.tilting_races == "full":
        raise MachineError("tilting_races: resolved balls do not follow the tilt of their race; use 'deflection'")
    return True


def resolved_size(balls: tuple[Ball, ...], lags: Lags) -> int:
    """Further states of the balls and of their fluids."""
    return len(balls) * at.BALL_STATES + mode_count(lags)


def resolved_numbers(
    machine: Machine,
    parts: Parts,
    balls: tuple[Ball, ...],
    angles: Floats,
    rotor: Floats,
    lags: Lags,
    first_state: int,
) -> Floats:
    """``rotor`` with the rows of the balls behind it; their states begin at ``first_state``, modes of fluids follow.

    ``angles`` at the start say between which partitions a ball is; drawn ones that overlap one are moved to its side.
    """
    numbers = list(rotor)
    rows, first_mode = len(numbers), first_state + len(balls) * at.BALL_STATES
    numbers += [0.0] * (len(balls) * at.RESOLVED_COLUMNS)
    fluids, shapes = FluidNumbers(numbers, at, balls, lags, first_mode), Shapes(machine, numbers)
    for i, ball in enumerate(balls):
        race = machine.balancers[ball.balancer].races[ball.race]
        row = rows + i * at.RESOLVED_COLUMNS
        put = partial(_put, numbers, row)
        for column, value in _columns(machine, race, ball).items():
            put(column, value)
        put(at.SHAPE, shapes.place(ball))
        if race.partitions is not None:
            put(at.PARTITIONS, len(numbers))
            found, angles[i] = partition_numbers(race, ball, angles[i], relative_mass(ball))
            numbers += found
        fluids.put(i, put)
    numbers[BALL_ROWS], numbers[SHAKERS] = rows, add_excitations(machine, parts, numbers)
    return np.array(numbers, np.float64)


def _put(numbers: list[float], row: int, column: int, value: float) -> None:
    numbers[row + column] = float(value)


def relative_mass(ball: Ball) -> float:
    """Mass, with virtual mass, that motion relative to the chamber has, kg."""
    return ball.mass + ball.virtual_mass * ball.displaced


def _columns(machine: Machine, race: Race, ball: Ball) -> dict[int, float]:
    """All of a row that is not a place of further numbers."""
    contact = race.resolved
    assert contact is not None
    whole, gap = relative_mass(ball), room(race, ball)
    refuse_sharp_waves(race, ball, gap)
    outer_k, inner_k, ball_k = stiffnesses(contact, ball, ball.orbit_radius - gap - ball.radius)
    hertz = contact.reduced_modulus is not None
    refuse_soft_wall(machine, ball, outer_k, hertz)
    ratio = damping_number(contact, float(contact.restitution)) if contact.restitution is not None else 0.0
    if race.contact is not None and race.contact.stiffness is not None and not hertz:
        ball_k = float(race.contact.stiffness)
    friction = race.friction
    hold = float(contact.adherence_stiffness)
    vertical = machine.axis == "vertical"
    return {
        at.MASS_: ball.effective_mass,
        at.EXTRA: whole - ball.effective_mass,
        at.SPIN_INERTIA: ball.spin_ratio * ball.mass * ball.radius**2,
        at.RADIUS: ball.radius,
        at.ORBIT_: ball.orbit_radius,
        at.CENTER_X: ball.eccentricity.real,
        at.CENTER_Y: ball.eccentricity.imag,
        at.PLACE_: ball.balancer,
        at.RACE_: -1.0 if race.coincidence else 1000.0 * ball.balancer + ball.race,
        at.GAP: gap,
        at.HERTZ: float(hertz),
        at.WALL_STIFFNESS: outer_k,
        at.INNER_STIFFNESS: inner_k,
        at.WALL_DAMPING: float(contact.damping) if contact.damping is not None else ratio * math.sqrt(outer_k * whole),
        at.INNER_DAMPING: float(contact.damping) if contact.damping is not None else ratio * math.sqrt(inner_k * whole),
        at.BALL_STIFFNESS: ball_k,
        at.BALL_DAMPING: damping_number(contact, restitution(race)),
        at.SLIDING: float(contact.sliding_friction),
        at.PEAK: float(contact.peak_friction or contact.sliding_friction),
        at.SLIP_SPEED: float(contact.slip_speed),
        at.PEAK_SPEED: float(contact.peak_speed or 1.0),
        at.ROLLING_ARM: float(friction.rolling_resistance) * ball.radius if friction is not None else 0.0,
        at.REST_SPEED: float(contact.rest_speed or 1.0),
        at.ADHERENCE: float(friction.adherence or 0.0) if friction is not None else 0.0,
        at.HOLD_STIFFNESS: hold,
        at.HOLD_DAMPING: 2.0 * math.sqrt(hold * whole),
        at.FLOOR: float(contact.floor_friction),
        at.WEIGHT: ball.effective_mass * float(machine.gravity) if vertical else 0.0,
        at.BALL_SLIDING: float(contact.ball_friction),
        at.VISCOUS: ball.drag / ball.orbit_radius**2,
    }


def start_states(machine: Machine, balls: tuple[Ball, ...], angles: Floats, rotor: Floats, speed: float) -> Matrix:
    """Balls that roll at their start angles and speeds, pressed on their wall by the ``speed`` of the rotor (rad/s)."""
    states = np.zeros((len(balls), at.BALL_STATES))
    for row, numbers, ball, angle in zip(states, rows_of(rotor, len(balls)), balls, angles, strict=True):
        race = machine.balancers[ball.balancer].races[ball.race]
        assert race.resolved is not None
        radius, slope = orbit_at(race, ball, angle)
        steep = math.hypot(1.0, slope / radius)  # distance along the radius over distance from the wall
        beyond = -float(race.resolved.start_gap)
        if race.resolved.start_gap == 0.0:
            in_space, rest = speed + ball.start_speed, relative_mass(ball) - ball.effective_mass
            force = ball.orbit_radius * (ball.effective_mass * in_space**2 + rest * ball.start_speed**2)
            beyond = _depth(numbers, force)
        place = (radius + beyond * steep) * cmath.rect(1.0, angle)
        velocity = (slope * cmath.rect(1.0, angle) + 1j * place) * ball.start_speed
        row[[at.BALL_X, at.BALL_Y]] = place.real, place.imag
        row[[at.BALL_VX, at.BALL_VY]] = velocity.real, velocity.imag
        if race.resolved.start_gap == 0.0:
            along = (velocity * (1j * radius + slope).conjugate() * cmath.rect(1.0, -angle)).real / abs(
                radius + 1j * slope
            )
            row[at.BALL_SPIN] = -along / ball.radius
    return states


def resolved_scales(balls: tuple[Ball, ...], rotor: Floats, fastest: float) -> Matrix:
    """Sizes of the states for tolerances, (n, BALL_STATES): depth of contact and its frequency at the speed ``fastest``."""
    scales = np.ones((len(balls), at.BALL_STATES))
    rows = rows_of(rotor, len(balls))
    for scale, row, ball in zip(scales, rows, balls, strict=True):
        force = max(ball.moment * fastest**2, 10.0 * ball.effective_mass)
        power = 1.5 if row[at.HERTZ] else 1.0
        depth = _depth(row, force)
        frequency = math.sqrt(power * force / depth / relative_mass(ball))
        scale[[at.BALL_X, at.BALL_Y, at.HOLD]] = depth
        scale[[at.BALL_VX, at.BALL_VY]] = depth * frequency
        scale[at.BALL_SPIN] = depth * frequency / ball.radius
    return scales


def _depth(row: Floats, force: float) -> float:
    """How deep the outer wall is pressed by a force, m."""
    return float((force / row[at.WALL_STIFFNESS]) ** (2.0 / 3.0 if row[at.HERTZ] else 1.0))


def rows_of(rotor: Floats, count: int) -> Matrix:
    """The rows of the balls, (count, RESOLVED_COLUMNS)."""
    first = int(rotor[BALL_ROWS])
    return np.asarray(rotor[first : first + count * at.RESOLVED_COLUMNS].reshape(count, at.RESOLVED_COLUMNS))


def ball_states(states: Matrix, system: System, rotor_size: int) -> Any:
    """The states of the balls alone, (times, n, BALL_STATES)."""
    count = system.balls.shape[0]
    first = 2 + 2 * rotor_size + 2 * count
    return states[:, first : first + count * at.BALL_STATES].reshape(-1, count, at.BALL_STATES)
