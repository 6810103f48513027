"""One speed held and measured."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from numba import int64, types

from autobalancer.kernels.compiler.flags import COMPILED, INLINE, PART, njit
from autobalancer.kernels.compiler.numba_struct import address, as_void, data, deref, passed_by_address, struct_type
from autobalancer.kernels.integrators.collocation import (
    BASIS,
    HELD,
    LENGTH_BEFORE,
    LONG_STEPS,
    OF_EXPONENTS,
    TALLIES,
    Amplitudes,
    amplitudes_type,
    nodes_type,
    watch_type,
)
from autobalancer.kernels.integrators.collocation_stepper import integrate
from autobalancer.kernels.integrators.collocation_sweep import pieces_needed, values_inside, write_piece
from autobalancer.kernels.integrators.dense_output import component, polynomials, slope
from autobalancer.kernels.integrators.integrator_state import (
    ACCEPTED,
    COUNTS,
    END,
    ERROR,
    FORGET,
    FRESH,
    STEP,
    TAKEN,
    TIME,
    Memory,
    memory_type,
    switch_type,
)
from autobalancer.kernels.integrators.recording import PIECES, Record, record_type
from autobalancer.kernels.integrators.runge_kutta import FINISHED, RUNNING
from autobalancer.kernels.integrators.tableau import Tableau, tableau_type
from autobalancer.kernels.system import (
    BALLS,
    SPEED,
    THETA,
    Floats,
    Matrix,
    System,
    rhs_type,
    system_at,
    system_type,
    tuple_type,
    vector_type,
)

# What is measured while a speed is held.
#
# Measured on the dense output of every step, at :data:`PIECES` equal parts of it and, between two of these, wherever a
# radius stops growing or a ball turns back (rule of the Illinois).


@passed_by_address
class Window(NamedTuple):
    """What is measured of S stations and n balls, in both halves of the window, and room for it."""

    rows: Matrix  # (2 S, R) deflection of the stations along x and y
    weights: Floats  # (S,) in the mean radius
    greatest: Matrix  # (2, S + 1) greatest radius of each station, then of their mean
    low: Matrix  # (2, n) least ball angle in the rotor
    high: Matrix  # (2, n) greatest
    ends: Matrix  # (2, n) at begin and end of the window
    forward: Matrix  # (S, 2) mean deflection in the rotor
    spent: Floats  # (3,) time on the way, relative change between the halves, weight of the mean
    place: Floats  # (R,) work
    move: Floats  # (R,) work
    points: Matrix  # (S, 2) work
    value: Floats  # (S + 1,) work
    growth: Floats  # (S + 1,) work
    before: Floats  # (S + 1,) work


window_type = struct_type(tuple_type(Window))


@njit(**PART)
def _look(x, count, seen):  # type: ignore[no-untyped-def]
    """Radii and their growth at the fraction x of the step; ``seen`` points to (memory, window)."""
    m, w = deref(seen)
    stations, size = w.weights.size, w.rows.shape[1]
    for k in range(size):
        i = k if k < 2 else BALLS + 2 * count + k - 2
        w.place[k], w.move[k] = component(i, x, m), slope(i, x, m)
    mean, growing = 0.0, 0.0
    for s in range(stations):
        a, b, da, db = 0.0, 0.0, 0.0, 0.0
        for k in range(size):
            a += w.rows[2 * s, k] * w.place[k]
            b += w.rows[2 * s + 1, k] * w.place[k]
            da += w.rows[2 * s, k] * w.move[k]
            db += w.rows[2 * s + 1, k] * w.move[k]
        radius = math.sqrt(a * a + b * b)
        rate = (a * da + b * db) / radius if radius > 0.0 else 0.0
        w.points[s, 0], w.points[s, 1] = a, b
        w.value[s], w.growth[s] = radius, rate
        mean += w.weights[s] * radius
        growing += w.weights[s] * rate
    w.value[stations], w.growth[stations] = mean, growing


@njit(**INLINE)
def _next_guess(low: float, high: float, f_low: float, f_high: float) -> float:
    return (low * f_high - high * f_low) / (f_high - f_low)


@njit(**PART)
def _turning_radius(k, left, right, f_left, f_right, count, seen):  # type: ignore[no-untyped-def]
    """Greatest value of radius k between two places where its growth has opposite signs."""
    _, w = deref(seen)
    low, high, f_low, f_high, best = left, right, f_left, f_right, 0.0
    for _ in range(6):
        x = _next_guess(low, high, f_low, f_high)
        _look(x, count, seen)
        best, f = max(best, w.value[k]), w.growth[k]
        if f * f_high < 0.0:
            low, f_low = high, f_high
        else:
            f_low *= 0.5
        high, f_high = x, f
        if f == 0.0 or abs(high - low) < 1e-9:
            break
    return best


@njit(**PART)
def _turning_angle(b, left, right, f_left, f_right, count, seen):  # type: ignore[no-untyped-def]
    """Angle of a ball where it turns back."""
    m, _ = deref(seen)
    low, high, f_low, f_high = left, right, f_left, f_right
    for _ in range(6):
        x = _next_guess(low, high, f_low, f_high)
        f = component(BALLS + count + b, x, m)
        if f * f_high < 0.0:
            low, f_low = high, f_high
        else:
            f_low *= 0.5
        high, f_high = x, f
        if f == 0.0 or abs(high - low) < 1e-9:
            break
    return component(BALLS + b, high, m)


@njit(**PART)
def note(left, begin, length, half, parameters, seen):  # type: ignore[no-untyped-def]
    """Fold the step that began at ``left`` into the window that began at ``begin``; it counts up to where it was cut."""
    p, (m, w) = deref(system_at(parameters)), deref(seen)
    count, radii, step = p.ball_count, w.weights.size + 1, m.clock[TAKEN]
    cut = min(1.0, (m.clock[TIME] - left) / step)
    for piece in range(PIECES + 1):
        x = cut * piece / PIECES
        _look(x, count, seen)
        # Simpson's rule over the pieces, and the weight of Hann, which lets no part of a turn leak into the mean
        share = cut * step / (3.0 * PIECES) * (1.0 if piece in (0, PIECES) else 4.0 if piece % 2 == 1 else 2.0)
        share *= 1.0 - math.cos(2.0 * math.pi * (left + x * step - begin) / length)
        c, s = 1.0, 0.0
        if p.rotating != 1:
            angle = component(THETA, x, m)
            c, s = math.cos(angle), math.sin(angle)
        w.spent[2] += share
        for k in range(radii - 1):
            a, b = w.points[k, 0], w.points[k, 1]
            w.forward[k, 0] += share * (a * c + b * s)
            w.forward[k, 1] += share * (b * c - a * s)
        for k in range(radii):
            w.greatest[half, k] = max(w.greatest[half, k], w.value[k])
            after = w.growth[k]
            if piece > 0 and w.before[k] > 0.0 and after < 0.0:
                best = _turning_radius(k, x - cut / PIECES, x, w.before[k], after, count, seen)
                w.greatest[half, k] = max(w.greatest[half, k], best)
                _look(x, count, seen)
            w.before[k] = w.growth[k]
        for ball in range(count):
            angle = component(BALLS + ball, x, m)
            w.low[half, ball], w.high[half, ball] = min(w.low[half, ball], angle), max(w.high[half, ball], angle)
            if piece == 0:
                continue
            back = x - cut / PIECES
            old, new = component(BALLS + count + ball, back, m), component(BALLS + count + ball, x, m)
            if old * new < 0.0:
                angle = _turning_angle(ball, back, x, old, new, count, seen)
                w.low[half, ball], w.high[half, ball] = min(w.low[half, ball], angle), max(w.high[half, ball], angle)


# A rotor is brought to a speed, held there until transients have died, and measured over a window.
#
# In long steps where the machine takes them, with the explicit pair where it does not, as any run.


# places in the plan: speed to go to, rate of the way there (infinite: at once), time before and length of the window,
# relative change between its halves that counts as settled (negative: never look), longest time at the speed, steps
TARGET, RATE, DWELL, WINDOW, SETTLED, LIMIT, BUDGET, PLAN = range(8)
LOOK = 5_000  # steps between two looks at the budget
FIRST = 0.1  # rad of rotor angle in the first step at a speed


@njit(**PART)
def _forget(by_powers):  # type: ignore[no-untyped-def]
    """Nothing of an earlier speed is left in what long steps remember, so that each begins as if it were the first."""
    _, _, a = deref(by_powers)
    for i in range(HELD):
        a.held[i] = math.nan
    a.held[BASIS] = -1.0
    for i in range(TALLIES):
        a.tallies[i] = 0
    if a.bases.size > 0:
        for part in range(a.exponents.size):
            a.exponents[part] = a.bases[OF_EXPONENTS + part]


@njit(**PART)
def _note_pieces(time, begin, length, half, parameters, seen, by_powers):  # type: ignore[no-untyped-def]
    """Measure a long step that began at ``time``; ``by_powers`` points to (tableau, memory, amplitudes) of long steps."""
    powers, long, a = deref(by_powers)
    step, end, inner, memory = a.held[LENGTH_BEFORE], long.clock[TIME], address(a), address(long)
    pieces = pieces_needed(step, a)
    for i in range(long.state.size):
        long.start[i] = a.origin[i]
    for piece in range(pieces):
        left = time + step * piece / pieces
        if left >= end:
            break
        long.clock[TAKEN] = step / pieces
        if pieces == 1:
            write_piece(data(a.values), step, long.state.size, inner, memory)
        else:
            values_inside(piece, pieces, step, a, long)
            write_piece(data(a.inside), step / pieces, long.state.size, inner, memory)
        polynomials(long.state.size, powers, long)
        note(left, begin, length, half, parameters, seen)
        for i in range(long.state.size):
            long.start[i] = a.reached[i]


@njit(
    int64(
        rhs_type, switch_type, nodes_type, watch_type, system_type, types.UniTuple(tableau_type, 2),
        types.UniTuple(record_type, 2), types.UniTuple(memory_type, 2), amplitudes_type, window_type, vector_type,
    ),
    **COMPILED,
)  # fmt: skip
def hold(
    rhs: Callable[[float, Any, Any, Any], None],
    switch: Callable[[int, float, Any, Any, Any], float],
    nodes: Callable[[float, float, Any, Any], None],
    watch: Callable[[float, Any, Any], float],
    p: System,
    tableaus: tuple[Tableau, Tableau],
    records: tuple[Record, Record],
    memories: tuple[Memory, Memory],
    a: Amplitudes,
    w: Window,
    plan: Floats,
) -> int:
    """Bring the state to the speed of the plan, hold, measure; returns how the integration ended.

    ``p`` has one segment. The clock and the steps begin anew, so that the end depends on the state and the plan only.
    Of the two records the first makes the stepper keep no dense output, the second that of all components. Tableaus, memories
    (of the pair, of long steps) and amplitudes are those of
    :func:`autobalancer.kernels.integrators.collocation_stepper.integrate`.
    """
    (t, powers), (quiet, dense), (m, long) = tableaus, records, memories
    n, count, radii = m.state.size, p.ball_count, w.weights.size + 1
    parameters, segment = as_void(address(p)), p.drive.segments[0]
    seen, seen_long, by_powers = address((m, w)), address((long, w)), address((powers, long, a))
    for i in range(COUNTS):
        m.counts[i] = 0
    _forget(by_powers)
    switch(FORGET, 0.0, rhs, parameters, as_void(address((t, m))))
    # a small part of a turn: at a motion that hardly changes in the rotor a guess from rates would be far too long
    m.clock[TIME], m.clock[STEP], m.clock[ERROR] = 0.0, FIRST / abs(plan[TARGET]), 1.0
    # to the speed of the plan
    change = plan[TARGET] - m.state[SPEED]
    ramp, status = 0.0, FINISHED
    if change != 0.0 and math.isinf(plan[RATE]):
        # the limit of an ever faster ramp: the accelerations are linear in that of the rotor
        for i in range(m.trial.size):
            m.trial[i] = m.state[i] if i < n else 0.0
        segment.value = m.state[SPEED]
        for number in range(2):
            segment.rate = float(number)
            rhs(0.0, data(m.trial), data(m.stages[number]), parameters)
        for i in range(n):
            m.state[i] += change * (m.stages[1, i] - m.stages[0, i])
    elif change != 0.0:
        ramp = abs(change) / plan[RATE]
        segment.value, segment.rate = m.state[SPEED], change / ramp
        m.clock[END], status = ramp, RUNNING
        while status == RUNNING and m.counts[ACCEPTED] < plan[BUDGET]:
            status = integrate(rhs, switch, nodes, watch, p, t, powers, quiet, m, long, a, LOOK)
    w.spent[0] = ramp
    if status != FINISHED:
        return status
    # hold it
    segment.value, segment.rate, m.state[SPEED] = plan[TARGET], 0.0, plan[TARGET]
    m.counts[FRESH] = 0
    m.clock[END], status = ramp + plan[DWELL], RUNNING
    while status == RUNNING and m.counts[ACCEPTED] < plan[BUDGET]:
        status = integrate(rhs, switch, nodes, watch, p, t, powers, quiet, m, long, a, LOOK)
    # measure both halves of a window, and once more as long as they differ
    looking = status == FINISHED
    while looking:
        begin, length = m.clock[TIME], plan[WINDOW]
        w.spent[2] = 0.0
        for k in range(radii - 1):
            w.forward[k, 0], w.forward[k, 1] = 0.0, 0.0
        for i in range(count):
            w.ends[0, i] = m.state[BALLS + i]
        for half in range(2):
            for k in range(radii):
                w.greatest[half, k] = 0.0
            for i in range(count):
                w.low[half, i], w.high[half, i] = math.inf, -math.inf
            m.clock[END], status = begin + 0.5 * (half + 1) * length, RUNNING
            while status == RUNNING and m.counts[ACCEPTED] < plan[BUDGET]:
                left, taken, before = m.clock[TIME], m.counts[ACCEPTED], a.tallies[LONG_STEPS]
                status = integrate(rhs, switch, nodes, watch, p, t, powers, dense, m, long, a, 1)
                if a.tallies[LONG_STEPS] > before:
                    _note_pieces(left, begin, length, half, parameters, seen_long, by_powers)
                elif m.counts[ACCEPTED] > taken:
                    note(left, begin, length, half, parameters, seen)
            if status != FINISHED:
                return status
        for i in range(count):
            w.ends[1, i] = m.state[BALLS + i]
        old, new = 0.0, 0.0
        for k in range(radii - 1):
            w.forward[k, 0] /= w.spent[2]
            w.forward[k, 1] /= w.spent[2]
            old += w.weights[k] * w.greatest[0, k]
            new += w.weights[k] * w.greatest[1, k]
        w.spent[1] = (new - old) / max(old, new) if new > 0.0 else 0.0
        late = m.clock[TIME] - ramp + length > plan[LIMIT]
        looking = plan[SETTLED] >= 0.0 and abs(w.spent[1]) > plan[SETTLED] and not late
    return status
