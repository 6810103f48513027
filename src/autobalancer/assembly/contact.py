"""Contacts of balls: which meet, and what of them depends on the speed of an impact."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from autobalancer.arrays import Floats
from autobalancer.catalog.resolve import Ball, occupied_angle
from autobalancer.errors import MachineError
from autobalancer.kernels.laws.contact_law import DECADES, LEVELS, LOWEST, NONE, PER_DECADE, TURNS
from autobalancer.kernels.records import CONTACT, TIE
from autobalancer.kernels.system import Rigid, Rows
from autobalancer.laws.impacts import (
    LEAST,
    TouchingBalls,
    damping_ratio,
    slowest_rebound,
    touching_balls,
    wet_factor,
    yielding_factor,
)
from autobalancer.machine import Machine, Race
from autobalancer.machine.rebound import Rebound

# Tables from which contacts take what depends on the speed of an impact, see kernels/laws/contact_law.py.
#
# With a spring and a damper of ratio z, v' = -q - 2 z v and q' = v in a time of its own, with Hertz and the damper of
# Tsuji et al. (1992) too (Antypov and Elliott 2011). With A^2 = v^2 + 2 z q v + q^2 and the phase s, tan(w s) = w q/(v
# + z q), w^2 = 1 - z^2, the impact began at the speed A e^(z s). Where the damper would pull, the bodies have parted
# with e times it.
#
# With the law of Pakuła (2021), (15), energy says it: the impact began at sqrt(v^2 + q^2) while the bodies approach,
# and at sqrt(v^2/e^2 + q^2) while they part.


SPEEDS = np.logspace(LOWEST - 1.0, LOWEST + DECADES + 3.0, 2401)  # of impacts: beyond the table, as some of it is lost
LEVEL = LOWEST + np.arange(LEVELS) / PER_DECADE  # log10 of a speed
REBOUND_TURN = np.linspace(0.0, math.pi, TURNS)
Law = tuple[Rebound, float, float]  # restitution of slow impacts, and the speed below which a fluid leaves none (m/s)


def restitution_at(law: Law, speeds: Floats, least_left: float = LEAST) -> Floats:
    """Restitution of impacts at these speeds (m/s), ``least_left`` where it is less: 0.01 of contacts that are not rigid."""
    rebound, slow, least = law
    factor = np.ones_like(speeds)
    if rebound.yield_speed is not None:
        factor = yielding_factor(speeds, float(rebound.yield_speed), float(rebound.exponent))
    elif rebound.speeds:
        factor = np.interp(speeds, rebound.speeds, rebound.factors)
    if least > 0.0:
        factor = factor * wet_factor(speeds, least)
    return np.maximum(slow * factor, least_left)


def least_rebound(rebound: Rebound | None, ball: Ball, other: Ball | None = None) -> float:
    """The speed below which a ball does not rebound from another, or from a wall, m/s; 0 without a fluid."""
    if rebound is None or rebound.critical_stokes is None:
        return 0.0
    mass, radius = ball.mass, ball.radius
    if other is not None:
        mass, radius = 1.0 / (1.0 / mass + 1.0 / other.mass), 1.0 / (1.0 / radius + 1.0 / other.radius)
    return slowest_rebound(float(rebound.critical_stokes), mass, radius, ball.fluid_density * ball.fluid_viscosity)


class Tables:
    """The tables of a machine one behind the other; equal contacts share one.

    ``kind`` is ``dampers``, ``shares`` or, of rigid contacts, ``law_numbers``.
    """

    def __init__(self, kind: Callable[[Law], Floats]) -> None:
        self._kind = kind
        self._first: dict[tuple[Callable[[Law], Floats], Law], int] = {}
        self._tables: list[Floats] = []

    def first(
        self, rebound: Rebound | None, slow: float, least: float, kind: Callable[[Law], Floats] | None = None
    ) -> int:
        """Where the table of a contact begins, NONE without one; restitution of slow impacts and speed without any (m/s).

        It may be of another ``kind``.
        """
        if rebound is None:
            return NONE
        kind = kind or self._kind
        law = (rebound, slow, float(f"{least:.9g}"))  # the same for equal balls, however it was rounded
        if (kind, law) not in self._first:
            self._first[kind, law] = sum(table.size for table in self._tables)
            self._tables.append(kind(law))
        return self._first[kind, law]

    @property
    def numbers(self) -> Floats:
        """All tables."""
        return np.concatenate([*self._tables, np.zeros(0)])


@lru_cache(maxsize=64)
def dampers(law: Law) -> Floats:
    """Damping ratios, (SIZE,)."""
    left = restitution_at(law, SPEEDS)
    ratio = np.interp(left, *_known())[:, None]
    kept = np.empty((SPEEDS.size, TURNS))
    q, v = np.sin(REBOUND_TURN), np.cos(REBOUND_TURN)
    ahead = v + ratio * q
    width = np.sqrt(np.abs(1.0 - ratio**2))
    with np.errstate(invalid="ignore", divide="ignore"):
        under = np.arctan2(width * q, ahead) / width
        over = np.arctanh(width * q / ahead) / width
        phase = np.where(ratio < 1.0, under, over)
        kept = np.exp(-ratio * phase) / np.sqrt(1.0 + 2.0 * ratio * q * v)
        parted = np.where(v < 0.0, left[:, None] / np.abs(v), np.inf)
    # a path ends where the force does
    kept = np.where(q + 2.0 * ratio * v < 0.0, parted, kept)
    kept[:, -1] = left
    return _over_the_plane(kept, ratio[:, 0])


@lru_cache(maxsize=64)
def shares(law: Law) -> Floats:
    """Restitution squared, (SIZE,)."""
    left = restitution_at(law, SPEEDS)[:, None]
    loss = np.where(np.cos(REBOUND_TURN) < 0.0, 1.0 / left**2, 1.0)
    return _over_the_plane(1.0 / np.sqrt(np.sin(REBOUND_TURN) ** 2 + np.cos(REBOUND_TURN) ** 2 * loss), left[:, 0] ** 2)


def law_numbers(law: Law) -> Floats:
    """The law by its numbers, as kernels/laws/contact_law.py evaluates it."""
    rebound, slow, least = law
    yields = rebound.yield_speed is not None
    head = slow, least, rebound.yield_speed if yields else math.inf, rebound.exponent, len(rebound.speeds)
    return np.array([*head, *np.ravel(np.column_stack([rebound.speeds, rebound.factors]))], np.float64)


def _over_the_plane(kept: Floats, values: Floats) -> Floats:
    """``values`` of impacts over angle and distance; ``kept`` is the distance over the speed at which they began."""
    reached = np.log10(SPEEDS)[:, None] + np.log10(kept)
    table = np.stack([np.interp(LEVEL, np.maximum.accumulate(reached[:, i]), values) for i in range(TURNS)])
    table.setflags(write=False)
    return np.asarray(table.ravel())


@lru_cache(maxsize=1)
def _known() -> tuple[Floats, Floats]:
    """Damping ratios over what they leave, ascending."""
    left = np.concatenate([np.geomspace(LEAST, 0.5, 200), np.linspace(0.5, 1.0, 400)[1:]])
    return left, np.array([damping_ratio(float(e)) for e in left])


# Which balls can meet, and the springs and dampers between them.


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
    ring = []
    for number, i in enumerate(order):
        j = order[(number + 1) % len(order)]
        ahead = place[j] - place[i] + (TURN if number + 1 == len(order) else 0.0)
        ring.append((i, j, ahead - (angles[j] - angles[i])))
    return ring


def set_contacts(machine: Machine, balls: tuple[Ball, ...], angles: Floats, rows: Rows, frequency: float) -> Contacts:
    """Fill the rows of contacts; ``frequency`` is the greatest of the machine, rad/s.

    The start angles of balls that were not given and overlap a partition are moved to its side.
    """
    rows[:] = contact_rows(len(balls))
    angles, tables = np.array(angles, np.float64), Tables(dampers)
    for b, balancer in enumerate(machine.balancers):
        for number, race in enumerate(balancer.races):
            members = [i for i, ball in enumerate(balls) if (ball.balancer, ball.race) == (b, number)]
            solid = race.collisions and all(balls[i].diameter > 0.0 for i in members)
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


def meeting_table(tables: Tables, race: Race, ball: Ball, other: Ball | None = None, *, rigid: bool = False) -> int:
    """Where the table of a ball that meets another one, or a partition, begins."""
    rebound = race.contact.rebound if race.contact is not None else None
    kind = law_numbers if rigid else None
    return tables.first(rebound, restitution(race), least_rebound(rebound, ball, other), kind)


def parallel(one: float, other: float) -> float:
    """Reduced mass, inertia or radius of two."""
    return one * (other / (one + other))


def _spring_and_damper(race: Race, ball: Ball, other: Ball, frequency: float) -> tuple[float, float, float]:
    """Torque over the angle by which two balls overlap, N m/rad, and over the rate of this angle, N m s/rad; frequency, rad/s.

    The torque is the same on both, so their distance moves with the reduced inertia, and neither is the first. The damping is
    that of ratio 1 where the ratio depends on the impact.
    """
    inertia = parallel(ball.inertia, other.inertia)
    if race.contact is not None and race.contact.stiffness is not None:
        stiffness = float(race.contact.stiffness) * (ball.orbit_radius * other.orbit_radius)
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


# Room for rigid contacts of guided balls.


PULL = 1e-13  # torque that counts as a pull, over inertia and frequency squared


def pull_of(balls: tuple[Ball, ...], frequency: float) -> float:
    """Torque that counts as a pull, N m."""
    return PULL * max(ball.inertia for ball in balls) * frequency**2


def rigid_room(balls: tuple[Ball, ...], contacts: Rows, size: int, frequency: float) -> dict[str, Any]:
    """The fields of a system with rigid contacts, nothing without; its states have ``size`` components.

    ``frequency`` is that of what the balls do: the top speed, or the lowest critical one if that is higher, rad/s.
    """
    count = int((contacts.rigid == 1).sum() + 2 * (contacts.wall_rigid > 0).sum())
    if not (contacts.rigid.any() or contacts.wall_rigid.any()):
        return {}
    ties = TIE.rows(len(balls))
    full = np.flatnonzero(contacts.rigid == 2)
    ties.joined[full] = 1
    for race in {(balls[i].balancer, balls[i].race) for i in full}:  # a ring is a row whose last contact closes it
        members = [i for i in full if (balls[i].balancer, balls[i].race) == race]
        ties.joined[members[-1]] = 2
    pull = pull_of(balls, frequency)
    room = Rigid(
        bound=np.zeros(2, np.int64),
        margin=np.array([1e300, 1e300, pull, pull, -1.0]),
        kinds=np.zeros(count, np.int64),
        balls=np.zeros(count, np.int64),
        chosen=np.zeros(count, np.int64),
        active=np.zeros(count, np.int64),
        before=np.zeros(count),
        need=np.zeros(count),
        impulse=np.zeros(count),
        delassus=np.zeros((count, count)),
        left=np.zeros((count, count + 1)),
        response=np.zeros((count, size)),
        base=np.zeros(size),
        middle=np.zeros(size),
        missed=np.zeros(size),
    )
    return {"ties": ties, "rigid": room}
