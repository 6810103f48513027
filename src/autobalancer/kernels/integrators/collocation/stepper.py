"""Long steps: the forces on the rotor's modes and the motion of the balls by collocation at eight Radau nodes.

A fixed-point iteration finds the values at all nodes of a step at once; it begins with the forces of the last step continued,
and the modes themselves are integrated exactly about a frozen speed. So a step is as long as the forces are smooth, however
fast the modes turn. The method is of order 15 at the end of a step and of order 8 inside.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from numba import int64

from autobalancer.kernels.flags import COMPILED, njit
from autobalancer.kernels.host.drive import enter_segment
from autobalancer.kernels.integrators.collocation.amplitudes import (
    BEGINS,
    FROZEN,
    FROZEN_BEFORE,
    LONG_STEPS,
    SWEEPS,
    SWITCHES,
    UNSETTLED,
    Amplitudes,
    amplitudes_type,
    nodes_type,
    watch_type,
)
from autobalancer.kernels.integrators.collocation.bases import take_basis
from autobalancer.kernels.integrators.collocation.inside import pieces_needed, values_inside, write_piece
from autobalancer.kernels.integrators.collocation.parts import know_modes, remember, step_miss, weigh, write_end
from autobalancer.kernels.integrators.collocation.sweep import go_on, stand, sweep
from autobalancer.kernels.integrators.dense import evaluate
from autobalancer.kernels.integrators.memory import (
    ACCEPTED,
    END,
    EVALUATIONS,
    FRESH,
    LONGEST,
    REJECTED,
    STEP,
    TAKEN,
    TIME,
    Memory,
    memory_type,
)
from autobalancer.kernels.integrators.record import Record, record, record_type, wanted
from autobalancer.kernels.integrators.runge_kutta import EVENT, FINISHED, NOT_FINITE, RUNNING, STEP_TOO_SMALL
from autobalancer.kernels.integrators.switching import CUT, DUE, PASS, TAKE, switch_type
from autobalancer.kernels.integrators.tableau import Tableau, tableau_type
from autobalancer.kernels.pointers import address, data, plain
from autobalancer.kernels.system import SPEED, System, rhs_type, system_type
from autobalancer.kernels.wide import NODES

OTHER_FORCES = 5  # another end of a call, beside those of the explicit pairs
KAPPA = 0.001  # the iteration ends where its error is this share of the tolerance
MOST_SWEEPS = 12
RENEW = (
    0.05  # rad: so far may the frame turn in a step against the frozen speed, if the middle of the step has that one
)
INSIDE = 1.0 - 1e-12  # of a step that a switch ends
SMALLEST = 1e-8  # of the error of a step, so that the next one is not longer without limit


@njit(
    int64(
        rhs_type, switch_type, nodes_type, watch_type, system_type, tableau_type, record_type, memory_type,
        amplitudes_type, int64,
    ),
    **COMPILED,
)  # fmt: skip
def advance_long(
    rhs: Callable[[float, Any, Any, Any], None],
    switch: Callable[[int, float, Any, Any, Any], float],
    nodes: Callable[[float, float, Any, Any], None],
    watch: Callable[[float, Any, Any], float],
    p: System,
    t: Tableau,
    r: Record,
    m: Memory,
    a: Amplitudes,
    budget: int,
) -> int:
    """Take up to ``budget`` accepted steps towards ``m.clock[END]``; returns how that ended.

    ``t`` is :func:`autobalancer.kernels.integrators.collocation.inside.by_powers`. OTHER_FORCES says that the forces change
    now: the explicit pair has to go on from here. Calling it again goes on where it stopped, to the last bit as if it had
    never stopped.
    """
    parameters, pair, kept, inner, memory = plain(address(p)), address((t, m)), address(r), address(a), address(m)
    unknowns, asked = plain(inner), plain(pair)
    n, taken, quick = m.state.size, 0, 0.0
    for mode in range(a.modes):
        quick = max(quick, math.hypot(a.exponents[2 * mode], a.exponents[2 * mode + 1]))
    segments, now = p.drive.segments, p.drive.now
    while taken < budget:
        time, end = m.clock[TIME], m.clock[END]
        if time >= end:
            return FINISHED
        anew = enter_segment(time, p.drive)
        stop = end
        if now[0] + 1 < segments.shape[0]:
            stop = min(stop, segments[now[0] + 1].start)
        if anew or m.counts[FRESH] == 0:
            switch(TAKE, time, rhs, parameters, asked)
        if m.counts[FRESH] == 0:
            a.held[FROZEN] = m.state[SPEED]
            take_basis(inner)
            for row in range(a.rates.size):
                a.rates[row] = 0.0
            if m.clock[STEP] == 0.0:
                m.clock[STEP] = min(0.5 / (abs(m.state[SPEED]) + quick), stop - time)
        step, left = min(m.clock[STEP], m.clock[LONGEST]), stop - time
        reach = time + step
        if step >= 0.999 * left:
            reach, step = stop, left
        elif step > 0.5 * left:  # two equal steps to a corner, not a long one and a short one
            step = 0.5 * left
            reach = time + step
        m.clock[TAKEN] = step
        for i in range(n):
            m.start[i] = a.origin[i] = m.state[i]
        middle = m.state[SPEED]
        if m.counts[FRESH] == 1:
            middle += 0.5 * step * a.forces_before[(2 * a.modes + 1) * NODES - 1]
        if abs(middle - a.held[FROZEN]) * step > RENEW:
            a.held[FROZEN] = middle
            take_basis(inner)
        weigh(a, m)
        know_modes(step, a)
        sweeps, found = 0, m.counts[FRESH] == 0
        if found:
            stand(a, m)
            nodes(time, step, parameters, unknowns)
            sweeps += 1
        else:
            go_on(step, a.held[FROZEN] - a.held[FROZEN_BEFORE], a)
        before, settled, count = math.inf, False, 0
        while count < MOST_SWEEPS:
            change = sweep(found, step, a, m)
            count += 1
            if count > 1:
                if not change < math.inf or (count > 2 and change > 2.0 * before):
                    break
                shrink = min(change / before, 1.0) if count > 2 and before > 0.0 else 0.2
                if change * shrink < KAPPA:
                    settled = True
                    break
                before = change
            nodes(time, step, parameters, unknowns)
            sweeps, found = sweeps + 1, True
        a.tallies[SWEEPS] += sweeps
        m.counts[EVALUATIONS] += NODES * sweeps
        error = step_miss(step, a) if settled else math.inf
        if not error <= 1.0:
            m.counts[REJECTED] += 1
            if settled:
                m.clock[STEP] = step * max(0.2, 0.85 * error ** (-1.0 / NODES))
            else:
                a.tallies[UNSETTLED] += 1
                m.clock[STEP] = 0.5 * step
            if not m.clock[STEP] >= 4e-16 * max(abs(time), 1e-3):
                for i in range(a.forces.size):
                    if not math.isfinite(a.forces[i]):
                        return NOT_FINITE
                return STEP_TOO_SMALL
            continue
        until = watch(step, parameters, unknowns)
        if until < 1.0:
            if until * step < 1.0 / (abs(m.state[SPEED]) + quick):
                return OTHER_FORCES
            m.counts[REJECTED] += 1
            m.clock[STEP] = until * step
            continue
        write_end(a, m)
        a.tallies[LONG_STEPS] += 1
        m.counts[ACCEPTED] += 1
        taken += 1
        cut, components = 1.0, wanted(time, reach, end, r, m)
        if components >= 0 or until == SWITCHES:
            pieces, piece = pieces_needed(step, a), 0
            length = step / pieces
            m.clock[TAKEN] = length
            while piece < pieces and cut == 1.0:
                left, right, limit = time + step * piece / pieces, time + step * (piece + 1) / pieces, 1.0
                if piece == pieces - 1:
                    right = reach
                if pieces == 1:
                    write_piece(data(a.values), length, inner, memory)
                else:
                    values_inside(piece, pieces, step, a, m)
                    write_piece(data(a.inside), length, inner, memory)
                if until == SWITCHES:
                    for i in range(n):
                        m.state[i] = a.reached[i]
                    due = switch(DUE, left, rhs, parameters, asked) != 0.0
                    limit = switch(CUT, left, rhs, parameters, asked)
                    if due or limit < 1.0:
                        cut = min((piece + limit) / pieces, INSIDE)
                if components >= 0:
                    ended = record(left, right, components, limit, kept, pair)
                    if ended <= 1.0:
                        evaluate(ended, pair, data(m.state))
                        m.clock[TIME] = left + ended * length
                        m.counts[FRESH] = 0
                        return EVENT
                if cut < 1.0:
                    evaluate(limit, pair, data(m.state))
                    reach = right if limit == 1.0 else left + limit * length
                else:
                    for i in range(n):
                        m.start[i] = a.reached[i]
                piece += 1
        remember(step, a)
        m.counts[FRESH] = 1
        m.clock[TIME] = reach
        a.held[BEGINS] = cut
        if cut < 1.0:  # the forces of this step are still a good begin of the next one
            switch(PASS, reach, rhs, parameters, asked)
            switch(TAKE, reach, rhs, parameters, asked)
            continue
        growth = 0.9 * max(error, SMALLEST) ** (-1.0 / NODES)
        if count >= MOST_SWEEPS - 1:
            growth = min(growth, 0.9)
        growth = min(2.0, max(0.3, growth))
        if growth < 0.95 or growth > 1.2:
            m.clock[STEP] = step * growth
    return FINISHED if m.clock[TIME] >= m.clock[END] else RUNNING
