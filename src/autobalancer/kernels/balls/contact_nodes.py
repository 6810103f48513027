"""What is kept of a ball at all nodes of a long step, in ``numbers`` after the room of the rotor and its stations.

Its row solved for phi'' (push, twist and four leans, for x, y, u and v); its own row in the same order; its inertia; on real
races the length of its path per angle, and its normal force (push, twist, x, y).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from autobalancer.kernels.balls.guided import Row, left_over
from autobalancer.kernels.balls.planar_nodes import EACH, SOLVED, load_row
from autobalancer.kernels.balls.rigid_torques import FAR, LEAST, PULL, leads
from autobalancer.kernels.compiler.flags import ADDRESSED, MERGED, njit
from autobalancer.kernels.compiler.numba_struct import data, deref
from autobalancer.kernels.compiler.simd import NODES, all_lanes, amount, greater, greatest, load, store
from autobalancer.kernels.host.linear import Motion
from autobalancer.kernels.host.linear_nodes import KEPT, PARTS, ROOM
from autobalancer.kernels.integrators.collocation import SWITCHES, amplitudes_at, follow, set_rate
from autobalancer.kernels.records import PRESCRIBED
from autobalancer.kernels.system import BALLS, System, system_at

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
def push_left(first: int, count: int, b: int, p: Any, a: Any) -> Any:
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


# Guided balls in rigid contact at all nodes of a long step: kernels/balls/rigid_torques.py without friction between
# balls.
#
# Balls that touch have one acceleration, so their rows are summed; beside a partition it is zero. The torques of
# contacts follow ball by ball, and :func:`least_torque` says whether they all press.


@njit(**MERGED)
def simple(p: System) -> bool:
    """Whether no ball rubs on another one or on its race, and no race is full."""
    for k in range(p.ball_count):
        if p.guided[k].bound != 0:
            ball, pair = p.balls[k], p.contacts[k]
            if pair.rub > 0.0 or ball.rolling > 0.0 or ball.adherence > 0.0 or pair.rigid == 2:
                return False
    return True


@njit(**MERGED)
def bind_at_nodes(motion: Motion, p: Any, a: Any) -> tuple[Any, Any]:
    """Put all clusters into their stations; returns their torque and inertia there."""
    kept, each = data(a.numbers), p.work.inert.shape[1]
    push, arm, turn, inert = station_places(p)
    torque, inertia = all_lanes(0.0), all_lanes(0.0)
    for head in range(p.ball_count):
        if leads(p, head):
            own, total = _row(head, p, a), load(kept, kept_at(head, p) + WEIGHT * NODES)
            # balls that touch have one acceleration: their rows are summed
            held, k, more = p.ties[head].low != 0, head, True
            while more:
                held = held or p.ties[k].high != 0
                more = p.ties[k].joined == 1
                if more:
                    k = p.contacts[k].next
                    its = _row(k, p, a)
                    own = Row(
                        own.push + its.push, own.spin + its.spin,
                        own.x + its.x, own.y + its.y, own.u + its.u, own.v + its.v,
                    )  # fmt: skip
                    total += load(kept, kept_at(k, p) + WEIGHT * NODES)
            # beside a partition they do not move
            inverse = 1.0 / total
            if held:
                inverse = all_lanes(0.0)
            found_push = (own.push - own.spin * motion.acceleration) * inverse
            found_spin = own.spin * inverse
            # each ball of the cluster keeps the row of all, and relaxes at its rate
            k, more = head, True
            while more:
                place = kept_at(k, p)
                store(found_push, kept, place)
                store(found_spin, kept, place + NODES)
                follow(1 + k, 1 + head, a)
                if held:
                    set_rate(1 + k, 0.0, a)
                for i in range(4):
                    store(lean(own, i) * inverse, kept, place + (2 + i) * NODES)
                more = p.ties[k].joined == 1
                k = p.contacts[k].next
            # what the cluster does to its station, as one ball would
            at = p.balls[head].station * each
            for i in range(each):
                add(-lean(own, i) * found_push, kept, push + (at + i) * NODES)
                if p.drive.kind != PRESCRIBED:
                    add(-lean(own, i) * found_spin, kept, arm + (at + i) * NODES)
                    add(-lean(own, i) * found_spin, kept, turn + (at + i) * NODES)
                for j in range(each):
                    taken = lean(own, i) * lean(own, j) * inverse
                    add(-taken, kept, inert + ((at + i) * each + j) * NODES)
            torque -= own.spin * found_push
            inertia -= own.spin * found_spin
    return torque, inertia


@njit(**MERGED)
def _row(k: int, p: Any, a: Any) -> Row:
    """The own row of ball k."""
    kept, place = data(a.numbers), kept_at(k, p) + OWN * NODES
    return Row(
        load(kept, place), load(kept, place + NODES), load(kept, place + 2 * NODES), load(kept, place + 3 * NODES),
        load(kept, place + 4 * NODES), load(kept, place + 5 * NODES),
    )  # fmt: skip


@njit(**MERGED)
def rest_at_nodes(k: int, p: Any, a: Any) -> Any:
    """What the contacts must add to ball k, negative: its row less its inertia times its acceleration."""
    weight = load(data(a.numbers), kept_at(k, p) + WEIGHT * NODES)
    acceleration = load(data(a.forces), 2 * a.modes * NODES)
    return push_left(OWN, p.work.inert.shape[1], k, p, a) - weight * rate_of_rows(k, acceleration, p, a)


@njit(**MERGED)
def _lesser(one: Any, least: Any) -> Any:
    """The lesser of two, lane by lane."""
    return -greater(-one, -least)


@njit(**MERGED)
def least_torque(rest: Callable[[int, Any, Any], Any], p: Any, a: Any) -> float:
    """The least torque of all contacts that are closed and can open, at the nodes; FAR without any.

    ``rest`` is :func:`rest_at_nodes` or the same of other equations.
    """
    least = all_lanes(FAR)
    for head in range(p.ball_count):
        if leads(p, head):
            # the ends of the row: what a partition holds there
            low, last, more = p.ties[head].low != 0, head, True
            while more:
                more = p.ties[last].joined == 1
                if more:
                    last = p.contacts[last].next
            high = p.ties[last].high != 0
            if low and high:
                continue  # a row without play stays as it is
            # from the free end on, each contact carries what the balls beyond it lack
            carried = all_lanes(0.0)
            if low:
                k = last
                while k != head:
                    carried -= rest(k, p, a)
                    least = _lesser(carried, least)
                    k = p.contacts[k].before
                least = _lesser(carried - rest(head, p, a), least)
            else:
                k = head
                while k != last:
                    carried += rest(k, p, a)
                    least = _lesser(carried, least)
                    k = p.contacts[k].next
                if high:
                    least = _lesser(carried + rest(last, p, a), least)
    return -greatest(-least)


# How far a long step goes before a gap closes, and whether it may close at all.


DIP = 0.005  # of the step squared times the relative acceleration: how far a gap can dip between two nodes, 0.2^2 / 8


@njit(**MERGED)
def open_until(start: float, gap: Any, bend: Any, step: float, a: Any) -> float:
    """The fraction of the step up to which a gap stays open, 1 if it does; 0 where it is closed at the begin."""
    nodes, work = data(a.radau.nodes), data(a.work)
    dip = DIP * step * step * greatest(amount(bend))
    if not start > dip:
        return 0.0
    store(gap, work, 0)
    for i in range(NODES):
        if not work[i] > dip:
            return nodes[i - 1] if i > 0 else 0.0
    return 1.0


@njit(**MERGED)
def may_close(gap: Any, bend: Any, step: float) -> bool:
    """Whether a gap may close in the step, at a node or between two."""
    return greatest(-gap) > -DIP * step * step * greatest(amount(bend))


# How far a long step goes before a soft contact closes, and whether a rigid one closes or opens in it.
#
# Soft contacts are open all the time. Where a rigid one may change, the switch of the equations finds the instant
# inside the step.


@njit(**MERGED)
def _gaps(step: float, p: Any, a: Any) -> tuple[float, bool]:
    """The fraction of the step up to which all soft contacts stay open, and whether a rigid one may close."""
    values, forces, start = data(a.values), data(a.forces), data(a.origin)
    angles, own, until, closing = 2 * a.modes + 2, 2 * a.modes + 1, 1.0, False
    for i in range(a.balls):
        # only contacts that are there and open now
        pair = p.contacts[i]
        soft, rigid = pair.hard > 0.0, pair.rigid > 0 and p.ties[i].joined == 0
        soft_wall, rigid_wall = pair.wall_hard > 0.0, pair.wall_rigid > 0
        if not (soft or rigid or soft_wall or rigid_wall):
            continue
        angle, bend, now = load(values, (angles + i) * NODES), load(forces, (own + i) * NODES), start[BALLS + i]
        # to the next ball: its gap at the nodes, and the relative acceleration that may bend it between two
        if soft or rigid:
            other = pair.next
            ahead = pair.wrap - pair.touch
            gap = load(values, (angles + other) * NODES) - angle + ahead
            turned = load(forces, (own + other) * NODES) - bend
            if soft:
                until = min(until, open_until(start[BALLS + other] - now + ahead, gap, turned, step, a))
            else:
                closing = closing or may_close(gap, turned, step)
        # to the partitions on both sides
        if soft_wall:
            until = min(until, open_until(now - pair.wall_low, angle - pair.wall_low, bend, step, a))
            until = min(until, open_until(pair.wall_high - now, pair.wall_high - angle, bend, step, a))
        elif rigid_wall:
            closing = closing or (p.ties[i].low == 0 and may_close(angle - pair.wall_low, bend, step))
            closing = closing or (p.ties[i].high == 0 and may_close(pair.wall_high - angle, bend, step))
    return until, closing


@njit(**MERGED)
def contacts_until(rest: Callable[[int, Any, Any], Any], step: float, p: Any, a: Any) -> float:
    """The fraction of the step up to which all soft contacts stay open; SWITCHES if a rigid one may close or open.

    0 where balls that touch rub or fill their race: their torques take more than the balls' own rows, see ``rest`` of
    :func:`autobalancer.kernels.balls.contact_nodes.least_torque`.
    """
    if p.rigid.bound[0] > 0 and not simple(p):
        return 0.0
    until, closing = _gaps(step, p, a)
    if p.rigid.bound[0] > 0:
        p.rigid.margin[LEAST] = least_torque(rest, p, a)
        closing = closing or not p.rigid.margin[LEAST] >= -2.0 * p.rigid.margin[PULL]
    return SWITCHES if closing and until == 1.0 else until


@njit(**ADDRESSED)
def contacts_at_nodes(step: float, system: Any, amplitudes: Any) -> float:
    """:func:`contacts_until` of balls at the stations of a linear rotor."""
    p, a = deref(system_at(system)), deref(amplitudes_at(amplitudes))
    return float(contacts_until(rest_at_nodes, step, p, a))


# How far balls on a planar rotor go in a long step before a contact changes.


@njit(**MERGED)
def _rest(k: int, p: Any, a: Any) -> Any:
    """What the contacts must add to ball k, negative: its row less its inertia times its acceleration."""
    work, acceleration = data(a.balls_work), load(data(a.forces), 2 * a.modes * NODES)
    ax, ay = load(work, EACH * a.balls), load(work, EACH * a.balls + NODES)
    free = left_over(load_row(work, EACH * k), ax, ay, acceleration)
    rate = left_over(load_row(work, EACH * k + SOLVED), ax, ay, acceleration)
    return free - rate * p.balls[k].inertia


@njit(**ADDRESSED)
def contacts_in_steps(step: float, system: Any, amplitudes: Any) -> float:
    """:func:`contacts_until` of balls on a planar rotor."""
    p, a = deref(system_at(system)), deref(amplitudes_at(amplitudes))
    return float(contacts_until(_rest, step, p, a))
