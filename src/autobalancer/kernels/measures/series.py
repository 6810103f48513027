"""Measures of the course of a run: its envelope over bins, and the motion of its balls over samples or the ends of bins."""

from __future__ import annotations

import math

from numba import boolean, float64, int64, void

from autobalancer.kernels.flags import EXACT, njit
from autobalancer.kernels.measures.limits import (
    CONSTANT,
    JUMP,
    NEAR_CRITICAL,
    NOWHERE,
    RELEASE,
    REST,
    RUN_UP,
    SAME_SPEED,
    STALL_MARGIN,
    STALL_SHARE,
    START,
)
from autobalancer.kernels.system import Floats, Integers, Matrix, integers_type, matrix_type, vector_type


@njit(int64(vector_type), **EXACT)
def greatest_at(values: Floats) -> int:
    """Where the greatest of some numbers is, the first one; nan counts as the greatest."""
    best = 0
    for i in range(values.size):
        if math.isnan(values[i]):
            return i
        if values[i] > values[best]:
            best = i
    return best


@njit(float64(vector_type), **EXACT)
def greatest_known(values: Floats) -> float:
    """The greatest that is a number; nan if there is none."""
    found = math.nan
    for i in range(values.size):
        if math.isfinite(values[i]) and not values[i] <= found:
            found = values[i]
    return found


@njit(float64(vector_type), **EXACT)
def mean(values: Floats) -> float:
    """The mean of some numbers."""
    total = 0.0
    for i in range(values.size):
        total += values[i]
    return total / values.size


@njit(float64(vector_type, vector_type), **EXACT)
def time_near_peak(width: Floats, high: Floats) -> float:
    """Time (s) with a deflection above half of the greatest; of bins with their ``width`` (s) and greatest deflection (m)."""
    half, total = 0.5 * high[greatest_at(high)], 0.0
    for i in range(high.size):
        if high[i] > half:
            total += width[i]
    return total


@njit(float64(vector_type, vector_type, float64), **EXACT)
def time_at_resonance(time: Floats, speed: Floats, critical: float) -> float:
    """Time (s) with a rotor speed within a tenth of the ``critical`` one, up to the last bin or sample; linear in between."""
    total, low, high = 0.0, (1.0 - NEAR_CRITICAL) * critical, (1.0 + NEAR_CRITICAL) * critical
    if not critical > 0.0:
        return math.nan
    for i in range(1, time.size):
        a, b = abs(speed[i - 1]), abs(speed[i])
        if a == b:
            share = 1.0 if low <= a <= high else 0.0
        else:
            share = max(0.0, min(max(a, b), high) - max(min(a, b), low)) / abs(b - a)
        total += share * (time[i] - time[i - 1])
    return total


@njit(float64(vector_type, vector_type, float64), **EXACT)
def last_deflection(time: Floats, high: Floats, begin: float) -> float:
    """The greatest of ``high`` (m) from ``begin`` (s) on, the last one in any case."""
    found = high[high.size - 1]
    for i in range(high.size - 1):
        if time[i] >= begin and high[i] > found:
            found = high[i]
    return found


@njit(void(vector_type, matrix_type, vector_type, float64, vector_type), **EXACT)
def settled_from(time: Floats, angle: Matrix, speed: Floats, tolerance: float, found: Floats) -> None:
    """Time from which each ball stays within ``tolerance`` (rad) of its last angle; nan if it still moves.

    ``angle`` is (T, n), in the rotor. Balls that swing under gravity come to rest in the mean over a revolution.
    """
    count = time.size
    last = count - 1
    end = abs(speed[last])
    since = time[last] - 2.0 * math.pi / max(end, 1e-300)
    first = count - 1  # the last time that is not after the begin of the last turn
    while first >= 0 and time[first] > since:
        first -= 1
    first = min(max(first, 0), count - 2)
    passed = time[last] - time[first] if count > 1 else 1.0
    for i in range(angle.shape[1]):
        found[i] = math.nan
        begin = angle[first, i] if count > 1 else angle[last, i]
        if abs(angle[last, i] - begin) > REST * end * passed:
            continue
        away = last
        while away >= 0 and not abs(angle[away, i] - angle[last, i]) > tolerance:
            away -= 1
        if away < 0:
            found[i] = time[0]
        elif away + 1 < last:
            found[i] = time[away + 1]


@njit(void(vector_type, matrix_type, float64, vector_type), **EXACT)
def release_rows(speed: Floats, rate: Matrix, critical: float, found: Floats) -> None:
    """Row, with its fraction, at which each stalled ball breaks away; nan if it never stalled or never broke away.

    ``rate`` is that of the balls in the rotor, (T, n). A ball is stalled while it is three times nearer to the critical speed
    than to the rotor speed, at least 2 % above the critical speed. A stalled ball hangs just below the critical speed; it is
    released where it passes it for the last time, if it then comes nearer to the rotor speed.
    """
    last = speed.size - 1
    for i in range(rate.shape[1]):
        found[i] = math.nan
        stalled, hangs, below = 0, -1, -1
        for t in range(last + 1):
            margin = speed[t] - critical
            if margin > STALL_MARGIN * critical:
                excess = rate[t, i] + speed[t] - critical
                if excess < STALL_SHARE * margin:
                    stalled, hangs = stalled + 1, t
                if excess < 0.0:
                    below = t
        if stalled < 2 or rate[last, i] + speed[last] - critical < 0.5 * (speed[last] - critical):
            continue
        row = min(below if below >= 0 else hangs, last - 1)  # it hung above the critical speed: the end of the stall
        under = rate[row, i] + speed[row] - critical
        rise = rate[row + 1, i] + speed[row + 1] - critical - under
        found[i] = row + (min(max(-under / rise, 0.0), 1.0) if rise > 0.0 else 0.5)


@njit(float64(float64, vector_type), **EXACT)
def value_at(row: float, values: Floats) -> float:
    """A value at a row with a fraction, linear in between; nan where the row is."""
    if math.isnan(row):
        return math.nan
    i = min(int(row), values.size - 1)
    if i == values.size - 1:
        return values[i]
    return values[i] + (row - i) * (values[i + 1] - values[i])


@njit(void(float64, vector_type, vector_type, matrix_type, float64, vector_type), **EXACT)
def stalled_times(start: float, time: Floats, speed: Floats, rate: Matrix, critical: float, found: Floats) -> None:
    """How long each ball was stalled, s, by the rule of :func:`release_rows`; each entry stands for the time before it."""
    for i in range(rate.shape[1]):
        found[i] = 0.0
        for t in range(time.size):
            margin = speed[t] - critical
            if margin > STALL_MARGIN * critical and rate[t, i] + speed[t] - critical < STALL_SHARE * margin:
                found[i] += time[t] - (time[t - 1] if t > 0 else start)


@njit(void(vector_type, matrix_type, vector_type), **EXACT)
def fastest(speed: Floats, rate: Matrix, found: Floats) -> None:
    """Greatest amount of the speed of each ball in space, rad/s."""
    for i in range(rate.shape[1]):
        found[i] = 0.0
        for t in range(speed.size):
            found[i] = max(found[i], abs(rate[t, i] + speed[t]))


@njit(float64(vector_type, vector_type), **EXACT)
def end_of_run_up(time: Floats, speed: Floats) -> float:
    """Time from which the rotor speed stays within 0.1 % of its last value; the first time if it does from there on."""
    last = speed.size - 1
    for t in range(last - 1, -1, -1):
        if abs(speed[t] - speed[last]) > CONSTANT * abs(speed[last]):
            return time[t + 1]
    return time[0]


@njit(void(vector_type, vector_type, float64, float64, vector_type, vector_type, integers_type), **EXACT)
def counted(
    settled: Floats, released: Floats, run_up: float, start: float, jumps: Floats, duration: Floats, origin: Integers
) -> None:
    """Duration of settling of each ball, and from where it counts: the last of these times that is not after it.

    ``settled`` and ``released`` (s) are (n,), nan where there is none; ``run_up`` is the end of the run-up, ``jumps`` (s) are
    those of the unbalance. The last of them up to ``start`` counts in its place.
    """
    first, kind = start, START
    for k in range(jumps.size):
        if jumps[k] <= start and (kind == START or jumps[k] > first):
            first, kind = jumps[k], JUMP
    for i in range(settled.size):
        begin, cause = math.nan, NOWHERE
        if first <= settled[i]:
            begin, cause = first, kind
        if run_up > start and run_up <= settled[i] and not run_up <= begin:
            begin, cause = run_up, RUN_UP
        if released[i] <= settled[i] and not released[i] <= begin:
            begin, cause = released[i], RELEASE
        for k in range(jumps.size):
            if jumps[k] > start and jumps[k] <= settled[i] and not jumps[k] <= begin:
                begin, cause = jumps[k], JUMP
        duration[i], origin[i] = settled[i] - begin, cause


@njit(float64(float64), **EXACT)
def wrapped(angle: float) -> float:
    """The same angle within (-pi, pi]."""
    return math.pi - (math.pi - angle) % (2.0 * math.pi)


@njit(void(vector_type, vector_type), **EXACT)
def all_wrapped(angles: Floats, found: Floats) -> None:
    """The same of many."""
    for i in range(angles.size):
        found[i] = wrapped(angles[i])


@njit(boolean(vector_type, vector_type, float64), **EXACT)
def speed_changes(time: Floats, speed: Floats, end: float) -> bool:
    """Whether the speed still changes in the last twentieth of a run of ``end`` seconds, so that it has no steady state."""
    low, high = math.inf, -math.inf
    for t in range(time.size):
        if time[t] >= 0.95 * end:
            low, high = min(low, speed[t]), max(high, speed[t])
    return high >= low and high - low > SAME_SPEED * max(abs(low), abs(high))


@njit(boolean(vector_type, matrix_type, float64), **EXACT)
def goes_round(time: Floats, angle: Matrix, end: float) -> bool:
    """Whether a ball makes a turn in the rotor in the last twentieth of a run; ``angle`` is (T, n) in the rotor, rad."""
    last, first = time.size - 1, time.size
    while first > 0 and time[first - 1] >= 0.95 * end:
        first -= 1
    for i in range(angle.shape[1] if first <= last else 0):  # noqa: SIM110
        if abs(angle[last, i] - angle[first, i]) > 2.0 * math.pi:
            return True
    return False
