"""Equal balls can be exchanged: balls that coincide move as one, and states that differ by an exchange are the same.

Balls that stand in one place stay there together, so a group of k coincident equal balls is one ball of k times the mass,
inertia and drag. In these reduced coordinates (the fixed-point space of the exchanges) a state that is singular only because
the group may fall apart is a regular one; the falling apart is a scalar equation, I d'' + beta d' + r d = 0, for each group.
Where r passes zero new states branch off in which the group has split in two (equivariant branching lemma: Golubitsky et al.
1988, XIII.3).
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from autobalancer.stability.host.cycle import Equations
from autobalancer.stability.host.planar import Floats
from autobalancer.stability.host.stations import Stations
from autobalancer.stability.host.vector_field import Field
from autobalancer.stability.states.planar import close_polygon

Groups: TypeAlias = tuple[tuple[int, ...], ...]
TOGETHER = 1e-7  # rad: nearer balls count as coincident


def kinds(hosts: list[Stations]) -> list[tuple[float, ...]]:
    """For each ball what it shares with its equals, in all of these hosts."""
    if hosts[0].forces is not None and hosts[0].forces.pairs:  # a ball that changes places gets other neighbors
        return [(float(ball),) for ball in range(hosts[0].moment.size)]
    rows = [np.stack([h.race, h.ball_mass, h.moment, h.inertia, h.drag, h.offset.real, h.offset.imag]) for h in hosts]
    return [tuple(column) for column in np.concatenate(rows).T.tolist()] if hosts[0].moment.size else []


def coincident(angles: Floats, kind: list[tuple[float, ...]]) -> Groups:
    """Equal balls at one place, by their first ball."""
    groups: list[list[int]] = []
    for ball in range(angles.size):
        for group in groups:
            first = group[0]
            if (
                kind[first] == kind[ball]
                and abs(math.remainder(angles[ball] - angles[first], 2.0 * math.pi)) < TOGETHER
            ):
                group.append(ball)
                break
        else:
            groups.append([ball])
    return tuple(tuple(group) for group in groups)


def merged(p: Stations, groups: Groups) -> Stations:
    """The stations at which every group is one ball."""
    if len(groups) == p.moment.size:
        return p
    first = [group[0] for group in groups]

    def total(values: Floats) -> Floats:
        return np.array([values[list(group)].sum() for group in groups])

    return replace(
        p,
        race=p.race[first],
        station=p.station[first],
        offset=p.offset[first],
        ball_mass=total(p.ball_mass),
        moment=total(p.moment),
        inertia=total(p.inertia),
        drag=total(p.drag),
        forces=None if p.forces is None else p.forces.merged(groups),
    )


def expanded(states: Floats, groups: Groups, rotor: int) -> Floats:
    """States of the merged balls as states of all balls, behind ``rotor`` components; last axis rotor + 2 n."""
    place = rotor + _places(groups)
    return np.concatenate([states[..., :rotor], states[..., place], states[..., len(groups) + place]], -1)


def gathered(states: Floats, groups: Groups, rotor: int) -> Floats:
    """States of the merged balls for states of all balls; the last axis counts components."""
    n = (states.shape[-1] - rotor) // 2
    first = rotor + np.array([group[0] for group in groups], np.int64)
    return np.concatenate([states[..., :rotor], states[..., first], states[..., n + first]], -1)


def restoring(equations: Equations, state: Floats) -> Floats:
    """r of every ball, over I w^2: falls below zero where balls at this place no longer stay together.

    Where it varies over half a turn, the constant one that does the same.
    """
    field, here = (equations, state) if isinstance(equations, Field) else (equations.field, equations.around(state))
    p, first = field.host, field.rotor
    half, turned = first // 2, np.zeros_like(here)
    turned[..., first : first + field.balls] = (
        1.0  # the torque on a ball depends on no other ball but through the rotor
    )
    matrices, right = field.series(here, turned, 1)
    whole = field.accelerations(here, field(here))
    torque = right[1][..., half:] - (matrices[1][..., half:, :half] @ whole[..., None])[..., 0]
    stiffness = np.asarray(-torque / (p.inertia * field.speed**2))
    if isinstance(equations, Field):
        return stiffness
    slowed = np.roll(turned, field.balls, -1)
    return equations.held(stiffness, -field.series(here, slowed, 1)[1][1][..., half:] / (p.inertia * field.speed))


def splittings(groups: Groups) -> list[tuple[Groups, Floats]]:
    """Ways in which one group falls apart in two: the new groups, and in which direction each of them moves at first."""
    found = []
    for number, group in enumerate(groups):
        for part in range(1, len(group) // 2 + 1):
            new = (*groups[:number], group[:part], group[part:], *groups[number + 1 :])
            way = np.zeros(len(new))
            way[number], way[number + 1] = (len(group) - part) / len(group), -part / len(group)
            found.append((new, way))
    return found


def meeting(groups: Groups, kind: list[tuple[float, ...]]) -> list[tuple[int, int]]:
    """Pairs of groups of equal balls: those that can come together."""
    count = len(groups)
    return [(a, b) for a in range(count) for b in range(a + 1, count) if kind[groups[a][0]] == kind[groups[b][0]]]


def joined(groups: Groups, pair: tuple[int, int]) -> Groups:
    """The groups after two of them have become one."""
    a, b = pair
    both = tuple(sorted(groups[a] + groups[b]))
    return (*groups[:a], both, *groups[a + 1 : b], *groups[b + 1 :])


def in_two_bundles(
    angles: Floats, p: Stations, kind: list[tuple[float, ...]], true: NDArray[np.bool_]
) -> Floats | None:
    """Ball angles with the same resultants in which the balls of each race that runs true stand in two bundles.

    The bundles are as even as possible. In the merged balls the state is no continuum any more. ``true``: whether the race
    of each ball runs true. ``None`` if the balls of such a station are not all equal, or no two bundles close.
    """
    new = np.array(angles)
    for station in sorted(set(p.station[true].tolist())):
        balls = np.flatnonzero(true & (p.station == station))
        count = balls.size
        if len({kind[ball] for ball in balls}) != 1:
            return None
        if count < 3:
            continue
        target, one = complex((p.moment[balls] * np.exp(1j * angles[balls])).sum()), p.moment[balls[0]]
        parts = range(count // 2, 0, -1)
        closed = [(part, close_polygon(one * np.array([float(count - part), float(part)]), target)) for part in parts]
        part, pairs = next(((part, pairs) for part, pairs in closed if pairs), (0, []))
        if not pairs:
            return None
        new[balls] = np.repeat(pairs[0], [count - part, part])
    return new


def signature(p: Stations, state: Floats) -> Floats:
    """Numbers that no exchange of equal balls alters, nor, of one station, the mirror image of a rotor at rest."""
    pairs, first, total = p.model.pairs, 4 * p.model.pairs, p.moment.sum() or 1.0
    loads = p.rows @ p.load
    found: list[float] = []
    for station, load in enumerate(loads):
        heavy = load / abs(load) if load else 1.0
        balls = np.flatnonzero(p.station == station)
        angle = state[first + balls] - np.angle(heavy)
        whirl = complex(p.rows[station] @ (state[:pairs] + 1j * state[pairs : 2 * pairs])) * np.conj(heavy)
        sums = [complex((p.moment[balls] * np.exp(1j * k * angle)).sum()) / total for k in (1, 2, 3)]
        numbers = [whirl * p.model.total_mass / (abs(p.unbalance) + total), *sums]
        found += [n.real for n in numbers] + [abs(n.imag) if loads.size == 1 else n.imag for n in numbers]
    return np.array(found)


def _places(groups: Groups) -> np.ndarray:
    place = np.zeros(sum(len(group) for group in groups), np.int64)
    for number, group in enumerate(groups):
        place[list(group)] = number
    return place
