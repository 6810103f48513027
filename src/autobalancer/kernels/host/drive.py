"""Speed, torque and unbalance at an instant, from the segment in force."""

from __future__ import annotations

from autobalancer.kernels.flags import INLINE, njit
from autobalancer.kernels.records.drive import HILL
from autobalancer.kernels.system import Drive


@njit(**INLINE)
def drive_value(time: float, drive: Drive) -> tuple[float, float]:
    """The drive's profile (speed or torque) and its rate of change."""
    segment = drive.segments[drive.now[0]]
    if segment.kind == HILL:
        begin, exponent = segment.begin, segment.exponent
        if time <= 0.0:
            return begin, 0.0
        ratio = (time / segment.half_time) ** exponent
        rise = ratio / (1.0 + ratio)
        return begin + (segment.end - begin) * rise, (segment.end - begin) * rise * exponent / (time * (1.0 + ratio))
    return segment.value + (time - segment.start) * segment.rate, segment.rate


@njit(**INLINE)
def unbalance_value(time: float, drive: Drive) -> tuple[float, float]:
    """The resultant unbalance (Ux, Uy) in the rotor, kg m."""
    segment = drive.segments[drive.now[0]]
    s = time - segment.start
    return segment.unbalance_x + s * segment.unbalance_rate_x, segment.unbalance_y + s * segment.unbalance_rate_y


@njit(**INLINE)
def table_torque(speed: float, drive: Drive) -> float:
    """Torque from the table over speed, held constant outside it; 0 without a table."""
    table = drive.table
    count = table.shape[0]
    if count == 0:
        return 0.0
    if speed <= table[0, 0]:
        return table[0, 1]
    for i in range(1, count):
        if speed <= table[i, 0]:
            part = (speed - table[i - 1, 0]) / (table[i, 0] - table[i - 1, 0])
            return table[i - 1, 1] + part * (table[i, 1] - table[i - 1, 1])
    return table[count - 1, 1]


@njit(**INLINE)
def motor_torque(drive_value: float, speed: float, drive: Drive) -> float:
    """Torque of the motor at a speed against its stator: profile, table, formula of Kloss, less what brakes it."""
    torque = drive_value + table_torque(speed, drive) - drive.damping * speed
    if drive.breakdown_torque != 0.0:
        slip, width = drive.synchronous_speed - speed, drive.breakdown_slip
        torque += 2.0 * drive.breakdown_torque * slip * width / (width * width + slip * slip)
    return torque


@njit(**INLINE)
def enter_segment(time: float, drive: Drive) -> bool:
    """Go on to the segment of this time, if that is a later one; returns whether it is."""
    later = False
    while drive.now[0] + 1 < drive.segments.shape[0] and drive.segments[drive.now[0] + 1].start <= time:
        drive.now[0] += 1
        later = True
    return later
