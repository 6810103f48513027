"""A rotor is brought to a speed, held there until transients have died, and measured over a window.

In long steps where the machine takes them, with the explicit pair where it does not, as any run.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from numba import int64

from autobalancer.kernels.dwell.window import Window, note, window_type
from autobalancer.kernels.flags import COMPILED, PART, njit
from autobalancer.kernels.integrators.collocation.amplitudes import (
    BASIS,
    HELD,
    LENGTH_BEFORE,
    LONG_STEPS,
    TALLIES,
    Amplitudes,
    amplitudes_type,
    nodes_type,
    watch_type,
)
from autobalancer.kernels.integrators.collocation.bases import OF_EXPONENTS
from autobalancer.kernels.integrators.collocation.inside import pieces_needed, values_inside, write_piece
from autobalancer.kernels.integrators.collocation.march import march
from autobalancer.kernels.integrators.dense import polynomials
from autobalancer.kernels.integrators.memory import (
    ACCEPTED,
    COUNTS,
    END,
    ERROR,
    FRESH,
    STEP,
    TAKEN,
    TIME,
    Memory,
    memory_type,
)
from autobalancer.kernels.integrators.record import Record, record_type
from autobalancer.kernels.integrators.runge_kutta import FINISHED, RUNNING
from autobalancer.kernels.integrators.switching import FORGET, switch_type
from autobalancer.kernels.integrators.tableau import Tableau, tableau_type
from autobalancer.kernels.pointers import address, behind, data, plain
from autobalancer.kernels.system import BALLS, SPEED, Floats, System, rhs_type, system_type, vector_type

# places in the plan: speed to go to, rate of the way there (infinite: at once), time before and length of the window,
# relative change between its halves that counts as settled (negative: never look), longest time at the speed, steps
TARGET, RATE, DWELL, WINDOW, SETTLED, LIMIT, BUDGET, PLAN = range(8)
LOOK = 5_000  # steps between two looks at the budget
FIRST = 0.1  # rad of rotor angle in the first step at a speed


@njit(**PART)
def _forget(by_powers):  # type: ignore[no-untyped-def]
    """Nothing of an earlier speed is left in what long steps remember, so that each begins as if it were the first."""
    _, _, a = behind(by_powers)
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
    powers, long, a = behind(by_powers)
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
            write_piece(data(a.values), step, inner, memory)
        else:
            values_inside(piece, pieces, step, a, long)
            write_piece(data(a.inside), step / pieces, inner, memory)
        polynomials(long.state.size, powers, long)
        note(left, begin, length, half, parameters, seen)
        for i in range(long.state.size):
            long.start[i] = a.reached[i]


@njit(
    int64(
        rhs_type, switch_type, nodes_type, watch_type, system_type, tableau_type, tableau_type, record_type, record_type,
        memory_type, memory_type, amplitudes_type, window_type, vector_type,
    ),
    **COMPILED,
)  # fmt: skip
def hold(
    rhs: Callable[[float, Any, Any, Any], None],
    switch: Callable[[int, float, Any, Any, Any], float],
    nodes: Callable[[float, float, Any, Any], None],
    watch: Callable[[float, Any, Any], float],
    p: System,
    t: Tableau,
    powers: Tableau,
    quiet: Record,
    dense: Record,
    m: Memory,
    long: Memory,
    a: Amplitudes,
    w: Window,
    plan: Floats,
) -> int:
    """Bring ``m.state`` to the speed of the plan, hold, measure; returns how the integration ended.

    ``p`` has one segment. The clock and the steps begin anew, so that the end depends on the state and the plan only.
    ``dense`` makes the stepper keep the dense output of all components, ``quiet`` of none. The memories and amplitudes are those
    of :func:`autobalancer.kernels.integrators.collocation.march.march`.
    """
    n, count, radii = m.state.size, p.ball_count, w.weights.size + 1
    parameters, segment = plain(address(p)), p.drive.segments[0]
    seen, seen_long, by_powers = address((m, w)), address((long, w)), address((powers, long, a))
    for i in range(COUNTS):
        m.counts[i] = 0
    _forget(by_powers)
    switch(FORGET, 0.0, rhs, parameters, plain(address((t, m))))
    # a small part of a turn: at a motion that hardly changes in the rotor a guess from rates would be far too long
    m.clock[TIME], m.clock[STEP], m.clock[ERROR] = 0.0, FIRST / abs(plan[TARGET]), 1.0
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
            status = march(rhs, switch, nodes, watch, p, t, powers, quiet, m, long, a, LOOK)
    w.spent[0] = ramp
    if status != FINISHED:
        return status
    segment.value, segment.rate, m.state[SPEED] = plan[TARGET], 0.0, plan[TARGET]
    m.counts[FRESH] = 0
    m.clock[END], status = ramp + plan[DWELL], RUNNING
    while status == RUNNING and m.counts[ACCEPTED] < plan[BUDGET]:
        status = march(rhs, switch, nodes, watch, p, t, powers, quiet, m, long, a, LOOK)
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
                status = march(rhs, switch, nodes, watch, p, t, powers, dense, m, long, a, 1)
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
