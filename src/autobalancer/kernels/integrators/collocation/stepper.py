"""Long steps: the forces on the rotor's modes and the motion of the balls by collocation at eight Radau nodes.

A fixed-point iteration finds the values at all nodes of a step at once; it begins with the forces of the last step continued,
and the modes themselves are integrated exactly about a frozen speed. So a step is as long as the forces are smooth, however
fast the modes turn. The method is of order 15 at the end of a step and of order 8 inside.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from numba import int64, njit

from autobalancer.kernels.flags import COMPILED, MERGED
from autobalancer.kernels.host.drive import enter_segment
from autobalancer.kernels.integrators.collocation.amplitudes import (
    DECAY_KNOWN,
    FROZEN,
    FROZEN_BEFORE,
    FROZEN_KNOWN,
    LENGTH_BEFORE,
    LENGTH_KNOWN,
    LONG_STEPS,
    RENEWED,
    SWEEPS,
    UNSETTLED,
    Amplitudes,
    amplitudes_type,
    nodes_type,
    watch_type,
)
from autobalancer.kernels.integrators.collocation.bases import take_basis
from autobalancer.kernels.integrators.collocation.exponentials import decay, exponentials
from autobalancer.kernels.integrators.collocation.inside import pieces_needed, values_inside, write_piece
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
from autobalancer.kernels.integrators.tableau import Tableau, tableau_type
from autobalancer.kernels.pointers import address, data, plain
from autobalancer.kernels.system import BALLS, SPEED, THETA, System, system_type
from autobalancer.kernels.wide import NODES, load, store, total

OTHER_FORCES = 5  # another end of a call, beside those of the explicit pairs
KAPPA = 0.001  # the iteration ends where its error is this share of the tolerance
MOST_SWEEPS = 12
RENEW = 0.1  # rad: so far may the frame turn against the frozen speed in a step
STRICT = 1.0  # the estimate is of a lower order than the step; it is multiplied by this
SMALLEST = 1e-8  # of the error of a step, so that the next one is not longer without limit


@njit(**MERGED)
def _weigh(a: Any, m: Any) -> None:
    """Inverse tolerances of all rows of values, and the amplitudes at the begin of the step."""
    size, weights, shapes, inverse = 2 * a.modes, data(a.weights), data(a.shapes), data(a.inverse)
    for q in range(size):
        weights[q] = 0.0
        number = 0.0
        for k in range(size):
            number += inverse[q * size + k] * m.start[a.places[k]]
        a.begin[q] = number
    for k in range(0, size, 2):
        one, other = a.places[k], a.places[k + 1]
        length = math.sqrt(m.start[one] ** 2 + m.start[other] ** 2)
        sharp = 1.0 / min(m.absolute[one] + m.relative[one] * length, m.absolute[other] + m.relative[other] * length)
        for q in range(size):
            weights[q] = max(weights[q], max(abs(shapes[k * size + q]), abs(shapes[(k + 1) * size + q])) * sharp)
    weights[size] = 1.0 / m.absolute[SPEED]
    weights[size + 1] = 1.0 / m.absolute[THETA]
    for i in range(2 * a.balls):
        weights[size + 2 + i] = 1.0 / m.absolute[BALLS + i]


@njit(**MERGED)
def _know_modes(step: float, a: Any) -> None:
    """Factors and sums of all modes for this step and the frozen speed, unless they are known."""
    frozen = a.held[FROZEN]
    if step == a.held[LENGTH_KNOWN] and frozen == a.held[FROZEN_KNOWN]:
        return
    for mode in range(a.modes):
        real = a.exponents[2 * mode] * step
        if step != a.held[DECAY_KNOWN]:
            decay(mode, real, a)
        exponentials(mode, real, (a.exponents[2 * mode + 1] - a.turning * frozen) * step, a)
    a.held[LENGTH_KNOWN] = a.held[DECAY_KNOWN] = step
    a.held[FROZEN_KNOWN] = frozen
    a.tallies[RENEWED] += 1


@njit(**MERGED)
def _error(step: float, a: Any) -> float:
    """How far the forces are from the polynomials through the nodes, in what it makes of the motion, in tolerances."""
    forces, weights, size, frozen = data(a.forces), data(a.weights), 2 * a.modes, a.held[FROZEN]
    top, worst = load(data(a.radau.top), 0), 0.0
    for q in range(size + 1 + a.balls):
        miss = abs(total(top * load(forces, q * NODES)))
        if q < size:
            mode = q - q % 2
            turn = a.exponents[mode + 1] - a.turning * frozen
            fast = math.sqrt(a.exponents[mode] ** 2 + turn * turn)
            miss *= (2.0 / fast if fast * step > 2.0 else step) * weights[q]
        elif q == size:
            miss *= step * weights[q]
        else:
            own = q + 1
            miss *= step * max(weights[own + a.balls], step * weights[own] / (2.0 * NODES))
        if not miss <= worst:  # also when it is not a number
            worst = miss
    return worst * STRICT


@njit(**MERGED)
def _end(a: Any, m: Any) -> None:
    """The state at the last node."""
    values, shapes, size, last = data(a.values), data(a.shapes), 2 * a.modes, NODES - 1
    for k in range(size):
        number = 0.0
        for q in range(size):
            number += shapes[k * size + q] * values[q * NODES + last]
        m.state[a.places[k]] = number
    m.state[SPEED], m.state[THETA] = values[size * NODES + last], values[(size + 1) * NODES + last]
    for i in range(2 * a.balls):
        m.state[BALLS + i] = values[(size + 2 + i) * NODES + last]


@njit(**MERGED)
def _remember(step: float, a: Any) -> None:
    """Forces and amplitudes of an accepted step, from which the next one is begun."""
    size = 2 * a.modes
    forces, before = data(a.forces), data(a.forces_before)
    for q in range(size + 1 + a.balls):
        store(load(forces, q * NODES), before, q * NODES)
    values, amplitudes = data(a.values), data(a.amplitudes_before)
    for q in range(size):
        store(load(values, q * NODES), amplitudes, q * NODES)
    a.held[LENGTH_BEFORE], a.held[FROZEN_BEFORE] = step, a.held[FROZEN]


@njit(
    int64(nodes_type, watch_type, system_type, tableau_type, record_type, memory_type, amplitudes_type, int64),
    **COMPILED,
)
def advance_long(
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
    unknowns = plain(inner)
    n, taken, quick = m.state.size, 0, 0.0
    for mode in range(a.modes):
        quick = max(quick, math.hypot(a.exponents[2 * mode], a.exponents[2 * mode + 1]))
    segments, now = p.drive.segments, p.drive.now
    while taken < budget:
        time, end = m.clock[TIME], m.clock[END]
        if time >= end:
            return FINISHED
        enter_segment(time, p.drive)
        stop = end
        if now[0] + 1 < segments.shape[0]:
            stop = min(stop, segments[now[0] + 1].start)
        if m.counts[FRESH] == 0:
            a.held[FROZEN] = m.state[SPEED]
            take_basis(inner)
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
        if abs(m.state[SPEED] - a.held[FROZEN]) * step > RENEW:
            a.held[FROZEN] = m.state[SPEED]
            take_basis(inner)
        _weigh(a, m)
        _know_modes(step, a)
        sweeps = 0
        if m.counts[FRESH] == 1:
            go_on(step, a.held[FROZEN] - a.held[FROZEN_BEFORE], a)
        else:
            stand(a, m)
            nodes(time, step, parameters, unknowns)
            sweeps += 1
        before, settled, count = math.inf, False, 0
        while count < MOST_SWEEPS:
            change = sweep(step, a, m)
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
            sweeps += 1
        a.tallies[SWEEPS] += sweeps
        m.counts[EVALUATIONS] += NODES * sweeps
        error = _error(step, a) if settled else math.inf
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
        _end(a, m)
        a.tallies[LONG_STEPS] += 1
        m.counts[ACCEPTED] += 1
        taken += 1
        components = wanted(time, reach, end, r, m)
        if components >= 0:
            pieces = pieces_needed(step, a)
            for piece in range(pieces):
                left, right = time + step * piece / pieces, time + step * (piece + 1) / pieces
                if piece == pieces - 1:
                    right = reach
                m.clock[TAKEN] = step / pieces
                if pieces == 1:
                    write_piece(data(a.values), step, inner, memory)
                else:
                    values_inside(piece, pieces, step, a, m)
                    write_piece(data(a.inside), step / pieces, inner, memory)
                ended = record(left, right, components, 1.0, kept, pair)
                if ended <= 1.0:
                    evaluate(ended, pair, data(m.state))
                    m.clock[TIME] = left + ended * step / pieces
                    m.counts[FRESH] = 0
                    return EVENT
                for i in range(n):
                    m.start[i] = a.reached[i]
        _remember(step, a)
        m.counts[FRESH] = 1
        m.clock[TIME] = reach
        growth = 0.9 * max(error, SMALLEST) ** (-1.0 / NODES)
        if count >= MOST_SWEEPS - 1:
            growth = min(growth, 0.9)
        growth = min(2.0, max(0.3, growth))
        if growth < 0.95 or growth > 1.2:
            m.clock[STEP] = step * growth
    return FINISHED if m.clock[TIME] >= m.clock[END] else RUNNING
