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

from autobalancer.kernels.compiler.flags import COMPILED, INLINE, MERGED, PART, njit
from autobalancer.kernels.compiler.numba_struct import address, as_void, data, deref
from autobalancer.kernels.compiler.simd import NODES
from autobalancer.kernels.host.shaft_train import enter_segment, next_corner
from autobalancer.kernels.integrators.collocation import (
    BEGINS,
    CHUNK,
    EXPLICIT,
    FROZEN,
    FROZEN_BEFORE,
    HANDED,
    IN_A_ROW,
    LEFT,
    LONG_STEPS,
    PAIR_STEP,
    SINCE,
    SWEEPS,
    SWEEPS_THEN,
    SWITCHES,
    UNSETTLED,
    Amplitudes,
    amplitudes_type,
    nodes_type,
    take_basis,
    watch_type,
)
from autobalancer.kernels.integrators.collocation_sweep import (
    go_on,
    know_modes,
    pieces_needed,
    remember,
    stand,
    step_miss,
    sweep,
    values_inside,
    weigh,
    write_end,
    write_piece,
)
from autobalancer.kernels.integrators.dense_output import evaluate
from autobalancer.kernels.integrators.integrator_state import (
    ACCEPTED,
    CUT,
    DUE,
    END,
    ERROR,
    EVALUATIONS,
    FRESH,
    LONGEST,
    PASS,
    REJECTED,
    STEP,
    TAKE,
    TAKEN,
    TIME,
    Memory,
    memory_type,
    switch_type,
)
from autobalancer.kernels.integrators.recording import (
    Record,
    components_needed,
    components_requested,
    record,
    record_type,
)
from autobalancer.kernels.integrators.runge_kutta import (
    EVENT,
    FINISHED,
    RUNNING,
    advance,
    do_stages,
    refuse,
    step_error,
)
from autobalancer.kernels.integrators.tableau import Tableau, tableau_type
from autobalancer.kernels.system import SPEED, System, rhs_type, system_type

OTHER_FORCES = 5  # another end of a call, beside those of the explicit pairs
KAPPA = 0.001  # the iteration ends where its error is this share of the tolerance
MOST_SWEEPS = 12
RENEW = (
    0.05  # rad: so far may the frame turn in a step against the frozen speed, if the middle of the step has that one
)
INSIDE = 1.0 - 1e-12  # of a step that a switch ends
SMALLEST = 1e-8  # of the error of a step, so that the next one is not longer without limit


@njit(**INLINE)
def _begin_anew(left: float, quick: float, inner: Any, m: Memory, a: Amplitudes) -> None:
    """Nothing of a step before is known: frozen speed and modes of now, and, if need be, a step of half a radian."""
    a.held[FROZEN] = m.state[SPEED]
    take_basis(inner)
    for row in range(a.rates.size):
        a.rates[row] = 0.0
    if m.clock[STEP] == 0.0:
        m.clock[STEP] = min(0.5 / (abs(m.state[SPEED]) + quick), left)


@njit(**INLINE)
def _next_reach(time: float, stop: float, m: Memory) -> tuple[float, float]:
    """The step to try, and the time it reaches: never a sliver before a corner at ``stop``."""
    step, left = min(m.clock[STEP], m.clock[LONGEST]), stop - time
    reach = time + step
    if step >= 0.999 * left:
        reach, step = stop, left
    elif step > 0.5 * left:  # two equal steps to a corner, not a long one and a short one
        step = 0.5 * left
        reach = time + step
    return step, reach


@njit(**INLINE)
def _renew_frozen_speed(step: float, inner: Any, m: Memory, a: Amplitudes) -> None:
    """Modes turn about a frozen speed: take that of the middle of the step where the rotor has left it too far behind."""
    middle = m.state[SPEED]
    if m.counts[FRESH] == 1:
        middle += 0.5 * step * a.forces_before[(2 * a.modes + 1) * NODES - 1]
    if abs(middle - a.held[FROZEN]) * step > RENEW:
        a.held[FROZEN] = middle
        take_basis(inner)


@njit(**INLINE)
def _iterate(time, step, nodes, parameters, unknowns, m, a) -> tuple[bool, int]:  # type: ignore[no-untyped-def]
    """Fixed-point iteration for the values at all nodes; whether it settled, and after how many sweeps.

    It begins with the forces of the last step continued, and ends when the next change would be small enough.
    """
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
            # it diverges, or its error, about change * shrink / (1 - shrink), is small against the tolerance
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
    return settled, count


@njit(**INLINE)
def _write_pieces(time, step, reach, components, changing, rhs, switch, addresses, r, m, a):  # type: ignore[no-untyped-def]
    """Write out a step where somebody looks into it; returns whether an event ended the run, the fraction taken, the time.

    A step is a few polynomials of lower degree, its pieces. ``changing``: a contact may change in it, and ends it there.
    """
    parameters, inner, memory, kept, pair = addresses
    asked, n, cut, event = as_void(pair), m.state.size, 1.0, False
    pieces, piece = pieces_needed(step, a), 0
    length = step / pieces
    m.clock[TAKEN] = length
    while piece < pieces and cut == 1.0 and not event:
        left, right, limit = time + step * piece / pieces, time + step * (piece + 1) / pieces, 1.0
        if piece == pieces - 1:
            right = reach
        # the polynomials of this piece, of so many leading components as are asked for
        leading = n if changing else components_requested(components, right, r, m)
        if pieces == 1:
            write_piece(data(a.values), length, leading, inner, memory)
        else:
            values_inside(piece, pieces, step, a, m)
            write_piece(data(a.inside), length, leading, inner, memory)
        # a contact that changes in this piece ends the step there
        if changing:
            for i in range(n):
                m.state[i] = a.reached[i]
            due = switch(DUE, left, rhs, parameters, asked) != 0.0
            limit = switch(CUT, left, rhs, parameters, asked)
            if due or limit < 1.0:
                cut = min((piece + limit) / pieces, INSIDE)
        # what was asked for in this piece; an event ends the run inside
        if components >= 0:
            ended = record(left, right, components, limit, kept, pair)
            if ended <= 1.0:
                evaluate(ended, pair, data(m.state))
                reach, event = left + ended * length, True
        if not event:
            if cut < 1.0:
                evaluate(limit, pair, data(m.state))
                reach = right if limit == 1.0 else left + limit * length
            else:
                for i in range(n):
                    m.start[i] = a.reached[i]
        piece += 1
    return event, cut, reach


@njit(**INLINE)
def _choose_next_step(step: float, error: float, sweeps: int, m: Memory) -> None:
    """The next step follows from the error, and stays as it is where it would hardly change."""
    growth = 0.9 * max(error, SMALLEST) ** (-1.0 / NODES)
    if sweeps >= MOST_SWEEPS - 1:
        growth = min(growth, 0.9)
    growth = min(2.0, max(0.3, growth))
    if growth < 0.95 or growth > 1.2:
        m.clock[STEP] = step * growth


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

    ``t`` is :func:`autobalancer.kernels.integrators.collocation_sweep.by_powers`. OTHER_FORCES says that the forces change
    now: the explicit pair has to go on from here. Calling it again goes on where it stopped, to the last bit as if it had
    never stopped.
    """
    parameters, pair, kept, inner, memory = as_void(address(p)), address((t, m)), address(r), address(a), address(m)
    unknowns, asked, r, m, a = as_void(inner), as_void(pair), deref(r), deref(m), deref(a)
    n, taken, quick = m.state.size, 0, 0.0
    for mode in range(a.modes):
        quick = max(quick, math.hypot(a.exponents[2 * mode], a.exponents[2 * mode + 1]))
    while taken < budget:
        # up to the end or the next corner of the drive, where the forces have a jump
        time, end = m.clock[TIME], m.clock[END]
        if time >= end:
            return FINISHED
        anew = enter_segment(time, p.drive)
        stop = next_corner(end, p.drive)
        if anew or m.counts[FRESH] == 0:
            switch(TAKE, time, rhs, parameters, asked)
        if m.counts[FRESH] == 0:
            _begin_anew(stop - time, quick, inner, m, a)
        step, reach = _next_reach(time, stop, m)
        m.clock[TAKEN] = step
        for i in range(n):
            m.start[i] = a.origin[i] = m.state[i]
        # the values at the nodes of the step
        _renew_frozen_speed(step, inner, m, a)
        weigh(a, m)
        know_modes(step, a)
        settled, count = _iterate(time, step, nodes, parameters, unknowns, m, a)
        # refuse a step that did not settle or misses by too much
        error = step_miss(step, a) if settled else math.inf
        if not error <= 1.0:
            shrink = 0.5
            if settled:
                shrink = max(0.2, 0.85 * error ** (-1.0 / NODES))
            else:
                a.tallies[UNSETTLED] += 1
            status = refuse(time, step * shrink, data(a.forces), a.forces.size, m)
            if status != RUNNING:
                return status
            continue
        # the equations may hold for a part of the step only; where that is too short, the pair takes over
        until = watch(step, parameters, unknowns)
        if until < 1.0:
            if until * step < 1.0 / (abs(m.state[SPEED]) + quick):
                return OTHER_FORCES
            m.counts[REJECTED] += 1
            m.clock[STEP] = until * step
            continue
        # the step is taken
        write_end(a, m)
        a.tallies[LONG_STEPS] += 1
        m.counts[ACCEPTED] += 1
        taken += 1
        event, cut, components = False, 1.0, components_needed(time, reach, end, r, m)
        if components >= 0 or until == SWITCHES:
            addresses = parameters, inner, memory, kept, pair
            event, cut, reach = _write_pieces(
                time, step, reach, components, until == SWITCHES, rhs, switch, addresses, r, m, a
            )
        m.clock[TIME] = reach
        if event:
            m.counts[FRESH] = 0
            return EVENT
        # ready for the next one
        remember(step, a)
        m.counts[FRESH] = 1
        a.held[BEGINS] = cut
        if cut < 1.0:  # the forces of this step are still a good begin of the next one
            switch(PASS, reach, rhs, parameters, asked)
            switch(TAKE, reach, rhs, parameters, asked)
            continue
        _choose_next_step(step, error, count, m)
    return FINISHED if m.clock[TIME] >= m.clock[END] else RUNNING


# Long steps where they win, and the explicit pair where it does.
#
# The pair takes over where the forces on the balls change, as in a contact, and where it gets further for the same
# work. Its step is known without taking one: the error of a trial says how long it could be. After a while long steps
# are tried again; the while is doubled as long as they fail.


SHORTEST_CHUNK, LONGEST_CHUNK = 50, 1600  # steps of the pair before long ones are tried again
LOOK = 64  # long steps between two looks at what the pair would do
# in evaluations of the right-hand side
PER_SWEEP = 2.4
PER_STEP = 6.0
WORTH = 0.9  # long steps are kept unless the pair needs less than this share of their work


@njit(**PART)
def _trial_step(rhs, guess, parameters, pair):  # type: ignore[no-untyped-def]
    """The step that the pair would take now; the state stays."""
    t, m = deref(pair)
    for i in range(m.state.size):
        m.start[i] = m.state[i]
    rhs(m.clock[TIME], data(m.start), data(m.stages), parameters)
    m.clock[TAKEN] = guess
    do_stages(int64(1), t.main, rhs, parameters, pair)
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
def integrate(
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
    parameters, pair = as_void(address(p)), address((t, m))
    last = m.counts[ACCEPTED] + budget
    while m.counts[ACCEPTED] < last:
        # while the pair has the word: its steps, until the chunk it was given is used up
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
        # long steps from here on: note when they began and what they had cost
        if a.tallies[IN_A_ROW] == 0:
            a.held[SINCE], a.tallies[SWEEPS_THEN] = m.clock[TIME], a.tallies[SWEEPS]
            if not a.held[PAIR_STEP] > 0.0:
                a.held[PAIR_STEP] = 1.0 / (abs(m.state[SPEED]) + math.hypot(a.exponents[0], a.exponents[1]))
        # a batch of long steps, then a look at what the pair would do
        status = advance_long(
            rhs, switch, nodes, watch, p, powers, r, long, a, min(left, LOOK - a.tallies[IN_A_ROW] % LOOK)
        )
        a.tallies[IN_A_ROW] += m.counts[ACCEPTED] - before
        if status == OTHER_FORCES:
            _hand_to_pair(m, a)
        elif status != RUNNING:
            return status
        elif a.tallies[IN_A_ROW] % LOOK == 0:
            # cost of the batch in evaluations, against the steps of the pair for the same time
            work = PER_SWEEP * (a.tallies[SWEEPS] - a.tallies[SWEEPS_THEN]) + PER_STEP * LOOK
            covered = m.clock[TIME] - a.held[SINCE]
            a.held[PAIR_STEP] = _trial_step(rhs, a.held[PAIR_STEP], parameters, pair)
            a.held[SINCE], a.tallies[SWEEPS_THEN] = m.clock[TIME], a.tallies[SWEEPS]
            if (t.main - 1) * covered < WORTH * work * a.held[PAIR_STEP]:
                _hand_to_pair(m, a)
    return RUNNING if m.clock[TIME] < m.clock[END] else FINISHED
