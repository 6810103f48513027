"""One adaptive stepper for every explicit pair and every right-hand side and switch with the same parameters.

Step control is proportional-integral (Hairer and Wanner 1996, section IV.2). The right-hand side comes as a
function type and the pair as numbers, so one compiled function, kept in the cache, serves all.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from numba import int64

from autobalancer.kernels.compiler.flags import COMPILED, INLINE, PART, njit
from autobalancer.kernels.compiler.numba_struct import address, as_void, data, deref
from autobalancer.kernels.compiler.simd import LANES, add_product, lanes, put
from autobalancer.kernels.host.shaft_train import enter_segment, next_corner
from autobalancer.kernels.integrators.dense_output import evaluate, sums
from autobalancer.kernels.integrators.integrator_state import (
    ACCEPTED,
    CUT,
    DUE,
    END,
    ERROR,
    EVALUATIONS,
    FORGET,
    FRESH,
    LONGEST,
    PASS,
    REJECTED,
    SHORTEST,
    STEP,
    TAKE,
    TAKEN,
    TIME,
    Memory,
    memory_type,
    switch_type,
)
from autobalancer.kernels.integrators.recording import Record, components_needed, record, record_type
from autobalancer.kernels.integrators.tableau import Tableau, tableau_type
from autobalancer.kernels.system import System, rhs_type, system_type

RUNNING, FINISHED, EVENT, STEP_TOO_SMALL, NOT_FINITE = range(5)
HUGE = 1e300  # squares of errors that leave room for sums of them


@njit(**PART)
def do_stages(first, last, rhs, p, pair):  # type: ignore[no-untyped-def]
    t, m = deref(pair)
    start, trial, step = data(m.start), data(m.trial), m.clock[TAKEN]
    for stage in range(first, last):
        for i in range(0, m.trial.size, LANES):
            state = lanes()
            add_product(state, 1.0, start, i)
            add_product(state, step, sums(stage, i, t, m), 0)
            put(state, trial, i)
        rhs(m.clock[TIME] + t.nodes[stage] * step, trial, data(m.stages[stage]), p)
    m.counts[EVALUATIONS] += last - first


@njit(**PART)
def step_error(pair):  # type: ignore[no-untyped-def]
    """Weighted error of the step; ``m.trial`` holds the new state."""
    t, m = deref(pair)
    start, trial, absolute, relative = data(m.start), data(m.trial), data(m.absolute), data(m.relative)
    fine, coarse = 0.0, 0.0
    for i in range(0, m.trial.size, LANES):
        estimate, correction = sums(t.total, i, t, m), sums(t.total + 1, i, t, m)
        for k in range(LANES):
            weight = 1.0 / (absolute[i + k] + relative[i + k] * max(abs(start[i + k]), abs(trial[i + k])))
            fine += (estimate[k] * weight) ** 2
            coarse += (correction[k] * weight) ** 2
    if fine == 0.0:
        return 0.0
    if not fine + coarse < HUGE:  # else a step into nowhere would count as exact: infinite is the square root below
        return math.inf
    return m.clock[TAKEN] * fine / math.sqrt((fine + 0.01 * coarse) * m.state.size)


@njit(**PART)
def _first_step(pair):  # type: ignore[no-untyped-def]
    """A step over which the state changes by about a hundredth of its own weight (Hairer et al. 1993, II.4)."""
    _, m = deref(pair)
    size, rate = 0.0, 0.0
    for i in range(m.state.size):
        weight = 1.0 / (m.absolute[i] + m.relative[i] * abs(m.state[i]))
        size += (m.state[i] * weight) ** 2
        rate += (m.stages[0, i] * weight) ** 2
    left = m.clock[END] - m.clock[TIME]
    ratio = size / rate
    if size < 1e-10 or rate < 1e-10 or not math.isfinite(ratio):
        return 1e-6 * left
    return min(0.01 * math.sqrt(ratio), left)


@njit(**INLINE)
def _retreat(step: float, shortest: float, m: Memory) -> None:
    """Go back to the begin of a step that is too long to tell when the equations switch; the next is shorter."""
    for i in range(m.state.size):
        m.state[i] = m.start[i]
    m.counts[REJECTED] += 1
    m.counts[FRESH] = 0
    m.clock[STEP] = max(0.1 * step, shortest)


@njit(**INLINE)
def refuse(time: float, shorter: float, rates: Any, count: int, m: Memory) -> int:
    """Go on with a shorter step, unless time would not move: then the rates, or what takes their place, tell why."""
    m.counts[REJECTED] += 1
    m.clock[STEP] = shorter
    status = RUNNING
    if not shorter >= 4e-16 * max(abs(time), 1e-3):
        status = STEP_TOO_SMALL
        for i in range(count):
            if not math.isfinite(rates[i]):
                status = NOT_FINITE
    return status


@njit(**INLINE)
def _choose_next_step(step: float, error: float, order: float, m: Memory) -> None:
    """Proportional-integral control: the error before damps the change."""
    error = max(error, 1e-4)
    growth = 0.9 * error ** (-0.7 / order) * m.clock[ERROR] ** (0.4 / order)
    m.clock[STEP] = step * min(6.0, max(0.2, growth))
    m.clock[ERROR] = error


@njit(int64(rhs_type, switch_type, system_type, tableau_type, record_type, memory_type, int64), **COMPILED)
def advance(
    rhs: Callable[[float, Any, Any, Any], None],
    switch: Callable[[int, float, Any, Any, Any], float],
    p: System,
    t: Tableau,
    r: Record,
    m: Memory,
    budget: int,
) -> int:
    """Take up to ``budget`` accepted steps towards ``m.clock[END]``; returns how that ended.

    Calling it again goes on where it stopped, to the last bit as if it had never stopped.
    """
    parameters, pair, kept = as_void(address(p)), address((t, m)), address(r)
    asked, t, r, m = as_void(pair), deref(t), deref(r), deref(m)
    n, last = m.state.size, t.main - 1
    taken, held = 0, False
    while taken < budget:
        time, end = m.clock[TIME], m.clock[END]
        if time >= end:
            return FINISHED
        if enter_segment(time, p.drive):
            m.counts[FRESH] = 0
        stop = next_corner(end, p.drive)
        if m.counts[FRESH] == 0:
            switch(TAKE, time, rhs, parameters, asked)
            rhs(time, data(m.state), data(m.stages), parameters)
            m.counts[EVALUATIONS] += 1
            m.counts[FRESH] = 1
            if m.clock[STEP] == 0.0:
                m.clock[STEP] = _first_step(pair)
        # up to the end or the next corner of the drive, where the right-hand side has a jump
        step = min(m.clock[STEP], m.clock[LONGEST])
        reach = time + step
        if reach >= stop - 1e-3 * step:  # never leave a sliver before a corner
            reach, step = stop, stop - time
        m.clock[TAKEN] = step
        for i in range(n):
            m.start[i] = m.state[i]
        # the step, and its error in tolerances
        do_stages(int64(1), t.main, rhs, parameters, pair)
        error = step_error(pair)
        if not error <= 1.0:  # also when it is not a number
            shrink = 0.1 if not error < 1e8 else max(0.1, 0.9 * error ** (-1.0 / t.order))
            status = refuse(time, step * shrink, data(m.stages[last]), n, m)
            if status != RUNNING:
                return status
            continue
        for i in range(n):
            m.state[i] = m.trial[i]
        # a switch may end the step inside; only a record or a switch needs the further stages of the dense output
        ended, limit = 2.0, 1.0
        components = components_needed(time, reach, end, r, m)
        due = not held and switch(DUE, time, rhs, parameters, asked) != 0.0
        if components >= 0 or due:
            do_stages(t.main, t.total, rhs, parameters, pair)
            if due:
                limit = switch(CUT, time, rhs, parameters, asked)
                if limit == 0.0:
                    shortest = switch(SHORTEST, time, rhs, parameters, asked)
                    _retreat(step, shortest, m)
                    if step <= shortest:  # the shortest one: what is at rest stays so in it
                        switch(FORGET, time, rhs, parameters, asked)
                        held = True
                    continue
            if components >= 0:
                ended = record(time, reach, components, limit, kept, pair)
        m.counts[ACCEPTED] += 1
        taken += 1
        if ended <= 1.0:
            evaluate(ended, pair, data(m.state))
            m.clock[TIME] = time + ended * step
            m.counts[FRESH] = 0
            return EVENT
        if due:
            evaluate(limit, pair, data(m.state))
            m.clock[TIME] = reach if limit == 1.0 else time + limit * step
            switch(PASS, m.clock[TIME], rhs, parameters, asked)
            m.counts[FRESH] = 0
            continue
        m.clock[TIME] = reach
        if held:
            held = False
            m.counts[FRESH] = 0
        # the last stage is the first one of the next step
        for i in range(n):
            m.stages[0, i] = m.stages[last, i]
        _choose_next_step(step, error, t.order, m)
    return FINISHED if m.clock[TIME] >= m.clock[END] else RUNNING
