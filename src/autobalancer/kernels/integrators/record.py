"""What a run keeps: samples at given times, envelopes over bins, the last revolutions, events.

All of it is found on the dense output of a step, and none of it grows with the length of the run.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from numba import njit, types

from autobalancer.kernels.events import event_value
from autobalancer.kernels.flags import COMPILED, INLINE
from autobalancer.kernels.integrators.memory import (
    EVENTS_SEEN,
    NEXT_BIN,
    NEXT_SAMPLE,
    NEXT_TURN,
    Memory,
)
from autobalancer.kernels.system import (
    THETA,
    Floats,
    Integers,
    System,
    X,
    Y,
    integers_type,
    matrix_type,
    vector_type,
)

PIECES = 8  # parts into which a step is cut in search of extrema and events


class Record(NamedTuple):
    """Where a run writes; an array of length zero means: not wanted."""

    sample_times: Floats  # (m,) ascending
    samples: Floats  # (m, n) states
    bin_edges: Floats  # (b + 1,) ascending
    bin_low: Floats  # (b,) least deflection in the bin
    bin_high: Floats  # (b,) greatest deflection in the bin
    bin_states: Floats  # (b, n) state at the end of the bin
    turn_states: Floats  # (r, n + 1) ring of states (time first) at equal steps of the rotor angle
    turn_step: float  # that step, rad
    turn_count: float  # revolutions kept
    event_kinds: Integers  # (e,)
    event_balls: Integers  # (e,) which ball, or -1
    event_levels: Floats  # (e,)
    event_directions: Integers  # (e,) +1 rising, -1 falling, 0 both
    event_terminal: Integers  # (e,) 1 ends the run
    event_seen: Integers  # (e,) how often it happened
    event_states: Floats  # (k, n + 2) event number, time, state; the first k events


record_type = types.NamedTuple(
    [
        vector_type, matrix_type, vector_type, vector_type, vector_type, matrix_type, matrix_type,
        types.float64, types.float64,
        integers_type, integers_type, vector_type, integers_type, integers_type, integers_type, matrix_type,
    ],
    Record,
)  # fmt: skip


@njit(**INLINE)
def component(i: int, x: float, m: Memory) -> float:
    """Component i of the state at the fraction x of the step."""
    degree = m.dense.shape[0]
    value = 0.0
    for j in range(degree - 1, -1, -1):
        value = (value + m.dense[j, i]) * x
    return m.start[i] + value


@njit(**INLINE)
def slope(i: int, x: float, m: Memory) -> float:
    """Derivative of :func:`component` with respect to x."""
    degree = m.dense.shape[0]
    value = 0.0
    for j in range(degree - 1, -1, -1):
        value = value * x + (j + 1.0) * m.dense[j, i]
    return value


@njit(**COMPILED)
def evaluate(x: float, m: Memory, out: Floats) -> None:
    """The whole state at the fraction x of the step."""
    for i in range(out.size):
        out[i] = component(i, x, m)


@njit(**COMPILED)
def record_samples(left: float, right: float, r: Record, m: Memory) -> None:
    """States at the sample times in (left, right]."""
    while m.counts[NEXT_SAMPLE] < r.sample_times.size:
        number = m.counts[NEXT_SAMPLE]
        time = r.sample_times[number]
        if time > right:
            return
        evaluate((time - left) / (right - left), m, r.samples[number])
        m.counts[NEXT_SAMPLE] += 1


@njit(**INLINE)
def _growth(x: float, m: Memory) -> float:
    """Half the derivative of the squared deflection."""
    return component(X, x, m) * slope(X, x, m) + component(Y, x, m) * slope(Y, x, m)


@njit(**INLINE)
def _note(x: float, left: float, width: float, r: Record, m: Memory) -> None:
    time = left + x * width
    deflection = math.hypot(component(X, x, m), component(Y, x, m))
    number = m.counts[NEXT_BIN]
    while number < r.bin_low.size - 1 and time > r.bin_edges[number + 1]:
        number += 1
    r.bin_low[number] = min(r.bin_low[number], deflection)
    r.bin_high[number] = max(r.bin_high[number], deflection)


@njit(**COMPILED)
def record_envelope(left: float, right: float, r: Record, m: Memory) -> None:
    """Extrema of the deflection in every bin: at turning points inside the step and at edges."""
    if m.counts[NEXT_BIN] >= r.bin_low.size:
        return
    width = right - left
    before = _growth(0.0, m)
    for piece in range(PIECES):
        low, high = piece / PIECES, (piece + 1) / PIECES
        after = _growth(high, m)
        _note(high, left, width, r, m)
        if before * after < 0.0:
            f_low, f_high = before, after
            for _ in range(6):
                middle = (low * f_high - high * f_low) / (f_high - f_low)
                f = _growth(middle, m)
                if f * f_high < 0.0:
                    low, f_low = high, f_high
                else:
                    f_low *= 0.5
                high, f_high = middle, f
                if f == 0.0 or abs(high - low) < 1e-9:
                    break
            _note(min(max(high, 0.0), 1.0), left, width, r, m)
        before = after
    while m.counts[NEXT_BIN] < r.bin_low.size and r.bin_edges[m.counts[NEXT_BIN] + 1] <= right:
        number = m.counts[NEXT_BIN]
        x = (r.bin_edges[number + 1] - left) / width
        evaluate(x, m, r.bin_states[number])
        deflection = math.hypot(r.bin_states[number, X], r.bin_states[number, Y])
        for neighbor in range(number, min(number + 2, r.bin_low.size)):
            r.bin_low[neighbor] = min(r.bin_low[neighbor], deflection)
            r.bin_high[neighbor] = max(r.bin_high[neighbor], deflection)
        m.counts[NEXT_BIN] += 1


@njit(**COMPILED)
def record_turns(left: float, right: float, end: float, r: Record, m: Memory) -> None:
    """States at equal steps of the rotor angle, in a ring that holds the last revolutions."""
    size = r.turn_states.shape[0]
    if size == 0:
        return
    first, last = m.start[THETA], component(THETA, 1.0, m)
    if last <= first:
        return
    speed = (last - first) / (right - left)
    number = math.floor(first / r.turn_step) + 1
    if speed * (end - left) > 2.0 * math.pi * (2.0 * r.turn_count + 1.0):
        return  # still far from the end
    while number * r.turn_step <= last:
        target = number * r.turn_step
        x = (target - first) / (last - first)
        for _ in range(8):
            rate = slope(THETA, x, m)
            miss = component(THETA, x, m) - target
            if rate <= 0.0:
                break
            x = min(max(x - miss / rate, 0.0), 1.0)
            if abs(miss) < 1e-13 * abs(target):
                break
        place = m.counts[NEXT_TURN] % size
        r.turn_states[place, 0] = left + x * (right - left)
        evaluate(x, m, r.turn_states[place, 1:])
        m.counts[NEXT_TURN] += 1
        number += 1


@njit(**COMPILED)
def find_events(left: float, right: float, p: System, r: Record, m: Memory) -> float:
    """Log the events of a step in order; the fraction of the step at which the run ends, or 2."""
    position = 0.0
    while True:
        # the earliest event after `position`; few events happen, so the search starts again after each
        first, which = 2.0, -1
        for e in range(r.event_kinds.size):
            evaluate(position, m, m.trial)
            before = event_value(r.event_kinds[e], r.event_balls[e], r.event_levels[e], m.trial)
            for piece in range(PIECES):
                high = (piece + 1) / PIECES
                low = max(piece / PIECES, position)
                if high <= position:
                    continue
                evaluate(high, m, m.trial)
                after = event_value(r.event_kinds[e], r.event_balls[e], r.event_levels[e], m.trial)
                rising = before < 0.0 <= after and r.event_directions[e] >= 0
                falling = before > 0.0 >= after and r.event_directions[e] <= 0
                before = after
                if rising or falling:
                    sign = 1.0 if rising else -1.0
                    for _ in range(60):
                        middle = 0.5 * (low + high)
                        if middle in (low, high):
                            break
                        evaluate(middle, m, m.trial)
                        if sign * event_value(r.event_kinds[e], r.event_balls[e], r.event_levels[e], m.trial) >= 0.0:
                            high = middle
                        else:
                            low = middle
                    if high < first:
                        first, which = high, e
                    break
        if which < 0:
            return 2.0
        r.event_seen[which] += 1
        log = m.counts[EVENTS_SEEN]
        if log < r.event_states.shape[0]:
            r.event_states[log, 0] = which
            r.event_states[log, 1] = left + first * (right - left)
            evaluate(first, m, r.event_states[log, 2:])
        m.counts[EVENTS_SEEN] += 1
        if r.event_terminal[which] == 1:
            return first
        position = first
