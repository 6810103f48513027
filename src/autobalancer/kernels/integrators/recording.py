"""What a run keeps: samples at given times, envelopes over bins, the last revolutions, events.

All of it is found on the dense output of a step, and none of it grows with the length of the run.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from numba import int64

from autobalancer.kernels.compiler.flags import INLINE, MERGED, PART, njit
from autobalancer.kernels.compiler.numba_struct import data, deref, passed_by_address, struct_type
from autobalancer.kernels.compiler.simd import NODES, all_lanes, amount, load, root, select, store, total
from autobalancer.kernels.integrators.dense_output import component, evaluate, polynomials, quantity, slope, states_at
from autobalancer.kernels.integrators.integrator_state import (
    END,
    EVENTS_SEEN,
    NEXT_BIN,
    NEXT_SAMPLE,
    NEXT_TURN,
    TAKEN,
    Memory,
)
from autobalancer.kernels.system import THETA, Floats, Integers, Matrix, X, Y, tuple_type

PIECES = NODES  # parts into which a step is cut in search of extrema and events
NEAR = 1e-12  # a squared deflection is an extremum if it would change by no more than this share of it


@passed_by_address
class Record(NamedTuple):
    """Where a run writes; an array of length zero means: not wanted."""

    sample_times: Floats  # (m,) ascending
    samples: Matrix  # (m, n) states
    bin_edges: Floats  # (b + 1,) ascending
    bin_low: Floats  # (b,) least deflection in the bin
    bin_high: Floats  # (b,) greatest deflection in the bin
    bin_states: Matrix  # (b, n) state at the end of the bin
    turn_states: Matrix  # (r, n + 1) ring of states (time first) at equal steps of the rotor angle
    turn_step: float  # that step, rad
    turn_count: float  # revolutions kept
    event_kinds: Integers  # (e,) of the quantity, and its components: integrators/dense_output.py
    event_firsts: Integers  # (e,)
    event_seconds: Integers  # (e,)
    event_levels: Floats  # (e,)
    event_directions: Integers  # (e,) +1 rising, -1 falling, 0 both
    event_terminal: Integers  # (e,) 1 ends the run
    event_seen: Integers  # (e,) how often it happened
    event_sides: Floats  # (e,) on which side of the level the quantity was seen last, +1 or -1; 0 before the first look
    event_places: Floats  # (e,) work: the fraction of the step up to which passages are noted
    event_states: Matrix  # (k, n + 2) event number, time, state; the first k events


record_type = struct_type(tuple_type(Record))


@njit(**INLINE)
def components_needed(left: float, right: float, end: float, r: Record, m: Memory) -> int:
    """How many leading components of the dense output this step needs as polynomials; -1 if nothing at all."""
    if r.event_kinds.size > 0:
        return m.state.size
    if r.turn_states.shape[0] > 0:
        # revolutions to come, if the rotor keeps its speed; far from the end nothing is kept
        turned = abs(m.state[THETA] - m.start[THETA])  # a long step may turn the rotor more often than that
        if turned * (end - right) <= 2.0 * math.pi * (2.0 * r.turn_count + 1.0) * (right - left):
            return THETA + 1
    if m.counts[NEXT_BIN] < r.bin_low.size:
        return Y + 1
    number = m.counts[NEXT_SAMPLE]
    return 0 if number < r.sample_times.size and r.sample_times[number] <= right else -1


@njit(**INLINE)
def components_requested(components: int, right: float, r: Record, m: Memory) -> int:
    """How many leading components :func:`record` asks for up to ``right``: all of them where it keeps a state."""
    bin_, sample = m.counts[NEXT_BIN], m.counts[NEXT_SAMPLE]
    alone = components == Y + 1 and not (bin_ < r.bin_low.size and r.bin_edges[bin_ + 1] <= right)
    return (
        components if alone and not (sample < r.sample_times.size and r.sample_times[sample] <= right) else m.state.size
    )


@njit(**PART)
def record_samples(left, right, kept, pair):  # type: ignore[no-untyped-def]
    """States at the sample times in (left, right]."""
    (_, m), r = deref(pair), deref(kept)
    number = m.counts[NEXT_SAMPLE]
    while number < r.sample_times.size and r.sample_times[number] <= right:
        evaluate((r.sample_times[number] - left) / m.clock[TAKEN], pair, data(r.samples[number]))
        number += 1
    m.counts[NEXT_SAMPLE] = number


@njit(**PART)
def _growth(x, pair):  # type: ignore[no-untyped-def]
    """Half the derivative of the squared deflection, and the latter."""
    _, m = deref(pair)
    one, other = component(X, x, m), component(Y, x, m)
    return one * slope(X, x, m) + other * slope(Y, x, m), one * one + other * other


@njit(**PART)
def _at_ends_of_pieces(cut, pair):  # type: ignore[no-untyped-def]
    """Deflection and :func:`_growth` at the ends of all pieces at once, into ``trial`` and ``spare``."""
    _, m = deref(pair)
    places, dense, width = data(m.spare), data(m.dense), m.dense.shape[1]
    for piece in range(PIECES):
        places[piece] = cut * (piece + 1) / PIECES
    x = load(places, 0)
    one, other, along, across = all_lanes(0.0), all_lanes(0.0), all_lanes(0.0), all_lanes(0.0)
    for j in range(m.dense.shape[0] - 1, -1, -1):
        of_x, of_y = dense[j * width + X], dense[j * width + Y]
        one, other = (one + of_x) * x, (other + of_y) * x
        along, across = along * x + (j + 1.0) * of_x, across * x + (j + 1.0) * of_y
    one, other = one * m.clock[TAKEN] + data(m.start)[X], other * m.clock[TAKEN] + data(m.start)[Y]
    store(root(one * one + other * other), data(m.trial), 0)
    store((one * along + other * across) * m.clock[TAKEN], places, 0)


@njit(**INLINE)
def _note(deflection, time, r, m):  # type: ignore[no-untyped-def]
    """Into the bin of this time, whose number is returned."""
    number = m.counts[NEXT_BIN]
    while number < r.bin_low.size - 1 and time > r.bin_edges[number + 1]:
        number += 1
    r.bin_low[number] = min(r.bin_low[number], deflection)
    r.bin_high[number] = max(r.bin_high[number], deflection)
    return number


@njit(**PART)
def record_envelope(left, right, cut, kept, pair):  # type: ignore[no-untyped-def]
    """Extrema of the deflection in every bin: at turning points inside the step and at edges.

    The step ends at the fraction ``cut``.
    """
    (_, m), r = deref(pair), deref(kept)
    if m.counts[NEXT_BIN] >= r.bin_low.size:
        return
    # radius and its growth at equal parts of the step
    step = m.clock[TAKEN]
    _at_ends_of_pieces(cut, pair)
    before = (m.start[X] * m.dense[0, X] + m.start[Y] * m.dense[0, Y]) * step
    for piece in range(PIECES):
        # a part whose growth changes its sign has an extremum inside
        low, high = cut * piece / PIECES, cut * (piece + 1) / PIECES
        after, end = m.spare[piece], m.trial[piece]
        number = _note(end, left + high * step, r, m)
        # nothing to be found in a part whose squared deflection cannot pass what is known: it changes by twice the growth over it
        reach = 2.0 * (abs(before) + abs(after)) * (high - low)
        known = r.bin_edges[number] <= left + low * step and (
            end * end + reach < r.bin_high[number] ** 2 if before > 0.0 else end * end - reach > r.bin_low[number] ** 2
        )
        if before * after < 0.0 and not known:
            # a turning point inside, by the rule of the Illinois; it counts besides the end of the piece
            place, f_low, f_high, square = high, before, after, 0.0
            for _ in range(6):
                last, place = place, (low * f_high - high * f_low) / (f_high - f_low)
                f, square = _growth(place, pair)
                if f * f_high < 0.0:
                    low, f_low = high, f_high
                else:
                    f_low *= 0.5
                high, f_high = place, f
                if abs(f * (place - last)) <= NEAR * square:
                    break
            _note(math.sqrt(square), left + place * step, r, m)
        before = after
    # edges of bins in this step: the deflection there belongs to both, and the state is kept
    while m.counts[NEXT_BIN] < r.bin_low.size and r.bin_edges[m.counts[NEXT_BIN] + 1] <= right:
        number = m.counts[NEXT_BIN]
        evaluate((r.bin_edges[number + 1] - left) / step, pair, data(r.bin_states[number]))
        deflection = math.hypot(r.bin_states[number, X], r.bin_states[number, Y])
        for neighbor in range(number, min(number + 2, r.bin_low.size)):
            r.bin_low[neighbor] = min(r.bin_low[neighbor], deflection)
            r.bin_high[neighbor] = max(r.bin_high[neighbor], deflection)
        m.counts[NEXT_BIN] += 1


@njit(**MERGED)
def _angle_crossings(targets, first, last, cut, m):  # type: ignore[no-untyped-def]
    """Fractions of the step, up to ``cut``, at which the rotor has eight angles, by Newton; into the place of the angles."""
    dense, width, count = data(m.dense), m.dense.shape[1], m.dense.shape[0]
    begin, step, way = data(m.start)[THETA], m.clock[TAKEN], 1.0 if last > first else -1.0
    angles, searching = load(targets, 0), all_lanes(1.0)
    # begin as if the speed were constant, then Newton on the polynomial of the angle and its derivative, never
    # beyond the step or where the rotor turns back
    x = (angles - first) * cut / (last - first)
    for _ in range(8):
        rate, value = all_lanes(0.0), all_lanes(0.0)
        for j in range(count - 1, -1, -1):
            number = dense[j * width + THETA]
            rate, value = rate * x + (j + 1.0) * number, (value + number) * x
        rate, miss = rate * step, value * step + begin - angles
        searching = select(rate * way <= 0.0, 0.0, searching)
        nearer = x - miss / rate
        nearer = select(nearer > 0.0, nearer, 0.0)
        x = select(searching > 0.0, select(nearer < cut, nearer, cut), x)
        searching = select(amount(miss) < amount(angles) * 1e-13, 0.0, searching)
        if total(searching) == 0.0:
            break
    store(x, targets, 0)


@njit(**PART)
def record_turns(left, cut, kept, pair):  # type: ignore[no-untyped-def]
    """States at equal steps of the rotor angle, in a ring that holds the last revolutions; eight are sought at once.

    Those that later ones are to replace are left out: at least half of those that would come if the rotor kept its speed.
    """
    (_, m), r = deref(pair), deref(kept)
    size, places = r.turn_states.shape[0], data(m.spare)
    first, last = m.start[THETA], component(THETA, cut, m)
    if size == 0 or last == first:
        return
    # the first angle of the grid behind the begin
    way = 1.0 if last > first else -1.0
    number, taken = math.floor(way * first / r.turn_step) + 1, cut * m.clock[TAKEN]
    # how many of them will still be there at the end of the run
    keep = float(size)
    if r.event_kinds.size == 0 and r.turn_count < math.inf:  # nothing ends the run before its time
        keep -= 0.5 * abs(last - first) / r.turn_step * (m.clock[END] - left - taken) / taken
    left_out = math.floor(way * last / r.turn_step) - number - math.ceil(max(keep, 0.0))
    if left_out > 0:
        number += left_out
        m.counts[NEXT_TURN] = 0
    # eight angles at once, in the vector registers
    while number * r.turn_step <= way * last:
        count: Any = int64(0)  # not the number 0 itself, for which what is called would be compiled once more
        for k in range(NODES):  # those behind the step stand for nothing
            if (number + k) * r.turn_step <= way * last:
                count = k + 1
            places[k] = way * (number + count - 1) * r.turn_step
        _angle_crossings(places, first, last, cut, m)
        states_at(places, count, m.counts[NEXT_TURN], left, r.turn_states, pair)
        m.counts[NEXT_TURN] += count
        number += count


@njit(**INLINE)
def _value(e, x, r, pair):  # type: ignore[no-untyped-def]
    """The quantity of an event, less its level."""
    return quantity(r.event_kinds[e], r.event_firsts[e], r.event_seconds[e], x, pair) - r.event_levels[e]


@njit(**PART)
def _passage(e, kept, pair):  # type: ignore[no-untyped-def]
    """The next passage that counts, after those noted: its fraction of the step, or 2, and the side it leads to."""
    r = deref(kept)
    side, low = r.event_sides[e], r.event_places[e]
    for piece in range(int(low * PIECES), PIECES):
        # on one side until the sign differs at the end of a part
        high = (piece + 1) / PIECES
        value = _value(e, high, r, pair)
        if side == 0.0 and value != 0.0:
            side = math.copysign(1.0, value)
        elif side * value <= 0.0 and side != 0.0:
            # a passage in the direction asked for is bisected to the last bit; another one only changes the side
            if side * r.event_directions[e] <= 0.0:
                middle = 0.5 * (low + high)
                while low < middle < high:
                    if side * _value(e, middle, r, pair) <= 0.0:
                        high = middle
                    else:
                        low = middle
                    middle = 0.5 * (low + high)
                return high, -side
            side = -side
        low = high
    return 2.0, side


@njit(**PART)
def find_events(left, limit, kept, pair):  # type: ignore[no-untyped-def]
    """Log the events of a step up to the fraction ``limit`` in order; the fraction at which the run ends, or 2.

    The side of a quantity is remembered from step to step, so that rounding neither hides nor doubles a passage.
    """
    (_, m), r = deref(pair), deref(kept)
    ended = 2.0
    # a side that was not known, because the quantity was at its level
    for e in range(r.event_kinds.size):
        r.event_places[e] = 0.0
        value = _value(e, 0.0, r, pair)
        if r.event_sides[e] == 0.0 and value != 0.0:
            r.event_sides[e] = math.copysign(1.0, value)
    searching = True
    while searching:
        # the earliest passage of all events, one after the other
        first, which, side = 2.0, -1, 0.0
        for e in range(r.event_kinds.size):
            x, after = _passage(e, kept, pair)
            if x < first:
                first, which, side = x, e, after
        searching = which >= 0 and first <= min(ended, limit)
        if searching:
            r.event_seen[which] += 1
            r.event_places[which], r.event_sides[which] = first, side
            log = m.counts[EVENTS_SEEN]
            if log < r.event_states.shape[0]:
                r.event_states[log, 0] = which
                r.event_states[log, 1] = left + first * m.clock[TAKEN]
                evaluate(first, pair, data(r.event_states[log, 2:]))
            m.counts[EVENTS_SEEN] += 1
            if r.event_terminal[which] == 1:
                ended = first
    # on which side each quantity ends, unless it passed just now
    last = min(ended, limit)
    for e in range(r.event_kinds.size):
        value = _value(e, last, r, pair)
        if r.event_places[e] < last and value != 0.0:
            r.event_sides[e] = math.copysign(1.0, value)
    return ended


@njit(**PART)
def record(left, right, components, limit, kept, pair):  # type: ignore[no-untyped-def]
    """All that is wanted of the step from ``left`` to ``right``; the fraction at which an event ends the run, or 2.

    Only the fraction ``limit`` of the step counts.
    """
    (t, m), r = deref(pair), deref(kept)
    ended, cut = 2.0, limit
    if limit < 1.0:
        right = left + limit * m.clock[TAKEN]
    polynomials(components, t, m)
    # events first: one that ends the run cuts the step
    if r.event_kinds.size > 0:
        ended = find_events(left, limit, kept, pair)
        if ended <= 1.0:
            cut = ended
            right = left + cut * m.clock[TAKEN]
    # then what the cut step holds: samples, bins of the envelope, states at equal angles
    record_samples(left, right, kept, pair)
    if components > Y:
        record_envelope(left, right, cut, kept, pair)
    if components > THETA:
        record_turns(left, cut, kept, pair)
    return ended
