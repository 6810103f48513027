"""All measures of a finished run as one row of numbers.

For each run: ``start(workspace)``, then after every call of the stepper ``collect_impacts(p, inputs, workspace)``, and at the
end ``measure_row(p, record, memory, inputs, workspace, status, row)``. The inputs are those of the machine
(assembly/places.py); runs that differ only in drag, drive, unbalance or start share them. The workspace is room that
each thread has for itself. ``row`` has ``WIDTH + n`` numbers: those named in ``record_series.py``, then for each of the
n balls its final angle from the unbalance; nan stands for what a run cannot say. None of it needs Python or its lock. Only
softening rubber asks for more afterwards: the vibration without balls, and with it the verdict, see ``completed`` in
studies/variations.py.
"""

from __future__ import annotations

import math

from numba import float64, int64, void

from autobalancer.kernels.compiler.flags import EXACT, EXACT_PART, njit
from autobalancer.kernels.host.shaft_train import drive_value, motor_torque
from autobalancer.kernels.integrators.integrator_state import NEXT_BIN, NEXT_TURN, TIME, Memory, memory_type
from autobalancer.kernels.integrators.recording import Record, record_type
from autobalancer.kernels.integrators.runge_kutta import FINISHED
from autobalancer.kernels.measures import record_series as series
from autobalancer.kernels.measures import thresholds
from autobalancer.kernels.measures.observables import (
    ball_at,
    observe,
    observe_locked_balls,
    standing,
    turns_of,
    unbalance_at,
)
from autobalancer.kernels.measures.record_series import BALL, COLUMN, COLUMNS, KNOWN, PLACE, WIDTH
from autobalancer.kernels.measures.workspace import (
    CENTERED,
    HELD,
    RESOLVED,
    MeasureInputs,
    Workspace,
    inputs_type,
    workspace_type,
)
from autobalancer.kernels.records import PRESCRIBED
from autobalancer.kernels.system import (
    SPEED,
    THETA,
    Floats,
    Matrix,
    System,
    matrix_type,
    system_type,
    vector_type,
)

# where a row has what is measured of places and of balls
OF_PLACES, OF_BALLS = COLUMNS.index(PLACE._fields[0]), COLUMNS.index(BALL._fields[0])


@njit(void(workspace_type), **EXACT_PART)
def start(d: Workspace) -> None:
    """Before a run: forget the impacts of the one before."""
    d.noted[0] = 0


@njit(int64(record_type, memory_type, inputs_type, workspace_type), **EXACT_PART)
def _bins(r: Record, m: Memory, g: MeasureInputs, d: Workspace) -> int:
    """The whole bins, the last one cut off where the run ended early, to the workspace; how many there are."""
    count, n, size = m.counts[NEXT_BIN], g.ball_mass.size, g.rows.shape[0]
    resolved = 1 if g.scalars[RESOLVED] != 0.0 else 0
    whole, now = count, m.clock[TIME]
    if count < r.bin_low.size and math.isfinite(r.bin_high[count]) and now > r.bin_edges[count]:
        count += 1
    for b in range(count):
        y = r.bin_states[b] if b < whole else m.state
        d.end[b] = r.bin_edges[b + 1] if b < whole else now
        d.middle[b] = 0.5 * (r.bin_edges[b] + d.end[b])
        d.width[b] = 2.0 * (d.end[b] - d.middle[b])
        d.speed[b] = y[SPEED]
        for i in range(n):
            d.angle[b, i], d.rate[b, i] = ball_at(y, i, n, size, resolved)
    return count


@njit(float64(system_type, vector_type, vector_type, matrix_type, float64), **EXACT)
def held_at_critical_speed(p: System, time: Floats, speed: Floats, whirls: Matrix, now: float) -> float:
    """The critical speed (rad/s) just below which the rotor stays although its drive has torque left there; nan if it does not.

    ``time`` (s) and ``speed`` (rad/s) are those of a run that ends ``now``.
    """
    held = series.held_at(time, speed, whirls)
    if p.drive.motor == PRESCRIBED or math.isnan(held):
        return math.nan
    way = math.copysign(1.0, speed[speed.size - 1])
    return held if way * motor_torque(drive_value(now, p.drive)[0], way * held, p.drive) > 0.0 else math.nan


@njit(void(system_type, record_type, inputs_type, workspace_type, int64, float64, vector_type), **EXACT_PART)
def _course(p: System, r: Record, g: MeasureInputs, d: Workspace, count: int, now: float, row: Floats) -> None:
    """What the envelope says."""
    time, middle, speed = d.end[:count], d.middle[:count], d.speed[:count]
    low, high, angle, rate = r.bin_low[:count], r.bin_high[:count], d.angle[:count], d.rate[:count]
    centered = 1 if g.scalars[CENTERED] != 0.0 else 0
    # the rotor
    series.rotor_measures(middle, time, d.width[:count], high, speed, g.whirls, row)
    row[COLUMN.held_at_critical_speed] = held_at_critical_speed(p, time, speed, g.whirls, now)
    row[COLUMN.speed_changes] = 1.0 if series.speed_changes(time, speed, now) else 0.0
    row[COLUMN.goes_round] = 1.0 if series.goes_round(time, angle, now) else 0.0
    row[COLUMN.vibration_before] = series.twentieth(middle, low, high, now, 0.9, centered)
    row[COLUMN.vibration_after] = series.twentieth(middle, low, high, now, 0.95, centered)
    if centered == 1:
        row[COLUMN.residual_vibration] = series.last_deflection(middle, high, now - thresholds.LAST * now)
    # from when settling counts
    n, begin = g.ball_mass.size, r.bin_edges[0]
    run_up = series.end_of_run_up(time, speed, begin)
    since, cause = series.origin_of(run_up, thresholds.RUN_UP, begin, now, g.jumps)
    row[COLUMN.vibration_to_come] = series.vibration_to_come(middle, low, high, since, now, centered)
    # the balls: settled, released, stalled; the last one counts
    if n == 0:
        return
    settled, hung, found = d.of_balls[0], d.of_balls[1:4], d.of_balls[4:]
    series.settled_from(time, angle, rate, begin, thresholds.SETTLED, settled)
    series.stalls(begin, time, speed, angle, rate, g.whirls, hung)
    series.ball_measures(time, speed, angle, rate, hung, found)
    for k in range(found.shape[0]):
        greatest = series.greatest_known(found[k]) if KNOWN[k] else found[k, series.greatest_at(found[k])]
        row[OF_BALLS + k] = greatest
    row[COLUMN.creeps] = 1.0 if series.creeps(time, angle, settled, since, now) else 0.0
    last = settled[series.greatest_at(settled)]
    held = cause != thresholds.JUMP and math.isfinite(
        row[COLUMN.held_at_critical_speed]
    )  # then the run-up does not end
    row[COLUMN.settled_at], row[COLUMN.settling_time] = last, math.nan if held else series.time_since(since, last)
    row[COLUMN.settling_since_release] = row[COLUMN.settling_time]
    if row[COLUMN.break_away_time] > begin:
        free, _ = series.origin_of(row[COLUMN.break_away_time], thresholds.RELEASE, begin, now, g.jumps)
        row[COLUMN.settling_since_release] = series.time_since(free, last)
    row[COLUMN.stalled_balls] = 0.0
    for i in range(n):
        row[COLUMN.stalled_balls] += 0.0 if math.isnan(hung[2, i]) else 1.0
    x, y = unbalance_at(time[count - 1], p)
    for i in range(n):
        row[WIDTH + i] = series.wrapped(angle[count - 1, i] - math.atan2(y, x))


@njit(void(system_type, record_type, memory_type, inputs_type, workspace_type, vector_type), **EXACT_PART)
def _turns(p: System, r: Record, m: Memory, g: MeasureInputs, d: Workspace, row: Floats) -> None:
    """What the last revolutions say; nothing without a whole one."""
    kept, written = r.turn_states.shape[0], m.counts[NEXT_TURN]
    oldest, there = (written % kept, kept) if written > kept else (0, written)
    for t in range(there):
        d.rotor[t] = r.turn_states[(oldest + t) % kept, 1 + THETA]
    # whole revolutions only, as means over a part of one would be wrong
    count = turns_of(d.rotor[:there])
    if count == 0:
        return
    places, supports, n = g.rows.shape[1] // 2, g.weight.size // 2, g.ball_mass.size
    several = 1 if g.capability.size > 1 else 0
    observe(p, g, r.turn_states, (oldest + there - count) % kept, count, several, d)
    seen, centered = d.seen, 1 if g.scalars[CENTERED] != 0.0 else 0
    z, v, force = seen.z[:count], seen.v[:count], seen.force[:count]
    # deflections and their mean, then forces
    standing(z, count, d.rotor, seen.angles, centered, d.columns, d.small, d.mean)
    found, vibration = d.of_places[2:], d.of_places[2 + PLACE.vibration]
    series.place_measures(z, v, count, d.mean, found)
    if centered == 0:
        row[COLUMN.residual_vibration] = vibration[0]
    elif row[COLUMN.residual_vibration] > vibration[0]:  # slow changes in the last twentieth count there too
        vibration[0] = row[COLUMN.residual_vibration]
    for k in range(found.shape[0]):
        row[OF_PLACES + k] = found[k, series.greatest_at(found[k, :places])]
    standing(force, count, d.rotor, seen.angles, centered, d.columns, d.small, d.mean)
    series.place_measures(force, force, count, d.mean, found)
    row[COLUMN.support_force] = vibration[series.greatest_at(vibration[:supports])] if supports > 0 else 0.0
    if n == 0:
        return
    # unbalance with and without the balls; of several planes the sum of their sizes
    wanted, left = series.mean_size(seen.unbalance, 0, count), series.size_of_mean(seen.left, 0, count)
    if several == 1:
        left = 0.0
        for t in range(count):
            total = 0.0
            for k in range(g.capability.size):
                one = seen.wanted[t, k]
                total += math.sqrt(one.real**2 + one.imag**2)
                seen.held[t, k] += one
            seen.unbalance[t, 0] = total
        for k in range(g.capability.size):
            left += series.size_of_mean(seen.held, k, count)
        wanted = series.mean_size(seen.unbalance, 0, count)
    row[COLUMN.residual_unbalance] = left
    row[COLUMN.residual_share] = left / wanted if wanted > 0.0 else math.nan
    if g.scalars[HELD] == thresholds.LINEAR and abs(m.state[SPEED]) < thresholds.FASTEST:
        observe_locked_balls(p, g, m.clock[TIME], m.state[SPEED], d, d.of_places[0], d.of_places[1])
        row[COLUMN.vibration_without_balls] = d.of_places[0, series.greatest_at(d.of_places[0, :places])]


@njit(int64(vector_type), **EXACT)
def judged(row: Floats) -> int:
    """The verdict on a row that has everything else."""
    # no verdict without a vibration to compare with: that of the same rotor with its balls held
    without = row[COLUMN.vibration_without_balls]
    if row[COLUMN.status] != FINISHED or not without > 0.0:
        return thresholds.NO_VERDICT
    vibration, before, after = row[COLUMN.vibration], row[COLUMN.vibration_before], row[COLUMN.vibration_after]
    speed, uneven, moves = row[COLUMN.speed_changes] != 0.0, row[COLUMN.goes_round] != 0.0, row[COLUMN.creeps] == 1.0
    # a run that still changes is not judged, nor one that is too short to tell
    reason = series.changing(speed, uneven, moves, before, after, row[COLUMN.vibration_to_come], vibration, without)
    if reason != thresholds.SPEED_CHANGES and series.too_short(row[COLUMN.end_time], row[COLUMN.end_speed]):
        return thresholds.NOT_SETTLED
    if reason == thresholds.STEADY:
        return series.class_of(vibration / without)
    return thresholds.NO_VERDICT if reason == thresholds.SPEED_CHANGES else thresholds.NOT_SETTLED


@njit(void(system_type, record_type, memory_type, inputs_type, workspace_type, int64, vector_type), **EXACT)
def measure_row(p: System, r: Record, m: Memory, g: MeasureInputs, d: Workspace, status: int, row: Floats) -> None:
    """Fill the row of a run that ended with ``status`` with what its envelope and last revolutions say, where it kept them."""
    for k in range(row.size):
        row[k] = math.nan
    # what is known of any run
    now = m.clock[TIME]
    row[COLUMN.status], row[COLUMN.verdict] = status, thresholds.NO_VERDICT
    row[COLUMN.end_time], row[COLUMN.end_speed] = now, m.state[SPEED]
    # from the envelope, if there is one; else only where the balls are
    count = _bins(r, m, g, d)
    if count > 0:
        _course(p, r, g, d, count, now, row)
    elif r.bin_low.size > 0:
        return
    else:  # without an envelope: the angles of the last state
        n, size, resolved = g.ball_mass.size, g.rows.shape[0], 1 if g.scalars[RESOLVED] != 0.0 else 0
        x, y = unbalance_at(now, p)
        for i in range(n):
            row[WIDTH + i] = series.wrapped(ball_at(m.state, i, n, size, resolved)[0] - math.atan2(y, x))
    # from the last revolutions, then the impacts, and last the verdict on all of it
    _turns(p, r, m, g, d, row)
    if p.touches.shape[0] > 0:
        hits = d.hits
        series.impact_measures(hits[0], hits[1], hits[2], hits[3], d.noted[0], now - thresholds.LAST * now, now, row)
    row[COLUMN.verdict] = judged(row)
