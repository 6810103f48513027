"""What is kept of a ball at all nodes of a long step, in ``numbers`` after the room of the rotor and its stations.

Its row solved for phi'' (push, twist and four leans, for x, y, u and v); its own row in the same order; its inertia; on real
races the length of its path per angle, and its normal force (push, twist, x, y).
"""

from __future__ import annotations

from typing import Any

from autobalancer.kernels.balls.guided import Row
from autobalancer.kernels.flags import MERGED, njit
from autobalancer.kernels.host.linear_nodes import KEPT, PARTS, ROOM
from autobalancer.kernels.pointers import data
from autobalancer.kernels.records.drive import PRESCRIBED
from autobalancer.kernels.wide import NODES, all_lanes, load, store

OWN, WEIGHT, LENGTH, NORMAL = 6, 12, 13, 14


@njit(**MERGED)
def add(value: Any, numbers: Any, place: int) -> None:
    """Add to a row of lanes."""
    store(load(numbers, place) + value, numbers, place)


@njit(**MERGED)
def station_places(p: Any) -> tuple[int, int, int, int]:
    """Where push, arm, turn and inertia of the stations are."""
    push, rows = ROOM + PARTS * NODES * p.host.size, NODES * p.host.rows.shape[0]
    return push, push + rows, push + 2 * rows, push + 3 * rows


@njit(**MERGED)
def accelerations_at(p: Any) -> int:
    """Where the accelerations of the stations are."""
    rows, each = p.host.rows.shape[0], p.work.inert.shape[1]
    return ROOM + NODES * (PARTS * p.host.size + rows * (3 + each))


@njit(**MERGED)
def kept_at(b: int, p: Any) -> int:
    """Where the rows of a ball are."""
    rows, each = p.host.rows.shape[0], p.work.inert.shape[1]
    return ROOM + NODES * (PARTS * p.host.size + rows * (5 + each + rows) + KEPT * b)


@njit(**MERGED)
def lean(its: Row, i: int) -> Any:
    """That for x, y, u or v, in lanes; rows of races that do not tilt have plain zeros."""
    if i == 0:
        return its.x
    if i == 1:
        return its.y
    return all_lanes(0.0) + (its.u if i == 2 else its.v)


@njit(**MERGED)
def keep(its: Row, first: int, each: int, b: int, p: Any, a: Any) -> None:
    """Keep a row of a ball from this row on."""
    kept, place = data(a.numbers), kept_at(b, p) + first * NODES
    store(its.push, kept, place)
    store(its.spin, kept, place + NODES)
    for i in range(each):
        store(lean(its, i), kept, place + (2 + i) * NODES)


@njit(**MERGED)
def left(first: int, count: int, b: int, p: Any, a: Any) -> Any:
    """Push of a row that is kept, less what the accelerations of rotor and station take from it."""
    kept, place = data(a.numbers), kept_at(b, p) + first * NODES
    at = accelerations_at(p) + p.work.inert.shape[1] * p.balls[b].station * NODES
    taken = load(kept, place + NODES) * load(data(a.forces), 2 * a.modes * NODES)
    for i in range(count):
        taken += load(kept, place + (2 + i) * NODES) * load(kept, at + i * NODES)
    return load(kept, place) - taken


@njit(**MERGED)
def rate_of_rows(b: int, acceleration: Any, p: Any, a: Any) -> Any:
    """The acceleration of a ball from its row solved for it, and those of the rotor and its station."""
    kept, place, each = data(a.numbers), kept_at(b, p), p.work.inert.shape[1]
    at, rate = accelerations_at(p) + p.balls[b].station * each * NODES, load(kept, place)
    if p.drive.kind != PRESCRIBED:
        rate -= load(kept, place + NODES) * acceleration
    for i in range(each):
        rate -= load(kept, place + (2 + i) * NODES) * load(kept, at + i * NODES)
    return rate
