"""What the impacts of a run say of its noise and wear."""

from __future__ import annotations

import math

from numba import float64, int64, types, void

from autobalancer.kernels.flags import EXACT, EXACT_PART, njit
from autobalancer.kernels.measures.gauges import Desk, Gauges, desk_type, gauges_type
from autobalancer.kernels.measures.limits import COUNT, IMPULSE, LATE_POWER, LATE_RATE, POWER, SPEED
from autobalancer.kernels.records.impacts import IMPACT, MEETING
from autobalancer.kernels.system import Floats, Matrix, Rows, System, matrix_type, system_type, vector_type


@njit(float64(MEETING.row_type, matrix_type, float64), **EXACT_PART)
def restitution(meeting: Rows, points: Matrix, speed: float) -> float:
    """What an impact at a speed leaves of it."""
    if meeting.falls == 0:
        return meeting.restitution
    factor, first, last = 1.0, meeting.first, meeting.first + meeting.points - 1
    if speed > meeting.yield_speed:
        factor = (meeting.yield_speed / speed) ** meeting.exponent
    if meeting.points > 0:
        k = first
        while k < last and points[k + 1, 0] <= speed:
            k += 1
        factor = points[k, 1]
        if k < last and speed > points[k, 0]:
            rise = (points[k + 1, 1] - points[k, 1]) / (points[k + 1, 0] - points[k, 0])
            factor += rise * (speed - points[k, 0])
    if meeting.slowest > 0.0:
        factor *= 1.0 - meeting.slowest / max(speed, meeting.slowest)
    return max(meeting.restitution * factor, meeting.least)


@njit(types.UniTuple(float64, 2)(MEETING.row_type, matrix_type, float64), **EXACT_PART)
def meant(meeting: Rows, points: Matrix, speed: float) -> tuple[float, float]:
    """Energy that an impact at a speed dissipates (J), and its impulse (N s)."""
    left = restitution(meeting, points, speed)
    return 0.5 * meeting.mass * speed * speed * (1.0 - left * left), meeting.mass * speed * (1.0 + left)


@njit(void(IMPACT.rows_type(), MEETING.rows_type(), matrix_type, matrix_type), **EXACT)
def all_meant(rows: Rows, meetings: Rows, points: Matrix, found: Matrix) -> None:
    """The same of all impacts, (2, I)."""
    for k in range(rows.shape[0]):
        found[0, k], found[1, k] = meant(meetings[rows[k].touch], points, rows[k].speed)


@njit(void(vector_type, vector_type, vector_type, vector_type, int64, float64, float64, vector_type), **EXACT)
def impact_measures(
    time: Floats, speed: Floats, lost: Floats, impulse: Floats, count: int, late: float, end: float, found: Floats
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
    found[COUNT] = count
    found[SPEED] = total / count if count > 0 else math.nan
    found[POWER] = energy / end if end > 0.0 else math.nan
    found[IMPULSE] = greatest
    found[LATE_RATE] = last / (end - late) if end > late else math.nan
    found[LATE_POWER] = spent / (end - late) if end > late else math.nan


@njit(void(system_type, gauges_type, desk_type), **EXACT_PART)
def take_impacts(p: System, g: Gauges, d: Desk) -> None:
    """Take over the impacts that the equations noted, and empty their room; call it after every call of the stepper."""
    if p.touches.shape[0] == 0:
        return
    seen = p.impact_count[0]
    for k in range(min(seen, p.impacts.shape[0])):
        to = d.noted[0]
        if to < d.hits.shape[1]:
            one = p.impacts[k]
            lost, impulse = meant(g.meetings[one.touch], g.rebounds, one.speed)
            d.hits[0, to], d.hits[1, to], d.hits[2, to], d.hits[3, to] = one.time, one.speed, lost, impulse
            d.noted[0] = to + 1
    p.impact_count[0] = 0
