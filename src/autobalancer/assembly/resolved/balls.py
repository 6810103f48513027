"""Contact-resolved balls as rows and states of kernels/records/resolved.py."""

from __future__ import annotations

import cmath
import math
from typing import Any

import numpy as np

from autobalancer.assembly.contact.meetings import meeting_table
from autobalancer.assembly.contact.rebound import Tables, dampers, least_rebound
from autobalancer.assembly.fluids import FluidRows, Lags, mode_count
from autobalancer.assembly.resolved.friction import friction_rows
from autobalancer.assembly.resolved.walls import (
    damping_number,
    meeting_damping,
    orbit_at,
    refuse_sharp_waves,
    refuse_soft_wall,
    room,
    set_partitions,
    stiffnesses,
)
from autobalancer.assembly.waves import WaveRows
from autobalancer.catalog.resolve import Ball
from autobalancer.errors import MachineError
from autobalancer.kernels.records import resolved as at
from autobalancer.kernels.records.fluid import NONE
from autobalancer.kernels.records.resolved import FREE, FREE_BALL, PARTITION
from autobalancer.kernels.system import Floats, Integers, Matrix, Rows, System
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


def free_rows(machine: Machine, balls: tuple[Ball, ...], angles: Floats, fluids: FluidRows) -> dict[str, Rows]:
    """Rows of the balls, of their partitions and of the waves of their races, as fields of a system.

    ``angles`` at the start say between which partitions a ball is; drawn ones that overlap one are moved to its side.
    """
    rows, waves, tables = FREE_BALL.rows(len(balls)), WaveRows(machine), Tables(dampers)
    bounded = [i for i, b in enumerate(balls) if machine.balancers[b.balancer].races[b.race].partitions is not None]
    partitions = PARTITION.rows(len(bounded))
    for i, (row, ball) in enumerate(zip(rows, balls, strict=True)):
        race = machine.balancers[ball.balancer].races[ball.race]
        _fill(row, machine, race, ball)
        row.rebound = _wall_table(tables, race, ball)
        waves.fill(row, ball)
        fluids.fill(row, i)
        row.partition = bounded.index(i) if i in bounded else NONE
        if i in bounded:
            angles[i] = set_partitions(partitions[row.partition], race, ball, angles[i], relative_mass(ball), tables)
    pairs = _pair_tables(tables, machine, balls)
    others = friction_rows(machine, balls, rows) | {"rebounds": tables.numbers, "pair_rebounds": pairs}
    return {"free_balls": rows, "free": FREE.rows(len(balls)), "partitions": partitions, "waves": waves.rows} | others


def _wall_table(tables: Tables, race: Race, ball: Ball) -> int:
    """Where the table of a ball and the walls of its race begins."""
    contact = race.resolved
    assert contact is not None
    return tables.first(contact.rebound, float(contact.restitution or 0.0), least_rebound(contact.rebound, ball))


def _pair_tables(tables: Tables, machine: Machine, balls: tuple[Ball, ...]) -> Integers:
    """Where those of balls that meet begin, row by row; empty if there are none."""
    found = np.full((len(balls), len(balls)), NONE, np.int64)
    for i, one in enumerate(balls):
        race = machine.balancers[one.balancer].races[one.race]
        for j, other in enumerate(balls):
            if i < j and (one.balancer, one.race) == (other.balancer, other.race):
                found[i, j] = meeting_table(tables, race, one, other)
    return found.ravel() if (found != NONE).any() else np.zeros(0, np.int64)


def relative_mass(ball: Ball) -> float:
    """Mass, with virtual mass, that motion relative to the chamber has, kg."""
    return ball.mass + ball.virtual_mass * ball.displaced


def _fill(row: Any, machine: Machine, race: Race, ball: Ball) -> None:
    """All of a row that is not a place of further numbers."""
    contact = race.resolved
    assert contact is not None
    whole, gap = relative_mass(ball), room(race, ball)
    refuse_sharp_waves(race, ball, gap)
    outer_k, inner_k, ball_k = stiffnesses(contact, ball, ball.orbit_radius - gap - ball.radius)
    hertz = contact.reduced_modulus is not None
    refuse_soft_wall(machine, ball, outer_k, hertz)
    left = contact.restitution
    ratio = damping_number(contact, float(left), contact.rebound) if left is not None else 0.0
    if race.contact is not None and race.contact.stiffness is not None and not hertz:
        ball_k = float(race.contact.stiffness)
    friction = race.friction
    hold = float(contact.adherence_stiffness)
    vertical = machine.axis == "vertical"
    row.mass = ball.effective_mass
    row.extra = whole - ball.effective_mass
    row.spin_inertia = ball.own_inertia
    row.radius = ball.radius
    row.orbit = ball.orbit_radius
    row.center_x = ball.eccentricity.real
    row.center_y = ball.eccentricity.imag
    row.station = ball.balancer
    row.race = -1 if race.coincidence else 1000 * ball.balancer + ball.race
    row.gap = gap
    row.hertz = int(hertz)
    row.wall_stiffness = outer_k
    row.inner_stiffness = inner_k
    row.wall_damping = float(contact.damping) if contact.damping is not None else ratio * math.sqrt(outer_k * whole)
    row.inner_damping = float(contact.damping) if contact.damping is not None else ratio * math.sqrt(inner_k * whole)
    row.ball_stiffness = ball_k
    row.ball_damping = meeting_damping(contact, race)
    row.sliding = float(contact.sliding_friction)
    row.slip_speed = float(contact.slip_speed)
    row.rolling_arm = float(friction.rolling_resistance) * ball.radius if friction is not None else 0.0
    row.rest_speed = float(contact.rest_speed or 1.0)
    row.adherence = float(friction.adherence or 0.0) if friction is not None else 0.0
    row.hold_stiffness = hold
    row.hold_damping = 2.0 * math.sqrt(hold * whole)
    row.floor = float(contact.floor_friction)
    row.floor_arm = ball.radius if contact.floor_motion == "rolling" and vertical and row.floor > 0.0 else 0.0
    row.weight = ball.effective_mass * float(machine.gravity) if vertical else 0.0
    row.ball_sliding = float(contact.ball_friction)
    row.viscous = ball.drag / ball.orbit_radius**2


def start_states(machine: Machine, balls: tuple[Ball, ...], angles: Floats, rows: Rows, speed: float) -> Matrix:
    """Balls that roll at their start angles and speeds, pressed on their wall by the ``speed`` of the rotor (rad/s)."""
    states = np.zeros((len(balls), at.BALL_STATES))
    for row, numbers, ball, angle in zip(states, rows, balls, angles, strict=True):
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
            if numbers.floor_arm > 0.0:  # on floor and wall at once it turns about their diagonal
                normal = (radius - 1j * slope) * cmath.rect(1.0, angle) / abs(radius + 1j * slope)
                row[[at.TUMBLE_X, at.TUMBLE_Y]] = row[at.BALL_SPIN] * normal.real, row[at.BALL_SPIN] * normal.imag
    return states


def resolved_scales(balls: tuple[Ball, ...], rows: Rows, speed: float) -> Matrix:
    """Sizes of the states for tolerances, (n, BALL_STATES): depth of contact and its frequency at this speed of the rotor."""
    scales = np.ones((len(balls), at.BALL_STATES))
    for scale, row, ball in zip(scales, rows, balls, strict=True):
        force = max(ball.moment * speed**2, 10.0 * ball.effective_mass)
        power = 1.5 if row.hertz else 1.0
        depth = _depth(row, force)
        frequency = math.sqrt(power * force / depth / relative_mass(ball))
        scale[[at.BALL_X, at.BALL_Y, at.HOLD]] = depth
        scale[[at.BALL_VX, at.BALL_VY]] = depth * frequency
        scale[[at.BALL_SPIN, at.TUMBLE_X, at.TUMBLE_Y]] = depth * frequency / ball.radius
    return scales


def _depth(row: Any, force: float) -> float:
    """How deep the outer wall is pressed by a force, m."""
    return float((force / row.wall_stiffness) ** (2.0 / 3.0 if row.hertz else 1.0))


def ball_states(states: Matrix, system: System, rotor_size: int) -> Any:
    """The states of the balls alone, (times, n, BALL_STATES)."""
    count = system.ball_count
    first = 2 + 2 * rotor_size + 2 * count
    return states[:, first : first + count * at.BALL_STATES].reshape(-1, count, at.BALL_STATES)
