"""The same loop over members for machines that are integrated in long steps."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import int64, void

from autobalancer.kernels.ensemble.members import LOOK, STOP, become, words_type, write_down
from autobalancer.kernels.ensemble.numbers import with_numbers
from autobalancer.kernels.flags import COMPILED, njit
from autobalancer.kernels.integrators.collocation.amplitudes import (
    Amplitudes,
    amplitudes_type,
    nodes_type,
    watch_type,
)
from autobalancer.kernels.integrators.collocation.march import march
from autobalancer.kernels.integrators.memory import ACCEPTED, Memory, memory_type
from autobalancer.kernels.integrators.record import Record, record_type
from autobalancer.kernels.integrators.runge_kutta import RUNNING
from autobalancer.kernels.integrators.switching import switch_type
from autobalancer.kernels.integrators.tableau import Tableau, tableau_type
from autobalancer.kernels.measures.gauges import Desk, Gauges, desk_type, gauges_type
from autobalancer.kernels.measures.impacts import take_impacts
from autobalancer.kernels.measures.row import start
from autobalancer.kernels.system import Integers, Matrix, System, integers_type, matrix_type, rhs_type, system_type


@njit(
    void(
        rhs_type, switch_type, nodes_type, watch_type, tableau_type, memory_type, amplitudes_type, int64,
        system_type, tableau_type, record_type, memory_type, gauges_type, desk_type,
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
    g: Gauges,
    d: Desk,
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
    """As :func:`autobalancer.kernels.ensemble.members.run_members`; the plain numbers of ``a`` begin at ``first_number``."""
    for number in range(first, last):
        become(block, fresh, places, words, number)
        system, own = with_numbers(p, block, 0), with_numbers(a, block, first_number)
        start(d)
        status = RUNNING
        while status == RUNNING and m.counts[ACCEPTED] < most and flags[STOP] == 0:
            budget = min(LOOK, most - m.counts[ACCEPTED])
            status = march(rhs, switch, nodes, watch, system, t, powers, r, m, long, own, budget)
            take_impacts(system, g, d)
        if status == RUNNING and m.counts[ACCEPTED] < most:
            return
        write_down(system, r, m, g, d, status, number, flags, rows, states, counts)
