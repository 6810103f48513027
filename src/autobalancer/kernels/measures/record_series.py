"""Measures of the course of a run: its envelope over bins, and the motion of its balls over samples or the ends of bins."""

from __future__ import annotations

import math
from collections import namedtuple
from typing import Any, NamedTuple

from numba import boolean, float64, int64, types, void

from autobalancer.kernels.compiler.flags import EXACT, EXACT_PART, njit
from autobalancer.kernels.laws.contact_law import NONE, restitution_at
from autobalancer.kernels.measures import thresholds as numbers
from autobalancer.kernels.measures.observables import columns_type, square
from autobalancer.kernels.measures.workspace import (
    MeasureInputs,
    Workspace,
    complexes_type,
    inputs_type,
    workspace_type,
)
from autobalancer.kernels.records import IMPACT, MEETING
from autobalancer.kernels.system import Floats, Matrix, Rows, System, matrix_type, system_type, vector_type

# The measures that these loops take from motions, and the numbers of a row of all measures, in their order.
#
# A new one is an entry in the table of its motion, and the line of the loop that fills it by name: ``rotor_measures``,
# ``ball_measures``, ``place_measures`` or ``impact_measures``. Runs, sweeps and the documentation take it from here.


HERE = "the reference station"  # in a text; a run has the name of its own there
LATE_TURNS = "in the last revolutions"


class OfMotion(NamedTuple):
    """One of them. Of several numbers a sweep keeps the greatest, if ``of_all`` says what it is; ``known``: nan left out."""

    name: str
    unit: str
    text: str
    of_all: str = ""
    known: bool = False


OF_ROTOR = (  # from the envelope
    OfMotion("peak_deflection", "m", f"greatest deflection at {HERE}"),
    OfMotion("peak_speed", "rad/s", f"rotor speed at the greatest deflection at {HERE}"),
    OfMotion("peak_time", "s", f"time of the greatest deflection at {HERE}"),
    OfMotion("time_near_peak", "s", f"time with more than half of the greatest deflection at {HERE}"),
    OfMotion("time_at_resonance", "s", "time with a rotor speed within 10 % of a critical speed"),
)
OF_PLACES = (  # and of supports, whose forces are measured in the same way
    OfMotion(
        *("static_deflection", "m", f"static deflection {LATE_TURNS}"),
        f"greatest static deflection of all places {LATE_TURNS}",
    ),
    OfMotion(
        *("vibration", "m", "greatest distance from the mean position at the end of the run"),
        "greatest vibration of all places at the end of the run",
    ),
    OfMotion("vibration_rms", "m", f"root mean square of the vibration {LATE_TURNS}"),
    OfMotion(
        *("velocity_rms", "m/s", f"root mean square of the velocity {LATE_TURNS}"),
        f"greatest root mean square of the velocity of all places {LATE_TURNS}",
    ),
)
OF_BALLS = (
    OfMotion(
        *("break_away_speed", "rad/s", "break-away speed in the run"),
        "greatest break-away speed of a stalled ball",
        known=True,
    ),
    OfMotion(
        *("break_away_time", "s", "time in the run at which the stalled ball breaks away"),
        "time in the run at which the last stalled ball breaks away",
        known=True,
    ),
    OfMotion("stalled_time", "s", "time for which the ball is stalled", "longest time for which a ball is stalled"),
    OfMotion(
        *("greatest_ball_speed", "rad/s", "greatest speed of the ball in space"), "greatest speed of a ball in space"
    ),
)
OF_IMPACTS = (
    OfMotion("impacts", "", "impacts of balls on each other, partitions and walls"),
    OfMotion("impact_speed", "m/s", "mean speed of the impacts"),
    OfMotion("impact_power", "W", "mean power that impacts dissipate over the run"),
    OfMotion("greatest_impulse", "N s", "impulse of the hardest impact"),
    OfMotion("late_impact_rate", "1/s", "impacts a second at the end of the run"),
    OfMotion("late_impact_power", "W", "power that impacts dissipate at the end of the run"),
)

# A row: what is measured, then how the run ended: the stepper's word, time and speed, and what the verdict asks for.


OTHERS = (
    *("held_at_critical_speed", "residual_vibration", "vibration_without_balls"),
    *("residual_unbalance", "residual_share", "support_force"),
)
OTHERS_OF_BALLS = ("settling_time", "settled_at", "stalled_balls")
ENDED = (
    "status",
    "verdict",
    "end_time",
    "end_speed",
    "speed_changes",
    "goes_round",
    "vibration_before",
    "vibration_after",
    "creeps",
    "vibration_to_come",  # change, over its mean at the end
    "settling_since_release",  # settling_time, counted from the last release
)


def _names(*groups: tuple[OfMotion, ...]) -> tuple[str, ...]:
    return tuple(one.name for group in groups for one in group)


MEASURED = (*_names(OF_ROTOR, OF_PLACES), *OTHERS, *OTHERS_OF_BALLS, *_names(OF_BALLS, OF_IMPACTS))
COLUMNS = (*MEASURED, *ENDED)
WIDTH = len(COLUMNS)
# where a number stands, by name: ``COLUMN.peak_time`` in a row, the others in what the loops find of places and balls
by_name: Any = namedtuple  # which type checkers want to read
Column, Place, Ball = by_name("Column", COLUMNS), by_name("Place", _names(OF_PLACES)), by_name("Ball", _names(OF_BALLS))
COLUMN, PLACE, BALL = Column(*range(WIDTH)), Place(*range(len(OF_PLACES))), Ball(*range(len(OF_BALLS)))
KNOWN = tuple(one.known for one in OF_BALLS)


strided_type = types.Array(types.float64, 1, "A")
HALVINGS = 40  # of a bin, in which the instant of a crossing is found


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


@njit(float64(vector_type, vector_type, vector_type), **EXACT)
def crest_time(time: Floats, end: Floats, high: Floats) -> float:
    """When the greatest deflection is, s; of bins with their middles ``time``, ends (s) and greatest deflections ``high`` (m).

    What surrounds it is taken for a parabola. Then the greatest deflections of the bins beside it are at its edges, and the roots
    of how far they are below the crest are as the distances of the edges from it.
    """
    crest, last = greatest_at(high), high.size - 1
    before = math.sqrt(high[crest] - high[crest - 1]) if crest > 0 else 0.0
    after = math.sqrt(high[crest] - high[crest + 1]) if crest < last else 0.0
    place = before / (before + after) if before + after > 0.0 else 0.5
    return time[crest] + (2.0 * place - 1.0) * (end[crest] - time[crest])


@njit(float64(float64, vector_type, vector_type), **EXACT)
def value_when(now: float, time: Floats, values: Floats) -> float:
    """A value at a time, linear between those at ``time``, also beyond the first and the last."""
    t = 1
    while t < time.size - 1 and time[t] < now:
        t += 1
    if time.size < 2 or not time[t] > time[t - 1]:
        return values[0]
    return values[t - 1] + (now - time[t - 1]) / (time[t] - time[t - 1]) * (values[t] - values[t - 1])


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


@njit(float64(vector_type, vector_type, matrix_type), **EXACT)
def time_at_resonance(time: Floats, speed: Floats, whirls: Matrix) -> float:
    """Time (s) with a rotor speed within a tenth of a critical one, up to the last bin or sample; linear in between.

    nan without a critical speed.
    """
    total = 0.0 if whirls.shape[0] > 0 else math.nan
    for i in range(1, time.size):
        a, b, reached = abs(speed[i - 1]), abs(speed[i]), 0.0
        for k in range(whirls.shape[0]):  # ascending; where two ranges overlap the time counts once
            low = max((1.0 - numbers.NEAR_CRITICAL) * whirls[k, 0], reached)
            high = reached = (1.0 + numbers.NEAR_CRITICAL) * whirls[k, 0]
            if a == b:
                share = 1.0 if low <= a <= high else 0.0
            else:
                share = max(0.0, min(max(a, b), high) - max(min(a, b), low)) / abs(b - a)
            total += share * (time[i] - time[i - 1])
    return total


@njit(void(vector_type, vector_type, vector_type, vector_type, vector_type, matrix_type, vector_type), **EXACT)
def rotor_measures(
    middle: Floats, end: Floats, width: Floats, high: Floats, speed: Floats, whirls: Matrix, row: Floats
) -> None:
    """Fill what is measured of the rotor over bins: their times (s), greatest deflections (m), and speeds at their ends."""
    row[COLUMN.peak_deflection], row[COLUMN.peak_time] = high[greatest_at(high)], crest_time(middle, end, high)
    row[COLUMN.peak_speed] = value_when(row[COLUMN.peak_time], end, speed)
    row[COLUMN.time_near_peak] = time_near_peak(width, high)
    row[COLUMN.time_at_resonance] = time_at_resonance(end, speed, whirls)


@njit(float64(vector_type, vector_type, matrix_type), **EXACT)
def held_at(time: Floats, speed: Floats, whirls: Matrix) -> float:
    """The critical speed (rad/s) just below which the speed of the rotor stays at the end of a run; nan if it does not.

    That is in the last fifth of the time. Of a rotor that a torque drives: its drive does not take it past.
    """
    low, high = math.inf, 0.0
    for t in range(time.size):
        if time[t] >= numbers.LATE * time[time.size - 1]:
            low, high = min(low, abs(speed[t])), max(high, abs(speed[t]))
    middle = 0.5 * (low + high)
    if time.size > 1 and high - low <= numbers.SAME_SPEED * 2.0 * middle:
        for k in range(whirls.shape[0]):
            if (1.0 - numbers.NEAR_CRITICAL) * whirls[k, 0] < middle < whirls[k, 0]:
                return whirls[k, 0]
    return math.nan


@njit(float64(vector_type, vector_type, float64), **EXACT)
def last_deflection(time: Floats, high: Floats, begin: float) -> float:
    """The greatest of ``high`` (m) from ``begin`` (s) on, the last one in any case."""
    found = high[high.size - 1]
    for i in range(high.size - 1):
        if time[i] >= begin and high[i] > found:
            found = high[i]
    return found


@njit(types.UniTuple(float64, 2)(vector_type, strided_type, strided_type, float64, float64, float64), **EXACT)
def drift(
    time: Floats, values: Floats, others: Floats, share: float, begin: float, least: float
) -> tuple[float, float]:
    """Where values go: their mean in the last third of the time from ``begin`` to the end, and the change still to come.

    The values are ``values`` less a ``share`` of ``others``. Means of the thirds of an exponential approach are a geometric
    series; the change to come is its sum. It is infinite where the changes do not become smaller, and zero where the last one is
    smaller than ``least`` or than a fifth of the spread in the last third, or has another sign; nan without any time.
    """
    last = time.size - 1
    begin = max(begin, time[0])
    third = (time[last] - begin) / 3.0
    if not third > 0.0:
        return math.nan, math.nan
    first, second, mean, low, high = 0.0, 0.0, 0.0, math.inf, -math.inf
    for k in range(3):
        since, until, total = begin + k * third, begin + (k + 1) * third, 0.0
        for t in range(last, 0, -1):  # linear between two values
            if time[t] <= since:
                break
            left, right = max(time[t - 1], since), min(time[t], until)
            if left >= right:
                continue
            one, other = values[t - 1] - share * others[t - 1], values[t] - share * others[t]
            middle = (0.5 * (left + right) - time[t - 1]) / (time[t] - time[t - 1])
            total += (right - left) * (one + middle * (other - one))
            if k == 2:
                low, high = min(low, other), max(high, other)
        first, second, mean = second, total / third - mean, total / third
    if abs(second) <= max(least, numbers.TREND * (high - low)) or first * second <= 0.0:
        return mean, 0.0
    if abs(second) >= abs(first):
        return mean, math.copysign(math.inf, second)
    return mean, second * second / (first - second)


@njit(float64(vector_type, matrix_type, matrix_type, int64, float64, float64, float64), **EXACT)
def within_since(
    time: Floats, angle: Matrix, rate: Matrix, i: int, goal: float, tolerance: float, start: float
) -> float:
    """Time from which ball i stays within ``tolerance`` of an angle; ``start`` if it always was, nan if it is not at the end.

    Between two samples the angle is the cubic of both angles and rates.
    """
    away = time.size - 1
    if not abs(angle[away, i] - goal) <= tolerance:
        return math.nan
    while away >= 0 and abs(angle[away, i] - goal) <= tolerance:
        away -= 1
    if away < 0:
        return start
    step, a, b = time[away + 1] - time[away], angle[away, i], angle[away + 1, i]
    u, v = step * rate[away, i], step * rate[away + 1, i]
    outside, inside = 0.0, 1.0
    for _ in range(HALVINGS):
        s = 0.5 * (outside + inside)
        there = a + s * (u + s * (3.0 * (b - a) - 2.0 * u - v + s * (u + v - 2.0 * (b - a))))
        if abs(there - goal) <= tolerance:
            inside = s
        else:
            outside = s
    return time[away] + inside * step


@njit(void(vector_type, matrix_type, matrix_type, float64, float64, vector_type), **EXACT)
def settled_from(time: Floats, angle: Matrix, rate: Matrix, start: float, tolerance: float, found: Floats) -> None:
    """Time from which each ball stays within ``tolerance`` (rad) of the angle to which it goes; nan if it has not settled.

    ``angle`` and ``rate`` are (T, n), in the rotor; ``start`` (s) is where the first step begins. A ball has settled that has
    been within the tolerance of its last angle for a twentieth of the time, and whose way still to come, extrapolated from how
    it moved in the second half of this time, is not longer than the tolerance. Where it turned round in this half, its second
    half counts.
    """
    last = time.size - 1
    for i in range(angle.shape[1]):
        found[i] = math.nan
        since = within_since(time, angle, rate, i, angle[last, i], tolerance, start)
        if not time[last] - since >= numbers.LAST * (time[last] - start):
            continue
        least, stay = numbers.LEAST_DRIFT * tolerance, time[last] - since
        mean_angle, to_come = drift(time, angle[:, i], angle[:, i], 0.0, time[last] - 0.5 * stay, least)
        if math.isinf(to_come):
            mean_angle, to_come = drift(time, angle[:, i], angle[:, i], 0.0, time[last] - 0.25 * stay, least)
        found[i] = within_since(time, angle, rate, i, mean_angle + to_come, tolerance, start)


@njit(boolean(vector_type, matrix_type, vector_type, float64, float64), **EXACT)
def creeps(time: Floats, angle: Matrix, settled: Floats, since: float, end: float) -> bool:
    """Whether a ball that has not ``settled`` (n,) drifts in one direction in the last fifth of a run of ``end`` seconds.

    That is after ``since`` (s), when the run-up ended and the unbalance jumped last. ``angle`` is (T, n) in the rotor, rad.
    """
    begin = max(since, numbers.LATE * end)
    for i in range(angle.shape[1]):
        if math.isnan(settled[i]):
            _, to_come = drift(time, angle[:, i], angle[:, i], 0.0, begin, numbers.LEAST_DRIFT * numbers.SETTLED)
            if abs(to_come) > 0.0:
                return True
    return False


@njit(float64(vector_type, vector_type, vector_type, float64, float64, int64), **EXACT)
def vibration_to_come(time: Floats, low: Floats, high: Floats, since: float, end: float, centered: int) -> float:
    """Change of the vibration that is still to come, over the vibration at the end of a run; nan if it is not known.

    It is extrapolated from the last fifth of a run of ``end`` seconds, after ``since`` (s), when the run-up ended and the
    unbalance jumped last. ``time`` are the middles of bins.
    """
    if time.size == 0:
        return math.nan
    share, last = 0.0 if centered != 0 else 1.0, time.size - 1  # else the range
    least = numbers.LEAST_CHANGE * (high[last] - share * low[last])
    mean_size, to_come = drift(time, high, low, share, max(since, numbers.LATE * end), least)
    return to_come / mean_size if mean_size > 0.0 else math.nan


# Which balls are stalled: the one rule for runs, sweeps, studies, basins, stepped responses and films.
#
# A rotor that runs above a critical speed w_c leaves there a whirl with the frequency f. It is w_c unless gyroscopic moments
# raise it: of a mode with the share g of these in its inertia, f^2 - g w f = (1 - g) w_c^2 at the rotor speed w. A ball hangs at
# a whirl that the rotor has passed by 2 % where its speed in space is twice as near to f as to w, or below f, where a weak drag
# keeps it, down to half of f. It is stalled if it so goes round in the rotor once or more, counted from where the rotor passes f.


@njit(boolean(float64, float64, matrix_type, float64), **EXACT)
def hangs(own: float, speed: float, whirls: Matrix, margin: float) -> bool:
    """Whether a ball with the speed ``own`` in space hangs at a whirl that the rotor with its ``speed`` passed by a ``margin``.

    The margin is relative. ``whirls`` are (K, 2): critical speeds (rad/s), ascending, and the gyroscopic share of each.
    """
    size, own = abs(speed), math.copysign(1.0, speed) * own
    for k in range(whirls.shape[0]):
        critical, share = whirls[k, 0], whirls[k, 1]
        turned = share * size
        whirl = 0.5 * (turned + math.sqrt(turned * turned + 4.0 * (1.0 - share) * critical * critical))
        ahead = size - whirl
        if ahead > margin * whirl and numbers.STALL_LEAST * whirl < own < whirl + numbers.STALL_SHARE * ahead:
            return True
    return False


@njit(float64(strided_type, vector_type, int64, matrix_type), **EXACT)
def hanging_part(rate: Floats, speed: Floats, row: int, whirls: Matrix) -> float:
    """Which part of the way from a row, in which a ball hangs, to the next it still hangs; both speeds are linear there."""
    inside, outside = 0.0, 1.0
    for _ in range(HALVINGS):
        s = 0.5 * (inside + outside)
        rotor = speed[row] + s * (speed[row + 1] - speed[row])
        if hangs(rate[row] + s * (rate[row + 1] - rate[row]) + rotor, rotor, whirls, numbers.STALL_MARGIN):
            inside = s
        else:
            outside = s
    return inside


@njit(void(float64, vector_type, vector_type, matrix_type, matrix_type, matrix_type, matrix_type), **EXACT)
def stalls(
    start: float, time: Floats, speed: Floats, angle: Matrix, rate: Matrix, whirls: Matrix, found: Matrix
) -> None:
    """How long each ball is stalled (s); in which row, with its fraction, it breaks away; its speed at the end if stalled.

    ``angle`` and ``rate`` are those of the balls in the rotor, (T, n), ``found`` is (3, n); each entry stands for the time before
    it. A ball breaks away where it hangs for the last time, if it then makes up for half of its lag; nan if it does not. Its
    speed at the end (rad/s) is the mean of the last twentieth; nan if it does not hang there.
    """
    last, margin = time.size - 1, numbers.STALL_MARGIN
    late = last
    while late > 0 and (late == last or time[late - 1] >= (1.0 - numbers.LAST) * time[last]):
        late -= 1
    rotor, duration = mean(speed[late:]), time[last] - time[late]
    for i in range(rate.shape[1]):
        found[0, i], found[1, i], found[2, i] = 0.0, math.nan, math.nan
        until, own = last, 0.0
        if duration > 0.0 and hangs(rotor + (angle[last, i] - angle[late, i]) / duration, rotor, whirls, margin):
            own = rotor + (angle[last, i] - angle[late, i]) / duration
        else:
            # back to where it hangs for the last time; does it gain on the rotor then?
            while until >= 0 and not hangs(rate[until, i] + speed[until], speed[until], whirls, margin):
                until -= 1
            gained = 0.0
            for t in range(max(until, 0), last + 1):
                gained = max(gained, abs(rate[t, i] + speed[t]) - abs(rate[until, i] + speed[until]))
            if 0 <= until < last and gained > 0.5 * abs(rate[until, i]):
                found[1, i] = until + hanging_part(rate[:, i], speed, until, whirls)
        # the time for which it hangs, and how far it falls behind
        turned = 0.0
        for t in range(until + 1):
            step = time[t] - (time[t - 1] if t > 0 else start)
            if hangs(rate[t, i] + speed[t], speed[t], whirls, margin):
                found[0, i] += step
            if hangs(rate[t, i] + speed[t], speed[t], whirls, 0.0):
                turned += abs(rate[t, i]) * step
        if turned < 2.0 * math.pi:
            found[0, i], found[1, i] = 0.0, math.nan
        elif own != 0.0:
            found[2, i] = own


@njit(float64(float64, vector_type), **EXACT)
def value_at(row: float, values: Floats) -> float:
    """A value at a row with a fraction, linear in between; nan where the row is."""
    if math.isnan(row):
        return math.nan
    i = min(int(row), values.size - 1)
    if i == values.size - 1:
        return values[i]
    return values[i] + (row - i) * (values[i + 1] - values[i])


@njit(void(vector_type, vector_type, matrix_type, matrix_type, matrix_type, matrix_type), **EXACT)
def ball_measures(time: Floats, speed: Floats, angle: Matrix, rate: Matrix, hung: Matrix, found: Matrix) -> None:
    """Fill what is measured of each ball, (OF_BALLS, n); ``hung`` is what :func:`stalls` found, the rest as there."""
    for i in range(angle.shape[1]):
        found[BALL.break_away_speed, i] = value_at(hung[1, i], speed)
        found[BALL.break_away_time, i] = value_at(hung[1, i], time)
        found[BALL.stalled_time, i] = hung[0, i]
        fastest = 0.0
        for t in range(speed.size):
            fastest = max(fastest, abs(rate[t, i] + speed[t]))
        found[BALL.greatest_ball_speed, i] = fastest


@njit(float64(vector_type, vector_type, float64), **EXACT)
def end_of_run_up(time: Floats, speed: Floats, start: float) -> float:
    """Time from which the rotor speed stays within 0.1 % of its last value; ``start`` if it always does.

    Between two samples the speed goes on as before, up to the second one: exact where a ramp ends between them.
    """
    last = speed.size - 1
    limit = numbers.CONSTANT * abs(speed[last])
    for t in range(last - 1, -1, -1):
        off = abs(speed[t] - speed[last]) - limit
        if off > 0.0:
            step = time[t + 1] - time[t]
            slope = (off + limit - abs(speed[t + 1] - speed[last])) / step
            if t > 0:
                slope = max(slope, (abs(speed[t - 1] - speed[last]) - limit - off) / (time[t] - time[t - 1]))
            return time[t] + min(off / slope, step) if slope > 0.0 else time[t + 1]
    return start


@njit(types.Tuple((float64, int64))(float64, int64, float64, float64, vector_type), **EXACT)
def origin_of(after: float, cause: int, start: float, end: float, jumps: Floats) -> tuple[float, int]:
    """From when settling counts in a run from ``start`` to ``end`` (s), and what happened then.

    That is ``after`` (s, what ``cause`` says; nan if it did not happen) or a jump of the unbalance, whichever is later; if there
    is neither, the start, or the last jump up to then.
    """
    begin, kind = start, numbers.START
    for k in range(jumps.size):
        if jumps[k] <= start and (kind == numbers.START or jumps[k] > begin):
            begin, kind = jumps[k], numbers.JUMP
    if after > start:
        begin, kind = after, cause
    for k in range(jumps.size):
        if start < jumps[k] <= end and jumps[k] >= begin:
            begin, kind = jumps[k], numbers.JUMP
    return begin, kind


@njit(float64(float64, float64), **EXACT)
def time_since(begin: float, settled: float) -> float:
    """How long after ``begin`` a ball has settled, s: zero if it had before, nan if it has not."""
    return 0.0 if settled <= begin else settled - begin


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
    return high >= low and high - low > numbers.SAME_SPEED * max(abs(low), abs(high))


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


# Whether a run is balanced, by the rule of results/verdict.py.


FIRST = numbers.LIMITS[0]
REVOLUTIONS = 10.0  # so that each of the last twentieths has half of one, in which a vibration shows its extremes


@njit(float64(vector_type, vector_type, vector_type, float64, float64, int64), **EXACT)
def twentieth(time: Floats, low: Floats, high: Floats, end: float, begin: float, centered: int) -> float:
    """Vibration at the reference station in the twentieth of a run from a share of it on, m; nan without an envelope there."""
    least, greatest, any_of = math.inf, -math.inf, False
    for b in range(time.size):
        if begin * end < time[b] <= (begin + 0.05) * end:
            least, greatest, any_of = min(least, low[b]), max(greatest, high[b]), True
    if not any_of:
        return math.nan
    return greatest if centered != 0 else 0.5 * (greatest - least)


@njit(int64(boolean, boolean, boolean, float64, float64, float64, float64, float64), **EXACT)
def changing(
    speed: bool,
    uneven: bool,
    creeps: bool,
    before: float,
    after: float,
    to_come: float,
    vibration: float,
    without: float,
) -> int:
    """Why a run has no verdict: its speed changes, or its vibration, ``before`` and ``after`` in the last two twentieths (m).

    ``uneven``: a ball goes round in the rotor; ``creeps``: one that has not settled drifts. ``to_come`` is the change of the
    vibration that is still to come, over what it is; nan if that is not known. ``vibration`` and ``without`` are the greatest of
    all places, that without balls (m): below a tenth of it a vibration may change.
    """
    if speed:
        return numbers.SPEED_CHANGES
    if creeps and not uneven and vibration > FIRST * without:
        return numbers.VIBRATION_CHANGES
    greater, smaller = max(before, after), min(before, after)
    if greater > FIRST * without:
        if greater > (numbers.UNEVEN if uneven else numbers.SAME_VIBRATION) * smaller:
            return numbers.VIBRATION_CHANGES
        if not uneven and (1.0 + to_come > numbers.SAME_VIBRATION or (1.0 + to_come) * numbers.SAME_VIBRATION < 1.0):
            return numbers.VIBRATION_CHANGES
    return numbers.STEADY


@njit(boolean(float64, float64), **EXACT)
def too_short(end: float, speed: float) -> bool:
    """Whether a run of ``end`` seconds has too few revolutions at its last ``speed`` (rad/s) to tell where it goes."""
    return end * abs(speed) < REVOLUTIONS * 2.0 * math.pi


@njit(int64(float64), **EXACT)
def class_of(ratio: float) -> int:
    """The verdict on a vibration with balls over that without."""
    if math.isnan(ratio):
        return numbers.NO_VERDICT
    for k in range(len(numbers.LIMITS)):
        if ratio <= numbers.LIMITS[k]:
            return k
    return len(numbers.LIMITS)


# What the impacts of a run say of its noise and wear.


@njit(types.UniTuple(float64, 2)(MEETING.row_type, vector_type, float64), **EXACT_PART)
def loss_and_impulse(meeting: Rows, laws: Floats, speed: float) -> tuple[float, float]:
    """Energy that an impact at a speed dissipates (J), and its impulse (N s)."""
    left = meeting.restitution
    if meeting.law != NONE:
        left = max(restitution_at(laws, meeting.law, speed), meeting.least)
    return 0.5 * meeting.mass * speed * speed * (1.0 - left * left), meeting.mass * speed * (1.0 + left)


@njit(void(IMPACT.rows_type(), MEETING.rows_type(), vector_type, matrix_type), **EXACT)
def losses_and_impulses(rows: Rows, meetings: Rows, laws: Floats, found: Matrix) -> None:
    """The same of all impacts, (2, I)."""
    for k in range(rows.shape[0]):
        found[0, k], found[1, k] = loss_and_impulse(meetings[rows[k].touch], laws, rows[k].speed)


@njit(void(vector_type, vector_type, vector_type, vector_type, int64, float64, float64, vector_type), **EXACT)
def impact_measures(
    time: Floats, speed: Floats, lost: Floats, impulse: Floats, count: int, late: float, end: float, row: Floats
) -> None:
    """Number, mean speed (m/s), mean power (W) and greatest impulse (N s); rate (1/s) and power from the time ``late`` on."""
    total, energy, greatest, last, spent = 0.0, 0.0, 0.0, 0, 0.0
    for k in range(count):
        total += speed[k]
        greatest = max(greatest, impulse[k])
        if 0.0 <= time[k] <= end:
            energy += lost[k]
        if late <= time[k] <= end:
            last += 1
            spent += lost[k]
    row[COLUMN.impacts] = count
    row[COLUMN.impact_speed] = total / count if count > 0 else math.nan
    row[COLUMN.impact_power] = energy / end if end > 0.0 else math.nan
    row[COLUMN.greatest_impulse] = greatest
    row[COLUMN.late_impact_rate] = last / (end - late) if end > late else math.nan
    row[COLUMN.late_impact_power] = spent / (end - late) if end > late else math.nan


@njit(void(system_type, inputs_type, workspace_type), **EXACT_PART)
def collect_impacts(p: System, g: MeasureInputs, d: Workspace) -> None:
    """Take over the impacts that the equations noted, and empty their room; call it after every call of the stepper."""
    if p.touches.shape[0] == 0:
        return
    seen = p.impact_count[0]
    for k in range(min(seen, p.impacts.shape[0])):
        to = d.noted[0]
        if to < d.hits.shape[1]:
            one = p.impacts[k]
            lost, impulse = loss_and_impulse(g.meetings[one.touch], g.rebounds, one.speed)
            d.hits[0, to], d.hits[1, to], d.hits[2, to], d.hits[3, to] = one.time, one.speed, lost, impulse
            d.noted[0] = to + 1
    p.impact_count[0] = 0


@njit(float64(columns_type, int64, int64, types.complex128), **EXACT_PART)
def one_way_rms(z: Any, k: int, count: int, mean: complex) -> float:
    """Root mean square of column k along the direction in which it is greatest."""
    size, turned = 0.0, complex(0.0, 0.0)
    for t in range(count):
        a = z[t, k] - mean
        size += square(a)
        turned += a * a
    return math.sqrt(0.5 * (size + math.sqrt(square(turned))) / count)


@njit(void(columns_type, columns_type, int64, complexes_type, matrix_type), **EXACT)
def place_measures(z: Any, v: Any, count: int, mean: Any, found: Matrix) -> None:
    """Fill what is measured of each place or support, (OF_PLACES, columns or more), from ``count`` rows and the ``mean`` place.

    It is how far that is from zero, the greatest distance from it, and rms of this and of the velocity along the direction in
    which they are greatest.
    """
    for k in range(z.shape[1]):
        greatest = 0.0
        for t in range(count):
            greatest = max(greatest, square(z[t, k] - mean[k]))
        found[PLACE.static_deflection, k] = math.sqrt(square(mean[k]))
        found[PLACE.vibration, k] = math.sqrt(greatest)
        found[PLACE.vibration_rms, k] = one_way_rms(z, k, count, mean[k])
        found[PLACE.velocity_rms, k] = one_way_rms(v, k, count, complex(0.0, 0.0))


@njit(float64(columns_type, int64, int64), **EXACT_PART)
def size_of_mean(z: Any, k: int, count: int) -> float:
    """Size of the mean of column k: what swings to and fro in the rotor is no unbalance of it."""
    x, y = 0.0, 0.0
    for t in range(count):
        x, y = x + z[t, k].real, y + z[t, k].imag
    x, y = x / count, y / count
    return math.sqrt(x * x + y * y)


@njit(float64(columns_type, int64, int64), **EXACT_PART)
def mean_size(z: Any, k: int, count: int) -> float:
    """Mean size of column k."""
    total = 0.0
    for t in range(count):
        total += math.sqrt(square(z[t, k]))
    return total / count


@njit(void(complexes_type, vector_type), **EXACT)
def sizes(z: Any, found: Floats) -> None:
    """Size of each x + i y."""
    for k in range(z.size):
        found[k] = math.sqrt(square(z[k]))


@njit(void(complexes_type, vector_type), **EXACT)
def directions(z: Any, found: Floats) -> None:
    """Angle of each, rad."""
    for k in range(z.size):
        found[k] = math.atan2(z[k].imag, z[k].real)
