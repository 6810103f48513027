"""The loop over the members of an ensemble: each its own numbers, its own steps, events and end.

A member is a copy of the block of a fresh run, and a few words that are its own. Whatever an integration changes or remembers
lies in that block, so the member before leaves no trace.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from numba import int64, types, void

from autobalancer.kernels.compiler.flags import COMPILED, njit
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
from autobalancer.kernels.system import Integers, Matrix, System, rhs_type, system_type, tuple_type

LOOK = 4096  # steps between two looks at the impacts that were noted, and at the word to stop
STOP, DONE, FLAGS = range(3)  # places in the flags: whether to stop; how many members are done

words_type = types.Array(types.int64, 2, "C")


class Members(NamedTuple):
    """Members that one thread runs in its block, in which the arrays of the system, its record and its memory lie."""

    block: Integers  # words of the member that runs
    fresh: Integers  # those of a run that has not begun
    places: Integers  # where members differ from it,
    words: Any  # (members, places) and what stands there
    most: int  # steps of each
    flags: Integers  # STOP, DONE
    numbers_of_steps: int  # where the plain numbers of the long steps begin in the block


class Found(NamedTuple):
    """What members of one layout leave, a row for each."""

    rows: Matrix  # (members, measures + balls)
    states: Matrix  # (members, states) at the end, or (0, 0)
    counts: Any  # (members, 3) accepted, rejected, evaluations; no accepted step: it did not run

    def part(self, members: range) -> Found:
        """Room for some of them."""
        where = slice(members.start, members.stop)
        return Found(*(whole[where] for whole in self))


members_type = tuple_type(Members, words=words_type)
found_type = tuple_type(Found, counts=words_type)
measures_type = types.Tuple((inputs_type, workspace_type))
Measures = tuple[MeasureInputs, Workspace]


@njit(void(members_type, int64), **COMPILED)
def load_member(members: Members, number: int) -> None:
    """Make the block that of a fresh run of a member."""
    for i in range(members.block.size):
        members.block[i] = members.fresh[i]
    for k in range(members.places.size):
        members.block[members.places[k]] = members.words[number, k]


@njit(
    void(system_type, record_type, memory_type, measures_type, int64, int64, members_type, found_type), **COMPILED
)  # fmt: skip
def store_member(
    p: System, r: Record, m: Memory, measures: Measures, status: int, number: int, members: Members, found: Found
) -> None:
    """Keep what a member leaves that is done."""
    g, d = measures
    measure_row(p, r, m, g, d, status, found.rows[number])
    found.counts[number, 0] = m.counts[ACCEPTED]
    found.counts[number, 1] = m.counts[REJECTED]
    found.counts[number, 2] = m.counts[EVALUATIONS]
    if found.states.shape[0] > 0:
        for i in range(m.state.size):
            found.states[number, i] = m.state[i]
    members.flags[DONE] += 1


@njit(
    void(
        rhs_type, switch_type, system_type, tableau_type, record_type, memory_type, measures_type, members_type, found_type
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
    measures: Measures,
    members: Members,
    found: Found,
) -> None:
    """Run the members, each to its end or for as many steps as it may take, and write down what they leave."""
    g, d = measures
    for number in range(members.words.shape[0]):
        load_member(members, number)
        system = with_numbers(p, members.block, 0)
        start(d)
        status = RUNNING
        while status == RUNNING and m.counts[ACCEPTED] < members.most and members.flags[STOP] == 0:
            status = advance(rhs, switch, system, t, r, m, min(LOOK, members.most - m.counts[ACCEPTED]))
            collect_impacts(system, g, d)
        if status == RUNNING and m.counts[ACCEPTED] < members.most:
            return
        store_member(system, r, m, measures, status, number, members, found)


# The same loop over members for machines that are integrated in long steps.


@njit(
    void(
        rhs_type, switch_type, nodes_type, watch_type, system_type, types.UniTuple(tableau_type, 2), record_type,
        types.UniTuple(memory_type, 2), amplitudes_type, measures_type, members_type, found_type,
    ),
    **COMPILED,
)  # fmt: skip
def run_members_long(
    rhs: Callable[[float, Any, Any, Any], None],
    switch: Callable[[int, float, Any, Any, Any], float],
    nodes: Callable[[float, float, Any, Any], None],
    watch: Callable[[float, Any, Any], float],
    p: System,
    tableaus: tuple[Tableau, Tableau],
    r: Record,
    memories: tuple[Memory, Memory],
    a: Amplitudes,
    measures: Measures,
    members: Members,
    found: Found,
) -> None:
    """As :func:`autobalancer.kernels.many_members.run_members`; tableaus and memories are those of the pair and of long steps."""
    (g, d), (t, powers), (m, long) = measures, tableaus, memories
    for number in range(members.words.shape[0]):
        load_member(members, number)
        system = with_numbers(p, members.block, 0)
        own = with_numbers(a, members.block, members.numbers_of_steps)
        start(d)
        status = RUNNING
        while status == RUNNING and m.counts[ACCEPTED] < members.most and members.flags[STOP] == 0:
            budget = min(LOOK, members.most - m.counts[ACCEPTED])
            status = integrate(rhs, switch, nodes, watch, system, t, powers, r, m, long, own, budget)
            collect_impacts(system, g, d)
        if status == RUNNING and m.counts[ACCEPTED] < members.most:
            return
        store_member(system, r, m, measures, status, number, members, found)
