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

from autobalancer.stability.continuation.vector_field import Field
from autobalancer.stability.host.planar import Floats, Plane
from autobalancer.stability.states.planar import close_polygon

Groups: TypeAlias = tuple[tuple[int, ...], ...]
TOGETHER = 1e-7  # rad: nearer balls count as coincident


def kinds(planes: list[Plane]) -> list[tuple[float, ...]]:
    """For each ball what it shares with its equals, in all of these planes."""
    rows = [np.stack([p.race, p.ball_mass, p.moment, p.inertia, p.drag, p.offset.real, p.offset.imag]) for p in planes]
    return [tuple(column) for column in np.concatenate(rows).T.tolist()] if planes[0].moment.size else []


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


def merged(p: Plane, groups: Groups) -> Plane:
    """The plane in which every group is one ball."""
    if len(groups) == p.moment.size:
        return p
    first = [group[0] for group in groups]

    def total(values: Floats) -> Floats:
        return np.array([values[list(group)].sum() for group in groups])

    return replace(
        p,
        race=p.race[first],
        offset=p.offset[first],
        ball_mass=total(p.ball_mass),
        moment=total(p.moment),
        inertia=total(p.inertia),
        drag=total(p.drag),
    )


def expanded(states: Floats, groups: Groups) -> Floats:
    """States of the merged plane as states of all balls, angle and speed of each ball; last axis 4 + 2 n."""
    place = _places(groups)
    count = len(groups)
    return np.concatenate([states[..., :4], states[..., 4 + place], states[..., 4 + count + place]], -1)


def gathered(state: Floats, groups: Groups) -> Floats:
    """The state of the merged plane for a state of all balls."""
    n = (state.size - 4) // 2
    first = np.array([group[0] for group in groups], np.int64)
    return np.concatenate([state[:4], state[4 + first], state[4 + n + first]])


def restoring(field: Field, state: Floats) -> Floats:
    """r of every ball, over I w^2: falls below zero where balls at this place no longer stay together."""
    p, n = field.plane, field.balls
    c, s = np.cos(state[4 : 4 + n]), np.sin(state[4 : 4 + n])
    rate = field(state)
    ax, ay = rate[2] - field.speed * state[3], rate[3] + field.speed * state[2]
    along = p.offset.real * c + p.offset.imag * s
    return np.asarray(p.moment * (field.speed**2 * along - c * ax - s * ay) / (p.inertia * field.speed**2))


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


def in_two_bundles(p: Plane, state: Floats, kind: list[tuple[float, ...]]) -> Floats | None:
    """The balanced state with the same resultant in which equal balls stand in two bundles, as even as possible.

    In the merged balls it is no continuum any more. ``None`` if the balls are not all equal or no two bundles close.
    """
    count = p.moment.size
    if len(set(kind)) != 1:
        return None
    target = complex((p.moment * np.exp(1j * state[4 : 4 + count])).sum())
    for part in range(count // 2, 0, -1):
        for pair in close_polygon(p.moment[0] * np.array([float(count - part), float(part)]), target)[:1]:
            new = np.array(state)
            new[4 : 4 + count] = np.repeat(pair, [count - part, part])
            return new
    return None


def signature(p: Plane, state: Floats) -> Floats:
    """Numbers that no exchange of equal balls alters, nor for a rotor at rest the mirror image of the ball angles."""
    n = p.moment.size
    heavy = p.unbalance / abs(p.unbalance) if p.unbalance else 1.0
    angle = state[4 : 4 + n] - np.angle(heavy)
    total = p.moment.sum() or 1.0
    whirl = complex(state[0], state[1]) * np.conj(heavy) * p.mass / (abs(p.unbalance) + total)
    sums = [complex((p.moment * np.exp(1j * k * angle)).sum()) / total for k in (1, 2, 3)]
    return np.array([whirl.real, abs(whirl.imag), *(s.real for s in sums), *(abs(s.imag) for s in sums)])


def _places(groups: Groups) -> np.ndarray:
    place = np.zeros(sum(len(group) for group in groups), np.int64)
    for number, group in enumerate(groups):
        place[list(group)] = number
    return place
