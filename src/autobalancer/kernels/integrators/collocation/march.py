"""Long steps where they win, and the explicit pair where it does.

The pair takes over where the forces on the balls change, as in a contact, and where it gets further for the same work. Its
step is known without taking one: the error of a trial says how long it could be. After a while long steps are tried again;
the while is doubled as long as they fail.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from numba import int64

from autobalancer.kernels.flags import COMPILED, MERGED, PART, njit
from autobalancer.kernels.integrators.collocation.amplitudes import (
    CHUNK,
    EXPLICIT,
    HANDED,
    IN_A_ROW,
    LEFT,
    PAIR_STEP,
    SINCE,
    SWEEPS,
    SWEEPS_THEN,
    Amplitudes,
    amplitudes_type,
    nodes_type,
    watch_type,
)
from autobalancer.kernels.integrators.collocation.stepper import OTHER_FORCES, advance_long
from autobalancer.kernels.integrators.memory import (
    ACCEPTED,
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
from autobalancer.kernels.integrators.runge_kutta import FINISHED, RUNNING, advance, do_stages, step_error
from autobalancer.kernels.integrators.switching import switch_type
from autobalancer.kernels.integrators.tableau import Tableau, tableau_type
from autobalancer.kernels.pointers import address, behind, data, plain
from autobalancer.kernels.system import SPEED, System, rhs_type, system_type

SHORTEST_CHUNK, LONGEST_CHUNK = 50, 1600  # steps of the pair before long ones are tried again
LOOK = 64  # long steps between two looks at what the pair would do
# in evaluations of the right-hand side
PER_SWEEP = 2.4
PER_STEP = 6.0
WORTH = 0.9  # long steps are kept unless the pair needs less than this share of their work


@njit(**PART)
def _trial_step(rhs, guess, parameters, pair):  # type: ignore[no-untyped-def]
    """The step that the pair would take now; the state stays."""
    t, m = behind(pair)
    for i in range(m.state.size):
        m.start[i] = m.state[i]
    rhs(m.clock[TIME], data(m.start), data(m.stages), parameters)
    m.clock[TAKEN] = guess
    do_stages(1, t.main, rhs, parameters, pair)
    error = step_error(pair)
    if not error < math.inf:
        return 0.1 * guess
    return guess * min(4.0, max(0.1, 0.9 * max(error, 1e-6) ** (-1.0 / t.order)))


@njit(**MERGED)
def _hand_to_pair(m: Memory, a: Amplitudes) -> None:
    """From now on the pair, for as many steps as is worth it."""
    if a.tallies[IN_A_ROW] >= 2 * LOOK:
        a.tallies[CHUNK] = SHORTEST_CHUNK
    else:
        a.tallies[CHUNK] = min(2 * max(a.tallies[CHUNK], SHORTEST_CHUNK // 2), LONGEST_CHUNK)
    a.tallies[LEFT] = a.tallies[CHUNK]
    a.tallies[EXPLICIT] = 1
    a.tallies[HANDED] += 1
    m.counts[FRESH] = 0
    m.clock[STEP], m.clock[ERROR] = a.held[PAIR_STEP], 1.0


@njit(
    int64(
        rhs_type, switch_type, nodes_type, watch_type, system_type, tableau_type, tableau_type, record_type,
        memory_type, memory_type, amplitudes_type, int64,
    ),
    **COMPILED,
)  # fmt: skip
def march(
    rhs: Callable[[float, Any, Any, Any], None],
    switch: Callable[[int, float, Any, Any, Any], float],
    nodes: Callable[[float, float, Any, Any], None],
    watch: Callable[[float, Any, Any], float],
    p: System,
    t: Tableau,
    powers: Tableau,
    r: Record,
    m: Memory,
    long: Memory,
    a: Amplitudes,
    budget: int,
) -> int:
    """Take up to ``budget`` accepted steps towards ``m.clock[END]``, as :func:`advance` does.

    ``m`` is a memory for the pair ``t``, ``long`` the same one with work arrays for ``powers``. Without modes there are only
    steps of the pair.
    """
    if a.modes == 0:
        return advance(rhs, switch, p, t, r, m, budget)
    parameters, pair = plain(address(p)), address((t, m))
    last = m.counts[ACCEPTED] + budget
    while m.counts[ACCEPTED] < last:
        before, left = m.counts[ACCEPTED], last - m.counts[ACCEPTED]
        if a.tallies[EXPLICIT] == 1:
            status = advance(rhs, switch, p, t, r, m, min(left, a.tallies[LEFT]))
            a.tallies[LEFT] -= m.counts[ACCEPTED] - before
            if status != RUNNING:
                return status
            if a.tallies[LEFT] == 0:
                a.tallies[EXPLICIT] = a.tallies[IN_A_ROW] = 0
                m.counts[FRESH] = 0
                a.held[PAIR_STEP] = m.clock[STEP]
                a.held[SINCE], a.tallies[SWEEPS_THEN] = m.clock[TIME], a.tallies[SWEEPS]
            continue
        if a.tallies[IN_A_ROW] == 0:
            a.held[SINCE], a.tallies[SWEEPS_THEN] = m.clock[TIME], a.tallies[SWEEPS]
            if not a.held[PAIR_STEP] > 0.0:
                a.held[PAIR_STEP] = 1.0 / (abs(m.state[SPEED]) + math.hypot(a.exponents[0], a.exponents[1]))
        status = advance_long(
            rhs, switch, nodes, watch, p, powers, r, long, a, min(left, LOOK - a.tallies[IN_A_ROW] % LOOK)
        )
        a.tallies[IN_A_ROW] += m.counts[ACCEPTED] - before
        if status == OTHER_FORCES:
            _hand_to_pair(m, a)
        elif status != RUNNING:
            return status
        elif a.tallies[IN_A_ROW] % LOOK == 0:
            work = PER_SWEEP * (a.tallies[SWEEPS] - a.tallies[SWEEPS_THEN]) + PER_STEP * LOOK
            covered = m.clock[TIME] - a.held[SINCE]
            a.held[PAIR_STEP] = _trial_step(rhs, a.held[PAIR_STEP], parameters, pair)
            a.held[SINCE], a.tallies[SWEEPS_THEN] = m.clock[TIME], a.tallies[SWEEPS]
            if (t.main - 1) * covered < WORTH * work * a.held[PAIR_STEP]:
                _hand_to_pair(m, a)
    return RUNNING if m.clock[TIME] < m.clock[END] else FINISHED
