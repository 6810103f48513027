"""Which balls can meet, and the springs and dampers between them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from autobalancer.assembly.contact.rebound import Tables, dampers, least_rebound, remainders
from autobalancer.catalog.resolve import Ball, occupied_angle
from autobalancer.errors import MachineError
from autobalancer.kernels.laws.rebound import NONE
from autobalancer.kernels.records.guided import CONTACT
from autobalancer.kernels.system import Floats, Rows
from autobalancer.laws.rebound import damping_ratio
from autobalancer.laws.touching_balls import TouchingBalls, touching_balls
from autobalancer.machine import Machine, Race

TURN = 2.0 * math.pi
TOUCHING = 1e-9  # rad, by which a ball may start inside a partition
QUICK = 10.0  # frequency of a soft contact without a stiffness over the greatest of the machine

SLOW = 1e-3  # slip at which friction between balls sets in, over the speed of the wall at the greatest frequency
CRITICAL = math.exp(-2.0)  # restitution of critical damping, which costs no more steps
JAMMING = 0.9  # friction between balls from which on they can lock, so that no rigid contact tells how they move
FULL = 1e-9  # rad: play of a race below which its balls have none


class Contacts(NamedTuple):
    """Start angles of the balls (rad), and tables of contacts whose restitution depends on the speed of impacts."""

    angles: Floats
    rebounds: Floats


def contact_rows(count: int) -> Rows:
    """Balls that touch nothing."""
    rows = CONTACT.rows(count)
    rows.next, rows.before, rows.wall_low, rows.wall_high = -1, -1, -math.inf, math.inf
    rows.rebound = rows.wall_rebound = NONE
    return rows


def ring(members: Sequence[int], angles: Floats) -> list[tuple[int, int, float]]:
    """The balls of a race in their order around it: each, the next, and what to add to the angle of that, so that it is ahead."""
    place = {i: math.fmod(math.fmod(angles[i], TURN) + TURN, TURN) for i in members}
    order = sorted(members, key=lambda i: place[i])
    found = []
    for number, i in enumerate(order):
        j = order[(number + 1) % len(order)]
        ahead = place[j] - place[i] + (TURN if number + 1 == len(order) else 0.0)
        found.append((i, j, ahead - (angles[j] - angles[i])))
    return found


def set_contacts(machine: Machine, balls: tuple[Ball, ...], angles: Floats, rows: Rows, frequency: float) -> Contacts:
    """Fill the rows of contacts; ``frequency`` is the greatest of the machine, rad/s.

    The start angles of balls that were not given and overlap a partition are moved to its side.
    """
    rows[:] = contact_rows(len(balls))
    angles, tables = np.array(angles, np.float64), Tables(dampers)
    for b, balancer in enumerate(machine.balancers):
        for number, race in enumerate(balancer.races):
            members = [i for i, ball in enumerate(balls) if (ball.balancer, ball.race) == (b, number)]
            solid = not race.coincidence and all(balls[i].diameter > 0.0 for i in members)
            if race.partitions is not None:
                _set_walls(race, balls, members, angles, rows, frequency, tables)
            if solid and len(members) > 1:
                _set_neighbors(race, balls, members, angles, rows, frequency, tables)
    return Contacts(angles, tables.numbers)


def restitution(race: Race) -> float:
    """Of balls that meet each other or a partition; of slow impacts, where it depends on their speed."""
    return float(race.contact.restitution) if race.contact is not None else CRITICAL


def is_rigid(race: Race) -> bool:
    """Whether balls meet in rigid contacts: where no stiffness is given, nor friction by which they could lock."""
    return race.contact is None or (race.contact.stiffness is None and race.contact.friction < JAMMING)


def has_rigid_friction(machine: Machine) -> bool:
    """Whether balls rub on each other in rigid contacts."""
    races = [race for balancer in machine.balancers for race in balancer.races]
    return any(race.contact is not None and race.contact.friction > 0.0 and is_rigid(race) for race in races)


def meeting_table(tables: Tables, race: Race, one: Ball, other: Ball | None = None, *, rigid: bool = False) -> int:
    """Where the table of a ball that meets another one, or a partition, begins."""
    rebound = race.contact.rebound if race.contact is not None else None
    kind = remainders if rigid else None
    return tables.first(rebound, restitution(race), least_rebound(rebound, one, other), kind)


def parallel(one: float, other: float) -> float:
    """Reduced mass, inertia or radius of two."""
    return one * (other / (one + other))


def _spring_and_damper(race: Race, one: Ball, other: Ball, frequency: float) -> tuple[float, float, float]:
    """Torque over the angle by which two balls overlap, N m/rad, and over the rate of this angle, N m s/rad; frequency, rad/s.

    The torque is the same on both, so their distance moves with the reduced inertia, and neither is the first. The damping is
    that of ratio 1 where the ratio depends on the impact.
    """
    inertia = parallel(one.inertia, other.inertia)
    if race.contact is not None and race.contact.stiffness is not None:
        stiffness = float(race.contact.stiffness) * (one.orbit_radius * other.orbit_radius)
    else:
        stiffness = inertia * (QUICK * frequency) ** 2
    varies = race.contact is not None and race.contact.rebound is not None
    ratio = 1.0 if varies else damping_ratio(restitution(race))
    return stiffness, 2.0 * ratio * math.sqrt(inertia * stiffness), math.sqrt(stiffness / inertia)


def _set_neighbors(
    race: Race,
    balls: tuple[Ball, ...],
    members: list[int],
    angles: Floats,
    rows: Rows,
    frequency: float,
    tables: Tables,
) -> None:
    for i, j, wrap in ring(members, angles):
        if race.partitions is not None and _sector(race, angles[i]) != _sector(race, angles[j] + wrap):
            continue  # a partition has no thickness, but nothing meets through it
        one, other, row = balls[i], balls[j], rows[i]
        row.next, row.wrap, rows[j].before = j, wrap, i
        row.touch = 0.5 * occupied_angle([one, other])
        if is_rigid(race):
            row.rigid, row.left = 1, restitution(race)
        else:
            row.hard, row.soft, row.quick = _spring_and_damper(race, one, other, frequency)
        row.rebound = meeting_table(tables, race, one, other, rigid=is_rigid(race))
        pair = touching_balls((one.orbit_radius, other.orbit_radius), (one.radius, other.radius))
        row.pace = 1.0 / pair.force
        _set_rubbing(race, one, pair, row, frequency)
    if is_rigid(race) and 2.0 * math.pi - rows.touch[members].sum() < FULL:
        rows.rigid[members] = 2


def _set_rubbing(race: Race, ball: Ball, pair: TouchingBalls, row: Any, frequency: float) -> None:
    row.out, row.out_next = pair.force * pair.outward[0], pair.force * pair.outward[1]
    if race.contact is not None and race.contact.friction > 0.0:
        wall = ball.orbit_radius + ball.radius
        slow = float(race.contact.slip_speed) if race.contact.slip_speed is not None else SLOW * wall * frequency
        row.rub, row.grip = float(race.contact.friction), 1.0 / (pair.force * slow)
        row.arm, row.arm_next = pair.force * pair.arms[0], pair.force * pair.arms[1]


def _set_walls(
    race: Race,
    balls: tuple[Ball, ...],
    members: list[int],
    angles: Floats,
    rows: Rows,
    frequency: float,
    tables: Tables,
) -> None:
    for i in members:
        # a wall is the mirror image of the ball, which overlaps it by twice the angle
        if is_rigid(race):
            rows[i].wall_rigid, rows[i].wall_left = 1, restitution(race)
        else:
            hard, soft, rows[i].wall_quick = _spring_and_damper(race, balls[i], balls[i], frequency)
            rows[i].wall_hard, rows[i].wall_soft = 2.0 * hard, 2.0 * soft
        rows[i].wall_rebound = meeting_table(tables, race, balls[i], rigid=is_rigid(race))
        half = 0.5 * occupied_angle([balls[i]])
        rows[i].wall_pace = balls[i].orbit_radius * math.cos(half)
        low, high = sector(race, balls[i], angles[i], half)
        rows[i].wall_low, rows[i].wall_high = low + half, high - half
        angles[i] = min(max(angles[i], low + half), high - half)


def _sector(race: Race, angle: float) -> int:
    """Between which partitions an angle lies; over a whole turn as many more."""
    assert race.partitions is not None
    return math.floor((angle - float(race.partitions.angle)) / (TURN / race.partitions.count))


def sector(race: Race, ball: Ball, angle: float, half: float) -> tuple[float, float]:
    """The angles of the partitions on both sides of a ball, which takes ``half`` an angle on each of its own.

    Raises
    ------
    MachineError
        If the ball does not fit between them, or was given a start angle at which it overlaps one.
    """
    assert race.partitions is not None
    count, first = race.partitions.count, float(race.partitions.angle)
    width = TURN / count
    if 2.0 * half > width:
        raise MachineError(
            f"balancers[{ball.balancer + 1}].races[{ball.race + 1}].partitions.count: given {count}; "
            f"{math.degrees(width):.4g} deg between partitions are less than the {math.degrees(2.0 * half):.4g} deg of a ball; "
            "take fewer partitions or a smaller ball"
        )
    part = _sector(race, angle)
    low, high = first + part * width, first + (part + 1) * width
    short = half - min(angle - low, high - angle)
    if ball.start_angle is not None and short > TOUCHING:
        raise MachineError(
            f"balancers[{ball.balancer + 1}].races[{ball.race + 1}].balls: one that starts at {math.degrees(angle):.4g} deg "
            f"overlaps the partition beside it; start it at least {math.degrees(half):.4g} deg from a partition"
        )
    return low, high
