"""Rigid contacts by number: which are closed, how wide the others are, and which balls they hold together.

A contact is known by its kind (records/impacts.py: NEXT, BEHIND, AHEAD) and its ball. All functions take a state ``y``.
"""

from __future__ import annotations

from typing import Any

from autobalancer.kernels.flags import APART, INLINE, njit
from autobalancer.kernels.pointers import behind, data
from autobalancer.kernels.records.impacts import AHEAD, BEHIND, NEXT
from autobalancer.kernels.system import BALLS, System, system_at

THIN, DIGITS = 1e-12, 1e-14  # rad, and over the angle: a gap that is none


@njit(**INLINE)
def exists(p: System, kind: int, k: int) -> bool:
    """Whether this contact is rigid and can open."""
    return bool(p.contacts[k].rigid == 1 if kind == NEXT else p.contacts[k].wall_rigid != 0)


@njit(**INLINE)
def is_closed(p: System, kind: int, k: int) -> bool:
    its = p.ties[k]
    return bool((its.joined if kind == NEXT else its.low if kind == BEHIND else its.high) != 0)


@njit(**INLINE)
def close(p: System, kind: int, k: int, closed: int) -> None:
    """Close or open a contact; :func:`count_bound` follows."""
    its = p.ties[k]
    if kind == NEXT:
        its.joined = closed
    elif kind == BEHIND:
        its.low = closed
    else:
        its.high = closed


@njit(**INLINE)
def torque_of(p: System, kind: int, k: int) -> float:
    """Torque that presses, as found by the last evaluation."""
    its = p.ties[k]
    return float(its.press if kind == NEXT else its.press_low if kind == BEHIND else its.press_high)


@njit(**INLINE)
def gap(y: Any, p: System, kind: int, k: int) -> float:
    """Angle that is left before the contact closes."""
    pair, angle = p.contacts[k], y[BALLS + k]
    if kind == NEXT:
        return float(y[BALLS + pair.next] - angle + pair.wrap - pair.touch)
    return float(angle - pair.wall_low if kind == BEHIND else pair.wall_high - angle)


@njit(**INLINE)
def opening(y: Any, p: System, kind: int, k: int) -> float:
    """Rate of the gap; of the rates of a state its acceleration."""
    at = BALLS + p.ball_count
    if kind == NEXT:
        return float(y[at + p.contacts[k].next] - y[at + k])
    return float(y[at + k] if kind == BEHIND else -y[at + k])


@njit(**INLINE)
def thin(y: Any, k: int) -> float:
    """What counts as no gap at ball k."""
    return THIN + DIGITS * abs(y[BALLS + k])


@njit(**APART)
def count_bound(system: Any) -> None:
    """Find out which balls contacts hold, after contacts were closed or opened."""
    p = behind(system_at(system))
    number = 0
    for k in range(p.ball_count):
        p.ties[k].follows = 0
    for k in range(p.ball_count):
        if p.ties[k].joined == 1:
            p.ties[p.contacts[k].next].follows = 1
    for k in range(p.ball_count):
        its = p.ties[k]
        p.guided[k].bound = 1 if its.joined + its.follows + its.low + its.high > 0 else 0
        number += p.guided[k].bound
    p.rigid.bound[0] = number


@njit(**APART)
def collect(y: Any, system: Any, width: float) -> int:
    """List the contacts that are closed or have a gap below ``width`` (rad) and their openings; returns how many."""
    p = behind(system_at(system))
    found, r = 0, p.rigid
    for k in range(p.ball_count):
        for kind in (NEXT, BEHIND, AHEAD):
            if exists(p, kind, k) and (is_closed(p, kind, k) or gap(y, p, kind, k) < max(width, thin(y, k))):
                r.kinds[found], r.balls[found], r.chosen[found] = kind, k, 0
                r.before[found] = opening(y, p, kind, k)
                found += 1
    return found


@njit(**APART)
def equalize(y: Any, system: Any) -> None:
    """Give all balls of a cluster one speed, which differs by rounding, and close the gaps between them."""
    p = behind(system_at(system))
    at = BALLS + p.ball_count
    for head in range(p.ball_count):
        if p.guided[head].bound == 0 or p.ties[head].follows != 0:
            continue
        total, momentum, wall = 0.0, 0.0, p.ties[head].low != 0
        k, more = head, True
        while more:
            its = p.ties[k]
            total += p.balls[k].inertia
            momentum += p.balls[k].inertia * y[at + k]
            more, wall = its.joined == 1, wall or its.high != 0
            k = p.contacts[k].next
        k, more = head, True
        while more:
            y[at + k] = 0.0 if wall else momentum / total
            more = p.ties[k].joined == 1
            k = p.contacts[k].next
    for k in range(p.ball_count):
        its = p.ties[k]
        if its.joined == 1:
            half = 0.5 * gap(y, p, NEXT, k)
            if abs(half) < 1e-9:
                y[BALLS + k] += half
                y[BALLS + p.contacts[k].next] -= half


@njit(**INLINE)
def free_of_contacts(system: Any) -> None:
    """Open all contacts that can open."""
    p = behind(system_at(system))
    for k in range(p.ball_count):
        its = p.ties[k]
        its.low, its.high = 0, 0
        its.joined = 0 if p.contacts[k].rigid < 2 else its.joined
    data(p.rigid.bound)[0] = 0
