"""Contacts whose impacts a run notes, and what an impact in each of them means."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from autobalancer.assembly.contact import is_rigid, least_rebound, parallel, restitution
from autobalancer.assembly.system import Assembly
from autobalancer.catalog.resolve import Ball
from autobalancer.kernels import records
from autobalancer.laws.impacts import LEAST, rebound
from autobalancer.machine import Machine, Race
from autobalancer.machine.rebound import Rebound

ROOM = 20_000  # impacts between two looks at them


@dataclass(frozen=True)
class Touch:
    """A contact: numbers of both balls from 0, the second -1 at a partition and -2 at a wall; reduced mass, kg."""

    kind: int
    one: int
    other: int
    mass: float
    restitution: float
    rebound: Rebound | None
    slowest: float  # m/s: no slower impact rebounds, because of the fluid
    least: float = LEAST  # restitution that counts for less; 0 of rigid contacts


def with_touches(machine: Machine, assembly: Assembly) -> tuple[Assembly, tuple[Touch, ...]]:
    """The assembly with room for the impacts of all contacts of its balls, and these contacts."""
    touches = touches_of(machine, assembly)
    if not touches:
        return assembly, ()
    rows = records.TOUCH.rows(len(touches))
    for row, touch in zip(rows, touches, strict=True):
        row.kind, row.one, row.other, row.known = touch.kind, touch.one, touch.other, -1
    room = {"touches": rows, "impacts": records.IMPACT.rows(ROOM), "impact_count": np.zeros(1, np.int64)}
    return replace(assembly, system=assembly.system._replace(**room)), touches


def touches_of(machine: Machine, assembly: Assembly) -> tuple[Touch, ...]:
    """All contacts of the balls of a machine."""
    return tuple(_resolved(machine, assembly) if assembly.resolved else _guided(machine, assembly))


def _guided(machine: Machine, assembly: Assembly) -> list[Touch]:
    touches = []
    for i, (ball, contact) in enumerate(zip(assembly.balls, assembly.system.contacts, strict=True)):
        race = _race(machine, ball)
        least = 0.0 if is_rigid(race) else LEAST
        if contact.hard > 0.0 or contact.rigid > 0:
            j = int(contact.next)
            other = assembly.balls[j]
            mass = parallel(ball.inertia, other.inertia) / contact.pace**2
            touches.append(Touch(records.NEXT, i, j, mass, *_meeting(race, ball, other), least=least))
        if contact.wall_hard > 0.0 or contact.wall_rigid > 0:
            mass = ball.inertia / contact.wall_pace**2
            touches += [
                Touch(kind, i, -1, mass, *_meeting(race, ball), least=least) for kind in (records.BEHIND, records.AHEAD)
            ]
    return touches


def _resolved(machine: Machine, assembly: Assembly) -> list[Touch]:
    touches = []
    for i, (ball, free) in enumerate(zip(assembly.balls, assembly.system.free_balls, strict=True)):
        race, mass = _race(machine, ball), float(free.mass + free.extra)
        law = race.resolved
        assert law is not None
        damped = free.wall_damping / (2.0 * math.sqrt(free.wall_stiffness * mass))  # with 'damping', of a linear spring
        told = float(law.restitution) if law.restitution is not None else rebound(damped)
        touches.append(Touch(records.WALL, i, -2, mass, told, law.rebound, least_rebound(law.rebound, ball)))
        if np.isfinite(free.gap):
            touches.append(replace(touches[-1], kind=records.INNER))
        if race.partitions is not None:
            touches.append(Touch(records.SIDES, i, -1, mass, *_meeting(race, ball)))
        for j in range(i + 1, len(assembly.balls)):
            other, its = assembly.balls[j], assembly.system.free_balls[j]
            if free.race >= 0 and free.race == its.race:
                reduced = parallel(mass, float(its.mass + its.extra))
                touches.append(Touch(records.OTHER_BALL, i, j, reduced, *_meeting(race, ball, other)))
    return touches


def _race(machine: Machine, ball: Ball) -> Race:
    return machine.balancers[ball.balancer].races[ball.race]


def _meeting(race: Race, ball: Ball, other: Ball | None = None) -> tuple[float, Rebound | None, float]:
    falls = race.contact.rebound if race.contact is not None else None
    return restitution(race), falls, least_rebound(falls, ball, other)
