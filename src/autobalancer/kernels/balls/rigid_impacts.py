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
from typing import Any, NamedTuple

from autobalancer.kernels.balls.rigid_torques import FAR, LEAST, NOW, PULL, capacity, leads, link
from autobalancer.kernels.compiler.flags import APART, INLINE, njit
from autobalancer.kernels.compiler.numba_struct import data, deref
from autobalancer.kernels.laws.contact_law import NONE, restitution_at
from autobalancer.kernels.records import AHEAD, BEHIND, NEXT
from autobalancer.kernels.system import BALLS, System, system_at

SLOWEST = 1e-5  # m/s, as in race_events.py
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
    p = deref(system_at(system))
    r, rows = p.rigid, p.ball_count
    # the rates with all chosen contacts open: what every response is measured against
    for q in range(count):
        if r.chosen[q] != 0:
            close(p, r.kinds[q], r.balls[q], 0)
    count_bound(system)
    rates(time, y, data(r.base), system)
    # a torque that changes rates as much as the motion itself does, so that the difference keeps its digits
    fast, done = 1.0, 1
    for k in range(rows):
        fast = max(fast, abs(r.base[BALLS + rows + k]))
    # each contact alone presses with that torque: the rates are linear in it, so their difference over it is exact
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
    # Delassus' matrix G: how much the gap of one contact accelerates per torque of another
    for q in range(count):
        for j in range(count):
            if r.chosen[q] != 0 and r.chosen[j] != 0:
                r.delassus[q, j] = opening(data(r.response[j]), p, r.kinds[q], r.balls[q])
    return done


@njit(**APART)
def solve_active(system: Any, count: int) -> None:
    """Impulses of the active contacts that bring ``need`` to zero there, by Gauss' elimination; 0 elsewhere."""
    p = deref(system_at(system))
    r, left = p.rigid, p.rigid.left
    # rows and columns of the active contacts, and the greatest number of the diagonal as the measure of what is zero
    great = 0.0
    for i in range(count):
        for j in range(count):
            both = r.active[i] != 0 and r.active[j] != 0
            left[i, j] = r.delassus[i, j] if both else 0.0
        left[i, count] = -r.need[i] if r.active[i] != 0 else 0.0
        if r.active[i] != 0:
            great = max(great, abs(r.delassus[i, i]))
    # eliminate above and below the diagonal at once; a contact that depends on others keeps no impulse
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
    p = deref(system_at(system))
    r = p.rigid
    # begin with those active that approach; what is left is judged against the greatest need and stiffness
    size, stiff = 0.0, 0.0
    for q in range(count):
        r.impulse[q], r.active[q] = 0.0, 0
        if r.chosen[q] != 0:
            size, stiff = max(size, abs(r.need[q])), max(stiff, r.delassus[q, q])
            r.active[q] = 1 if r.need[q] < 0.0 else 0
    if stiff == 0.0 or size == 0.0:
        return
    # block pivoting: solve for the active set, then exchange all that are on the wrong side. That may cycle, so when the
    # number of wrong ones has not fallen for ten rounds, only the last one is exchanged (Murty), which always ends
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
    p = deref(system_at(system))
    r = p.rigid
    for q in range(count):
        r.impulse[q] = 0.0
    # contact after contact takes the impulse that ends its approach, never a pull, until nothing changes
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
    return restitution_at(p.rebounds, table, speed)


@njit(**APART)
def strike(time, y, rates, system, size, count, slow):  # type: ignore[no-untyped-def]
    """Change the state ``y`` by the impact of the contacts listed, whose openings are known; returns evaluations.

    What approaches more slowly than ``slow`` (rad/s) does not rebound.
    """
    p = deref(system_at(system))
    r, at, done, rubs, fastest = p.rigid, BALLS + p.ball_count, 0, False, 0.0
    # all contacts listed take part; a speed below `enough` is no difference any more
    _free_for_impact(p, count)
    for q in range(count):
        r.chosen[q] = 1
        rubs = rubs or (r.kinds[q] == NEXT and p.contacts[r.balls[q]].rub > 0.0)
        fastest = max(fastest, abs(r.before[q]))
    enough = max(1e-3 * slow, 1e-9 * fastest)
    # friction depends on the slip, so on the mean of the states before and after: `middle`, found by iteration
    for i in range(size):
        r.middle[i], r.missed[i] = y[i], 0.0
    share = 1.0
    for _ in range(GUESSES if rubs else 1):
        # what the gaps need: an end of the approach, and of fast approaches the rebound too
        done += responses(time, data(r.middle), rates, system, size, count)
        for q in range(count):
            kind, k, before = r.kinds[q], r.balls[q], r.before[q]
            r.need[q] = before
            if before < -slow:
                pace = p.contacts[k].pace if kind == NEXT else p.contacts[k].wall_pace
                r.need[q] += restitution(p, kind, k, -pace * before) * before
        complementary(system, count)
        # the middle state that these impulses give, and by how much the guess of it was wrong
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
    # the whole state takes the impulse, rotor included
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


# Rigid contacts by number: which are closed, how wide the others are, and which balls they hold together.
#
# A contact is known by its kind (records.py: NEXT, BEHIND, AHEAD) and its ball. All functions take a state
# ``y``.


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
    p = deref(system_at(system))
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
    p = deref(system_at(system))
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
    p = deref(system_at(system))
    at = BALLS + p.ball_count
    for head in range(p.ball_count):
        if p.guided[head].bound == 0 or p.ties[head].follows != 0:
            continue
        # the common speed keeps the angular momentum; beside a partition it is zero
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
    # gaps of the size of rounding are closed from both sides
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
    p = deref(system_at(system))
    for k in range(p.ball_count):
        its = p.ties[k]
        its.low, its.high = 0, 0
        its.joined = 0 if p.contacts[k].rigid < 2 else its.joined
    data(p.rigid.bound)[0] = 0


# Which rigid contacts are closed from an instant on: impacts first, then who presses, then who only chatters.
#
# All of it asks for a state, the right-hand side and tolerances, not for how the state was reached.


NEAR = 1e-9  # rad, by which balls may be apart that touch at the start of a run


class Limits(NamedTuple):
    """What counts as nothing."""

    slow: float  # rad/s: an approach that does not rebound
    low: float  # rad: height of a flight that is not flown


@njit(**INLINE)
def _rest_speed(limits: Limits) -> float:
    return max(1e-3 * limits.slow, 1e-11)


@njit(**APART)
def settle(time, y, rates, system, size, width, limits):  # type: ignore[no-untyped-def]
    """Let closed contacts strike, and find out which stay closed; ``width`` (rad) is that of gaps that count as closed.

    Changes the state ``y`` of ``size`` components; returns evaluations.
    """
    p = deref(system_at(system))
    r, done, still = p.rigid, 0, _rest_speed(limits)
    # first the impacts, if anything approaches
    count = collect(y, system, width)
    approaching = False
    for q in range(count):
        approaching = approaching or r.before[q] < -still
    if approaching:
        done += strike(time, y, rates, system, size, count, limits.slow)
    # then which of the closed contacts press, with accelerations in place of speeds
    done += _stay(time, y, rates, system, size, count, still)
    # last the chattering: what would fly apart by less than can be seen is stopped and stays closed
    if _catch(y, p, count, still, limits.low):
        done += _stop_openings(time, y, rates, system, size, count)
        done += _stay(time, y, rates, system, size, count, still)
    r.margin[LEAST] = FAR
    return done


@njit(**APART)
def _stay(time, y, rates, system, size, count, still):  # type: ignore[no-untyped-def]
    """Close the contacts listed that are at rest and press, and open the others; ``r.base`` are the rates then."""
    p = deref(system_at(system))
    r, done = p.rigid, 0
    # contacts whose balls do not part are closed for now, and their balls get one speed
    for q in range(count):
        kind, k = r.kinds[q], r.balls[q]
        close(p, kind, k, 1 if abs(opening(y, p, kind, k)) <= still else 0)
    count_bound(system)
    equalize(y, system)
    _set_modes(y, p)
    # balls that adherence may hold come first: whether they rest does not ask who presses
    done += _rest(time, y, rates, system, count, still)
    # then rolling balls; a ball that was held may break loose by what they do to the rotor, so again
    again = True
    while again and done <= 9 * p.ball_count + 9:
        done += _press(time, y, rates, system, size, count, still)
        again = _loosen(system)  # what balls that touch do to the rotor may be just too much for one that rests
    return done


@njit(**APART)
def _press(time, y, rates, system, size, count, still):  # type: ignore[no-untyped-def]
    """Close those contacts listed of rolling balls that press, and open the others."""
    p = deref(system_at(system))
    r, done, some = p.rigid, 0, False
    # those at rest whose balls roll: 0 <= torque orthogonal to acceleration of the gap >= 0
    for q in range(count):
        kind, k = r.kinds[q], r.balls[q]
        r.chosen[q] = 1 if not is_closed(p, kind, k) and _may_press(y, p, kind, k, still) else 0
        some = some or r.chosen[q] != 0
    if some:
        done += responses(time, y, rates, system, size, count)
        for q in range(count):
            r.need[q] = opening(data(r.base), p, r.kinds[q], r.balls[q])
        complementary(system, count)
        # a contact stays closed where it presses, or where its gap would open by less than rounding
        for q in range(count):
            if r.chosen[q] != 0:
                rest = r.need[q]
                for j in range(count):
                    rest += r.delassus[q, j] * r.impulse[j] if r.chosen[j] != 0 else 0.0
                presses = r.impulse[q] > 0.0 or rest <= r.margin[PULL] * r.delassus[q, q]
                close(p, r.kinds[q], r.balls[q], 1 if presses else 0)
        count_bound(system)
    return done + open_pulling(time, y, rates, system)


@njit(**INLINE)
def rubs(ball: Any) -> bool:
    """Whether friction can hold a ball."""
    return bool(ball.rolling > 0.0 or ball.adherence > 0.0)


@njit(**INLINE)
def at_rest(p: System, k: int) -> bool:
    """Whether friction holds a ball."""
    return bool(p.guided[k].mode == 0.0 and rubs(p.balls[k]))


@njit(**INLINE)
def _set_modes(y: Any, p: System) -> None:
    """Balls that friction can hold rest where their speed is zero, and roll the way they move elsewhere."""
    for k in range(p.ball_count):
        rate = y[BALLS + p.ball_count + k]
        if rubs(p.balls[k]):
            p.guided[k].mode = math.copysign(1.0, rate) if rate != 0.0 else 0.0


@njit(**INLINE)
def _may_press(y: Any, p: System, kind: int, k: int, still: float) -> bool:
    """Whether a contact of balls that roll is at rest."""
    rest = at_rest(p, k) or (kind == NEXT and at_rest(p, p.contacts[k].next))
    return bool(not rest and abs(opening(y, p, kind, k)) <= still)


@njit(**APART)
def _rest(time, y, rates, system, count, still):  # type: ignore[no-untyped-def]
    """Close the contacts among balls that adherence may hold, and let those break loose that it cannot."""
    p = deref(system_at(system))
    r = p.rigid
    for q in range(count):
        kind, k = r.kinds[q], r.balls[q]
        held = at_rest(p, k) and (kind != NEXT or at_rest(p, p.contacts[k].next))
        close(p, kind, k, 1 if held and abs(opening(y, p, kind, k)) <= still else 0)
    count_bound(system)
    resting = False
    for k in range(p.ball_count):
        resting = resting or at_rest(p, k)
    done = 0
    while resting and done <= p.ball_count:
        rates(time, y, data(r.base), system)
        done += 1
        resting = _loosen(system)
    return done


@njit(**APART)
def _loosen(system: Any) -> bool:
    """Let those balls roll that adherence cannot hold, by the last evaluation; whether there were any."""
    p = deref(system_at(system))
    some = False
    for k in range(p.ball_count):
        if p.guided[k].bound == 0 and at_rest(p, k):
            if is_loose(p, k):
                p.guided[k].mode, some = math.copysign(1.0, p.guided[k].need), True
        elif leads(p, k) and at_rest(p, k):
            some = _break(p, k) or some
    if some:
        count_bound(system)
    return some


@njit(**INLINE)
def is_loose(p: System, k: int) -> bool:
    """Whether adherence cannot hold a ball that touches nothing."""
    return bool(abs(p.guided[k].need) > capacity(p, k))


@njit(**INLINE)
def _break(p: System, head: int) -> bool:
    """Let those balls of a row at rest roll that cannot be held: the first ones backward, or the last ones forward."""
    # through the row: the first ball up to which it cannot be held backward, and the torque that all must hold together
    k, last, back = head, head, -1
    pushed, more = 0.0, True
    while more:
        its = p.ties[k]
        if back < 0 and its.most < 0.0 and its.joined != 2:
            back = k
        pushed += its.rest
        last, more = k, its.joined == 1
        k = p.contacts[k].next
    # a full ring has no end: it breaks loose as a whole or not at all
    end = p.ties[last]
    if end.joined == 2:
        if p.rigid.margin[NOW] >= 0.0:
            return False
        _roll(p, head, last, math.copysign(1.0, pushed))
        return True
    # the first ones up to there roll backward and leave the rest
    if back >= 0:
        _roll(p, head, back, -1.0)
        p.ties[back].joined = 0
        return True
    # the last ones roll forward, if nothing stops them there
    if end.high == 0 and end.least > 0.0:
        first = last
        while first != head and p.ties[p.contacts[first].before].least > 0.0:
            first = p.contacts[first].before
        _roll(p, first, last, 1.0)
        if first != head:
            p.ties[p.contacts[first].before].joined = 0
        else:
            p.ties[head].low = 0
        return True
    return False


@njit(**INLINE)
def _roll(p: System, first: int, last: int, way: float) -> None:
    """Balls in a row roll this way; what joined them is to be found again."""
    k, more = first, True
    while more:
        p.guided[k].mode = way
        more = k != last
        if p.ties[k].joined == 1 and more:
            p.ties[k].joined = 1 if p.contacts[k].rigid == 2 else 0
        k = p.contacts[k].next


@njit(**INLINE)
def _catch(y: Any, p: System, count: int, still: float, low: float) -> bool:
    """Choose contacts that would fly apart less than ``low``, besides those that press; whether there are any."""
    r, some = p.rigid, False
    for q in range(count):
        kind, k = r.kinds[q], r.balls[q]
        r.chosen[q] = 1 if is_closed(p, kind, k) else 0
        if r.chosen[q] == 0:
            rate, back = opening(y, p, kind, k), -opening(data(r.base), p, kind, k)
            if rate > still and back > 0.0 and rate * rate < 2.0 * back * low:
                r.chosen[q], some = 1, True
    return some


@njit(**APART)
def _stop_openings(time, y, rates, system, size, count):  # type: ignore[no-untyped-def]
    """Stop the openings of the chosen contacts by impulses of either sign, which are tiny."""
    p = deref(system_at(system))
    r = p.rigid
    # balls at rest that move by rounding count as rolling, else friction would hold them
    for q in range(count):
        k = r.balls[q]
        for j in (k, p.contacts[k].next if r.kinds[q] == NEXT else k):
            if r.chosen[q] != 0 and p.guided[j].mode == 0.0 and y[BALLS + p.ball_count + j] != 0.0:
                p.guided[j].mode = math.copysign(1.0, y[BALLS + p.ball_count + j])
    # impulses that take the opening speeds to zero, put into the whole state
    done = responses(time, y, rates, system, size, count)
    for q in range(count):
        r.need[q], r.active[q] = opening(y, p, r.kinds[q], r.balls[q]), r.chosen[q]
    solve_active(system, count)
    for i in range(size):
        for q in range(count):
            if r.chosen[q] != 0:
                y[i] += r.response[q, i] * r.impulse[q]
    return done


@njit(**APART)
def open_pulling(time, y, rates, system):  # type: ignore[no-untyped-def]
    """Open contacts that would pull, the one that pulls most first; returns evaluations. ``r.base`` are the rates then."""
    p = deref(system_at(system))
    r, done, pulls = p.rigid, 0, True
    while pulls and done <= 3 * p.ball_count:
        r.margin[NOW] = FAR
        rates(time, y, data(r.base), system)
        done += 1
        # opening one contact changes the torques of all, so one at a time, and the worst first
        worst, which, its_kind = -r.margin[PULL], -1, NEXT
        for k in range(p.ball_count):
            for kind in (NEXT, BEHIND, AHEAD):
                if exists(p, kind, k) and is_closed(p, kind, k) and torque_of(p, kind, k) < worst:
                    worst, which, its_kind = torque_of(p, kind, k), k, kind
        pulls = which >= 0
        if pulls:
            close(p, its_kind, which, 0)
            count_bound(system)
    return done


@njit(**APART)
def recognize(time, y, rates, system):  # type: ignore[no-untyped-def]
    """Which contacts are closed in a state that a run has left: those without a gap whose balls have the same speed."""
    p = deref(system_at(system))
    for k in range(p.ball_count):
        for kind in (NEXT, BEHIND, AHEAD):
            if exists(p, kind, k):
                touches = gap(y, p, kind, k) < NEAR and opening(y, p, kind, k) == 0.0
                close(p, kind, k, 1 if touches else 0)
    count_bound(system)
    open_pulling(time, y, rates, system)
