"""Impacts of rigid contacts: Moreau's law on all closed contacts at once, on whatever rotor.

The rates of a machine are linear in the torque of a contact. So what an impulse does to the whole state follows from the
equations themselves: rates with a torque at one contact, less those without. With u the rates of the gaps, P the impulses and
G the accelerations of the gaps over the torques (Delassus' matrix), an impact gives (Moreau 1988)

    0 <= P  orthogonal to  u+ + e u- >= 0,    u+ = u- + G P.

With e = 0 and accelerations in place of u the same law tells which contacts at rest press. It is solved by pivoting (Júdice
and Pires 1994), and by projected Gauss-Seidel where rows without play leave G singular. Balls rub in an impact by the mean of
the slips before and after it, which takes energy at any friction.
"""

from __future__ import annotations

import math
from typing import Any

from autobalancer.kernels.balls.rigid.closed import close, count_bound, opening
from autobalancer.kernels.balls.rigid.clusters import link
from autobalancer.kernels.flags import APART, INLINE, njit
from autobalancer.kernels.laws.rebound import LEVELS, LOWEST, NONE, PER_DECADE
from autobalancer.kernels.pointers import behind, data
from autobalancer.kernels.records.impacts import BEHIND, NEXT
from autobalancer.kernels.system import BALLS, System, system_at

SLOWEST = 1e-5  # m/s, as in impacts.py
GUESSES = 300  # of the slips in an impact
PIVOT = 1e-11  # of the greatest: what is less depends on the others


@njit(**INLINE)
def _give(y: Any, p: System, kind: int, k: int, torque: float) -> None:
    """Give the balls of a contact its torque from outside."""
    its = p.guided[k]
    if kind == NEXT:
        at, other = link(y, p, k), p.guided[p.contacts[k].next]
        its.given, its.given_out = -torque * at.back, torque * at.out
        other.given, other.given_out = torque * at.ahead, torque * at.out_next
    else:
        its.given = torque if kind == BEHIND else -torque


@njit(**INLINE)
def _take_back(p: System, kind: int, k: int) -> None:
    p.guided[k].given, p.guided[k].given_out = 0.0, 0.0
    if kind == NEXT:
        p.guided[p.contacts[k].next].given, p.guided[p.contacts[k].next].given_out = 0.0, 0.0


@njit(**APART)
def responses(time, y, rates, system, size, count):  # type: ignore[no-untyped-def]
    """Rates with the chosen contacts open, what a torque of each adds to them, and Delassus' matrix; returns evaluations."""
    p = behind(system_at(system))
    r, rows = p.rigid, p.ball_count
    for q in range(count):
        if r.chosen[q] != 0:
            close(p, r.kinds[q], r.balls[q], 0)
    count_bound(system)
    rates(time, y, data(r.base), system)
    fast, done = 1.0, 1
    for k in range(rows):
        fast = max(fast, abs(r.base[BALLS + rows + k]))
    for q in range(count):
        if r.chosen[q] == 0:
            continue
        kind, k = r.kinds[q], r.balls[q]
        torque = p.balls[k].inertia * fast
        _give(y, p, kind, k, torque)
        rates(time, y, data(r.response[q]), system)
        _take_back(p, kind, k)
        done += 1
        for i in range(size):
            r.response[q, i] = (r.response[q, i] - r.base[i]) / torque
    for q in range(count):
        for j in range(count):
            if r.chosen[q] != 0 and r.chosen[j] != 0:
                r.delassus[q, j] = opening(data(r.response[j]), p, r.kinds[q], r.balls[q])
    return done


@njit(**APART)
def solve_active(system: Any, count: int) -> None:
    """Impulses of the active contacts that bring ``need`` to zero there, by Gauss' elimination; 0 elsewhere."""
    p = behind(system_at(system))
    r, left = p.rigid, p.rigid.left
    great = 0.0
    for i in range(count):
        for j in range(count):
            both = r.active[i] != 0 and r.active[j] != 0
            left[i, j] = r.delassus[i, j] if both else 0.0
        left[i, count] = -r.need[i] if r.active[i] != 0 else 0.0
        if r.active[i] != 0:
            great = max(great, abs(r.delassus[i, i]))
    for k in range(count):  # the matrix is nearly symmetric and positive: pivots on its diagonal
        if abs(left[k, k]) <= PIVOT * great:
            continue
        inverse = 1.0 / left[k, k]
        for i in range(count):
            if i != k and left[i, k] != 0.0:
                factor = left[i, k] * inverse
                for j in range(k, count + 1):
                    left[i, j] -= factor * left[k, j]
                left[i, k] = 0.0
    for k in range(count):
        r.impulse[k] = left[k, count] / left[k, k] if abs(left[k, k]) > PIVOT * great else 0.0


@njit(**APART)
def complementary(system: Any, count: int) -> None:
    """Impulses P >= 0 of the chosen contacts, orthogonal to need + G P >= 0."""
    p = behind(system_at(system))
    r = p.rigid
    size, stiff = 0.0, 0.0
    for q in range(count):
        r.impulse[q], r.active[q] = 0.0, 0
        if r.chosen[q] != 0:
            size, stiff = max(size, abs(r.need[q])), max(stiff, r.delassus[q, q])
            r.active[q] = 1 if r.need[q] < 0.0 else 0
    if stiff == 0.0 or size == 0.0:
        return
    least, patience = count + 1, 10
    for _ in range(20 + 10 * count):
        solve_active(system, count)
        wrong, last = 0, -1
        for q in range(count):
            if _misplaced(p, q, count, size, stiff):
                wrong, last = wrong + 1, q
        if wrong == 0:
            for q in range(count):
                r.impulse[q] = max(r.impulse[q], 0.0)
            return
        several = wrong < least or patience > 0
        patience = 10 if wrong < least else patience - 1
        least = min(least, wrong)
        # turned from the last one on, as the impulses judge the old set
        for q in range(count):
            r.active[q] += 2 if (several or q == last) and _misplaced(p, q, count, size, stiff) else 0
        for q in range(count):
            r.active[q] = 1 - (r.active[q] - 2) if r.active[q] >= 2 else r.active[q]
    _relaxed(system, count, size)


@njit(**INLINE)
def _misplaced(p: System, q: int, count: int, size: float, stiff: float) -> bool:
    """Whether an active contact pulls, or one that is not active is driven together."""
    r = p.rigid
    if r.chosen[q] == 0:
        return False
    if r.active[q] % 2 == 1:
        return bool(r.impulse[q] * stiff < -1e-12 * size)
    rest = r.need[q]
    for j in range(count):
        rest += r.delassus[q, j] * r.impulse[j] if r.chosen[j] != 0 else 0.0
    return bool(rest < -1e-12 * size)


@njit(**APART)
def _relaxed(system: Any, count: int, size: float) -> None:
    """Projected Gauss-Seidel, for rows without play."""
    p = behind(system_at(system))
    r = p.rigid
    for q in range(count):
        r.impulse[q] = 0.0
    for _ in range(20_000):
        change = 0.0
        for q in range(count):
            if r.chosen[q] == 0 or r.delassus[q, q] <= 0.0:
                continue
            rest = r.need[q]
            for j in range(count):
                rest += r.delassus[q, j] * r.impulse[j] if r.chosen[j] != 0 else 0.0
            new = max(0.0, r.impulse[q] - rest / r.delassus[q, q])
            change = max(change, abs(new - r.impulse[q]) * r.delassus[q, q])
            r.impulse[q] = new
        if change <= 1e-14 * size:
            break


@njit(**INLINE)
def restitution(p: System, kind: int, k: int, speed: float) -> float:
    """Share of the speed (m/s) that an impact leaves."""
    pair = p.contacts[k]
    table, left = (pair.rebound, pair.left) if kind == NEXT else (pair.wall_rebound, pair.wall_left)
    if table == NONE:
        return float(left)
    level = min(max((math.log10(speed + 1e-300) - LOWEST) * PER_DECADE, 0.0), LEVELS - 1.000001)
    i = int(level)
    one = p.rebounds[table + i]
    return float(one + (level - i) * (p.rebounds[table + i + 1] - one))


@njit(**APART)
def strike(time, y, rates, system, size, count, slow):  # type: ignore[no-untyped-def]
    """Change the state ``y`` by the impact of the contacts listed, whose openings are known; returns evaluations.

    What approaches more slowly than ``slow`` (rad/s) does not rebound.
    """
    p = behind(system_at(system))
    r, at, done, rubs, fastest = p.rigid, BALLS + p.ball_count, 0, False, 0.0
    _free_for_impact(p, count)
    for q in range(count):
        r.chosen[q] = 1
        rubs = rubs or (r.kinds[q] == NEXT and p.contacts[r.balls[q]].rub > 0.0)
        fastest = max(fastest, abs(r.before[q]))
    enough = max(1e-3 * slow, 1e-9 * fastest)
    for i in range(size):
        r.middle[i], r.missed[i] = y[i], 0.0
    share = 1.0
    for _ in range(GUESSES if rubs else 1):
        done += responses(time, data(r.middle), rates, system, size, count)
        for q in range(count):
            kind, k, before = r.kinds[q], r.balls[q], r.before[q]
            r.need[q] = before
            if before < -slow:
                pace = p.contacts[k].pace if kind == NEXT else p.contacts[k].wall_pace
                r.need[q] += restitution(p, kind, k, -pace * before) * before
        complementary(system, count)
        change, turn = 0.0, 0.0
        for i in range(size):
            gained = 0.0
            for q in range(count):
                gained += r.response[q, i] * r.impulse[q]
            miss = y[i] + 0.5 * gained - r.middle[i]
            if at <= i < at + p.ball_count:
                change, turn = max(change, abs(miss)), turn + miss * r.missed[i]
            r.base[i], r.missed[i] = gained, miss
        if turn < 0.0:  # friction that turns the slip round is found by ever smaller changes
            share *= 0.5
        for i in range(size):
            r.middle[i] += share * r.missed[i]
        if change < enough:
            break
    for i in range(size):
        y[i] += r.base[i]
    _note(time, p, count)
    return done


@njit(**INLINE)
def _free_for_impact(p: System, count: int) -> None:
    """Let go of balls at rest on their race which an impact reaches, and give them the way it pushes them."""
    r = p.rigid
    for _ in range(count):
        for q in range(count):
            if r.kinds[q] != NEXT:
                continue
            one, other = p.guided[r.balls[q]], p.guided[p.contacts[r.balls[q]].next]
            hit = r.before[q] < 0.0
            if one.mode == 0.0 and (hit or other.mode < 0.0):
                one.mode = -1.0
            if other.mode == 0.0 and (hit or one.mode > 0.0):
                other.mode = 1.0


@njit(**INLINE)
def _note(time: float, p: System, count: int) -> None:
    """Note the impacts of a run that wants to know them."""
    r = p.rigid
    for t in range(p.touches.size):
        touch = p.touches[t]
        for q in range(count):
            if touch.kind == r.kinds[q] and touch.one == r.balls[q]:
                pair = p.contacts[touch.one]
                speed = -(pair.pace if touch.kind == NEXT else pair.wall_pace) * r.before[q]
                if speed > SLOWEST:
                    number = p.impact_count[0]
                    if number < p.impacts.size:
                        p.impacts[number].time, p.impacts[number].speed, p.impacts[number].touch = time, speed, t
                    p.impact_count[0] = number + 1
