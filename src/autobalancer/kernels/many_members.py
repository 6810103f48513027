"""The loop over the members of an ensemble: each its own numbers, its own steps, events and end.

A member is a copy of the block of a fresh run, and a few words that are its own. Whatever an integration changes or remembers
lies in that block, so the member before leaves no trace.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import int64, types, void

from autobalancer.kernels.compiler.cache import njit
from autobalancer.kernels.compiler.flags import COMPILED
from autobalancer.kernels.compiler.numba_struct import with_numbers
from autobalancer.kernels.integrators.collocation import Amplitudes, amplitudes_type, nodes_type, watch_type
from autobalancer.kernels.integrators.collocation_stepper import integrate
from autobalancer.kernels.integrators.integrator_state import (
    ACCEPTED,
    EVALUATIONS,
    REJECTED,
    Memory,
    memory_type,
    switch_type,
)
from autobalancer.kernels.integrators.recording import Record, record_type
from autobalancer.kernels.integrators.runge_kutta import RUNNING, advance
from autobalancer.kernels.integrators.tableau import Tableau, tableau_type
from autobalancer.kernels.measures.record_series import collect_impacts
from autobalancer.kernels.measures.row import measure_row, start
from autobalancer.kernels.measures.workspace import MeasureInputs, Workspace, inputs_type, workspace_type
from autobalancer.kernels.system import Integers, Matrix, System, integers_type, matrix_type, rhs_type, system_type

LOOK = 4096  # steps between two looks at the impacts that were noted, and at the word to stop
STOP, DONE, FLAGS = range(3)  # places in the flags: whether to stop; how many members are done

words_type = types.Array(types.int64, 2, "C")


@njit(void(integers_type, integers_type, integers_type, words_type, int64), **COMPILED)
def load_member(block: Integers, fresh: Integers, places: Integers, words: Any, number: int) -> None:
    """Make the block that of a fresh run of a member."""
    for i in range(block.size):
        block[i] = fresh[i]
    for k in range(places.size):
        block[places[k]] = words[number, k]


@njit(
    void(
        system_type, record_type, memory_type, inputs_type, workspace_type, int64, int64, integers_type, matrix_type,
        matrix_type, words_type,
    ),
    **COMPILED,
)  # fmt: skip
def store_member(
    p: System,
    r: Record,
    m: Memory,
    g: MeasureInputs,
    d: Workspace,
    status: int,
    number: int,
    flags: Integers,
    rows: Matrix,
    states: Matrix,
    counts: Any,
) -> None:
    """Keep what a member leaves that is done."""
    measure_row(p, r, m, g, d, status, rows[number])
    counts[number, 0] = m.counts[ACCEPTED]
    counts[number, 1] = m.counts[REJECTED]
    counts[number, 2] = m.counts[EVALUATIONS]
    if states.shape[0] > 0:
        for i in range(m.state.size):
            states[number, i] = m.state[i]
    flags[DONE] += 1


@njit(
    void(
        rhs_type, switch_type, system_type, tableau_type, record_type, memory_type, inputs_type, workspace_type,
        integers_type, integers_type, integers_type, words_type, int64, int64, int64, integers_type,
        matrix_type, matrix_type, words_type,
    ),
    **COMPILED,
)  # fmt: skip
def run_members(
    rhs: Callable[[float, Any, Any, Any], None],
    switch: Callable[[int, float, Any, Any, Any], float],
    p: System,
    t: Tableau,
    r: Record,
    m: Memory,
    g: MeasureInputs,
    d: Workspace,
    block: Integers,
    fresh: Integers,
    places: Integers,
    words: Any,
    first: int,
    last: int,
    most: int,
    flags: Integers,
    rows: Matrix,
    states: Matrix,
    counts: Any,
) -> None:
    """Run the members from ``first`` to before ``last``, each to its end or for ``most`` steps.

    The arrays of ``p``, ``r``, ``m`` and ``g`` lie in ``block``; ``fresh``, ``places`` and ``words`` (members, places) say what
    it is for each of them. ``rows`` (members, measures + balls) get the measures, ``states`` the last states (or have no rows),
    ``counts`` (members, 3) the accepted and rejected steps and the evaluations: no accepted step where a member did not run.
    """
    for number in range(first, last):
        load_member(block, fresh, places, words, number)
        system = with_numbers(p, block, 0)
        start(d)
        status = RUNNING
        while status == RUNNING and m.counts[ACCEPTED] < most and flags[STOP] == 0:
            status = advance(rhs, switch, system, t, r, m, min(LOOK, most - m.counts[ACCEPTED]))
            collect_impacts(system, g, d)
        if status == RUNNING and m.counts[ACCEPTED] < most:
            return
        store_member(system, r, m, g, d, status, number, flags, rows, states, counts)


# The same loop over members for machines that are integrated in long steps.


@njit(
    void(
        rhs_type, switch_type, nodes_type, watch_type, tableau_type, memory_type, amplitudes_type, int64,
        system_type, tableau_type, record_type, memory_type, inputs_type, workspace_type,
        integers_type, integers_type, integers_type, words_type, int64, int64, int64, integers_type,
        matrix_type, matrix_type, words_type,
    ),
    **COMPILED,
)  # fmt: skip
def run_members_long(
    rhs: Callable[[float, Any, Any, Any], None],
    switch: Callable[[int, float, Any, Any, Any], float],
    nodes: Callable[[float, float, Any, Any], None],
    watch: Callable[[float, Any, Any], float],
    powers: Tableau,
    long: Memory,
    a: Amplitudes,
    first_number: int,
    p: System,
    t: Tableau,
    r: Record,
    m: Memory,
    g: MeasureInputs,
    d: Workspace,
    block: Integers,
    fresh: Integers,
    places: Integers,
    words: Any,
    first: int,
    last: int,
    most: int,
    flags: Integers,
    rows: Matrix,
    states: Matrix,
    counts: Any,
) -> None:
    """As :func:`autobalancer.kernels.many_members.run_members`; the plain numbers of ``a`` begin at ``first_number``."""
    for number in range(first, last):
        load_member(block, fresh, places, words, number)
        system, own = with_numbers(p, block, 0), with_numbers(a, block, first_number)
        start(d)
        status = RUNNING
        while status == RUNNING and m.counts[ACCEPTED] < most and flags[STOP] == 0:
            budget = min(LOOK, most - m.counts[ACCEPTED])
            status = integrate(rhs, switch, nodes, watch, system, t, powers, r, m, long, own, budget)
            collect_impacts(system, g, d)
        if status == RUNNING and m.counts[ACCEPTED] < most:
            return
        store_member(system, r, m, g, d, status, number, flags, rows, states, counts)
