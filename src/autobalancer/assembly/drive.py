"""Drive and unbalance of a machine over time, as the segments of kernels/records/drive.py."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import zip_longest
from typing import Any, NamedTuple

import numpy as np

from autobalancer.assembly.profile import Piece, profile_pieces, schedule_times, unbalance_factor
from autobalancer.assembly.torsion.links import link_rows, ripple_rows
from autobalancer.kernels.records.drive import HILL, LINEAR, PRESCRIBED, SEGMENT, TORQUE
from autobalancer.kernels.system import Drive, Rows
from autobalancer.machine import AsynchronousDrive, ConstantTorque, Machine, PrescribedSpeed, TargetTorque, TorqueTable


def drive_of(machine: Machine, first_state: int = 0) -> Drive:
    """What turns the rotor of a machine; the states of its links begin at ``first_state``."""
    drive = machine.drive
    prescribed = isinstance(drive, PrescribedSpeed)
    links, ripples = link_rows(drive, first_state), ripple_rows(drive)
    breakdown, synchronous, slip = 0.0, 0.0, 0.0
    if isinstance(drive, AsynchronousDrive):
        synchronous = float(drive.synchronous_speed)
        breakdown, slip = float(drive.rated_torque * drive.overload), float(drive.breakdown_slip) * synchronous
    table = np.zeros((0, 2))
    if isinstance(drive, TorqueTable):
        table = np.column_stack([[float(w) for w in drive.speed], [float(q) for q in drive.torque]])
    return Drive(
        kind=PRESCRIBED if prescribed and not len(links) else TORQUE,
        damping=0.0 if isinstance(drive, PrescribedSpeed) else float(drive.damping),
        table=np.ascontiguousarray(table, np.float64),
        segments=_segments(machine),
        now=np.zeros(1, np.int64),
        breakdown_torque=breakdown,
        synchronous_speed=synchronous,
        breakdown_slip=slip,
        motor=PRESCRIBED if prescribed else TORQUE,
        linked=int(len(links) + len(ripples) > 0),
        links=links,
        ripples=ripples,
    )


def steady(speed: float, unbalance: complex) -> Drive:
    """A constant prescribed speed, rad/s, and an unbalance in the rotor, kg m."""
    segments = SEGMENT.rows(1)
    segments.value, segments.unbalance_x, segments.unbalance_y = speed, unbalance.real, unbalance.imag
    return Drive(PRESCRIBED, 0.0, np.zeros((0, 2)), segments, np.zeros(1, np.int64), motor=PRESCRIBED)


def first_speed(machine: Machine, drive: Drive) -> float:
    """Speed of the rotor at the start, rad/s."""
    first = drive.segments[0]
    if drive.motor == PRESCRIBED:
        return float(first.value if first.kind == LINEAR else first.begin)
    return float(machine.start.speed)


def _pieces(machine: Machine) -> list[Piece]:
    drive = machine.drive
    if isinstance(drive, PrescribedSpeed):
        return profile_pieces(drive.profile)
    if isinstance(drive, ConstantTorque):
        return [Piece(0.0, LINEAR, (float(drive.torque), 0.0, 0.0, 0.0))]
    if isinstance(drive, TargetTorque):
        gain = float(drive.gain)
        scaled = []
        for piece in profile_pieces(drive.profile):
            a, b, c, d = piece.numbers
            linear = piece.kind == LINEAR
            numbers = gain * a, gain * b if linear else b, c, d if linear else gain * d
            scaled.append(Piece(piece.start, piece.kind, numbers))
        return scaled
    return [Piece(0.0, LINEAR, (0.0, 0.0, 0.0, 0.0))]


def _segments(machine: Machine) -> Rows:
    """The common grid of all times at which drive or unbalance take another course."""
    pieces = _pieces(machine)
    grid = sorted({*(piece.start for piece in pieces), *schedule_times(machine)})
    rows = SEGMENT.rows(len(grid))
    for row, time in zip(rows, grid, strict=True):
        piece = [p for p in pieces if p.start <= time][-1]
        row.start, row.kind = time, piece.kind
        numbers = piece.at(time)
        if piece.kind == HILL:
            row.end, row.half_time, row.exponent, row.begin = numbers
        else:
            row.value, row.rate = numbers[:2]
    courses = unbalance_courses(machine, grid)
    vectors = [unbalance.vector for unbalance in machine.unbalances]
    resultant = unbalances_over(courses, [one.real for one in vectors], [one.imag for one in vectors])
    for row, course, values in zip(rows, courses, resultant, strict=True):
        row.changing = int(any(late != factor for factor, late in course.factors))
        row.unbalance_x, row.unbalance_y, row.unbalance_rate_x, row.unbalance_rate_y = values
    return rows


class Course(NamedTuple):
    """How the point unbalances change from one time of a grid to the next."""

    factors: list[tuple[float, float]]  # of each unbalance, just after the one time and just before the next
    time: float  # between them, s; 1 after the last, where nothing changes


def unbalance_courses(machine: Machine, grid: Sequence[float]) -> list[Course]:
    """The courses of the unbalances of a machine over a grid of times, s."""
    found = []
    for time, late in zip_longest(grid, grid[1:]):
        factors = [unbalance_factor(one, time) for one in machine.unbalances]
        ends = factors if late is None else [unbalance_factor(one, late, before=True) for one in machine.unbalances]
        found.append(Course(list(zip(factors, ends, strict=True)), 1.0 if late is None else late - time))
    return found


def unbalances_over(courses: Sequence[Course], x: Sequence[Any], y: Sequence[Any]) -> list[list[Any]]:
    """The resultant of unbalances at the begin of each course, and its rate.

    Parameters
    ----------
    courses
        From :func:`unbalance_courses`.
    x, y
        Of each unbalance at factor one, kg m: a number, or an array over many machines that differ in it.

    Returns
    -------
    list
        Of each course x and y, kg m, and their rates, kg m/s.
    """
    found = []
    for factors, time in courses:
        after = [sum((part * begin for part, (begin, _) in zip(own, factors, strict=True)), 0.0) for own in (x, y)]
        rate = [
            sum((part * (end - begin) / time for part, (begin, end) in zip(own, factors, strict=True)), 0.0)
            for own in (x, y)
        ]
        found.append([*after, *rate])
    return found
