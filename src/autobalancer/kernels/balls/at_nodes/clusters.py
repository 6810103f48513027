"""Guided balls in rigid contact at all nodes of a long step: kernels/balls/rigid/clusters.py without friction between balls.

Balls that touch have one acceleration, so their rows are summed; beside a partition it is zero. The torques of contacts follow
ball by ball, and :func:`least_torque` says whether they all press.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from autobalancer.kernels.balls.at_nodes.rows import OWN, WEIGHT, add, kept_at, lean, left, rate_of_rows, station_places
from autobalancer.kernels.balls.guided import Row
from autobalancer.kernels.balls.rigid.clusters import leads
from autobalancer.kernels.balls.rigid.torques import FAR
from autobalancer.kernels.flags import MERGED, njit
from autobalancer.kernels.host.linear import Motion
from autobalancer.kernels.integrators.collocation.rates import follow, set_rate
from autobalancer.kernels.pointers import data
from autobalancer.kernels.records.drive import PRESCRIBED
from autobalancer.kernels.system import System
from autobalancer.kernels.wide import NODES, all_lanes, greater, greatest, load, store


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
            inverse = 1.0 / total
            if held:
                inverse = all_lanes(0.0)
            found_push = (own.push - own.spin * motion.acceleration) * inverse
            found_spin = own.spin * inverse
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
    return left(OWN, p.work.inert.shape[1], k, p, a) - weight * rate_of_rows(k, acceleration, p, a)


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
            low, last, more = p.ties[head].low != 0, head, True
            while more:
                more = p.ties[last].joined == 1
                if more:
                    last = p.contacts[last].next
            high = p.ties[last].high != 0
            if low and high:
                continue  # a row without play stays as it is
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
