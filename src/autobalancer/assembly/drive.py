"""Drive and unbalance of a machine over time, as the segments of kernels/records/drive.py."""

from __future__ import annotations

import numpy as np

from autobalancer.assembly.profile import Piece, profile_pieces, schedule_times, unbalance_factor, unbalance_vector
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
    for number, (row, time) in enumerate(zip(rows, grid, strict=True)):
        piece = [p for p in pieces if p.start <= time][-1]
        row.start, row.kind = time, piece.kind
        numbers = piece.at(time)
        if piece.kind == HILL:
            row.end, row.half_time, row.exponent, row.begin = numbers
        else:
            row.value, row.rate = numbers[:2]
        after, change = unbalance_vector(machine, time), 0j
        for unbalance in machine.unbalances if number + 1 < len(grid) else ():
            factor, late = unbalance_factor(unbalance, time), unbalance_factor(unbalance, grid[number + 1], before=True)
            change += unbalance.vector * (late - factor) / (grid[number + 1] - time)
            row.changing |= int(late != factor)
        row.unbalance_x, row.unbalance_y = after.real, after.imag
        row.unbalance_rate_x, row.unbalance_rate_y = change.real, change.imag
    return rows
